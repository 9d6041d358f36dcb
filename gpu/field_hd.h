// SPDX-License-Identifier: MIT
/* A field as kernels see it: the same rules as volume/field.h, over samples in the memory of the
 * device. A slab of a volume holds a range of its planes; lattice points keep their numbers. A
 * sparse volume has its values in blocks and no border. */
#ifndef QNI_GPU_FIELD_HD_H
#define QNI_GPU_FIELD_HD_H

#include "gpu/blocks_hd.h"

#include <stdint.h>

/* In the order of QN_SCALAR_MAP, which kernels cannot include. */
#define QNI_GPU_SCALAR_MAP(X)                                                                      \
    X(0, uint8_t)                                                                                  \
    X(1, int8_t)                                                                                   \
    X(2, uint16_t)                                                                                 \
    X(3, int16_t)                                                                                  \
    X(4, uint32_t)                                                                                 \
    X(5, int32_t)                                                                                  \
    X(6, float)                                                                                    \
    X(7, double)

typedef struct qni_gpu_field {
    const void *samples;  /* plane `first_plane` comes first */
    int64_t row, plane;   /* samples from one row or plane to the next */
    int64_t first_plane;  /* of those that are there */
    int64_t size[3];      /* samples of the whole volume */
    int64_t points[3];    /* of the lattice, virtual layer included */
    int32_t leaves[3];    /* of the lattice */
    int32_t first_layer;  /* layers of leaves along z in this slab: numbered from here, */
    int32_t layers;       /* so many; */
    int32_t scalar;       /* of QNI_GPU_SCALAR_MAP */
    int32_t border;       /* 1 closed, 0 open */
    int32_t scaled;       /* slope and intercept change the samples */
    int32_t inside_below; /* inside is value < 0 */
    int32_t inverted;     /* stored form of value >= 0: (stored >= threshold) != inverted, */
    int32_t constant;     /* or this where it is not -1 */
    int64_t whole_threshold;
    double real_threshold;
    double isovalue, slope, intercept;
    double nonfinite_distance; /* 0: no sample is known to be non-finite */
    qni_gpu_blocks blocks;     /* of a sparse volume, whose `samples` are a pool of leaves */
} qni_gpu_field;

QN_HD_INLINE int64_t qni_gpu_clamp(int64_t i, int64_t size) {
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

QN_HD_INLINE int64_t qni_gpu_sample_at(const qni_gpu_field *field, int64_t i, int64_t j,
                                       int64_t k) {
    return i + j * field->row + (k - field->first_plane) * field->plane;
}

QN_HD_INLINE double qni_gpu_stored(const qni_gpu_field *field, int64_t at) {
    switch (field->scalar) {
#define QNI_GPU_STORED(number, type)                                                               \
    case number:                                                                                   \
        return (double)((const type *)field->samples)[at];
        QNI_GPU_SCALAR_MAP(QNI_GPU_STORED)
#undef QNI_GPU_STORED
    }
    return 0;
}

QN_HD_INLINE double qni_gpu_magnitude(double a) {
    return a < 0 ? -a : a;
}

QN_HD_INLINE int qni_gpu_is_finite(double a) {
    return a - a == 0;
}

/* Slope and intercept, two roundings. */
QN_HD_INLINE double qni_gpu_scale(const qni_gpu_field *field, double stored) {
    const double scaled = field->slope * stored;
    return field->scaled ? scaled + field->intercept : stored;
}

/* From a sample's value to the field's, as settle() of volume/field.c. */
QN_HD_INLINE double qni_gpu_settle(const qni_gpu_field *field, double value) {
    const double largest_distance = 1e140;
    const double d = value - field->isovalue;
    if (qni_gpu_magnitude(d) <= largest_distance)
        return d;
    if (qni_gpu_is_finite(value))
        return d > 0 ? largest_distance : -largest_distance;
    const int above = value != value ? field->inside_below : value > 0;
    return above ? field->nonfinite_distance : -field->nonfinite_distance;
}

/* The virtual layer mirrors the border's values at the iso-value to the outside. */
QN_HD_INLINE double qni_gpu_outside_of(const qni_gpu_field *field, double d) {
    const double least_outside = 1e-30, size = qni_gpu_magnitude(d);
    const double distance = size > least_outside ? size : least_outside;
    return field->inside_below ? distance : -distance;
}

QN_HD_INLINE int qni_gpu_is_sparse(const qni_gpu_field *field) {
    return field->blocks.keys != 0;
}

/* One sample of a block. */
QN_HD_INLINE double qni_gpu_value_in_block(const qni_gpu_field *field, const qni_gpu_block *block,
                                           int64_t place) {
    return qni_gpu_settle(field,
                          block->at < 0 ? block->value : qni_gpu_stored(field, block->at + place));
}

QN_HD_APART double qni_gpu_sparse_value(const qni_gpu_field *field, int64_t x, int64_t y,
                                        int64_t z) {
    const qni_gpu_block block = qni_gpu_find_block(&field->blocks, x >> 3, y >> 3, z >> 3);
    return qni_gpu_value_in_block(field, &block, qni_gpu_place_in_block(x, y, z));
}

/* Value of any lattice point. */
QN_HD_INLINE double qni_gpu_dense_value(const qni_gpu_field *field, int64_t x, int64_t y,
                                        int64_t z) {
    const int64_t i = x - field->border, j = y - field->border, k = z - field->border;
    const int64_t ci = qni_gpu_clamp(i, field->size[0]), cj = qni_gpu_clamp(j, field->size[1]),
                  ck = qni_gpu_clamp(k, field->size[2]);
    const double stored = qni_gpu_stored(field, qni_gpu_sample_at(field, ci, cj, ck));
    const double d = qni_gpu_settle(field, qni_gpu_scale(field, stored));
    return i == ci && j == cj && k == ck ? d : qni_gpu_outside_of(field, d);
}

QN_HD_INLINE double qni_gpu_value(const qni_gpu_field *field, int64_t x, int64_t y, int64_t z) {
    return qni_gpu_is_sparse(field) ? qni_gpu_sparse_value(field, x, y, z)
                                    : qni_gpu_dense_value(field, x, y, z);
}

/* Seven cells in eight along an axis lie in one block. */
QN_HD_INLINE int qni_gpu_is_in_block(const int64_t cell[3]) {
    return (cell[0] & 7) != 7 && (cell[1] & 7) != 7 && (cell[2] & 7) != 7;
}

QN_HD_APART void qni_gpu_load_cell(const qni_gpu_field *field, const int64_t cell[3], double d[8]) {
    if (qni_gpu_is_sparse(field) && qni_gpu_is_in_block(cell)) {
        const qni_gpu_block block =
            qni_gpu_find_block(&field->blocks, cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
        const int64_t place = qni_gpu_place_in_block(cell[0], cell[1], cell[2]);
        QN_ROLLED
        for (int c = 0; c < 8; ++c)
            d[c] = qni_gpu_value_in_block(field, &block,
                                          place + (c & 1) + 8 * (c >> 1 & 1) + 64 * (c >> 2));
        return;
    }
    QN_ROLLED
    for (int c = 0; c < 8; ++c)
        d[c] = qni_gpu_value(field, cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2));
}

/* The same up to one point beyond the lattice's ends, extrapolated along the axis where the point
 * is beyond. Where it is beyond along two, no vertex asks: 0. */
QN_HD static inline double qni_gpu_dense_extended_value(const qni_gpu_field *field,
                                                        const int64_t point[3]) {
    int64_t at[2][3]; /* the point, or the lattice's last one before it; the one before that */
    double value[2] = {0, 0};
    int beyond = 0;
    for (int a = 0; a < 3; ++a) {
        at[0][a] = qni_gpu_clamp(point[a], field->points[a]);
        at[1][a] = 2 * at[0][a] - point[a];
        const int64_t step = at[0][a] - point[a];
        beyond += step < -1 || step > 1 ? 2 : step != 0;
    }
    if (beyond > 1)
        return 0;
    QN_ROLLED
    for (int n = 0; n <= beyond; ++n)
        value[n] = qni_gpu_dense_value(field, at[n][0], at[n][1], at[n][2]);
    return beyond ? 2 * value[0] - value[1] : value[0];
}

/* Sparse fields have no ends: background goes on. */
QN_HD static inline double qni_gpu_extended_value(const qni_gpu_field *field,
                                                  const int64_t point[3]) {
    return qni_gpu_is_sparse(field) ? qni_gpu_sparse_value(field, point[0], point[1], point[2])
                                    : qni_gpu_dense_extended_value(field, point);
}

/* The sign of a stored number, by its type's own threshold; `odd` when it is not finite. */
#define QNI_GPU_SIGN_OF(number, type)                                                              \
    QN_HD_INLINE int qni_gpu_sign_of_##number(const qni_gpu_field *field, int64_t at, int *odd) {  \
        const type stored = ((const type *)field->samples)[at];                                    \
        const type limit =                                                                         \
            (number) >= 6 ? (type)field->real_threshold : (type)field->whole_threshold;            \
        *odd |= (number) >= 6 && !(stored - stored == 0);                                          \
        return field->constant >= 0 ? field->constant : (stored >= limit) != field->inverted;      \
    }
QNI_GPU_SCALAR_MAP(QNI_GPU_SIGN_OF)
#undef QNI_GPU_SIGN_OF

#endif
