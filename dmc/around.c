// SPDX-License-Identifier: MIT
/* Quads round a vertex without halfedges: vertices and quads are numbered leaf by leaf, so the few
 * quads of a leaf are looked through. What was written afterwards is kept in a table of pairs. */
#include "dmc/around.h"
#include "core/context.h"
#include "core/status.h"

#include <assert.h>
#include <string.h>

/* ---- pairs ----------------------------------------------------------------------------------- */

static uint32_t chain_of(const qni_pairs *pairs, uint32_t vertex) {
    return qni_scatter(vertex) & (uint32_t)(pairs->heads - 1);
}

static void chain(qni_pairs *pairs, int64_t n) {
    uint32_t *head = pairs->head + chain_of(pairs, pairs->pair[n][0]);
    pairs->pair[n][2] = *head;
    *head = (uint32_t)(n + 1);
}

/* Twice the room, and as many chains as pairs. */
static qn_status grow(qni_around *around, qn_error *error) {
    qni_pairs *pairs = &around->pairs;
    const int64_t capacity = pairs->capacity ? 2 * pairs->capacity : 1024;
    void *grown =
        qni_realloc(around->context, pairs->pair, pairs->capacity, capacity, sizeof *pairs->pair);
    if (!grown)
        return qni_fail_memory(error, "the quads round changed vertices");
    pairs->pair = grown;
    pairs->capacity = capacity;
    qni_free(around->context, pairs->head, pairs->heads, sizeof *pairs->head);
    pairs->heads = 0;
    pairs->head = qni_alloc_zero(around->context, capacity, sizeof *pairs->head);
    if (!pairs->head)
        return qni_fail_memory(error, "the quads round changed vertices");
    pairs->heads = capacity;
    for (int64_t n = 0; n < pairs->count; ++n)
        chain(pairs, n);
    return QN_OK;
}

qn_status qni_around_note(qni_around *around, uint32_t vertex, uint32_t quad, qn_error *error) {
    qni_pairs *pairs = &around->pairs;
    if (pairs->count == pairs->capacity)
        QN_TRY(grow(around, error));
    pairs->pair[pairs->count][0] = vertex;
    pairs->pair[pairs->count][1] = quad;
    chain(pairs, pairs->count++);
    return QN_OK;
}

qn_status qni_around_init(qni_around *around, qn_error *error) {
    const qni_leaf_index *index = around->index;
    memset(&around->pairs, 0, sizeof around->pairs);
    for (int64_t n = 0; index && n < index->rewritten_count; ++n)
        for (int k = 0; k < 4; ++k)
            QN_TRY(qni_around_note(around,
                                   around->mesh->quads[4 * (size_t)index->rewritten[n] + (size_t)k],
                                   index->rewritten[n], error));
    return QN_OK;
}

void qni_around_free(qni_around *around) {
    qni_pairs *pairs = &around->pairs;
    qni_free(around->context, pairs->pair, pairs->capacity, sizeof *pairs->pair);
    qni_free(around->context, pairs->head, pairs->heads, sizeof *pairs->head);
    memset(pairs, 0, sizeof *pairs);
}

/* ---- looking --------------------------------------------------------------------------------- */

typedef struct finding {
    uint32_t *quads;
    int count, wanted;
} finding;

static void add(const qni_around *around, uint32_t quad, finding *found) {
    if (around->colour[quad] == QNI_QUAD_GONE || found->count == found->wanted)
        return;
    for (int n = 0; n < found->count; ++n)
        if (found->quads[n] == quad)
            return;
    found->quads[found->count++] = quad;
}

/* Four quads are compared at a time: few of them match. */
static void look_through_leaf(const qni_around *around, int64_t leaf, uint32_t vertex,
                              finding *found) {
    const uint32_t *corner = around->mesh->quads;
    const size_t end = 4 * (size_t)around->index->quad_start[leaf + 1];
    size_t at = 4 * (size_t)around->index->quad_start[leaf];
    for (; at + 16 <= end && found->count < found->wanted; at += 16) {
        uint32_t any = 0;
        for (int n = 0; n < 16; ++n)
            any |= corner[at + (size_t)n] == vertex;
        for (size_t n = 0; any && n < 16; ++n)
            if (corner[at + n] == vertex)
                add(around, (uint32_t)((at + n) >> 2), found);
    }
    for (; at < end; ++at)
        if (corner[at] == vertex)
            add(around, (uint32_t)(at >> 2), found);
}

static int64_t leaf_of(const qni_leaf_index *index, uint32_t vertex) {
    int64_t leaf = index->hint[vertex >> 6];
    while (index->vertex_start[leaf + 1] <= vertex)
        ++leaf;
    return leaf;
}

static void look_for(const qni_around *around, uint32_t vertex, finding *found) {
    const qni_leaf_index *index = around->index;
    const qni_pairs *pairs = &around->pairs;
    if (vertex < index->vertex_start[index->leaves]) {
        const int64_t leaf = leaf_of(index, vertex);
        look_through_leaf(around, leaf, vertex, found);
        for (int shift = 1; shift < 8 && found->count < found->wanted; ++shift) {
            const int64_t upper = qni_leaf_index_upper(index, leaf, shift);
            if (upper >= 0)
                look_through_leaf(around, upper, vertex, found);
        }
    }
    if (pairs->heads == 0 || found->count == found->wanted)
        return;
    for (uint32_t n = pairs->head[chain_of(pairs, vertex)]; n; n = pairs->pair[n - 1][2])
        if (pairs->pair[n - 1][0] == vertex)
            add(around, pairs->pair[n - 1][1], found);
}

static int walk_round(const qni_around *around, uint32_t vertex, uint32_t *quads) {
    const uint32_t start = around->mesh->vertex_halfedges[vertex];
    uint32_t h = start;
    int count = 0;
    do {
        quads[count++] = h >> 2;
        h = qni_next_round(around->mesh->twins, h);
    } while (h != start && h != QNI_UNPAIRED && count < QNI_VALENCE_LARGEST);
    return count;
}

int qni_quads_round(const qni_around *around, uint32_t vertex,
                    uint32_t quads[QNI_VALENCE_LARGEST]) {
    if (around->mesh->twins)
        return walk_round(around, vertex, quads);
    finding found = {quads, 0, qni_valence_now(around, vertex)};
    look_for(around, vertex, &found);
    if (around->valence[vertex] & QNI_VALENCE_MERGED)
        for (uint32_t member = around->circle[vertex];
             member != vertex && found.count < found.wanted; member = around->circle[member])
            look_for(around, member, &found);
    assert(found.count == found.wanted);
    return found.count;
}
