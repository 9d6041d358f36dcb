// SPDX-License-Identifier: MIT
/* [CMS05] figure 8d: a polygon animal, a CSG solid and a level set in one tree: clean, every owner
 * on the surface, and long creases that lie on two of them where they meet.
 * With a name the mesh is written there: test_solid_mixed mixed.ply */
#include "lib/polygon_models.h"

#include <math.h>

enum { LEAVES = 5, LEVEL_SET = 3 };

static const char *output;

/* Body, head, muzzle, ears and legs, each a closed ball or box of triangles. */
static qn_solid *make_animal(qn_context *context) {
    static const double balls[][4] = {
        {0, 0, 0, 1},        {0.7, 0, 0.15, 0.85}, {-0.7, 0, 0, 0.9},    {1.7, 0, 0.8, 0.55},
        {2.2, 0, 0.65, 0.3}, {1.6, 0.4, 1.3, 0.2}, {1.6, -0.4, 1.3, 0.2}};
    static const double legs[4][2] = {{0.9, 0.4}, {0.9, -0.4}, {-0.9, 0.4}, {-0.9, -0.4}};
    test_model model = {0};
    for (size_t n = 0; n < sizeof balls / sizeof *balls; ++n)
        test_model_ball(&model, balls[n], balls[n][3], 4);
    for (int n = 0; n < 4; ++n) {
        const double low[3] = {legs[n][0] - 0.17, legs[n][1] - 0.17, -1.73},
                     high[3] = {legs[n][0] + 0.17, legs[n][1] + 0.17, -0.31};
        test_model_box(&model, low, high, NULL);
    }
    qn_mesh *mesh = test_model_mesh(context, &model);
    test_model_free(&model);
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    options.owner = 1;
    options.one_owner = true;
    qn_solid *solid;
    qn_solid_mesh_report report;
    assert_int_equal(qn_solid_from_mesh(context, mesh, &options, &solid, &report, NULL), QN_OK);
    assert_true(report.closed);
    qn_mesh_destroy(mesh);
    return solid;
}

/* A saddle block with a round hole along y. */
static qn_solid *make_block(qn_context *context) {
    static const double low[3] = {-1.21, -0.77, 0.4}, high[3] = {0.33, 0.77, 1.52};
    static const double matrix[3][4] = {{1, 0, 0, -0.44}, {0, 0, 1, -1}, {0, -1, 0, 1.13}};
    qn_solid *box, *drill, *turned, *block, *solid;
    assert_int_equal(qn_solid_box(context, low, high, &box, NULL), QN_OK);
    assert_int_equal(qn_solid_cylinder(context, 2, 0.27, 0.27, 0, &drill, NULL), QN_OK);
    assert_int_equal(qn_solid_transform(context, drill, matrix, &turned, NULL), QN_OK);
    qn_solid *const parts[] = {box, turned};
    assert_int_equal(qn_solid_difference(context, 2, parts, &block, NULL), QN_OK);
    assert_int_equal(qn_solid_with_owner(context, block, 2, &solid, NULL), QN_OK);
    qn_solid_destroy(box);
    qn_solid_destroy(drill);
    qn_solid_destroy(turned);
    qn_solid_destroy(block);
    return solid;
}

/* A ball as a sparse level set: distances in leaves of 8^3 samples. */
static qn_volume *make_level_set(qn_context *context, const double centre[3], double radius) {
    static int32_t origins[LEAVES * LEAVES * LEAVES][3];
    static float values[LEAVES * LEAVES * LEAVES][512];
    const double voxel = 2.4 * radius / (8 * LEAVES);
    for (int leaf = 0; leaf < LEAVES * LEAVES * LEAVES; ++leaf) {
        const int at[3] = {leaf % LEAVES, leaf / LEAVES % LEAVES, leaf / LEAVES / LEAVES};
        for (int k = 0; k < 3; ++k)
            origins[leaf][k] = 8 * at[k];
        for (int n = 0; n < 512; ++n) {
            const int place[3] = {n % 8, n / 8 % 8, n / 64};
            double sum = 0;
            for (int k = 0; k < 3; ++k) {
                const double d = voxel * (8 * at[k] + place[k] - 4 * LEAVES + 0.5);
                sum += d * d;
            }
            values[leaf][n] = (float)(sqrt(sum) - radius);
        }
    }
    qn_sparse_grid grid = {.scalar = QN_F32,
                           .leaf_count = LEAVES * LEAVES * LEAVES,
                           .origins = origins,
                           .values = values,
                           .background = 3 * voxel,
                           .kind = QN_SPARSE_LEVEL_SET};
    for (int k = 0; k < 3; ++k) {
        grid.index_to_world[k][k] = voxel;
        grid.index_to_world[k][3] = centre[k] - voxel * (4 * LEAVES - 0.5);
    }
    grid.index_to_world[3][3] = 1;
    qn_volume *volume;
    assert_int_equal(qn_volume_create_sparse(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    return volume;
}

static qn_solid *solid_of_volume(qn_context *context, const qn_volume *volume) {
    qn_solid_volume_options options;
    qn_solid_volume_options_init(&options);
    options.owner = LEVEL_SET;
    qn_solid *solid;
    assert_int_equal(
        qn_solid_from_volume(context, volume, 0, QN_INSIDE_BELOW, &options, &solid, NULL), QN_OK);
    return solid;
}

/* Whether a point is on the surfaces of two parts: where two solids meet. */
static bool is_on_two(qn_solid *const parts[3], const float *position, double near) {
    const double p[1][3] = {{position[0], position[1], position[2]}};
    int count = 0;
    for (int n = 0; n < 3; ++n) {
        double value;
        assert_int_equal(qn_solid_values(parts[n], 1, p, &value, NULL), QN_OK);
        count += fabs(value) < near;
    }
    return count >= 2;
}

typedef struct side {
    uint32_t low, high; /* the edge's ends */
    uint32_t triangle;
} side;

static int compare_sides(const void *a, const void *b) {
    const side *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    return p->high < q->high ? -1 : p->high > q->high;
}

static void normal_of(const qn_mesh_view *view, uint32_t triangle, double normal[3]) {
    const uint32_t *corner = view->triangles + 3 * (size_t)triangle;
    double a[3], b[3], length = 0;
    for (int k = 0; k < 3; ++k) {
        a[k] = (double)view->positions[3 * (size_t)corner[1] + (size_t)k] -
               (double)view->positions[3 * (size_t)corner[0] + (size_t)k];
        b[k] = (double)view->positions[3 * (size_t)corner[2] + (size_t)k] -
               (double)view->positions[3 * (size_t)corner[0] + (size_t)k];
    }
    for (int k = 0; k < 3; ++k) {
        normal[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        length += normal[k] * normal[k];
    }
    for (int k = 0; k < 3; ++k)
        normal[k] /= sqrt(length);
}

static bool is_tagged(const qn_mesh_view *view, const side *edge) {
    for (int64_t n = 0; n < view->crease_edge_count; ++n) {
        const uint32_t a = view->crease_edges[2 * n], b = view->crease_edges[2 * n + 1];
        if ((a < b ? a : b) == edge->low && (a < b ? b : a) == edge->high)
            return true;
    }
    return false;
}

static double length_of(const qn_mesh_view *view, const side *edge) {
    double length = 0;
    for (size_t k = 0; k < 3; ++k)
        length += pow((double)view->positions[3 * (size_t)edge->low + k] -
                          (double)view->positions[3 * (size_t)edge->high + k],
                      2);
    return sqrt(length);
}

/* Edges where owners meet; of those that do so at more than the crease angle and a little, how many
 * are not tagged. Of edges shorter than a thousandth of a cell the normals mean nothing. */
typedef struct seams {
    int64_t edges, flat, untagged;
} seams;

static void count_seams(const qn_mesh *mesh, double cell, seams *all) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const size_t count = 3 * (size_t)view.triangle_count;
    side *sides = test_alloc(count, sizeof *sides);
    for (size_t n = 0; n < count; ++n) {
        const uint32_t a = view.triangles[n], b = view.triangles[n % 3 == 2 ? n - 2 : n + 1];
        const side one = {a < b ? a : b, a < b ? b : a, (uint32_t)(n / 3)};
        sides[n] = one;
    }
    qsort(sides, count, sizeof *sides, compare_sides);
    for (size_t n = 0; n + 1 < count; n += 2) {
        double m[3], q[3];
        if (view.triangle_owners[sides[n].triangle] ==
                view.triangle_owners[sides[n + 1].triangle] ||
            length_of(&view, &sides[n]) < 1e-3 * cell)
            continue;
        normal_of(&view, sides[n].triangle, m);
        normal_of(&view, sides[n + 1].triangle, q);
        const bool sharp = m[0] * q[0] + m[1] * q[1] + m[2] * q[2] < 0.82; /* 35 degrees */
        ++all->edges;
        all->flat += !sharp;
        all->untagged += sharp && !is_tagged(&view, &sides[n]);
    }
    free(sides);
}

/* The seams: crease edges with both ends on the surfaces of two parts, to a hundredth of a cell. */
static void check_seam(const qn_mesh *mesh, qn_solid *const parts[3], double cell) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    int64_t seam = 0, owners[4] = {0};
    double length = 0;
    for (int64_t n = 0; n < view.triangle_count; ++n) {
        assert_in_range(view.triangle_owners[n], 1, 3);
        ++owners[view.triangle_owners[n]];
    }
    for (int64_t n = 0; n < view.crease_edge_count; ++n) {
        const float *a = view.positions + 3 * (size_t)view.crease_edges[2 * n],
                    *b = view.positions + 3 * (size_t)view.crease_edges[2 * n + 1];
        if (!is_on_two(parts, a, 0.01 * cell) || !is_on_two(parts, b, 0.01 * cell))
            continue;
        ++seam;
        length += sqrt(pow((double)a[0] - (double)b[0], 2) + pow((double)a[1] - (double)b[1], 2) +
                       pow((double)a[2] - (double)b[2], 2));
    }
    print_message("%lld triangles (%lld, %lld, %lld by owner), seams of %lld crease edges, %.1f "
                  "cells long\n",
                  (long long)view.triangle_count, (long long)owners[1], (long long)owners[2],
                  (long long)owners[3], (long long)seam, length / cell);
    for (int owner = 1; owner <= 3; ++owner)
        assert_true(owners[owner] > 100);
    assert_true(length > 100 * cell);
}

/* With room round the solid, so that nothing of the surface is the cut. */
static void surface_in_box(qn_context *context, const qn_solid *solid, qn_solid *const parts[3],
                           double extent, seams *all) {
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = 6;
    options.has_box = true;
    for (int k = 0; k < 3; ++k) {
        options.low[k] = -2.05;
        options.high[k] = options.low[k] + extent;
    }
    qn_solid_surface_report surface;
    qn_mesh *mesh;
    qn_error error;
    if (qn_solid_surface(context, solid, &options, &mesh, &surface, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    if (output)
        assert_int_equal(qn_mesh_write(context, mesh, output, NULL, NULL), QN_OK);
    check_seam(mesh, parts, surface.finest_cell);
    count_seams(mesh, surface.finest_cell, all);
    qn_mesh_destroy(mesh);
}

/* In boxes of several sizes, so that the corners of the seams lie in cells of all kinds. Where the
 * facets of the animal are as small as cells, or a corner lies in the next cell, one edge of a
 * hundred is not tagged. */
static void three_kinds_in_one_tree_meet_sharply(void **state) {
    (void)state;
    static const double bite[3] = {0.31, -0.62, 0.53};
    qn_context *context = test_context(0);
    qn_volume *volume = make_level_set(context, bite, 0.71);
    qn_solid *const parts[3] = {make_animal(context), make_block(context),
                                solid_of_volume(context, volume)};
    qn_solid *both, *solid;
    seams all = {0};
    assert_int_equal(qn_solid_union(context, 2, parts, &both, NULL), QN_OK);
    qn_solid *const last[2] = {both, parts[2]};
    assert_int_equal(qn_solid_difference(context, 2, last, &solid, NULL), QN_OK);
    for (int n = 0; n < 8; ++n)
        surface_in_box(context, solid, parts, 4.7 + 0.06 * n, &all);
    print_message("%lld edges between owners, %lld of them flat, %lld sharp and not tagged\n",
                  (long long)all.edges, (long long)all.flat, (long long)all.untagged);
    assert_true(all.edges > 8 * 100);
    assert_true(200 * all.untagged <= 3 * all.edges);
    qn_solid_destroy(solid);
    qn_solid_destroy(both);
    for (int n = 0; n < 3; ++n)
        qn_solid_destroy(parts[n]);
    qn_volume_destroy(volume);
    test_context_end(context);
}

int main(int argc, char **argv) {
    output = argc > 1 ? argv[1] : NULL;
    const struct CMUnitTest tests[] = {cmocka_unit_test(three_kinds_in_one_tree_meet_sharply)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
