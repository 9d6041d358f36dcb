// SPDX-License-Identifier: MIT
/* Doubled edges and how they are taken apart.
 *
 * Where all four crossings of an ambiguous face belong to one polygon in each of its two cells, the
 * two segments of the face are two mesh edges between the same two vertices: the non-manifold edge
 * of [MDMC21]. As edges they are separate; only their ends coincide. So each is given two points of
 * its own, in the middle of its own arc, and the quads beside it are split into quads round a point
 * of their own. One round is enough, whatever the clusters: every new vertex belongs to one mesh
 * edge or one quad, so no pair of vertices can meet twice again.
 *
 * Tunnels are restored in the same pass (tunnel_hd.h, tunnel.c): the two vertices that a tunnel
 * joins are cut out. Every mesh edge at such a vertex ends in a point of its own before it, every
 * quad at it gets a corner point before it, and the two rings of points are joined by quads. A quad
 * can have points on its sides and cut corners at once; its fan takes them all. */
#ifndef QNI_DMC_REPAIR_H
#define QNI_DMC_REPAIR_H

#include "core/cube_hd.h"
#include "dmc/dmc.h"

enum { QNI_NO_POINTS = -1, QNI_NOT_CUT = -1, QNI_LARGEST_BOUNDARY = 20 };

/* A lattice edge whose quad is to be split. Numbered in the order of the quads. */
typedef struct qni_quad_split {
    int64_t row;
    int32_t point[3]; /* the lattice point the edge starts from */
    uint8_t axis;
    uint8_t quads; /* it becomes so many */
    uint32_t quad; /* its place in the mesh; known after emission */
    int64_t
        first_extra;   /* where all but the first of its quads go, from the end of the plain mesh */
    int64_t points[4]; /* by ring side: the first of the side's two points, or QNI_NO_POINTS */
    int32_t
        cut_end[4]; /* by ring place: the tunnel's end that cuts this corner off, or QNI_NOT_CUT */
    uint8_t cut_edge[4];    /* which of the end's edges this is */
    uint8_t cut_side[4][2]; /* which of the end's segments lies on the ring side before the place,
                               and on the one after it */
    uint32_t corners[4];    /* of the quad before it was split */
    uint32_t twins[4];      /* likewise */
    uint8_t forward;        /* the quad runs along its ring */
    uint8_t turn; /* spokes go to every second boundary vertex, from this one on: 0 or 1 */
} qni_quad_split;

/* One of the two polygons a tunnel joins: its edges in their order, and the segments between them:
 * n joins edges n and n + 1. */
typedef struct qni_tunnel_end {
    uint8_t edge[QNI_EDGES]; /* of the cell */
    int32_t count;
    int64_t split[QNI_EDGES]; /* of each edge's quad */
    int64_t first_point; /* of the segments, then of all edges but the first, whose point takes the
                            vertex's place */
    uint32_t vertex;     /* the polygon's vertex, cut out; known after emission */
} qni_tunnel_end;

/* How the rings of a tunnel's ends are joined. The ring of an end runs as its quads' boundaries do,
 * from the first edge's point on: points of edges at even places, of segments at odd ones. */
typedef struct qni_tunnel_tube {
    int64_t first_quad; /* from the end of the split quads */
    int32_t longer;     /* the end with more edges */
    int32_t start[2];   /* of the longer ring, which is walked backward, and of the shorter one */
} qni_tunnel_tube;

typedef struct qni_repair {
    qni_doubled_face *faces;
    int64_t face_count;
    qni_quad_split *splits;
    int64_t split_count, split_capacity;
    qni_tunnel_cell *tunnels;
    qni_tunnel_end *ends;   /* two a tunnel */
    qni_tunnel_tube *tubes; /* one a tunnel */
    int64_t tunnel_count;
    int64_t tunnel_points, split_quads; /* points the ends add; quads the splits add */
    int64_t extra_vertices, extra_quads;
    int64_t fallback_points; /* points left on their face: the arc touches its border there */
} qni_repair;

/* Look whether a low face of a cell is doubled; `entry` is the cell's. */
bool qni_face_is_doubled(const qni_field *field, const int64_t cell[3], int axis, int entry,
                         qni_doubled_face *face_out);

/* Look whether all edges of the tunnel's two polygons have quads. */
bool qni_tunnel_has_quads(const qni_field *field, const qni_tunnel_cell *tunnel);

/* From the faces and tunnels that counting found: the quads to split, what the mesh will have more.
 */
qn_status qni_repair_plan(qni_dmc *dmc, qn_error *error);
/* The first split of a row, and the end of its splits. */
int64_t qni_repair_row_split(const qni_repair *repair, int64_t row);
/* Write the new vertices and quads into a mesh with room for them; after emission, which fills in
 * where the quads are. The mesh's plain part comes first, so all that needs no repair stays where
 * it is. */
void qni_repair_apply(qni_dmc *dmc, const qni_frame *frame, bool reverse, qn_mesh *mesh);
/* The halfedges of the split quads and of their neighbours; after qni_repair_apply(). */
void qni_repair_link(qni_dmc *dmc, qn_mesh *mesh);
/* Valences of the vertices that repair or the rim made or changed, colours of the quads. */
void qni_repair_count_valences(const qni_dmc *dmc, const qn_mesh *mesh);
void qni_repair_free(qni_dmc *dmc);

#endif
