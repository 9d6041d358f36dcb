// SPDX-License-Identifier: MIT
/* Merged vertices on their way back onto the surface, many at a time. What is computed for each is
 * said by project_hd.h and project.c; here it lies across lanes (landing_body.h). */
#ifndef QNI_DMC_LANDING_H
#define QNI_DMC_LANDING_H

#include "volume/field.h"

struct qni_projector;

/* All arrays have values up to the next multiple of 8 lanes. */
enum { QNI_LANDINGS = QNI_CELLS_TOGETHER };

/* Points near the surface, to be put onto it. */
typedef struct qni_landings {
    int count;
    float position[3][QNI_LANDINGS]; /* of no meaning afterwards unless landed */
    float normal[3][QNI_LANDINGS]; /* the surface's there, unit length, about right; 0: not known */
    int64_t landed[QNI_LANDINGS];  /* out: whether the surface was within reach */
} qni_landings;

/* The corners a, b, X and Y of merged quads. */
typedef struct qni_meetings {
    float position[4][3][QNI_LANDINGS];
    float normal[4][3][QNI_LANDINGS]; /* 0: there are none */
} qni_meetings;

/* Where points are in the lattice, and how the values rise there. */
typedef struct qni_approach {
    double at[3][QNI_LANDINGS];
    double cell[3][QNI_LANDINGS];  /* whole numbers */
    qni_cells cells;               /* the same */
    double slope[3][QNI_LANDINGS]; /* of which the surface's normal is sure */
    double corner[8][QNI_LANDINGS];
} qni_approach;

/* The middle between a and b and their mean normal; with `move` then between X and Y. */
typedef void qni_meet_kernel(const qni_meetings *meetings, bool move, qni_landings *landings);
/* All of the approach but the corners' values. */
typedef void qni_locate_kernel(const struct qni_projector *projector, const qni_landings *landings,
                               qni_approach *approach);
/* Along the axis on which the surface lies most squarely, within the cell. */
typedef void qni_land_kernel(const struct qni_projector *projector, qni_approach *approach,
                             qni_landings *landings);

#endif
