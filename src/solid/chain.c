// SPDX-License-Identifier: MIT
/* From a mesh to a chain of triangles whose vertices are joined by place; its edges, sorted. */
#include "solid/chain.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

typedef struct placed {
    float at[3];
    uint32_t number;
} placed;

static int compare_placed(const void *a, const void *b) {
    const placed *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p->at[k] < q->at[k] || p->at[k] > q->at[k])
            return p->at[k] < q->at[k] ? -1 : 1;
    return p->number < q->number ? -1 : p->number > q->number;
}

static bool is_finite(const float at[3]) {
    return isfinite(at[0]) && isfinite(at[1]) && isfinite(at[2]);
}

enum { NOT_FINITE = -1 };

/* first[v]: the lowest vertex at the same place; NOT_FINITE for those nowhere. */
static bool join_places(qni_chain *chain, const qn_mesh_view *view, int64_t *first) {
    int64_t count = view->vertex_count, used = 0;
    placed *order = qni_alloc(chain->context, count, sizeof *order);
    if (!order)
        return false;
    for (int64_t v = 0; v < count; ++v) {
        first[v] = NOT_FINITE;
        if (!is_finite(view->positions + 3 * v))
            continue;
        for (int k = 0; k < 3; ++k)
            order[used].at[k] = view->positions[3 * v + k] + 0.0f; /* -0 and 0 are one place */
        order[used++].number = (uint32_t)v;
    }
    if (used)
        qsort(order, (size_t)used, sizeof *order, compare_placed);
    for (int64_t n = 0; n < used; ++n) {
        bool same = n > 0 && memcmp(order[n].at, order[n - 1].at, sizeof order[n].at) == 0;
        first[order[n].number] = same ? first[order[n - 1].number] : (int64_t)order[n].number;
        chain->joined += same;
    }
    qni_free(chain->context, order, count, sizeof *order);
    return true;
}

static void add(qni_chain *chain, const int64_t *first, const uint32_t corners[3], int32_t owner) {
    int64_t at[3];
    for (int i = 0; i < 3; ++i)
        at[i] = first[corners[i]];
    if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) {
        ++chain->dropped;
        return;
    }
    for (int i = 0; i < 3; ++i)
        chain->triangles[chain->count][i] = (uint32_t)at[i];
    chain->owners[chain->count++] = owner;
}

static void add_faces(qni_chain *chain, const qn_mesh_view *view, const int64_t *first,
                      int32_t owner, bool keep_owners) {
    for (int64_t n = 0; n < view->quad_count; ++n) {
        uint32_t two[6];
        const uint32_t *quad = view->quads + 4 * n;
        qni_split_quad(view->positions, quad, two);
        int32_t own = keep_owners && view->quad_owners ? view->quad_owners[n] : owner;
        add(chain, first, two, own);
        add(chain, first, two + 3, own);
    }
    for (int64_t n = 0; n < view->triangle_count; ++n)
        add(chain, first, view->triangles + 3 * n,
            keep_owners && view->triangle_owners ? view->triangle_owners[n] : owner);
}

bool qni_chain_from_mesh(qn_context *context, const qn_mesh_view *view, int32_t owner,
                         bool keep_owners, qni_chain *chain) {
    *chain = (qni_chain){.context = context};
    chain->vertex_count = view->vertex_count;
    chain->capacity = 2 * view->quad_count + view->triangle_count;
    chain->places = qni_alloc(context, chain->vertex_count, sizeof *chain->places);
    chain->triangles = qni_alloc(context, chain->capacity, sizeof *chain->triangles);
    chain->owners = qni_alloc(context, chain->capacity, sizeof *chain->owners);
    int64_t *first = qni_alloc(context, chain->vertex_count, sizeof *first);
    bool good = chain->places && chain->triangles && chain->owners && first &&
                join_places(chain, view, first);
    if (good) {
        for (int64_t v = 0; v < 3 * view->vertex_count; ++v)
            chain->places[v / 3][v % 3] = view->positions[v] + 0.0f;
        add_faces(chain, view, first, owner, keep_owners);
    }
    qni_free(context, first, chain->vertex_count, sizeof *first);
    return good;
}

void qni_chain_drop_edges(qni_chain *chain) {
    qni_free(chain->context, chain->edges, 3 * chain->count, sizeof *chain->edges);
    chain->edges = NULL;
}

void qni_chain_free(qni_chain *chain) {
    qn_context *context = chain->context;
    qni_free(context, chain->places, chain->vertex_count, sizeof *chain->places);
    qni_free(context, chain->triangles, chain->capacity, sizeof *chain->triangles);
    qni_free(context, chain->owners, chain->capacity, sizeof *chain->owners);
    qni_chain_drop_edges(chain);
    *chain = (qni_chain){.context = context};
}

static int compare_edges(const void *a, const void *b) {
    const qni_chain_edge *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    if (p->high != q->high)
        return p->high < q->high ? -1 : 1;
    return p->side < q->side ? -1 : p->side > q->side;
}

static qni_chain_edge edge_of(const qni_chain *chain, int64_t side) {
    const uint32_t from = chain->triangles[side / 3][side % 3],
                   to = chain->triangles[side / 3][(side + 1) % 3];
    const qni_chain_edge edge = {from < to ? from : to, from < to ? to : from, (uint32_t)side,
                                 from < to ? 1 : -1};
    return edge;
}

/* Of one lower vertex, a handful most often; in the order of their sides before. */
static void sort_bucket(qni_chain_edge *edges, int64_t count) {
    enum { FEW = 24 };
    if (count > FEW) {
        qsort(edges, (size_t)count, sizeof *edges, compare_edges);
        return;
    }
    for (int64_t n = 1; n < count; ++n) {
        const qni_chain_edge edge = edges[n];
        int64_t m = n;
        for (; m > 0 && edges[m - 1].high > edge.high; --m)
            edges[m] = edges[m - 1];
        edges[m] = edge;
    }
}

/* Counted by their lower vertices. */
static bool sort_edges(qni_chain *chain) {
    const int64_t count = 3 * chain->count;
    uint32_t *ends = qni_alloc_zero(chain->context, chain->vertex_count + 1, sizeof *ends);
    if (!ends)
        return false;
    for (int64_t n = 0; n < count; ++n)
        ++ends[edge_of(chain, n).low + 1];
    for (int64_t v = 0; v < chain->vertex_count; ++v)
        ends[v + 1] += ends[v];
    for (int64_t n = 0; n < count; ++n) {
        const qni_chain_edge edge = edge_of(chain, n);
        chain->edges[ends[edge.low]++] = edge;
    }
    for (int64_t v = 0, from = 0; v < chain->vertex_count; from = ends[v++])
        sort_bucket(chain->edges + from, ends[v] - from);
    qni_free(chain->context, ends, chain->vertex_count + 1, sizeof *ends);
    return true;
}

bool qni_chain_find_edges(qni_chain *chain) {
    int64_t count = 3 * chain->count;
    if (!chain->edges)
        chain->edges = qni_alloc(chain->context, count, sizeof *chain->edges);
    if (!chain->edges || !sort_edges(chain))
        return false;
    chain->rim_edges = chain->odd_edges = 0;
    for (int64_t n = 0, end; n < count; n = end) {
        int64_t net = 0;
        for (end = n; end < count && chain->edges[end].low == chain->edges[n].low &&
                      chain->edges[end].high == chain->edges[n].high;
             ++end)
            net += chain->edges[end].way;
        chain->rim_edges += net < 0 ? -net : net;
        chain->odd_edges += (end - n) % 2;
    }
    return true;
}

qni_panel qni_chain_panel(const qni_chain *chain, int64_t triangle) {
    qni_panel panel = {.owner = chain->owners[triangle], .number = (int32_t)triangle};
    for (int i = 0; i < 3; ++i)
        memcpy(panel.at[i], chain->places[chain->triangles[triangle][i]], sizeof panel.at[i]);
    return panel;
}
