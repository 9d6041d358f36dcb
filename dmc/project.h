// SPDX-License-Identifier: MIT
/* Ways back onto the trilinear surface of a field, for vertices that simplification made or
 * relaxation moves. */
#ifndef QNI_DMC_PROJECT_H
#define QNI_DMC_PROJECT_H

#include "dmc/dmc.h"

typedef struct qni_projector {
    const qni_field *field;
    const qni_kernels *kernels;
    qni_frame frame;
    double lattice[3][4]; /* world to lattice */
} qni_projector;

void qni_projector_init(const qni_field *field, qni_projector *projector);

/* Onto the surface from nearby: along the axis on which the surface lies most squarely, in the
 * point's own cell or the next one, to the one zero of the interpolant there, if the values cross
 * it in the sense of the normal. Else along the other two. A zero normal stands for that of the
 * cell's values. First all but the values, which are asked for; then with them. With + - * / alone.
 */
void qni_project_start(const qni_projector *projector, const qni_landings *landings,
                       qni_approach *approach);
void qni_project_end(const qni_projector *projector, qni_approach *approach,
                     qni_landings *landings);

/* The functions below take a qni_projector as `user`, may be called from any worker, and use + - *
 * / alone. */

/* The cell that holds a position. False when a vertex there should stay: the cell has several
 * polygons, so that a neighbouring point may belong to another one. In a cell with a single polygon
 * the surface is of one piece. */
bool qni_project_home(const void *user, const float position[3], int32_t cell[3]);

/* Onto the surface within the cell, after stepping back towards `from` (a point of the cell) as far
 * as the cell asks for. False, and nothing changed, when the axis lines through that point do not
 * cross the surface in the cell. */
bool qni_project_in_cell(const void *user, const int32_t cell[3], const float from[3],
                         const float normal[3], float position[3]);

/* The unit normal at a position of the cell: central differences at its corners, interpolated, as
 * for every vertex. Left as it is where they cancel. */
void qni_project_normal(const void *user, const int32_t cell[3], const float position[3],
                        float normal[3]);

#endif
