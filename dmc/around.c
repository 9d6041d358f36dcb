// SPDX-License-Identifier: MIT
/* Quads round a vertex without halfedges: the grid says which quads a vertex of its cell can have
 * (leaf_index.c). What was written afterwards is kept in a table of pairs. */
#include "dmc/around.h"
#include "core/context.h"
#include "core/cube_hd.h"
#include "core/status.h"

#include <assert.h>
#include <string.h>

enum { FEWEST_PAIRS = 1024 };

/* ---- pairs ----------------------------------------------------------------------------------- */

static uint32_t chain_of(const qni_pairs *pairs, uint32_t vertex) {
    return qni_scatter(vertex) & (uint32_t)(pairs->heads - 1);
}

static void chain(qni_pairs *pairs, int64_t n) {
    uint32_t *head = pairs->head + chain_of(pairs, pairs->pair[n][0]);
    pairs->pair[n][2] = *head;
    *head = (uint32_t)(n + 1);
}

/* Room for so many pairs, a power of two, and as many chains. */
static qn_status reserve(qni_around *around, int64_t capacity, qn_error *error) {
    qni_pairs *pairs = &around->pairs;
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
        QN_TRY(reserve(around, pairs->capacity ? 2 * pairs->capacity : FEWEST_PAIRS, error));
    pairs->pair[pairs->count][0] = vertex;
    pairs->pair[pairs->count][1] = quad;
    chain(pairs, pairs->count++);
    return QN_OK;
}

qn_status qni_around_init(qni_around *around, qn_error *error) {
    const qni_leaf_index *index = around->index;
    int64_t room = FEWEST_PAIRS;
    memset(&around->pairs, 0, sizeof around->pairs);
    while (index && room < 4 * index->rewritten_count)
        room *= 2;
    if (room > FEWEST_PAIRS)
        QN_TRY(reserve(around, room, error));
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

/* Among the quads of the vertex' cell, as the grid has them. Those that repair made anew have a
 * colour of their own; a quad that took its ring's place has lost the vertices of its cells. */
static void look_in_cell(const qni_around *around, uint32_t vertex, finding *found) {
    const qni_leaf_index *index = around->index;
    if (vertex >= index->vertex_start[index->leaves])
        return;
    uint32_t quads[QNI_EDGES];
    bool alone;
    const int count = qni_leaf_index_quads(index, vertex, quads, &alone);
    for (int n = 0; n < count; ++n)
        if ((alone && around->colour[quads[n]] < QNI_COLOURS) ||
            qni_has_corner(around->mesh->quads + 4 * (size_t)quads[n], vertex))
            add(around, quads[n], found);
}

/* Among those that came later. */
static void look_in_pairs(const qni_around *around, uint32_t vertex, finding *found) {
    const qni_pairs *pairs = &around->pairs;
    if (pairs->heads == 0)
        return;
    for (uint32_t n = pairs->head[chain_of(pairs, vertex)]; n && found->count < found->wanted;
         n = pairs->pair[n - 1][2])
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
    return qni_quads_round_with(around, vertex, QNI_UNPAIRED, quads);
}

int qni_quads_round_with(const qni_around *around, uint32_t vertex, uint32_t known,
                         uint32_t quads[QNI_VALENCE_LARGEST]) {
    if (around->mesh->twins)
        return walk_round(around, vertex, quads);
    finding found = {quads, 0, qni_valence_now(around, vertex)};
    if (known != QNI_UNPAIRED)
        add(around, known, &found);
    const bool merged = around->valence[vertex] & QNI_VALENCE_MERGED;
    for (int later = 0; later < 2 && found.count < found.wanted; ++later) {
        uint32_t member = vertex;
        do {
            if (later)
                look_in_pairs(around, member, &found);
            else
                look_in_cell(around, member, &found);
            member = merged ? around->circle[member] : vertex;
        } while (member != vertex && found.count < found.wanted);
    }
    assert(found.count == found.wanted);
    return found.count;
}
