// SPDX-License-Identifier: MIT
/* Closed meshes for the tests: bumpy balls and boxes, turned, overlapping, in one mesh. */
#ifndef TEST_CLOSED_MESH_H
#define TEST_CLOSED_MESH_H

#include "lib/support.h"

/* Triangles that grow piece by piece. */
typedef struct test_pieces {
    int64_t vertex_count, triangle_count;
    float *positions;
    uint32_t *triangles;
} test_pieces;

/* A ball of rings * segments vertices and two poles; its radius varies by `bumps` of it. */
void test_add_ball(test_pieces *pieces, test_random *random, const double centre[3], double radius,
                   double bumps, int rings, int segments);
/* A box with the given half sides, turned by `angle` about a random axis. */
void test_add_box(test_pieces *pieces, test_random *random, const double centre[3],
                  const double half[3], double angle);
/* The mesh of all pieces, which are given up. */
qn_mesh *test_pieces_mesh(qn_context *context, test_pieces *pieces);

/* The winding number of a closed mesh about a point, by solid angles. */
double test_winding_number(const qn_mesh *mesh, const double p[3]);
/* The distance to the nearest triangle, by trying all. */
double test_mesh_distance_to(const qn_mesh *mesh, const double p[3]);

#endif
