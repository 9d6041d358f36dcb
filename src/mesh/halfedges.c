// SPDX-License-Identifier: MIT
/* Halfedges of any mesh from its indices: sides sorted by their two vertices, neighbours in that
 * order are twins. The grid gives them without sorting (dmc/link.c); this is for meshes that come
 * from elsewhere, and the judge of the other. */
#include "mesh/mesh.h"
#include "core/context.h"
#include "core/sort.h"
#include "core/status.h"

typedef struct side {
    uint32_t low, high; /* its vertices */
    uint32_t halfedge;
} side;

qn_status qni_mesh_alloc_halfedges(qn_context *context, qn_mesh *mesh, qn_error *error) {
    qni_mesh_free_halfedges(mesh);
    const int64_t count = mesh->quad_count ? 4 * mesh->quad_count : 3 * mesh->triangle_count;
    if (mesh->quad_count && mesh->triangle_count)
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "halfedges need a mesh of quads alone or of triangles alone: split the quads first");
    if (count > UINT32_MAX - 1)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the mesh has %lld halfedges, more than the 2^32 - 2 that can be numbered",
                        (long long)count);
    const int64_t room = count + 4 * mesh->quad_slack,
                  vertex_room = mesh->vertex_count + mesh->vertex_slack;
    uint32_t *twins = qni_alloc(context, room, sizeof *twins);
    uint32_t *of_vertices = qni_alloc(context, vertex_room, sizeof *of_vertices);
    if (!twins || !of_vertices) {
        qni_free(context, twins, room, sizeof *twins);
        qni_free(context, of_vertices, vertex_room, sizeof *of_vertices);
        return qni_fail_memory(error, "the halfedges");
    }
    mesh->twins = twins;
    mesh->vertex_halfedges = of_vertices;
    mesh->halfedge_count = count;
    return QN_OK;
}

void qni_mesh_free_halfedges(qn_mesh *mesh) {
    qni_free(mesh->context, mesh->twins, mesh->halfedge_count + 4 * mesh->quad_slack,
             sizeof *mesh->twins);
    qni_free(mesh->context, mesh->vertex_halfedges, mesh->vertex_count + mesh->vertex_slack,
             sizeof *mesh->vertex_halfedges);
    mesh->twins = mesh->vertex_halfedges = NULL;
    mesh->halfedge_count = 0;
}

qn_halfedges qn_mesh_get_halfedges(const qn_mesh *mesh) {
    qn_halfedges halfedges = {mesh->quad_count ? 4 : 3, mesh->halfedge_count, mesh->twins,
                              mesh->vertex_halfedges};
    return halfedges;
}

static int compare_sides(const void *a, const void *b) {
    const side *s = a, *t = b;
    if (s->low != t->low)
        return s->low < t->low ? -1 : 1;
    if (s->high != t->high)
        return s->high < t->high ? -1 : 1;
    return s->halfedge < t->halfedge ? -1 : s->halfedge > t->halfedge;
}

static uint32_t next_of(uint32_t h, uint32_t corners) {
    return h % corners == corners - 1 ? h + 1 - corners : h + 1;
}

static void pair_equal_sides(const qn_mesh *mesh, const uint32_t *origin, const side *from,
                             const side *end) {
    for (const side *s = from; s < end; ++s)
        mesh->twins[s->halfedge] = QN_NO_HALFEDGE;
    if (end - from == 2 && origin[from[0].halfedge] != origin[from[1].halfedge]) {
        mesh->twins[from[0].halfedge] = from[1].halfedge;
        mesh->twins[from[1].halfedge] = from[0].halfedge;
    }
}

static void choose_vertex_halfedges(qn_mesh *mesh, const uint32_t *origin) {
    for (int64_t v = 0; v < mesh->vertex_count; ++v)
        mesh->vertex_halfedges[v] = QN_NO_HALFEDGE;
    for (int64_t h = mesh->halfedge_count - 1; h >= 0; --h) {
        uint32_t *chosen = mesh->vertex_halfedges + origin[h];
        const bool ends_fan = mesh->twins[h] == QN_NO_HALFEDGE;
        if (*chosen == QN_NO_HALFEDGE || ends_fan || mesh->twins[*chosen] != QN_NO_HALFEDGE)
            *chosen = (uint32_t)h;
    }
}

qn_status qn_mesh_build_halfedges(qn_context *context, qn_mesh *mesh, qn_error *error) {
    QN_TRY(qni_mesh_alloc_halfedges(context, mesh, error));
    const uint32_t corners = mesh->quad_count ? 4 : 3;
    const uint32_t *origin = mesh->quad_count ? mesh->quads : mesh->triangles;
    const int64_t count = mesh->halfedge_count;
    side *sides = qni_alloc(context, count, sizeof *sides);
    if (!sides) {
        qni_mesh_free_halfedges(mesh);
        return qni_fail_memory(error, "the sides of the mesh");
    }
    for (int64_t h = 0; h < count; ++h) {
        const uint32_t a = origin[h], b = origin[next_of((uint32_t)h, corners)];
        sides[h] = (side){a < b ? a : b, a < b ? b : a, (uint32_t)h};
    }
    if (!qni_sort(context, sides, count, sizeof *sides, compare_sides)) {
        qni_free(context, sides, count, sizeof *sides);
        qni_mesh_free_halfedges(mesh);
        return qni_fail_memory(error, "the sides of the mesh");
    }
    for (int64_t from = 0, end; from < count; from = end) {
        for (end = from + 1; end < count && sides[end].low == sides[from].low &&
                             sides[end].high == sides[from].high;)
            ++end;
        pair_equal_sides(mesh, origin, sides + from, sides + end);
    }
    qni_free(context, sides, count, sizeof *sides);
    choose_vertex_halfedges(mesh, origin);
    return QN_OK;
}
