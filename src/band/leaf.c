// SPDX-License-Identifier: MIT
#include "band/leaf.h"

static const int strides[3] = {1, 8, 64};

static bool share_a_ball(const double *distances, double voxel, int a, int b) {
    const double least = voxel * (1 + 1e-9);
    return distances[a] > least || distances[b] > least;
}

int qni_leaf_regions(const double distances[QNI_BAND_SAMPLES], double voxel,
                     int16_t regions[QNI_BAND_SAMPLES], int16_t first[QNI_BAND_SAMPLES]) {
    int16_t stack[QNI_BAND_SAMPLES];
    int count = 0;
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n)
        regions[n] = -1;
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n) {
        if (regions[n] >= 0)
            continue;
        int depth = 0;
        first[count] = (int16_t)n;
        regions[n] = (int16_t)count;
        stack[depth++] = (int16_t)n;
        while (depth > 0) {
            const int a = stack[--depth];
            for (int side = 0; side < 6; ++side) {
                const int stride = strides[side >> 1], at = a / stride & 7;
                if (at == (side & 1 ? 7 : 0))
                    continue;
                const int b = side & 1 ? a + stride : a - stride;
                if (regions[b] >= 0 || !share_a_ball(distances, voxel, a, b))
                    continue;
                regions[b] = (int16_t)count;
                stack[depth++] = (int16_t)b;
            }
        }
        ++count;
    }
    return count;
}

int64_t qni_leaf_tears(const double distances[QNI_BAND_SAMPLES], double voxel,
                       const bool inside[QNI_BAND_SAMPLES]) {
    int64_t tears = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int stride = strides[axis];
        for (int n = 0; n < QNI_BAND_SAMPLES; ++n)
            if ((n / stride & 7) < 7 && inside[n] != inside[n + stride])
                tears += share_a_ball(distances, voxel, n, n + stride);
    }
    return tears;
}
