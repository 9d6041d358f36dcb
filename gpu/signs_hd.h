// SPDX-License-Identifier: MIT
/* One bit a lattice point: it is above. And which leaves have surface, from these bits. */
#ifndef QNI_GPU_SIGNS_HD_H
#define QNI_GPU_SIGNS_HD_H

#include "core/bits_hd.h"
#include "gpu/args_hd.h"

/* The sign of stored sample `at`, of numeric type `scalar`, a constant where this is called. */
QN_HD_INLINE int qni_gpu_stored_sign(const qni_gpu_field *field, int scalar, int64_t at, int *odd) {
    if (field->nonfinite_distance > 0)
        return qni_gpu_settle(field, qni_gpu_scale(field, qni_gpu_stored(field, at))) >= 0;
    switch (scalar) {
#define QNI_GPU_SIGN_CASE(number, type)                                                            \
    case number:                                                                                   \
        return qni_gpu_sign_of_##number(field, at, odd);
        QNI_GPU_SCALAR_MAP(QNI_GPU_SIGN_CASE)
#undef QNI_GPU_SIGN_CASE
    }
    return 0;
}

/* The sign of lattice point (x, y, z). Beyond the end of x the last point is repeated, so that
 * nothing there looks like surface. */
QN_HD_INLINE int qni_gpu_sign(const qni_gpu_field *field, int scalar, int64_t x, int64_t y,
                              int64_t z, int *odd) {
    x = qni_gpu_clamp(x, field->points[0]);
    const int64_t i = x - field->border, j = y - field->border, k = z - field->border;
    if (i < 0 || j < 0 || k < 0 || i >= field->size[0] || j >= field->size[1] ||
        k >= field->size[2])
        return field->inside_below;
    return qni_gpu_stored_sign(field, scalar, qni_gpu_sample_at(field, i, j, k), odd);
}

/* Lines of signs, numbered y first. */
QN_HD_INLINE int64_t qni_gpu_sign_lines(const qni_gpu_args *a) {
    return a->field.points[1] * a->sign_planes;
}

QN_HD_INLINE int64_t qni_gpu_sign_plane(const qni_gpu_args *a) {
    return (int64_t)8 * a->field.first_layer;
}

/* The nine signs along x of leaf `leaf_x` on a line of the slab; lines beyond the lattice repeat
 * the last. `z` counts from the slab's first plane. */
QN_HD_INLINE unsigned qni_gpu_nine_signs(const qni_gpu_args *a, int64_t leaf_x, int64_t y,
                                         int64_t z) {
    const int64_t line = qni_gpu_clamp(z, a->sign_planes) * a->field.points[1] +
                         qni_gpu_clamp(y, a->field.points[1]);
    const uint8_t *bytes = (const uint8_t *)(a->signs + line * a->line_words) + leaf_x;
    return (bytes[0] | (unsigned)bytes[1] << 8) & 0x1ffu;
}

/* ---- leaves with surface --------------------------------------------------------------------- */

/* Lines of nine signs round a leaf. */
enum { QNI_LEAVES_THREADS = 256, QNI_GPU_SIGN_LINES = 81 };
typedef struct qni_gpu_nothing_shared {
    int unused;
} qni_gpu_nothing_shared;

QN_HD_INLINE void qni_gpu_leaf_at(const qni_gpu_field *field, int64_t index, int32_t leaf[3]) {
    const int64_t row = index / field->leaves[0];
    if (qni_gpu_is_sparse(field)) {
        qni_gpu_leaf_of_key(&field->blocks, field->blocks.keys[index], leaf);
        return;
    }
    leaf[0] = (int32_t)(index % field->leaves[0]);
    leaf[1] = (int32_t)(row % field->leaves[1]);
    leaf[2] = (int32_t)(row / field->leaves[1]) + field->first_layer;
}

QN_HD_INLINE int64_t qni_gpu_leaf_index(const qni_gpu_field *field, int64_t x, int64_t y,
                                        int64_t z) {
    if (qni_gpu_is_sparse(field))
        return qni_gpu_find_key(&field->blocks, qni_gpu_key(&field->blocks, x, y, z));
    return x + field->leaves[0] * (y + field->leaves[1] * (z - field->first_layer));
}

enum { QNI_GPU_find_leaves_THREADS = QNI_LEAVES_THREADS, QNI_GPU_find_leaves_PHASES = 1 };
typedef qni_gpu_nothing_shared qni_gpu_find_leaves_shared;

QN_HD_INLINE int64_t qni_gpu_find_leaves_items(const qni_gpu_args *a) {
    return ((int64_t)a->totals->leaves + QNI_LEAVES_THREADS - 1) / QNI_LEAVES_THREADS;
}

QN_HD_INLINE void qni_gpu_find_leaves(const qni_gpu_args *a, qni_gpu_find_leaves_shared *s,
                                      int64_t item, int phase, int thread) {
    const int64_t index = item * QNI_LEAVES_THREADS + thread;
    int32_t leaf[3];
    unsigned all = 0x1ff, any = 0;
    (void)s;
    (void)phase;
    if (index >= (int64_t)a->totals->leaves)
        return;
    qni_gpu_leaf_at(&a->field, index, leaf);
    const int64_t z0 = (int64_t)8 * (leaf[2] - a->field.first_layer);
    for (int z = 0; z < 9; ++z)
        for (int y = 0; y < 9; ++y) {
            const unsigned nine = qni_gpu_nine_signs(a, leaf[0], (int64_t)8 * leaf[1] + y, z0 + z);
            all &= nine;
            any |= nine;
        }
    a->slot[index] = all != 0x1ff && any != 0;
}

enum { QNI_GPU_list_leaves_THREADS = QNI_LEAVES_THREADS, QNI_GPU_list_leaves_PHASES = 1 };
typedef qni_gpu_nothing_shared qni_gpu_list_leaves_shared;

QN_HD_INLINE int64_t qni_gpu_list_leaves_items(const qni_gpu_args *a) {
    return qni_gpu_find_leaves_items(a);
}

QN_HD_INLINE void qni_gpu_list_leaves(const qni_gpu_args *a, qni_gpu_list_leaves_shared *s,
                                      int64_t item, int phase, int thread) {
    const int64_t index = item * QNI_LEAVES_THREADS + thread;
    (void)s;
    (void)phase;
    if (index >= (int64_t)a->totals->leaves)
        return;
    const uint32_t slot = a->slot[index];
    if (a->slot[index + 1] != slot)
        a->active_leaf[slot] = (uint32_t)index;
}

/* ---- samples that are not finite ------------------------------------------------------------- */

enum { QNI_GPU_measure_THREADS = 256, QNI_GPU_measure_PHASES = 1 };
typedef qni_gpu_nothing_shared qni_gpu_measure_shared;

/* A row of samples of the slab's planes each. */
QN_HD_INLINE int64_t qni_gpu_measure_items(const qni_gpu_args *a) {
    return a->field.size[1] * a->measured_planes;
}

QN_HD_INLINE void qni_gpu_measure(const qni_gpu_args *a, qni_gpu_measure_shared *s, int64_t item,
                                  int phase, int thread) {
    const qni_gpu_field *field = &a->field;
    const int64_t j = item % field->size[1], k = a->measured_from + item / field->size[1];
    uint64_t nan_count = 0, infinite_count = 0;
    double largest = 0;
    (void)s;
    (void)phase;
    for (int64_t i = thread; i < field->size[0]; i += QNI_GPU_measure_THREADS) {
        const double value =
            qni_gpu_scale(field, qni_gpu_stored(field, qni_gpu_sample_at(field, i, j, k)));
        const double distance = qni_gpu_magnitude(value - field->isovalue);
        if (qni_gpu_is_finite(value))
            largest = distance > largest ? distance : largest;
        else if (value != value)
            ++nan_count;
        else
            ++infinite_count;
    }
    if (nan_count)
        qni_shared_add(&a->totals->nan_count, nan_count);
    if (infinite_count)
        qni_shared_add(&a->totals->infinite_count, infinite_count);
    qni_shared_largest(&a->totals->largest_bits, largest);
}

#endif
