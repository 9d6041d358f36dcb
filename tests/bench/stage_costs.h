// SPDX-License-Identifier: MIT
/* What each stage after the extraction adds to a call, in user time and memory. */
#ifndef BENCH_STAGE_COSTS_H
#define BENCH_STAGE_COSTS_H

#include <qn/qn.h>

/* Each stage's options; STAGE_SIMPLIFIED has no halfedges, STAGE_RELAXED is simplified and has
 * them. */
enum {
    STAGE_PLAIN, /* doubled edges kept */
    STAGE_REPAIRED,
    STAGE_HALFEDGES,
    STAGE_SIMPLIFIED,
    STAGE_SIMPLIFIED_LINKED, /* with halfedges, patched in place */
    STAGE_RELAXED,           /* three sweeps */
    STAGES
};

typedef struct stage_costs {
    double seconds[STAGES]; /* least user time of a whole call */
    qn_surface_report report[STAGES];
} stage_costs;

/* The stages up to `last` in turns, `runs` times, so that a busy machine spoils no ratio. */
bool stage_costs_measure(qn_context *context, const qn_volume *volume, double iso, bool open,
                         int runs, int last, stage_costs *costs_out);
/* What a stage adds to the one it builds on, in seconds. */
double stage_costs_added(const stage_costs *costs, int stage);
/* Most bytes held beside the mesh while the stage ran, for each vertex extracted. */
double stage_costs_bytes(const stage_costs *costs, int stage);

#endif
