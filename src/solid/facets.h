// SPDX-License-Identifier: MIT
/* Facetted spheres and cylinders as OpenSCAD makes them. */
#ifndef QNI_SOLID_FACETS_H
#define QNI_SOLID_FACETS_H

#include "solid/node.h"

/* A sphere has half the square of them as facets: half a million. A circle may have more. */
enum { QNI_SPHERE_FRAGMENTS = 1 << 10, QNI_CIRCLE_FRAGMENTS = 1 << 14 };

/* Sine and cosine of degrees, exact at multiples of 90, and of 30 where they are 0.5. */
double qni_sin_degrees(double degrees);
double qni_cos_degrees(double degrees);

/* Points of a circle: the first lies on the x axis. */
void qni_circle_point(double radius, int32_t fragments, int32_t n, double point[2]);
/* The rings of a sphere: how many, and radius and z of one, from the top down. */
int32_t qni_sphere_rings(int32_t fragments);
void qni_sphere_ring(double radius, int32_t fragments, int32_t ring, double *ring_radius,
                     double *z);

/* From z = low to low + height. NULL when memory is short. */
qn_solid *qni_facet_cylinder(qn_context *context, double low, double height, double low_radius,
                             double high_radius, int32_t fragments, int32_t owner);
qn_solid *qni_facet_sphere(qn_context *context, double radius, int32_t fragments, int32_t owner);
/* The same, round. */
qn_solid *qni_round_cylinder(qn_context *context, double low, double height, double low_radius,
                             double high_radius, int32_t owner);

#endif
