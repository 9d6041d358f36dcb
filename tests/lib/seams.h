// SPDX-License-Identifier: MIT
/* Where the parts of a solid meet: how well the tagged edges of a mesh follow their seams, found
 * without the library's surfacer by Newton's method on the values of two parts. */
#ifndef TEST_SEAMS_H
#define TEST_SEAMS_H

#include "lib/support.h"

enum { TEST_SEAM_PARTS = 3 };

/* The whole is made of the parts, whose owners are 1, 2, 3; sign -1: it is taken away. */
typedef struct test_parts {
    qn_solid *whole, *parts[TEST_SEAM_PARTS];
    int signs[TEST_SEAM_PARTS];
} test_parts;

/* Sums add up over calls. Edges shorter than a thousandth of a cell are left out: their triangles
 * have no normals to speak of. */
typedef struct test_seams {
    int64_t edges, flat; /* where two owners meet; of those that turn by less than 35 degrees */
    int64_t untagged;    /* others that are no crease edges */
    int64_t shallow;     /* of these, beside a seam that turns by less than 35 degrees itself */
    int64_t points,
        missing;     /* of seams that turn by more than 40; over 0.1 cells from all tagged */
    double farthest; /* in cells */
    double where[3]; /* the farthest one, or the last untagged edge */
} test_seams;

void test_measure_seams(const test_parts *parts, const qn_mesh *mesh, double cell, test_seams *sum);

#endif
