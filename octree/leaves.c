// SPDX-License-Identifier: MIT
/* Numbering the leaves with surface, and finding who lies across a face. */
#include "core/context.h"
#include "core/cube_hd.h"
#include "core/status.h"
#include "octree/octree.h"

#include <stdlib.h>
#include <string.h>

static bool has_surface(const qni_hermite *hermite, const qni_cell *cell) {
    return qni_hermite_has_crossed_edge(hermite, cell->low, cell->level);
}

/* The blocks round one, at steps of x + 2 y + 4 z; NULL: none there. */
typedef struct block_group {
    const qni_hermite_block *blocks[8];
} block_group;

static block_group group_of(const qni_hermite *hermite, const qni_hermite_block *block) {
    block_group group;
    for (int n = 0; n < 8; ++n) {
        const int64_t index =
            qni_hermite_find(hermite, block->place[0] + (n & 1), block->place[1] + (n >> 1 & 1),
                             block->place[2] + (n >> 2));
        group.blocks[n] = index < 0 ? NULL : &hermite->blocks[index];
    }
    return group;
}

/* The crossed edges along an axis of a layer of z, as seen from finest cells that lie a step below
 * them. */
static uint64_t edges_beside(const block_group *group, int axis, int z, int x_step, int y_step) {
    const uint64_t column = UINT64_C(0x0101010101010101);
    uint64_t words[4];
    for (int n = 0; n < 4; ++n) {
        const qni_hermite_block *block = group->blocks[n + (z == 8 ? 4 : 0)];
        words[n] = block ? block->crossed[8 * axis + (z & 7)] : 0;
    }
    for (int n = 0; n < 2 && y_step; ++n)
        words[n] = words[n] >> 8 | words[n + 2] << 56;
    return x_step ? (words[0] >> 1 & ~(column << 7)) | (words[1] & column) << 7 : words[0];
}

/* Finest cells with a crossed edge, of a layer of a block. */
static uint64_t crossed_cells(const block_group *group, int z) {
    uint64_t crossed = 0;
    for (int n = 0; n < 4; ++n)
        crossed |= edges_beside(group, 0, z + (n >> 1), 0, n & 1) |
                   edges_beside(group, 1, z + (n >> 1), n & 1, 0) |
                   edges_beside(group, 2, z, n & 1, n >> 1);
    return crossed;
}

/* Leaves with surface have finest cells with crossed edges: these lead to them. */
static void mark_starts(qni_octree *octree, int64_t index) {
    const qni_hermite_block *block = &octree->hermite->blocks[index];
    const block_group group = group_of(octree->hermite, block);
    uint64_t *starts = octree->starts[index], asked[8] = {0};
    for (int z = 0; z < 8; ++z)
        for (uint64_t bits = crossed_cells(&group, z); bits; bits &= bits - 1) {
            const int at = __builtin_ctzll(bits), level = octree->levels[index][64 * z + at];
            if (level > 3)
                continue;
            const int low[3] = {(at & 7) >> level << level, (at >> 3) >> level << level,
                                z >> level << level};
            const uint64_t bit = UINT64_C(1) << (8 * low[1] + low[0]);
            if (asked[low[2]] & bit)
                continue;
            asked[low[2]] |= bit;
            const qni_cell cell = {{8 * block->place[0] + low[0], 8 * block->place[1] + low[1],
                                    8 * block->place[2] + low[2]},
                                   level};
            if (level == 0 || has_surface(octree->hermite, &cell))
                starts[low[2]] |= bit;
        }
}

static int compare_cells(const void *a, const void *b) {
    const qni_cell *p = a, *q = b;
    for (int k = 2; k >= 0; --k)
        if (p->low[k] != q->low[k])
            return p->low[k] < q->low[k] ? -1 : 1;
    return p->level - q->level;
}

static void list_small(qni_octree *octree) {
    for (int64_t i = 0; i < octree->hermite->block_count; ++i) {
        const int32_t *place = octree->hermite->blocks[i].place;
        qni_cell *leaf = octree->leaves + octree->bases[i];
        for (int word = 0; word < 8; ++word)
            for (uint64_t bits = octree->starts[i][word]; bits; bits &= bits - 1, ++leaf) {
                const int n = 64 * word + __builtin_ctzll(bits);
                leaf->low[0] = 8 * place[0] + (n & 7);
                leaf->low[1] = 8 * place[1] + (n >> 3 & 7);
                leaf->low[2] = 8 * place[2] + (n >> 6);
                leaf->level = octree->levels[i][n];
            }
    }
}

qn_status qni_octree_number_leaves(qni_octree *octree, const qni_cell *large, int64_t large_count,
                                   qn_error *error) {
    const qni_hermite *hermite = octree->hermite;
    const int32_t threads = qn_context_threads(hermite->context);
#pragma omp parallel for schedule(dynamic, 16) num_threads(threads)
    for (int64_t i = 0; i < hermite->block_count; ++i)
        mark_starts(octree, i);
    int64_t count = 0;
    for (int64_t i = 0; i < hermite->block_count; ++i) {
        octree->bases[i] = (uint32_t)count;
        for (int word = 0; word < 8; ++word) {
            octree->ranks[i][word] = (uint16_t)(count - octree->bases[i]);
            count += qni_count_bits(octree->starts[i][word]);
        }
    }
    octree->small_count = count;
    for (int64_t n = 0; n < large_count; ++n)
        count += has_surface(hermite, &large[n]);
    if (count >= INT32_MAX)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "more than 2^31 leaves: take a smaller depth");
    octree->leaves = qni_alloc(hermite->context, count, sizeof *octree->leaves);
    if (!octree->leaves)
        return qni_fail_memory(error, "the octree");
    octree->leaf_count = count;
    list_small(octree);
    count = octree->small_count;
    for (int64_t n = 0; n < large_count; ++n)
        if (has_surface(hermite, &large[n]))
            octree->leaves[count++] = large[n];
    qsort(octree->leaves + octree->small_count, (size_t)(count - octree->small_count),
          sizeof(qni_cell), compare_cells);
    return QN_OK;
}

int64_t qni_octree_find_leaf(const qni_octree *octree, const qni_cell *cell) {
    if (cell->level > 3) {
        const qni_cell *from = octree->leaves + octree->small_count;
        const size_t count = (size_t)(octree->leaf_count - octree->small_count);
        const qni_cell *found =
            count ? bsearch(cell, from, count, sizeof *cell, compare_cells) : NULL;
        return found ? found - octree->leaves : -1;
    }
    const int64_t index =
        qni_hermite_find(octree->hermite, cell->low[0] >> 3, cell->low[1] >> 3, cell->low[2] >> 3);
    const int n = 64 * (cell->low[2] & 7) + 8 * (cell->low[1] & 7) + (cell->low[0] & 7);
    if (index < 0 || octree->levels[index][n] != cell->level || !qni_bit(octree->starts[index], n))
        return -1;
    int64_t number = octree->bases[index];
    for (int word = 0; word < n >> 6; ++word)
        number += qni_count_bits(octree->starts[index][word]);
    return number + qni_count_bits(octree->starts[index][n >> 6] & ((UINT64_C(1) << (n & 63)) - 1));
}

bool qni_octree_is_empty_of(const qni_octree *octree, const int32_t point[3], int level) {
    if (level < 0)
        return true;
    const qni_cell leaf = {
        {point[0] >> level << level, point[1] >> level << level, point[2] >> level << level},
        level};
    return qni_octree_find_leaf(octree, &leaf) < 0;
}

int qni_octree_level_across(const qni_octree *octree, const qni_cell *cell, int face) {
    const int axis = face >> 1, p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    qni_cell across = qni_cell_across(cell, face);
    if (!(face & 1))
        across.low[axis] += (1 << cell->level) - 1; /* the layer that touches the face */
    const int32_t step = cell->level < 3 ? 1 << cell->level : QNI_BLOCK;
    for (int32_t v = 0; v < 1 << cell->level; v += step)
        for (int32_t u = 0; u < 1 << cell->level; u += step) {
            int32_t point[3] = {across.low[0], across.low[1], across.low[2]};
            point[p] += u;
            point[q] += v;
            const int level = qni_octree_level(octree, point);
            if (level >= 0)
                return level;
        }
    return -1;
}

bool qni_octree_divided_across(const qni_octree *octree, const qni_cell *cell, int face) {
    const int level = qni_octree_level_across(octree, cell, face);
    return level >= 0 && level < cell->level;
}
