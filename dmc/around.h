// SPDX-License-Identifier: MIT
/* The quads round a vertex of a mesh that is being simplified: by its halfedges where it has some,
 * else by the grid that it came from. */
#ifndef QNI_DMC_AROUND_H
#define QNI_DMC_AROUND_H

#include "dmc/simplify_hd.h"
#include "core/cube_hd.h"
#include "mesh/mesh.h"

/* Where the leaves' vertices and quads start. A vertex has its quads round the edges of its cell;
 * exceptions are in `rewritten`. */
typedef struct qni_leaf_index {
    int64_t leaves;
    uint32_t *vertex_start, *quad_start; /* [leaves + 1] */
    uint32_t *hint;                      /* [vertices / 64 + 1]: a leaf at or before vertex 64 n */
    uint32_t *row;                       /* [leaves] */
    struct qni_leaf_row *rows;           /* [rows] */
    struct qni_leaf_place *place;        /* [leaves] */
    const uint32_t *quads;               /* the mesh's */
    int64_t rewritten_count;
    uint32_t *rewritten; /* quads that are not as emitted, and those after the leaves' */
    const struct qni_dmc *dmc;
} qni_leaf_index;

qn_status qni_leaf_index_build(const struct qni_dmc *dmc, const qn_mesh *mesh,
                               qni_leaf_index *index_out, qn_error *error);
void qni_leaf_index_free(const struct qni_dmc *dmc, qni_leaf_index *index);
/* Ask for what is needed to find a vertex' quads. */
void qni_leaf_index_prefetch(const qni_leaf_index *index, uint32_t vertex);
/* The quads of the lattice edges of the cell that a vertex was emitted in; how many. All of them
 * were emitted with the vertex if it is `alone` in its cell. */
int qni_leaf_index_quads(const qni_leaf_index *index, uint32_t vertex, uint32_t quads[QNI_EDGES],
                         bool *alone_out);

/* The four quads that lie round this one, in no order, if it closes a bump round an end of its
 * lattice edge; and the one on the edge beyond that end, or QNI_UNPAIRED. A guess from the grid: if
 * the mesh is no longer as it was emitted they may be others. False when some do not exist. */
bool qni_leaf_index_ring(const qni_leaf_index *index, uint32_t quad, int axis, uint32_t ring[4],
                         uint32_t *beyond);

/* Pairs of vertex and quad, to be found by the vertex. */
typedef struct qni_pairs {
    uint32_t *head;      /* [1 << bits]: the first pair of each chain, counted from 1; 0: none */
    uint32_t (*pair)[3]; /* [capacity]: vertex, quad, next */
    int64_t count, capacity, heads;
} qni_pairs;

/* Corners name vertices as emitted. Vertices that were merged form a circle through `circle`, in
 * which all but one are gone; it is set where a vertex is QNI_VALENCE_MERGED, or gone. */
typedef struct qni_around {
    qn_context *context;
    const qn_mesh *mesh;
    uint8_t *valence; /* [vertices] */
    uint8_t *colour;  /* [quads] */
    uint32_t *circle; /* [vertices] */
    const qni_leaf_index *index;
    qni_pairs pairs;
} qni_around;

/* `index` is not needed with halfedges. */
qn_status qni_around_init(qni_around *around, qn_error *error);
void qni_around_free(qni_around *around);
/* Tell of a quad that got a corner it was not emitted with. */
qn_status qni_around_note(qni_around *around, uint32_t vertex, uint32_t quad, qn_error *error);

static inline uint32_t qni_vertex_now(const qni_around *around, uint32_t vertex) {
    while (around->valence[vertex] == QNI_VALENCE_GONE)
        vertex = around->circle[vertex];
    return vertex;
}

static inline int qni_valence_now(const qni_around *around, uint32_t vertex) {
    return around->valence[vertex] & QNI_VALENCE_MASK;
}

static inline void qni_corners_now(const qni_around *around, uint32_t quad, uint32_t corner[4]) {
    for (int k = 0; k < 4; ++k)
        corner[k] = qni_vertex_now(around, around->mesh->quads[4 * (size_t)quad + (size_t)k]);
}

/* The quads round a vertex that is neither gone nor fixed, in no order; as many as its valence. */
int qni_quads_round(const qni_around *around, uint32_t vertex, uint32_t quads[QNI_VALENCE_LARGEST]);
/* The same where one of them is known: one that it was not emitted with is soonest found so. */
int qni_quads_round_with(const qni_around *around, uint32_t vertex, uint32_t known,
                         uint32_t quads[QNI_VALENCE_LARGEST]);

#endif
