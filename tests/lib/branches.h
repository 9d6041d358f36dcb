// SPDX-License-Identifier: MIT
/* The branches of the trilinear surface in one cell, by brute force: the cell is cut into n^3
 * boxes, boxes that the surface meets are joined across their faces. */
#ifndef TEST_BRANCHES_H
#define TEST_BRANCHES_H

#include "lib/reference_dmc.h"

/* The box of a polygon's crossings, local coordinates. Its branch lies within: a slice of the
 * trilinear interpolant has saddles only, so no coordinate is extreme inside of the branch, nor on
 * the arcs of its border. */
typedef struct test_box {
    double low[3], high[3];
} test_box;
test_box test_polygon_box(const test_field *field, const int64_t cell[3], uint16_t polygon);
bool test_box_holds(const test_box *box, const double local[3], const double reach[3]);

typedef struct test_branches {
    int boxes;           /* a side */
    int *component;      /* [boxes^3] -1 where no surface is */
    int polygon_root[4]; /* the component of each polygon's crossings */
    bool joined; /* a tunnel, or too coarse boxes, joins two polygons: nothing can be said */
} test_branches;

test_branches test_branches_make(const test_field *field, const int64_t cell[3],
                                 const uint16_t polygons[4], int polygon_count, int boxes);
void test_branches_free(test_branches *branches);

/* The polygons, as a mask, on whose branch a point of the cell may lie; 0 when no surface is near.
 */
unsigned test_branches_at(const test_branches *branches, int polygon_count, const double local[3],
                          const double reach[3]);

#endif
