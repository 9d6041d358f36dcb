// SPDX-License-Identifier: MIT
/* Sharpness: every true edge longer than two finest cells comes out as an unbroken chain of tagged
 * edges whose vertices lie on it within 1e-4 of a finest cell, corners likewise. On solids whose
 * edges are known, turned and moved at random. */
#include "lib/true_edges.h"

#include <math.h>

enum { MOST_FACES = 16 };

/* A solid in a body frame and the faces it is made of. */
typedef struct model {
    qn_context *context;
    test_random *random;
    test_frame frame;
    test_face faces[MOST_FACES];
    int face_count;
} model;

static void to_world(const model *m, const double body[3], bool point, double world[3]) {
    for (int k = 0; k < 3; ++k) {
        world[k] = point ? m->frame.origin[k] : 0;
        for (int i = 0; i < 3; ++i)
            world[k] += m->frame.turn[i][k] * body[i];
    }
}

static test_face *add_face(model *m, test_face_kind kind, double x, double y, double z) {
    const double body[3] = {x, y, z};
    test_face *face = &m->faces[m->face_count++];
    memset(face, 0, sizeof *face);
    face->kind = kind;
    to_world(m, body, true, face->centre);
    return face;
}

static qn_solid *plane(model *m, double nx, double ny, double nz, double offset) {
    const double length = sqrt(nx * nx + ny * ny + nz * nz),
                 body[3] = {nx / length, ny / length, nz / length};
    test_face *face =
        add_face(m, TEST_FACE_PLANE, body[0] * offset, body[1] * offset, body[2] * offset);
    to_world(m, body, false, face->axis);
    double height = 0;
    for (int k = 0; k < 3; ++k)
        height += face->axis[k] * face->centre[k];
    return test_plane(m->context, face->axis, height, m->face_count);
}

static qn_solid *sphere(model *m, double x, double y, double z, double radius) {
    test_face *face = add_face(m, TEST_FACE_SPHERE, x, y, z);
    face->radius = radius;
    return test_sphere(m->context, face->centre, radius, m->face_count);
}

/* Along the body's z axis. */
static qn_solid *cylinder(model *m, double x, double y, double radius) {
    static const double up[3] = {0, 0, 1};
    test_face *face = add_face(m, TEST_FACE_CYLINDER, x, y, 0);
    face->radius = radius;
    to_world(m, up, false, face->axis);
    test_frame frame = m->frame;
    memcpy(frame.origin, face->centre, sizeof frame.origin);
    return test_cylinder(m->context, &frame, radius, m->face_count);
}

static qn_solid *slab(model *m, int axis, double low, double high) {
    return test_intersection(plane(m, axis == 0, axis == 1, axis == 2, high),
                             plane(m, -(axis == 0), -(axis == 1), -(axis == 2), -low));
}

static qn_solid *cube(model *m, double half) {
    return test_intersection(test_intersection(slab(m, 0, -half, half), slab(m, 1, -half, half)),
                             slab(m, 2, -half, half));
}

static double wobble(model *m, double middle, double spread) {
    return middle + spread * (2 * test_random_unit(m->random) - 1);
}

static qn_solid *make_cube(model *m, int64_t number) {
    (void)number;
    return cube(m, 0.6);
}

static qn_solid *make_bored_cube(model *m, int64_t number) {
    (void)number;
    return test_difference(cube(m, 0.6),
                           cylinder(m, wobble(m, 0, 0.2), wobble(m, 0, 0.2), wobble(m, 0.25, 0.1)));
}

/* Two planes that meet at the given angle, 1 to 179 degrees, in a box. */
static qn_solid *make_wedge(model *m, int64_t number) {
    const double half = (1 + (double)(number % 179)) * 3.14159265358979 / 360;
    qn_solid *planes = test_intersection(plane(m, -sin(half), cos(half), 0, 0.6 * sin(half)),
                                         plane(m, -sin(half), -cos(half), 0, 0.6 * sin(half)));
    qn_solid *box = test_intersection(slab(m, 1, -0.55, 0.55), slab(m, 2, -0.6, 0.6));
    return test_intersection(planes, test_intersection(box, plane(m, 1, 0, 0, 0.5)));
}

/* [CMS05] figure 8: a cube and a cylinder, less a sphere, here across the edge where they meet. */
static qn_solid *make_figure_8(model *m, int64_t number) {
    const double x = wobble(m, -0.25, 0.03), y = wobble(m, 0, 0.1), radius = wobble(m, 0.2, 0.02);
    (void)number;
    qn_solid *column = test_intersection(cylinder(m, x, y, radius), slab(m, 2, -0.9, 0.9));
    return test_difference(test_union(cube(m, 0.6), column),
                           sphere(m, x + wobble(m, 0.45, 0.03), y, wobble(m, 0.75, 0.03), 0.35));
}

/* The sphere at a corner of the cube. */
static qn_solid *make_bitten_corner(model *m, int64_t number) {
    (void)number;
    qn_solid *column =
        test_intersection(cylinder(m, -0.2, -0.2, wobble(m, 0.25, 0.1)), slab(m, 2, -0.9, 0.9));
    return test_difference(test_union(cube(m, 0.6), column),
                           sphere(m, 0.6, wobble(m, 0.6, 0.1), 0.6, wobble(m, 0.5, 0.1)));
}

typedef qn_solid *make_model(model *m, int64_t number);

static void check_clean(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    assert_int_equal(report.degenerate_faces, 0);
}

static void measure_one(uint64_t seed, int64_t number, make_model *make, double crease, int depth,
                        test_sharpness *sum) {
    test_random random = {seed};
    qn_context *context = test_context(1);
    model m = {.context = context, .random = &random, .frame = test_random_frame(&random, 0.1)};
    qn_solid *solid = make(&m, number);
    test_solid_set_box(solid, -1.3, 1.3);
    static test_edges edges;
    test_find_edges(solid, m.face_count, m.faces, 1.5, &edges);
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    options.base = number & 1 ? 2 : 8;
    options.crease = crease;
    qn_solid_surface_report report;
    qn_mesh *mesh;
    qn_error error;
    if (qn_solid_surface(context, solid, &options, &mesh, &report, &error) != QN_OK)
        fail_msg("%s", error.message);
    check_clean(context, mesh);
    test_measure_sharpness(&edges, mesh, report.finest_cell, 1e-4 * report.finest_cell, sum);
    qn_mesh_destroy(mesh);
    qn_solid_destroy(solid);
    test_context_end(context);
}

static void measure_all(const char *name, make_model *make, double crease, int lowest,
                        int64_t count) {
    test_sharpness total = {0};
    int64_t whole = 0;
    const uint64_t seed = test_seed();
    for (int64_t n = 0; n < count; ++n) {
        test_sharpness one = {0};
        measure_one(seed + 1000003 * (uint64_t)n, n, make, crease, lowest + (int)(n % (8 - lowest)),
                    &one);
        whole += one.whole == one.edges && one.stray == 0 && one.corners_found == one.corners;
        if (one.whole != one.edges || one.stray)
            print_message("%s %lld: %lld of %lld edges, %lld of %lld corners, %.2f cells missing, "
                          "%lld stray, %.3g cells off; at %.4f %.4f %.4f\n",
                          name, (long long)n, (long long)one.whole, (long long)one.edges,
                          (long long)one.corners_found, (long long)one.corners, one.missing,
                          (long long)one.stray, one.farthest, one.first_gap[0], one.first_gap[1],
                          one.first_gap[2]);
        total.edges += one.edges;
        total.whole += one.whole;
        total.corners += one.corners;
        total.corners_found += one.corners_found;
        total.stray += one.stray;
        total.missing = fmax(total.missing, one.missing);
        total.farthest = fmax(total.farthest, one.farthest);
    }
    print_message("%s: %lld of %lld solids whole; %lld of %lld edges, %lld of %lld corners; at "
                  "most %.2f cells missing; %lld stray ends, at most %.3g cells off\n",
                  name, (long long)whole, (long long)count, (long long)total.whole,
                  (long long)total.edges, (long long)total.corners_found, (long long)total.corners,
                  total.missing, (long long)total.stray, total.farthest);
    assert_int_equal(whole, count);
}

static void cubes(void **state) {
    (void)state;
    measure_all("cube", make_cube, 0, 5, test_count(12, 200));
}

static void bored_cubes(void **state) {
    (void)state;
    measure_all("bored cube", make_bored_cube, 0, 5, test_count(12, 200));
}

static void wedges(void **state) {
    (void)state;
    measure_all("wedge", make_wedge, 0.5, 5, test_count(179, 179));
}

static void figures_8(void **state) {
    (void)state;
    measure_all("figure 8", make_figure_8, 0, 6, test_count(12, 200));
}

static void bitten_corners(void **state) {
    (void)state;
    measure_all("bitten corner", make_bitten_corner, 0, 6, test_count(20, 200));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cubes),     cmocka_unit_test(bored_cubes),    cmocka_unit_test(wedges),
        cmocka_unit_test(figures_8), cmocka_unit_test(bitten_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
