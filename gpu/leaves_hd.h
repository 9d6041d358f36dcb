// SPDX-License-Identifier: MIT
/* A block a leaf with surface: what it will give, and once more to write down which cells do. Two
 * kernels of the same phases, since places are known between them only. */
#ifndef QNI_GPU_LEAVES_HD_H
#define QNI_GPU_LEAVES_HD_H

#include "dmc/doubled_hd.h"
#include "dmc/leaf_hd.h"
#include "gpu/signs_hd.h"

enum { QNI_LEAF_THREADS = 64, QNI_LEAF_CELLS = 512 };

typedef struct qni_gpu_leaf_shared {
    qni_leaf_masks masks;
    uint64_t active[8], quads[3][8];
    uint64_t extra[2][8]; /* cells with 1, 2 or 3 polygons more, as bits of this number */
    uint64_t doubled[3][8];
    uint16_t signs[9][9];
    uint16_t entry[QNI_LEAF_CELLS]; /* of cells with several polygons */
    uint8_t found[QNI_LEAF_CELLS];  /* bits 0-1: polygons more, 2-4: doubled low faces */
    uint16_t ambiguous[QNI_LEAF_THREADS], tied[QNI_LEAF_THREADS];
    uint32_t slice[QNI_GPU_PLACED][8]; /* of each slice, then before it */
    uint32_t sum[QNI_GPU_CHANNELS];
} qni_gpu_leaf_shared;

QN_HD_INLINE qni_leaf_extent qni_gpu_extent(const qni_gpu_field *field, const int32_t leaf[3]) {
    qni_leaf_extent extent;
    for (int a = 0; a < 3; ++a) {
        const int64_t left = field->points[a] - 1 - (int64_t)8 * leaf[a];
        extent.cells[a] = left < 8 ? (int)left : 8;
        extent.at_low[a] = leaf[a] == 0;
    }
    return extent;
}

/* ---- shared with emission -------------------------------------------------------------------- */

QN_HD_INLINE void qni_gpu_load_signs(const qni_gpu_args *a, int64_t slot, const int32_t leaf[3],
                                     uint16_t signs[9][9], int thread, int threads) {
    if (qni_gpu_is_sparse(&a->field)) {
        const uint16_t *lines = a->leaf_signs + (size_t)a->active_leaf[slot] * QNI_GPU_SIGN_LINES;
        for (int n = thread; n < QNI_GPU_SIGN_LINES; n += threads)
            signs[n / 9][n % 9] = lines[n];
        return;
    }
    const int64_t z0 = (int64_t)8 * (leaf[2] - a->field.first_layer);
    for (int n = thread; n < 81; n += threads)
        signs[n / 9][n % 9] =
            (uint16_t)qni_gpu_nine_signs(a, leaf[0], (int64_t)8 * leaf[1] + n % 9, z0 + n / 9);
}

/* Mask of corner c in slice z: one of the 36 of qni_leaf_masks_init(). */
QN_HD_INLINE void qni_gpu_make_masks(const uint16_t signs[9][9], qni_leaf_masks *masks, int thread,
                                     int threads) {
    for (int n = thread; n < 36; n += threads) {
        const int c = n / 9, z = n % 9;
        uint64_t mask = 0;
        for (int y = 0; y < 8; ++y)
            mask |= (uint64_t)(signs[z][y + (c >> 1)] >> (c & 1) & 0xff) << (8 * y);
        masks->corner[c][z] = mask;
    }
}

/* ---- cells ----------------------------------------------------------------------------------- */

QN_HD_APART qni_cell_choice qni_gpu_resolve(const double d[8], int case_index) {
    return qni_cell_resolve(d, case_index);
}

/* Bit `axis` for each low face of the cell that is a doubled edge. */
QN_HD static inline int qni_gpu_doubled_faces(const qni_gpu_field *field, const int32_t cell[3],
                                              int ambiguous_faces, int entry) {
    const int64_t cells[3] = {field->points[0] - 1, field->points[1] - 1, field->points[2] - 1};
    int doubled = 0;
    QN_ROLLED
    for (int axis = 0; axis < 3; ++axis) {
        if (!(ambiguous_faces >> (2 * axis) & 1) || cell[axis] == 0 ||
            !qni_one_polygon_has_face(entry, 2 * axis))
            continue;
        const int64_t below[3] = {cell[0] - (axis == 0), cell[1] - (axis == 1),
                                  cell[2] - (axis == 2)};
        double d[8];
        qni_gpu_load_cell(field, below, d);
        const int entry_below = qni_gpu_resolve(d, qni_case_of_values(d)).entry;
        if (!qni_one_polygon_has_face(entry_below, 2 * axis + 1))
            continue;
        const int first_cut = qni_face_first_cut(d, 2 * axis + 1);
        doubled |= qni_doubled_has_quads(cells, cell, axis, first_cut) << axis;
    }
    return doubled;
}

/* A cell whose polygons are not known from its signs alone. */
QN_HD_APART void qni_gpu_resolve_cell(const qni_gpu_args *a, qni_gpu_leaf_shared *s,
                                      const int32_t leaf[3], int cell, int case_index, int thread) {
    const qni_gpu_field *field = &a->field;
    const int32_t at[3] = {8 * leaf[0] + (cell & 7), 8 * leaf[1] + (cell >> 3 & 7),
                           8 * leaf[2] + (cell >> 6)};
    int entry = qni_case_offset(case_index), doubled = 0;
    if (qni_case_ambiguous_faces(case_index) != 0) {
        const int64_t corner[3] = {at[0], at[1], at[2]};
        double d[8];
        qni_gpu_load_cell(field, corner, d);
        const qni_cell_choice choice = qni_gpu_resolve(d, case_index);
        int own = 1 << 0 | 1 << 2 | 1 << 4; /* faces count for the cell above, or the last cell */
        for (int axis = 0; axis < 3; ++axis)
            own |= (at[axis] == field->points[axis] - 2) << (2 * axis + 1);
        s->ambiguous[thread] = (uint16_t)(s->ambiguous[thread] +
                                          qni_count_bits((uint64_t)(choice.ambiguous_faces & own)));
        s->tied[thread] =
            (uint16_t)(s->tied[thread] + qni_count_bits((uint64_t)(choice.tied_faces & own)));
        entry = choice.entry;
        if (a->with_doubled)
            doubled = qni_gpu_doubled_faces(field, at, choice.ambiguous_faces, entry);
    }
    s->entry[cell] = (uint16_t)entry;
    s->found[cell] = (uint8_t)((qni_entry_polygons(entry) - 1) | doubled << 2);
}

/* The eight cells of one column, one thread. */
QN_HD_INLINE void qni_gpu_look_at_column(const qni_gpu_args *a, qni_gpu_leaf_shared *s,
                                         const int32_t leaf[3], int thread) {
    s->ambiguous[thread] = s->tied[thread] = 0;
    QN_ROLLED
    for (int z = 0; z < 8; ++z) {
        const int cell = thread + 64 * z;
        s->found[cell] = 0;
        if (!(s->active[z] >> thread & 1))
            continue;
        const int case_index =
            qni_case_of_cell((const uint16_t(*)[9])s->signs, thread & 7, thread >> 3, z);
        if (!qni_case_is_simple(case_index))
            qni_gpu_resolve_cell(a, s, leaf, cell, case_index, thread);
    }
}

/* ---- slices ---------------------------------------------------------------------------------- */

QN_HD_INLINE void qni_gpu_sum_slice(qni_gpu_leaf_shared *s, int z) {
    uint64_t low = 0, high = 0, doubled[3] = {0, 0, 0};
    QN_ROLLED
    for (int n = 0; n < 64; ++n) {
        const uint64_t found = s->found[n + 64 * z];
        low |= (found & 1) << n;
        high |= (found >> 1 & 1) << n;
        for (int axis = 0; axis < 3; ++axis)
            doubled[axis] |= (found >> (2 + axis) & 1) << n;
    }
    s->extra[0][z] = low;
    s->extra[1][z] = high;
    for (int axis = 0; axis < 3; ++axis)
        s->doubled[axis][z] = doubled[axis];
    s->slice[QNI_GPU_VERTICES][z] =
        (uint32_t)(qni_count_bits(s->active[z]) + qni_count_bits(low) + 2 * qni_count_bits(high));
    s->slice[QNI_GPU_MULTIS][z] = (uint32_t)qni_count_bits(low | high);
    s->slice[QNI_GPU_DOUBLED][z] =
        (uint32_t)(qni_count_bits(doubled[0]) + qni_count_bits(doubled[1]) +
                   qni_count_bits(doubled[2]));
}

/* Slices' numbers become what comes before each; quads are counted by axis first. */
QN_HD_INLINE void qni_gpu_sum_leaf(qni_gpu_leaf_shared *s, int thread) {
    if (thread < QNI_GPU_PLACED && thread != QNI_GPU_QUADS) {
        uint32_t before = 0;
        for (int z = 0; z < 8; ++z) {
            const uint32_t count = s->slice[thread][z];
            s->slice[thread][z] = before;
            before += count;
        }
        s->sum[thread] = before;
    } else if (thread == QNI_GPU_QUADS) {
        uint32_t quads = 0;
        for (int n = 0; n < 24; ++n)
            quads += (uint32_t)qni_count_bits(s->quads[n >> 3][n & 7]);
        s->sum[QNI_GPU_QUADS] = quads;
    } else if (thread == QNI_GPU_CELLS) {
        uint32_t cells = 0;
        for (int z = 0; z < 8; ++z)
            cells += (uint32_t)qni_count_bits(s->active[z]);
        s->sum[QNI_GPU_CELLS] = cells;
    } else if (thread == QNI_GPU_AMBIGUOUS || thread == QNI_GPU_TIED) {
        uint32_t faces = 0;
        for (int n = 0; n < QNI_LEAF_THREADS; ++n)
            faces += thread == QNI_GPU_AMBIGUOUS ? s->ambiguous[n] : s->tied[n];
        s->sum[thread] = faces;
    }
}

/* The phases both kernels begin with. */
QN_HD_INLINE void qni_gpu_leaf_phase(const qni_gpu_args *a, qni_gpu_leaf_shared *s, int64_t item,
                                     int phase, int thread) {
    int32_t leaf[3];
    qni_gpu_leaf_at(&a->field, a->active_leaf[item], leaf);
    if (phase == 0) {
        qni_gpu_load_signs(a, item, leaf, s->signs, thread, QNI_LEAF_THREADS);
    } else if (phase == 1) {
        qni_gpu_make_masks((const uint16_t(*)[9])s->signs, &s->masks, thread, QNI_LEAF_THREADS);
    } else if (phase == 2) {
        const qni_leaf_extent extent = qni_gpu_extent(&a->field, leaf);
        if (thread < 8)
            s->active[thread] = qni_active_of_slice(&s->masks, &extent, thread);
        else if (thread < 32)
            s->quads[(thread - 8) >> 3][thread & 7] =
                qni_quads_of_slice(&s->masks, &extent, (thread - 8) >> 3, thread & 7);
    } else if (phase == 3) {
        qni_gpu_look_at_column(a, s, leaf, thread);
    } else if (phase == 4) {
        if (thread < 8)
            qni_gpu_sum_slice(s, thread);
    } else if (phase == 5) {
        qni_gpu_sum_leaf(s, thread);
    }
}

/* ---- count ----------------------------------------------------------------------------------- */

enum { QNI_GPU_count_THREADS = QNI_LEAF_THREADS, QNI_GPU_count_PHASES = 7 };
typedef qni_gpu_leaf_shared qni_gpu_count_shared;

QN_HD_INLINE int64_t qni_gpu_count_items(const qni_gpu_args *a) {
    return (int64_t)a->totals->active;
}

QN_HD_INLINE void qni_gpu_count(const qni_gpu_args *a, qni_gpu_count_shared *s, int64_t item,
                                int phase, int thread) {
    if (phase < 6)
        qni_gpu_leaf_phase(a, s, item, phase, thread);
    else if (thread < QNI_GPU_CHANNELS)
        a->counts[thread * a->count_stride + item] = s->sum[thread];
}

/* ---- record ---------------------------------------------------------------------------------- */

enum { QNI_GPU_record_THREADS = QNI_LEAF_THREADS, QNI_GPU_record_PHASES = 8 };
typedef qni_gpu_leaf_shared qni_gpu_record_shared;

QN_HD_INLINE int64_t qni_gpu_record_items(const qni_gpu_args *a) {
    return (int64_t)a->totals->active;
}

/* Where a leaf's entries of a channel begin. */
QN_HD_INLINE uint32_t qni_gpu_place(const qni_gpu_args *a, int channel, int64_t slot) {
    return a->counts[channel * a->count_stride + slot];
}

QN_HD_INLINE void qni_gpu_record_multi(const qni_gpu_args *a, const qni_gpu_leaf_shared *s,
                                       int64_t item, int cell) {
    const int z = cell >> 6, bit = cell & 63;
    const uint64_t low = s->extra[0][z], high = s->extra[1][z];
    qni_gpu_multi multi;
    int before_slice = 0;
    for (int n = 0; n < z; ++n)
        before_slice += qni_count_bits(s->active[n]);
    const int extra_in_slices = (int)s->slice[QNI_GPU_VERTICES][z] - before_slice;
    multi.cell = (uint16_t)cell;
    multi.extra_before =
        (uint16_t)(extra_in_slices + qni_bits_below(low, bit) + 2 * qni_bits_below(high, bit));
    multi.entry = s->entry[cell];
    a->multis[qni_gpu_place(a, QNI_GPU_MULTIS, item) + s->slice[QNI_GPU_MULTIS][z] +
              (uint32_t)qni_bits_below(low | high, bit)] = multi;
}

QN_HD_APART void qni_gpu_record_doubled(const qni_gpu_args *a, const qni_gpu_leaf_shared *s,
                                        const int32_t leaf[3], int64_t item, int cell) {
    const int z = cell >> 6, bit = cell & 63;
    uint32_t place = qni_gpu_place(a, QNI_GPU_DOUBLED, item) + s->slice[QNI_GPU_DOUBLED][z];
    for (int axis = 0; axis < 3; ++axis)
        place += (uint32_t)qni_bits_below(s->doubled[axis][z], bit);
    qni_gpu_doubled face;
    face.cell[0] = 8 * leaf[0] + (cell & 7);
    face.cell[1] = 8 * leaf[1] + (cell >> 3 & 7);
    face.cell[2] = 8 * leaf[2] + z;
    const int64_t corner[3] = {face.cell[0], face.cell[1], face.cell[2]};
    double d[8];
    qni_gpu_load_cell(&a->field, corner, d);
    QN_ROLLED
    for (int axis = 0; axis < 3; ++axis)
        if (s->found[cell] >> (2 + axis) & 1) {
            face.axis = (uint8_t)axis;
            face.first_cut = (uint8_t)qni_face_first_cut(d, 2 * axis);
            a->doubled[place++] = face;
        }
}

QN_HD_INLINE void qni_gpu_record(const qni_gpu_args *a, qni_gpu_record_shared *s, int64_t item,
                                 int phase, int thread) {
    if (phase < 6) {
        qni_gpu_leaf_phase(a, s, item, phase, thread);
        return;
    }
    if (phase == 6) {
        int32_t leaf[3];
        qni_gpu_leaf_at(&a->field, a->active_leaf[item], leaf);
        QN_ROLLED
        for (int z = 0; z < 8; ++z) {
            const int cell = thread + 64 * z;
            if (s->found[cell] & 3)
                qni_gpu_record_multi(a, s, item, cell);
            if (s->found[cell] >> 2)
                qni_gpu_record_doubled(a, s, leaf, item, cell);
        }
        return;
    }
    if (thread < 8) {
        int before = 0;
        for (int z = 0; z < thread; ++z)
            before += qni_count_bits(s->active[z]);
        a->leaves[item].active[thread] = s->active[thread];
        a->leaves[item].before[thread] = (uint16_t)before;
    } else if (thread < 32 && a->leaf_quads) {
        const int n = thread - 8;
        int before = 0;
        QN_ROLLED
        for (int m = 0; m < n; ++m)
            before += qni_count_bits(s->quads[m >> 3][m & 7]);
        a->leaf_quads[item].mask[n >> 3][n & 7] = s->quads[n >> 3][n & 7];
        a->leaf_quads[item].before[n >> 3][n & 7] = (uint16_t)before;
    }
}

#endif
