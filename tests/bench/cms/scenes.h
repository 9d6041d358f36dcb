// SPDX-License-Identifier: MIT
/* The solids that the benchmarks of Cubical Marching Squares take, and their surfaces. */
#ifndef BENCH_CMS_SCENES_H
#define BENCH_CMS_SCENES_H

#include "lib/support.h"

/* The union of a cube and a cylinder, less a sphere: [CMS05] figure 8, whose sizes it does not
 * tell. */
qn_solid *scene_figure_8(qn_context *context);
/* libfive's model: the cube [-1, 1]^3 less a sphere of radius 1.2 at (1, 1, 1), united with a
 * cylinder of radius 0.35, |z| < 1.5, at (-0.3, -0.3); as it is, or turned 0.5 rad about (1, 2, 3).
 */
qn_solid *scene_libfive(qn_context *context, bool turned);
/* A cube of side 2, turned 0.6 rad about (3, 1, 2), off the origin. */
qn_solid *scene_turned_cube(qn_context *context);
/* `count` turned boxes, balls, cylinders, cones and rings, of which every fifth is taken away. */
qn_solid *scene_primitives(qn_context *context, int count);
/* A file of the data folder's csg/; NULL, with a line on stderr, where it is not there or needs
 * what was not built in. */
qn_solid *scene_file(qn_context *context, const char *name);

typedef struct scene_surface {
    qn_mesh *mesh;
    qn_solid_surface_report report;
} scene_surface;

/* Tolerance in finest cells; 0: the default. Fails the program when there is no surface. */
scene_surface scene_make_surface(qn_context *context, const qn_solid *solid, int depth,
                                 double tolerance_cells, bool uniform);
/* " 1,234 ": thousands apart; the text is good until the eighth call after it. */
const char *scene_count(int64_t count);

#endif
