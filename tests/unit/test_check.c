// SPDX-License-Identifier: MIT
/* qn_mesh_check() on small shapes whose every count is known. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <qn/qn.h>
#include "core/context.h"

enum { MOST = 4096 };

/* A mesh under construction. */
typedef struct shape {
    int64_t vertex_count, quad_count, triangle_count;
    float positions[MOST][3];
    uint32_t quads[MOST][4], triangles[MOST][3];
} shape;

static uint32_t vertex(shape *s, double x, double y, double z) {
    s->positions[s->vertex_count][0] = (float)x;
    s->positions[s->vertex_count][1] = (float)y;
    s->positions[s->vertex_count][2] = (float)z;
    return (uint32_t)s->vertex_count++;
}

static void quad(shape *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const uint32_t q[4] = {a, b, c, d};
    memcpy(s->quads[s->quad_count++], q, sizeof q);
}

static void triangle(shape *s, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t t[3] = {a, b, c};
    memcpy(s->triangles[s->triangle_count++], t, sizeof t);
}

static shape *new_shape(void) {
    return calloc(1, sizeof(shape));
}

/* Corner numbers of a cube: bit 0 is x, bit 1 is y, bit 2 is z. */
static const uint32_t cube_quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

static void add_cube_faces(shape *s, const uint32_t corner[8]) {
    for (int f = 0; f < 6; ++f) {
        const uint32_t *q = cube_quads[f];
        quad(s, corner[q[0]], corner[q[1]], corner[q[2]], corner[q[3]]);
    }
}

static void add_cube(shape *s, double x, double y, double z, double side) {
    uint32_t corner[8];
    for (int i = 0; i < 8; ++i)
        corner[i] = vertex(s, x + side * (i & 1), y + side * ((i >> 1) & 1), z + side * (i >> 2));
    add_cube_faces(s, corner);
}

/* A tetrahedron of the corner at (x, y, z) and the three axes; its volume is side^3 / 6. */
static void add_tetrahedron(shape *s, double x, double y, double z, double side) {
    uint32_t o = vertex(s, x, y, z), a = vertex(s, x + side, y, z);
    uint32_t b = vertex(s, x, y + side, z), c = vertex(s, x, y, z + side);
    triangle(s, o, b, a);
    triangle(s, o, a, c);
    triangle(s, o, c, b);
    triangle(s, a, b, c);
}

/* Surface of the unit cubes (x, y, z) for which full() is true, vertices joined on the lattice. */
static void add_voxels(shape *s, int n, bool (*full)(int x, int y, int z)) {
    static uint32_t names[16][16][16];
    memset(names, 0xff, sizeof names);
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x)
                for (int f = 0; f < 6 && full(x, y, z); ++f) {
                    int step = f % 2 ? 1 : -1, axis = f / 2;
                    if (full(x + (axis == 0 ? step : 0), y + (axis == 1 ? step : 0),
                             z + (axis == 2 ? step : 0)))
                        continue;
                    uint32_t q[4];
                    for (int k = 0; k < 4; ++k) {
                        uint32_t c = cube_quads[f][k];
                        uint32_t *name = &names[z + (c >> 2)][y + ((c >> 1) & 1)][x + (c & 1)];
                        if (*name == UINT32_MAX)
                            *name = vertex(s, x + (int)(c & 1), y + (int)((c >> 1) & 1),
                                           z + (int)(c >> 2));
                        q[k] = *name;
                    }
                    quad(s, q[0], q[1], q[2], q[3]);
                }
}

static qn_mesh_report check_with_threads(const shape *s, int32_t threads) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = threads;
    qn_context *context;
    qn_mesh *mesh;
    qn_mesh_report report;
    qn_error error = {QN_OK, ""};
    const qn_mesh_view view = {s->vertex_count,
                               s->quad_count,
                               s->triangle_count,
                               s->positions[0],
                               NULL,
                               s->quads[0],
                               s->triangles[0],
                               "",
                               "",
                               NULL,
                               0,
                               NULL,
                               NULL};
    assert_int_equal(qn_context_create(&options, &context, &error), QN_OK);
    assert_int_equal(qn_mesh_create(context, &view, &mesh, &error), QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, &error), QN_OK);
    qn_mesh_destroy(mesh);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_destroy(context);
    return report;
}

/* Check a shape and free it. The report must not depend on the number of threads. */
static qn_mesh_report check(shape *s) {
    qn_mesh_report one = check_with_threads(s, 1), three = check_with_threads(s, 3);
    assert_memory_equal(&one, &three, sizeof one);
    free(s);
    return one;
}

static void assert_near(double a, double b) {
    assert_true(fabs(a - b) <= 1e-6 * fmax(1, fabs(b)));
}

static void assert_clean(const qn_mesh_report *r) {
    assert_true(r->closed && r->manifold && r->oriented);
    assert_int_equal(r->boundary_edges, 0);
    assert_int_equal(r->nonmanifold_edges, 0);
    assert_int_equal(r->nonmanifold_vertices, 0);
    assert_int_equal(r->orientation_conflicts, 0);
    assert_int_equal(r->degenerate_faces, 0);
    assert_int_equal(r->duplicate_faces, 0);
    assert_int_equal(r->duplicate_positions, 0);
    assert_int_equal(r->nonfinite_vertices, 0);
    assert_int_equal(r->unused_vertices, 0);
    assert_int_equal(r->self_intersections, 0);
    assert_int_equal(r->components, r->closed_components);
}

static void an_empty_mesh_is_clean(void **state) {
    (void)state;
    qn_mesh_report r = check(new_shape());
    assert_clean(&r);
    assert_int_equal(r.components, 0);
    assert_int_equal(r.euler_characteristic, 0);
    assert_true(r.area == 0 && r.volume == 0 && r.irregular_vertices == 0);
    assert_true(r.bounds[0][0] == 0 && r.bounds[1][2] == 0);
}

static void a_tetrahedron_is_a_sphere(void **state) {
    (void)state;
    shape *s = new_shape();
    add_tetrahedron(s, 100, 200, -300, 2);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.edge_count, 6);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.euler_characteristic, 2);
    assert_int_equal(r.genus_sum, 0);
    assert_near(r.volume, 8.0 / 6);
    assert_near(r.area, 6 + 2 * sqrt(3.0));
    assert_near(r.bounds[0][2], -300);
    assert_near(r.bounds[1][1], 202);
    assert_near(r.smallest_angle, 45);
    /* Three right triangles of legs 2: 4 sqrt(3) 2 / 16; one equilateral: 1. */
    assert_near(r.triangle_quality_min, sqrt(3.0) / 2);
    assert_near(r.triangle_quality_mean, (3 * sqrt(3.0) / 2 + 1) / 4);
    assert_near(r.irregular_vertices, 1);
    assert_true(r.quad_quality_mean == 0);
}

static void a_cube_is_a_sphere_of_quads(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, -1, -1, -1, 2);
    vertex(s, 9, 9, 9);
    qn_mesh_report r = check(s);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.edge_count, 12);
    assert_int_equal(r.euler_characteristic, 2);
    assert_true(r.closed && r.manifold && r.oriented);
    assert_int_equal(r.self_intersections, 0);
    assert_near(r.volume, 8);
    assert_near(r.area, 24);
    assert_near(r.quad_quality_mean, 1);
    assert_near(r.quad_quality_min, 1);
    assert_near(r.triangle_quality_mean, sqrt(3.0) / 2);
    assert_near(r.smallest_angle, 45);
    assert_near(r.irregular_vertices, 1);
    assert_near(r.bounds[1][0], 1);
}

static void an_inward_cube_has_negative_volume(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 50, 0, 0, 1);
    for (int f = 0; f < 6; ++f) {
        uint32_t swapped = s->quads[f][1];
        s->quads[f][1] = s->quads[f][3];
        s->quads[f][3] = swapped;
    }
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_near(r.volume, -1);
}

static void add_torus(shape *s, int around, int tube) {
    uint32_t first = (uint32_t)s->vertex_count;
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < tube; ++j) {
            double u = 2 * acos(-1.0) * i / around, v = 2 * acos(-1.0) * j / tube;
            vertex(s, (3 + cos(v)) * cos(u), (3 + cos(v)) * sin(u), sin(v));
        }
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < tube; ++j) {
            int k = (i + 1) % around, l = (j + 1) % tube;
            quad(s, first + i * tube + j, first + k * tube + j, first + k * tube + l,
                 first + i * tube + l);
        }
}

static void a_torus_has_genus_one_and_is_regular(void **state) {
    (void)state;
    shape *s = new_shape();
    add_torus(s, 24, 12);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.euler_characteristic, 0);
    assert_int_equal(r.genus_sum, 1);
    assert_int_equal(r.largest_genus, 1);
    assert_int_equal(r.edge_count, 2 * 24 * 12);
    assert_true(r.irregular_vertices == 0);
    assert_true(r.volume > 0);
}

static bool plate_with_two_holes(int x, int y, int z) {
    bool hole = y == 1 && (x == 1 || x == 3);
    return x >= 0 && x < 5 && y >= 0 && y < 3 && z == 0 && !hole;
}

static void genus_is_summed_over_components(void **state) {
    (void)state;
    shape *s = new_shape();
    add_voxels(s, 5, plate_with_two_holes);
    for (int i = 0; i < s->vertex_count; ++i)
        s->positions[i][2] += 10;
    add_torus(s, 9, 5);
    add_tetrahedron(s, 30, 0, 0, 1);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.components, 3);
    assert_int_equal(r.euler_characteristic, -2 + 0 + 2);
    assert_int_equal(r.genus_sum, 3);
    assert_int_equal(r.largest_genus, 2);
}

static bool two_cubes_at_an_edge(int x, int y, int z) {
    return z == 0 && ((x == 0 && y == 0) || (x == 1 && y == 1));
}

static void an_edge_of_four_faces_is_not_manifold(void **state) {
    (void)state;
    shape *s = new_shape();
    add_voxels(s, 2, two_cubes_at_an_edge);
    qn_mesh_report r = check(s);
    assert_int_equal(r.vertex_count, 14);
    assert_int_equal(r.nonmanifold_edges, 1);
    assert_int_equal(r.nonmanifold_vertices, 0); /* the fans at its ends hang together by it */
    assert_int_equal(r.boundary_edges, 0);
    assert_int_equal(r.edge_count, 23);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.closed_components, 1);
    assert_true(r.closed && !r.manifold && r.oriented);
    assert_int_equal(r.genus_sum, 0);
    assert_int_equal(r.self_intersections, 0);
}

static bool two_cubes_at_a_corner(int x, int y, int z) {
    return (x == 0 && y == 0 && z == 0) || (x == 1 && y == 1 && z == 1);
}

static void a_shared_tip_is_not_manifold(void **state) {
    (void)state;
    shape *s = new_shape();
    add_voxels(s, 2, two_cubes_at_a_corner);
    qn_mesh_report r = check(s);
    assert_int_equal(r.vertex_count, 15);
    assert_int_equal(r.nonmanifold_edges, 0);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_int_equal(r.euler_characteristic, 3);
    assert_true(r.closed && !r.manifold && r.oriented);
    assert_int_equal(r.self_intersections, 0);
}

static void a_pinched_component_has_no_genus(void **state) {
    (void)state;
    shape *s = new_shape();
    add_torus(s, 24, 12);
    for (int f = 0; f < s->quad_count; ++f)
        for (int k = 0; k < 4; ++k)
            if (s->quads[f][k] == 150)
                s->quads[f][k] = 0;
    qn_mesh_report r = check(s);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.nonmanifold_edges, 0);
    assert_int_equal(r.euler_characteristic, -1);
    assert_true(r.closed && r.oriented && !r.manifold);
    assert_int_equal(r.genus_sum, 0);
}

static void fans_of_many_corners_are_found(void **state) {
    (void)state;
    enum { ROUND = 300 };
    shape *s = new_shape();
    uint32_t tip = vertex(s, 0, 0, 0);
    for (int side = -1; side <= 1; side += 2) {
        uint32_t first = (uint32_t)s->vertex_count;
        for (int i = 0; i < ROUND; ++i) {
            double angle = 2 * acos(-1.0) * i / ROUND;
            vertex(s, cos(angle), sin(angle), side);
        }
        for (uint32_t i = 0; i < ROUND; ++i) {
            uint32_t a = first + i, b = first + (i + 1) % ROUND;
            triangle(s, tip, side > 0 ? a : b, side > 0 ? b : a);
        }
    }
    triangle(s, tip, 2, 1); /* one more face on the first cone, turned: a duplicate */
    qn_mesh_report r = check(s);
    assert_int_equal(r.nonmanifold_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_int_equal(r.closed_components, 0);
    assert_int_equal(r.duplicate_faces, 1);
    assert_int_equal(r.nonmanifold_edges, 2);
    assert_int_equal(r.boundary_edges, 2 * ROUND - 1);
    assert_int_equal(r.edge_count, 4 * ROUND);
    assert_int_equal(r.euler_characteristic, 1 + 2 * ROUND - 4 * ROUND + 2 * ROUND + 1);
    assert_int_equal(r.self_intersections, 1);
}

static void a_moebius_band_cannot_be_oriented(void **state) {
    (void)state;
    enum { ROUND = 16 };
    shape *s = new_shape();
    for (int i = 0; i < ROUND; ++i)
        for (int k = -1; k <= 1; k += 2) {
            double u = 2 * acos(-1.0) * i / ROUND;
            vertex(s, (2 + 0.5 * k * cos(u / 2)) * cos(u), (2 + 0.5 * k * cos(u / 2)) * sin(u),
                   0.5 * k * sin(u / 2));
        }
    for (uint32_t i = 0; i < ROUND; ++i) {
        uint32_t a = 2 * i, b = 2 * i + 1, c = 2 * i + 3, d = 2 * i + 2;
        if (i == ROUND - 1) {
            c = 0;
            d = 1;
        }
        quad(s, a, b, c, d);
    }
    qn_mesh_report r = check(s);
    assert_int_equal(r.orientation_conflicts, 1);
    assert_false(r.oriented);
    assert_true(r.manifold);
    assert_int_equal(r.boundary_edges, 2 * ROUND);
    assert_int_equal(r.euler_characteristic, 0);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.self_intersections, 0);
}

static void a_turned_face_makes_conflicts(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    uint32_t swapped = s->quads[2][0];
    s->quads[2][0] = s->quads[2][2];
    s->quads[2][2] = swapped;
    qn_mesh_report r = check(s);
    assert_int_equal(r.orientation_conflicts, 4);
    assert_true(r.closed && r.manifold && !r.oriented);
    assert_int_equal(r.genus_sum, 0);
    assert_int_equal(r.components, 1);
}

static void an_open_box_has_a_boundary(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    s->quad_count -= 1;
    qn_mesh_report r = check(s);
    assert_int_equal(r.boundary_edges, 4);
    assert_int_equal(r.components, 1);
    assert_int_equal(r.closed_components, 0);
    assert_int_equal(r.euler_characteristic, 1);
    assert_true(!r.closed && r.manifold && r.oriented);
    assert_near(r.irregular_vertices, 1); /* the four inner ones, of valence 3 */
}

static void duplicates_are_counted_once_each(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    quad(s, s->quads[0][2], s->quads[0][1], s->quads[0][0], s->quads[0][3]);
    quad(s, s->quads[0][0], s->quads[0][2], s->quads[0][1], s->quads[0][3]);
    vertex(s, 5, 5, 0.0);
    vertex(s, 5, 5, -0.0);
    vertex(s, 5, 5, 0.0);
    uint32_t far = vertex(s, 6, 7, 8);
    triangle(s, 8, far, 0);
    triangle(s, 9, far, 0);
    triangle(s, 10, far, 0);
    triangle(s, 10, 0, far);
    qn_mesh_report r = check(s);
    assert_int_equal(r.duplicate_faces, 3);
    assert_int_equal(r.duplicate_positions, 2);
}

static void degenerate_faces_are_seen_exactly(void **state) {
    (void)state;
    shape *s = new_shape();
    uint32_t a = vertex(s, 0, 0, 0), b = vertex(s, 0.1f, 0.1f, 0.1f),
             c = vertex(s, 0.2f, 0.2f, 0.2f);
    uint32_t near_line = vertex(s, 0.3f, 0.3f, nextafterf(0.3f, 1));
    uint32_t d = vertex(s, 1, 0, 0), e = vertex(s, 0, 1, 0);
    triangle(s, a, b, c);         /* collinear */
    triangle(s, a, b, near_line); /* by one bit not collinear */
    triangle(s, a, a, b);         /* an index twice: not a polygon */
    quad(s, a, d, e, e);          /* an index twice: the triangle a, d, e */
    quad(s, a, d, a, e);          /* not a polygon */
    vertex(s, 4, 4, 4);
    quad(s, 6, 6, 6, 6);
    qn_mesh_report r = check(s);
    assert_int_equal(r.degenerate_faces, 5);
    assert_int_equal(r.edge_count, 5 + 3);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_int_equal(r.euler_characteristic, 6 - 8 + 3);
    assert_int_equal(r.quad_count, 3);
    assert_int_equal(r.self_intersections, 0);
    assert_true(r.triangle_quality_min == 0 && r.smallest_angle == 0);
}

static void nonfinite_vertices_take_their_faces_out_of_the_geometry(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    add_cube(s, 5, 0, 0, 1);
    s->positions[8][1] = NAN;
    s->positions[9][0] = INFINITY;
    qn_mesh_report r = check(s);
    assert_int_equal(r.nonfinite_vertices, 2);
    assert_int_equal(r.components, 2);
    assert_true(r.closed && r.manifold);
    assert_near(r.area, 6 + 2); /* of the second cube two faces are left */
    assert_near(r.bounds[1][0], 6);
    assert_int_equal(r.self_intersections, 0);
}

static void nested_and_apart_do_not_intersect(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 4);
    add_cube(s, 1, 1, 1, 1);
    add_tetrahedron(s, 2.5, 2.5, 2.5, 0.25);
    add_cube(s, 4.0000005, 0, 0, 1);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.components, 4);
    assert_near(r.volume, 64 + 1 + 1 + 0.015625 / 6);
}

static void crossing_triangles_are_one_pair(void **state) {
    (void)state;
    shape *s = new_shape();
    triangle(s, vertex(s, -1, -1, 0), vertex(s, 1, -1, 0), vertex(s, 0, 2, 0));
    triangle(s, vertex(s, 0, 0, -1), vertex(s, 0, 0.5, 1), vertex(s, 0, -0.5, 1));
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 1);
}

static void touching_strangers_are_pairs(void **state) {
    (void)state;
    shape *s = new_shape();
    triangle(s, vertex(s, -1, -1, 0), vertex(s, 1, -1, 0), vertex(s, 0, 2, 0));
    triangle(s, vertex(s, 0, 0, 0), vertex(s, 0, 0.5, 1), vertex(s, 0, -0.5, 1));
    triangle(s, vertex(s, 10, 0, 0), vertex(s, 11, 0, 0), vertex(s, 10, 1, 0));
    triangle(s, vertex(s, 10, 0, 0), vertex(s, 11, 0, 0), vertex(s, 10, -1, 0)); /* equal edges */
    triangle(s, vertex(s, 20, 0, 0), vertex(s, 21, 0, 0), vertex(s, 20, 1, 0));
    triangle(s, vertex(s, 20, 0, 0), vertex(s, 19, 0, 0), vertex(s, 20, -1, 5)); /* equal corners */
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 3);
    assert_int_equal(r.duplicate_positions, 3);
}

static void neighbours_meet_only_beyond_what_they_share(void **state) {
    (void)state;
    shape *s = new_shape();
    uint32_t o = vertex(s, 0, 0, 0), x = vertex(s, 4, 0, 0), y = vertex(s, 0, 4, 0);
    triangle(s, o, x, y);
    triangle(s, o, vertex(s, 1, 1, 1), vertex(s, 1, 1, -1)); /* a pair: through the first */
    uint32_t p = vertex(s, 100, 0, 0), q = vertex(s, 101, 0, 0), r0 = vertex(s, 100, 1, 0);
    triangle(s, p, q, r0);
    triangle(s, q, p, vertex(s, 100.25, 0.25, 0)); /* a pair: folded flat onto it */
    triangle(s, p, r0, vertex(s, 99, 0.5f, 0));    /* no pair: flat, beside both */
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 2);
}

static void solids_pushed_into_each_other_intersect(void **state) {
    (void)state;
    shape *s = new_shape();
    add_tetrahedron(s, 0, 0, 0, 1);
    add_tetrahedron(s, -10, -10, 0.25,
                    100); /* its base cuts the three faces at the first one's tip */
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 3);
    assert_true(r.closed && r.manifold);
}

static void intersections_can_be_left_out(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    qn_context *context;
    qn_mesh *mesh;
    qn_mesh_report report;
    qn_error error;
    qn_mesh_check_options options;
    qn_mesh_check_options_init(&options);
    options.skip_intersections = true;
    const qn_mesh_view view = {8,    6, 0,   s->positions[0], NULL, s->quads[0], NULL, "", "",
                               NULL, 0, NULL, NULL};
    assert_int_equal(qn_context_create(NULL, &context, NULL), QN_OK);
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, &options, &report, &error), QN_OK);
    assert_int_equal(report.self_intersections, -1);
    assert_int_equal(report.edge_count, 12);
    options.struct_size = 0;
    assert_int_equal(qn_mesh_check(context, mesh, &options, &report, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_mesh_destroy(mesh);
    qn_context_destroy(context);
    free(s);
}

/* ---- failure -----------------------------------------------------------------------------------
 */

typedef struct limits {
    int allocations_left, steps_left;
} limits;

static void *limited_alloc(void *user, size_t size, size_t alignment) {
    limits *l = user;
    return l->allocations_left-- > 0
               ? aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
               : NULL;
}

static void limited_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

static int limited_progress(void *user, const char *stage, double fraction) {
    assert_string_equal(stage, "check");
    assert_true(fraction >= 0 && fraction <= 1);
    return ((limits *)user)->steps_left-- <= 0;
}

static qn_status check_within(limits *l, const qn_mesh_view *view) {
    int allocations = l->allocations_left;
    l->allocations_left = 1000;
    qn_context_options options;
    qn_context_options_init(&options);
    options.allocator = (qn_allocator){l, limited_alloc, limited_free};
    options.progress = limited_progress;
    options.user = l;
    qn_context *context;
    qn_mesh *mesh;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    assert_int_equal(qn_mesh_create(context, view, &mesh, NULL), QN_OK);
    int64_t held = qn_context_memory(context).current_bytes;
    l->allocations_left = allocations;
    qn_mesh_report report;
    qn_error error = {QN_OK, ""};
    qn_status status = qn_mesh_check(context, mesh, NULL, &report, &error);
    assert_int_equal(error.status, status);
    if (status != QN_OK)
        assert_int_equal(report.vertex_count, 0);
    assert_int_equal(qn_context_memory(context).current_bytes, held);
    qn_mesh_destroy(mesh);
    qn_context_destroy(context);
    return status;
}

static void every_failure_is_reported_and_leaks_nothing(void **state) {
    (void)state;
    shape *s = new_shape();
    add_torus(s, 24, 12);
    const qn_mesh_view view = {s->vertex_count,
                               s->quad_count,
                               0,
                               s->positions[0],
                               NULL,
                               s->quads[0],
                               NULL,
                               "",
                               "",
                               NULL,
                               0,
                               NULL,
                               NULL};
    int failures = 0, cancels = 0;
    for (qn_status status = QN_ERROR_INTERNAL; status != QN_OK; ++failures) {
        limits l = {failures, 1000};
        status = check_within(&l, &view);
        assert_true(status == QN_OK || status == QN_ERROR_OUT_OF_MEMORY);
    }
    for (qn_status status = QN_ERROR_INTERNAL; status != QN_OK; ++cancels) {
        limits l = {1000, cancels};
        status = check_within(&l, &view);
        assert_true(status == QN_OK || status == QN_ERROR_CANCELLED);
    }
    assert_true(failures > 12 && cancels > 8);
    free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_mesh_is_clean),
        cmocka_unit_test(a_tetrahedron_is_a_sphere),
        cmocka_unit_test(a_cube_is_a_sphere_of_quads),
        cmocka_unit_test(an_inward_cube_has_negative_volume),
        cmocka_unit_test(a_torus_has_genus_one_and_is_regular),
        cmocka_unit_test(genus_is_summed_over_components),
        cmocka_unit_test(an_edge_of_four_faces_is_not_manifold),
        cmocka_unit_test(a_shared_tip_is_not_manifold),
        cmocka_unit_test(a_pinched_component_has_no_genus),
        cmocka_unit_test(fans_of_many_corners_are_found),
        cmocka_unit_test(a_moebius_band_cannot_be_oriented),
        cmocka_unit_test(a_turned_face_makes_conflicts),
        cmocka_unit_test(an_open_box_has_a_boundary),
        cmocka_unit_test(duplicates_are_counted_once_each),
        cmocka_unit_test(degenerate_faces_are_seen_exactly),
        cmocka_unit_test(nonfinite_vertices_take_their_faces_out_of_the_geometry),
        cmocka_unit_test(nested_and_apart_do_not_intersect),
        cmocka_unit_test(crossing_triangles_are_one_pair),
        cmocka_unit_test(touching_strangers_are_pairs),
        cmocka_unit_test(neighbours_meet_only_beyond_what_they_share),
        cmocka_unit_test(solids_pushed_into_each_other_intersect),
        cmocka_unit_test(intersections_can_be_left_out),
        cmocka_unit_test(every_failure_is_reported_and_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
