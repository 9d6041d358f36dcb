// SPDX-License-Identifier: MIT
/* Where the leaves' vertices and quads start in the mesh, from the rows that emission went by. */
#include "dmc/around.h"
#include "dmc/cell_hd.h"
#include "dmc/dmc.h"
#include "dmc/repair.h"
#include "core/bits_hd.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { HINT_BITS = 6 };

/* What pass 1 left of a leaf. */
typedef struct qni_leaf_place {
    const qni_dmc_leaf *leaf;
    const qni_leaf_quads *quads;
    const qni_multi_cell *multis;
} qni_leaf_place;

/* A row of leaves. */
typedef struct qni_leaf_row {
    int32_t yz[2];     /* leaf coordinates */
    uint32_t first;    /* leaf */
    int32_t first_x;   /* its coordinate */
    uint64_t presence; /* bit n: there is a leaf at first_x + n */
} qni_leaf_row;

static int64_t hints_of(const qni_dmc *dmc) {
    return (dmc->vertex_count >> HINT_BITS) + 1;
}

static void list_leaves(const qni_dmc *dmc, qni_leaf_index *index) {
    int64_t leaf = 0, hints = 0;
    for (int64_t r = 0; r < dmc->row_count; ++r) {
        const qni_dmc_row *row = dmc->rows + r;
        qni_leaf_row *out = index->rows + r;
        *out = (qni_leaf_row){.first = (uint32_t)leaf,
                              .first_x = row->leaf_count > 0 ? row->leaves[0].x : 0};
        qni_field_row_leaf(&dmc->field, r, out->yz);
        for (int32_t n = 0; n < row->leaf_count; ++n, ++leaf) {
            const int64_t along = (int64_t)row->leaves[n].x - out->first_x;
            out->presence |= along < 64 ? UINT64_C(1) << along : 0;
            const uint32_t start = (uint32_t)(row->vertex_base + row->leaves[n].vertex_base);
            index->vertex_start[leaf] = start;
            index->quad_start[leaf] = (uint32_t)(row->quad_base + row->leaves[n].quad_base);
            index->row[leaf] = (uint32_t)r;
            index->place[leaf] = (qni_leaf_place){row->leaves + n, row->quads + n,
                                                  row->multis + row->leaves[n].multi_base};
            for (; hints << HINT_BITS < start; ++hints)
                index->hint[hints] = (uint32_t)(leaf - 1);
        }
    }
    index->vertex_start[leaf] = (uint32_t)dmc->vertex_count;
    index->quad_start[leaf] = (uint32_t)dmc->quad_count;
    for (; hints < hints_of(dmc); ++hints)
        index->hint[hints] = (uint32_t)(leaf - 1);
}

static void list_rewritten(const qni_dmc *dmc, int64_t quads, qni_leaf_index *index) {
    int64_t count = 0;
    for (int64_t n = 0; dmc->repair && n < dmc->repair->split_count; ++n)
        index->rewritten[count++] = dmc->repair->splits[n].quad;
    for (int64_t q = dmc->quad_count; q < quads; ++q)
        index->rewritten[count++] = (uint32_t)q;
}

qn_status qni_leaf_index_build(const qni_dmc *dmc, const qn_mesh *mesh, qni_leaf_index *index,
                               qn_error *error) {
    const int64_t quads = mesh->quad_count;
    memset(index, 0, sizeof *index);
    index->dmc = dmc;
    index->quads = mesh->quads;
    index->leaves = dmc->leaf_count;
    index->rewritten_count = quads - dmc->quad_count + (dmc->repair ? dmc->repair->split_count : 0);
    index->vertex_start = qni_alloc(dmc->context, index->leaves + 1, sizeof *index->vertex_start);
    index->quad_start = qni_alloc(dmc->context, index->leaves + 1, sizeof *index->quad_start);
    index->row = qni_alloc(dmc->context, index->leaves, sizeof *index->row);
    index->place = qni_alloc(dmc->context, index->leaves, sizeof *index->place);
    index->rows = qni_alloc(dmc->context, dmc->row_count, sizeof *index->rows);
    index->hint = qni_alloc(dmc->context, hints_of(dmc), sizeof *index->hint);
    index->rewritten = qni_alloc(dmc->context, index->rewritten_count, sizeof *index->rewritten);
    if (!index->vertex_start || !index->quad_start || !index->row || !index->place ||
        !index->rows || !index->hint || !index->rewritten) {
        qni_leaf_index_free(dmc, index);
        return qni_fail_memory(error, "the index of leaves");
    }
    list_leaves(dmc, index);
    list_rewritten(dmc, quads, index);
    return QN_OK;
}

void qni_leaf_index_free(const qni_dmc *dmc, qni_leaf_index *index) {
    qni_free(dmc->context, index->vertex_start, index->leaves + 1, sizeof *index->vertex_start);
    qni_free(dmc->context, index->quad_start, index->leaves + 1, sizeof *index->quad_start);
    qni_free(dmc->context, index->row, index->leaves, sizeof *index->row);
    qni_free(dmc->context, index->place, index->leaves, sizeof *index->place);
    qni_free(dmc->context, index->rows, dmc->row_count, sizeof *index->rows);
    qni_free(dmc->context, index->hint, hints_of(dmc), sizeof *index->hint);
    qni_free(dmc->context, index->rewritten, index->rewritten_count, sizeof *index->rewritten);
    memset(index, 0, sizeof *index);
}

/* ---- quads of a vertex ----------------------------------------------------------------------- */

/* The bit that so many come before. First its byte: that of sums of bits, each byte and all below
 * it, which are at most as many. */
static int select_bit(uint64_t bits, int before) {
    const uint64_t ones = UINT64_C(0x0101010101010101), high = ones << 7;
    uint64_t sums = bits - (bits >> 1 & UINT64_C(0x5555555555555555));
    sums = (sums & UINT64_C(0x3333333333333333)) + (sums >> 2 & UINT64_C(0x3333333333333333));
    sums = ((sums + (sums >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f)) * ones;
    const uint64_t passed = (((uint64_t)before * ones | high) - sums) & high;
    const int shift = (int)((passed >> 7) * ones >> 56) * 8;
    uint64_t rest = bits >> shift;
    for (int n = (int)(sums << 8 >> shift & 0xff); n < before; ++n)
        rest &= rest - 1;
    return shift + __builtin_ctzll(rest);
}

/* The cell whose active cells before it are so many; x + 8 y + 64 z. */
static int active_cell(const qni_dmc_leaf *leaf, int before) {
    int z = 0;
    for (int n = 1; n < QNI_LEAF; ++n)
        z += leaf->before_slice[n] <= before;
    return 64 * z + select_bit(leaf->active[z], before - leaf->before_slice[z]);
}

/* The first vertex of a multiple cell, counted from the leaf's own first. */
static int first_of_multi(const qni_dmc_leaf *leaf, const qni_multi_cell *multi) {
    const int z = multi->cell >> 6;
    return leaf->before_slice[z] + qni_bits_below(leaf->active[z], multi->cell & 63) +
           multi->extra_before;
}

/* The cell of the leaf's vertex `number`: cells with several polygons have as many vertices. */
static int cell_of(const qni_leaf_place *place, int number, bool *alone) {
    const qni_dmc_leaf *leaf = place->leaf;
    *alone = true;
    int low = 0, high = leaf->multi_count; /* multiple cells that start there or before */
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (first_of_multi(leaf, place->multis + middle) <= number)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0)
        return active_cell(leaf, number);
    const qni_multi_cell *last = place->multis + low - 1;
    const int more = qni_entry_polygons(last->entry);
    *alone = number >= first_of_multi(leaf, last) + more;
    return *alone ? active_cell(leaf, number - (last->extra_before + more - 1)) : last->cell;
}

static int64_t leaf_of(const qni_leaf_index *index, uint32_t vertex) {
    int64_t leaf = index->hint[vertex >> HINT_BITS];
    while (index->vertex_start[leaf + 1] <= vertex)
        ++leaf;
    return leaf;
}

/* The leaf of a row at x, or -1; from its 65th place on. */
static int64_t search_row(const qni_leaf_index *index, int64_t row_number, int64_t x) {
    const qni_dmc_row *row = index->dmc->rows + row_number;
    int32_t low = 0, high = row->leaf_count;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (row->leaves[middle].x < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low < row->leaf_count && row->leaves[low].x == x
               ? (int64_t)index->rows[row_number].first + low
               : -1;
}

/* The leaf so many further along each axis, or -1. */
static int64_t leaf_beside(const qni_leaf_index *index, int64_t leaf, int along_x, int along_y,
                           int along_z) {
    const qni_dmc *dmc = index->dmc;
    int64_t there = index->row[leaf];
    const int64_t x = (int64_t)index->place[leaf].leaf->x + along_x;
    if (along_y || along_z) {
        const int32_t *yz = index->rows[there].yz;
        there = qni_field_find_row(&dmc->field, (int64_t)yz[0] + along_y, (int64_t)yz[1] + along_z);
        if (there < 0)
            return -1;
    }
    const qni_leaf_row *row = index->rows + there;
    const int64_t bit = x - row->first_x;
    if (bit < 0 || bit >= 64)
        return bit < 0 ? -1 : search_row(index, there, x);
    return row->presence >> bit & 1 ? (int64_t)row->first + qni_bits_below(row->presence, (int)bit)
                                    : -1;
}

/* The leaf one higher along the axes in `shift` (bit 0 x, 1 y, 2 z), or -1. */
static int64_t upper_leaf(const qni_leaf_index *index, int64_t leaf, int shift) {
    return leaf_beside(index, leaf, shift & 1, shift >> 1 & 1, shift >> 2);
}

void qni_leaf_index_prefetch(const qni_leaf_index *index, uint32_t vertex) {
    if (vertex >= index->vertex_start[index->leaves])
        return;
    const qni_leaf_place *place = index->place + leaf_of(index, vertex);
    __builtin_prefetch(place->leaf);
    __builtin_prefetch((const char *)place->leaf + 64);
    __builtin_prefetch(place->multis);
    for (size_t line = 0; line < sizeof *place->quads; line += 64)
        __builtin_prefetch((const char *)place->quads + line);
}

/* The quads of a cell's edges that start at its corner, which the leaf has; without branches, since
 * which edges have quads is hard to foresee. */
static inline int add_from_corner(const qni_leaf_index *index, int64_t leaf, int corner, int z,
                                  int bit, int count, uint32_t quads[QNI_EDGES]) {
    const qni_leaf_quads *masks = index->place[leaf].quads;
    const uint32_t start = index->quad_start[leaf];
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
        if (corner >> axis & 1) /* they end there */
            continue;
        const uint64_t mask = masks->mask[axis][z];
        quads[count] = start + masks->before[axis][z] + (uint32_t)qni_bits_below(mask, bit);
        count += mask >> bit & 1;
    }
    return count;
}

int qni_leaf_index_quads(const qni_leaf_index *index, uint32_t vertex, uint32_t quads[QNI_EDGES],
                         bool *alone) {
    enum { NOT_ASKED = -2, LAST_START = 6 };
    const int64_t own = leaf_of(index, vertex);
    const int cell = cell_of(index->place + own, (int)(vertex - index->vertex_start[own]), alone);
    int64_t leaves[8] = {own,       NOT_ASKED, NOT_ASKED, NOT_ASKED,
                         NOT_ASKED, NOT_ASKED, NOT_ASKED, NOT_ASKED};
    int count = 0;
#pragma GCC unroll 7
    for (int corner = 0; corner <= LAST_START; ++corner) {
        const int x = (cell & 7) + (corner & 1), y = (cell >> 3 & 7) + (corner >> 1 & 1),
                  z = (cell >> 6) + (corner >> 2);
        const int shift = x >> 3 | (y >> 3) << 1 | (z >> 3) << 2;
        if (leaves[shift] == NOT_ASKED)
            leaves[shift] = upper_leaf(index, own, shift);
        if (leaves[shift] >= 0)
            count = add_from_corner(index, leaves[shift], corner, z & 7, (x & 7) + 8 * (y & 7),
                                    count, quads);
    }
    for (int n = 0; n < count; ++n)
        __builtin_prefetch(index->quads + 4 * (size_t)quads[n]);
    return count;
}

/* The quad of the edge along `axis` from a point, which is counted from the leaf's first and at
 * most one leaf away. */
static uint32_t quad_from(const qni_leaf_index *index, int64_t leaf, const int point[3], int axis) {
    const int bit = (point[0] & 7) + 8 * (point[1] & 7), z = point[2] & 7;
    if ((point[0] | point[1] | point[2]) & ~7) /* -1 becomes -1, 8 becomes 1 */
        leaf = leaf_beside(index, leaf, point[0] >> 3, point[1] >> 3, point[2] >> 3);
    if (leaf < 0)
        return QNI_UNPAIRED;
    const qni_leaf_quads *masks = index->place[leaf].quads;
    const uint64_t mask = masks->mask[axis][z];
    return mask >> bit & 1 ? index->quad_start[leaf] + masks->before[axis][z] +
                                 (uint32_t)qni_bits_below(mask, bit)
                           : QNI_UNPAIRED;
}

/* The quads of the edges that meet at a point across `axis`; whether there are all four. */
static bool quads_across(const qni_leaf_index *index, int64_t leaf, const int point[3], int axis,
                         uint32_t quads[4]) {
    for (int n = 0; n < 4; ++n) {
        const int along = (axis + 1 + (n & 1)) % 3;
        int start[3] = {point[0], point[1], point[2]};
        start[along] -= n >> 1;
        quads[n] = quad_from(index, leaf, start, along);
        if (quads[n] == QNI_UNPAIRED)
            return false;
    }
    return true;
}

/* Its corner 2 was emitted for the cell whose first corner starts the quad's edge; another one
 * tells that it is not as it was emitted. */
bool qni_leaf_index_ring(const qni_leaf_index *index, uint32_t quad, int axis, uint32_t ring[4],
                         uint32_t *beyond) {
    const uint32_t vertex = index->quads[4 * (size_t)quad + 2];
    if (vertex >= index->vertex_start[index->leaves])
        return false;
    const int64_t leaf = leaf_of(index, vertex);
    if (quad < index->quad_start[leaf] || quad >= index->quad_start[leaf + 1])
        return false;
    const qni_leaf_quads *masks = index->place[leaf].quads;
    const int number = (int)(quad - index->quad_start[leaf]);
    int z = 0;
    for (int n = 1; n < QNI_LEAF; ++n)
        z += masks->before[axis][n] <= number;
    const int bit = select_bit(masks->mask[axis][z], number - masks->before[axis][z]);
    int point[3] = {bit & 7, bit >> 3, z};
    const bool at_start = quads_across(index, leaf, point, axis, ring);
    ++point[axis];
    if (!at_start && !quads_across(index, leaf, point, axis, ring))
        return false;
    point[axis] -= at_start ? 2 : 0;
    *beyond = quad_from(index, leaf, point, axis);
    return true;
}
