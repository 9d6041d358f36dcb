// SPDX-License-Identifier: MIT
/* What each stage costs beside the extraction: user time of runs taken in turns, the least of each,
 * so that a busy machine spoils no ratio. stages [part of a volume's name] [runs] [threads] [last
 * stage, 1 repair to 5 relaxation, which takes most of the time] */
#include "bench/bench.h"
#include "bench/stage_costs.h"
#include "lib/support.h"

#include <stdlib.h>
#include <string.h>

static void print_row(const bench_volume *volume, int last, const stage_costs *c) {
    const double plain = c->seconds[STAGE_PLAIN];
    const double vertices = (double)c->report[STAGE_PLAIN].vertices;
    printf("| %s | %lld | %.1f ns |", volume->name, (long long)c->report[STAGE_REPAIRED].vertices,
           1e9 * plain / vertices);
    for (int stage = STAGE_REPAIRED; stage < STAGES; ++stage)
        if (stage <= last)
            printf(" %+.1f %% |", 100 * stage_costs_added(c, stage) / plain);
        else
            printf(" - |");
    for (int stage = STAGE_PLAIN; stage <= last; ++stage)
        printf("%s%.1f", stage == STAGE_PLAIN ? " " : ", ", stage_costs_bytes(c, stage));
    printf(" |\n");
    fflush(stdout);
}

static bool measure(qn_context *context, const bench_volume *bench, int runs, int last,
                    stage_costs *c) {
    qn_grid grid;
    qn_volume *volume = NULL;
    memset(&grid, 0, sizeof grid);
    grid.samples = bench->samples;
    grid.scalar = bench->scalar;
    grid.swapped = bench->swapped;
    memcpy(grid.size, bench->size, sizeof grid.size);
    if (qn_volume_create(context, &grid, NULL, NULL, &volume, NULL) != QN_OK)
        return false;
    const bool good = stage_costs_measure(context, volume, bench->iso, false, runs, last, c);
    qn_volume_destroy(volume);
    return good;
}

int main(int argc, char **argv) {
    const int runs = argc > 2 ? atoi(argv[2]) : 5;
    const int last = argc > 4 && atoi(argv[4]) < STAGES ? atoi(argv[4]) : STAGES - 1;
    qn_context *context = test_context(argc > 3 ? atoi(argv[3]) : 1);
    printf(
        "| volume | vertices | extraction with normals, a vertex | repair | halfedges | "
        "simplification without halfedges | with them, beside them | relaxation, 3 sweeps | bytes "
        "a vertex beside the mesh: extraction, and each of these |\n"
        "|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 0; n < BENCH_VOLUMES; ++n) {
        bench_volume volume;
        stage_costs costs;
        if ((argc > 1 && !strstr(bench_volume_name(n), argv[1])) || !bench_volume_make(n, &volume))
            continue;
        memset(&costs, 0, sizeof costs);
        if (measure(context, &volume, runs, last, &costs))
            print_row(&volume, last, &costs);
        bench_volume_free(&volume);
    }
    qn_context_destroy(context);
    return 0;
}
