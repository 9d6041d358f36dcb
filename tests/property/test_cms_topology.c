// SPDX-License-Identifier: MIT
/* Cubical Marching Squares on volumes has the topology of the trilinear interpolant: pieces and
 * Euler characteristic, found independently, with tubes where it has tunnels; and stays clean. */
#include "lib/random_volume.h"
#include "lib/trilinear_topology.h"

static qn_mesh *surface(qn_context *context, const test_field *field,
                        const qn_solid_surface_options *options, qn_solid_surface_report *report) {
    qn_volume *volume = test_field_volume(context, field);
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface_adaptive(context, volume, field->iso, field->inside, options, &mesh, report,
                            &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    qn_volume_destroy(volume);
    return mesh;
}

typedef struct agreement {
    int64_t grids, agreeing, tubes, nested, lost, late;
} agreement;

static void compare(qn_context *context, const test_field *field, int64_t number,
                    const qn_solid_surface_options *options, agreement *sum) {
    qn_solid_surface_report report;
    qn_mesh *mesh = surface(context, field, options, &report);
    qn_mesh_report check;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &check, NULL), QN_OK);
    if (!check.closed || !check.manifold || !check.oriented || check.self_intersections)
        fail_msg("%s, number %lld: closed %d, manifold %d, oriented %d, %lld self-intersections",
                 field->name, (long long)number, check.closed, check.manifold, check.oriented,
                 (long long)check.self_intersections);
    bool late;
    const test_topology found = test_trilinear_topology(field, &check, &late);
    if (!test_topology_agrees(&found, &check))
        print_message("%s, number %lld: mesh of %lld pieces, Euler %lld, %lld tubes; by brute "
                      "force %lld pieces, Euler %lld, %lld tunnels\n",
                      field->name, (long long)number, (long long)check.components,
                      (long long)check.euler_characteristic, (long long)report.tubes,
                      (long long)found.components, (long long)found.euler,
                      (long long)found.tunnels);
    ++sum->grids;
    sum->agreeing += test_topology_agrees(&found, &check);
    sum->tubes += report.tubes;
    sum->nested += report.nested_tubes;
    sum->lost += report.lost_tubes;
    sum->late += late;
    qn_mesh_destroy(mesh);
}

static void compare_grids(qn_context *context, test_kind kind, int64_t count, bool plain) {
    agreement sum = {0};
    const uint64_t seed = test_seed();
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.uniform = options.no_features = plain;
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_field_make(5, 5, 5);
        test_random_fill(&field, &random, kind);
        field.inside = i & 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_prepare(&field);
        compare(context, &field, i, &options, &sum);
        test_field_free(&field);
    }
    printf("%s, %s: %lld of %lld grids of 5 x 5 x 5 as the trilinear surface; %lld tubes, %lld "
           "nested, %lld lost; %lld needed more than 32 boxes\n",
           test_kind_name(kind), plain ? "uniform" : "adaptive", (long long)sum.agreeing,
           (long long)sum.grids, (long long)sum.tubes, (long long)sum.nested, (long long)sum.lost,
           (long long)sum.late);
    assert_int_equal(sum.agreeing, sum.grids);
    assert_int_equal(sum.lost, 0);
    assert_true(sum.tubes > 0);
}

static void has_the_topology_of_the_trilinear_surface(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    compare_grids(context, TEST_GAUSSIAN, test_count(150, 10000), true);
    compare_grids(context, TEST_SMALL_INTEGERS, test_count(80, 2000), true);
    compare_grids(context, TEST_GAUSSIAN, test_count(40, 1000), false);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(has_the_topology_of_the_trilinear_surface),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
