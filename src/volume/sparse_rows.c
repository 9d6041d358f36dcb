// SPDX-License-Identifier: MIT
/* Rows of runs from leaves and tiles in any order: list a key for each leaf and each row of a tile,
 * sort, join neighbours, fill the gaps inside a level set. */
#include "volume/sparse.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };
static const int64_t most_tile_rows = INT64_C(1) << 26;

/* A leaf, or one row of a tile: its first block, packed so that keys sort by z, y, x. */
typedef struct entry {
    uint64_t key;
    uint32_t source; /* in the caller's arrays */
    uint32_t is_tile;
} entry;

typedef struct builder {
    qn_context *context;
    qni_sparse *sparse;
    entry *entries, *spare;
    int64_t count;
    int bits[3];
    int64_t leaves; /* put into `order` so far */
} builder;

static int bits_of(int64_t count) {
    int bits = 0;
    for (; count >> bits; ++bits)
        ;
    return bits;
}

static uint64_t pack(const builder *b, int64_t x, int64_t y, int64_t z) {
    return ((uint64_t)z << b->bits[1] | (uint64_t)y) << b->bits[0] | (uint64_t)x;
}

static void unpack(const builder *b, uint64_t key, int32_t at[3]) {
    at[0] = (int32_t)(key & ((UINT64_C(1) << b->bits[0]) - 1));
    at[1] = (int32_t)(key >> b->bits[0] & ((UINT64_C(1) << b->bits[1]) - 1));
    at[2] = (int32_t)(key >> (b->bits[0] + b->bits[1]));
}

static bool is_sorted(const entry *entries, int64_t count) {
    for (int64_t n = 1; n < count; ++n)
        if (entries[n].key < entries[n - 1].key)
            return false;
    return true;
}

/* By digits from the lowest up, each pass keeping the order of the one before. */
static void sort_entries(builder *b) {
    const int bits = b->bits[0] + b->bits[1] + b->bits[2];
    if (is_sorted(b->entries, b->count))
        return;
    for (int shift = 0; shift < bits; shift += DIGIT_BITS) {
        int64_t place[DIGITS] = {0}, sum = 0;
        for (int64_t n = 0; n < b->count; ++n)
            ++place[b->entries[n].key >> shift & (DIGITS - 1)];
        for (int d = 0; d < DIGITS; ++d) {
            const int64_t here = place[d];
            place[d] = sum;
            sum += here;
        }
        for (int64_t n = 0; n < b->count; ++n)
            b->spare[place[b->entries[n].key >> shift & (DIGITS - 1)]++] = b->entries[n];
        entry *sorted = b->spare;
        b->spare = b->entries;
        b->entries = sorted;
    }
}

/* ---- listing --------------------------------------------------------------------------------- */

static int64_t lattice_block(const qni_sparse *sparse, int axis, int64_t sample) {
    return (sample - sparse->first_block[axis] * QNI_BLOCK) / QNI_BLOCK;
}

static qn_status count_entries(builder *b, qn_error *error) {
    const qn_sparse_grid *grid = &b->sparse->grid;
    int64_t rows = 0;
    for (int64_t n = 0; n < grid->tile_count && rows <= most_tile_rows; ++n) {
        const int32_t *size = grid->tiles[n].size;
        rows += (int64_t)(size[1] / QNI_BLOCK) * (size[2] / QNI_BLOCK);
    }
    if (rows > most_tile_rows)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the tiles span more than %lld rows of 8^3 blocks: leave out those far "
                        "from any leaf",
                        (long long)most_tile_rows);
    b->count = grid->leaf_count + rows;
    return QN_OK;
}

static void list_tile(builder *b, int64_t n, entry **to) {
    const qni_sparse *sparse = b->sparse;
    const qn_sparse_tile *tile = sparse->grid.tiles + n;
    int64_t at[3];
    for (int a = 0; a < 3; ++a)
        at[a] = lattice_block(sparse, a, tile->origin[a]);
    for (int64_t z = 0; z < tile->size[2] / QNI_BLOCK; ++z)
        for (int64_t y = 0; y < tile->size[1] / QNI_BLOCK; ++y)
            *(*to)++ = (entry){pack(b, at[0], at[1] + y, at[2] + z), (uint32_t)n, 1};
}

static void list_entries(builder *b) {
    const qni_sparse *sparse = b->sparse;
    entry *to = b->entries;
    for (int64_t n = 0; n < sparse->grid.leaf_count; ++n) {
        const int32_t *origin = sparse->grid.origins[n];
        *to++ =
            (entry){pack(b, lattice_block(sparse, 0, origin[0]),
                         lattice_block(sparse, 1, origin[1]), lattice_block(sparse, 2, origin[2])),
                    (uint32_t)n, 0};
    }
    for (int64_t n = 0; n < sparse->grid.tile_count; ++n)
        list_tile(b, n, &to);
}

/* ---- runs ------------------------------------------------------------------------------------ */

static double sample_value(qn_scalar scalar, const char *at) {
    switch (scalar) {
#define SAMPLE_VALUE(name, type, text)                                                             \
    case QN_##name: {                                                                              \
        type value;                                                                                \
        memcpy(&value, at, sizeof value);                                                          \
        return (double)value;                                                                      \
    }
        QN_SCALAR_MAP(SAMPLE_VALUE)
#undef SAMPLE_VALUE
    case QN_SCALAR_COUNT:
        break;
    }
    return 0;
}

/* All samples of the run's last (or first) layer across x are inside. */
static bool end_is_inside(const qni_sparse *sparse, const qni_sparse_run *run, bool last) {
    if (run->leaf < 0)
        return run->value < 0;
    const char *samples =
        qni_sparse_leaf(sparse, last ? run->leaf + (run->end - run->begin - 1) : run->leaf);
    const size_t size = qn_scalar_size(sparse->grid.scalar);
    for (size_t line = 0; line < QNI_BLOCK * QNI_BLOCK; ++line)
        if (!(sample_value(sparse->grid.scalar,
                           samples + (line * QNI_BLOCK + (last ? QNI_BLOCK - 1 : 0)) * size) < 0))
            return false;
    return true;
}

/* The value rule for gaps of level sets (qn/volume.h). */
static bool gap_is_inside(const qni_sparse *sparse, const qni_sparse_run *before,
                          const qni_sparse_run *after) {
    return sparse->grid.kind == QN_SPARSE_LEVEL_SET && sparse->grid.background > 0 &&
           end_is_inside(sparse, before, true) && end_is_inside(sparse, after, false);
}

static bool joins(const qni_sparse_run *run, const qni_sparse_run *next) {
    if (run->end != next->begin)
        return false;
    if (run->leaf < 0 || next->leaf < 0)
        return run->leaf < 0 && next->leaf < 0 && run->value == next->value;
    return true; /* `order` holds them side by side */
}

static bool reserve_runs(builder *b, int64_t wanted) {
    qni_sparse *sparse = b->sparse;
    if (wanted <= sparse->run_capacity)
        return true;
    const int64_t capacity = wanted + wanted / 2 + 64;
    void *grown =
        qni_realloc(b->context, sparse->runs, sparse->run_capacity, capacity, sizeof *sparse->runs);
    if (!grown)
        return false;
    sparse->runs = grown;
    sparse->run_capacity = capacity;
    return true;
}

static bool reserve_rows(builder *b) {
    qni_sparse *sparse = b->sparse;
    const int64_t old = sparse->row_capacity, capacity = old + old / 2 + 64;
    if (sparse->row_count < old)
        return true;
    void *rows = qni_realloc(b->context, sparse->rows, old, capacity, sizeof *sparse->rows);
    if (!rows)
        return false;
    sparse->rows = rows;
    void *row_runs =
        qni_realloc(b->context, sparse->row_runs, old + 1, capacity + 1, sizeof *sparse->row_runs);
    if (!row_runs) { /* back to one capacity for both */
        void *smaller = qni_realloc(b->context, rows, capacity, old, sizeof *sparse->rows);
        sparse->rows = smaller ? smaller : rows;
        return false;
    }
    sparse->row_runs = row_runs;
    sparse->row_capacity = capacity;
    return true;
}

static qn_status fail_overlap(const builder *b, const entry *e, qn_error *error) {
    int32_t at[3];
    unpack(b, e->key, at);
    int64_t sample[3];
    for (int a = 0; a < 3; ++a)
        sample[a] = (at[a] + b->sparse->first_block[a]) * QNI_BLOCK;
    return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                    "two leaves or tiles hold the block at %lld %lld %lld", (long long)sample[0],
                    (long long)sample[1], (long long)sample[2]);
}

static qni_sparse_run run_of(builder *b, const entry *e, int32_t begin) {
    qni_sparse *sparse = b->sparse;
    qni_sparse_run run = {begin, begin + 1, -1, 0};
    if (e->is_tile) {
        const qn_sparse_tile *tile = sparse->grid.tiles + e->source;
        run.end = begin + tile->size[0] / QNI_BLOCK;
        run.value = sparse->grid.scalar == QN_F32 ? (double)(float)tile->value : tile->value;
    } else {
        run.leaf = b->leaves;
        sparse->order[b->leaves++] = e->source;
    }
    return run;
}

/* Put a run at the end of the last row, after the one before it. */
static void append_run(builder *b, const qni_sparse_run *run) {
    qni_sparse *sparse = b->sparse;
    if (sparse->run_count > sparse->row_runs[sparse->row_count - 1]) {
        qni_sparse_run *last = sparse->runs + sparse->run_count - 1;
        if (last->end < run->begin && gap_is_inside(sparse, last, run)) {
            const qni_sparse_run gap = {last->end, run->begin, -1, -sparse->grid.background};
            sparse->filled_blocks += run->begin - last->end;
            append_run(b, &gap);
            append_run(b, run);
            return;
        }
        if (joins(last, run)) {
            last->end = run->end;
            return;
        }
    }
    sparse->runs[sparse->run_count++] = *run;
}

static qn_status join_entries(builder *b, qn_error *error) {
    qni_sparse *sparse = b->sparse;
    int32_t row_end = 0; /* of the last run */
    for (int64_t n = 0; n < b->count; ++n) {
        const entry *e = b->entries + n;
        int32_t at[3];
        unpack(b, e->key, at);
        const int64_t last = sparse->row_count - 1;
        if (last < 0 || sparse->rows[last].y != at[1] || sparse->rows[last].z != at[2]) {
            if (!reserve_rows(b))
                return qni_fail_memory(error, "the rows of a sparse volume");
            sparse->rows[sparse->row_count] = (qni_sparse_row){at[1], at[2]};
            sparse->row_runs[sparse->row_count++] = sparse->run_count;
            row_end = 0;
        }
        if (at[0] < row_end)
            return fail_overlap(b, e, error);
        if (!reserve_runs(b, sparse->run_count + 2))
            return qni_fail_memory(error, "the rows of a sparse volume");
        const qni_sparse_run run = run_of(b, e, at[0]);
        append_run(b, &run);
        row_end = run.end;
    }
    sparse->row_runs[sparse->row_count] = sparse->run_count;
    return QN_OK;
}

/* ---- rows of lattice leaves ------------------------------------------------------------------ */

/* A lattice leaf touches its own block and the next one along each axis: so each row of blocks
 * belongs to four rows of leaves. */
static qn_status make_field_rows(builder *b, qn_error *error) {
    qni_sparse *sparse = b->sparse;
    b->count = 0;
    for (int64_t r = 0; r < sparse->row_count; ++r)
        for (int n = 0; n < 4; ++n)
            b->entries[b->count++].key =
                pack(b, 0, sparse->rows[r].y - (n & 1), sparse->rows[r].z - (n >> 1));
    sort_entries(b);
    int64_t count = 0;
    for (int64_t n = 0; n < b->count; ++n)
        if (n == 0 || b->entries[n].key != b->entries[n - 1].key)
            b->entries[count++].key = b->entries[n].key;
    sparse->field_rows = qni_alloc(b->context, count, sizeof *sparse->field_rows);
    if (!sparse->field_rows)
        return qni_fail_memory(error, "the rows of a sparse volume");
    sparse->field_row_capacity = sparse->field_row_count = count;
    for (int64_t n = 0; n < count; ++n) {
        int32_t at[3];
        unpack(b, b->entries[n].key, at);
        sparse->field_rows[n] = (qni_sparse_row){at[1], at[2]};
    }
    return QN_OK;
}

static qn_status with_entries(builder *b, int64_t capacity, qn_error *error,
                              qn_status (*work)(builder *, qn_error *)) {
    entry *first = qni_alloc(b->context, capacity, sizeof *first);
    entry *second = qni_alloc(b->context, capacity, sizeof *second);
    b->entries = first;
    b->spare = second;
    qn_status status =
        first && second ? work(b, error) : qni_fail_memory(error, "the order of the leaves");
    qni_free(b->context, first, capacity, sizeof *first);
    qni_free(b->context, second, capacity, sizeof *second);
    return status;
}

static qn_status list_and_join(builder *b, qn_error *error) {
    list_entries(b);
    sort_entries(b);
    return join_entries(b, error);
}

qn_status qni_sparse_make_rows(qn_context *context, qni_sparse *sparse, qn_error *error) {
    builder b = {.context = context, .sparse = sparse};
    for (int a = 0; a < 3; ++a)
        b.bits[a] = bits_of(sparse->blocks[a]);
    QN_TRY(count_entries(&b, error));
    sparse->order = qni_alloc(context, sparse->grid.leaf_count, sizeof *sparse->order);
    sparse->row_runs = qni_alloc_zero(context, 1, sizeof *sparse->row_runs);
    if (!sparse->order || !sparse->row_runs)
        return qni_fail_memory(error, "the order of the leaves");
    QN_TRY(with_entries(&b, b.count, error, list_and_join));
    return with_entries(&b, 4 * sparse->row_count, error, make_field_rows);
}
