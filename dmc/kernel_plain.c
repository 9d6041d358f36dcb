// SPDX-License-Identifier: MIT
/* The inner loops for any processor, and the choice among the builds. */
#define KERNEL_NAME qni_point_kernel_plain
#include "dmc/kernel_body.h"
#include "qni_config.h"

void qni_gather_stencil(const double *corner, double stencil[QNI_STENCIL]) {
    for (int r = 0; r < 4; ++r)
        for (int n = 0; n < 4; ++n)
            stencil[4 * r + n] = corner[row_start[r] + n];
    for (int r = 0; r < 8; ++r) {
        stencil[16 + 2 * r] = corner[pair_start[r]];
        stencil[17 + 2 * r] = corner[pair_start[r] + 1];
    }
}

void qni_place_point(const double stencil[QNI_STENCIL], const double cell[3], const double local[3],
                     const qni_frame *frame, float position[3], float normal[3]) {
    qni_placed result;
#define S(n) stencil[n]
    QNI_PLACE(S, cell[0], cell[1], cell[2], local[0], local[1], local[2], frame, result);
#undef S
    position[0] = result.px;
    position[1] = result.py;
    position[2] = result.pz;
    normal[0] = result.nx;
    normal[1] = result.ny;
    normal[2] = result.nz;
}

#if QNI_HAVE_AVX_KERNELS
void qni_point_kernel_avx2(qni_point_batch *batch, const qni_frame *frame);
void qni_point_kernel_avx512(qni_point_batch *batch, const qni_frame *frame);

qni_point_kernel qni_choose_point_kernel(void) {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        return qni_point_kernel_avx512;
    return __builtin_cpu_supports("avx2") ? qni_point_kernel_avx2 : qni_point_kernel_plain;
}
#else
qni_point_kernel qni_choose_point_kernel(void) {
    return qni_point_kernel_plain;
}
#endif
