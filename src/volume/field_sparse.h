// SPDX-License-Identifier: MIT
/* Sparse fields: what the calls of field.h do when the volume is sparse. */
#ifndef QNI_VOLUME_FIELD_SPARSE_H
#define QNI_VOLUME_FIELD_SPARSE_H

#include "volume/field.h"
#include "volume/sparse.h"

/* Set up all but the iso-value and the side. */
void qni_sparse_field_init(const qni_sparse *sparse, qni_field *field);

double qni_sparse_field_value(const qni_field *field, int64_t x, int64_t y, int64_t z);
void qni_sparse_field_load_cell(const qni_field *field, const int64_t cell[3], double corner[8]);
void qni_sparse_field_load_tile(const qni_field *field, const int32_t leaf[3],
                                double tile[QNI_TILE][QNI_TILE][QNI_TILE]);

/* Non-finite samples, counted in parts so that threads can share. */
typedef struct qni_nonfinite_count {
    int64_t nan_count, infinite_count;
    double largest;
} qni_nonfinite_count;
int64_t qni_sparse_field_part_count(const qni_field *field);
qni_nonfinite_count qni_sparse_field_count_part(const qni_field *field, int64_t part);

/* A scan of one row: its mixed leaves in order, with their signs. */
qn_status qni_sparse_scan_create(qni_scan *scan, qn_error *error);
void qni_sparse_scan_destroy(qni_scan *scan);
void qni_sparse_scan_row(const qni_field *field, int64_t row, qni_scan *scan);
int64_t qni_sparse_scan_next(const qni_scan *scan, int64_t from); /* -1: none */
void qni_sparse_scan_leaf(const qni_scan *scan, int64_t leaf_x,
                          uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES]);

#endif
