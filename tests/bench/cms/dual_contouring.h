// SPDX-License-Identifier: MIT
/* Plain dual contouring on Hermite data, for comparison. Source: Ju, Losasso, Schaefer, Warren,
 * "Dual contouring of Hermite data", 2002: one vertex in each cell with a change of sign, at the
 * least squares point of its crossings' planes; one quad round each edge with a change of sign. */
#ifndef BENCH_CMS_DUAL_CONTOURING_H
#define BENCH_CMS_DUAL_CONTOURING_H

#include "hermite/hermite.h"

/* Of an edge with several crossings the first one of the right direction counts. False where the
 * cell has no change of sign. Eigenvalues of the normal equations below a tenth of the largest are
 * dropped [Ju 2002, section 2.3]; the point is not kept in the cell. */
bool dual_contouring_vertex(const qni_hermite *hermite, const int32_t cell[3], double vertex[3]);

#endif
