// SPDX-License-Identifier: MIT
/* What each stage costs beside the extraction, on one thread: user time of runs taken in turns, the
 * least of each, so that a busy machine spoils no ratio. stages [part of a volume's name] [runs]
 * [last stage, 0 to 4] */
#include "bench/bench.h"
#include "lib/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { PLAIN, REPAIRED, HALFEDGES, SIMPLIFIED, RELAXED, STAGES };

static double user_seconds(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
}

static qn_surface_options options_of(int stage, const double *iso) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = iso;
    options.isovalue_count = 1;
    options.keep_doubled = stage == PLAIN;
    options.halfedges = stage == HALFEDGES;
    options.simplify = stage >= SIMPLIFIED;
    options.relax = stage == RELAXED ? 3 : 0;
    return options;
}

typedef struct costs {
    double seconds[STAGES]; /* least user time of a whole call */
    double simplify;        /* of simplification alone, least */
    qn_surface_report report[STAGES];
} costs;

/* As many calls in one measurement as take a tenth of a second, for the clock's sake. */
static bool measure(qn_context *context, const bench_volume *bench, int runs, int last, costs *c) {
    qn_grid grid;
    qn_volume *volume = NULL;
    memset(&grid, 0, sizeof grid);
    grid.samples = bench->samples;
    grid.scalar = bench->scalar;
    grid.swapped = bench->swapped;
    memcpy(grid.size, bench->size, sizeof grid.size);
    if (qn_volume_create(context, &grid, NULL, NULL, &volume, NULL) != QN_OK)
        return false;
    int repeats = 1;
    for (int stage = 0; stage < STAGES; ++stage)
        c->seconds[stage] = INFINITY;
    c->simplify = INFINITY;
    for (int run = 0; run < runs; ++run)
        for (int stage = 0; stage <= last; ++stage) {
            const qn_surface_options options = options_of(stage, &bench->iso);
            const double start = user_seconds();
            for (int n = 0; n < repeats; ++n) {
                qn_mesh *mesh = NULL;
                if (qn_surface(context, volume, &options, &mesh, c->report + stage, NULL) != QN_OK)
                    return false;
                qn_mesh_destroy(mesh);
            }
            const double took = (user_seconds() - start) / repeats;
            if (run == 0 && stage == PLAIN)
                repeats = took < 0.1 ? (int)(0.1 / fmax(took, 1e-3)) + 1 : 1;
            else
                c->seconds[stage] = fmin(c->seconds[stage], took);
            if (stage == SIMPLIFIED)
                c->simplify = fmin(c->simplify, c->report[stage].seconds_simplify);
        }
    qn_volume_destroy(volume);
    return true;
}

static void print_row(const bench_volume *volume, const costs *c) {
    const double *s = c->seconds, vertices = (double)c->report[PLAIN].vertices;
    printf("| %s | %lld | %.1f ns | %+.1f %% | %+.0f %% | %.0f %% (%.1f ns; wall) | %+.0f %% | "
           "%+.0f %% | %.0f, %.0f |\n",
           volume->name, (long long)c->report[REPAIRED].vertices, 1e9 * s[PLAIN] / vertices,
           100 * (s[REPAIRED] / s[PLAIN] - 1), 100 * (s[HALFEDGES] - s[REPAIRED]) / s[PLAIN],
           100 * c->simplify / s[PLAIN], 1e9 * c->simplify / vertices,
           100 * (s[SIMPLIFIED] - s[REPAIRED]) / s[PLAIN],
           100 * (s[RELAXED] - s[SIMPLIFIED]) / s[PLAIN],
           (double)c->report[REPAIRED].scratch_bytes / vertices,
           (double)c->report[RELAXED].scratch_bytes / vertices);
    fflush(stdout);
}

int main(int argc, char **argv) {
    qn_context *context = test_context(1);
    const int runs = argc > 2 ? atoi(argv[2]) : 5;
    const int last = argc > 3 && atoi(argv[3]) < STAGES ? atoi(argv[3]) : STAGES - 1;
    printf(
        "| volume | vertices | extraction, a vertex | repair | halfedges | simplification alone | "
        "with what it needs | relaxation, 3 sweeps | bytes a vertex beside the mesh, without and "
        "with these |\n|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 0; n < BENCH_VOLUMES; ++n) {
        bench_volume volume;
        costs c;
        if ((argc > 1 && !strstr(bench_volume_name(n), argv[1])) || !bench_volume_make(n, &volume))
            continue;
        memset(&c, 0, sizeof c);
        if (measure(context, &volume, runs, last, &c))
            print_row(&volume, &c);
        bench_volume_free(&volume);
    }
    qn_context_destroy(context);
    return 0;
}
