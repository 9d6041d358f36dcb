// SPDX-License-Identifier: MIT
/* Which corners of a cell the trilinear interpolant joins inside, decided exactly.
 *
 * Across an axis the interpolant is bilinear in every slice, so every part of a slice above (or
 * below) the iso-value holds one of its corners, and two parts with opposite corners a, c are one
 * where a c - b d > 0 (>= 0 for above: a saddle at the iso-value counts as above, as in
 * face/face_hd.h). Hence the regions of the cell are those of its border, and two of them are
 * joined inside exactly if their edges along the axis - any one axis will do - carry a slice like
 * that. With a, b, c, d linear along the edges, a c - b d is a quadratic form in (s, t) = (1 - z,
 * z). It is negative at both ends of the stretch where a and c are above, else the regions would be
 * joined on the border already; so it reaches 0 inside exactly if its discriminant is not negative
 * and its polar form of the two ends is positive. The discriminant is the hyperdeterminant of the
 * eight values, the same for all three axes. Both are sums of products of four values; where
 * rounding leaves their sign open they are summed without it. */
#ifndef QNI_FACE_TUNNEL_HD_H
#define QNI_FACE_TUNNEL_HD_H

#include "face/face_hd.h"

/* ---- signs of sums of products, exact for magnitudes between 1e-60 and 1e70 (and 0) ------------
 */

enum { QNI_MOST_PRODUCTS = 12, QNI_PARTS_OF_PRODUCT = 8 };

typedef struct qni_products {
    double factor[QNI_MOST_PRODUCTS][4];
    int count;
} qni_products;

QN_HD_INLINE void qni_add_product(qni_products *sum, double a, double b, double c, double d) {
    double *factor = sum->factor[sum->count++];
    factor[0] = a;
    factor[1] = b;
    factor[2] = c;
    factor[3] = d;
}

/* Add b to the sum of `count` parts that do not overlap, least first (Shewchuk 1997). */
QN_HD static inline int qni_grow_sum(double *parts, int count, double b) {
    int kept = 0;
    for (int n = 0; n < count; ++n) {
        const double a = parts[n], sum = a + b;
        const double b_part = sum - a, a_part = sum - b_part;
        const double rest = (a - a_part) + (b - b_part);
        if (rest != 0)
            parts[kept++] = rest;
        b = sum;
    }
    if (b != 0)
        parts[kept++] = b;
    return kept;
}

QN_HD static inline int qni_exact_sign(const qni_products *sum) {
    double parts[QNI_MOST_PRODUCTS * QNI_PARTS_OF_PRODUCT];
    int count = 0;
    for (int n = 0; n < sum->count; ++n) {
        const double *f = sum->factor[n];
        const double low = f[0] * f[1], high = f[2] * f[3];
        const double first[2] = {low, qni_product_error(f[0], f[1], low)};
        const double second[2] = {high, qni_product_error(f[2], f[3], high)};
        for (int k = 0; k < 4; ++k) {
            const double a = first[k & 1], b = second[k >> 1], p = a * b;
            count = qni_grow_sum(parts, count, qni_product_error(a, b, p));
            count = qni_grow_sum(parts, count, p);
        }
    }
    return count == 0 ? 0 : parts[count - 1] > 0 ? 1 : -1;
}

QN_HD static inline int qni_sign_of_products(const qni_products *sum) {
    double value = 0, size = 0;
    for (int n = 0; n < sum->count; ++n) {
        const double *f = sum->factor[n];
        const double p = (f[0] * f[1]) * (f[2] * f[3]);
        value += p;
        size += p < 0 ? -p : p;
    }
    const double most_wrong = size * 2e-15; /* 12 terms, 3 + 11 roundings of 2^-53 each, and some */
    if (value > most_wrong)
        return 1;
    if (value < -most_wrong)
        return -1;
    return size == 0 ? 0 : qni_exact_sign(sum);
}

/* The sign of the hyperdeterminant of the eight values. */
QN_HD static inline int qni_discriminant_sign(const double d[8]) {
    const double p0 = d[0] * d[7], p1 = d[1] * d[6], p2 = d[2] * d[5], p3 = d[3] * d[4];
    const double even = (d[0] * d[3]) * (d[5] * d[6]), odd = (d[7] * d[4]) * (d[2] * d[1]);
    const double a = (p0 - p1) - (p2 - p3), b = p0 * p3 + p1 * p2;
    const double value = a * a + 4 * ((even + odd) - b);
    const double size = (p0 * p0 + p1 * p1) + (p2 * p2 + p3 * p3) +
                        ((even < 0 ? -even : even) + (odd < 0 ? -odd : odd));
    if (value > size * 4e-14 || value < size * -4e-14) /* far from where rounding matters */
        return value > 0 ? 1 : -1;
    qni_products sum;
    sum.count = 0;
    for (int n = 0; n < 4; ++n)
        qni_add_product(&sum, d[n], d[7 - n], d[n], d[7 - n]);
    for (int n = 0; n < 4; ++n)
        for (int m = n + 1; m < 4; ++m)
            qni_add_product(&sum, -2 * d[n], d[7 - n], d[m], d[7 - m]);
    qni_add_product(&sum, 4 * d[0], d[3], d[5], d[6]);
    qni_add_product(&sum, 4 * d[7], d[4], d[2], d[1]);
    return qni_sign_of_products(&sum);
}

/* ---- one pair of opposite edges -------------------------------------------------------------- */

/* Values of the four edges along z at the cell's lower and upper end; a and c are opposite, above
 * where their sign is `sign`. */
typedef struct qni_edge_pair {
    double a[2], b[2], c[2], d[2];
} qni_edge_pair;

/* A point of the edges as (s, t), both at least 0. */
typedef struct qni_edge_place {
    double s, t;
} qni_edge_place;

/* Where an edge is above: from one place to the other. */
QN_HD_INLINE void qni_edge_above(const double v[2], const int above[2], qni_edge_place *from,
                                 qni_edge_place *to) {
    const double size_0 = v[0] < 0 ? -v[0] : v[0], size_1 = v[1] < 0 ? -v[1] : v[1];
    from->s = above[0] ? 1 : size_1;
    from->t = above[0] ? 0 : size_0;
    to->s = above[1] ? 0 : size_1;
    to->t = above[1] ? 1 : size_0;
}

/* -1, 0, 1: p comes before, is at, or comes after q. */
QN_HD_INLINE int qni_compare_places(qni_edge_place p, qni_edge_place q) {
    return qni_determinant_sign(p.t, q.s, q.t, p.s);
}

/* The sign of twice the polar form of a c - b d at the two places. */
QN_HD static inline int qni_polar_sign(const qni_edge_pair *e, qni_edge_place p, qni_edge_place q) {
    qni_products sum;
    sum.count = 0;
    qni_add_product(&sum, 2 * e->a[0], e->c[0], p.s, q.s);
    qni_add_product(&sum, -2 * e->b[0], e->d[0], p.s, q.s);
    qni_add_product(&sum, 2 * e->a[1], e->c[1], p.t, q.t);
    qni_add_product(&sum, -2 * e->b[1], e->d[1], p.t, q.t);
    for (int n = 0; n < 2; ++n) {
        const double s = n ? q.s : p.s, t = n ? p.t : q.t;
        qni_add_product(&sum, e->a[0], e->c[1], s, t);
        qni_add_product(&sum, e->a[1], e->c[0], s, t);
        qni_add_product(&sum, -e->b[0], e->d[1], s, t);
        qni_add_product(&sum, -e->b[1], e->d[0], s, t);
    }
    return qni_sign_of_products(&sum);
}

/* The edges at columns `first` and its opposite, 3 - first, of a cell: joined inside on the given
 * side (1: above)? To be asked of edges whose regions are apart on the border, with a discriminant
 * that allows it. The ends of the stretch where both edges are on that side are given back. */
QN_HD static inline int qni_edges_join(const double d[8], int first, int side,
                                       qni_edge_place stretch[2]) {
    const int a = first, c = 3 - first, b = first ^ 1, e = c ^ 1;
    const qni_edge_pair pair = {
        {d[a], d[a + 4]}, {d[b], d[b + 4]}, {d[c], d[c + 4]}, {d[e], d[e + 4]}};
    const int above_a[2] = {(d[a] >= 0) == side, (d[a + 4] >= 0) == side};
    const int above_c[2] = {(d[c] >= 0) == side, (d[c + 4] >= 0) == side};
    if (!(above_a[0] || above_a[1]) || !(above_c[0] || above_c[1]))
        return 0;
    qni_edge_place from_a, to_a, from_c, to_c;
    qni_edge_above(pair.a, above_a, &from_a, &to_a);
    qni_edge_above(pair.c, above_c, &from_c, &to_c);
    stretch[0] = qni_compare_places(from_a, from_c) >= 0 ? from_a : from_c;
    stretch[1] = qni_compare_places(to_a, to_c) <= 0 ? to_a : to_c;
    return qni_compare_places(stretch[0], stretch[1]) < 0 &&
           qni_polar_sign(&pair, stretch[0], stretch[1]) > 0;
}

/* ---- the cell -------------------------------------------------------------------------------- */

QN_HD_INLINE void qni_merge_regions(int region[8], int a, int b) {
    const int to = a < b ? a : b, from = a < b ? b : a;
    for (int corner = 0; corner < 8; ++corner)
        region[corner] = region[corner] == from ? to : region[corner];
}

/* Where a c - b d is largest between the two ends, and the saddle of that slice. */
QN_HD static inline void qni_tunnel_middle(const double d[8], const qni_edge_place stretch[2],
                                           double middle[3]) {
    double bound[2], q[3];
    for (int n = 0; n < 2; ++n)
        bound[n] = stretch[n].t / (stretch[n].s + stretch[n].t);
    q[0] = d[0] * d[3] - d[1] * d[2];
    q[1] = (d[0] * d[7] + d[4] * d[3]) - (d[1] * d[6] + d[5] * d[2]);
    q[2] = d[4] * d[7] - d[5] * d[6];
    const double top = (q[1] - 2 * q[0]) / (2 * ((q[1] - q[0]) - q[2]));
    const double z = top >= bound[0] && top <= bound[1] ? top : (bound[0] + bound[1]) * 0.5;
    double v[4];
    for (int n = 0; n < 4; ++n)
        v[n] = d[n] + z * (d[n + 4] - d[n]);
    const double bend = (v[0] + v[3]) - (v[1] + v[2]);
    const double x = (v[0] - v[2]) / bend, y = (v[0] - v[1]) / bend;
    middle[0] = x > 0 && x < 1 ? x : 0.5;
    middle[1] = y > 0 && y < 1 ? y : 0.5;
    middle[2] = z;
}

/* Pairs of opposite edges that would join inside, if the border has not joined them already: bits 0
 * and 1 above, 2 and 3 below, for columns 0 and 1. The cheap question, to be asked first. */
QN_HD static inline int qni_joining_edges(const double d[8], qni_edge_place stretch[4][2]) {
    const int discriminant = qni_discriminant_sign(d);
    int joining = 0;
    if (discriminant < 0)
        return 0;
    for (int n = 0; n < 4; ++n)
        if ((n < 2 || discriminant > 0) && qni_edges_join(d, n & 1, n < 2, stretch[n]))
            joining |= 1 << n;
    return joining;
}

/* Join the regions of the corners, as the border made them, that hang together inside. True when
 * some do: then `side` (1: above) is what the tunnel holds, and `middle` a place well inside of it,
 * the saddle of the widest slice along z, local. */
QN_HD static inline int qni_join_regions(const double d[8], int joining,
                                         const qni_edge_place stretch[4][2], int region[8],
                                         int *side_out, double middle[3]) {
    int found = 0;
    for (int n = 0; n < 4; ++n) {
        if (!(joining >> n & 1))
            continue;
        const int side = n < 2, a = n & 1, c = 3 - a;
        const int corner_a = (d[a] >= 0) == side ? a : a + 4,
                  corner_c = (d[c] >= 0) == side ? c : c + 4;
        if (region[corner_a] == region[corner_c])
            continue;
        /* Swapping the two diagonals turns the form's sign: its extremum stays where it is. */
        qni_tunnel_middle(d, stretch[n], middle);
        *side_out = side;
        qni_merge_regions(region, region[corner_a], region[corner_c]);
        found = 1;
    }
    return found;
}

#endif
