// SPDX-License-Identifier: MIT
/* Simplification as dmc/simplify_hd.h says, a thread a quad or a vertex: first merges colour by
 * colour, then rounds on what is suspect. Halfedges say who is beside whom, and corners are renamed
 * at once. Within a kernel no two threads change the same quad, vertex or side; sums and marks come
 * out the same in any order. */
#ifndef QNI_GPU_SIMPLIFY_HD_H
#define QNI_GPU_SIMPLIFY_HD_H

#include "dmc/project_hd.h"
#include "dmc/simplify_hd.h"
#include "gpu/repair_hd.h"

/* Marks of a quad: that it is suspect; in a round, what is decided of a quad that may go; among the
 * first merges, that it is one, and which corners have valence 3. */
enum {
    QNI_GPU_SUSPECT = 1,
    QNI_GPU_OPEN = 2,
    QNI_GPU_TAKEN = 4,
    QNI_GPU_LEFT = 8,
    QNI_GPU_RIVALS = QNI_GPU_OPEN | QNI_GPU_TAKEN | QNI_GPU_LEFT,
    QNI_GPU_FIRST = 16,
    QNI_GPU_ODD = 32,
    QNI_GPU_CHANGED = 1 /* mark of a vertex: its valence has changed */
};

QN_HD_INLINE int qni_gpu_valence_now(const qni_gpu_args *a, uint32_t vertex) {
    return qni_byte_now(a->valences + vertex) & QNI_VALENCE_MASK;
}

/* A vertex' byte becomes `value`; nobody else changes it meanwhile, but those beside it. */
QN_HD_INLINE void qni_gpu_set_valence(const qni_gpu_args *a, uint32_t vertex, int value) {
    qni_shared_add_byte(a->valences, vertex, value - qni_byte_now(a->valences + vertex));
}

QN_HD_INLINE uint32_t qni_gpu_valences_of(const qni_gpu_args *a, int64_t quad) {
    uint32_t four = 0;
    for (int k = 0; k < 4; ++k)
        four |= (uint32_t)a->valences[a->quads[4 * (size_t)quad + (size_t)k]] << (8 * k);
    return four;
}

QN_HD_INLINE int qni_gpu_kind_of(const qni_gpu_args *a, int64_t quad) {
    return qni_kind_of_valences(qni_gpu_valences_of(a, quad) & UINT32_C(0x3f3f3f3f));
}

QN_HD_INLINE void qni_gpu_load_corners_of(const qni_gpu_args *a, uint32_t quad,
                                          uint32_t corner[4]) {
    for (int k = 0; k < 4; ++k)
        corner[k] = a->quads[4 * (size_t)quad + (size_t)k];
}

/* ---- places ---------------------------------------------------------------------------------- */

QN_HD_INLINE double qni_gpu_affine(const double row[4], double x, double y, double z) {
    return (row[0] * x + row[1] * y) + (row[2] * z + row[3]);
}

/* As project_along() of dmc/project.c. */
QN_HD_APART int qni_gpu_project_along(const qni_gpu_args *a, const int64_t cell[3],
                                      const double d[8], int axis, double slope, double at[3]) {
    const double local[3] = {at[0] - (double)cell[0], at[1] - (double)cell[1],
                             at[2] - (double)cell[2]};
    double end[2];
    qni_line_ends(d, axis, local, end);
    double zero = qni_crossing_of_line(end, slope);
    int64_t start = cell[axis];
    if (zero < 0) {
        const double here = qni_lerp(end[0], end[1], local[axis]);
        int64_t next[3] = {cell[0], cell[1], cell[2]};
        double next_values[8];
        next[axis] += (here < 0) == (slope > 0) ? 1 : -1;
        if (next[axis] < 0 || next[axis] >= a->field.points[axis] - 1)
            return 0;
        qni_gpu_load_cell(&a->field, next, next_values);
        qni_line_ends(next_values, axis, local, end);
        zero = qni_crossing_of_line(end, slope);
        start = next[axis];
    }
    if (zero < 0 || fabs((double)start + zero - at[axis]) > 1)
        return 0;
    at[axis] = (double)start + zero;
    return 1;
}

/* As qni_project_landings() for one point. */
QN_HD_APART int qni_gpu_project(const qni_gpu_args *a, const float normal[3], float position[3]) {
    double at[3], d[8], slope[3];
    int64_t cell[3];
    int order[3];
    for (int k = 0; k < 3; ++k) {
        at[k] = qni_gpu_affine(a->lattice[k], (double)position[0], (double)position[1],
                               (double)position[2]);
        const double low = floor(at[k]), last = (double)(a->field.points[k] - 2);
        cell[k] = (int64_t)(low < 0 ? 0 : low > last ? last : low);
    }
    qni_gpu_load_cell(&a->field, cell, d);
    for (int k = 0; k < 3; ++k) {
        const double sum =
            (a->world[0][k] * (double)normal[0] + a->world[1][k] * (double)normal[1]) +
            a->world[2][k] * (double)normal[2];
        slope[k] = a->field.inside_below ? sum : -sum;
    }
    if (slope[0] == 0 && slope[1] == 0 && slope[2] == 0) {
        const double local[3] = {at[0] - (double)cell[0], at[1] - (double)cell[1],
                                 at[2] - (double)cell[2]};
        qni_slope_of_values(d, local, slope);
    }
    qni_sort_axes(slope, order);
    QN_ROLLED
    for (int n = 0; n < 3; ++n)
        if (qni_gpu_project_along(a, cell, d, order[n], slope[order[n]], at)) {
            for (int r = 0; r < 3; ++r)
                position[r] = (float)qni_gpu_affine(a->world[r], at[0], at[1], at[2]);
            return 1;
        }
    return 0;
}

/* The kept vertex goes to the middle between it and the one that went, and between x and y, then
 * onto the surface. */
QN_HD_APART void qni_gpu_place_pair(const qni_gpu_args *a, uint32_t kept, uint32_t gone, uint32_t x,
                                    uint32_t y) {
    float position[3], normal[3];
    const size_t at = 3 * (size_t)kept;
    qni_middle_of_pair(a->positions, a->normals, kept, gone, position, normal);
    if (a->reproject)
        qni_move_between(a->positions, a->normals, x, y, position, normal);
    const int landed = !a->reproject || qni_gpu_project(a, normal, position);
    if (!landed)
        qni_shared_add(&a->totals->unprojected, 1);
    for (size_t k = 0; k < 3; ++k) {
        if (landed)
            a->positions[at + k] = position[k];
        if (a->normals)
            a->normals[at + k] = normal[k];
    }
}

/* ---- carrying out ---------------------------------------------------------------------------- */

/* Merge the corners k and k + 2 of a quad into the lower one of them. `marks` are what it gets
 * beside its valence of 4. */
QN_HD_INLINE void qni_gpu_merge(const qni_gpu_args *a, uint32_t quad, uint32_t k, int marks) {
    uint32_t corner[4];
    qni_gpu_load_corners_of(a, quad, corner);
    if (corner[k] > corner[k ^ 2])
        k ^= 2;
    const uint32_t kept = corner[k], gone = corner[k ^ 2], x = corner[(k + 1) & 3],
                   y = corner[(k + 3) & 3];
    const uint32_t ha = 4 * quad + k, from_gone = a->twins[qni_next_side(ha)],
                   to_gone = a->twins[ha ^ 2];
    qni_gpu_place_pair(a, kept, gone, x, y);
    qni_gpu_set_valence(a, kept, 4 | marks);
    qni_gpu_set_valence(a, gone, QNI_VALENCE_GONE);
    qni_shared_add_byte(a->valences, x, -1);
    qni_shared_add_byte(a->valences, y, -1);
    a->colours[quad] = QNI_QUAD_GONE;
    a->vertex_marks[kept] = a->vertex_marks[x] = a->vertex_marks[y] = QNI_GPU_CHANGED;
    a->quads[from_gone] = kept;
    a->quads[qni_next_side(to_gone)] = kept;
    qni_close_merge(a->twins, a->vertex_halfedges, ha, kept, x, y);
    qni_shared_add(&a->totals->merged, 1);
}

/* The outer corner of the ring across side k. */
QN_HD_INLINE uint32_t qni_gpu_outer_corner(const qni_gpu_args *a, uint32_t quad, uint32_t k) {
    return a->quads[a->twins[4 * quad + k] ^ 2];
}

QN_HD_INLINE void qni_gpu_shrink(const qni_gpu_args *a, uint32_t quad) {
    uint32_t outer[4];
    for (uint32_t k = 0; k < 4; ++k)
        outer[k] = qni_gpu_outer_corner(a, quad, k);
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t beside = a->twins[4 * quad + k] >> 2;
        qni_gpu_set_valence(a, a->quads[4 * (size_t)quad + k], QNI_VALENCE_GONE);
        qni_shared_add_byte(a->valences, outer[k], -1);
        a->colours[beside] = QNI_QUAD_GONE;
        a->vertex_marks[outer[k]] = QNI_GPU_CHANGED;
        a->quads[4 * (size_t)quad + k] = outer[k];
    }
    qni_close_ring(a->twins, a->vertex_halfedges, quad, outer);
    qni_shared_add(&a->totals->shrunk, 4);
}

/* ---- first merges ---------------------------------------------------------------------------- */

QN_HD_INLINE void qni_gpu_find_first_quad(const qni_gpu_args *a, int64_t quad) {
    const uint32_t four = qni_gpu_valences_of(a, quad);
    const int kind = qni_kind_of_valences(four & UINT32_C(0x3f3f3f3f));
    int marks = kind != QNI_QUAD_STAYS ? QNI_GPU_SUSPECT : 0;
    if (qni_is_merge(kind) && qni_are_plain(four))
        marks = QNI_GPU_FIRST | ((four & 255) != 3 ? QNI_GPU_ODD : 0);
    a->quad_marks[quad] = (uint8_t)marks;
}
QNI_GPU_THINGS(find_first, (int64_t)a->plain_quads, qni_gpu_find_first_quad)

/* Quads of one colour: taken unless one before has taken a corner of valence 3. */
QN_HD_INLINE void qni_gpu_merge_first_quad(const qni_gpu_args *a, int64_t quad) {
    const int marks = a->quad_marks[quad];
    if (!(marks & QNI_GPU_FIRST) || a->colours[quad] != a->colour)
        return;
    const uint32_t k = marks & QNI_GPU_ODD ? 1 : 0;
    const uint32_t *corner = a->quads + 4 * (size_t)quad;
    if (qni_byte_now(a->valences + corner[k]) == 3 &&
        qni_byte_now(a->valences + corner[k + 2]) == 3)
        qni_gpu_merge(a, (uint32_t)quad, k, QNI_VALENCE_MERGED);
}
QNI_GPU_THINGS(merge_first, (int64_t)a->plain_quads, qni_gpu_merge_first_quad)

/* ---- what becomes suspect -------------------------------------------------------------------- */

/* The quads round a vertex that does not stay, by their sides that start at it. */
#define QNI_GPU_ROUND(a, vertex, h)                                                                \
    for (uint32_t h = (a)->vertex_halfedges[vertex], first_##h = QNI_UNPAIRED;                     \
         h != first_##h && h != QNI_UNPAIRED;                                                      \
         first_##h = first_##h == QNI_UNPAIRED ? h : first_##h, h = qni_next_round((a)->twins, h))

QN_HD_INLINE void qni_gpu_suspect_round(const qni_gpu_args *a, uint32_t vertex) {
    QNI_GPU_ROUND(a, vertex, h)
    if (qni_gpu_kind_of(a, h >> 2) != QNI_QUAD_STAYS)
        a->quad_marks[h >> 2] |= QNI_GPU_SUSPECT; /* whoever writes, writes the same */
}

/* Quads round vertices that came down to 3; after merges also those that a vertex of 4 allows: the
 * middles of rings round its neighbours of valence 3. */
QN_HD_INLINE void qni_gpu_spread_vertex(const qni_gpu_args *a, int64_t n) {
    const uint32_t vertex = (uint32_t)n;
    if (!a->vertex_marks[n])
        return;
    a->vertex_marks[n] = 0;
    if (a->valences[n] == QNI_VALENCE_GONE)
        return;
    const int valence = qni_gpu_valence_now(a, vertex);
    if (valence == 3)
        qni_gpu_suspect_round(a, vertex);
    if (valence != 4 || !a->middles)
        return;
    QNI_GPU_ROUND(a, vertex, h)
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t corner = a->quads[(h & ~UINT32_C(3)) | k];
        if (qni_gpu_valence_now(a, corner) == 3)
            qni_gpu_suspect_round(a, corner);
    }
}
QNI_GPU_THINGS(spread, (int64_t)a->plain_vertices, qni_gpu_spread_vertex)

/* ---- looking at suspects --------------------------------------------------------------------- */

/* The two other quads round a corner of valence 3. */
QN_HD_INLINE int qni_gpu_other_two(const qni_gpu_args *a, uint32_t vertex, uint32_t quad,
                                   uint32_t found[2]) {
    int count = 0, others = 0;
    QNI_GPU_ROUND(a, vertex, h) {
        if (h >> 2 != quad && others < 2)
            found[others++] = h >> 2;
        ++count;
    }
    return count == 3 && others == 2;
}

QN_HD_INLINE uint32_t qni_gpu_third_neighbour(const qni_gpu_args *a, uint32_t vertex,
                                              uint32_t quad) {
    uint32_t found[2];
    return qni_gpu_other_two(a, vertex, quad, found)
               ? qni_shared_corner(a->quads + 4 * (size_t)found[0], a->quads + 4 * (size_t)found[1],
                                   vertex)
               : QNI_UNPAIRED;
}

QN_HD_INLINE int qni_gpu_quad_may_merge(const qni_gpu_args *a, uint32_t quad, uint32_t k) {
    uint32_t corner[4];
    qni_gpu_load_corners_of(a, quad, corner);
    return qni_may_merge(corner[k], corner[k ^ 2], corner[(k + 1) & 3], corner[(k + 3) & 3],
                         qni_gpu_third_neighbour(a, corner[k], quad),
                         qni_gpu_third_neighbour(a, corner[k ^ 2], quad));
}

/* The quads of the ring, by the side of the quad in its middle; as find_ring() of
 * dmc/simplify_rest.c. */
QN_HD_INLINE int qni_gpu_find_ring(const qni_gpu_args *a, uint32_t quad, const uint32_t corner[4],
                                   uint32_t outer[4]) {
    uint32_t ring[4];
    for (int k = 0; k < 4; k += 2) {
        uint32_t found[2];
        if (!qni_gpu_other_two(a, corner[k], quad, found))
            return 0;
        const int after = qni_has_corner(a->quads + 4 * (size_t)found[1], corner[k + 1]);
        ring[k] = found[after];
        ring[(k + 3) & 3] = found[1 - after];
    }
    for (int k = 0; k < 4; ++k)
        outer[k] = qni_shared_corner(a->quads + 4 * (size_t)ring[(k + 3) & 3],
                                     a->quads + 4 * (size_t)ring[k], corner[k]);
    return 1;
}

QN_HD_APART int qni_gpu_ring_may_shrink(const qni_gpu_args *a, uint32_t quad) {
    uint32_t corner[4], outer[4];
    int valence[4];
    qni_gpu_load_corners_of(a, quad, corner);
    if (!qni_gpu_find_ring(a, quad, corner, outer))
        return 0;
    for (int k = 0; k < 4; ++k)
        valence[k] = outer[k] == QNI_UNPAIRED ? 0 : qni_gpu_valence_now(a, outer[k]);
    if (!qni_may_shrink(corner, outer, valence))
        return 0;
    int joined = 0;
    QNI_GPU_ROUND(a, outer[0], h)
    joined |= qni_joins_all(a->quads + 4 * (size_t)(h >> 2), outer);
    return !joined;
}

/* A suspect that may go by this round's pattern is open; one of the other stays suspect. */
QN_HD_INLINE void qni_gpu_look_at_quad(const qni_gpu_args *a, int64_t n) {
    const uint32_t quad = (uint32_t)n;
    if (!(a->quad_marks[n] & QNI_GPU_SUSPECT)) {
        a->quad_marks[n] = 0;
        return;
    }
    const int gone = a->colours[n] == QNI_QUAD_GONE;
    const int kind = gone ? QNI_QUAD_STAYS : qni_gpu_kind_of(a, n);
    int marks = 0;
    if (kind != QNI_QUAD_STAYS && qni_is_merge(kind) == a->rings)
        marks = QNI_GPU_SUSPECT;
    else if (kind != QNI_QUAD_STAYS &&
             (a->rings ? qni_gpu_ring_may_shrink(a, quad)
                       : qni_gpu_quad_may_merge(a, quad, (uint32_t)(kind - QNI_QUAD_MERGES_02))))
        marks = QNI_GPU_OPEN | (kind == QNI_QUAD_MERGES_13 ? QNI_GPU_ODD : 0);
    a->quad_marks[n] = (uint8_t)marks;
    if (marks & QNI_GPU_OPEN)
        qni_shared_add(&a->totals->open, 1);
}
QNI_GPU_THINGS(look, (int64_t)a->plain_quads, qni_gpu_look_at_quad)

/* ---- who goes -------------------------------------------------------------------------------- */

/* Asked again and again, by all threads at once, this ends with what taking all in their turns
 * gives: taken is who comes before all rivals that are not left, left is whose rival is taken. */
QN_HD_INLINE void qni_gpu_meet(const qni_gpu_args *a, uint32_t quad, uint32_t other,
                               int *decision) {
    const int marks = qni_byte_now(a->quad_marks + other);
    if (other == quad || !(marks & QNI_GPU_RIVALS) || marks & QNI_GPU_LEFT)
        return;
    if (marks & QNI_GPU_TAKEN)
        *decision = QNI_GPU_LEFT;
    else if (*decision == QNI_GPU_TAKEN &&
             qni_turn_of(a->colours[other], other) < qni_turn_of(a->colours[quad], quad))
        *decision = QNI_GPU_OPEN;
}

/* Merges that share a corner of valence 3. */
QN_HD_INLINE int qni_gpu_decide_merge(const qni_gpu_args *a, uint32_t quad) {
    const uint32_t *corner = a->quads + 4 * (size_t)quad;
    int decision = QNI_GPU_TAKEN;
    for (int k = 0; k < 4; ++k)
        if (qni_gpu_valence_now(a, corner[k]) == 3) {
            QNI_GPU_ROUND(a, corner[k], h)
            qni_gpu_meet(a, quad, h >> 2, &decision);
        }
    return decision;
}

/* Rings that share an outer corner: from a quad round it, the middle of another ring lies across
 * one of the two sides that the corner is not part of. */
QN_HD_INLINE int qni_gpu_decide_ring(const qni_gpu_args *a, uint32_t quad) {
    int decision = QNI_GPU_TAKEN;
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t outer = qni_gpu_outer_corner(a, quad, k);
        QNI_GPU_ROUND(a, outer, h)
        for (uint32_t n = 1; n < 3; ++n) {
            const uint32_t across = a->twins[(h & ~UINT32_C(3)) | ((h + n) & 3)];
            if (across != QNI_UNPAIRED)
                qni_gpu_meet(a, quad, across >> 2, &decision);
        }
    }
    return decision;
}

QN_HD_INLINE void qni_gpu_decide_quad(const qni_gpu_args *a, int64_t quad) {
    const int marks = a->quad_marks[quad];
    if (!(marks & QNI_GPU_OPEN))
        return;
    const int decision =
        a->rings ? qni_gpu_decide_ring(a, (uint32_t)quad) : qni_gpu_decide_merge(a, (uint32_t)quad);
    if (decision == QNI_GPU_OPEN)
        return;
    a->quad_marks[quad] = (uint8_t)(decision | (marks & QNI_GPU_ODD));
    qni_shared_add(&a->totals->open, ~UINT64_C(0)); /* one less */
}
QNI_GPU_THINGS(decide, (int64_t)a->plain_quads, qni_gpu_decide_quad)

/* Those that must wait stay suspect, and so does a quad that took its ring's place. */
QN_HD_INLINE void qni_gpu_carry_out_quad(const qni_gpu_args *a, int64_t n) {
    const uint32_t quad = (uint32_t)n;
    const int marks = a->quad_marks[n];
    if (!(marks & (QNI_GPU_TAKEN | QNI_GPU_LEFT)))
        return;
    a->quad_marks[n] = marks & QNI_GPU_LEFT || a->rings ? QNI_GPU_SUSPECT : 0;
    if (marks & QNI_GPU_LEFT)
        return;
    if (a->rings)
        qni_gpu_shrink(a, quad);
    else
        qni_gpu_merge(a, quad, marks & QNI_GPU_ODD ? 1 : 0, QNI_VALENCE_MERGED | QNI_VALENCE_APART);
}
QNI_GPU_THINGS(carry_out, (int64_t)a->plain_quads, qni_gpu_carry_out_quad)

/* ---- packing --------------------------------------------------------------------------------- */

QN_HD_INLINE void qni_gpu_count_vertex(const qni_gpu_args *a, int64_t n) {
    a->vertex_places[n] = a->valences[n] != QNI_VALENCE_GONE;
}
QNI_GPU_THINGS(count_vertices, (int64_t)a->plain_vertices, qni_gpu_count_vertex)

QN_HD_INLINE void qni_gpu_count_quad(const qni_gpu_args *a, int64_t n) {
    a->quad_places[n] = a->colours[n] != QNI_QUAD_GONE;
}
QNI_GPU_THINGS(count_quads, (int64_t)a->plain_quads, qni_gpu_count_quad)

QN_HD_INLINE uint32_t qni_gpu_packed_side(const qni_gpu_args *a, uint32_t h) {
    return h == QNI_UNPAIRED ? h : a->quad_places[h >> 2] << 2 | (h & 3);
}

QN_HD_INLINE void qni_gpu_pack_vertex(const qni_gpu_args *a, int64_t n) {
    if (a->valences[n] == QNI_VALENCE_GONE)
        return;
    const size_t from = 3 * (size_t)n, to = 3 * (size_t)a->vertex_places[n];
    for (size_t k = 0; k < 3; ++k) {
        a->packed_positions[to + k] = a->positions[from + k];
        if (a->normals)
            a->packed_normals[to + k] = a->normals[from + k];
    }
    a->packed_vertex_halfedges[a->vertex_places[n]] =
        qni_gpu_packed_side(a, a->vertex_halfedges[n]);
}
QNI_GPU_THINGS(pack_vertices, (int64_t)a->plain_vertices, qni_gpu_pack_vertex)

QN_HD_INLINE void qni_gpu_pack_quad(const qni_gpu_args *a, int64_t n) {
    if (a->colours[n] == QNI_QUAD_GONE)
        return;
    const size_t from = 4 * (size_t)n, to = 4 * (size_t)a->quad_places[n];
    for (size_t k = 0; k < 4; ++k) {
        a->packed_quads[to + k] = a->vertex_places[a->quads[from + k]];
        a->packed_twins[to + k] = qni_gpu_packed_side(a, a->twins[from + k]);
    }
}
QNI_GPU_THINGS(pack_quads, (int64_t)a->plain_quads, qni_gpu_pack_quad)

#endif
