// SPDX-License-Identifier: MIT
/* A volume from inside. */
#ifndef QNI_VOLUME_VOLUME_H
#define QNI_VOLUME_VOLUME_H

#include <qn/volume.h>

struct qn_volume {
    qn_context *context;
    qn_grid grid;              /* strides, slope and matrix always filled in */
    struct qni_sparse *sparse; /* sparse.h; NULL: dense. Of a sparse volume `grid` has no samples */
    qn_release release;
    void *release_user;
    char format[16];
};

/* The stored number of sample (i, j, k) as double, before slope and intercept; no range check. */
double qni_grid_stored(const qn_grid *grid, int64_t i, int64_t j, int64_t k);
/* Its value: slope * stored + intercept, two roundings. */
double qni_grid_value(const qn_grid *grid, int64_t i, int64_t j, int64_t k);

/* Samples read from a file, to hand over to qn_volume_create(): memory of the context, released
 * with it. */
qn_status qni_volume_own(qn_context *context, qn_grid *grid, void *samples, int64_t bytes,
                         const char *format, qn_volume **volume_out, qn_error *error);

#endif
