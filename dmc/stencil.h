// SPDX-License-Identifier: MIT
/* The values that the vertex of one cell needs, from the field rather than from a tile: for
 * vertices that are made or moved after emission. */
#ifndef QNI_DMC_STENCIL_H
#define QNI_DMC_STENCIL_H

#include "dmc/dmc.h"

/* In the order of place_hd.h; one point beyond the lattice's ends extrapolated. */
void qni_load_stencil(const qni_field *field, const int64_t cell[3], double stencil[QNI_STENCIL]);
/* The cell's corner values among them. */
void qni_stencil_corners(const double stencil[QNI_STENCIL], double d[8]);

#endif
