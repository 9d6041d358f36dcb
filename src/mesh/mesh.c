// SPDX-License-Identifier: MIT
/* The mesh's life: making, viewing, destroying. */
#include "mesh/mesh.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

static const int64_t largest_vertex_count = UINT32_MAX;

qn_status qni_mesh_alloc(qn_context *context, int64_t vertex_count, int64_t quad_count,
                         int64_t triangle_count, bool with_normals, qn_mesh **mesh_out,
                         qn_error *error) {
    *mesh_out = NULL;
    if (vertex_count < 0 || quad_count < 0 || triangle_count < 0)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "a mesh cannot have a negative count");
    if (vertex_count > largest_vertex_count)
        return qni_fail(
            error, QN_ERROR_OUT_OF_MEMORY,
            "the mesh would have %lld vertices, more than the 2^32 - 1 that its indices "
            "can name: take a coarser volume, or a part of it",
            (long long)vertex_count);
    qn_mesh *mesh = qni_alloc_zero(context, 1, sizeof *mesh);
    if (!mesh)
        return qni_fail_memory(error, "a mesh");
    mesh->context = context;
    mesh->vertex_count = vertex_count;
    mesh->quad_count = quad_count;
    mesh->triangle_count = triangle_count;
    bool good = true;
    if (vertex_count)
        good = good && (mesh->positions = qni_alloc(context, vertex_count, 3 * sizeof(float)));
    if (vertex_count && with_normals)
        good = good && (mesh->normals = qni_alloc(context, vertex_count, 3 * sizeof(float)));
    if (quad_count)
        good = good && (mesh->quads = qni_alloc(context, quad_count, 4 * sizeof(uint32_t)));
    if (triangle_count)
        good = good && (mesh->triangles = qni_alloc(context, triangle_count, 3 * sizeof(uint32_t)));
    if (!good) {
        qn_mesh_destroy(mesh);
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "not enough memory for a mesh of %lld vertices and %lld faces",
                        (long long)vertex_count, (long long)(quad_count + triangle_count));
    }
    *mesh_out = mesh;
    return QN_OK;
}

static bool indices_in_range(const uint32_t *indices, int64_t count, int64_t vertex_count) {
    for (int64_t i = 0; i < count; ++i)
        if ((int64_t)indices[i] >= vertex_count)
            return false;
    return true;
}

/* Owners and creases; on failure the mesh is destroyed. */
static qn_status copy_tags(qn_mesh *mesh, const qn_mesh_view *view, qn_error *error) {
    bool good = true;
    if (view->triangle_owners && view->triangle_count)
        good = good && (mesh->triangle_owners =
                            qni_alloc(mesh->context, view->triangle_count, sizeof(int32_t)));
    if (view->quad_owners && view->quad_count) {
        mesh->quad_owners = qni_alloc(mesh->context, view->quad_count, sizeof(int32_t));
        mesh->quad_owner_count = mesh->quad_owners ? view->quad_count : 0;
        good = good && mesh->quad_owners;
    }
    if (view->crease_edge_count)
        good = good && (mesh->crease_edges = qni_alloc(mesh->context, view->crease_edge_count,
                                                       2 * sizeof(uint32_t)));
    mesh->crease_edge_count = mesh->crease_edges ? view->crease_edge_count : 0;
    if (!good) {
        qn_mesh_destroy(mesh);
        return qni_fail_memory(error, "a mesh");
    }
    if (mesh->triangle_owners)
        memcpy(mesh->triangle_owners, view->triangle_owners,
               (size_t)mesh->triangle_count * sizeof(int32_t));
    if (mesh->quad_owners)
        memcpy(mesh->quad_owners, view->quad_owners,
               (size_t)mesh->quad_owner_count * sizeof(int32_t));
    if (mesh->crease_edges)
        memcpy(mesh->crease_edges, view->crease_edges,
               (size_t)mesh->crease_edge_count * 2 * sizeof(uint32_t));
    return QN_OK;
}

qn_status qn_mesh_create(qn_context *context, const qn_mesh_view *view, qn_mesh **mesh_out,
                         qn_error *error) {
    *mesh_out = NULL;
    if (!indices_in_range(view->quads, 4 * view->quad_count, view->vertex_count) ||
        !indices_in_range(view->triangles, 3 * view->triangle_count, view->vertex_count) ||
        !indices_in_range(view->crease_edges, 2 * view->crease_edge_count, view->vertex_count))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a face or crease names a vertex beyond the mesh's %lld",
                        (long long)view->vertex_count);
    qn_mesh *mesh;
    QN_TRY(qni_mesh_alloc(context, view->vertex_count, view->quad_count, view->triangle_count,
                          view->normals != NULL, &mesh, error));
    if (mesh->positions)
        memcpy(mesh->positions, view->positions, (size_t)mesh->vertex_count * 3 * sizeof(float));
    if (mesh->normals)
        memcpy(mesh->normals, view->normals, (size_t)mesh->vertex_count * 3 * sizeof(float));
    if (mesh->quads)
        memcpy(mesh->quads, view->quads, (size_t)mesh->quad_count * 4 * sizeof(uint32_t));
    if (mesh->triangles)
        memcpy(mesh->triangles, view->triangles,
               (size_t)mesh->triangle_count * 3 * sizeof(uint32_t));
    QN_TRY(copy_tags(mesh, view, error));
    if (view->space)
        strncpy(mesh->space, view->space, sizeof mesh->space - 1);
    if (view->unit)
        strncpy(mesh->unit, view->unit, sizeof mesh->unit - 1);
    *mesh_out = mesh;
    return QN_OK;
}

void qn_mesh_destroy(qn_mesh *mesh) {
    if (!mesh)
        return;
    qni_mesh_free_halfedges(mesh);
    qni_free(mesh->context, mesh->positions, mesh->vertex_count + mesh->vertex_slack,
             3 * sizeof(float));
    qni_free(mesh->context, mesh->normals, mesh->vertex_count + mesh->vertex_slack,
             3 * sizeof(float));
    qni_free(mesh->context, mesh->quads, mesh->quad_count + mesh->quad_slack, 4 * sizeof(uint32_t));
    qni_free(mesh->context, mesh->triangles, mesh->triangle_count, 3 * sizeof(uint32_t));
    qni_free(mesh->context, mesh->triangle_owners, mesh->triangle_count, sizeof(int32_t));
    qni_free(mesh->context, mesh->quad_owners, mesh->quad_owner_count, sizeof(int32_t));
    qni_free(mesh->context, mesh->crease_edges, mesh->crease_edge_count, 2 * sizeof(uint32_t));
    qni_free(mesh->context, mesh, 1, sizeof *mesh);
}

qn_mesh_view qn_mesh_get_view(const qn_mesh *mesh) {
    qn_mesh_view view = {
        mesh->vertex_count, mesh->quad_count,      mesh->triangle_count,    mesh->positions,
        mesh->normals,      mesh->quads,           mesh->triangles,         mesh->space,
        mesh->unit,         mesh->triangle_owners, mesh->crease_edge_count, mesh->crease_edges,
        mesh->quad_owners};
    return view;
}
