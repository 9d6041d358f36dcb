// SPDX-License-Identifier: MIT
/* One leaf of 8^3 cells as 64-bit masks: bit x + 8 y of slice z. Everything about which cells and
 * edges carry surface comes from these. */
#ifndef QNI_DMC_LEAF_HD_H
#define QNI_DMC_LEAF_HD_H

#include "core/hd.h"

#include <stdint.h>

/* corner[c][z]: the sign of corner c (x + 2 y) of each cell's lower square in slice z; slice 8
 * closes slice 7. */
typedef struct qni_leaf_masks {
    uint64_t corner[4][9];
} qni_leaf_masks;

/* Bits of the cells that exist, and of the edges at the cells' own corner that are inside the
 * lattice (those have four cells round them, hence a quad). All by slice, from how many cells the
 * leaf has along each axis and whether the leaf starts at the lattice's low end. */
typedef struct qni_leaf_extent {
    int cells[3];  /* 1 to 8 */
    int at_low[3]; /* 1: the leaf's first cell is the lattice's first */
} qni_leaf_extent;

QN_HD_INLINE void qni_leaf_masks_init(const uint16_t signs[9][9], qni_leaf_masks *masks) {
    for (int z = 0; z < 9; ++z) {
        uint64_t a = 0, b = 0;
        for (int y = 0; y < 8; ++y) {
            a |= (uint64_t)(signs[z][y] & 0xff) << (8 * y);
            b |= (uint64_t)(signs[z][y] >> 1 & 0xff) << (8 * y);
        }
        masks->corner[0][z] = a;
        masks->corner[1][z] = b;
        masks->corner[2][z] = a >> 8 | (uint64_t)(signs[z][8] & 0xff) << 56;
        masks->corner[3][z] = b >> 8 | (uint64_t)(signs[z][8] >> 1 & 0xff) << 56;
    }
}

QN_HD_INLINE uint64_t qni_columns(int first, int end) {
    const uint64_t row = (uint64_t)(((1u << end) - 1) & ~((1u << first) - 1));
    return row * UINT64_C(0x0101010101010101);
}

QN_HD_INLINE uint64_t qni_rows(int first, int end) {
    const uint64_t below_end = end == 8 ? ~UINT64_C(0) : (UINT64_C(1) << (8 * end)) - 1;
    return below_end & ~((UINT64_C(1) << (8 * first)) - 1);
}

QN_HD_INLINE uint64_t qni_cells_of_slice(const qni_leaf_extent *extent, int z) {
    return z < extent->cells[2] ? qni_columns(0, extent->cells[0]) & qni_rows(0, extent->cells[1])
                                : 0;
}

/* Cells of the slice with corners on both sides. */
QN_HD_INLINE uint64_t qni_active_of_slice(const qni_leaf_masks *masks,
                                          const qni_leaf_extent *extent, int z) {
    uint64_t any = 0, all = ~UINT64_C(0);
    for (int c = 0; c < 4; ++c) {
        any |= masks->corner[c][z] | masks->corner[c][z + 1];
        all &= masks->corner[c][z] & masks->corner[c][z + 1];
    }
    return any & ~all & qni_cells_of_slice(extent, z);
}

/* Crossed inner edges along `axis` from the lowest corner of the slice's cells. */
QN_HD_INLINE uint64_t qni_quads_of_slice(const qni_leaf_masks *masks, const qni_leaf_extent *extent,
                                         int axis, int z) {
    const uint64_t here = masks->corner[0][z];
    const uint64_t there = axis == 0   ? masks->corner[1][z]
                           : axis == 1 ? masks->corner[2][z]
                                       : masks->corner[0][z + 1];
    uint64_t inner = qni_cells_of_slice(extent, z);
    if (axis != 0 && extent->at_low[0])
        inner &= qni_columns(1, 8);
    if (axis != 1 && extent->at_low[1])
        inner &= qni_rows(1, 8);
    if (axis != 2 && extent->at_low[2] && z == 0)
        inner = 0;
    return (here ^ there) & inner;
}

/* The case of cell (x, y) of slice z: bit c is the sign of corner c. */
QN_HD_INLINE int qni_case_of_cell(const uint16_t signs[9][9], int x, int y, int z) {
    const int low_0 = signs[z][y] >> x & 3, low_1 = signs[z][y + 1] >> x & 3;
    const int high_0 = signs[z + 1][y] >> x & 3, high_1 = signs[z + 1][y + 1] >> x & 3;
    return low_0 | low_1 << 2 | high_0 << 4 | high_1 << 6;
}

#endif
