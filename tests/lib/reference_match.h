// SPDX-License-Identifier: MIT
/* Is the tested mesh the reference's mesh? Vertices are known by their cell, quads by the one
 * lattice edge that their four cells share; so a match is a proof of equal connectivity, not an
 * estimate. */
#ifndef TEST_REFERENCE_MATCH_H
#define TEST_REFERENCE_MATCH_H

#include "lib/reference_dmc.h"

typedef struct test_match {
    int64_t
        *vertex_polygon;  /* [vertex_count] the reference polygon of each vertex. In open meshes the
                             polygons of a cell that carry no quad are told apart by nothing. */
    test_edge *quad_edge; /* [quad_count] the lattice edge that each quad lies round */
    int64_t segments;     /* interior face segments, each seen once in both directions */
} test_match;

/* Compares counts, connectivity, winding and the two directions of every interior face segment. On
 * a difference the test fails with a sentence. */
test_match test_match_mesh(const test_field *field, const test_reference *reference,
                           const qn_mesh *mesh);
/* The same for the counters of the report. */
void test_match_report(const test_field *field, const test_reference *reference,
                       const qn_surface_report *report);
void test_match_free(test_match *match);

#endif
