// SPDX-License-Identifier: MIT
/* A block a leaf with surface: the twins of the halfedges on the low faces of its cells, and a
 * halfedge for each of its vertices. Each halfedge lies on one face, so each is written once. */
#ifndef QNI_GPU_LINK_HD_H
#define QNI_GPU_LINK_HD_H

#include "dmc/doubled_hd.h"
#include "dmc/ring_hd.h"
#include "gpu/emit_hd.h"

enum { QNI_LINK_THREADS = 128 };

typedef struct qni_gpu_link_shared {
    uint16_t signs[9][9];
    uint16_t cell[QNI_LEAF_CELLS];
} qni_gpu_link_shared;

/* A cell with surface, and the quads of its crossed edges. */
typedef struct qni_gpu_link_cell {
    int32_t at[3];
    int case_index, crossed, forward; /* the last two: a bit an edge */
    uint32_t quad[QNI_EDGES];         /* QNI_GPU_NO_HALFEDGE where there is none */
} qni_gpu_link_cell;

QN_HD_INLINE void qni_gpu_look_up_cell(const qni_gpu_args *a, qni_gpu_link_cell *c) {
    c->crossed = c->forward = 0;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int start = qni_edge_start_corner(edge), axis = qni_edge_axis(edge);
        const int above = c->case_index >> start & 1;
        const int crossed = above != (c->case_index >> (start | 1 << axis) & 1);
        int32_t point[3];
        qni_lattice_edge_point(c->at, edge, point);
        c->quad[edge] = crossed ? qni_gpu_quad_of(a, point, axis) : QNI_GPU_NO_HALFEDGE;
        c->crossed |= crossed << edge;
        c->forward |= (above != a->reverse) << edge;
    }
}

QN_HD_INLINE uint32_t qni_gpu_halfedge_on(const qni_gpu_link_cell *c, int edge, int face) {
    const int side = qni_quad_side(qni_ring_side(edge, face), c->forward >> edge & 1);
    return 4 * c->quad[edge] + (uint32_t)side;
}

QN_HD_INLINE void qni_gpu_pair(const qni_gpu_args *a, const qni_gpu_link_cell *c, int face,
                               int edge_a, int edge_b) {
    const int has_a = c->quad[edge_a] != QNI_GPU_NO_HALFEDGE,
              has_b = c->quad[edge_b] != QNI_GPU_NO_HALFEDGE;
    const uint32_t half_a = has_a ? qni_gpu_halfedge_on(c, edge_a, face) : QNI_GPU_NO_HALFEDGE;
    const uint32_t half_b = has_b ? qni_gpu_halfedge_on(c, edge_b, face) : QNI_GPU_NO_HALFEDGE;
    if (has_a)
        a->twins[half_a] = half_b;
    if (has_b)
        a->twins[half_b] = half_a;
}

QN_HD_APART int qni_gpu_first_cut(const qni_gpu_args *a, const int32_t cell[3], int face) {
    const int64_t corner[3] = {cell[0], cell[1], cell[2]};
    double d[8];
    qni_gpu_load_cell(&a->field, corner, d);
    return qni_face_first_cut(d, face);
}

QN_HD_INLINE void qni_gpu_link_face(const qni_gpu_args *a, const qni_gpu_link_cell *c, int face) {
    int mask = 0, last[2] = {0, 0};
    for (int n = 0; n < 4; ++n) {
        const int edge = qni_face_edge(face, n);
        if (!(c->crossed >> edge & 1))
            continue;
        last[0] = last[1];
        last[1] = edge;
        mask |= 1 << n;
    }
    if (mask == 15) { /* corner n of the face lies between its edges n - 1 and n */
        const int first = qni_gpu_first_cut(a, c->at, face);
        for (int n = first; n < 4; n += 2)
            qni_gpu_pair(a, c, face, qni_face_edge(face, (n + 3) & 3), qni_face_edge(face, n));
    } else if (mask) {
        qni_gpu_pair(a, c, face, last[0], last[1]);
    }
}

/* The halfedge a vertex gets: the lowest that starts there and has no quad across it, else the
 * lowest that starts there. */
QN_HD_INLINE uint32_t qni_gpu_halfedge_of(const qni_gpu_link_cell *c, unsigned edges,
                                          uint64_t next_code) {
    uint32_t lowest = QNI_GPU_NO_HALFEDGE, lowest_open = QNI_GPU_NO_HALFEDGE;
    QN_ROLLED
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        if (!(edges >> edge & 1))
            continue;
        const int next = (int)(next_code >> (4 * edge) & 15), face = qni_face_of_edges(edge, next);
        for (int end = 0; end < 2; ++end) {
            const int own = end ? next : edge, other = end ? edge : next;
            if (c->quad[own] == QNI_GPU_NO_HALFEDGE)
                continue;
            const uint32_t half = qni_gpu_halfedge_on(c, own, face);
            if ((int)(half & 3) != qni_quad_corner(qni_ring_place(own), c->forward >> own & 1))
                continue; /* it ends here */
            lowest = half < lowest ? half : lowest;
            if (c->quad[other] == QNI_GPU_NO_HALFEDGE)
                lowest_open = half < lowest_open ? half : lowest_open;
        }
    }
    return lowest_open != QNI_GPU_NO_HALFEDGE ? lowest_open : lowest;
}

/* Its valence is its polygon's length, unless an edge has no quad: then it stays as it is. */
QN_HD_INLINE void qni_gpu_link_vertex(const qni_gpu_args *a, const qni_gpu_link_cell *c,
                                      unsigned edges, uint64_t next_code, uint32_t vertex) {
    a->vertex_halfedges[vertex] = qni_gpu_halfedge_of(c, edges, next_code);
    if (!a->valences)
        return;
    int missing = 0;
    QN_ROLLED
    for (int edge = 0; edge < QNI_EDGES; ++edge)
        missing |= (edges >> edge & 1) && c->quad[edge] == QNI_GPU_NO_HALFEDGE;
    a->valences[vertex] = (uint8_t)(missing ? 0 : qni_valence_of_polygon(edges, a->keep_doubled));
}

/* Where faces of a cell with one polygon are ambiguous, their choices decide the order of its
 * edges. */
QN_HD_APART int qni_gpu_resolved_entry(const qni_gpu_args *a, const int32_t cell[3],
                                       int case_index) {
    const int64_t corner[3] = {cell[0], cell[1], cell[2]};
    double d[8];
    qni_gpu_load_cell(&a->field, corner, d);
    return qni_gpu_resolve(d, case_index).entry;
}

QN_HD_INLINE void qni_gpu_link_vertices(const qni_gpu_args *a, const qni_gpu_link_cell *c,
                                        int64_t slot, int index, int n) {
    int entry;
    uint32_t vertex = qni_gpu_place(a, QNI_GPU_VERTICES, slot) + (uint32_t)n;
    vertex += qni_gpu_extra_before(a, slot, index, &entry);
    if (entry == QNI_GPU_NO_ENTRY)
        entry = qni_case_ambiguous_faces(c->case_index) == 0
                    ? qni_case_offset(c->case_index)
                    : qni_gpu_resolved_entry(a, c->at, c->case_index);
    QN_ROLLED
    for (int polygon = 0; polygon < qni_entry_polygons(entry); ++polygon, ++vertex)
        qni_gpu_link_vertex(a, c, qni_entry_edges(entry, polygon), qni_entry_next_code(entry),
                            vertex);
}

QN_HD_INLINE void qni_gpu_link_one(const qni_gpu_args *a, const qni_gpu_link_shared *s,
                                   int64_t slot, const int32_t leaf[3], int n) {
    const int index = s->cell[n], x = index & 7, y = index >> 3 & 7, z = index >> 6;
    qni_gpu_link_cell c;
    c.at[0] = 8 * leaf[0] + x;
    c.at[1] = 8 * leaf[1] + y;
    c.at[2] = 8 * leaf[2] + z;
    c.case_index = qni_case_of_cell((const uint16_t(*)[9])s->signs, x, y, z);
    qni_gpu_look_up_cell(a, &c);
    QN_ROLLED
    for (int axis = 0; axis < 3; ++axis)
        if (c.at[axis] > 0)
            qni_gpu_link_face(a, &c, 2 * axis);
    if (slot >= a->first_slot && slot < a->end_slot)
        qni_gpu_link_vertices(a, &c, slot, index, n);
}

/* ---- the kernel ------------------------------------------------------------------------------ */

enum { QNI_GPU_link_THREADS = QNI_LINK_THREADS, QNI_GPU_link_PHASES = 2 };

QN_HD_INLINE int64_t qni_gpu_link_items(const qni_gpu_args *a) {
    return a->end_linked - a->first_linked;
}

QN_HD_INLINE void qni_gpu_link(const qni_gpu_args *a, qni_gpu_link_shared *s, int64_t item,
                               int phase, int thread) {
    const int64_t slot = a->first_linked + item;
    int32_t leaf[3];
    qni_gpu_leaf_at(&a->field, a->active_leaf[slot], leaf);
    if (phase == 0) {
        qni_gpu_list_cells(a, s->cell, slot, thread, QNI_LINK_THREADS);
        qni_gpu_load_signs(a, slot, leaf, s->signs, thread, QNI_LINK_THREADS);
        return;
    }
    const int cells = qni_gpu_cell_count(a, slot);
    QN_ROLLED
    for (int n = thread; n < cells; n += QNI_LINK_THREADS)
        qni_gpu_link_one(a, s, slot, leaf, n);
}

#endif
