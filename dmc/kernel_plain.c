// SPDX-License-Identifier: MIT
/* The inner loops for any processor, and the choice among the builds. */
#define KERNEL(name) name##_plain
#include "dmc/kernel_body.h"
#include "dmc/landing_body.h"
#include "dmc/packing_body.h"
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

#define TABLE(set)                                                                                 \
    {                                                                                              \
#set, qni_point_##set, qni_meet_##set, qni_locate_##set, qni_land_##set,                   \
            qni_squeeze_##set, qni_number_##set                                                    \
    }

#if QNI_HAVE_AVX_KERNELS
qni_point_kernel qni_point_avx2, qni_point_avx512;
qni_meet_kernel qni_meet_avx2, qni_meet_avx512;
qni_locate_kernel qni_locate_avx2, qni_locate_avx512;
qni_land_kernel qni_land_avx2, qni_land_avx512;
qni_squeeze_kernel qni_squeeze_avx2, qni_squeeze_avx512;
qni_number_kernel qni_number_avx2, qni_number_avx512;

static const qni_kernels kernels[] = {TABLE(plain), TABLE(avx2), TABLE(avx512)};

static int count_kernels(void) {
    if (!__builtin_cpu_supports("avx2"))
        return 1;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512vl")
               ? 3
               : 2;
}
#else
static const qni_kernels kernels[] = {TABLE(plain)};

static int count_kernels(void) {
    return 1;
}
#endif

const qni_kernels *qni_kernels_at(int index) {
    return index < count_kernels() ? kernels + index : NULL;
}

const qni_kernels *qni_choose_kernels(void) {
    return kernels + count_kernels() - 1;
}
