// SPDX-License-Identifier: MIT
/* How much of a polygon model's creases the surface made of it has (as tests/bench/crease-share
 * measures for files). */
#ifndef TEST_CREASE_SHARE_H
#define TEST_CREASE_SHARE_H

#include "lib/polygon_models.h"

typedef struct test_crease_share {
    int64_t points, missing; /* a quarter of a cell apart; farther than 0.1 cells from all tagged
                                edges */
    double farthest;         /* in cells */
    double where[3];         /* the farthest one */
} test_crease_share;

/* How far a point is from the nearest tagged edge of a mesh; infinite without any. */
double test_distance_to_tagged(const qn_mesh_view *view, const double p[3]);
/* Creases are edges of two triangles that turn by more than the angle; their points are those of
 * the model's floats. */
test_crease_share test_measure_creases(const test_model *model, double degrees, const qn_mesh *mesh,
                                       double cell);

#endif
