// SPDX-License-Identifier: MIT
/* The ring of four cells round a lattice edge, which is the quad of that edge. Ring place 0 is the
 * cell lowest in both other axes; the ring turns counter-clockwise seen from the edge's end. Ring
 * side n joins places n and n + 1 and lies on the cell face between them: a mesh edge is a segment
 * on a lattice face, so quads on both sides of it are found from the grid (docs/architecture.md,
 * halfedges). A quad's corners run along the ring where the values fall along the edge, else
 * against it. */
#ifndef QNI_DMC_RING_HD_H
#define QNI_DMC_RING_HD_H

#include "core/cube_hd.h"

/* Place of a cell in the ring of its own edge `edge`. */
QN_HD_INLINE int qni_ring_place(int edge) {
    const int axis = edge >> 2, u = axis == 2 ? 0 : axis + 1, v = axis == 0 ? 2 : axis - 1;
    const int low_u = qni_edge_side(edge, u),
              low_v = qni_edge_side(edge, v); /* the edge at 1: the cell is lower */
    return low_v ? (low_u ? 0 : 1) : (low_u ? 3 : 2);
}

/* The ring side on one of the cell's two faces at `edge`. */
QN_HD_INLINE int qni_ring_side(int edge, int face) {
    const int axis = edge >> 2, u = axis == 2 ? 0 : axis + 1;
    const int place = qni_ring_place(edge);
    if (face >> 1 == u) /* steps along u join 0 - 1 and 3 - 2 */
        return place < 2 ? 0 : 2;
    return place == 0 || place == 3 ? 3 : 1;
}

/* The quad's corner at a ring place, and its side at a ring side. */
QN_HD_INLINE int qni_quad_corner(int place, int forward) {
    return forward ? place : (4 - place) & 3;
}

QN_HD_INLINE int qni_quad_side(int ring_side, int forward) {
    return forward ? ring_side : 3 - ring_side;
}

#endif
