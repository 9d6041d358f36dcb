// SPDX-License-Identifier: MIT
/* Back onto the trilinear surface: the arithmetic of project.c that needs no field, for the
 * processor and the GPU. */
#ifndef QNI_DMC_PROJECT_HD_H
#define QNI_DMC_PROJECT_HD_H

#include "dmc/vertex_hd.h"

#include <math.h>
#include <stddef.h>

QN_HD static inline void qni_slope_of_values(const double d[8], const double local[3],
                                             double slope[3]) {
    for (int a = 0; a < 3; ++a) {
        const int p = a == 0 ? 1 : 0, q = a == 2 ? 1 : 2;
        double rise[4];
        for (int n = 0; n < 4; ++n) {
            const int c = ((n & 1) << p) | ((n >> 1) << q);
            rise[n] = d[c | 1 << a] - d[c];
        }
        slope[a] = qni_bilinear(rise[0], rise[1], rise[2], rise[3], local[p], local[q]);
    }
}

/* Axes by falling size of the slope. */
QN_HD static inline void qni_sort_axes(const double slope[3], int order[3]) {
    const double x = fabs(slope[0]), y = fabs(slope[1]), z = fabs(slope[2]);
    order[0] = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    const int p = order[0] == 0 ? 1 : 0, q = order[0] == 2 ? 1 : 2;
    const int swap = fabs(slope[p]) < fabs(slope[q]);
    order[1] = swap ? q : p;
    order[2] = swap ? p : q;
}

/* Values at the two ends of the axis line through `local`. */
QN_HD static inline void qni_line_ends(const double d[8], int axis, const double local[3],
                                       double end[2]) {
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    for (int side = 0; side < 2; ++side) {
        const double *c = d + (side << axis);
        end[side] =
            qni_bilinear(c[0], c[1 << p], c[1 << q], c[(1 << p) | (1 << q)], local[p], local[q]);
    }
}

/* The zero between the ends, if they cross it with the slope asked for; else negative. */
QN_HD_INLINE double qni_crossing_of_line(const double end[2], double slope) {
    const int crosses =
        slope > 0 ? end[0] < 0 && end[1] >= 0 : slope < 0 && end[0] >= 0 && end[1] < 0;
    return crosses ? end[0] / (end[0] - end[1]) : -1;
}

/* The middle between two vertices and their mean normal; 0 where there are no normals. */
QN_HD static inline void qni_middle_of_pair(const float *positions, const float *normals,
                                            uint32_t first, uint32_t second, float position[3],
                                            float normal[3]) {
    const float *p = positions + 3 * (size_t)first, *q = positions + 3 * (size_t)second;
    for (int a = 0; a < 3; ++a) {
        position[a] = 0.5f * p[a] + 0.5f * q[a];
        normal[a] = 0;
    }
    if (!normals)
        return;
    const float *n = normals + 3 * (size_t)first, *m = normals + 3 * (size_t)second;
    const float sum[3] = {n[0] + m[0], n[1] + m[1], n[2] + m[2]};
    const float squares = (sum[0] * sum[0] + sum[1] * sum[1]) + sum[2] * sum[2];
    const int good = squares > 1e-6f; /* else they are opposite: the kept one is as good as any */
    const float scale = good ? 1 / sqrtf(squares) : 0;
    for (int a = 0; a < 3; ++a)
        normal[a] = good ? sum[a] * scale : n[a];
}

/* A unit normal moved by `share` of the way from that of x to that of y. */
QN_HD_INLINE void qni_turn_between(const float *normals, uint32_t x, uint32_t y, float share,
                                   float normal[3]) {
    const float *n = normals + 3 * (size_t)x, *m = normals + 3 * (size_t)y;
    float sum[3];
    for (int a = 0; a < 3; ++a)
        sum[a] = normal[a] + share * (m[a] - n[a]);
    const float squares = (sum[0] * sum[0] + sum[1] * sum[1]) + sum[2] * sum[2];
    const float scale = squares > 1e-6f ? 1 / sqrtf(squares) : 0;
    for (int a = 0; a < 3 && scale > 0; ++a)
        normal[a] = sum[a] * scale;
}

/* From the middle of a merged pair along the line from X to Y until it is equally far from both:
 * the quads beside it become squarer, and where they lie more evenly the interpolant is nearer to
 * what was sampled. The normal turns as it does from X to Y. */
QN_HD_INLINE void qni_move_between(const float *positions, const float *normals, uint32_t x,
                                   uint32_t y, float position[3], float normal[3]) {
    const float *p = positions + 3 * (size_t)x, *q = positions + 3 * (size_t)y;
    double way[3], along = 0, squares = 0;
    for (int a = 0; a < 3; ++a) {
        way[a] = (double)q[a] - (double)p[a];
        along += way[a] * ((double)position[a] - 0.5 * ((double)p[a] + (double)q[a]));
        squares += way[a] * way[a];
    }
    if (!(squares > 0))
        return;
    const double share = -along / squares;
    for (int a = 0; a < 3; ++a)
        position[a] = (float)((double)position[a] + share * way[a]);
    if (normals)
        qni_turn_between(normals, x, y, (float)share, normal);
}

#endif
