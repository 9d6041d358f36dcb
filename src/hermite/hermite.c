// SPDX-License-Identifier: MIT
/* Keeping Hermite blocks: the table, look-ups, and sampling until no crossing lacks a block beside
 * it. */
#include "hermite/hermite.h"
#include "core/context.h"
#include "core/cube_hd.h"
#include "core/parallel.h"
#include "core/status.h"
#include "solid/sampled.h"

#include <stdlib.h>
#include <string.h>

static void put_in_table(qni_hermite *hermite, int64_t index) {
    const int32_t *place = hermite->blocks[index].place;
    const uint64_t mask = (uint64_t)hermite->table_size - 1;
    uint64_t slot = qni_hash_place(place[0], place[1], place[2]) & mask;
    while (hermite->table[slot].number)
        slot = (slot + 1) & mask;
    const qni_block_slot entry = {{place[0], place[1], place[2]}, (int32_t)index + 1};
    hermite->table[slot] = entry;
}

static bool rebuild_table(qni_hermite *hermite, int64_t size) {
    qni_block_slot *table = qni_alloc_zero(hermite->context, size, sizeof *table);
    if (!table)
        return false;
    qni_free(hermite->context, hermite->table, hermite->table_size, sizeof *table);
    hermite->table = table;
    hermite->table_size = size;
    for (int64_t i = 0; i < hermite->block_count; ++i)
        put_in_table(hermite, i);
    return true;
}

bool qni_hermite_enter(qni_hermite *hermite, const int32_t place[3]) {
    if (hermite->block_count == hermite->block_capacity) {
        const int64_t capacity = hermite->block_capacity ? 2 * hermite->block_capacity : 256;
        qni_hermite_block *blocks = qni_realloc(hermite->context, hermite->blocks,
                                                hermite->block_capacity, capacity, sizeof *blocks);
        if (!blocks)
            return false;
        hermite->blocks = blocks;
        hermite->block_capacity = capacity;
    }
    if (2 * (hermite->block_count + 1) > hermite->table_size &&
        !rebuild_table(hermite, hermite->table_size ? 2 * hermite->table_size : 1024))
        return false;
    qni_hermite_block *block = &hermite->blocks[hermite->block_count];
    memset(block, 0, sizeof *block);
    memcpy(block->place, place, sizeof block->place);
    put_in_table(hermite, hermite->block_count++);
    return true;
}

void qni_hermite_drop_crossings(qni_hermite *hermite) {
    for (int64_t i = 0; i < hermite->block_count; ++i)
        hermite->blocks[i].crossings = NULL;
    qni_free(hermite->context, hermite->crossings, hermite->crossing_count,
             sizeof *hermite->crossings);
    hermite->crossings = NULL;
    hermite->crossing_count = 0;
}

void qni_hermite_destroy(qni_hermite *hermite) {
    for (int64_t i = 0; i < hermite->block_count; ++i) {
        qni_hermite_block *block = &hermite->blocks[i];
        qni_free(hermite->context, block->starts, block->edge_count + 1, sizeof *block->starts);
        if (!hermite->crossings)
            qni_free(hermite->context, block->crossings, block->crossing_count,
                     sizeof *block->crossings);
    }
    qni_hermite_drop_crossings(hermite);
    qni_free(hermite->context, hermite->blocks, hermite->block_capacity, sizeof *hermite->blocks);
    qni_free(hermite->context, hermite->table, hermite->table_size, sizeof *hermite->table);
    hermite->blocks = NULL;
    hermite->table = NULL;
    hermite->block_count = hermite->block_capacity = hermite->table_size = 0;
}

qni_edge_crossings qni_hermite_edge_near(const qni_hermite *hermite, const int32_t point[3],
                                         int axis, qni_last_block *last) {
    const qni_edge_crossings none = {NULL, 0, 0};
    const qni_hermite_block *block = qni_hermite_block_at(hermite, point, last);
    if (!block)
        return none;
    const int edge = 512 * axis + 64 * (point[2] & 7) + 8 * (point[1] & 7) + (point[0] & 7);
    if (!qni_bit(block->crossed, edge))
        return none;
    const uint64_t below = block->crossed[edge >> 6] & ((UINT64_C(1) << (edge & 63)) - 1);
    const int rank = block->rank[edge >> 6] + qni_count_bits(below);
    const int start = block->starts[rank];
    const qni_edge_crossings found = {block->crossings + start, block->base + start,
                                      block->starts[rank + 1] - start};
    return found;
}

unsigned qni_hermite_run(const qni_hermite *hermite, const int32_t point[3], int axis,
                         int32_t count, qni_last_block *last) {
    const qni_hermite_block *block = qni_hermite_block_at(hermite, point, last);
    if (!block)
        return 0;
    const uint64_t *words = block->crossed + 8 * axis + (point[2] & 7);
    const int start = 8 * (point[1] & 7) + (point[0] & 7);
    unsigned run = 0;
    if (axis == 0)
        return (unsigned)(*words >> start & ((UINT64_C(1) << count) - 1));
    for (int32_t n = 0; n < count; ++n)
        run |= (unsigned)((axis == 1 ? *words >> (start + 8 * n) : words[n] >> start) & 1) << n;
    return run;
}

qni_edge_crossings qni_hermite_edge(const qni_hermite *hermite, const int32_t point[3], int axis) {
    qni_last_block last = QNI_NO_LAST_BLOCK;
    return qni_hermite_edge_near(hermite, point, axis, &last);
}

/* Is any of the finest edges crossed that start at a point of a block and follow each other along
 * an axis? Up to 8 of them that lie in the block. */
static bool run_is_crossed(const qni_hermite_block *block, const int32_t point[3], int axis,
                           int32_t count) {
    const uint64_t *words = block->crossed + 8 * axis + (point[2] & 7);
    const int start = 8 * (point[1] & 7) + (point[0] & 7);
    if (axis == 0)
        return *words >> start & ((UINT64_C(1) << count) - 1);
    if (axis == 1)
        return *words >> start & UINT64_C(0x0101010101010101) &
               (count == 8 ? UINT64_MAX : (UINT64_C(1) << 8 * count) - 1);
    uint64_t any = 0;
    for (int32_t n = 0; n < count; ++n)
        any |= words[n];
    return any >> start & 1;
}

bool qni_hermite_has_crossed_edge(const qni_hermite *hermite, const int32_t low[3], int32_t level) {
    const int32_t size = 1 << level, run = size < QNI_BLOCK ? size : QNI_BLOCK;
    qni_last_block last = QNI_NO_LAST_BLOCK;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int corner = qni_edge_start_corner(edge), axis = qni_edge_axis(edge);
        int32_t point[3];
        for (int k = 0; k < 3; ++k)
            point[k] = low[k] + ((corner >> k & 1) << level);
        for (int32_t n = 0; n < size; n += run, point[axis] += run) {
            const qni_hermite_block *block = qni_hermite_block_at(hermite, point, &last);
            if (block && run_is_crossed(block, point, axis, run))
                return true;
        }
    }
    return false;
}

int qni_hermite_sign(const qni_hermite *hermite, const int32_t point[3]) {
    for (int low = 0; low < 8;
         ++low) { /* a point on a block's upper side is in that block's signs too */
        int32_t place[3], local[3];
        bool fits = true;
        for (int k = 0; k < 3; ++k) {
            const bool step = low >> k & 1;
            fits = fits && (!step || (point[k] & 7) == 0);
            place[k] = (point[k] >> 3) - step;
            local[k] = step ? 8 : point[k] & 7;
        }
        const int64_t index = fits ? qni_hermite_find(hermite, place[0], place[1], place[2]) : -1;
        if (index >= 0)
            return qni_bit(hermite->blocks[index].inside, 81 * local[2] + 9 * local[1] + local[0]);
    }
    return -1;
}

bool qni_hermite_cell_values(const qni_hermite *hermite, const int32_t cell[3], double corner[8]) {
    int64_t at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = (int64_t)cell[k] - hermite->lattice.shift[k];
    return hermite->lattice.samples && qni_sampled_corners(hermite->solid, at, corner);
}

/* Note where a crossed edge lies: at step[k] of -1, 0 or 1 the blocks on that side hold it, too. */
static void want_beside(bool wanted[27], const int step[3]) {
    for (int m = 1; m < 8; ++m)
        wanted[13 + (m & 1 ? step[0] : 0) + 3 * (m & 2 ? step[1] : 0) + 9 * (m & 4 ? step[2] : 0)] =
            true;
}

/* Edges along an axis at the block's lower sides, which it owns. */
static void look_below(const qni_hermite_block *block, int axis, bool wanted[27]) {
    static const uint64_t column = UINT64_C(0x0101010101010101), row = 0xff;
    for (int z = 0; z < 8; ++z) {
        const uint64_t crossed = block->crossed[8 * axis + z];
        for (int side = 1; side < 8; ++side) { /* bits: at the lowest x, y, z */
            const uint64_t here = (side & 1 ? column : ~column) & (side & 2 ? row : ~row);
            const int step[3] = {axis != 0 && side & 1 ? -1 : 0, axis != 1 && side & 2 ? -1 : 0,
                                 axis != 2 && side & 4 ? -1 : 0};
            if (crossed & here && (z == 0) == (side >> 2))
                want_beside(wanted, step);
        }
    }
}

/* Edges along an axis at the block's upper sides: others own them, their ends tell. */
static void look_above(const qni_hermite_block *block, int axis, bool wanted[27]) {
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    const int strides[3] = {1, 9, 81};
    for (int n = 0; n < 17; ++n) { /* (8, 0) .. (8, 8) .. (0, 8) */
        const int u = n < 8 ? 8 : 16 - n, v = n < 8 ? n : 8;
        int step[3] = {0, 0, 0};
        step[p] = u == 0 ? -1 : u == 8;
        step[q] = v == 0 ? -1 : v == 8;
        int corner = u * strides[p] + v * strides[q];
        for (int m = 0; m < 8; ++m, corner += strides[axis])
            if (qni_bit(block->inside, corner) != qni_bit(block->inside, corner + strides[axis])) {
                want_beside(wanted, step);
                break;
            }
    }
}

/* Blocks that hold a crossed edge of this one in their closed box, but are not there yet. */
static bool enter_missing_neighbors(qni_hermite *hermite, int64_t index) {
    const qni_hermite_block block = hermite->blocks[index]; /* entering may move the blocks */
    bool wanted[27] = {false};
    for (int axis = 0; axis < 3; ++axis) {
        look_below(&block, axis, wanted);
        look_above(&block, axis, wanted);
    }
    for (int n = 0; n < 27; ++n) {
        const int32_t place[3] = {block.place[0] + n % 3 - 1, block.place[1] + n / 3 % 3 - 1,
                                  block.place[2] + n / 9 - 1};
        if (wanted[n] && n != 13 && qni_hermite_find(hermite, place[0], place[1], place[2]) < 0 &&
            !qni_hermite_enter(hermite, place))
            return false;
    }
    return true;
}

static qn_status sample_blocks(qni_hermite *hermite, qni_region *regions, int64_t from,
                               qn_error *error) {
    const int32_t threads = qn_context_threads(hermite->context);
    const int64_t round = 64 * (int64_t)threads, end = hermite->block_count;
    for (int64_t first = from; first < end; first += round) {
        if (qni_progress(hermite->context, "sampling",
                         (double)(first - from) / (double)(end - from)))
            return qni_fail(error, QN_ERROR_CANCELLED, "sampling was cancelled");
        const int64_t last = end - first < round ? end : first + round;
        int64_t evaluations = 0, multiple = 0, mended = 0;
        int worst = QN_OK;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) \
    reduction(+ : evaluations, multiple, mended) reduction(max : worst)
        for (int64_t i = first; i < last; ++i) {
            qni_sampling sampling = {hermite, &regions[qni_thread_index()], 0, 0, 0};
            const int status = (int)qni_sample_block(&sampling, &hermite->blocks[i]);
            worst = status > worst ? status : worst;
            evaluations += sampling.evaluations;
            multiple += sampling.multiple_edges;
            mended += sampling.mended_edges;
        }
        if (worst == QN_ERROR_OUT_OF_MEMORY)
            return qni_fail_memory(error, "Hermite data");
        if (worst == QN_ERROR_CANCELLED)
            return qni_fail(error, QN_ERROR_CANCELLED, "a callback of the solid asked to stop");
        if (worst != QN_OK)
            return qni_fail(error, (qn_status)worst, "the solid could not be evaluated");
        hermite->evaluations += evaluations;
        hermite->multiple_edges += multiple;
        hermite->mended_edges += mended;
    }
    return QN_OK;
}

static int compare_blocks(const void *a, const void *b) {
    const int32_t *p = ((const qni_hermite_block *)a)->place,
                  *q = ((const qni_hermite_block *)b)->place;
    for (int k = 2; k >= 0; --k)
        if (p[k] != q[k])
            return p[k] < q[k] ? -1 : 1;
    return 0;
}

/* Order and number the blocks, so that how they were found no longer matters. */
static qn_status settle(qni_hermite *hermite, qn_error *error) {
    if (hermite->block_count == 0)
        return QN_OK;
    qsort(hermite->blocks, (size_t)hermite->block_count, sizeof *hermite->blocks, compare_blocks);
    if (!rebuild_table(hermite, hermite->table_size))
        return qni_fail_memory(error, "Hermite data");
    for (int64_t i = 0; i < hermite->block_count; ++i) {
        hermite->blocks[i].base = hermite->crossing_count;
        hermite->crossing_count += hermite->blocks[i].crossing_count;
    }
    hermite->crossings =
        qni_alloc(hermite->context, hermite->crossing_count, sizeof *hermite->crossings);
    if (!hermite->crossings)
        return qni_fail_memory(error, "Hermite data");
    for (int64_t i = 0; i < hermite->block_count; ++i) {
        qni_hermite_block *block = &hermite->blocks[i];
        qni_hermite_crossing *to = hermite->crossings + block->base;
        if (block->crossing_count)
            memcpy(to, block->crossings, sizeof *to * (size_t)block->crossing_count);
        qni_free(hermite->context, block->crossings, block->crossing_count, sizeof *to);
        block->crossings = to;
    }
    return QN_OK;
}

static qn_status find_and_sample(qni_hermite *hermite, qni_region *regions, qn_error *error) {
    QN_TRY(qni_discover(hermite, error));
    int64_t done = 0;
    while (done < hermite->block_count) {
        const int64_t end = hermite->block_count;
        QN_TRY(sample_blocks(hermite, regions, done, error));
        for (int64_t i = done; i < end; ++i)
            if (hermite->blocks[i].crossing_count && !enter_missing_neighbors(hermite, i))
                return qni_fail_memory(error, "Hermite data");
        done = end;
    }
    return settle(hermite, error);
}

static qn_status fill(qni_hermite *hermite, qn_error *error) {
    const int32_t threads = qn_context_threads(hermite->context);
    qni_region *regions = qni_alloc(hermite->context, threads, sizeof *regions);
    if (!regions)
        return qni_fail_memory(error, "Hermite data");
    for (int32_t n = 0; n < threads; ++n)
        qni_region_start(&regions[n], hermite->solid, &hermite->lattice, false);
    const qn_status status = find_and_sample(hermite, regions, error);
    for (int32_t n = 0; n < threads; ++n)
        qni_region_end(&regions[n]);
    qni_free(hermite->context, regions, threads, sizeof *regions);
    return status;
}

qn_status qni_hermite_create(qn_context *context, const qn_solid *solid, const qni_lattice *lattice,
                             qni_hermite *hermite, qn_error *error) {
    const qni_hermite empty = {.context = context, .solid = solid, .lattice = *lattice};
    *hermite = empty;
    const qn_status status = fill(hermite, error);
    if (status != QN_OK)
        qni_hermite_destroy(hermite);
    return status;
}
