// SPDX-License-Identifier: MIT
/* The field of caps: the exact sum of solid angles, its gradient, the jump where a cap is crossed;
 * the same bits whoever asked for what before. */
#include "lib/support.h"
#include "solid/cap_field.h"

#include <math.h>

enum { FANS = 40, ASKED = 2000 };

/* Fans of random loops, some tiny, each round its middle, like caps over holes. */
static void make_fans(qn_context *context, test_random *random, qni_panel_tree *tree) {
    int32_t number = 0;
    for (int fan = 0; fan < FANS; ++fan) {
        int corners = (int)test_random_range(random, 3, 24);
        double middle[3], size = pow(10, -2 * test_random_unit(random));
        for (int k = 0; k < 3; ++k)
            middle[k] = 2 * test_random_unit(random) - 1;
        for (int n = 0; n < corners; ++n) {
            qni_panel panel = {.number = number++};
            for (int end = 0; end < 2; ++end) {
                double turn = 6.283185307179586 * ((n + end) % corners) / corners;
                panel.at[end][0] = (float)(middle[0] + size * cos(turn));
                panel.at[end][1] = (float)(middle[1] + size * sin(turn));
                panel.at[end][2] = (float)(middle[2] + 0.3 * size * cos(3 * turn + fan));
            }
            for (int k = 0; k < 3; ++k)
                panel.at[2][k] = (float)middle[k];
            assert_true(qni_panel_tree_add(context, tree, &panel));
        }
    }
    assert_true(qni_panel_tree_build(context, tree, true));
}

static double exact_angle(const qni_panel_tree *tree, const double p[3], double gradient[3]) {
    double total = 0;
    for (int32_t n = 0; n < tree->count; ++n)
        total += qni_panel_angle(&tree->panels[n], p, gradient);
    return total;
}

/* Anywhere, also beyond the root; half of them close to a panel. */
static void random_point(test_random *random, const qni_panel_tree *tree, double p[3]) {
    const qni_panel *panel = &tree->panels[test_random_range(random, 0, tree->count - 1)];
    bool close = test_random_range(random, 0, 1);
    for (int k = 0; k < 3; ++k)
        p[k] = close ? (double)panel->at[1][k] + 0.02 * test_random_gaussian(random)
                     : 1.2 * test_random_gaussian(random);
}

static void the_field_is_the_sum(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    qni_panel_tree tree = {0};
    qni_cap_field field;
    const qni_box box = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}};
    make_fans(context, &random, &tree);
    assert_true(qni_cap_field_start(context, &tree, &box, &field));
    double worst = 0, worst_slope = 0;
    for (int n = 0; n < ASKED; ++n) {
        double p[3], slope[3] = {0, 0, 0}, exact_slope[3] = {0, 0, 0};
        random_point(&random, &tree, p);
        double angle = qni_cap_field_angle(&field, p, slope);
        double exact = exact_angle(&tree, p, exact_slope), off = 0, size = 0;
        worst = fmax(worst, fabs(angle - exact));
        for (int k = 0; k < 3; ++k) {
            off += (slope[k] - exact_slope[k]) * (slope[k] - exact_slope[k]);
            size += exact_slope[k] * exact_slope[k];
        }
        worst_slope = fmax(worst_slope, sqrt(off / (1e-4 + size)));
    }
    print_message("largest error %.2g, of the gradient's length %.2g\n", worst, worst_slope);
    assert_true(worst < 3e-3);
    assert_true(worst_slope < 0.1);
    qni_cap_field_free(&field);
    qni_panel_tree_free(context, &tree);
    test_context_end(context);
}

static void a_crossed_cap_is_a_jump_of_one(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    qni_panel_tree tree = {0};
    qni_cap_field field;
    const qni_box box = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}};
    make_fans(context, &random, &tree);
    assert_true(qni_cap_field_start(context, &tree, &box, &field));
    int crossed = 0;
    for (int n = 0; n < 500; ++n) {
        const qni_panel *panel = &tree.panels[test_random_range(&random, 0, tree.count - 1)];
        double normal[3], p[3], q[3], u = 0.1 + 0.5 * test_random_unit(&random);
        qni_panel_normal(panel, normal);
        for (int k = 0; k < 3; ++k) {
            double at = u * (double)panel->at[0][k] + 0.3 * (double)panel->at[1][k] +
                        (0.7 - u) * (double)panel->at[2][k];
            p[k] = at + 1e-7 * normal[k];
            q[k] = at - 1e-7 * normal[k];
        }
        if (qni_panel_across(panel, p, q) == 0)
            continue;
        double change = qni_cap_field_angle(&field, q, NULL) - qni_cap_field_angle(&field, p, NULL);
        assert_true(fabs(change - 1) < 5e-3);
        ++crossed;
    }
    assert_true(crossed > 400);
    qni_cap_field_free(&field);
    qni_panel_tree_free(context, &tree);
    test_context_end(context);
}

static void the_order_of_asking_changes_nothing(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(4);
    qni_panel_tree tree = {0};
    qni_cap_field one, other;
    const qni_box box = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}};
    double(*points)[3] = test_alloc(ASKED, sizeof *points);
    double *answers = test_alloc(ASKED, sizeof *answers);
    make_fans(context, &random, &tree);
    assert_true(qni_cap_field_start(context, &tree, &box, &one));
    assert_true(qni_cap_field_start(context, &tree, &box, &other));
    for (int n = 0; n < ASKED; ++n) {
        random_point(&random, &tree, points[n]);
        answers[n] = qni_cap_field_angle(&one, points[n], NULL);
    }
    int64_t different = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(4) reduction(+ : different)
    for (int n = ASKED - 1; n >= 0; --n) {
        double again = qni_cap_field_angle(&other, points[n], NULL);
        different += memcmp(&again, &answers[n], sizeof again) != 0;
    }
    assert_int_equal(different, 0);
    qni_cap_field_free(&one);
    qni_cap_field_free(&other);
    qni_panel_tree_free(context, &tree);
    free(points);
    free(answers);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_field_is_the_sum),
        cmocka_unit_test(a_crossed_cap_is_a_jump_of_one),
        cmocka_unit_test(the_order_of_asking_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
