// SPDX-License-Identifier: MIT
/* Which crossings of an ambiguous face are joined: the one rule for every surfacer and every
 * processor.
 *
 * A face with two opposite corners above the iso-value and two below has two ways to pair its four
 * crossings. The asymptotic decider (Nielson and Hamann 1991; [DMC21] section 3.1.1) asks for the
 * sign of the bilinear interpolant at its saddle, (a c - b d) / (a + c - b - d) with a, c above and
 * b, d below (values less iso). The denominator is positive, so the sign of a c - b d decides. It
 * is evaluated here exactly, so both cells at the face, in whatever order they name its corners, on
 * any machine, get the same answer. */
#ifndef QNI_FACE_FACE_HD_H
#define QNI_FACE_FACE_HD_H

#include "core/hd.h"

/* The rounding error of the rounded product p = a b, by Dekker's splitting: a b = p + error,
 * exactly, as long as nothing over- or underflows. Only + - *: the same bits wherever contraction
 * is off. */
QN_HD_INLINE double qni_product_error(double a, double b, double p) {
    const double splitter = 134217729.0; /* 2^27 + 1 */
    const double a_big = splitter * a, b_big = splitter * b;
    const double a_high = a_big - (a_big - a), b_high = b_big - (b_big - b);
    const double a_low = a - a_high, b_low = b - b_high;
    return a_low * b_low - (((p - a_high * b_high) - a_low * b_high) - a_high * b_low);
}

/* Sign of a c - b d: -1, 0, 1; exact for magnitudes between 1e-140 and 1e140 (and 0): rounding is
 * monotone, so unequal rounded products are ordered rightly, and for equal ones the rounding errors
 * decide. */
QN_HD_INLINE int qni_determinant_sign(double a, double c, double b, double d) {
    const double p = a * c, q = b * d;
    if (p != q)
        return p > q ? 1 : -1;
    const double p_error = qni_product_error(a, c, p), q_error = qni_product_error(b, d, q);
    return p_error > q_error ? 1 : p_error < q_error ? -1 : 0;
}

/* Sign of the interpolant at the saddle of an ambiguous face.
 * above_0, above_1  values less iso of the two corners >= 0
 * below_0, below_1  values less iso of the two corners <  0 */
QN_HD_INLINE int qni_face_saddle_sign(double above_0, double above_1, double below_0,
                                      double below_1) {
    return qni_determinant_sign(above_0, above_1, below_0, below_1);
}

/* True when the two corners above the iso-value are joined through the middle of the face, that is,
 * when the segments cut off its lower corners. A saddle at the iso-value joins them: it counts as
 * above, like a sample there does. */
QN_HD_INLINE int qni_face_joins_above(int saddle_sign) {
    return saddle_sign >= 0;
}

#endif
