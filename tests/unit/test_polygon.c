// SPDX-License-Identifier: MIT
/* Polygons are split into triangles that cover them once, concave ones too, in any plane. */
#include "lib/support.h"
#include "mesh/polygon.h"

#include <math.h>

enum { MOST = 6000 };

static float positions[MOST][3];
static uint32_t corners[MOST], triangles[MOST][3];

static void split(int64_t count) {
    int64_t bytes = qni_polygon_scratch_bytes(count);
    void *scratch = test_alloc((size_t)bytes, 1);
    for (int64_t i = 0; i < count; ++i)
        corners[i] = (uint32_t)i;
    memset(triangles, 0xff, sizeof triangles);
    qni_polygon_split(&positions[0][0], corners, count, scratch, &triangles[0][0]);
    free(scratch);
    for (int64_t t = 0; t < count - 2; ++t)
        for (int c = 0; c < 3; ++c)
            assert_in_range(triangles[t][c], 0, count - 1);
    assert_int_equal(triangles[count - 2][0], 0xffffffff);
}

/* Twice the area vector's part along n. */
static double area_along(const uint32_t t[3], const double n[3]) {
    double u[3], v[3], sum = 0;
    for (int a = 0; a < 3; ++a) {
        u[a] = (double)positions[t[1]][a] - (double)positions[t[0]][a];
        v[a] = (double)positions[t[2]][a] - (double)positions[t[0]][a];
    }
    for (int a = 0; a < 3; ++a)
        sum += n[a] * (u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3]);
    return sum;
}

/* Put plane coordinates into space along two perpendicular unit vectors; n is their cross product.
 */
static void lay(const double (*flat)[2], int64_t count, const double u[3], const double v[3],
                double n[3]) {
    for (int a = 0; a < 3; ++a)
        n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
    for (int64_t i = 0; i < count; ++i)
        for (int a = 0; a < 3; ++a)
            positions[i][a] = (float)(flat[i][0] * u[a] + flat[i][1] * v[a]);
}

/* All triangles turn as the polygon does and their areas add up to its own: they cover it once. */
static void assert_covers(const double (*flat)[2], int64_t count, const double n[3]) {
    double area = 0, sum = 0;
    for (int64_t i = 0; i < count; ++i) {
        const double *p = flat[i], *q = flat[(i + 1) % count];
        area += p[0] * q[1] - p[1] * q[0];
    }
    for (int64_t t = 0; t < count - 2; ++t) {
        double part = area_along(triangles[t], n);
        if (!(part > -1e-5 * area))
            fail_msg("triangle %lld of %lld is turned over", (long long)t, (long long)count);
        sum += part;
    }
    if (!(fabs(sum - area) < 1e-4 * area))
        fail_msg("%lld corners: triangles add up to %g, not %g", (long long)count, sum, area);
}

static const double x_axis[3] = {1, 0, 0}, y_axis[3] = {0, 1, 0}, z_axis[3] = {0, 0, 1};

static void an_l_and_a_comb_are_covered(void **state) {
    (void)state;
    static const double l[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    static const double comb[10][2] = {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1},
                                       {3, 1}, {3, 3}, {1, 3}, {1, 1}, {0, 1}};
    const double *axes[3][2] = {{x_axis, y_axis}, {y_axis, z_axis}, {x_axis, z_axis}};
    for (int plane = 0; plane < 3; ++plane) {
        double n[3];
        lay(l, 6, axes[plane][0], axes[plane][1], n);
        split(6);
        assert_covers(l, 6, n);
        lay(comb, 10, axes[plane][0], axes[plane][1], n);
        split(10);
        assert_covers(comb, 10, n);
    }
}

static void random_stars_are_covered_in_any_plane(void **state) {
    (void)state;
    test_random random = {test_seed()};
    static double flat[400][2];
    for (int64_t round = test_count(2000, 50000); round > 0; --round) {
        int64_t count = test_random_range(&random, 5, round % 50 ? 24 : 400);
        for (int64_t i = 0; i < count; ++i) {
            double angle = 6.283185307179586 * (double)i / (double)count;
            double radius = 0.1 + test_random_unit(&random);
            flat[i][0] = radius * cos(angle);
            flat[i][1] = radius * sin(angle);
        }
        double u[3], v[3], n[3], along = 0, length = 0;
        for (int a = 0; a < 3; ++a)
            u[a] = test_random_gaussian(&random), length += u[a] * u[a];
        for (int a = 0; a < 3; ++a)
            u[a] /= sqrt(length);
        for (int a = 0; a < 3; ++a)
            v[a] = test_random_gaussian(&random), along += v[a] * u[a];
        length = 0;
        for (int a = 0; a < 3; ++a)
            v[a] -= along * u[a], length += v[a] * v[a];
        for (int a = 0; a < 3; ++a)
            v[a] /= sqrt(length);
        lay(flat, count, u, v, n);
        split(count);
        assert_covers(flat, count, n);
    }
}

static void what_is_no_polygon_still_gives_triangles(void **state) {
    (void)state;
    memset(positions, 0, sizeof positions);
    split(7); /* all in one point */
    for (int i = 0; i < 9; ++i)
        positions[i][0] = (float)i;
    split(9); /* on a line */
    positions[3][1] = NAN;
    split(9);
    positions[3][1] = INFINITY;
    split(9);
    test_random random = {test_seed()};
    for (int i = 0; i < 300; ++i)
        for (int a = 0; a < 3; ++a)
            positions[i][a] = (float)test_random_gaussian(&random);
    split(300); /* crosses itself everywhere */
    split(QNI_LARGEST_CLIPPED + 100);
    positions[0][0] = 0;
    split(3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_l_and_a_comb_are_covered),
        cmocka_unit_test(random_stars_are_covered_in_any_plane),
        cmocka_unit_test(what_is_no_polygon_still_gives_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
