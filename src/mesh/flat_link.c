// SPDX-License-Identifier: MIT
/* Neighbours of triangles: sides in lists by their first vertex, so that twins are found without
 * sorting. */
#include "mesh/flat_parts.h"
#include "core/context.h"

#include <string.h>

static uint32_t find_side(const qni_flat *flat, const uint32_t *first, const uint32_t *sides,
                          uint32_t from, uint32_t to) {
    for (uint32_t n = first[from]; n < first[from + 1]; ++n)
        if (flat->corners[qni_flat_next(sides[n])] == to)
            return sides[n];
    return QN_NO_HALFEDGE;
}

static void link_sides(qni_flat *flat, uint32_t *first, uint32_t *sides) {
    const uint32_t count = (uint32_t)(3 * flat->triangles);
    for (uint32_t h = 0; h < count; ++h)
        ++first[flat->corners[h] + 2];
    for (int64_t v = 0; v < flat->vertices; ++v)
        first[v + 2] += first[v + 1];
    for (uint32_t h = 0; h < count;
         ++h) /* from where its vertex' begin to where the next ones do */
        sides[first[flat->corners[h] + 1]++] = h;
    for (int64_t v = 0; v < flat->vertices; ++v)
        flat->starts[v] = first[v] < first[v + 1] ? sides[first[v]] : QN_NO_HALFEDGE;
    for (uint32_t h = 0; h < count; ++h)
        flat->twins[h] =
            find_side(flat, first, sides, flat->corners[qni_flat_next(h)], flat->corners[h]);
}

bool qni_flat_link(qni_flat *flat) {
    const int64_t count = 3 * flat->triangles;
    uint32_t *first = qni_alloc_zero(flat->context, flat->vertices + 2, sizeof *first);
    uint32_t *sides = qni_alloc(flat->context, count, sizeof *sides);
    if (first && sides)
        link_sides(flat, first, sides);
    qni_free(flat->context, sides, count, sizeof *sides);
    qni_free(flat->context, first, flat->vertices + 2, sizeof *first);
    return first && sides;
}

/* The side from a to b, or QN_NO_HALFEDGE; *joined when there is one from b to a at least. */
static uint32_t side_between(const qni_flat *flat, uint32_t a, uint32_t b, bool *joined) {
    const uint32_t start = flat->starts[a];
    *joined = false;
    for (int back = 0; back < 2; ++back) {
        uint32_t h = start;
        while (h != QN_NO_HALFEDGE) {
            if (flat->corners[qni_flat_next(h)] == b) {
                *joined = true;
                return h;
            }
            *joined = *joined || flat->corners[qni_flat_before(h)] == b;
            const uint32_t twin = flat->twins[back ? h : qni_flat_before(h)];
            h = back && twin != QN_NO_HALFEDGE ? qni_flat_next(twin) : twin;
            if (h == start)
                return QN_NO_HALFEDGE;
        }
    }
    return QN_NO_HALFEDGE;
}

bool qni_flat_joined(const qni_flat *flat, uint32_t a, uint32_t b) {
    bool joined;
    side_between(flat, a, b, &joined);
    return joined;
}

void qni_flat_mark_creases(qni_flat *flat) {
    const qn_mesh *mesh = flat->mesh;
    memset(flat->creased, 0, 3 * (size_t)flat->triangles);
    for (int64_t n = 0; n < mesh->crease_edge_count; ++n)
        for (int way = 0; way < 2; ++way) {
            bool joined;
            const uint32_t h = side_between(flat, mesh->crease_edges[2 * n + way],
                                            mesh->crease_edges[2 * n + 1 - way], &joined);
            if (h != QN_NO_HALFEDGE)
                flat->creased[h] = 1;
        }
}
