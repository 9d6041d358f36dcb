// SPDX-License-Identifier: MIT
/* Ways through the inside or the outside of a solid, within a cell or a face of it: through samples
 * of one sign, no step crossing the surface. What a way joins hangs together in truth. */
#ifndef QNI_CMS_WAY_H
#define QNI_CMS_WAY_H

#include "hermite/hermite.h"

enum { QNI_WAY_SIDE = 8, QNI_WAY_SAMPLES = QNI_WAY_SIDE * QNI_WAY_SIDE * QNI_WAY_SIDE };

typedef struct qni_way {
    const qn_solid *solid;
    double low[3], high[3];
    int side[3]; /* samples along each axis: QNI_WAY_SIDE, or 1 where low and high are the same */
    bool inside[QNI_WAY_SAMPLES];
    bool end[QNI_WAY_SAMPLES];
    int16_t before[QNI_WAY_SAMPLES];  /* on the way; -1: not reached, itself: a start */
    bool blocked[3][QNI_WAY_SAMPLES]; /* the step to the next along an axis meets the surface */
} qni_way;

/* Samples of the box; false when the solid fails. */
bool qni_way_init(qni_way *way, const qn_solid *solid, const double low[3], const double high[3]);
/* x fastest. */
void qni_way_point(const qni_way *way, int sample, double point[3]);
/* A clear way from any of the starts to any of the ends; which end it reaches, or -1. With
 * `border`, on the box's border alone. */
int qni_way_find(qni_way *way, bool inside, const bool *starts, bool border);

#endif
