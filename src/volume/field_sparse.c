// SPDX-License-Identifier: MIT
/* Sparse fields: values and tiles of values from blocks, non-finite samples. Scans of rows are in
 * scan_sparse.c. Every value is the one that a dense grid of the same samples would give. */
#include "volume/field_sparse.h"
#include "volume/field_rows.h"

#include <math.h>
#include <string.h>

void qni_sparse_field_init(const qni_sparse *sparse, qni_field *field) {
    double world[4][4];
    field->sparse = sparse;
    for (int a = 0; a < 3; ++a) {
        field->leaves[a] = sparse->blocks[a];
        field->cells[a] = sparse->blocks[a] * QNI_LEAF;
        field->samples[a] = field->cells[a] + 1;
    }
    qni_sparse_world(sparse, sparse->first_block, world);
    memcpy(field->world, world, sizeof field->world);
    qni_field_set_threshold(field);
    field->direct = true;
}

/* ---- values ---------------------------------------------------------------------------------- */

/* `count` neighbouring samples of a block, from place `at` of its 512 on. */
static void load_values(const qni_field *field, const qni_block *block, int at, int count,
                        double *out) {
    const qn_scalar scalar = field->grid->scalar;
    if (!block->samples) {
        const double value = qni_field_settle(field, block->value);
        for (int n = 0; n < count; ++n)
            out[n] = value;
        return;
    }
    qni_samples_load(scalar, block->samples + (size_t)at * qn_scalar_size(scalar), count, out);
    if (field->nonfinite_distance > 0 || scalar == QN_F64) {
        for (int n = 0; n < count; ++n)
            out[n] = qni_field_settle(field, out[n]);
    } else {
        for (int n = 0; n < count; ++n)
            out[n] = out[n] - field->isovalue;
    }
}

static int place_of(int64_t x, int64_t y, int64_t z) {
    return (int)((x & 7) + 8 * (y & 7) + 64 * (z & 7));
}

double qni_sparse_field_value(const qni_field *field, int64_t x, int64_t y, int64_t z) {
    const qni_block block = qni_sparse_block(field->sparse, x >> 3, y >> 3, z >> 3);
    double value;
    load_values(field, &block, place_of(x, y, z), 1, &value);
    return value;
}

void qni_sparse_field_load_cell(const qni_field *field, const int64_t cell[3], double corner[8]) {
    if ((cell[0] & 7) == 7 || (cell[1] & 7) == 7 || (cell[2] & 7) == 7) {
        for (int c = 0; c < 8; ++c)
            corner[c] = qni_sparse_field_value(field, cell[0] + (c & 1), cell[1] + (c >> 1 & 1),
                                               cell[2] + (c >> 2));
        return;
    }
    const qni_block block =
        qni_sparse_block(field->sparse, cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
    const int at = place_of(cell[0], cell[1], cell[2]);
    for (int n = 0; n < 4; ++n)
        load_values(field, &block, at + 8 * (n & 1) + 64 * (n >> 1), 2, corner + 2 * n);
}

/* ---- tiles ----------------------------------------------------------------------------------- */

/* The blocks x - 1, x and x + 1 of a row. */
static void find_three(const qni_sparse *sparse, int64_t x, int64_t y, int64_t z,
                       qni_block three[3]) {
    const int64_t row = qni_sparse_find_row(sparse->rows, sparse->row_count, y, z);
    for (int n = 0; n < 3; ++n)
        three[n] = (qni_block){NULL, sparse->grid.background};
    if (row < 0)
        return;
    int64_t low = sparse->row_runs[row], high = sparse->row_runs[row + 1];
    const int64_t end = high;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (sparse->runs[middle].end <= x - 1)
            low = middle + 1;
        else
            high = middle;
    }
    for (int n = 0; n < 3; ++n) {
        const int64_t at = x - 1 + n;
        while (low < end && sparse->runs[low].end <= at)
            ++low;
        if (low == end || sparse->runs[low].begin > at)
            continue;
        const qni_sparse_run *run = sparse->runs + low;
        if (run->leaf < 0)
            three[n].value = run->value;
        else
            three[n].samples = qni_sparse_leaf(sparse, run->leaf + (at - run->begin));
    }
}

/* A tile takes the last layer of the block before, eight of its own, two of the block after: where
 * each begins in the tile, where it ends, and which of the block's layers comes first. */
static const int span_begin[4] = {0, 1, 9, 11};
static const int span_layer[3] = {7, 0, 0};

void qni_sparse_field_load_tile(const qni_field *field, const int32_t leaf[3],
                                double tile[QNI_TILE][QNI_TILE][QNI_TILE]) {
    for (int bz = 0; bz < 3; ++bz)
        for (int by = 0; by < 3; ++by) {
            qni_block three[3];
            find_three(field->sparse, leaf[0], (int64_t)leaf[1] - 1 + by, (int64_t)leaf[2] - 1 + bz,
                       three);
            for (int z = span_begin[bz]; z < span_begin[bz + 1]; ++z)
                for (int y = span_begin[by]; y < span_begin[by + 1]; ++y) {
                    const int at = 8 * (y - span_begin[by] + span_layer[by]) +
                                   64 * (z - span_begin[bz] + span_layer[bz]);
                    load_values(field, three, at + 7, 1, tile[z][y]);
                    load_values(field, three + 1, at, 8, tile[z][y] + 1);
                    load_values(field, three + 2, at, 2, tile[z][y] + 9);
                }
        }
}

/* ---- non-finite samples ---------------------------------------------------------------------- */

int64_t qni_sparse_field_part_count(const qni_field *field) {
    return field->sparse->row_count + 1; /* the last one is the background */
}

static void count_value(const qni_field *field, double value, int64_t times,
                        qni_nonfinite_count *count) {
    if (isnan(value))
        count->nan_count += times;
    else if (isinf(value))
        count->infinite_count += times;
    else
        count->largest = fmax(count->largest, fabs(value - field->isovalue));
}

qni_nonfinite_count qni_sparse_field_count_part(const qni_field *field, int64_t part) {
    const qni_sparse *sparse = field->sparse;
    qni_nonfinite_count count = {0, 0, 0};
    if (part == sparse->row_count) {
        count_value(field, sparse->grid.background, 0, &count);
        return count;
    }
    for (int64_t n = sparse->row_runs[part]; n < sparse->row_runs[part + 1]; ++n) {
        const qni_sparse_run *run = sparse->runs + n;
        const int64_t blocks = run->end - run->begin;
        if (run->leaf < 0)
            count_value(field, run->value, blocks * QNI_BLOCK_SAMPLES, &count);
        for (int64_t b = 0; run->leaf >= 0 && b < blocks; ++b) {
            double values[QNI_BLOCK_SAMPLES];
            qni_samples_load(sparse->grid.scalar, qni_sparse_leaf(sparse, run->leaf + b),
                             QNI_BLOCK_SAMPLES, values);
            for (int s = 0; s < QNI_BLOCK_SAMPLES; ++s)
                count_value(field, values[s], 1, &count);
        }
    }
    return count;
}
