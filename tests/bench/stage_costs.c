// SPDX-License-Identifier: MIT
/* Calls with one stage more each, timed in turns; the least user time of each counts. */
#include "bench/stage_costs.h"

#include <math.h>
#include <stddef.h>
#include <sys/resource.h>

static double user_seconds(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
}

static qn_surface_options options_of(int stage, const double *iso, bool open) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = iso;
    options.isovalue_count = 1;
    options.open = open;
    options.keep_doubled = stage == STAGE_PLAIN;
    options.halfedges = stage == STAGE_HALFEDGES || stage >= STAGE_SIMPLIFIED_LINKED;
    options.simplify = stage >= STAGE_SIMPLIFIED;
    options.relax = stage == STAGE_RELAXED ? 3 : 0;
    return options;
}

/* As many calls in one measurement as take a tenth of a second, for the clock's sake. */
bool stage_costs_measure(qn_context *context, const qn_volume *volume, double iso, bool open,
                         int runs, int last, stage_costs *c) {
    int repeats = 1;
    for (int stage = 0; stage < STAGES; ++stage)
        c->seconds[stage] = INFINITY;
    for (int run = 0; run < runs; ++run)
        for (int stage = 0; stage <= last; ++stage) {
            const qn_surface_options options = options_of(stage, &iso, open);
            const double start = user_seconds();
            for (int n = 0; n < repeats; ++n) {
                qn_mesh *mesh = NULL;
                if (qn_surface(context, volume, &options, &mesh, c->report + stage, NULL) != QN_OK)
                    return false;
                qn_mesh_destroy(mesh);
            }
            const double took = (user_seconds() - start) / repeats;
            if (run == 0 && stage == STAGE_PLAIN)
                repeats = took < 0.1 ? (int)(0.1 / fmax(took, 1e-3)) + 1 : 1;
            else
                c->seconds[stage] = fmin(c->seconds[stage], took);
        }
    return true;
}

double stage_costs_added(const stage_costs *c, int stage) {
    static const int base[STAGES] = {
        -1, STAGE_PLAIN, STAGE_REPAIRED, STAGE_REPAIRED, STAGE_HALFEDGES, STAGE_SIMPLIFIED_LINKED};
    return c->seconds[stage] - (base[stage] < 0 ? 0 : c->seconds[base[stage]]);
}

double stage_costs_bytes(const stage_costs *c, int stage) {
    return (double)c->report[stage].scratch_bytes / (double)c->report[STAGE_PLAIN].vertices;
}
