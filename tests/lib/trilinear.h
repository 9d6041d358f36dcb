// SPDX-License-Identifier: MIT
/* The trilinear interpolant of a field, its gradient, and how far a rounded vertex may stand off
 * it. */
#ifndef TEST_TRILINEAR_H
#define TEST_TRILINEAR_H

#include "lib/test_volume.h"

/* The eight corner distances of a cell; corner x + 2 y + 4 z. */
void test_cell_corners(const test_field *field, const int64_t cell[3], double corners[8]);
/* Value at local coordinates of the cell, 0 to 1 on each axis; gradient may be NULL. */
double test_trilinear(const double corners[8], const double local[3], double gradient[3]);

void test_to_world(const test_field *field, const double index[3], double world[3]);
void test_to_index(const test_field *field, const float world[3], double index[3]);
/* The cell that holds an index position (one of several on a border between cells). */
void test_cell_of(const test_field *field, const double index[3], int64_t cell[3]);
/* For each index axis, how far a float position may be off its exact place by rounding to float. */
void test_rounding(const test_field *field, const float world[3], double rounding[3]);

/* How a vertex stands in its cell. */
typedef struct test_standing {
    double deviation; /* |value - iso| at the vertex */
    double allowance; /* what rounding the coordinates to float can do to it */
    double
        outside; /* how far it lies outside of the cell, beyond rounding; index units, 0 inside */
} test_standing;

test_standing test_vertex_standing(const test_field *field, const int64_t cell[3],
                                   const float world[3]);

#endif
