// SPDX-License-Identifier: MIT
/* Convex hulls of points, by way of the Qhull library. */
#ifndef QNI_SOLID_HULL_H
#define QNI_SOLID_HULL_H

#include "solid/node.h"

/* Points that grow. */
typedef struct qni_points {
    double (*at)[3];
    int64_t count, capacity;
} qni_points;
bool qni_points_add(qn_context *context, qni_points *points, const double point[3]);
void qni_points_free(qn_context *context, qni_points *points);

typedef struct qni_hull {
    double (*planes)[4]; /* n . p < d */
    int64_t plane_count;
    bool flat; /* the points lie in a plane (in two dimensions: on a line), or there are too few */
} qni_hull;

/* The hull in three dimensions, or of x and y in two. `corner`, which may be NULL, has room for a
 * mark for each point. What fails inside the library is QN_ERROR_INPUT; a build without it
 * QN_ERROR_UNSUPPORTED. */
qn_status qni_hull_make(qn_context *context, int dimension, const qni_points *points, bool *corner,
                        qni_hull *hull, qn_error *error);
void qni_hull_free(qn_context *context, qni_hull *hull);

#endif
