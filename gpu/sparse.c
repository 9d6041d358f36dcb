// SPDX-License-Identifier: MIT
/* Sparse volumes on their way to the device, and pass 1 over them. Which lattice leaves can hold
 * surface is found by walking the four rows of runs that a row of lattice leaves touches in step,
 * as scan_sparse.c does, without a look at any leaf's samples. */
#include "gpu/sparse.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "volume/field_rows.h"
#include "volume/sparse.h"

#include <math.h>
#include <stddef.h>

_Static_assert(sizeof(qni_gpu_run) == sizeof(qni_sparse_run) &&
                   offsetof(qni_gpu_run, leaf) == offsetof(qni_sparse_run, leaf) &&
                   offsetof(qni_gpu_run, value) == offsetof(qni_sparse_run, value),
               "runs go up as they are");
_Static_assert(sizeof(qni_gpu_row) == sizeof(qni_sparse_row), "rows go up as they are");

/* ---- leaves and runs ------------------------------------------------------------------------- */

static int64_t padded(int64_t count, size_t size) {
    return (count * (int64_t)size + 255) / 256 * 256;
}

/* The next part of a buffer, filled. */
static qn_status put(qni_gpu_job *job, char **at, const void *from, int64_t count, size_t size,
                     const void **part, qn_error *error) {
    qni_device *device = job->pool->device;
    void *to = *at;
    *part = to;
    *at += padded(count, size);
    return count > 0 ? device->upload(device, to, from, count * (int64_t)size, error) : QN_OK;
}

static qn_status upload_pool(qni_gpu_job *job, const qn_sparse_grid *grid, qn_error *error) {
    qni_device *device = job->pool->device;
    const int64_t bytes =
        grid->leaf_count * QNI_BLOCK_SAMPLES * (int64_t)qn_scalar_size(grid->scalar);
    void *memory = NULL;
    if (bytes > 0) {
        QN_TRY(qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_SAMPLES, bytes, &memory, error));
        QN_TRY(device->upload(device, memory, grid->values, bytes, error));
    }
    job->args.field.samples = memory;
    return QN_OK;
}

qn_status qni_gpu_upload_blocks(qni_gpu_job *job, qn_error *error) {
    const qni_sparse *sparse = job->field.sparse;
    qni_gpu_blocks *blocks = &job->args.field.blocks;
    const int64_t rows = sparse->row_count, runs = sparse->run_count,
                  leaves = sparse->grid.leaf_count;
    const void *part[4];
    void *memory;
    QN_TRY(upload_pool(job, &sparse->grid, error));
    QN_TRY(
        qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_BLOCKS,
                        padded(rows, sizeof(qni_sparse_row)) + padded(rows + 1, sizeof(int64_t)) +
                            padded(runs, sizeof(qni_sparse_run)) + padded(leaves, sizeof(uint32_t)),
                        &memory, error));
    char *at = memory;
    QN_TRY(put(job, &at, sparse->rows, rows, sizeof *sparse->rows, part, error));
    QN_TRY(put(job, &at, sparse->row_runs, rows + 1, sizeof(int64_t), part + 1, error));
    QN_TRY(put(job, &at, sparse->runs, runs, sizeof *sparse->runs, part + 2, error));
    QN_TRY(put(job, &at, sparse->order, leaves, sizeof(uint32_t), part + 3, error));
    blocks->rows = part[0];
    blocks->row_runs = part[1];
    blocks->runs = part[2];
    blocks->order = part[3];
    blocks->row_count = rows;
    blocks->background = sparse->grid.background;
    for (int a = 0; a < 2; ++a)
        for (blocks->key_bits[a] = 0; sparse->blocks[a] >> blocks->key_bits[a];)
            ++blocks->key_bits[a];
    return QN_OK;
}

/* ---- leaves that can hold surface ------------------------------------------------------------ */

/* What one of the four rows has at a place, and how far that goes. */
typedef struct stretch {
    int64_t until;
    bool is_leaf, above;
} stretch;

typedef struct lane {
    const qni_sparse_run *run, *end;
} lane;

static stretch look(const qni_field *field, lane *l, int64_t x) {
    stretch found = {INT64_MAX, false, false};
    double value = field->sparse->grid.background;
    while (l->run < l->end && l->run->end <= x)
        ++l->run;
    if (l->run < l->end && l->run->begin > x) {
        found.until = l->run->begin;
    } else if (l->run < l->end) {
        found.until = l->run->end;
        found.is_leaf = l->run->leaf >= 0;
        value = l->run->value;
    }
    found.above = !found.is_leaf && qni_field_settle(field, value) >= 0;
    return found;
}

static bool is_plain(const stretch now[4], const stretch next[4]) {
    for (int n = 0; n < 4; ++n)
        if (now[n].is_leaf || next[n].is_leaf || now[n].above != now[0].above ||
            next[n].above != now[0].above)
            return false;
    return true;
}

/* Where the walk along a row begins; -1 when no run touches it. */
static int64_t start_walk(const qni_sparse *sparse, const qni_sparse_row *at, lane lanes[4]) {
    int64_t first = INT64_MAX;
    for (int n = 0; n < 4; ++n) {
        const int64_t r =
            qni_sparse_find_row(sparse->rows, sparse->row_count, at->y + (n & 1), at->z + (n >> 1));
        lanes[n].run = sparse->runs + (r < 0 ? 0 : sparse->row_runs[r]);
        lanes[n].end = sparse->runs + (r < 0 ? 0 : sparse->row_runs[r + 1]);
        if (lanes[n].run < lanes[n].end && lanes[n].run->begin < first)
            first = lanes[n].run->begin;
    }
    return first == INT64_MAX ? -1 : first - 1;
}

/* The keys of a row of lattice leaves, written where `keys` is not NULL; how many. */
static int64_t list_row(const qni_field *field, const qni_gpu_blocks *blocks, int64_t row,
                        uint64_t *keys) {
    const qni_sparse_row *at = field->sparse->field_rows + row;
    stretch now[4], next[4];
    lane lanes[4];
    int64_t count = 0, x = start_walk(field->sparse, at, lanes);
    if (x < 0)
        return 0;
    for (int n = 0; n < 4; ++n)
        now[n] = look(field, lanes + n, x);
    while (x < field->leaves[0]) {
        int64_t until = INT64_MAX, to = x + 1;
        for (int n = 0; n < 4; ++n) {
            next[n] = look(field, lanes + n, x + 1);
            until = next[n].until < until ? next[n].until : until;
        }
        if (is_plain(now, next)) {
            if (until == INT64_MAX)
                break;
            to = until - 1;
        } else {
            if (keys)
                keys[count] = qni_gpu_key(blocks, x, at->y, at->z);
            ++count;
        }
        x = to;
        for (int n = 0; n < 4; ++n)
            now[n] = next[n];
    }
    return count;
}

/* Of all rows: the first key of each in `places`, which has one more entry for their sum. */
static void list_all(qn_context *context, const qni_gpu_job *job, int64_t *places, uint64_t *keys) {
    const qni_field *field = &job->field;
    const qni_gpu_blocks *blocks = &job->args.field.blocks;
    const int64_t rows = field->sparse->field_row_count;
#pragma omp parallel for schedule(dynamic, 64) num_threads(qn_context_threads(context))
    for (int64_t r = 0; r < rows; ++r) {
        const int64_t count = list_row(field, blocks, r, keys ? keys + places[r] : NULL);
        if (!keys)
            places[r] = count;
    }
    int64_t before = 0;
    for (int64_t r = 0; r < rows && !keys; ++r) {
        const int64_t count = places[r];
        places[r] = before;
        before += count;
    }
    if (!keys)
        places[rows] = before;
}

static qn_status upload_list(qn_context *context, qni_gpu_job *job, int64_t *places,
                             qn_error *error) {
    qni_device *device = job->pool->device;
    qni_gpu_blocks *blocks = &job->args.field.blocks;
    list_all(context, job, places, NULL);
    const int64_t count = places[job->field.sparse->field_row_count];
    uint64_t *keys = qni_alloc(context, count, sizeof *keys);
    void *memory;
    if (!keys)
        return qni_fail_memory(error, "the leaves that can hold surface");
    list_all(context, job, places, keys);
    qn_status status = qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_KEYS,
                                       (count + 1) * (int64_t)sizeof *keys, &memory, error);
    if (status == QN_OK && count > 0)
        status = device->upload(device, memory, keys, count * (int64_t)sizeof *keys, error);
    if (status == QN_OK)
        status = device->finish(device, error); /* before the list is freed */
    qni_free(context, keys, count, sizeof *keys);
    blocks->keys = memory;
    blocks->key_count = count;
    return status;
}

qn_status qni_gpu_upload_keys(qn_context *context, qni_gpu_job *job, qn_error *error) {
    const int64_t entries = job->field.sparse->field_row_count + 1;
    int64_t *places = qni_alloc_zero(context, entries, sizeof *places);
    if (!places)
        return qni_fail_memory(error, "the leaves that can hold surface");
    const qn_status status = upload_list(context, job, places, error);
    qni_free(context, places, entries, sizeof *places);
    return status;
}

/* ---- pass 1 ---------------------------------------------------------------------------------- */

static bool has_odd_values(const qni_sparse *sparse) {
    bool odd = !isfinite(sparse->grid.background);
    for (int64_t n = 0; n < sparse->run_count && !odd; ++n)
        odd = sparse->runs[n].leaf < 0 && !isfinite(sparse->runs[n].value);
    return odd;
}

qn_status qni_gpu_count_sparse(qn_context *context, qni_gpu_job *job, qn_error *error) {
    const qni_field *field = &job->field;
    bool odd = has_odd_values(field->sparse);
    if (!odd) {
        QN_TRY(qni_gpu_upload_keys(context, job, error));
        QN_TRY(qni_gpu_count_surface(job, error));
        odd = job->totals.nonfinite != 0;
    }
    if (!odd)
        return QN_OK;
    qni_field_measure_nonfinite(context, &job->field);
    job->args.field.nonfinite_distance = field->nonfinite_distance;
    QN_TRY(qni_gpu_upload_keys(context, job, error));
    return qni_gpu_count_surface(job, error);
}
