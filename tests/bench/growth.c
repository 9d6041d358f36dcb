// SPDX-License-Identifier: MIT
/* Whether every stage stays linear: the same formulas, sampled finer and finer. The exponent is the
 * slope of log(time) over log(size) by least squares, where size counts vertices, and samples as
 * well for the extraction, which has to look at them all. growth [largest n] [runs] */
#include "bench/stage_costs.h"
#include "lib/analytic.h"
#include "lib/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIZES = 7 };
static const int64_t sizes[SIZES] = {64, 96, 128, 192, 256, 384, 512};
static const char *const names[STAGES] = {"extraction",
                                          "repair",
                                          "halfedges",
                                          "simplification, no halfedges",
                                          "simplification, with them",
                                          "relaxation, 3 sweeps"};

static double exponent_of(const double *size, const double *time, int count) {
    double x = 0, y = 0, xx = 0, xy = 0;
    for (int n = 0; n < count; ++n) {
        const double a = log(size[n]), b = log(fmax(time[n], 1e-9));
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    return (count * xy - x * y) / (count * xx - x * x);
}

static bool measure(qn_context *context, const char *formula, int64_t n, int runs,
                    stage_costs *costs) {
    void *samples;
    qn_volume *volume =
        test_analytic_volume(context, test_analytic_find(formula), n, QN_F32, &samples);
    memset(costs, 0, sizeof *costs);
    const bool good = stage_costs_measure(context, volume, test_analytic_iso(QN_F32), true, runs,
                                          STAGES - 1, costs);
    qn_volume_destroy(volume);
    free(samples);
    return good;
}

static void print_table(const char *formula, const stage_costs *costs, int count) {
    double size[SIZES], time[SIZES];
    printf("\n| %s, open; ns (bytes beside the mesh) a vertex |", formula);
    for (int n = 0; n < count; ++n)
        printf(" %lld^3: %lld vertices |", (long long)sizes[n],
               (long long)costs[n].report[STAGE_PLAIN].vertices);
    printf(" exponent |\n|---|");
    for (int n = 0; n <= count; ++n)
        printf("---|");
    for (int stage = 0; stage < STAGES; ++stage) {
        if (stage == STAGE_REPAIRED && costs[count - 1].report[stage].repaired_edges == 0)
            continue; /* nothing to time */
        printf("\n| %s |", names[stage]);
        for (int n = 0; n < count; ++n) {
            const double vertices = (double)costs[n].report[STAGE_PLAIN].vertices;
            time[n] = stage_costs_added(costs + n, stage);
            size[n] = vertices + (stage == STAGE_PLAIN ? pow((double)sizes[n], 3) : 0);
            printf(" %.1f (%.1f) |", 1e9 * time[n] / vertices, stage_costs_bytes(costs + n, stage));
        }
        printf(" %.2f |", exponent_of(size, time, count));
    }
    printf("\n");
    fflush(stdout);
}

int main(int argc, char **argv) {
    static const char *const formulas[2] = {"iwp", "gen2"};
    const int64_t largest = argc > 1 ? atoll(argv[1]) : 512;
    const int runs = argc > 2 ? atoi(argv[2]) : 5;
    qn_context *context = test_context(1);
    for (int f = 0; f < 2; ++f) {
        stage_costs costs[SIZES];
        int count = 0;
        while (count < SIZES && sizes[count] <= largest &&
               measure(context, formulas[f], sizes[count], runs, costs + count))
            ++count;
        if (count > 1)
            print_table(formulas[f], costs, count);
    }
    qn_context_destroy(context);
    return 0;
}
