// SPDX-License-Identifier: MIT
/* The polygons of one cell: its case, the choices on its ambiguous faces, and the table entry both
 * lead to. */
#ifndef QNI_DMC_CELL_HD_H
#define QNI_DMC_CELL_HD_H

#include "core/cube_hd.h"
#include "dmc/cases_hd.h"
#include "face/face_hd.h"

typedef struct qni_cell_choice {
    int entry;           /* of cases_hd.h */
    int ambiguous_faces; /* a mask */
    int tied_faces;      /* those of them that the tie rule decides */
} qni_cell_choice;

/* Look at every ambiguous face of a cell with corner values d (less iso) and find its entry. */
QN_HD static inline qni_cell_choice qni_cell_resolve(const double d[8], int case_index) {
    const int faces = qni_case_ambiguous_faces(case_index);
    qni_cell_choice choice;
    int packed = 0, count = 0;
    choice.ambiguous_faces = faces;
    choice.tied_faces = 0;
    for (int face = 0; face < QNI_FACES; ++face) {
        if (!(faces >> face & 1))
            continue;
        const double v0 = d[qni_face_corner(face, 0)], v1 = d[qni_face_corner(face, 1)];
        const double v2 = d[qni_face_corner(face, 2)], v3 = d[qni_face_corner(face, 3)];
        const int sign =
            v0 >= 0 ? qni_face_saddle_sign(v0, v2, v1, v3) : qni_face_saddle_sign(v1, v3, v0, v2);
        packed |= qni_face_joins_above(sign) << count++;
        choice.tied_faces |= (sign == 0) << face;
    }
    choice.entry = qni_case_offset(case_index) + packed;
    return choice;
}

QN_HD_INLINE int qni_entry_polygons(int entry) {
    return (int)(qni_entry_owner_code(entry) >> 24);
}

/* The polygon that crosses an edge. */
QN_HD_INLINE int qni_entry_polygon_of_edge(int entry, int edge) {
    return (int)(qni_entry_owner_code(entry) >> (2 * edge) & 3);
}

/* The edges of one polygon. */
QN_HD static inline unsigned qni_entry_edges(int entry, int polygon) {
    const uint32_t owner = qni_entry_owner_code(entry);
    const uint64_t next = qni_entry_next_code(entry);
    unsigned mask = 0;
    for (int edge = 0; edge < QNI_EDGES; ++edge)
        if ((next >> (4 * edge) & 15) != 15 && (int)(owner >> (2 * edge) & 3) == polygon)
            mask |= 1u << edge;
    return mask;
}

/* True for cases that always make exactly one polygon: no look at the values is needed. */
QN_HD_INLINE int qni_case_is_simple(int case_index) {
    return qni_case_ambiguous_faces(case_index) == 0 &&
           qni_entry_polygons(qni_case_offset(case_index)) == 1;
}

#endif
