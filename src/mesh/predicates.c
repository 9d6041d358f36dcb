// SPDX-License-Identifier: MIT
/* Exact orientation tests. An expansion is a sum of doubles of growing size that do not overlap, so
 * its last component carries its sign. After J. R. Shewchuk, Adaptive precision floating-point
 * arithmetic and fast robust geometric predicates, 1997: two-sum and two-product of section 2.3
 * and 2.5, the sum and the scaling of expansions of sections 2.4 and 2.6, the error bounds A of
 * tables 3 and 4.
 *
 * Float coordinates cannot leave the range of double in a product of three differences: the least
 * unit is 2^-447, the largest value below 2^390. Doubles that are 0 or between 1e-60 and 1e40 in
 * size cannot either (2^-756 to 2^402). Nothing here can overflow or underflow. */
#include "mesh/predicates.h"

#include <math.h>

enum { LARGEST_EXPANSION = 192 };

typedef struct two {
    double high, low;
} two;

static two two_sum(double a, double b) {
    double sum = a + b;
    double b_part = sum - a;
    double a_part = sum - b_part;
    two result = {sum, (a - a_part) + (b - b_part)};
    return result;
}

static two split(double a) {
    double c = 134217729.0 * a; /* 2^27 + 1 */
    double high = c - (c - a);
    two result = {high, a - high};
    return result;
}

static two two_product(double a, double b) {
    double product = a * b;
    two x = split(a), y = split(b);
    double rest = ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low;
    two result = {product, rest};
    return result;
}

static int keep(double *out, int count, double value) {
    if (value != 0)
        out[count++] = value;
    return count;
}

static int difference(double a, double b, double out[2]) {
    two d = two_sum(a, -b);
    return keep(out, keep(out, 0, d.low), d.high);
}

/* out = e + f; the components are taken by size from both and carried upwards. */
static int sum(const double *e, int e_count, const double *f, int f_count, double *out) {
    int i = 0, j = 0, count = 0;
    double carry = 0;
    while (i < e_count || j < f_count) {
        bool take_e = j == f_count || (i < e_count && fabs(e[i]) < fabs(f[j]));
        two s = two_sum(carry, take_e ? e[i++] : f[j++]);
        count = keep(out, count, s.low);
        carry = s.high;
    }
    return keep(out, count, carry);
}

/* out = e * factor, at most 2 e_count components. */
static int scale(const double *e, int e_count, double factor, double *out) {
    int count = 0;
    double carry = 0;
    for (int i = 0; i < e_count; ++i) {
        two product = two_product(e[i], factor);
        two low = two_sum(carry, product.low);
        two high = two_sum(product.high, low.high);
        count = keep(out, keep(out, count, low.low), high.low);
        carry = high.high;
    }
    return keep(out, count, carry);
}

/* out = e * f for f of one or two components (a difference); out holds 4 e_count. */
static int product(const double *e, int e_count, const double *f, int f_count, double *out) {
    double first[LARGEST_EXPANSION / 3], second[LARGEST_EXPANSION / 3];
    int first_count = f_count > 0 ? scale(e, e_count, f[0], first) : 0;
    int second_count = f_count > 1 ? scale(e, e_count, f[1], second) : 0;
    return sum(first, first_count, second, second_count, out);
}

typedef struct difference3 {
    double part[3][2];
    int count[3];
} difference3;

static difference3 difference_of(const double a[3], const double b[3]) {
    difference3 d;
    for (int i = 0; i < 3; ++i)
        d.count[i] = difference(a[i], b[i], d.part[i]);
    return d;
}

/* out = u_x v_y - u_y v_x, at most 16 components. */
static int minor(const difference3 *u, const difference3 *v, int x, int y, double out[16]) {
    double first[8], second[8];
    int first_count = product(u->part[x], u->count[x], v->part[y], v->count[y], first);
    int second_count = product(u->part[y], u->count[y], v->part[x], v->count[x], second);
    for (int i = 0; i < second_count; ++i)
        second[i] = -second[i];
    return sum(first, first_count, second, second_count, out);
}

static int sign_of(const double *e, int count) {
    return count == 0 ? 0 : (e[count - 1] > 0) - (e[count - 1] < 0);
}

static int orient3d_exact(const double a[3], const double b[3], const double c[3],
                          const double d[3]) {
    difference3 u = difference_of(b, a), v = difference_of(c, a), w = difference_of(d, a);
    double total[LARGEST_EXPANSION], longer[LARGEST_EXPANSION];
    int count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double cross[16], term[64];
        int cross_count = minor(&u, &v, (axis + 1) % 3, (axis + 2) % 3, cross);
        int term_count = product(cross, cross_count, w.part[axis], w.count[axis], term);
        int longer_count = sum(total, count, term, term_count, longer);
        for (int i = 0; i < longer_count; ++i)
            total[i] = longer[i];
        count = longer_count;
    }
    return sign_of(total, count);
}

/* The sign, where the determinant is larger than its error can be, or is no more than nothing;
 * else *clear is false. */
static int filtered_orient3d(const double a[3], const double b[3], const double c[3],
                             const double d[3], bool *clear) {
    const double bound = (7 + 56 * 0x1p-53) * 0x1p-53;
    double u[3], v[3], w[3];
    for (int i = 0; i < 3; ++i) {
        u[i] = b[i] - a[i];
        v[i] = c[i] - a[i];
        w[i] = d[i] - a[i];
    }
    double yz = u[1] * v[2], zy = u[2] * v[1];
    double zx = u[2] * v[0], xz = u[0] * v[2];
    double xy = u[0] * v[1], yx = u[1] * v[0];
    double determinant = w[0] * (yz - zy) + w[1] * (zx - xz) + w[2] * (xy - yx);
    double permanent = fabs(w[0]) * (fabs(yz) + fabs(zy)) + fabs(w[1]) * (fabs(zx) + fabs(xz)) +
                       fabs(w[2]) * (fabs(xy) + fabs(yx));
    const bool large = fabs(determinant) > bound * permanent;
    *clear = large || permanent == 0;
    return !large ? 0 : determinant > 0 ? 1 : -1;
}

int qni_orient3d_of(const double a[3], const double b[3], const double c[3], const double d[3]) {
    bool clear;
    const int sign = filtered_orient3d(a, b, c, d, &clear);
    return clear ? sign : orient3d_exact(a, b, c, d);
}

int qni_turn_of(const double a[3], const double b[3], const double c[3], const double d[3], int x,
                int y) {
    const double bound = (3 + 16 * 0x1p-53) * 0x1p-53;
    double left = (b[x] - a[x]) * (d[y] - c[y]), right = (b[y] - a[y]) * (d[x] - c[x]);
    double determinant = left - right, permanent = fabs(left) + fabs(right);
    if (fabs(determinant) > bound * permanent || permanent == 0)
        return (determinant > 0) - (determinant < 0);
    difference3 u = difference_of(b, a), v = difference_of(d, c);
    double exact[16];
    int count = minor(&u, &v, x, y, exact);
    return sign_of(exact, count);
}

static void widen(const float from[3], double to[3]) {
    for (int i = 0; i < 3; ++i)
        to[i] = (double)from[i];
}

int qni_orient3d_exact(const float a[3], const float b[3], const float c[3], const float d[3]) {
    double p[4][3];
    widen(a, p[0]);
    widen(b, p[1]);
    widen(c, p[2]);
    widen(d, p[3]);
    return orient3d_exact(p[0], p[1], p[2], p[3]);
}

int qni_orient3d(const float a[3], const float b[3], const float c[3], const float d[3]) {
    double p[4][3];
    widen(a, p[0]);
    widen(b, p[1]);
    widen(c, p[2]);
    widen(d, p[3]);
    return qni_orient3d_of(p[0], p[1], p[2], p[3]);
}

int qni_orient3d_quick(const float a[3], const float b[3], const float c[3], const float d[3]) {
    double p[4][3];
    bool clear;
    widen(a, p[0]);
    widen(b, p[1]);
    widen(c, p[2]);
    widen(d, p[3]);
    return filtered_orient3d(p[0], p[1], p[2], p[3], &clear);
}

int qni_orient2d(const float a[3], const float b[3], const float c[3], int x, int y) {
    double p[3][3];
    widen(a, p[0]);
    widen(b, p[1]);
    widen(c, p[2]);
    return qni_turn_of(p[0], p[1], p[0], p[2], x, y);
}

bool qni_collinear(const float a[3], const float b[3], const float c[3]) {
    return qni_orient2d(a, b, c, 0, 1) == 0 && qni_orient2d(a, b, c, 1, 2) == 0 &&
           qni_orient2d(a, b, c, 2, 0) == 0;
}
