// SPDX-License-Identifier: MIT
/* Solids for the tests: planes, spheres, cylinders, cones, tori, moved and turned, joined by min
 * and max; their crossings with a segment are exact. Independent of the library's own kinds of
 * solid. */
#ifndef TEST_SOLID_H
#define TEST_SOLID_H

#include "lib/support.h"
#include "solid/solid.h"

typedef struct test_frame {
    double turn[3][3]; /* rows: the body's axes in the world */
    double origin[3];
} test_frame;

/* All return a new solid that owns its parts. `owner` names the surface. */
qn_solid *test_plane(qn_context *context, const double normal[3], double offset,
                     int32_t owner); /* normal . p < offset */
qn_solid *test_sphere(qn_context *context, const double centre[3], double radius, int32_t owner);
/* Round the frame's z axis. The cone is one nappe, its tip at the origin, opening towards -z. */
qn_solid *test_cylinder(qn_context *context, const test_frame *frame, double radius, int32_t owner);
qn_solid *test_cone(qn_context *context, const test_frame *frame, double half_angle, int32_t owner);
qn_solid *test_torus(qn_context *context, const test_frame *frame, double ring, double tube,
                     int32_t owner);
qn_solid *test_union(qn_solid *a, qn_solid *b);
qn_solid *test_intersection(qn_solid *a, qn_solid *b);
qn_solid *test_difference(qn_solid *a, qn_solid *b);
/* Made of planes; owners from `owner` on. */
qn_solid *test_box(qn_context *context, const test_frame *frame, const double half[3],
                   int32_t owner);
/* Finite ones: |z| < half. The finite cone has its tip at z = 0 and its base at z = -height. */
qn_solid *test_finite_cylinder(qn_context *context, const test_frame *frame, double radius,
                               double half, int32_t owner);
qn_solid *test_finite_cone(qn_context *context, const test_frame *frame, double half_angle,
                           double height, int32_t owner);

test_frame test_frame_at(double x, double y, double z);
test_frame test_random_frame(test_random *random, double spread);
void test_solid_set_box(qn_solid *solid, double low, double high);
double test_solid_value(const qn_solid *solid, const double point[3]);

#endif
