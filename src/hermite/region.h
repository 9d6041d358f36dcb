// SPDX-License-Identifier: MIT
/* The solid as it is in one part of the lattice, restricted step by step from the whole: what is
 * far away is left out long before the small parts, so that their cost does not depend on how much
 * there is in all. */
#ifndef QNI_HERMITE_REGION_H
#define QNI_HERMITE_REGION_H

#include "hermite/lattice.h"

enum { QNI_REGION_LEVELS = 20, QNI_REGION_SIDE = 16, QNI_REGION_PLACES = 256 };

/* One of the cubes that share a place: the one asked for last. */
typedef struct qni_region_part {
    int32_t place[3]; /* in cubes of its level */
    qn_solid *solid;  /* NULL: none yet */
} qni_region_part;

/* Cubes of 2^level finest cells, the smallest a block, one in the other. Of one thread. */
typedef struct qni_region {
    const qn_solid *whole;
    const qni_lattice *lattice;
    bool wide; /* right half a cube's width around it, too */
    int32_t top;
    qni_region_part parts[QNI_REGION_LEVELS][QNI_REGION_PLACES];
} qni_region;

void qni_region_start(qni_region *region, const qn_solid *whole, const qni_lattice *lattice,
                      bool wide);
void qni_region_end(qni_region *region);

/* The solid that agrees with the whole in a cube, 2^level finest cells from `low`, of a block's
 * size at least; good until the next question. NULL when a step failed. */
const qn_solid *qni_region_cube(qni_region *region, const int32_t low[3], int32_t level);

#endif
