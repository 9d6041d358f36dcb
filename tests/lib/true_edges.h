// SPDX-License-Identifier: MIT
/* The true edges of a solid made of planes, spheres and cylinders, found without the library: on
 * the curve where two faces meet, the stretches where the solid's own values say that both matter.
 * And how well the tagged edges of a mesh follow them. */
#ifndef TEST_TRUE_EDGES_H
#define TEST_TRUE_EDGES_H

#include "lib/test_solid.h"

typedef enum test_face_kind {
    TEST_FACE_PLANE, /* through the centre, across the axis */
    TEST_FACE_SPHERE,
    TEST_FACE_CYLINDER /* round the axis */
} test_face_kind;

typedef struct test_face {
    test_face_kind kind;
    double centre[3], axis[3], radius;
} test_face;

/* Line: origin + t u. Circle: origin + radius (cos t u + sin t v). Cylinder and sphere: where the
 * sphere holds a piece of the axis's tube whole, two curves, t the angle about the cylinder and
 * `branch` the sign of the height over the sphere's centre; else (branch 0) one, the height being
 * half_height sin t. Heights are squared a + b cos of the angle. */
typedef struct test_curve {
    enum { TEST_LINE, TEST_CIRCLE, TEST_QUARTIC } kind;
    test_face faces[2];
    double origin[3], u[3], v[3], radius;
    double a, b, half_height;
    int branch;
} test_curve;

typedef struct test_edge {
    test_curve curve;
    double low, high; /* in t */
    bool closed;
    double length;
} test_edge;

enum { TEST_MOST_EDGES = 256 };

typedef struct test_edges {
    int count;
    test_edge items[TEST_MOST_EDGES];
} test_edges;

void test_curve_at(const test_curve *curve, double t, double point[3]);
/* `reach` bounds the solid about the origin: lines are looked at from -reach to reach. */
void test_find_edges(const qn_solid *solid, int face_count, const test_face *faces, double reach,
                     test_edges *edges);

/* What the tagged edges of a mesh miss, in cells. */
typedef struct test_sharpness {
    int64_t edges, whole, corners, corners_found; /* edges longer than two cells; their ends */
    int64_t crease_edges, stray; /* tagged edges; those of which an end is off all true edges */
    double missing, farthest;    /* length of gaps, summed; largest distance of a crease vertex */
    double first_gap[3];         /* where the first gap or stray vertex is, for a message */
} test_sharpness;

/* `tolerance` in world units: a crease vertex that is nearer to a true edge lies on it. Sums add up
 * over calls. */
void test_measure_sharpness(const test_edges *edges, const qn_mesh *mesh, double cell,
                            double tolerance, test_sharpness *sum);

#endif
