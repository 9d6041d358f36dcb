// SPDX-License-Identifier: MIT
/* Doubled edges taken apart, as dmc/repair.h says: a thread a doubled edge or a split quad. Which
 * quads are split is marked in a bit a quad; a scan of the marks numbers them in the order of the
 * mesh, so nothing is sorted. */
#ifndef QNI_GPU_REPAIR_HD_H
#define QNI_GPU_REPAIR_HD_H

#include "dmc/repair_hd.h"
#include "dmc/simplify_hd.h"
#include "gpu/link_hd.h"

enum { QNI_REPAIR_THREADS = 128, QNI_GPU_NO_POINTS = -1, QNI_GPU_LARGEST_BOUNDARY = 12 };

/* The item's thread as the number of a thing, of `count`; -1 when there is none. */
QN_HD_INLINE int64_t qni_gpu_thing(int64_t item, int thread, int64_t count) {
    const int64_t n = item * QNI_REPAIR_THREADS + thread;
    return n < count ? n : -1;
}

QN_HD_INLINE int64_t qni_gpu_blocks_for(int64_t count) {
    return (count + QNI_REPAIR_THREADS - 1) / QNI_REPAIR_THREADS;
}

QN_HD_INLINE int64_t qni_gpu_split_count(const qni_gpu_args *a) {
    return (int64_t)a->totals->splits;
}

/* Kernels of a single phase over things; `of` gives their number, `one` does one of them. */
#define QNI_GPU_THINGS(name, of, one)                                                              \
    enum { QNI_GPU_##name##_THREADS = QNI_REPAIR_THREADS, QNI_GPU_##name##_PHASES = 1 };           \
    typedef qni_gpu_nothing_shared qni_gpu_##name##_shared;                                        \
    QN_HD_INLINE int64_t qni_gpu_##name##_items(const qni_gpu_args *a) {                           \
        return qni_gpu_blocks_for(of);                                                             \
    }                                                                                              \
    QN_HD_INLINE void qni_gpu_##name(const qni_gpu_args *a, qni_gpu_##name##_shared *s,            \
                                     int64_t item, int phase, int thread) {                        \
        const int64_t n = qni_gpu_thing(item, thread, of);                                         \
        (void)s;                                                                                   \
        (void)phase;                                                                               \
        if (n >= 0)                                                                                \
            one(a, n);                                                                             \
    }

/* ---- which quads are split ------------------------------------------------------------------- */

/* Edge n of a doubled edge's four: its quad, or QNI_GPU_NO_HALFEDGE. */
QN_HD_INLINE uint32_t qni_gpu_doubled_quad(const qni_gpu_args *a, const qni_gpu_doubled *face,
                                           int n, int *edge, int32_t point[3]) {
    *edge = qni_doubled_edge(face->axis, face->first_cut, n);
    qni_lattice_edge_point(face->cell, *edge, point);
    return qni_gpu_quad_of(a, point, qni_edge_axis(*edge));
}

QN_HD_INLINE void qni_gpu_mark_face(const qni_gpu_args *a, int64_t i) {
    QN_ROLLED
    for (int n = 0; n < 4; ++n) {
        int edge;
        int32_t point[3];
        const uint32_t quad = qni_gpu_doubled_quad(a, a->doubled + i, n, &edge, point);
        if (quad != QNI_GPU_NO_HALFEDGE)
            qni_shared_or(a->marks + quad / 32, 1u << (quad % 32));
    }
}
QNI_GPU_THINGS(mark_quads, a->doubled_count, qni_gpu_mark_face)

QN_HD_INLINE void qni_gpu_count_word(const qni_gpu_args *a, int64_t word) {
    a->mark_ranks[word] = (uint32_t)qni_count_bits(a->marks[word]);
}
QNI_GPU_THINGS(count_marks, (int64_t)a->totals->mark_words, qni_gpu_count_word)

/* The number of a quad among those that are split; -1 when it is not. */
QN_HD_INLINE int64_t qni_gpu_split_of(const qni_gpu_args *a, uint32_t quad) {
    const uint32_t word = a->marks[quad / 32];
    if (!(word >> (quad % 32) & 1))
        return -1;
    return (int64_t)a->mark_ranks[quad / 32] + qni_bits_below(word, (int)(quad % 32));
}

/* Each side of a quad has one face, so points are written once; what else is written to a split is
 * the same whoever writes it. */
QN_HD_INLINE void qni_gpu_list_face(const qni_gpu_args *a, int64_t i) {
    const qni_gpu_doubled *face = a->doubled + i;
    QN_ROLLED
    for (int n = 0; n < 4; ++n) {
        int edge;
        int32_t point[3];
        const uint32_t quad = qni_gpu_doubled_quad(a, face, n, &edge, point);
        if (quad == QNI_GPU_NO_HALFEDGE)
            continue;
        qni_gpu_split *split = a->splits + qni_gpu_split_of(a, quad);
        split->quad = quad;
        split->axis = (uint8_t)qni_edge_axis(edge);
        for (int k = 0; k < 3; ++k)
            split->point[k] = point[k];
        split->points[qni_ring_side(edge, 2 * face->axis)] = (int32_t)(4 * i + 2 * (n / 2));
    }
}
QNI_GPU_THINGS(list_splits, a->doubled_count, qni_gpu_list_face)

QN_HD_INLINE void qni_gpu_note_split(const qni_gpu_args *a, int64_t n) {
    qni_gpu_split *split = a->splits + n;
    const double value =
        qni_gpu_value(&a->field, split->point[0], split->point[1], split->point[2]);
    int quads = 2;
    for (int k = 0; k < 4; ++k) {
        quads += split->points[k] != QNI_GPU_NO_POINTS;
        if (a->quads)
            split->corners[k] = a->quads[4 * (size_t)split->quad + (size_t)k];
        if (a->twins)
            split->twins[k] = a->twins[4 * (size_t)split->quad + (size_t)k];
    }
    split->quads = (uint8_t)quads;
    split->forward = (uint8_t)((value >= 0) != a->reverse);
    a->split_sizes[n] = (uint32_t)quads - 1;
}
QNI_GPU_THINGS(note_splits, qni_gpu_split_count(a), qni_gpu_note_split)

/* ---- new vertices ---------------------------------------------------------------------------- */

/* A vertex from its place in a cell anywhere, with the cell's stencil straight from the field. */
QN_HD_APART void qni_gpu_place_anywhere(const qni_gpu_args *a, const int64_t cell[3],
                                        const double local[3], uint32_t vertex) {
    double stencil[QNI_STENCIL];
    QN_ROLLED
    for (int n = 0; n < QNI_STENCIL; ++n) {
        int64_t point[3] = {cell[0], cell[1], cell[2]};
        if (n < 16) {
            point[0] += (n & 3) - 1;
            point[1] += n >> 2 & 1;
            point[2] += n >> 3;
        } else {
            const int beside = n < 24 ? 1 : 2;
            point[0] += n & 1;
            point[beside] += (n & 7) < 4 ? -1 : 2;
            point[3 - beside] += n >> 1 & 1;
        }
        stencil[n] = qni_gpu_extended_value(&a->field, point);
    }
    qni_placed placed;
#define QNI_GPU_S(n) stencil[n]
    QNI_PLACE(QNI_GPU_S, (double)cell[0], (double)cell[1], (double)cell[2], local[0], local[1],
              local[2], &a->frame, placed);
#undef QNI_GPU_S
    const size_t at = 3 * (size_t)vertex;
    a->positions[at] = placed.px;
    a->positions[at + 1] = placed.py;
    a->positions[at + 2] = placed.pz;
    if (!a->normals)
        return;
    float normal[3] = {placed.nx, placed.ny, placed.nz};
    if (!qni_is_unit(normal)) {
        double d[8];
        for (int c = 0; c < 8; ++c)
            d[c] = stencil[qni_corner_of_stencil(c)];
        qni_mend_normal(d, local, &a->frame, normal);
    }
    for (int k = 0; k < 3; ++k)
        a->normals[at + (size_t)k] = normal[k];
}

/* The four points of a doubled edge: two for each segment, first the one above the face. */
QN_HD_INLINE void qni_gpu_place_face(const qni_gpu_args *a, int64_t i) {
    const qni_gpu_doubled *face = a->doubled + i;
    const int axis = face->axis;
    int64_t cell[2][3];
    double d[2][8];
    int left = 0;
    for (int side = 0; side < 2; ++side) {
        for (int k = 0; k < 3; ++k)
            cell[side][k] = face->cell[k] - (side && k == axis);
        qni_gpu_load_cell(&a->field, cell[side], d[side]);
    }
    QN_ROLLED
    for (int segment = 0; segment < 2; ++segment) {
        double uw[2], length;
        qni_segment_middle(axis, face->first_cut, segment, d[0], uw, &length);
        QN_ROLLED
        for (int side = 0; side < 2; ++side) {
            double local[3];
            left +=
                !qni_point_in_cell(d[side], axis, side, uw, length * QNI_REPAIR_NEARNESS, local);
            qni_gpu_place_anywhere(a, cell[side], local,
                                   a->plain_vertices + (uint32_t)(4 * i + 2 * segment + side));
        }
    }
    if (left && i >= a->own_doubled[0] && i < a->own_doubled[1])
        qni_shared_add(&a->totals->left_on_face, (uint64_t)left);
}
QNI_GPU_THINGS(place_faces, a->doubled_count, qni_gpu_place_face)

/* ---- new quads ------------------------------------------------------------------------------- */

QN_HD_INLINE uint32_t qni_gpu_centre(const qni_gpu_args *a, int64_t split) {
    return a->plain_vertices + (uint32_t)(4 * a->doubled_count + split);
}

QN_HD_INLINE int qni_gpu_doubles(const qni_gpu_split *split, int k) {
    return split->points[qni_quad_side(k, split->forward)] != QNI_GPU_NO_POINTS;
}

/* The boundary of a split quad: each corner, then the two points of the side after it if that is
 * doubled. */
QN_HD_INLINE int qni_gpu_boundary(const qni_gpu_args *a, const qni_gpu_split *split,
                                  uint32_t boundary[QNI_GPU_LARGEST_BOUNDARY]) {
    int count = 0;
    for (int k = 0; k < 4; ++k) {
        const int ring_side = qni_quad_side(k, split->forward);
        boundary[count++] = split->corners[k];
        if (split->points[ring_side] == QNI_GPU_NO_POINTS)
            continue;
        /* Sides 0 and 1 of a ring climb, 2 and 3 come down. */
        const int climbs = (ring_side < 2) == (split->forward != 0);
        const uint32_t above = a->plain_vertices + (uint32_t)split->points[ring_side];
        boundary[count++] = climbs ? above + 1 : above;
        boundary[count++] = climbs ? above : above + 1;
    }
    return count;
}

/* Where corner k is on it. */
QN_HD_INLINE int qni_gpu_corner_at(const qni_gpu_split *split, int k) {
    int at = 0;
    for (int n = 0; n < k; ++n)
        at += 1 + 2 * qni_gpu_doubles(split, n);
    return at;
}

/* Where fan quad j of a split goes. */
QN_HD_INLINE uint32_t qni_gpu_fan_place(const qni_gpu_args *a, int64_t index, int j) {
    return j == 0 ? a->splits[index].quad
                  : a->plain_quads + a->split_sizes[index] + (uint32_t)j - 1;
}

/* The halfedge from boundary vertex `at` to the next. */
QN_HD_INLINE uint32_t qni_gpu_boundary_halfedge(const qni_gpu_args *a, int64_t index, int at) {
    const qni_gpu_split *split = a->splits + index;
    const int count = 2 * split->quads, from_turn = (at + count - split->turn) % count;
    return 4 * qni_gpu_fan_place(a, index, from_turn / 2) + 1 + (uint32_t)(from_turn % 2);
}

/* The centre is where the lattice edge meets the surface. */
QN_HD_INLINE void qni_gpu_split_one(const qni_gpu_args *a, int64_t index) {
    qni_gpu_split *split = a->splits + index;
    const int64_t cell[3] = {split->point[0], split->point[1], split->point[2]};
    const uint32_t centre = qni_gpu_centre(a, index);
    const int axis = split->axis;
    const double start = qni_gpu_value(&a->field, cell[0], cell[1], cell[2]);
    const double end = qni_gpu_value(&a->field, cell[0] + (axis == 0), cell[1] + (axis == 1),
                                     cell[2] + (axis == 2));
    double local[3] = {0, 0, 0};
    local[axis] = start / (start - end);
    qni_gpu_place_anywhere(a, cell, local, centre);
    uint32_t boundary[QNI_GPU_LARGEST_BOUNDARY];
    const int count = qni_gpu_boundary(a, split, boundary);
    const int turn = qni_better_turn(a->positions, boundary, count, centre);
    split->turn = (uint8_t)turn;
    for (int j = 0; j < count / 2; ++j)
        qni_fan_quad(boundary, count, centre, turn, j,
                     a->quads + 4 * (size_t)qni_gpu_fan_place(a, index, j));
}
QNI_GPU_THINGS(split_quads, qni_gpu_split_count(a), qni_gpu_split_one)

/* ---- halfedges ------------------------------------------------------------------------------- */

/* The halfedge of a part of old side k. */
QN_HD_INLINE uint32_t qni_gpu_part_halfedge(const qni_gpu_args *a, int64_t index, int k, int part) {
    return qni_gpu_boundary_halfedge(a, index, qni_gpu_corner_at(a->splits + index, k) + part);
}

/* The split across old side k, or -1. */
QN_HD_INLINE int64_t qni_gpu_split_across(const qni_gpu_args *a, const qni_gpu_split *split,
                                          int k) {
    return split->twins[k] == QNI_GPU_NO_HALFEDGE ? -1 : qni_gpu_split_of(a, split->twins[k] / 4);
}

QN_HD_INLINE void qni_gpu_link_side(const qni_gpu_args *a, int64_t index, int k) {
    const qni_gpu_split *split = a->splits + index;
    const int parts = qni_gpu_doubles(split, k) ? 3 : 1;
    const uint32_t twin = split->twins[k];
    const int64_t other = qni_gpu_split_across(a, split, k);
    for (int part = 0; part < parts; ++part) {
        const uint32_t own = qni_gpu_part_halfedge(a, index, k, part);
        a->twins[own] =
            other < 0 ? twin : qni_gpu_part_halfedge(a, other, (int)(twin & 3), parts - 1 - part);
        if (other < 0 && twin != QNI_GPU_NO_HALFEDGE)
            a->twins[twin] = own;
    }
    /* The points of a side lie on one other split at most: the lower one gives them halfedges. */
    if (parts == 3 && (other < 0 || index < other))
        for (int part = 1; part < 3; ++part) {
            const uint32_t half = qni_gpu_part_halfedge(a, index, k, part);
            a->vertex_halfedges[a->quads[half]] = half;
        }
}

QN_HD_INLINE void qni_gpu_link_split(const qni_gpu_args *a, int64_t index) {
    const qni_gpu_split *split = a->splits + index;
    const int fan = split->quads;
    QN_ROLLED
    for (int k = 0; k < 4; ++k) {
        qni_gpu_link_side(a, index, k);
        /* A corner whose halfedge was the old quad's. */
        const uint32_t half = qni_gpu_boundary_halfedge(a, index, qni_gpu_corner_at(split, k));
        uint32_t *of_corner = a->vertex_halfedges + split->corners[k];
        if (*of_corner == 4 * split->quad + (uint32_t)k)
            *of_corner = half;
    }
    for (int j = 0; j < fan; ++j) {
        const uint32_t out = 4 * qni_gpu_fan_place(a, index, (j + 1) % fan);
        const uint32_t back = 4 * qni_gpu_fan_place(a, index, j) + 3;
        a->twins[out] = back;
        a->twins[back] = out;
    }
    a->vertex_halfedges[qni_gpu_centre(a, index)] = 4 * split->quad;
}
QNI_GPU_THINGS(link_splits, qni_gpu_split_count(a), qni_gpu_link_split)

/* ---- valences -------------------------------------------------------------------------------- */

/* Vertices that repair touches, and are not fixed, are apart from now on; whoever writes, writes
 * the same. */
QN_HD_INLINE void qni_gpu_set_corners_apart(const qni_gpu_args *a, int64_t index) {
    const qni_gpu_split *split = a->splits + index;
    for (int k = 0; k < 4; ++k) {
        uint8_t *valence = a->valences + split->corners[k];
        if (*valence != QNI_VALENCE_FIXED)
            *valence = (uint8_t)(*valence | QNI_VALENCE_APART);
    }
}
QNI_GPU_THINGS(split_apart, qni_gpu_split_count(a), qni_gpu_set_corners_apart)

/* A quad comes to its corners, or goes. */
QN_HD_INLINE void qni_gpu_count_corners(const qni_gpu_args *a, const uint32_t corner[4],
                                        int change) {
    for (int k = 0; k < 4; ++k)
        if (qni_byte_now(a->valences + corner[k]) & QNI_VALENCE_APART)
            qni_shared_add_byte(a->valences, corner[k], change);
}

QN_HD_INLINE void qni_gpu_count_split(const qni_gpu_args *a, int64_t index) {
    const qni_gpu_split *split = a->splits + index;
    qni_gpu_count_corners(a, split->corners, -1);
    for (int j = 0; j < split->quads; ++j) {
        const uint32_t quad = qni_gpu_fan_place(a, index, j);
        a->colours[quad] = QNI_COLOUR_APART;
        qni_gpu_count_corners(a, a->quads + 4 * (size_t)quad, 1);
    }
}
QNI_GPU_THINGS(split_valences, qni_gpu_split_count(a), qni_gpu_count_split)

#endif
