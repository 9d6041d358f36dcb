// SPDX-License-Identifier: MIT
/* Rounds: a coarse leaf that does not come out well beside finer ones is divided, and what that
 * changes is made anew. The other chunks keep their work, so that a round costs what it changes.
 *
 * A leaf of level 3 or less lies in one block. Divided, it changes the faces that it and its
 * neighbours own, so their chunks are gone through again. A larger leaf does so to all blocks that
 * it holds and those beside it; the chunks of larger leaves, which are few, are cut anew. */
#include "cms/stages.h"
#include "core/context.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

static void free_faces(qn_context *context, qni_chunk *chunk) {
    qni_free(context, chunk->faces, chunk->face_capacity, sizeof *chunk->faces);
    qni_free(context, chunk->segments, chunk->segment_capacity, sizeof *chunk->segments);
    qni_free(context, chunk->features, chunk->feature_capacity, sizeof *chunk->features);
    chunk->faces = NULL;
    chunk->segments = NULL;
    chunk->features = NULL;
    chunk->face_capacity = chunk->segment_capacity = chunk->feature_capacity = 0;
}

static void free_chunk(qn_context *context, qni_chunk *chunk) {
    free_faces(context, chunk);
    qni_chunk_free_made(context, chunk);
}

static void clear_chunk(qni_stages *stages, qni_chunk *chunk) {
    const qni_chunk none = {0};
    free_chunk(stages->context, chunk);
    *chunk = none;
}

static void free_chunks(qni_stages *stages) {
    for (int64_t n = 0; stages->chunks && n < stages->chunk_count; ++n)
        free_chunk(stages->context, &stages->chunks[n]);
    qni_free(stages->context, stages->chunks, stages->chunk_count, sizeof *stages->chunks);
    qni_free(stages->context, stages->features, stages->feature_count, sizeof *stages->features);
    stages->chunks = NULL;
    stages->features = NULL;
    stages->chunk_count = stages->feature_count = 0;
}

static void free_leaf_index(qni_stages *stages) {
    qni_free(stages->context, stages->chunk_of_leaf, stages->leaf_count,
             sizeof *stages->chunk_of_leaf);
    stages->chunk_of_leaf = NULL;
    stages->leaf_count = 0;
}

void qni_stages_keep_shapes(qni_stages *stages) {
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        free_faces(stages->context, &stages->chunks[n]);
        qni_chunk_free_notes(stages->context, &stages->chunks[n]);
    }
    free_leaf_index(stages);
}

void qni_stages_free(qni_stages *stages) {
    free_chunks(stages);
    free_leaf_index(stages);
}

/* ---- cutting the leaves into chunks
 * -------------------------------------------------------------- */

static int64_t first_leaf(const qni_octree *octree, int64_t block) {
    return block < octree->hermite->block_count ? (int64_t)octree->bases[block]
                                                : octree->small_count;
}

/* Cut for the first time; without chunks only their number is told. */
static int64_t cut(const qni_octree *octree, qni_chunk *chunks) {
    const int64_t blocks = octree->hermite->block_count;
    int64_t count = 0;
    for (int64_t first = 0, end = 0; first < blocks; first = end, ++count) {
        while (end < blocks && first_leaf(octree, end) - first_leaf(octree, first) < QNI_CHUNK)
            ++end;
        if (chunks) {
            chunks[count].block_first = first;
            chunks[count].block_end = end;
        }
    }
    for (int64_t leaf = octree->small_count; leaf < octree->leaf_count; leaf += QNI_CHUNK) {
        if (chunks) {
            const int64_t end = leaf + QNI_CHUNK;
            chunks[count].leaf_first = leaf;
            chunks[count].leaf_end = end < octree->leaf_count ? end : octree->leaf_count;
        }
        ++count;
    }
    return count;
}

static bool holds_blocks(const qni_chunk *chunk) {
    return chunk->block_end > chunk->block_first;
}

/* Where each chunk's leaves are in the present octree; those of large ones move up by as many as
 * there are more small ones. */
static void number_leaves(qni_stages *stages) {
    const qni_octree *octree = stages->octree;
    int64_t large = octree->small_count;
    for (int64_t n = 0; n < stages->chunk_count; ++n) {
        qni_chunk *chunk = &stages->chunks[n];
        const int64_t count = chunk->leaf_end - chunk->leaf_first;
        chunk->leaf_first = holds_blocks(chunk) ? first_leaf(octree, chunk->block_first) : large;
        chunk->leaf_end =
            holds_blocks(chunk) ? first_leaf(octree, chunk->block_end) : large + count;
        large += holds_blocks(chunk) ? 0 : count;
        for (int64_t leaf = chunk->leaf_first; leaf < chunk->leaf_end; ++leaf)
            stages->chunk_of_leaf[leaf] = (uint32_t)n;
    }
}

/* Chunks of blocks stay; those of larger leaves are cut anew. */
static bool cut_large(qni_stages *stages) {
    const qni_octree *octree = stages->octree;
    int64_t kept = 0;
    while (kept < stages->chunk_count && holds_blocks(&stages->chunks[kept]))
        ++kept;
    for (int64_t n = kept; n < stages->chunk_count; ++n)
        clear_chunk(stages, &stages->chunks[n]);
    const int64_t large = octree->leaf_count - octree->small_count,
                  count = kept + (large + QNI_CHUNK - 1) / QNI_CHUNK, before = stages->chunk_count;
    qni_chunk *chunks = qni_realloc(stages->context, stages->chunks, before, count, sizeof *chunks);
    if (!chunks)
        return false;
    memset(chunks + kept, 0, sizeof *chunks * (size_t)(count - kept));
    stages->chunks = chunks;
    stages->chunk_count = count;
    for (int64_t n = kept; n < count; ++n) {
        const int64_t first = QNI_CHUNK * (n - kept);
        chunks[n].leaf_end = large - first < QNI_CHUNK ? large - first : QNI_CHUNK;
        chunks[n].solve = chunks[n].make = true;
    }
    return true;
}

static bool cut_all(qni_stages *stages) {
    stages->chunk_count = cut(stages->octree, NULL);
    stages->chunks = qni_alloc_zero(stages->context, stages->chunk_count, sizeof *stages->chunks);
    if (!stages->chunks)
        return false;
    cut(stages->octree, stages->chunks);
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        stages->chunks[n].solve = stages->chunks[n].make = true;
    return true;
}

qn_status qni_stages_cut(qni_stages *stages) {
    const qni_octree *octree = stages->octree;
    qni_free(stages->context, stages->chunk_of_leaf, stages->leaf_count,
             sizeof *stages->chunk_of_leaf);
    stages->leaf_count = octree->leaf_count;
    stages->chunk_of_leaf =
        qni_alloc(stages->context, octree->leaf_count, sizeof *stages->chunk_of_leaf);
    if (!stages->chunk_of_leaf || (!stages->chunks && !cut_all(stages)) ||
        (stages->large_changed && !cut_large(stages)))
        return qni_fail_memory(stages->error, "a surface");
    stages->large_changed = false;
    number_leaves(stages);
    return QN_OK;
}

/* ---- what a division changes
 * --------------------------------------------------------------------- */

static qni_chunk *chunk_of_block(const qni_stages *stages, int64_t block) {
    int64_t low = 0, high = stages->chunk_count;
    while (high - low > 1) { /* chunks of blocks come first */
        const int64_t middle = low + (high - low) / 2;
        if (holds_blocks(&stages->chunks[middle]) && stages->chunks[middle].block_first <= block)
            low = middle;
        else
            high = middle;
    }
    return &stages->chunks[low];
}

qni_chunk *qni_stages_chunk_at(const qni_stages *stages, const int32_t cell[3]) {
    const int64_t index =
        qni_hermite_find(stages->hermite, cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
    return index < 0 ? NULL : chunk_of_block(stages, index);
}

/* The chunk of the block beside a block, or NULL. */
static qni_chunk *chunk_beside(const qni_stages *stages, const int32_t place[3], int face) {
    int32_t at[3] = {place[0], place[1], place[2]};
    at[face >> 1] += face & 1 ? 1 : -1;
    const int64_t index = qni_hermite_find(stages->hermite, at[0], at[1], at[2]);
    return index < 0 ? NULL : chunk_of_block(stages, index);
}

static void mark_solved(const qni_stages *stages, const qni_cell *divided) {
    const int32_t place[3] = {divided->low[0] >> 3, divided->low[1] >> 3, divided->low[2] >> 3};
    const int64_t index = qni_hermite_find(stages->hermite, place[0], place[1], place[2]);
    chunk_of_block(stages, index)->solve = true;
    for (int face = 0; face < 6; ++face) {
        qni_chunk *beside = chunk_beside(stages, place, face);
        if (beside)
            beside->solve = true;
    }
}

void qni_stages_mark_none(qni_stages *stages) {
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        stages->chunks[n].solve = stages->chunks[n].make = false;
}

void qni_stages_mark_cell(qni_stages *stages, const int32_t low[3]) {
    for (int face = -1; face < 6; ++face) {
        int32_t at[3] = {low[0], low[1], low[2]};
        if (face >= 0)
            at[face >> 1] += face & 1 ? 1 : -1;
        qni_chunk *chunk = qni_stages_chunk_at(stages, at);
        if (chunk)
            chunk->solve = true;
    }
}

/* Larger leaves have finer ones' faces. */
void qni_stages_mark_made(qni_stages *stages) {
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        stages->chunks[n].make |= stages->chunks[n].solve || !holds_blocks(&stages->chunks[n]);
}

/* A leaf above the blocks: its own blocks, and those beside it. */
static void mark_solved_large(const qni_stages *stages, const qni_cell *divided) {
    const int32_t side = 1 << (divided->level - 3);
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t block = stages->chunks[n].block_first;
             block < stages->chunks[n].block_end && !stages->chunks[n].solve; ++block) {
            const int32_t *place = stages->hermite->blocks[block].place;
            bool near = true;
            for (int k = 0; k < 3; ++k) {
                const int32_t at = place[k] - (divided->low[k] >> 3);
                near = near && at >= -1 && at <= side;
            }
            stages->chunks[n].solve = near;
        }
}

static void mark_changed(qni_stages *stages, const qni_cell *divided, int64_t count) {
    qni_stages_mark_none(stages);
    for (int64_t n = 0; n < count; ++n)
        if (divided[n].level > 3) {
            mark_solved_large(stages, &divided[n]);
            stages->large_changed = true;
        } else {
            mark_solved(stages, &divided[n]);
        }
    qni_stages_mark_made(stages);
}

qn_status qni_stages_gather_vetoes(qni_stages *stages, qni_veto_list *list) {
    list->added = 0;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        list->added += stages->chunks[n].make ? stages->chunks[n].veto_count : 0;
    if (list->added == 0)
        return QN_OK;
    const int64_t total = list->count + list->added;
    qni_cell *items = qni_realloc(stages->context, list->items, list->count, total, sizeof *items);
    if (!items)
        return qni_fail_memory(stages->error, "a surface");
    list->items = items;
    qni_cell *next = items + list->count;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t m = 0; stages->chunks[n].make && m < stages->chunks[n].veto_count; ++m)
            *next++ = stages->chunks[n].vetoes[m];
    list->count = total;
    return QN_OK;
}

qn_status qni_stages_add_vetoes(qni_stages *stages, qni_veto_list *list, const qni_cell *cells,
                                int64_t count) {
    qni_cell *items =
        qni_realloc(stages->context, list->items, list->count, list->count + count, sizeof *items);
    if (!items)
        return qni_fail_memory(stages->error, "a surface");
    memcpy(items + list->count, cells, sizeof *cells * (size_t)count);
    list->items = items;
    list->count += count;
    list->added += count;
    return QN_OK;
}

void qni_stages_divide(qni_stages *stages, qni_veto_list *list) {
    mark_changed(stages, list->items + list->count - list->added, list->added);
    qsort(list->items, (size_t)list->count, sizeof *list->items, qni_compare_vetoes);
}

/* ---- the octree of a later round
 * ----------------------------------------------------------------- */

/* The level of the leaf that held a cell, or of one in it, in some block of it. */
static int level_before(const qni_octree *octree, const qni_cell *cell) {
    const int32_t size = 1 << cell->level;
    for (int32_t z = 0; z < size; z += QNI_BLOCK)
        for (int32_t y = 0; y < size; y += QNI_BLOCK)
            for (int32_t x = 0; x < size; x += QNI_BLOCK) {
                const int32_t point[3] = {cell->low[0] + x, cell->low[1] + y, cell->low[2] + z};
                const int level = qni_octree_level(octree, point);
                if (level >= 0)
                    return level;
            }
    return -1;
}

bool qni_ask_remembered(void *user, const qni_cell *cell) {
    const qni_remembered *remembered = user;
    const qni_coarsening *coarsening = remembered->coarsening;
    const int level = remembered->before ? level_before(remembered->before, cell) : INT8_MAX;
    if (level < cell->level)
        return false;
    if (level == cell->level)
        return !coarsening->veto_count ||
               !bsearch(cell, coarsening->vetoes, (size_t)coarsening->veto_count, sizeof *cell,
                        qni_compare_vetoes);
    return qni_cell_is_explained(remembered->coarsening, cell);
}
