// SPDX-License-Identifier: MIT
/* The surfacer has the connectivity of the reference on random volumes: vertices, quads, winding,
 * each interior face segment once in each direction; closed meshes close and have even Euler
 * numbers. */
#include "lib/mesh_measure.h"
#include "lib/random_volume.h"
#include "lib/reference_match.h"

/* Face segments are the true edges: a non-manifold edge counts as the two it is. */
static void check_closed(const test_field *field, const qn_mesh *mesh, const test_match *match) {
    test_edges edges = test_mesh_edges(mesh);
    qn_mesh_view view = qn_mesh_get_view(mesh);
    if (edges.unbalanced != 0 || match->segments != 2 * view.quad_count)
        fail_msg(
            "%s: closed, but %lld edges are not balanced and %lld of %lld segments are interior",
            field->name, (long long)edges.unbalanced, (long long)match->segments,
            (long long)(2 * view.quad_count));
    int64_t euler = view.vertex_count - match->segments + view.quad_count;
    if (euler % 2 != 0 || euler > 2 * test_mesh_pieces(mesh))
        fail_msg("%s: Euler characteristic %lld of %lld pieces", field->name, (long long)euler,
                 (long long)test_mesh_pieces(mesh));
    double area, volume;
    test_mesh_area_volume(mesh, &area, &volume);
    if (!(volume >= -1e-5 * area)) /* samples on the iso-value can make solids of no volume */
        fail_msg("%s: signed volume %g", field->name, volume);
}

static void check_field(qn_context *context, const test_field *field, int64_t totals[3]) {
    qn_surface_report report;
    qn_mesh *mesh = test_field_surface(context, field, &report);
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    test_match_report(field, &reference, &report);
    if (!field->open)
        check_closed(field, mesh, &match);
    assert_true(test_mesh_is_finite(mesh));
    totals[0] += reference.polygon_count;
    totals[1] += reference.ambiguous_faces;
    totals[2] += reference.tied_faces;
    test_match_free(&match);
    test_reference_free(&reference);
    qn_mesh_destroy(mesh);
}

static void random_volumes_have_the_reference_s_connectivity(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t totals[3] = {0, 0, 0}, count = test_count(400, 2000);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 24);
        size_t length = strlen(field.name);
        snprintf(field.name + length, sizeof field.name - length, ", number %lld", (long long)i);
        check_field(context, &field, totals);
        test_field_free(&field);
    }
    printf("%lld volumes: %lld vertices, %lld ambiguous faces, %lld of them tied\n",
           (long long)count, (long long)totals[0], (long long)totals[1], (long long)totals[2]);
    assert_true(totals[1] > 1000 && totals[2] > 100);
    test_context_end(context);
}

/* Many leaves along one axis, few along the others, most of them empty: neighbours that are
 * missing, far away, or at the end of another row. */
static void long_and_sparse_volumes_have_the_reference_s_connectivity(void **state) {
    (void)state;
    static const test_kind kinds[] = {TEST_SPARSE, TEST_SPARSE, TEST_SMOOTHED_NOISE, TEST_GAUSSIAN};
    uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t totals[3] = {0, 0, 0};
    for (int64_t i = 0; i < test_count(24, 200); ++i) {
        test_random random = {seed + 77777 + (uint64_t)i};
        int64_t n[3];
        for (int a = 0; a < 3; ++a)
            n[a] = a == i % 3 ? test_random_range(&random, 100, 600)
                              : test_random_range(&random, 1, 40);
        test_field field = test_field_make(n[0], n[1], n[2]);
        test_random_fill(&field, &random, kinds[i % 4]);
        field.open = i & 8;
        field.inside = i & 16 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_prepare(&field);
        check_field(context, &field, totals);
        test_field_free(&field);
    }
    assert_true(totals[0] > 10000);
    test_context_end(context);
}

/* All 256 sign patterns, each with each kind of values: one cell, closed on both sides and open. */
static void all_cells_have_the_reference_s_connectivity(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    int64_t totals[3] = {0, 0, 0};
    test_field field = test_field_make(2, 2, 2);
    for (int pattern = 0; pattern < 256; ++pattern)
        for (int kind = 0; kind < TEST_KIND_COUNT; ++kind)
            for (int rule = 0; rule < 3; ++rule) {
                field.open = rule == 2;
                field.inside = rule == 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
                test_random_fill(&field, &random, (test_kind)kind);
                for (int c = 0; c < 8; ++c) { /* mirror the values into the pattern */
                    double d = field.values[c] - field.iso;
                    field.values[c] = field.iso + ((d < 0) == (pattern >> c & 1) ? -d : d);
                }
                test_field_prepare(&field);
                check_field(context, &field, totals);
            }
    assert_true(totals[2] > 100);
    test_field_free(&field);
    test_context_end(context);
}

/* The exact comparison is itself compared: with 128 bit integers, and where doubles underflow. */
static void products_are_compared_exactly(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int i = 0; i < 200000; ++i) {
        int64_t n[4], near = test_random_range(&random, 1, INT64_C(1) << 53);
        for (int k = 0; k < 4; ++k)
            n[k] = near + test_random_range(&random, -1, 1);
        __int128 difference = (__int128)n[0] * n[1] - (__int128)n[2] * n[3];
        assert_int_equal(
            test_compare_products((double)n[0], (double)n[1], (double)n[2], (double)n[3]),
            (difference > 0) - (difference < 0));
    }
    assert_int_equal(test_compare_products(1e-300, 1e-300, 1e-301, 1e-300), 1);
    assert_int_equal(test_compare_products(0x1p-1074, 1, 1, 0x1p-1074), 0);
    assert_int_equal(test_compare_products(1e300, 1e300, 1e301, 1e300), -1);
    assert_int_equal(test_compare_products(0, 5, 0x1p-1074, 0x1p-1074), -1);
    assert_int_equal(test_compare_products(0, 5, 1, 0), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products_are_compared_exactly),
        cmocka_unit_test(all_cells_have_the_reference_s_connectivity),
        cmocka_unit_test(long_and_sparse_volumes_have_the_reference_s_connectivity),
        cmocka_unit_test(random_volumes_have_the_reference_s_connectivity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
