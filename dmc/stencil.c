// SPDX-License-Identifier: MIT
/* Stencils of single cells, by runs along x. */
#include "dmc/stencil.h"

static void load_run(const qni_field *field, int64_t x, int64_t y, int64_t z, int count,
                     double *out) {
    const int64_t first[3] = {x, y, z};
    if (qni_field_load_run(field, first, count, out))
        return;
    for (int n = 0; n < count; ++n) {
        const int64_t point[3] = {x + n, y, z};
        out[n] = qni_field_extended_value(field, point);
    }
}

void qni_load_stencil(const qni_field *field, const int64_t cell[3], double stencil[QNI_STENCIL]) {
    static const qni_run runs[12] = {{-1, 0, 0, 4}, {-1, 1, 0, 4}, {-1, 0, 1, 4}, {-1, 1, 1, 4},
                                     {0, -1, 0, 2}, {0, -1, 1, 2}, {0, 2, 0, 2},  {0, 2, 1, 2},
                                     {0, 0, -1, 2}, {0, 1, -1, 2}, {0, 0, 2, 2},  {0, 1, 2, 2}};
    const int64_t x = cell[0], y = cell[1], z = cell[2];
    if (qni_field_load_runs(field, cell, -1, 2, runs, 12, stencil))
        return;
    for (int n = 0; n < 4; ++n)
        load_run(field, x - 1, y + (n & 1), z + (n >> 1), 4, stencil + 4 * n);
    for (int n = 0; n < 2; ++n) {
        load_run(field, x, y - 1, z + n, 2, stencil + 16 + 2 * n);
        load_run(field, x, y + 2, z + n, 2, stencil + 20 + 2 * n);
        load_run(field, x, y + n, z - 1, 2, stencil + 24 + 2 * n);
        load_run(field, x, y + n, z + 2, 2, stencil + 28 + 2 * n);
    }
}

void qni_stencil_corners(const double stencil[QNI_STENCIL], double d[8]) {
    for (int c = 0; c < 8; ++c)
        d[c] = stencil[4 * (c >> 1) + 1 + (c & 1)];
}
