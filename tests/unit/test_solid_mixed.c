// SPDX-License-Identifier: MIT
/* [CMS05] figure 8d: a polygon animal, a CSG solid and a level set in one tree: clean, every owner
 * on the surface, and long creases that lie on two of them where they meet.
 * With a name the mesh is written there: test_solid_mixed mixed.ply */
#include "lib/level_set.h"
#include "lib/polygon_models.h"
#include "lib/seams.h"

#include <math.h>

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
    return test_model_solid(context, &model, 1);
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
static void surface_in_box(qn_context *context, const test_parts *parts, double extent,
                           test_seams *all) {
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
    if (qn_solid_surface(context, parts->whole, &options, &mesh, &surface, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    if (output)
        assert_int_equal(qn_mesh_write(context, mesh, output, NULL, NULL), QN_OK);
    check_seam(mesh, parts->parts, surface.finest_cell);
    test_measure_seams(parts, mesh, surface.finest_cell, all);
    qn_mesh_destroy(mesh);
}

/* In boxes of several sizes, so that the corners of the seams lie in cells of all kinds. Of edges
 * that turn by more than 35 degrees only some beside a seam of less are not tagged: there a crease
 * ends, or thin triangles turn more than the parts do. */
static void three_kinds_in_one_tree_meet_sharply(void **state) {
    (void)state;
    static const double bite[3] = {0.31, -0.62, 0.53};
    qn_context *context = test_context(0);
    qn_volume *volume = test_ball_level_set(context, bite, 0.71);
    test_parts tree = {.parts = {make_animal(context), make_block(context),
                                 test_level_set_solid(context, volume, 3)},
                       .signs = {1, 1, -1}};
    qn_solid *both;
    test_seams all = {0};
    assert_int_equal(qn_solid_union(context, 2, tree.parts, &both, NULL), QN_OK);
    qn_solid *const last[2] = {both, tree.parts[2]};
    assert_int_equal(qn_solid_difference(context, 2, last, &tree.whole, NULL), QN_OK);
    const int boxes = (int)test_count(8, 64);
    for (int n = 0; n < boxes; ++n)
        surface_in_box(context, &tree, 4.7 + 0.06 * n * 8 / boxes, &all);
    print_message(
        "%lld edges between owners, %lld of them flat, %lld sharp and not tagged, %lld of "
        "these where the parts meet at less than 35 degrees; %lld points of seams, %lld "
        "missing, up to %.2f cells off; %.6f %.6f %.6f\n",
        (long long)all.edges, (long long)all.flat, (long long)all.untagged, (long long)all.shallow,
        (long long)all.points, (long long)all.missing, all.farthest, all.where[0], all.where[1],
        all.where[2]);
    assert_true(all.edges > boxes * 100);
    assert_int_equal(all.untagged, all.shallow);
    assert_true(200 * all.shallow <= all.edges);
    assert_true(boxes > 8 ? 1000 * all.missing <= all.points : all.missing == 0);
    qn_solid_destroy(tree.whole);
    qn_solid_destroy(both);
    for (int n = 0; n < TEST_SEAM_PARTS; ++n)
        qn_solid_destroy(tree.parts[n]);
    qn_volume_destroy(volume);
    test_context_end(context);
}

int main(int argc, char **argv) {
    output = argc > 1 ? argv[1] : NULL;
    const struct CMUnitTest tests[] = {cmocka_unit_test(three_kinds_in_one_tree_meet_sharply)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
