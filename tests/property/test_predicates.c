// SPDX-License-Identifier: MIT
/* The exact predicates against other ways to the same signs: 128-bit integers, fractions,
 * constructions. */
#include "lib/support.h"
#include "mesh/predicates.h"
#include "mesh/triangle_pair.h"
#include "orientation_table.h"

#include <math.h>

__extension__ typedef __int128 wide;

static test_random dice;

static int roll(int low, int high) {
    return (int)test_random_range(&dice, low, high);
}

static float roll_unit(void) {
    return (float)(test_random_bits(&dice) >> 40) * 0x1p-24f;
}

static int sign_of(wide value) {
    return (value > 0) - (value < 0);
}

/* ---- orientation -------------------------------------------------------------------------------
 */

static int integer_orientation(const int64_t p[4][3]) {
    wide u[3], v[3], w[3], value = 0;
    for (int i = 0; i < 3; ++i) {
        u[i] = p[1][i] - p[0][i];
        v[i] = p[2][i] - p[0][i];
        w[i] = p[3][i] - p[0][i];
    }
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        value += w[i] * (u[j] * v[k] - u[k] * v[j]);
    }
    return sign_of(value);
}

/* Three random points and one in or near their plane. */
static void roll_points(int64_t p[4][3], int range) {
    for (int k = 0; k < 4; ++k)
        for (int i = 0; i < 3; ++i)
            p[k][i] = roll(-range, range);
    if (roll(0, 3) == 0)
        return;
    int s = roll(-2, 2), t = roll(-2, 2), off = roll(-3, 1);
    for (int i = 0; i < 3; ++i)
        p[3][i] = p[0][i] + s * (p[1][i] - p[0][i]) + t * (p[2][i] - p[0][i]);
    if (off >= 0)
        p[3][off] += roll(-1, 1);
}

static void orientation_of_integers_is_exact(void **state) {
    (void)state;
    static const int ranges[] = {1, 3, 100, 5000, 1 << 20, 1800000};
    int64_t rounds = test_count(2000000, 50000000), zeros = 0;
    for (int64_t n = 0; n < rounds; ++n) {
        int64_t p[4][3];
        float f[4][3];
        roll_points(p, ranges[n % 6]);
        for (int k = 0; k < 4; ++k)
            for (int i = 0; i < 3; ++i)
                f[k][i] = (float)p[k][i]; /* below 2^24: exact */
        int expected = integer_orientation((const int64_t(*)[3])p);
        zeros += expected == 0;
        assert_int_equal(qni_orient3d(f[0], f[1], f[2], f[3]), expected);
        assert_int_equal(qni_orient3d_exact(f[0], f[1], f[2], f[3]), expected);
        wide area = (wide)(p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                    (wide)(p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
        assert_int_equal(qni_orient2d(f[0], f[1], f[2], 0, 1), sign_of(area));
    }
    assert_true(zeros > rounds / 10);
}

static void orientation_of_wild_floats_is_exact(void **state) {
    (void)state;
    static const int orders[6][4] = {{0, 1, 2, 1},  {1, 2, 0, 1},  {2, 0, 1, 1},
                                     {1, 0, 2, -1}, {0, 2, 1, -1}, {2, 1, 0, -1}};
    for (size_t n = 0; n < sizeof orientation_table / sizeof orientation_table[0]; ++n) {
        const float(*p)[3] = orientation_table[n].points;
        int expected = orientation_table[n].orientation, area = orientation_table[n].area;
        for (int k = 0; k < 6; ++k) {
            const float *a = p[orders[k][0]], *b = p[orders[k][1]], *c = p[orders[k][2]];
            int sense = orders[k][3];
            assert_int_equal(qni_orient3d(a, b, c, p[3]), sense * expected);
            assert_int_equal(qni_orient3d(p[3], b, a, c), sense * expected);
            assert_int_equal(qni_orient3d_exact(a, b, c, p[3]), sense * expected);
            assert_int_equal(qni_orient2d(a, b, c, 0, 1), sense * area);
            assert_int_equal(qni_orient2d(a, b, c, 1, 0), -sense * area);
        }
    }
}

static float wild_float(int spread) {
    float x = ldexpf(1 + roll_unit(), roll(-spread, spread));
    return roll(0, 1) ? x : -x;
}

/* The filter must never answer otherwise than the expansions. */
static void filter_and_expansions_agree(void **state) {
    (void)state;
    static const int spreads[] = {0, 2, 10, 25, 60, 120};
    int64_t rounds = test_count(500000, 20000000);
    for (int64_t n = 0; n < rounds; ++n) {
        float p[4][3];
        float s = roll_unit(), t = roll_unit();
        for (int k = 0; k < 4; ++k)
            for (int i = 0; i < 3; ++i)
                p[k][i] = wild_float(spreads[n % 6]);
        for (int i = 0; i < 3 && n % 4; ++i)
            p[3][i] = p[0][i] + s * (p[1][i] - p[0][i]) + t * (p[2][i] - p[0][i]);
        int sign = qni_orient3d_exact(p[0], p[1], p[2], p[3]);
        assert_int_equal(qni_orient3d(p[0], p[1], p[2], p[3]), sign);
        assert_int_equal(qni_orient3d(p[3], p[1], p[0], p[2]), sign);
        assert_int_equal(qni_orient3d(p[0], p[2], p[1], p[3]), -sign);
    }
}

/* ---- triangle against triangle
 * ------------------------------------------------------------------- */

/* A point with rational coordinates x / w, w > 0. */
typedef struct point {
    int64_t x[3], w;
} point;

static void cross(const int64_t a[3], const int64_t b[3], int64_t out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static int64_t dot(const int64_t a[3], const int64_t b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void minus(const int64_t a[3], const int64_t b[3], int64_t out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[i] - b[i];
}

static void normal_of(const int64_t t[3][3], int64_t n[3]) {
    int64_t u[3], v[3];
    minus(t[1], t[0], u);
    minus(t[2], t[0], v);
    cross(u, v, n);
}

static bool is_flat(const int64_t t[3][3]) {
    int64_t n[3];
    normal_of(t, n);
    return dot(n, n) == 0;
}

/* A point a + (b - a) num / den. */
static point point_between(const int64_t a[3], const int64_t b[3], int64_t num, int64_t den) {
    point p;
    p.w = den < 0 ? -den : den;
    for (int i = 0; i < 3; ++i)
        p.x[i] = a[i] * p.w + (b[i] - a[i]) * (den < 0 ? -num : num);
    return p;
}

static bool point_in_triangle(const point *p, const int64_t t[3][3]) {
    int64_t n[3], to_point[3];
    normal_of(t, n);
    for (int i = 0; i < 3; ++i) {
        int64_t edge[3], across[3];
        minus(t[(i + 1) % 3], t[i], edge);
        for (int k = 0; k < 3; ++k)
            to_point[k] = p->x[k] - t[i][k] * p->w;
        cross(edge, to_point, across);
        if (dot(to_point, n) != 0 || dot(across, n) < 0)
            return false;
    }
    return true;
}

/* Which points of a contact are allowed: those on the shared vertices or the shared edge. */
typedef struct allowed {
    int count;
    int64_t at[2][3];
} allowed;

static bool is_allowed(const point *p, const allowed *shared) {
    int64_t from_first[3], edge[3], off[3];
    if (shared->count == 0)
        return false;
    for (int k = 0; k < 3; ++k)
        from_first[k] = p->x[k] - shared->at[0][k] * p->w;
    if (shared->count == 1)
        return dot(from_first, from_first) == 0;
    minus(shared->at[1], shared->at[0], edge);
    cross(edge, from_first, off);
    int64_t along = dot(edge, from_first);
    return dot(off, off) == 0 && along >= 0 && along <= dot(edge, edge) * p->w;
}

static bool is_contact(const point *p, const int64_t t[3][3], const allowed *shared) {
    return point_in_triangle(p, t) && !is_allowed(p, shared);
}

/* Where segment ab crosses, or lies in, the plane of t. */
static bool segment_has_contact(const int64_t a[3], const int64_t b[3], const int64_t t[3][3],
                                const allowed *shared) {
    int64_t n[3], to_a[3], to_b[3];
    normal_of(t, n);
    minus(a, t[0], to_a);
    minus(b, t[0], to_b);
    int64_t a_height = dot(to_a, n), b_height = dot(to_b, n);
    if (a_height != b_height) {
        if (a_height * b_height > 0)
            return false;
        point p = point_between(a, b, a_height, a_height - b_height);
        return is_contact(&p, t, shared);
    }
    if (a_height != 0)
        return false;
    point end_a = point_between(a, b, 0, 1), end_b = point_between(a, b, 1, 1);
    if (is_contact(&end_a, t, shared) || is_contact(&end_b, t, shared))
        return true;
    for (int i = 0; i < 3; ++i) {
        int64_t u[3], v[3], w[3], area[3], part[3], other[3];
        minus(b, a, u);
        minus(t[(i + 1) % 3], t[i], v);
        minus(t[i], a, w);
        cross(u, v, area);
        cross(w, v, part);
        cross(w, u, other);
        int64_t den = dot(area, area), num = dot(part, area), along = dot(other, area);
        if (den == 0 || num < 0 || num > den || along < 0 || along > den)
            continue;
        point p = point_between(a, b, num, den);
        if (is_contact(&p, t, shared))
            return true;
    }
    return false;
}

/* The common part of two triangles is the hull of points in which edges of one meet the other. */
static bool constructed_contact(const int64_t s[3][3], const int64_t t[3][3],
                                const allowed *shared) {
    for (int i = 0; i < 3; ++i)
        if (segment_has_contact(s[i], s[(i + 1) % 3], t, shared) ||
            segment_has_contact(t[i], t[(i + 1) % 3], s, shared))
            return true;
    return false;
}

typedef struct pair {
    int64_t whole[6][3];
    uint32_t a[3], b[3];
    int shared;
} pair;

static bool roll_pair(pair *p, int range) {
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < 3; ++i)
            p->whole[k][i] = roll(0, range);
    if (roll(0, 2) == 0) /* all in one plane */
        for (int k = 0; k < 6; ++k)
            p->whole[k][2] = p->whole[k][0] + p->whole[k][1];
    p->shared = roll(0, 2);
    int turn = roll(0, 2), start = roll(0, 2);
    for (int i = 0; i < 3; ++i) {
        p->a[i] = (uint32_t)((i + start) % 3);
        p->b[(i + turn) % 3] = (uint32_t)(i < p->shared ? i : i + 3);
    }
    int64_t s[3][3], t[3][3];
    for (int i = 0; i < 3; ++i) {
        memcpy(s[i], p->whole[p->a[i]], sizeof s[i]);
        memcpy(t[i], p->whole[p->b[i]], sizeof t[i]);
    }
    return !is_flat((const int64_t(*)[3])s) && !is_flat((const int64_t(*)[3])t);
}

static bool expected_contact(const pair *p) {
    int64_t s[3][3], t[3][3];
    allowed shared = {p->shared, {{0}}};
    for (int i = 0; i < 3; ++i) {
        memcpy(s[i], p->whole[p->a[i]], sizeof s[i]);
        memcpy(t[i], p->whole[p->b[i]], sizeof t[i]);
        if (i < 2)
            memcpy(shared.at[i], p->whole[i], sizeof shared.at[i]);
    }
    return constructed_contact((const int64_t(*)[3])s, (const int64_t(*)[3])t, &shared);
}

static void triangles_meet_as_constructed(void **state) {
    (void)state;
    static const int ranges[] = {1, 2, 3, 6, 20};
    int64_t rounds = test_count(3000000, 100000000), tried = 0, met[3] = {0}, apart[3] = {0};
    for (int64_t n = 0; n < rounds; ++n) {
        pair p;
        float f[6][3];
        if (!roll_pair(&p, ranges[n % 5]))
            continue;
        int64_t shift = n % 2 ? 1 << 23 : 0; /* where floats are whole numbers */
        for (int k = 0; k < 6; ++k)
            for (int i = 0; i < 3; ++i)
                f[k][i] = (float)(p.whole[k][i] + shift);
        bool expected = expected_contact(&p);
        ++*(expected ? &met[p.shared] : &apart[p.shared]);
        ++tried;
        assert_int_equal(qni_triangles_meet(f[0], p.a, p.b), expected);
    }
    for (int i = 0; i < 3; ++i)
        assert_true(met[i] > tried / 50 && apart[i] > tried / 50);
}

static bool meet_turned(const float f[6][3], const pair *p, int symmetry) {
    float g[6][3];
    static const int axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                   {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < 3; ++i) {
            float x = f[k][axes[symmetry % 6][i]];
            g[k][i] = (symmetry / 6) >> i & 1 ? -x : x;
        }
    uint32_t a[3], b[3];
    int turn = roll(0, 2), mirror = roll(0, 1);
    for (int i = 0; i < 3; ++i) {
        a[i] = p->a[(i + turn) % 3];
        b[mirror ? 2 - i : i] = p->b[i];
    }
    return turn ? qni_triangles_meet(g[0], a, b) : qni_triangles_meet(g[0], b, a);
}

static void meeting_does_not_depend_on_order_or_axes(void **state) {
    (void)state;
    int64_t rounds = test_count(40000, 2000000);
    for (int64_t n = 0; n < rounds; ++n) {
        pair p;
        float f[6][3];
        if (!roll_pair(&p, 4))
            continue;
        for (int k = 0; k < 6; ++k)
            for (int i = 0; i < 3; ++i)
                f[k][i] = (float)p.whole[k][i] + (n % 2 ? 0.1f * roll_unit() : 0);
        if (qni_collinear(f[p.a[0]], f[p.a[1]], f[p.a[2]]) ||
            qni_collinear(f[p.b[0]], f[p.b[1]], f[p.b[2]]))
            continue;
        bool expected = qni_triangles_meet(f[0], p.a, p.b);
        for (int symmetry = 0; symmetry < 48; ++symmetry)
            assert_int_equal(meet_turned((const float(*)[3])f, &p, symmetry), expected);
    }
}

int main(void) {
    dice.state = test_seed();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orientation_of_integers_is_exact),
        cmocka_unit_test(orientation_of_wild_floats_is_exact),
        cmocka_unit_test(filter_and_expansions_agree),
        cmocka_unit_test(triangles_meet_as_constructed),
        cmocka_unit_test(meeting_does_not_depend_on_order_or_axes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
