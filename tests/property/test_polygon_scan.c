// SPDX-License-Identifier: MIT
/* A block of a polygon model's lattice, scanned at once, says what each point and edge says when it
 * is asked alone, to the last bit: random overlapping boxes and balls, lattices through their
 * corners, lists short and long; some with holes. */
#include "lib/polygon_models.h"
#include "solid/model.h"

#include <math.h>
#include <string.h>

static qn_solid *random_model(qn_context *context, test_random *random) {
    test_model model = {0};
    const int parts = 1 + (int)(test_random_bits(random) % 3);
    for (int n = 0; n < parts; ++n) {
        const double low[3] = {-1 + 0.25 * (double)(test_random_bits(random) % 4), -1, -0.5},
                     high[3] = {0.5, 0.25 * (double)(1 + test_random_bits(random) % 4), 1};
        double matrix[3][4];
        test_random_matrix(random, 0.5, matrix);
        if (test_random_bits(random) % 2)
            test_model_ball(&model, low, 0.8, (int)(test_random_bits(random) % 4));
        else
            test_model_box(&model, low, high, test_random_bits(random) % 2 ? matrix : NULL);
    }
    if (test_random_bits(random) % 2) /* holes */
        model.triangle_count -= 1 + (int64_t)(test_random_bits(random) % 3);
    qn_mesh *mesh = test_model_mesh(context, &model);
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    qn_solid *solid = NULL;
    qn_error error;
    if (qn_solid_from_mesh(context, mesh, &options, &solid, NULL, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh_destroy(mesh);
    test_model_free(&model);
    return solid;
}

static void compare_signs(const qn_solid *whole, const double planes[3][9],
                          const qni_block_scan *scan) {
    for (int n = 0; n < QNI_SCAN_POINTS; ++n) {
        const double point[1][3] = {{planes[0][n % 9], planes[1][n / 9 % 9], planes[2][n / 81]}};
        bool inside;
        assert_int_equal(whole->ops->inside(whole, 1, point, &inside), QN_OK);
        assert_int_equal(inside, scan->inside[n]);
    }
}

static int compare_edges(const qn_solid *whole, const double planes[3][9],
                         const qni_block_scan *scan) {
    int crossed = 0;
    for (int edge = 0; edge < QNI_SCAN_EDGES; ++edge) {
        const int axis = edge >> 9, at[3] = {edge & 7, edge >> 3 & 7, edge >> 6 & 7};
        double a[3], b[3];
        qni_crossing alone[QNI_CROSSINGS];
        int32_t count;
        for (int k = 0; k < 3; ++k) {
            a[k] = planes[k][at[k]];
            b[k] = planes[k][at[k] + (k == axis)];
        }
        assert_int_equal(whole->ops->crossings(whole, a, b, QNI_CROSSINGS, alone, &count), QN_OK);
        assert_int_equal(count, scan->starts[edge + 1] - scan->starts[edge]);
        assert_int_equal(count > 0, scan->crossed[edge >> 6] >> (edge & 63) & 1);
        for (int32_t n = 0; n < count; ++n) {
            const qni_crossing *other = &scan->crossings[scan->starts[edge] + n];
            assert_memory_equal(&alone[n].at, &other->at, sizeof other->at);
            assert_memory_equal(alone[n].normal, other->normal, sizeof other->normal);
            assert_int_equal(alone[n].owner, other->owner);
            assert_int_equal(alone[n].enters, other->enters);
        }
        crossed += count;
    }
    return crossed;
}

static int scan_one(const qn_solid *whole, test_random *random) {
    double planes[3][9];
    qni_box box;
    const double step = test_random_bits(random) % 2 ? 0.25 : 0.03125;
    for (int k = 0; k < 3; ++k) {
        const double low = -2 + step * (double)(test_random_bits(random) % (uint64_t)(4 / step));
        for (int n = 0; n < 9; ++n)
            planes[k][n] = low + step * n;
        box.low[k] = planes[k][0];
        box.high[k] = planes[k][8];
    }
    qn_solid *local;
    qni_block_scan scan;
    bool known;
    assert_int_equal(whole->ops->restrict_to(whole, &box, &local), QN_OK);
    assert_int_equal(
        local->ops->scan(local, (const double(*)[9])planes, QNI_CROSSINGS, &scan, &known), QN_OK);
    assert_true(known);
    compare_signs(whole, (const double(*)[9])planes, &scan);
    const int crossed = compare_edges(whole, (const double(*)[9])planes, &scan);
    qni_free(whole->context, scan.crossings, scan.capacity, sizeof *scan.crossings);
    qn_solid_destroy(local);
    return crossed;
}

static void a_scan_says_what_single_questions_say(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    int64_t crossed = 0;
    for (int round = 0; round < 60; ++round) {
        qn_solid *whole = random_model(context, &random);
        for (int block = 0; block < 12; ++block)
            crossed += scan_one(whole, &random);
        qn_solid_destroy(whole);
    }
    assert_true(crossed > 2000); /* not all blocks were empty */
    test_context_end(context);
}

/* A local solid walks from point to point and looks in its list; the whole one shoots rays and
 * searches its tree: of panels equally near but for rounding each may find another. */
static int ask_one(const qn_solid *whole, const qn_solid *local, const double p[3], double most) {
    const double point[1][3] = {{p[0], p[1], p[2]}};
    double value, gradient[1][3], both, slope[3], distance;
    int32_t owner, other;
    assert_int_equal(whole->ops->values(whole, 1, point, &value), QN_OK);
    assert_int_equal(whole->ops->gradients(whole, 1, point, gradient, &owner), QN_OK);
    assert_int_equal(qni_solid_first_order(local, p, &both, slope, &other), QN_OK);
    assert_int_equal(value < 0, both < 0);
    assert_true(fabs(value - both) <= 1e-12);
    for (int k = 0; k < 3 && fabs(value) > 1e-6; ++k)
        assert_true(fabs(gradient[0][k] - slope[k]) <= 1e-8);
    assert_int_equal(owner, other);
    if (!local->ops->distance(local, p, most, &distance))
        return 0; /* caps matter here */
    if (fabs(value) <= most)
        assert_true(fabs(distance - fabs(value)) <= 1e-12);
    else
        assert_true(distance > most - 1e-12);
    return 1;
}

static void local_solids_say_what_the_whole_one_says(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    int64_t known = 0;
    for (int round = 0; round < 60; ++round) {
        qn_solid *whole = random_model(context, &random), *local;
        qni_box box;
        const double size = test_random_bits(&random) % 2 ? 0.5 : 2;
        for (int k = 0; k < 3; ++k) {
            box.low[k] = -1.5 + 2 * test_random_unit(&random);
            box.high[k] = box.low[k] + size;
        }
        assert_int_equal(whole->ops->restrict_to(whole, &box, &local), QN_OK);
        for (int n = 0; n < 200; ++n) {
            double p[3];
            for (int k = 0; k < 3; ++k) /* some beyond the box, some on planes of the model */
                p[k] = test_random_bits(&random) % 4 == 0
                           ? 0.25 * (double)test_random_range(&random, -6, 6)
                           : box.low[k] + (1.2 * test_random_unit(&random) - 0.1) * size;
            known += ask_one(whole, local, p, test_random_bits(&random) % 2 ? 1e-9 : 0.3 * size);
        }
        qn_solid_destroy(local);
        qn_solid_destroy(whole);
    }
    assert_true(known > 5000);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scan_says_what_single_questions_say),
        cmocka_unit_test(local_solids_say_what_the_whole_one_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
