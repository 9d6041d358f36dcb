// SPDX-License-Identifier: MIT
/* Signs of determinants of float coordinates, never wrong: a filter in double, then exact
 * expansions. */
#ifndef QNI_MESH_PREDICATES_H
#define QNI_MESH_PREDICATES_H

#include <stdbool.h>

/* Sign of ((b - a) x (c - a)) . (d - a): +1 when d lies on the side from which a, b, c run
 * counter-clockwise, 0 when the four are coplanar. Coordinates must be finite. */
int qni_orient3d(const float a[3], const float b[3], const float c[3], const float d[3]);

/* The same sign where the filter alone tells it; else 0, which says nothing. */
int qni_orient3d_quick(const float a[3], const float b[3], const float c[3], const float d[3]);

/* The same sign with no filter before it; what the filter is tested against. */
int qni_orient3d_exact(const float a[3], const float b[3], const float c[3], const float d[3]);

/* Sign of the area of a, b, c seen in the plane of the coordinates x and y (0, 1 or 2): +1 when
 * they run counter-clockwise, 0 when they are collinear there. */
int qni_orient2d(const float a[3], const float b[3], const float c[3], int x, int y);

/* The same two of doubles, each 0 or between 1e-60 and 1e40 in size; the second is the sign of
 * (b - a) x (d - c) in the plane of the coordinates x and y. */
int qni_orient3d_of(const double a[3], const double b[3], const double c[3], const double d[3]);
int qni_turn_of(const double a[3], const double b[3], const double c[3], const double d[3], int x,
                int y);

/* True when the three points lie on one line, or coincide. */
bool qni_collinear(const float a[3], const float b[3], const float c[3]);

#endif
