// SPDX-License-Identifier: MIT
/* Doubled edges (repair.h) from the corner values of the cells at a face: whether a face is one,
 * and which of its lattice edges have quads. */
#ifndef QNI_DMC_DOUBLED_HD_H
#define QNI_DMC_DOUBLED_HD_H

#include "dmc/cell_hd.h"

QN_HD_INLINE int qni_case_of_values(const double d[8]) {
    int bits = 0;
    for (int c = 0; c < 8; ++c)
        bits |= (d[c] >= 0) << c;
    return bits;
}

/* All four edges of an ambiguous face are crossed by one and the same polygon. */
QN_HD_INLINE int qni_one_polygon_has_face(int entry, int face) {
    const int first = qni_entry_polygon_of_edge(entry, qni_face_edge(face, 0));
    int same = 1;
    for (int n = 1; n < 4; ++n)
        same = same && qni_entry_polygon_of_edge(entry, qni_face_edge(face, n)) == first;
    return same;
}

/* Only a polygon that crosses all four edges of a face can end a doubled edge. */
QN_HD_INLINE int qni_polygon_fills_face(unsigned edges) {
    int fills = 0;
    QN_ROLLED
    for (int face = 0; face < 6; ++face) {
        unsigned round = 0;
        for (int n = 0; n < 4; ++n)
            round |= 1u << qni_face_edge(face, n);
        fills |= (edges & round) == round;
    }
    return fills;
}

/* The valence that simplification takes a polygon's vertex to have (simplify_hd.h). Where doubled
 * edges are kept their ends stay as they are: were the pairs of quads that lie along one on both of
 * its sides merged, their vertices would be joined by two edges as well. */
QN_HD_INLINE int qni_valence_of_polygon(unsigned edges, int keep_doubled) {
    int valence = 0;
    for (unsigned rest = edges; rest; rest &= rest - 1)
        ++valence;
    return keep_doubled && qni_polygon_fills_face(edges) ? 0 : valence;
}

/* An edge has a quad when there are four cells round it. `cells` of the lattice. */
QN_HD_INLINE int qni_lattice_edge_is_inner(const int64_t cells[3], const int32_t point[3],
                                           int axis) {
    int inner = 1;
    for (int a = 0; a < 3; ++a)
        inner = inner && (a == axis || (point[a] >= 1 && point[a] < cells[a]));
    return inner;
}

/* The lattice point an edge of a cell starts from. */
QN_HD_INLINE void qni_lattice_edge_point(const int32_t cell[3], int edge, int32_t point[3]) {
    const int start = qni_edge_start_corner(edge);
    for (int a = 0; a < 3; ++a)
        point[a] = cell[a] + (start >> a & 1);
}

/* The segments of an ambiguous face cut off its corners `result` and `result` + 2. `d` are the
 * corner values of a cell at the face; either cell gives the same. */
QN_HD_INLINE int qni_face_first_cut(const double d[8], int face) {
    double v[4];
    for (int n = 0; n < 4; ++n)
        v[n] = d[qni_face_corner(face, n)];
    const int sign = v[0] >= 0 ? qni_face_saddle_sign(v[0], v[2], v[1], v[3])
                               : qni_face_saddle_sign(v[1], v[3], v[0], v[2]);
    const int above = v[0] >= 0 ? 0 : 1;
    return qni_face_joins_above(sign) ? 1 - above : above;
}

/* Edge n of four, in the order of the face's two segments: 0 and 1 of the first, 2 and 3 of the
 * second. */
QN_HD_INLINE int qni_doubled_edge(int axis, int first_cut, int n) {
    return qni_face_edge(2 * axis, first_cut + 3 + n);
}

/* Each of the two segments has a quad on one side at least. `cell` is the one above the face. */
QN_HD static inline int qni_doubled_has_quads(const int64_t cells[3], const int32_t cell[3],
                                              int axis, int first_cut) {
    int has[2] = {0, 0};
    for (int n = 0; n < 4; ++n) {
        const int edge = qni_doubled_edge(axis, first_cut, n);
        int32_t point[3];
        qni_lattice_edge_point(cell, edge, point);
        has[n >> 1] = has[n >> 1] || qni_lattice_edge_is_inner(cells, point, qni_edge_axis(edge));
    }
    return has[0] && has[1];
}

#endif
