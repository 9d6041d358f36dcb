// SPDX-License-Identifier: MIT
/* Rows of samples, by scalar type: as doubles, and as sign bits compared in their stored form. */
#ifndef QNI_VOLUME_FIELD_ROWS_H
#define QNI_VOLUME_FIELD_ROWS_H

#include "volume/field.h"

/* `count` samples from (i, j, k) along x, as values: slope * stored + intercept. */
void qni_grid_load_row(const qn_grid *grid, int64_t i, int64_t j, int64_t k, int64_t count,
                       double *out);

/* Short runs round sample `at`, all of them samples; how many values, or 0 and nothing written
 * unless the rows are of the machine's own type, in order and aligned. */
int qni_grid_load_plain_runs(const qn_grid *grid, const int64_t at[3], const qni_run *runs,
                             int count, double *out);

/* The eight samples of the cell from sample `at`, likewise; false for 0. */
bool qni_grid_load_plain_cell(const qn_grid *grid, const int64_t at[3], double corner[8]);

/* The same of several cells, from where their samples are. */
bool qni_grid_load_plain_cells(const qn_grid *grid, const char *const from[QNI_CELLS_TOGETHER],
                               int count, double corner[8][QNI_CELLS_TOGETHER]);

/* A whole tile of plain samples less the iso-value, from sample (i, j, k) on; false when the grid
 * is not contiguous along x, swapped, or scaled, and nothing was done. */
bool qni_grid_load_plain_tile(const qni_field *field, const int64_t from[3],
                              double tile[QNI_TILE][QNI_TILE][QNI_TILE]);

/* Find the stored value at which `value >= iso` turns, by bisection of the very expression that is
 * evaluated elsewhere, so that both agree for every stored value. */
void qni_field_set_threshold(qni_field *field);

/* Sign bits of the samples (0 .. size[0] - 1, j, k), bit n of byte n / 8; returns true when a
 * sample is not finite. Only for fields with `direct`. The last byte's unused bits are 0. */
bool qni_field_pack_row(const qni_field *field, int64_t j, int64_t k, uint8_t *bits);

/* The same for `count` packed samples of the field's type; a `constant` field is heeded. */
bool qni_field_pack_samples(const qni_field *field, const void *from, int64_t count, uint8_t *bits);

/* Packed samples of a type as doubles. */
void qni_samples_load(qn_scalar scalar, const void *from, int64_t count, double *out);

/* From a sample's value to the field's: less iso, non-finite ones put where the rule says. */
double qni_field_settle(const qni_field *field, double value);

/* All lattice points of row (y, z), virtual ones included. */
void qni_field_load_lattice_row(const qni_field *field, int64_t y, int64_t z, double *out);

#endif
