// SPDX-License-Identifier: MIT
/* Taking crossings out of a mesh of quads made on a lattice: vertices near them are drawn towards
 * the middle of the faces round them until no two triangles cross. Faces and their order stay. */
#ifndef QNI_MESH_UNTANGLE_H
#define QNI_MESH_UNTANGLE_H

#include "mesh/mesh.h"

typedef struct qni_untangle_options {
    double to_world[4][4]; /* from lattice points: the mesh has one vertex in most cells it meets,
                            * and faces reach from a cell to its neighbours only; invertible */
    bool gives_inward;     /* sheets that lie on each other have the outside between them, not the
                            * inside */
    bool everywhere;       /* look for crossings among all faces, not only where they are not proved
                            * to be impossible */
} qni_untangle_options;

typedef struct qni_untangle_report {
    int64_t searched_quads; /* among which crossings were looked for */
    int64_t crossings;      /* pairs of triangles found */
    int64_t crossings_left; /* of those that mending could not part, or made */
    int64_t moved_vertices;
    double farthest; /* the largest move, in lattice cells */
    int32_t rounds;
} qni_untangle_report;

/* What is found and done depends on the positions and quads alone, and is the same for every thread
 * count. Only positions change. Triangles are left out of account.
 *
 * QN_ERROR_OUT_OF_MEMORY, QN_ERROR_CANCELLED */
qn_status qni_mesh_untangle(qn_context *context, qn_mesh *mesh, const qni_untangle_options *options,
                            qni_untangle_report *report_out, qn_error *error);

/* ---- parts of it ----------------------------------------------------------------------------- */

/* A set of vertices or quads, a bit each. */
typedef struct qni_vertex_set {
    int64_t count; /* of all there are */
    uint64_t *bits;
} qni_vertex_set;

static inline bool qni_in_set(const qni_vertex_set *set, int64_t vertex) {
    return set->bits[vertex / 64] >> (vertex % 64) & 1;
}

/* Some quads of a mesh with the vertices they use, numbered anew in the old order. */
typedef struct qni_mesh_part {
    int64_t vertex_count, quad_count;
    uint32_t *vertices; /* [vertex_count]: their numbers in the mesh */
    float *positions;   /* [vertex_count][3] */
    uint32_t *quads;    /* [quad_count][4], of the part's own numbers */
} qni_mesh_part;

qn_status qni_vertex_set_alloc(qn_context *context, int64_t count, qni_vertex_set *set,
                               qn_error *error);
void qni_vertex_set_free(qn_context *context, qni_vertex_set *set);

int64_t qni_vertex_set_count(const qni_vertex_set *set);

/* Vertices at which no two quads cross, into an empty set; more may be such. `unit` is about the
 * size of a lattice cell. */
qn_status qni_untangle_sound(qn_context *context, const qn_mesh_view *mesh, double unit,
                             const qni_vertex_set *sound, qn_error *error);

/* Where crossings can be: all else is proved to have none (untangle_suspects.c). */
typedef struct qni_suspects {
    int64_t count;
    bool too_large;       /* a quad is: look everywhere */
    qni_vertex_set quads; /* of two that cross one is here, */
    qni_vertex_set near;  /* and the other one, too, or it has a corner here */
    qni_vertex_set sound; /* vertices at which no two quads cross */
} qni_suspects;

qn_status qni_untangle_suspects(qn_context *context, const qn_mesh_view *mesh,
                                const double to_lattice[3][4], qni_suspects *suspects_out,
                                qn_error *error);
void qni_suspects_free(qn_context *context, qni_suspects *suspects);

/* The vertices within `reach` lattice cells of a vertex of the set, at least; none twice as far. */
qn_status qni_vertices_near(qn_context *context, const qn_mesh_view *mesh,
                            const double to_lattice[3][4], const qni_vertex_set *near, int reach,
                            qni_vertex_set *close_out, qn_error *error);
/* The quads that have a corner within `reach` lattice cells of a vertex of the set, at least. */
qn_status qni_mesh_part_near(qn_context *context, const qn_mesh_view *mesh,
                             const double to_lattice[3][4], const qni_vertex_set *near, int reach,
                             qni_mesh_part *part, qn_error *error);
/* Those of a set, and those with a corner of a set of vertices. */
qn_status qni_mesh_part_of(qn_context *context, const qn_mesh_view *mesh,
                           const qni_vertex_set *quads, const qni_vertex_set *vertices,
                           qni_mesh_part *part, qn_error *error);
qn_status qni_mesh_part_all(qn_context *context, const qn_mesh_view *mesh, qni_mesh_part *part,
                            qn_error *error);
void qni_mesh_part_free(qn_context *context, qni_mesh_part *part);

#endif
