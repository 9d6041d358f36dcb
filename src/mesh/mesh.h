// SPDX-License-Identifier: MIT
/* A mesh from inside. */
#ifndef QNI_MESH_MESH_H
#define QNI_MESH_MESH_H

#include <qn/mesh.h>

struct qn_mesh {
    qn_context *context;
    int64_t vertex_count, quad_count, triangle_count;
    float *positions;           /* [vertex_count][3] */
    float *normals;             /* [vertex_count][3] or NULL */
    uint32_t *quads;            /* [quad_count][4] or NULL */
    uint32_t *triangles;        /* [triangle_count][3] or NULL */
    uint32_t *twins;            /* [halfedge_count] or NULL */
    uint32_t *vertex_halfedges; /* [vertex_count] or NULL, together with twins */
    int64_t halfedge_count;     /* 4 quad_count or 3 triangle_count when there are twins, else 0 */
    int64_t vertex_slack,
        quad_slack; /* room in the arrays beyond the counts, where some were dropped in place */
    char space[32];
    char unit[16];
    int32_t *triangle_owners; /* [triangle_count] or NULL */
    int64_t crease_edge_count;
    uint32_t *crease_edges;   /* [crease_edge_count][2] or NULL */
    int32_t *quad_owners;     /* [quad_owner_count] or NULL */
    int64_t quad_owner_count; /* quad_count when there are owners */
};

/* A mesh with room for the given counts, its arrays not yet filled; arrays of count 0 are NULL. */
qn_status qni_mesh_alloc(qn_context *context, int64_t vertex_count, int64_t quad_count,
                         int64_t triangle_count, bool with_normals, qn_mesh **mesh_out,
                         qn_error *error);

/* Room for the halfedges of a mesh of one kind of face, and giving it up (before faces or vertices
 * change). */
qn_status qni_mesh_alloc_halfedges(qn_context *context, qn_mesh *mesh, qn_error *error);
void qni_mesh_free_halfedges(qn_mesh *mesh);

/* Move a mesh of triangles without normals; `mirrors` turns them round, so that they stay wound
 * counter-clockwise seen from outside. */
void qni_mesh_move(qn_mesh *mesh, const double matrix[3][4], bool mirrors);

/* Which diagonal the MaxMin angle criterion takes: true for corners 0-2, false for 1-3. */
bool qni_quad_splits_02(const float *positions, const uint32_t quad[4]);
/* The two triangles of that split. */
void qni_split_quad(const float *positions, const uint32_t quad[4], uint32_t triangles[6]);

#endif
