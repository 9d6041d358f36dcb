// SPDX-License-Identifier: MIT
/* The numbering of a cell's corners, edges and faces, drawn once for every module.
 *
 *          6------3------7          corner  x + 2 y + 4 z
 *         /|            /|          edge    along x: 0 + y + 2 z
 *        6 |           7 |                  along y: 4 + x + 2 z
 *       /  10         /  11                 along z: 8 + x + 2 y
 *      4------2------5   |          face    2 axis + side: 0 x=0, 1 x=1, 2 y=0, 3 y=1, 4 z=0, 5 z=1
 *      |   |         |   |
 *      |   2------1--|---3          z up, y into the page, x to the right
 *      8  /          9  /
 *      | 4           | 5
 *      |/            |/
 *      0------0------1
 */
#ifndef QNI_CORE_CUBE_HD_H
#define QNI_CORE_CUBE_HD_H

#include "core/hd.h"

#include <stdint.h>

enum { QNI_CORNERS = 8, QNI_EDGES = 12, QNI_FACES = 6 };

QN_HD_INLINE int qni_edge_axis(int edge) {
    return edge >> 2;
}

/* The corner an edge starts from; it ends at that corner + (1 << axis). */
QN_HD_INLINE int qni_edge_start_corner(int edge) {
    const int axis = edge >> 2;
    const int low = edge & 1, high = (edge >> 1) & 1;
    return axis == 0 ? 2 * low + 4 * high : axis == 1 ? low + 4 * high : low + 2 * high;
}

/* The edge that starts from `corner` along `axis`; the corner's own bit along the axis is ignored.
 */
QN_HD_INLINE int qni_edge_at(int axis, int corner) {
    const int x = corner & 1, y = (corner >> 1) & 1, z = (corner >> 2) & 1;
    return axis == 0 ? y + 2 * z : axis == 1 ? 4 + x + 2 * z : 8 + x + 2 * y;
}

/* Coordinate of an edge along another axis than its own: 0 or 1. */
QN_HD_INLINE int qni_edge_side(int edge, int axis) {
    return (qni_edge_start_corner(edge) >> axis) & 1;
}

/* The one face that two different edges of one cell face share. */
QN_HD_INLINE int qni_face_of_edges(int first_edge, int second_edge) {
    for (int axis = 0; axis < 3; ++axis) {
        if (qni_edge_axis(first_edge) == axis || qni_edge_axis(second_edge) == axis)
            continue;
        if (qni_edge_side(first_edge, axis) == qni_edge_side(second_edge, axis))
            return 2 * axis + qni_edge_side(first_edge, axis);
    }
    return -1;
}

/* Corners of a face in the lattice's orientation, cyclic: (0,0) (1,0) (1,1) (0,1) in its two axes,
 * the lower axis first. */
QN_HD_INLINE int qni_face_corner(int face, int index) {
    const int axis = face >> 1, side = face & 1;
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    const int u = index == 1 || index == 2, v = index >= 2;
    return (side << axis) | (u << p) | (v << q);
}

/* The edge between corners `index` and `index + 1` of a face, counted round it. */
QN_HD_INLINE int qni_face_edge(int face, int index) {
    const int a = qni_face_corner(face, index & 3), b = qni_face_corner(face, (index + 1) & 3);
    return qni_edge_at((a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2, a < b ? a : b);
}

#endif
