// SPDX-License-Identifier: MIT
/* Sparse volumes: checking what a caller gives, the box, blocks by their place, counts. */
#include "volume/sparse.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* As for dense volumes: lattice coordinates are int32_t, a few are needed beyond the ends. */
static const int64_t largest_size = (INT64_C(1) << 31) - 16;

/* ---- checks ---------------------------------------------------------------------------------- */

static int64_t block_of(int64_t sample) {
    return (sample - (sample & 7)) / QNI_BLOCK;
}

static qn_status check_tile(const qn_sparse_tile *tile, int64_t n, qn_error *error) {
    for (int a = 0; a < 3; ++a) {
        const int64_t end = (int64_t)tile->origin[a] + tile->size[a];
        if (tile->origin[a] % QNI_BLOCK || tile->size[a] % QNI_BLOCK || tile->size[a] < QNI_BLOCK ||
            end > INT64_C(1) << 31)
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "tile %lld starts at %d and is %d long along axis %d: both must be "
                            "multiples of 8",
                            (long long)n, (int)tile->origin[a], (int)tile->size[a], a);
    }
    return QN_OK;
}

static void grow_box(int64_t low[3], int64_t high[3], const int32_t origin[3], int64_t a,
                     int64_t size) {
    const int64_t first = block_of(origin[a]), end = first + size / QNI_BLOCK;
    low[a] = first < low[a] ? first : low[a];
    high[a] = end > high[a] ? end : high[a];
}

/* The box of all leaves and tiles in blocks; empty: one block at the origin. */
static qn_status find_box(const qn_sparse_grid *grid, int64_t low[3], int64_t high[3],
                          qn_error *error) {
    for (int a = 0; a < 3; ++a) {
        low[a] = grid->leaf_count + grid->tile_count ? INT64_MAX : 0;
        high[a] = grid->leaf_count + grid->tile_count ? INT64_MIN : 1;
    }
    for (int64_t n = 0; n < grid->leaf_count; ++n)
        for (int a = 0; a < 3; ++a) {
            if (grid->origins[n][a] % QNI_BLOCK)
                return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                                "leaf %lld starts at %d %d %d: all must be multiples of 8",
                                (long long)n, (int)grid->origins[n][0], (int)grid->origins[n][1],
                                (int)grid->origins[n][2]);
            grow_box(low, high, grid->origins[n], a, QNI_BLOCK);
        }
    for (int64_t n = 0; n < grid->tile_count; ++n) {
        QN_TRY(check_tile(grid->tiles + n, n, error));
        for (int a = 0; a < 3; ++a)
            grow_box(low, high, grid->tiles[n].origin, a, grid->tiles[n].size[a]);
    }
    return QN_OK;
}

static int bits_of(int64_t count) {
    int bits = 0;
    for (; count >> bits; ++bits)
        ;
    return bits;
}

static qn_status set_box(qni_sparse *sparse, qn_grid *dense, qn_error *error) {
    int64_t low[3], high[3];
    int bits = 0;
    bool too_long = false;
    QN_TRY(find_box(&sparse->grid, low, high, error));
    for (int a = 0; a < 3; ++a) {
        sparse->first_block[a] = low[a] - 1;
        sparse->blocks[a] = high[a] - low[a] + 2;
        dense->size[a] = (high[a] - low[a]) * QNI_BLOCK;
        bits += bits_of(sparse->blocks[a]);
        too_long = too_long || sparse->blocks[a] * QNI_BLOCK + 1 > largest_size;
    }
    if (too_long || bits > 63)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "leaves and tiles spread over %lld x %lld x %lld samples: too far apart to "
                        "number; split the volume",
                        (long long)dense->size[0], (long long)dense->size[1],
                        (long long)dense->size[2]);
    qni_sparse_world(sparse, low, dense->index_to_world);
    return QN_OK;
}

/* Values of tiles and background are numbers of the leaves' type. */
static qn_status settle_value(qn_scalar scalar, double *value, qn_error *error) {
    bool fits = true;
    switch (scalar) {
    case QN_F32:
        *value = (double)(float)*value;
        break;
    case QN_F64:
    case QN_SCALAR_COUNT:
        break;
#define WHOLE(name, type)                                                                          \
    case QN_##name:                                                                                \
        fits = *value >= -2147483648.0 && *value <= 4294967295.0 &&                                \
               (double)(type)(int64_t)*value == *value;                                            \
        break;
        WHOLE(U8, uint8_t)
        WHOLE(I8, int8_t)
        WHOLE(U16, uint16_t)
        WHOLE(I16, int16_t)
        WHOLE(U32, uint32_t)
        WHOLE(I32, int32_t)
#undef WHOLE
    }
    if (!fits)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a tile or the background holds %g, which is no %s", *value,
                        qn_scalar_name(scalar));
    return QN_OK;
}

static qn_status check_grid(qni_sparse *sparse, qn_error *error) {
    qn_sparse_grid *grid = &sparse->grid;
    if (grid->scalar < 0 || grid->scalar >= QN_SCALAR_COUNT)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "%d is no scalar type",
                        (int)grid->scalar);
    if (grid->leaf_count < 0 || grid->leaf_count > UINT32_MAX || grid->tile_count < 0 ||
        grid->tile_count > UINT32_MAX)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "%lld leaves and %lld tiles: each must be from 0 to 2^32 - 1",
                        (long long)grid->leaf_count, (long long)grid->tile_count);
    if ((grid->leaf_count && (!grid->origins || !grid->values)) ||
        (grid->tile_count && !grid->tiles))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a sparse grid needs origins and values of its leaves, and its tiles");
    if ((uintptr_t)grid->values % qn_scalar_size(grid->scalar))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the leaves' values are not aligned to their type");
    grid->space[sizeof grid->space - 1] = 0;
    grid->unit[sizeof grid->unit - 1] = 0;
    grid->name[sizeof grid->name - 1] = 0;
    QN_TRY(qni_volume_settle_matrix(grid->index_to_world, error));
    for (int64_t n = 0; n < grid->tile_count; ++n) {
        double value = grid->tiles[n].value;
        QN_TRY(settle_value(grid->scalar, &value, error));
    }
    return settle_value(grid->scalar, &grid->background, error);
}

/* ---- the volume ------------------------------------------------------------------------------ */

void qni_sparse_world(const qni_sparse *sparse, const int64_t block[3], double world[4][4]) {
    memcpy(world, sparse->grid.index_to_world, sizeof sparse->grid.index_to_world);
    for (int r = 0; r < 3; ++r)
        for (int a = 0; a < 3; ++a)
            world[r][3] += world[r][a] * (double)(QNI_BLOCK * block[a]);
}

static qn_status set_up(qn_context *context, qn_volume *volume, qn_error *error) {
    qni_sparse *sparse = volume->sparse;
    const qn_sparse_grid *grid = &sparse->grid;
    volume->grid.scalar = grid->scalar;
    volume->grid.slope = 1;
    QN_TRY(check_grid(sparse, error));
    QN_TRY(set_box(sparse, &volume->grid, error));
    memcpy(volume->grid.space, grid->space, sizeof grid->space);
    memcpy(volume->grid.unit, grid->unit, sizeof grid->unit);
    return qni_sparse_make_rows(context, sparse, error);
}

qn_status qn_volume_create_sparse(qn_context *context, const qn_sparse_grid *grid,
                                  qn_release release, void *release_user, qn_volume **volume_out,
                                  qn_error *error) {
    *volume_out = NULL;
    qn_volume *volume = qni_alloc_zero(context, 1, sizeof *volume);
    if (!volume)
        return qni_fail_memory(error, "a volume");
    volume->context = context;
    volume->sparse = qni_alloc_zero(context, 1, sizeof *volume->sparse);
    qn_status status = QN_OK;
    if (!volume->sparse) {
        status = qni_fail_memory(error, "a sparse volume");
    } else {
        volume->sparse->grid = *grid;
        status = set_up(context, volume, error);
    }
    if (status != QN_OK) {
        qn_volume_destroy(volume); /* which has nothing to release yet */
        return status;
    }
    volume->release = release;
    volume->release_user = release_user;
    *volume_out = volume;
    return QN_OK;
}

void qni_sparse_destroy(qn_context *context, qni_sparse *sparse) {
    if (!sparse)
        return;
    qni_free(context, sparse->order, sparse->grid.leaf_count, sizeof *sparse->order);
    qni_free(context, sparse->rows, sparse->row_capacity, sizeof *sparse->rows);
    qni_free(context, sparse->row_runs, sparse->row_capacity + 1, sizeof *sparse->row_runs);
    qni_free(context, sparse->runs, sparse->run_capacity, sizeof *sparse->runs);
    qni_free(context, sparse->field_rows, sparse->field_row_capacity, sizeof *sparse->field_rows);
    qni_free(context, sparse, 1, sizeof *sparse);
}

const qn_sparse_grid *qn_volume_sparse_grid(const qn_volume *volume) {
    return volume->sparse ? &volume->sparse->grid : NULL;
}

qn_status qn_volume_sparse_info(qn_context *context, const qn_volume *volume, qn_sparse_info *info,
                                qn_error *error) {
    (void)context;
    memset(info, 0, sizeof *info);
    const qni_sparse *sparse = volume->sparse;
    if (!sparse)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "the volume is dense");
    info->leaf_count = sparse->grid.leaf_count;
    info->tile_count = sparse->grid.tile_count;
    info->filled_blocks = sparse->filled_blocks;
    for (int a = 0; a < 3; ++a) {
        info->low[a] = (sparse->first_block[a] + 1) * QNI_BLOCK;
        info->high[a] = info->low[a] + volume->grid.size[a] - 1;
    }
    info->active_count = sparse->grid.masks ? 0 : info->leaf_count * QNI_BLOCK_SAMPLES;
    for (int64_t n = 0; sparse->grid.masks && n < info->leaf_count; ++n)
        for (int w = 0; w < 8; ++w)
            info->active_count += __builtin_popcountll(sparse->grid.masks[n][w]);
    for (int64_t n = 0; n < info->tile_count; ++n) {
        const qn_sparse_tile *tile = sparse->grid.tiles + n;
        int64_t samples = (int64_t)tile->size[0] * tile->size[1];
        if (tile->active &&
            (__builtin_mul_overflow(samples, tile->size[2], &samples) ||
             __builtin_add_overflow(info->active_count, samples, &info->active_count)))
            info->active_count = INT64_MAX;
    }
    return QN_OK;
}

/* ---- blocks by their place ------------------------------------------------------------------- */

int64_t qni_sparse_find_row(const qni_sparse_row *rows, int64_t row_count, int64_t y, int64_t z) {
    int64_t low = 0, high = row_count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (rows[middle].z < z || (rows[middle].z == z && rows[middle].y < y))
            low = middle + 1;
        else
            high = middle;
    }
    return low < row_count && rows[low].z == z && rows[low].y == y ? low : -1;
}

qni_block qni_sparse_block(const qni_sparse *sparse, int64_t x, int64_t y, int64_t z) {
    qni_block block = {NULL, sparse->grid.background};
    const int64_t row = qni_sparse_find_row(sparse->rows, sparse->row_count, y, z);
    if (row < 0)
        return block;
    int64_t low = sparse->row_runs[row], high = sparse->row_runs[row + 1];
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (sparse->runs[middle].end <= x)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == sparse->row_runs[row + 1] || sparse->runs[low].begin > x)
        return block;
    const qni_sparse_run *run = sparse->runs + low;
    if (run->leaf < 0)
        block.value = run->value;
    else
        block.samples = qni_sparse_leaf(sparse, run->leaf + (x - run->begin));
    return block;
}
