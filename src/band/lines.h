// SPDX-License-Identifier: MIT
/* Winding numbers of a mesh at all samples of a lattice, from its lines along x. */
#ifndef QNI_BAND_LINES_H
#define QNI_BAND_LINES_H

#include "band/band.h"
#include "mesh/nearest.h"

/* From sample `index` of its line on, the winding number is `winding`. */
typedef struct qni_line_step {
    int32_t index, winding;
} qni_line_step;

typedef struct qni_lines {
    qn_context *context;
    int32_t low[2];  /* y and z of the first line */
    int64_t size[2]; /* lines along y and z */
    int64_t *starts; /* [lines + 1]: of each line's steps, ascending */
    qni_line_step *steps;
    int64_t step_count;
    int64_t open_lines; /* with a winding number other than 0 at their end */
    int64_t odd_lines;  /* with an odd one */
} qni_lines;

/* Scan conversion of the triangles. Point (y, z) is counted within a triangle by the edges that a
 * ray from it along y meets, half-open at their ends; where such a ray passes an edge is a function
 * of the edge alone. So the windings along a line add up to 0 exactly when the edges of the faces
 * cancel, whatever rounding does. */
qn_status qni_lines_create(qni_check *work, const qni_nearest *mesh, const qni_lattice *lattice,
                           qni_lines *lines_out);
void qni_lines_destroy(qni_lines *lines);
/* The winding number at sample p. */
int32_t qni_lines_winding(const qni_lines *lines, const int32_t p[3]);
/* The same for eight samples along x from p on. */
void qni_lines_windings(const qni_lines *lines, const int32_t p[3], int32_t windings[8]);

#endif
