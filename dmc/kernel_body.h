// SPDX-License-Identifier: MIT
/* The inner loops of emission, included once for each instruction set (kernel_*.c) under another
 * name. The order of the stencil is that of place_hd.h. */
#include "dmc/dmc.h"
#include "dmc/place_hd.h"

#include <math.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

/* Where the stencil's rows of four and pairs start, from the cell's lowest corner in the tile. */
enum { STEP_Y = QNI_TILE, STEP_Z = QNI_TILE * QNI_TILE };
static const int row_start[4] = {-1, STEP_Y - 1, STEP_Z - 1, STEP_Y + STEP_Z - 1};
static const int pair_start[8] = {-STEP_Y, STEP_Z - STEP_Y, 2 * STEP_Y, 2 * STEP_Y + STEP_Z,
                                  -STEP_Z, STEP_Y - STEP_Z, 2 * STEP_Z, 2 * STEP_Z + STEP_Y};

#ifdef __AVX2__
/* Four lanes at once: loads along x, turned so that each stencil value lies across the lanes. */
static inline void gather_four(const double *const *corner, double (*stencil)[QNI_LANES],
                               int lane) {
    for (int r = 0; r < 4; ++r) {
        const __m256d a = _mm256_loadu_pd(corner[lane] + row_start[r]);
        const __m256d b = _mm256_loadu_pd(corner[lane + 1] + row_start[r]);
        const __m256d c = _mm256_loadu_pd(corner[lane + 2] + row_start[r]);
        const __m256d d = _mm256_loadu_pd(corner[lane + 3] + row_start[r]);
        const __m256d ab_even = _mm256_unpacklo_pd(a, b), ab_odd = _mm256_unpackhi_pd(a, b);
        const __m256d cd_even = _mm256_unpacklo_pd(c, d), cd_odd = _mm256_unpackhi_pd(c, d);
        _mm256_storeu_pd(&stencil[4 * r][lane], _mm256_permute2f128_pd(ab_even, cd_even, 0x20));
        _mm256_storeu_pd(&stencil[4 * r + 1][lane], _mm256_permute2f128_pd(ab_odd, cd_odd, 0x20));
        _mm256_storeu_pd(&stencil[4 * r + 2][lane], _mm256_permute2f128_pd(ab_even, cd_even, 0x31));
        _mm256_storeu_pd(&stencil[4 * r + 3][lane], _mm256_permute2f128_pd(ab_odd, cd_odd, 0x31));
    }
    for (int r = 0; r < 8; ++r) {
        const __m256d ac =
            _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(corner[lane] + pair_start[r])),
                                 _mm_loadu_pd(corner[lane + 2] + pair_start[r]), 1);
        const __m256d bd = _mm256_insertf128_pd(
            _mm256_castpd128_pd256(_mm_loadu_pd(corner[lane + 1] + pair_start[r])),
            _mm_loadu_pd(corner[lane + 3] + pair_start[r]), 1);
        _mm256_storeu_pd(&stencil[16 + 2 * r][lane], _mm256_unpacklo_pd(ac, bd));
        _mm256_storeu_pd(&stencil[17 + 2 * r][lane], _mm256_unpackhi_pd(ac, bd));
    }
}

static inline void gather_all(qni_point_batch *batch) {
    for (int lane = 0; lane < QNI_LANES; lane += 4)
        gather_four(batch->corner, batch->stencil, lane);
}
#else
static inline void gather_all(qni_point_batch *batch) {
    for (int lane = 0; lane < QNI_LANES; ++lane) {
        double stencil[QNI_STENCIL];
        qni_gather_stencil(batch->corner[lane], stencil);
        for (int n = 0; n < QNI_STENCIL; ++n)
            batch->stencil[n][lane] = stencil[n];
    }
}
#endif

qni_point_kernel KERNEL(qni_point);

void KERNEL(qni_point)(qni_point_batch *batch, const qni_frame *frame) {
    gather_all(batch);
#pragma omp simd
    for (int l = 0; l < QNI_LANES; ++l) {
#define S(n) batch->stencil[n][l]
        const qni_axis_point at =
            qni_point_of_one(S(1), S(2), S(5), S(6), S(9), S(10), S(13), S(14));
        batch->local[0][l] = at.x;
        batch->local[1][l] = at.y;
        batch->local[2][l] = at.z;
        batch->distance[l] = at.distance;
    }
#pragma omp simd
    for (int l = 0; l < QNI_LANES; ++l) {
        qni_placed result;
        QNI_PLACE(S, batch->cell[0][l], batch->cell[1][l], batch->cell[2][l], batch->local[0][l],
                  batch->local[1][l], batch->local[2][l], frame, result);
        batch->position[0][l] = result.px;
        batch->position[1][l] = result.py;
        batch->position[2][l] = result.pz;
        batch->normal[0][l] = result.nx;
        batch->normal[1][l] = result.ny;
        batch->normal[2][l] = result.nz;
        const float squares =
            (result.nx * result.nx + result.ny * result.ny) + result.nz * result.nz;
        batch->apart[l] = batch->distance[l] >= 2 || !(squares > 0.99f && squares < 1.01f);
#undef S
    }
}
