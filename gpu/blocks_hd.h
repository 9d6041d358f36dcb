// SPDX-License-Identifier: MIT
/* A sparse volume on the device: its leaves as the caller has them, one after another, and the rows
 * of runs of volume/sparse.h as they are. A block is found by two binary searches, of its row and
 * of its run. Lattice leaves that can hold surface are listed by key; a leaf's number is its place
 * in the list. */
#ifndef QNI_GPU_BLOCKS_HD_H
#define QNI_GPU_BLOCKS_HD_H

#include "core/hd.h"

#include <stdint.h>

/* As qni_sparse_run and qni_sparse_row. */
typedef struct qni_gpu_run {
    int32_t begin, end;
    int64_t leaf;
    double value;
} qni_gpu_run;

typedef struct qni_gpu_row {
    int32_t y, z;
} qni_gpu_row;

typedef struct qni_gpu_blocks {
    const qni_gpu_row *rows; /* by z, then y */
    const int64_t *row_runs; /* [row_count + 1] */
    const qni_gpu_run *runs;
    const uint32_t *order; /* of leaves: their places in the pool */
    int64_t row_count;
    double background;
    const uint64_t *keys; /* of lattice leaves that can hold surface, ascending; NULL: dense */
    int64_t key_count;
    int32_t key_bits[2]; /* of x and y */
} qni_gpu_blocks;

/* Where a block's 512 samples begin in the pool, or -1 and one value. */
typedef struct qni_gpu_block {
    int64_t at;
    double value;
} qni_gpu_block;

/* The row at (y, z), or -1. */
QN_HD_INLINE int64_t qni_gpu_find_row(const qni_gpu_blocks *blocks, int64_t y, int64_t z) {
    int64_t low = 0, high = blocks->row_count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        const qni_gpu_row row = blocks->rows[middle];
        if (row.z < z || (row.z == z && row.y < y))
            low = middle + 1;
        else
            high = middle;
    }
    return low < blocks->row_count && blocks->rows[low].z == z && blocks->rows[low].y == y ? low
                                                                                           : -1;
}

/* The block at a place of the lattice; any place, also beyond its ends. */
QN_HD_APART qni_gpu_block qni_gpu_find_block(const qni_gpu_blocks *blocks, int64_t x, int64_t y,
                                             int64_t z) {
    qni_gpu_block block = {-1, blocks->background};
    const int64_t row = qni_gpu_find_row(blocks, y, z);
    if (row < 0)
        return block;
    const int64_t end = blocks->row_runs[row + 1];
    int64_t low = blocks->row_runs[row], high = end;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (blocks->runs[middle].end <= x)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == end || blocks->runs[low].begin > x)
        return block;
    const qni_gpu_run run = blocks->runs[low];
    if (run.leaf < 0)
        block.value = run.value;
    else
        block.at = (int64_t)512 * blocks->order[run.leaf + (x - run.begin)];
    return block;
}

QN_HD_INLINE int64_t qni_gpu_place_in_block(int64_t x, int64_t y, int64_t z) {
    return (x & 7) + 8 * (y & 7) + 64 * (z & 7);
}

/* ---- lattice leaves -------------------------------------------------------------------------- */

QN_HD_INLINE uint64_t qni_gpu_key(const qni_gpu_blocks *blocks, int64_t x, int64_t y, int64_t z) {
    return ((uint64_t)z << blocks->key_bits[1] | (uint64_t)y) << blocks->key_bits[0] | (uint64_t)x;
}

QN_HD_INLINE void qni_gpu_leaf_of_key(const qni_gpu_blocks *blocks, uint64_t key, int32_t leaf[3]) {
    const int bits_x = blocks->key_bits[0], bits_y = blocks->key_bits[1];
    leaf[0] = (int32_t)(key & (((uint64_t)1 << bits_x) - 1));
    leaf[1] = (int32_t)(key >> bits_x & (((uint64_t)1 << bits_y) - 1));
    leaf[2] = (int32_t)(key >> (bits_x + bits_y));
}

/* The number of a leaf that is listed. */
QN_HD_APART int64_t qni_gpu_find_key(const qni_gpu_blocks *blocks, uint64_t key) {
    int64_t low = 0, high = blocks->key_count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (blocks->keys[middle] < key)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

#endif
