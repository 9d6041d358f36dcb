// SPDX-License-Identifier: MIT
/* Solids of volumes: what every solid promises, crossings of lattice edges exact, both sides,
 * turned volumes, ranges from leaves. */
#include "lib/random_volume.h"
#include "lib/solid_claims.h"
#include "solid/sampled.h"

#include <math.h>

static qn_solid *solid_of(qn_context *context, const test_field *field, qn_volume **volume) {
    qn_solid *solid;
    qn_error error;
    *volume = test_field_volume(context, field);
    if (qn_solid_from_volume(context, *volume, field->iso, field->inside, NULL, &solid, &error) !=
        QN_OK)
        fail_msg("%s", error.message);
    return solid;
}

static void keeps_the_promises_of_solids(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    for (int n = 0; n < 40; ++n) {
        test_field field = test_random_field(&random, n & 1 ? TEST_SMOOTHED_NOISE : TEST_GAUSSIAN,
                                             n < 20 ? 6 : 30);
        if (n % 4 == 0)
            test_field_random_matrix(&field, &random);
        test_field_prepare(&field);
        qn_volume *volume;
        qn_solid *solid = solid_of(context, &field, &volume);
        test_claims claims = {.rounds = 30};
        double low[3], high[3];
        qn_solid_get_box(solid, low, high);
        if (low[0] < high[0] && isfinite(low[0])) {
            for (int k = 0; k < 3; ++k) {
                const double room = 0.2 * (high[k] - low[k]);
                claims.low[k] = low[k] - room;
                claims.high[k] = high[k] + room;
            }
            test_solid_claims(field.name, solid, &claims, &random);
        }
        qn_solid_destroy(solid);
        qn_volume_destroy(volume);
        test_field_free(&field);
    }
    test_context_end(context);
}

/* Along a lattice edge there is the one crossing of the straight line between its samples. */
static void lattice_edges_cross_where_the_line_does(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    int64_t crossings = 0;
    for (int round = 0; round < 20; ++round) {
        test_field field = test_field_make(4, 5, 6);
        test_random_fill(&field, &random, round & 1 ? TEST_SMALL_INTEGERS : TEST_GAUSSIAN);
        field.inside = round & 2 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_prepare(&field);
        qn_volume *volume;
        qn_solid *solid = solid_of(context, &field, &volume);
        for (int n = 0; n < 60; ++n) {
            const int axis = n % 3;
            int64_t at[3];
            double a[3], b[3];
            for (int k = 0; k < 3; ++k)
                a[k] = b[k] = (double)(at[k] = test_random_range(&random, 0, field.size[k] - 2));
            b[axis] += 1;
            const double v = test_field_distance(&field, at[0], at[1], at[2]);
            const double w = test_field_distance(&field, at[0] + (axis == 0), at[1] + (axis == 1),
                                                 at[2] + (axis == 2));
            qni_crossing found[4];
            int32_t count;
            assert_int_equal(solid->ops->crossings(solid, a, b, 4, found, &count), QN_OK);
            assert_int_equal(count, (v >= 0) != (w >= 0));
            if (!count)
                continue;
            assert_true(fabs(found[0].at - v / (v - w)) < 1e-15);
            assert_int_equal(found[0].enters, (field.inside == QN_INSIDE_BELOW) == (w < 0));
            ++crossings;
        }
        qn_solid_destroy(solid);
        qn_volume_destroy(volume);
        test_field_free(&field);
    }
    assert_true(crossings > 200);
    test_context_end(context);
}

/* Far from the surface, boxes are ruled out without looking at samples; ranges hold all values. */
static void ranges_over_large_boxes_are_tight(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_field field = test_field_make(64, 64, 64);
    for (int64_t n = 0; n < 64 * 64 * 64; ++n) {
        const double x = (double)(n % 64) - 31.5, y = (double)(n / 64 % 64) - 31.5,
                     z = (double)(n / 4096) - 31.5;
        field.values[n] = sqrt(x * x + y * y + z * z) - 20;
    }
    field.inside = QN_INSIDE_BELOW;
    test_field_prepare(&field);
    qn_volume *volume;
    qn_solid *solid = solid_of(context, &field, &volume);
    const qni_box within = {{26, 26, 26}, {37, 37, 37}}, apart = {{0, 0, 0}, {14, 63, 14}},
                  all = {{0, 0, 0}, {63, 63, 63}};
    double range[2];
    assert_int_equal(solid->ops->bounds(solid, &within, range), QN_OK);
    assert_true(range[1] < 0 && range[0] < -18 && range[0] > -21);
    assert_int_equal(solid->ops->bounds(solid, &apart, range), QN_OK);
    assert_true(range[0] > 0);
    assert_int_equal(solid->ops->bounds(solid, &all, range), QN_OK);
    assert_true(range[0] <= -19 && range[1] >= 34 && range[0] > -21 && range[1] < 36);
    qn_solid_destroy(solid);
    qn_volume_destroy(volume);
    test_field_free(&field);
    test_context_end(context);
}

/* A volume's solid takes part in booleans like any other. */
static void takes_part_in_booleans(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    test_field field = test_field_make(32, 32, 32);
    for (int64_t n = 0; n < 32 * 32 * 32; ++n) {
        const double x = (double)(n % 32) - 15.5, y = (double)(n / 32 % 32) - 15.5,
                     z = (double)(n / 1024) - 15.5;
        field.values[n] = sqrt(x * x + y * y + z * z) - 10;
    }
    field.inside = QN_INSIDE_BELOW;
    test_field_prepare(&field);
    qn_volume *volume;
    qn_solid *parts[2], *cut;
    parts[0] = solid_of(context, &field, &volume);
    const double low[3] = {0, 0, 15.5}, high[3] = {31, 31, 31};
    assert_int_equal(qn_solid_box(context, low, high, &parts[1], NULL), QN_OK);
    assert_int_equal(qn_solid_difference(context, 2, parts, &cut, NULL), QN_OK);
    qn_mesh *mesh;
    qn_error error;
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = 5;
    if (qn_solid_surface(context, cut, &options, &mesh, NULL, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    const double half = 2.0 / 3 * 3.14159265358979 * 1000;
    assert_true(fabs(report.volume - half) < 0.02 * half);
    qn_mesh_destroy(mesh);
    qn_solid_destroy(cut);
    qn_solid_destroy(parts[0]);
    qn_solid_destroy(parts[1]);
    qn_volume_destroy(volume);
    test_field_free(&field);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_the_promises_of_solids),
        cmocka_unit_test(lattice_edges_cross_where_the_line_does),
        cmocka_unit_test(ranges_over_large_boxes_are_tight),
        cmocka_unit_test(takes_part_in_booleans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
