// SPDX-License-Identifier: MIT
/* The topology of the trilinear surface in one cell by brute force: the cell is cut into n^3 boxes,
 * whose edges, faces and corners say which parts above and below hang together. Tunnels narrower
 * than a box may be missed, none is made up. */
#ifndef TEST_REFINED_CELL_H
#define TEST_REFINED_CELL_H

#include <stdint.h>

typedef struct test_refined {
    int regions;   /* parts above and parts below, together */
    int surfaces;  /* pieces of surface */
    int euler;     /* of the surface */
    int region[8]; /* of each corner of the cell */
} test_refined;

/* d: corner values less iso. */
test_refined test_refine_cell(const double d[8], int n);

#endif
