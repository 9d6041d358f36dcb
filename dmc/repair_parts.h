// SPDX-License-Identifier: MIT
/* The parts that splitting quads, restoring tunnels and linking both share: where each new vertex,
 * quad and halfedge is.
 *
 * The boundary of a split quad runs, for each old side k: the corner, or the point that cuts it
 * off; if it is cut off, the point on side k before it; the two points of a doubled edge; if the
 * next corner is cut off, the point before that. */
#ifndef QNI_DMC_REPAIR_PARTS_H
#define QNI_DMC_REPAIR_PARTS_H

#include "dmc/repair.h"
#include "dmc/ring_hd.h"

typedef struct qni_repair_job {
    const qni_dmc *dmc;
    const qni_frame *frame;
    qn_mesh *mesh;
    bool reverse;
} qni_repair_job;

/* Corner values of a cell. */
void qni_repair_load_corners(const qni_field *field, const int64_t cell[3], double d[8]);
/* Write a vertex from its place in a cell. */
void qni_repair_place(const qni_repair_job *job, const int64_t cell[3], const double local[3],
                      int64_t vertex);
void qni_repair_place_from(const qni_repair_job *job, const int64_t cell[3],
                           const double stencil[QNI_STENCIL], const double local[3],
                           int64_t vertex);

/* Where an edge of a cell meets the surface. */
void qni_edge_crossing(const double d[8], int edge, double local[3]);
/* Along the gradient onto the interpolant of a cell, by Newton's method; false, and nothing
 * changed, when that leaves the cell or goes further than `reach`. */
bool qni_bring_to_surface(const double d[8], double reach, double local[3]);

/* tunnel.c: the points of a tunnel's end, which needs its quads as emitted; the quads between its
 * two ends, and their halfedges. */
int qni_tunnel_place_end(const qni_repair_job *job, int64_t index);
void qni_tunnel_close(const qni_repair_job *job, int64_t index);
void qni_tunnel_link(const qni_dmc *dmc, int64_t index, uint32_t *twins);

/* ---- vertices -------------------------------------------------------------------------------- */

static inline uint32_t qni_centre_vertex(const qni_dmc *dmc, int64_t split) {
    return (uint32_t)(dmc->vertex_count + 4 * dmc->repair->face_count + split);
}

static inline uint32_t qni_end_first_vertex(const qni_dmc *dmc, const qni_tunnel_end *end) {
    return qni_centre_vertex(dmc, dmc->repair->split_count) + (uint32_t)end->first_point;
}

static inline uint32_t qni_end_segment_vertex(const qni_dmc *dmc, const qni_tunnel_end *end,
                                              int segment) {
    return qni_end_first_vertex(dmc, end) + (uint32_t)segment;
}

/* The first edge's point takes the place of the vertex that is cut out. */
static inline uint32_t qni_end_edge_vertex(const qni_dmc *dmc, const qni_tunnel_end *end,
                                           int edge) {
    return edge == 0 ? end->vertex
                     : qni_end_first_vertex(dmc, end) + (uint32_t)(end->count + edge - 1);
}

/* ---- boundaries of split quads --------------------------------------------------------------- */

/* The ring side of side k; the ring place of corner k. */
static inline int qni_split_ring_side(const qni_quad_split *split, int k) {
    return qni_quad_side(k, split->forward);
}

static inline int qni_split_place(const qni_quad_split *split, int k) {
    return qni_quad_corner(k, split->forward);
}

static inline bool qni_split_cuts(const qni_quad_split *split, int k) {
    return split->cut_end[qni_split_place(split, k & 3)] != QNI_NOT_CUT;
}

static inline bool qni_split_doubles(const qni_quad_split *split, int k) {
    return split->points[qni_split_ring_side(split, k)] != QNI_NO_POINTS;
}

/* The point that cuts corner k off, and the point before it on the side after the corner, or on the
 * one before the corner. */
static inline uint32_t qni_cut_corner_vertex(const qni_dmc *dmc, const qni_quad_split *split,
                                             int k) {
    const int place = qni_split_place(split, k & 3);
    return qni_end_edge_vertex(dmc, dmc->repair->ends + split->cut_end[place],
                               split->cut_edge[place]);
}

static inline uint32_t qni_cut_side_vertex(const qni_dmc *dmc, const qni_quad_split *split, int k,
                                           bool after) {
    const int place = qni_split_place(split, k & 3);
    return qni_end_segment_vertex(dmc, dmc->repair->ends + split->cut_end[place],
                                  split->cut_side[place][after == (split->forward != 0)]);
}

static inline int qni_split_boundary_size(const qni_quad_split *split) {
    return 2 * split->quads;
}

/* Where corner k, or the point that cuts it off, is on the boundary. */
static inline int qni_split_corner_at(const qni_quad_split *split, int k) {
    int at = 0;
    for (int n = 0; n < k; ++n)
        at += 1 + qni_split_cuts(split, n) + 2 * qni_split_doubles(split, n) +
              qni_split_cuts(split, n + 1);
    return at;
}

/* Where fan quad j of a split goes. */
static inline int64_t qni_fan_place(const qni_dmc *dmc, const qni_quad_split *split, int j) {
    return j == 0 ? (int64_t)split->quad : dmc->quad_count + split->first_extra + j - 1;
}

/* The halfedge from boundary vertex `at` to the next. */
static inline uint32_t qni_boundary_halfedge(const qni_dmc *dmc, const qni_quad_split *split,
                                             int at) {
    const int count = qni_split_boundary_size(split),
              from_turn = (at + count - split->turn) % count;
    return (uint32_t)(4 * qni_fan_place(dmc, split, from_turn / 2) + 1 + from_turn % 2);
}

#endif
