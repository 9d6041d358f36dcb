// SPDX-License-Identifier: MIT
/* Measures of a mesh that the tests compute for themselves, beside qn_mesh_check(). */
#ifndef TEST_MESH_MEASURE_H
#define TEST_MESH_MEASURE_H

#include "lib/support.h"

typedef struct test_edges {
    int64_t unbalanced;    /* undirected edges that are not used as often one way as the other */
    int64_t once;          /* of these, edges with one face: boundary */
    int64_t more_than_two; /* edges of more than two faces */
    int64_t count;         /* undirected edges */
} test_edges;

/* Edges of all quads and triangles, by sorting. */
test_edges test_mesh_edges(const qn_mesh *mesh);
/* Unbalanced edges with an end strictly within the box: cracks, when the box leaves out the
 * border's cells. */
int64_t test_mesh_cracks(const qn_mesh *mesh, const double low[3], const double high[3]);
/* Area of the faces and signed volume, quads as two triangles from their first corner. */
void test_mesh_area_volume(const qn_mesh *mesh, double *area, double *volume);
/* The number of pieces that share vertices, and whether the vertices of all faces are finite. */
int64_t test_mesh_pieces(const qn_mesh *mesh);
bool test_mesh_is_finite(const qn_mesh *mesh);
/* [DMC21] equation (9), the mean over the quads, and (8), the mean over the triangles. */
double test_mean_quad_quality(const qn_mesh *mesh);
double test_mean_triangle_quality(const qn_mesh *mesh);

#endif
