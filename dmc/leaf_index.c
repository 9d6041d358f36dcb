// SPDX-License-Identifier: MIT
/* Where the leaves' vertices and quads start in the mesh, from the rows that emission went by. */
#include "dmc/around.h"
#include "dmc/dmc.h"
#include "dmc/repair.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { HINT_BITS = 6 };

static int64_t hints_of(const qni_dmc *dmc) {
    return (dmc->vertex_count >> HINT_BITS) + 1;
}

static void list_leaves(const qni_dmc *dmc, qni_leaf_index *index) {
    int64_t leaf = 0, hints = 0;
    for (int64_t r = 0; r < dmc->row_count; ++r) {
        const qni_dmc_row *row = dmc->rows + r;
        index->first[r] = (uint32_t)leaf;
        for (int32_t n = 0; n < row->leaf_count; ++n, ++leaf) {
            const uint32_t start = (uint32_t)(row->vertex_base + row->leaves[n].vertex_base);
            index->vertex_start[leaf] = start;
            index->quad_start[leaf] = (uint32_t)(row->quad_base + row->leaves[n].quad_base);
            index->row[leaf] = (uint32_t)r;
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

qn_status qni_leaf_index_build(const qni_dmc *dmc, int64_t quads, qni_leaf_index *index,
                               qn_error *error) {
    memset(index, 0, sizeof *index);
    index->dmc = dmc;
    index->leaves = dmc->leaf_count;
    index->rewritten_count = quads - dmc->quad_count + (dmc->repair ? dmc->repair->split_count : 0);
    index->vertex_start = qni_alloc(dmc->context, index->leaves + 1, sizeof *index->vertex_start);
    index->quad_start = qni_alloc(dmc->context, index->leaves + 1, sizeof *index->quad_start);
    index->row = qni_alloc(dmc->context, index->leaves, sizeof *index->row);
    index->first = qni_alloc(dmc->context, dmc->row_count, sizeof *index->first);
    index->hint = qni_alloc(dmc->context, hints_of(dmc), sizeof *index->hint);
    index->rewritten = qni_alloc(dmc->context, index->rewritten_count, sizeof *index->rewritten);
    if (!index->vertex_start || !index->quad_start || !index->row || !index->first ||
        !index->hint || !index->rewritten) {
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
    qni_free(dmc->context, index->first, dmc->row_count, sizeof *index->first);
    qni_free(dmc->context, index->hint, hints_of(dmc), sizeof *index->hint);
    qni_free(dmc->context, index->rewritten, index->rewritten_count, sizeof *index->rewritten);
    memset(index, 0, sizeof *index);
}

int64_t qni_leaf_index_upper(const qni_leaf_index *index, int64_t leaf, int shift) {
    const qni_dmc *dmc = index->dmc;
    const int64_t own_row = index->row[leaf];
    const int32_t x = dmc->rows[own_row].leaves[leaf - index->first[own_row]].x + (shift & 1);
    int64_t upper = own_row;
    if (shift > 1) {
        int32_t yz[2];
        qni_field_row_leaf(&dmc->field, own_row, yz);
        upper = qni_field_find_row(&dmc->field, yz[0] + (shift >> 1 & 1), yz[1] + (shift >> 2));
        if (upper < 0)
            return -1;
    }
    const qni_dmc_row *row = dmc->rows + upper;
    int32_t low = 0, high = row->leaf_count;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (row->leaves[middle].x < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low < row->leaf_count && row->leaves[low].x == x ? (int64_t)index->first[upper] + low
                                                            : -1;
}
