// SPDX-License-Identifier: MIT
/* What the tables say of one mesh. */
#ifndef BENCH_TABLES_MEASURE_H
#define BENCH_TABLES_MEASURE_H

#include "bench/bench.h"

enum { TABLES_VALENCES = 10 };

typedef struct tables_measure {
    bool known;
    int64_t vertices, quads, triangles; /* triangles: of the split when there are quads */
    double deviation_formula; /* mean over the vertices of |f - iso| with the formula; NAN: none */
    double deviation;         /* the same with the trilinear interpolant of the samples */
    double range;             /* of the samples */
    double quad_quality, triangle_quality;       /* means of equations (9) and (8) */
    double irregular_quads, irregular_triangles; /* percent of vertices of valence not 4, not 6 */
    double irregular_inner;                      /* the first of them, boundary vertices left out */
    double nonmanifold;                          /* percent of vertices */
    double valences[TABLES_VALENCES]; /* percent, by edges of the quads; the last: all above */
} tables_measure;

/* Measures a mesh in index space, open at the border; a mesh of quads is split for the triangles'
 * part. `value` is the formula at a sample's place, or NULL. */
tables_measure tables_measure_mesh(qn_context *context, const bench_volume *volume,
                                   double (*value)(const void *user, const double index[3]),
                                   const void *user, qn_mesh *mesh);

#endif
