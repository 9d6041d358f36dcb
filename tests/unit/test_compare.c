// SPDX-License-Identifier: MIT
/* Nearest triangles against brute force, and qn_mesh_compare() on meshes whose distances are known.
 */
#include "lib/failing.h"
#include "lib/support.h"
#include "mesh/nearest.h"

#include <math.h>

/* ---- a slow and plain distance -----------------------------------------------------------------
 */

typedef long double real;

static real clamp_to_segment(const real p[3], const real a[3], const real b[3]) {
    real along = 0, length = 0, squared = 0;
    for (int i = 0; i < 3; ++i) {
        along += (p[i] - a[i]) * (b[i] - a[i]);
        length += (b[i] - a[i]) * (b[i] - a[i]);
    }
    real t = length > 0 ? along / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    for (int i = 0; i < 3; ++i) {
        const real d = p[i] - a[i] - t * (b[i] - a[i]);
        squared += d * d;
    }
    return squared;
}

/* The least over the three sides and, where the foot lies inside, the plane. */
static real plain_squared(const double point[3], const float *corners[3]) {
    real p[3], v[3][3], n[3], squared = INFINITY;
    for (int i = 0; i < 3; ++i) {
        p[i] = point[i];
        for (int k = 0; k < 3; ++k)
            v[k][i] = corners[k][i];
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] =
            (v[1][j] - v[0][j]) * (v[2][k] - v[0][k]) - (v[1][k] - v[0][k]) * (v[2][j] - v[0][j]);
    }
    bool within = true;
    real length = 0, height = 0;
    for (int e = 0; e < 3; ++e) {
        const real *a = v[e], *b = v[(e + 1) % 3];
        const real side = clamp_to_segment(p, a, b);
        squared = side < squared ? side : squared;
        real turn = 0;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            turn += n[i] * ((b[j] - a[j]) * (p[k] - a[k]) - (b[k] - a[k]) * (p[j] - a[j]));
        }
        within = within && turn >= 0;
    }
    for (int i = 0; i < 3; ++i) {
        length += n[i] * n[i];
        height += n[i] * (p[i] - v[0][i]);
    }
    if (within && length > 0 && height * height / length < squared)
        squared = height * height / length;
    return squared;
}

/* Random triangles: many small ones, a few large, slivers, and some that have no area. */
static qn_mesh *random_soup(qn_context *context, test_random *random, int64_t count, double far) {
    float *positions = test_alloc((size_t)count, 9 * sizeof *positions);
    uint32_t *triangles = test_alloc((size_t)count, 3 * sizeof *triangles);
    for (int64_t t = 0; t < count; ++t) {
        const double size = test_random_range(random, 0, 9) == 0 ? 1 : 0.1;
        const bool thin = test_random_range(random, 0, 7) == 0;
        double centre[3], along[3];
        for (int i = 0; i < 3; ++i) {
            centre[i] = far + test_random_unit(random);
            along[i] = test_random_unit(random) - 0.5;
        }
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i)
                positions[9 * t + 3 * k + i] =
                    (float)(centre[i] + size * (thin ? along[i] * k : 0) +
                            size * (thin ? 1e-5 : 1) * (test_random_unit(random) - 0.5));
        for (uint32_t k = 0; k < 3; ++k)
            triangles[3 * t + k] = (uint32_t)(3 * t) + k;
        if (t % 20 == 0) /* no area */
            memcpy(positions + 9 * t + 3, positions + 9 * t, 3 * sizeof *positions);
    }
    const qn_mesh_view view = {.vertex_count = 3 * count,
                               .triangle_count = count,
                               .positions = positions,
                               .triangles = triangles};
    qn_mesh *mesh = NULL;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    free(positions);
    free(triangles);
    return mesh;
}

static double brute_force(const qni_nearest *nearest, const double p[3]) {
    real best = INFINITY;
    for (uint32_t t = 0; t < nearest->tree.triangle_count; ++t) {
        const float *corners[3];
        for (int k = 0; k < 3; ++k)
            corners[k] = qni_nearest_corner(nearest, t, k);
        const real squared = plain_squared(p, corners);
        best = squared < best ? squared : best;
    }
    return (double)sqrtl(best);
}

static void assert_same(const qni_near *a, const qni_near *b) {
    assert_true(a->squared == b->squared && a->triangle == b->triangle);
    assert_memory_equal(a->point, b->point, sizeof a->point);
}

static void try_soup(test_random *random, int64_t count, double far) {
    qn_context *context = test_context(1);
    qn_mesh *mesh = random_soup(context, random, count, far);
    qni_nearest nearest;
    assert_int_equal(qni_nearest_create(context, mesh, "test", &nearest, NULL), QN_OK);
    uint32_t hint = QNI_NO_TRIANGLE;
    for (int n = 0; n < 200; ++n) {
        double p[3];
        for (int i = 0; i < 3; ++i)
            p[i] = far + 2 * test_random_unit(random) - 0.5;
        const double expected = brute_force(&nearest, p);
        const qni_near near = qni_nearest_find(&nearest, p, INFINITY, QNI_NO_TRIANGLE);
        const double slack = 1e-12 * (1 + fabs(far));
        assert_true(fabs(sqrt(near.squared) - expected) <= slack);
        const qni_near hinted = qni_nearest_find(&nearest, p, INFINITY, hint);
        assert_same(&near, &hinted);
        const double limit = expected * (test_random_unit(random) + 0.5);
        const qni_near limited = qni_nearest_find(&nearest, p, limit * limit, QNI_NO_TRIANGLE);
        if (limit > expected + slack)
            assert_same(&near, &limited);
        else if (limit < expected - slack)
            assert_int_equal(limited.triangle, QNI_NO_TRIANGLE);
        double centre[3], away = 0;
        for (int i = 0; i < 3; ++i) {
            centre[i] = p[i] + 0.2 * (test_random_unit(random) - 0.5);
            away += (centre[i] - p[i]) * (centre[i] - p[i]);
        }
        away = (expected + sqrt(away)) * 1.001;
        qni_near_set set;
        qni_nearest_gather(&nearest, centre, away * away, &set);
        const qni_near among = qni_nearest_find_among(&nearest, &set, p, INFINITY, hint);
        assert_same(&near, &among);
        hint = near.triangle;
    }
    qni_nearest_destroy(&nearest);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void nearest_is_what_brute_force_finds(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int64_t n = 0; n < test_count(10, 200); ++n) {
        try_soup(&random, test_random_range(&random, 1, 400), 0);
        try_soup(&random, test_random_range(&random, 1, 60), 1000);
    }
}

/* ---- comparisons -------------------------------------------------------------------------------
 */

/* A box of quads between two corners; or open, without its top. */
static qn_mesh *box_mesh(qn_context *context, const float low[3], const float high[3]) {
    static const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    float positions[8][3];
    for (int v = 0; v < 8; ++v)
        for (int i = 0; i < 3; ++i)
            positions[v][i] = v >> i & 1 ? high[i] : low[i];
    const qn_mesh_view view = {
        .vertex_count = 8, .quad_count = 6, .positions = positions[0], .quads = quads[0]};
    qn_mesh *mesh = NULL;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    return mesh;
}

static const float zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};

static void a_box_and_a_larger_one(void **state) {
    (void)state;
    const float low[3] = {0, 0, 0}, high[3] = {1, 1, 1.25f};
    qn_context *context = test_context(2);
    qn_mesh *a = box_mesh(context, zero, one), *b = box_mesh(context, low, high);
    qn_mesh_comparison c;
    assert_int_equal(qn_mesh_compare(context, a, b, NULL, &c, NULL), QN_OK);
    assert_true(fabs(c.diagonal - sqrt(3)) < 1e-12);
    assert_true(fabs(c.area_a - 6) < 1e-12 && fabs(c.area_b - 7) < 1e-12);
    assert_true(fabs(c.volume_a - 1) < 1e-12 && fabs(c.volume_b - 1.25) < 1e-12);
    /* from a only the top is away from b: by 0.25 near its middle, by less at its rim */
    assert_true(fabs(c.a_to_b.max - 0.25) < 1e-12);
    assert_true(fabs(c.b_to_a.max - 0.25) < 1e-12 && c.b_to_a.farthest[2] == 1.25);
    assert_true(c.max == c.b_to_a.max && c.a_to_b.points == 100008);
    /* the top of b is 0.25 away, its walls above 1 from 0 to 0.25 */
    assert_true(fabs(c.b_to_a.mean - (0.25 + 4 * 0.25 * 0.125) / 7) < 1e-4);
    const double squares = 0.0625 + 4 * 0.25 * 0.0625 / 3;
    assert_true(fabs(c.b_to_a.rms - sqrt(squares / 7)) < 1e-4);
    /* of a's top the frame nearer to a wall than to the top of b looks at the walls */
    assert_true(fabs(c.a_to_b.normal_beyond_30 - (1 - 0.25) / 6) < 1e-3);
    assert_true(fabs(c.a_to_b.normal_max - 90) < 1e-9);
    qn_mesh_destroy(a);
    qn_mesh_destroy(b);
    test_context_end(context);
}

static void one_box_turned_inside_out(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    const float inner_low[3] = {1, 1, 1}, inner_high[3] = {0, 0, 0};
    qn_mesh *a = box_mesh(context, zero, one), *b = box_mesh(context, inner_low, inner_high);
    qn_mesh_comparison c;
    assert_int_equal(qn_mesh_compare(context, a, b, NULL, &c, NULL), QN_OK);
    assert_true(c.max < 1e-12 && fabs(c.volume_b + 1) < 1e-12);
    assert_true(c.a_to_b.normal_mean > 179);
    qn_mesh_destroy(a);
    qn_mesh_destroy(b);
    test_context_end(context);
}

static void threads_change_nothing(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_mesh_comparison results[3];
    memset(results, 0, sizeof results);
    for (int n = 0; n < 3; ++n) {
        test_random here = random;
        qn_context *context = test_context(1 + 2 * n);
        qn_mesh *a = random_soup(context, &here, 300, 0), *b = random_soup(context, &here, 200, 0);
        assert_int_equal(qn_mesh_compare(context, a, b, NULL, &results[n], NULL), QN_OK);
        qn_mesh_destroy(a);
        qn_mesh_destroy(b);
        test_context_end(context);
        assert_memory_equal(&results[n], &results[0], sizeof results[0]);
    }
}

static void what_cannot_be_compared(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    const float flat[3] = {1, 0, 0}, huge[3] = {1e30f, 1, 1};
    qn_mesh *a = box_mesh(context, zero, one), *none = box_mesh(context, zero, flat);
    qn_mesh *large = box_mesh(context, zero, huge);
    qn_mesh_comparison c;
    qn_error error;
    assert_int_equal(qn_mesh_compare(context, a, none, NULL, &c, &error), QN_ERROR_EMPTY);
    assert_non_null(strstr(error.message, "second"));
    assert_int_equal(qn_mesh_compare(context, large, a, NULL, &c, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_mesh_compare_options options;
    qn_mesh_compare_options_init(&options);
    options.samples = -1;
    assert_int_equal(qn_mesh_compare(context, a, a, &options, &c, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options.struct_size = 0;
    assert_int_equal(qn_mesh_compare(context, a, a, &options, &c, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_mesh_destroy(a);
    qn_mesh_destroy(none);
    qn_mesh_destroy(large);
    test_context_end(context);
}

static qn_status compare_boxes(qn_context *context) {
    const float high[3] = {1, 2, 1};
    qn_mesh *a = box_mesh(context, zero, one), *b = box_mesh(context, zero, high);
    qn_mesh_comparison c;
    qn_mesh_compare_options options;
    qn_mesh_compare_options_init(&options);
    options.samples = 10;
    const qn_status status = qn_mesh_compare(context, a, b, &options, &c, NULL);
    qn_mesh_destroy(a);
    qn_mesh_destroy(b);
    return status;
}

/* The meshes are made before the count begins: `first` allocations of theirs succeed. */
static void each_allocation_and_each_look_may_fail(void **state) {
    (void)state;
    const int64_t made_before = 7; /* context, and two meshes with their arrays: never fails */
    bool finished = false;
    for (int64_t n = made_before; !finished; ++n) {
        test_failing failing = {n, -1, 0};
        qn_context *context = test_failing_context(&failing);
        const qn_status status = compare_boxes(context);
        finished = failing.allocations_left >= 0;
        assert_int_equal(status, finished ? QN_OK : QN_ERROR_OUT_OF_MEMORY);
        qn_context_destroy(context);
        assert_int_equal(failing.held, 0);
    }
    finished = false;
    for (int64_t n = 0; !finished; ++n) {
        test_failing failing = {-1, n, 0};
        qn_context *context = test_failing_context(&failing);
        const qn_status status = compare_boxes(context);
        finished = failing.looks_left >= 0;
        assert_int_equal(status, finished ? QN_OK : QN_ERROR_CANCELLED);
        qn_context_destroy(context);
        assert_int_equal(failing.held, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_is_what_brute_force_finds),
        cmocka_unit_test(a_box_and_a_larger_one),
        cmocka_unit_test(one_box_turned_inside_out),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(what_cannot_be_compared),
        cmocka_unit_test(each_allocation_and_each_look_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
