// SPDX-License-Identifier: MIT
/* The shape of a quad, and the square it would like to be: what relaxation measures and aims at. */
#ifndef QNI_DMC_RELAX_HD_H
#define QNI_DMC_RELAX_HD_H

#include "core/hd.h"

/* n x v, the vector turned by a right angle about a unit normal when it lies across it. */
QN_HD_INLINE void qni_turn(const float n[3], const float v[3], float out[3]) {
    out[0] = n[1] * v[2] - n[2] * v[1];
    out[1] = n[2] * v[0] - n[0] * v[2];
    out[2] = n[0] * v[1] - n[1] * v[0];
}

QN_HD_INLINE float qni_dot(const float u[3], const float v[3]) {
    return (u[0] * v[0] + u[1] * v[1]) + u[2] * v[2];
}

/* [DMC21] equation (9), the least over the corners of 2 area / (sum of the two squared sides), but
 * with the area that is seen from the normal, so that folded and turned corners are negative. */
QN_HD_INLINE float qni_quad_shape(const float *corner[4], const float normal[3]) {
    float least = 1;
    for (int k = 0; k < 4; ++k) {
        const float *p = corner[k], *a = corner[(k + 1) & 3], *b = corner[(k + 3) & 3];
        const float u[3] = {a[0] - p[0], a[1] - p[1], a[2] - p[2]},
                    v[3] = {b[0] - p[0], b[1] - p[1], b[2] - p[2]};
        float across[3];
        qni_turn(u, v, across);
        const float squares = qni_dot(u, u) + qni_dot(v, v);
        const float shape = squares > 0 ? 2 * qni_dot(across, normal) / squares : 0;
        least = shape < least ? shape : least;
    }
    return least;
}

/* Corner k of the square that is nearest to the quad in the plane across the normal, about the
 * quad's middle: the corners' arms from the middle, turned back onto that of corner k, are
 * averaged. */
QN_HD_INLINE void qni_square_corner(const float *corner[4], const float normal[3], int k,
                                    float out[3]) {
    float middle[3], cross_arm[3], turned[3];
    for (int a = 0; a < 3; ++a) {
        middle[a] = 0.25f * ((corner[0][a] + corner[1][a]) + (corner[2][a] + corner[3][a]));
        cross_arm[a] = corner[(k + 3) & 3][a] -
                       corner[(k + 1) & 3][a]; /* a quarter before less a quarter after */
    }
    qni_turn(normal, cross_arm, turned);
    for (int a = 0; a < 3; ++a)
        out[a] = middle[a] + 0.25f * (corner[k][a] - corner[(k + 2) & 3][a] + turned[a]);
}

#endif
