// SPDX-License-Identifier: MIT
/* A sparse volume from inside: rows of blocks of 8^3 samples along x, each row a sorted list of
 * runs. A run is either neighbouring leaves or a stretch of one value; what no run covers is
 * background. So the memory beside the leaves goes with the runs, and large tiles cost what their
 * face across x costs (after the run-length level sets of Houston et al., Hierarchical RLE level
 * set, 2006, with whole leaves in place of samples).
 *
 * Blocks are counted from the lattice's low corner, which lies one block below the lowest leaf or
 * tile; the lattice ends one block above the highest. So whatever happens, happens inside. */
#ifndef QNI_VOLUME_SPARSE_H
#define QNI_VOLUME_SPARSE_H

#include "volume/volume.h"

enum { QNI_BLOCK = 8, QNI_BLOCK_SAMPLES = QNI_BLOCK * QNI_BLOCK * QNI_BLOCK };

typedef struct qni_sparse_run {
    int32_t begin, end; /* blocks along x */
    int64_t leaf;       /* place in `order` of the first of its leaves; -1: one value */
    double value;
} qni_sparse_run;

typedef struct qni_sparse_row {
    int32_t y, z; /* blocks */
} qni_sparse_row;

typedef struct qni_sparse {
    qn_sparse_grid grid;
    int64_t first_block[3]; /* the lattice's low corner, in blocks of the index space */
    int64_t blocks[3];      /* of the lattice */
    uint32_t *order;        /* leaves by z, y, x: their places in the caller's arrays */
    qni_sparse_row *rows;   /* that hold runs, by z, then y */
    int64_t *row_runs;      /* [row_count + 1]: the first run of each row */
    int64_t row_count, row_capacity;
    qni_sparse_run *runs;
    int64_t run_count, run_capacity;
    qni_sparse_row *field_rows; /* rows of lattice leaves that touch a row with runs */
    int64_t field_row_count, field_row_capacity;
    int64_t filled_blocks;
} qni_sparse;

/* What a block holds: its leaf's samples, or NULL and one value. */
typedef struct qni_block {
    const char *samples;
    double value;
} qni_block;

/* The block at a place of the lattice; any place, also beyond its ends. */
qni_block qni_sparse_block(const qni_sparse *sparse, int64_t x, int64_t y, int64_t z);
/* A row with runs, or -1. */
int64_t qni_sparse_find_row(const qni_sparse_row *rows, int64_t row_count, int64_t y, int64_t z);
/* The samples of the leaf at a place of `order`. */
static inline const char *qni_sparse_leaf(const qni_sparse *sparse, int64_t place) {
    const size_t bytes = QNI_BLOCK_SAMPLES * qn_scalar_size(sparse->grid.scalar);
    return (const char *)sparse->grid.values + sparse->order[place] * bytes;
}
/* Index to world of the lattice whose point (0, 0, 0) is sample 8 * block. */
void qni_sparse_world(const qni_sparse *sparse, const int64_t block[3], double world[4][4]);

/* Sort the leaves and tiles into rows of runs (sparse_rows.c). */
qn_status qni_sparse_make_rows(qn_context *context, qni_sparse *sparse, qn_error *error);
void qni_sparse_destroy(qn_context *context, qni_sparse *sparse);

/* Shared with dense.c: fill in an identity for an all-zero matrix, and check it. */
qn_status qni_volume_settle_matrix(double matrix[4][4], qn_error *error);

#endif
