// SPDX-License-Identifier: MIT
/* From a vertex's place in its cell to the world: its position, and its normal by central
 * differences of the 32 samples at and round the cell.
 *
 * Stencil order: 0-15 the four rows along x at (y, z) = (0,0) (1,0) (0,1) (1,1), each x = -1, 0, 1,
 * 2; 16-19 y = -1: (x, z) = (0,0) (1,0) (0,1) (1,1); 20-23 y = 2 likewise; 24-27 z = -1: (x, y) =
 * (0,0) (1,0) (0,1) (1,1); 28-31 z = 2 likewise. */
#ifndef QNI_DMC_PLACE_HD_H
#define QNI_DMC_PLACE_HD_H

#include "dmc/frame_hd.h"
#include "dmc/vertex_hd.h"

#include <math.h>

/* Which stencil values are the cell's own corners. */
QN_HD_INLINE int qni_corner_of_stencil(int corner) {
    return (corner & 1) + 1 + 4 * (corner >> 1);
}

/* Where a stencil value is, from the cell's lowest corner, in an array whose lines along x are
 * `line` apart and whose slices are `slice` apart. */
QN_HD_INLINE int qni_stencil_offset(int n, int line, int slice) {
    if (n < 16)
        return (n & 3) - 1 + (n >> 2 & 1) * line + (n >> 3) * slice;
    const int beside = n < 24 ? line : slice, other = n < 24 ? slice : line;
    return (n & 1) + (n >> 1 & 1) * other + ((n & 7) < 4 ? -beside : 2 * beside);
}

typedef struct qni_placed {
    float px, py, pz, nx, ny, nz;
} qni_placed;

/* World position of the local point (u, v, w) and the unit normal there. `s(n)` is stencil value n.
 */
#define QNI_PLACE(s, cx, cy, cz, u, v, w, frame, result)                                           \
    do {                                                                                           \
        const double gx = qni_central_gradient(qni_bilinear(s(0), s(4), s(8), s(12), v, w),        \
                                               qni_bilinear(s(1), s(5), s(9), s(13), v, w),        \
                                               qni_bilinear(s(2), s(6), s(10), s(14), v, w),       \
                                               qni_bilinear(s(3), s(7), s(11), s(15), v, w), u);   \
        const double gy = qni_central_gradient(qni_bilinear(s(16), s(17), s(18), s(19), u, w),     \
                                               qni_bilinear(s(1), s(2), s(9), s(10), u, w),        \
                                               qni_bilinear(s(5), s(6), s(13), s(14), u, w),       \
                                               qni_bilinear(s(20), s(21), s(22), s(23), u, w), v); \
        const double gz = qni_central_gradient(qni_bilinear(s(24), s(25), s(26), s(27), u, v),     \
                                               qni_bilinear(s(1), s(2), s(5), s(6), u, v),         \
                                               qni_bilinear(s(9), s(10), s(13), s(14), u, v),      \
                                               qni_bilinear(s(28), s(29), s(30), s(31), u, v), w); \
        const double x = (cx) + (u), y = (cy) + (v), z = (cz) + (w);                               \
        const double(*m)[4] = (frame)->world;                                                      \
        const double(*q)[3] = (frame)->normal;                                                     \
        (result).px = (float)((m[0][0] * x + m[0][1] * y) + (m[0][2] * z + m[0][3]));              \
        (result).py = (float)((m[1][0] * x + m[1][1] * y) + (m[1][2] * z + m[1][3]));              \
        (result).pz = (float)((m[2][0] * x + m[2][1] * y) + (m[2][2] * z + m[2][3]));              \
        const double nx = (q[0][0] * gx + q[0][1] * gy) + q[0][2] * gz;                            \
        const double ny = (q[1][0] * gx + q[1][1] * gy) + q[1][2] * gz;                            \
        const double nz = (q[2][0] * gx + q[2][1] * gy) + q[2][2] * gz;                            \
        const double scale = 1 / sqrt((nx * nx + ny * ny) + nz * nz);                              \
        (result).nx = (float)(nx * scale);                                                         \
        (result).ny = (float)(ny * scale);                                                         \
        (result).nz = (float)(nz * scale);                                                         \
    } while (0)

/* Where central differences cancel, the trilinear gradient in the cell, or at last the way from its
 * upper to its lower corners, still says which way is out. */
QN_HD static inline void qni_mend_normal(const double d[8], const double local[3],
                                         const qni_frame *frame, float normal[3]) {
    double g[3], largest = 0;
    for (int attempt = 0; attempt < 2 && largest == 0; ++attempt) {
        for (int a = 0; a < 3; ++a) {
            const int p = a == 0 ? 1 : 0, q = a == 2 ? 1 : 2;
            double rise[4];
            for (int n = 0; n < 4; ++n) {
                const int c = ((n & 1) << p) | ((n >> 1) << q), e = c | (1 << a);
                rise[n] = attempt == 0 ? d[e] - d[c] : (double)((d[e] >= 0) - (d[c] >= 0));
            }
            g[a] = attempt == 0
                       ? qni_bilinear(rise[0], rise[1], rise[2], rise[3], local[p], local[q])
                       : ((rise[0] + rise[1]) + (rise[2] + rise[3]));
            largest = fmax(largest, fabs(g[a]));
        }
        if (!(largest - largest == 0)) /* not finite */
            largest = 0;
    }
    if (largest == 0) {
        g[0] = g[1] = 0;
        g[2] = largest = 1;
    }
    double n[3], squares = 0;
    for (int r = 0; r < 3; ++r) {
        n[r] = 0;
        for (int a = 0; a < 3; ++a)
            n[r] += frame->normal[r][a] * (g[a] / largest);
        squares += n[r] * n[r];
    }
    for (int r = 0; r < 3; ++r)
        normal[r] = (float)(n[r] / sqrt(squares));
}

QN_HD_INLINE int qni_is_unit(const float normal[3]) {
    float squares = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    return squares > 0.99f && squares < 1.01f;
}

#endif
