// SPDX-License-Identifier: MIT
/* Distances from points to a mesh of triangles, and sampled distances from one mesh to another. */
#ifndef TEST_MESH_DISTANCE_H
#define TEST_MESH_DISTANCE_H

#include "lib/support.h"

/* A tree of boxes over the triangles of a mesh, in double precision. */
typedef struct test_distance_tree test_distance_tree;

/* The mesh must have a triangle at least; its arrays are copied. */
test_distance_tree *test_distance_tree_create(const qn_mesh *mesh);
void test_distance_tree_destroy(test_distance_tree *tree);
double test_distance_to_mesh(const test_distance_tree *tree, const double point[3]);

typedef struct test_deviation {
    double largest, mean; /* mean over the samples, of which so many lie on equal areas */
    int64_t samples;
    double where[3]; /* the sample of the largest */
} test_deviation;

/* From `mesh` to the tree's mesh: its vertices, and `count` points spread evenly over its area. The
 * mean is that of the points on the area. */
test_deviation test_mesh_deviation(const qn_mesh *mesh, int64_t count,
                                   const test_distance_tree *tree);

#endif
