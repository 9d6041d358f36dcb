// SPDX-License-Identifier: MIT
/* The tables of [DMC21] section 5 again, beside the printed figures: Tables 3, 4, 6, 7, 8, and the
 * valences of Figure 11 as a table. What is printed in the paper stands in brackets. */
#include "bench/tables.h"
#include "bench/tables_measure.h"
#include "lib/analytic.h"
#include "lib/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DMC, DMCS, DMCS_RELAXED, DMCS_MIDDLE, DC, MC, OWN_METHODS, MOST_METHODS = OWN_METHODS + 4 };
enum { PAPER_SETS = 4, SETS = 7 };

/* One data set; the paper's figures by column DMC, DMCS, DC, TMC, MC. */
typedef struct data_set {
    const char *name, *formula;
    int64_t n;
    int index;                                               /* of bench_volume_make(), for files */
    long dmc_vertices, mc_vertices, dmc_quads, mc_triangles; /* Table 3; 0: not printed */
    long merged, shrunk;                                     /* Table 4; -1: not printed */
    double deviation[5];                                     /* Table 6 */
    double triangle_quality[5], triangle_irregular[5];       /* Table 7 */
    double quad_quality[3], quad_irregular[3];               /* Table 8 */
} data_set;

static const data_set sets[SETS] = {
    {"iWP 512",
     "iwp",
     512,
     0,
     6528938,
     6558756,
     6498576,
     13056698,
     346907,
     384,
     {0.97e-4, 1.06e-4, 3.44e-4, 1.04e-4, 1.04e-4},
     {0.84, 0.82, 0.86, 0.65, 0.65},
     {23.85, 28.57, 24.13, 25.17, 25.13},
     {0.89, 0.90, 0.84},
     {23.51, 4.22, 23.50}},
    {"gen2 64",
     "gen2",
     64,
     0,
     0,
     0,
     0,
     0,
     -1,
     -1,
     {0.69, 0.69, 0.68, 0.69, 0.69},
     {0.87, 0.83, 0.84, 0.71, 0.71},
     {34.88, 48.30, 43.37, 46.15, 46.15},
     {0.85, 0.87, 0.73},
     {43.37, 8.85, 43.37}},
    {"gen2 128",
     "gen2",
     128,
     0,
     0,
     0,
     0,
     0,
     -1,
     -1,
     {0.70, 0.69, 0.70, 0.70, 0.70},
     {0.87, 0.82, 0.84, 0.71, 0.71},
     {31.86, 44.48, 36.71, 45.03, 45.03},
     {0.86, 0.87, 0.73},
     {42.60, 5.95, 42.60}},
    {"gen2 256",
     "gen2",
     256,
     0,
     158902,
     158904,
     158904,
     317812,
     16158,
     0,
     {0.70, 0.69, 0.70, 0.70, 0.70},
     {0.87, 0.82, 0.84, 0.71, 0.71},
     {28.96, 41.01, 34.40, 44.13, 44.13},
     {0.86, 0.87, 0.74},
     {42.28, 5.14, 42.28}},
    {.name = "CT head u16", .index = 10, .merged = -1},
    {.name = "CT cranium i16", .index = 11, .merged = -1},
    {.name = "CT engine u8", .index = 12, .merged = -1},
};

/* What Quoin did, for Table 4. */
typedef struct removal {
    int64_t merged, shrunk;
} removal;

typedef struct results {
    bool known;
    tables_measure of[MOST_METHODS];
    removal until_none, as_paper;
} results;

static tables_method methods[MOST_METHODS];
static int method_count = OWN_METHODS;
static removal last_removal;

/* ---- Quoin ----------------------------------------------------------------------------------- */

static qn_mesh *surface(qn_context *context, const bench_volume *bench, bool simplify, int passes,
                        bool middle, int relax) {
    qn_grid grid;
    qn_volume *volume = NULL;
    qn_mesh *mesh = NULL;
    qn_surface_report report;
    qn_surface_options options;
    memset(&grid, 0, sizeof grid);
    grid.samples = bench->samples;
    grid.scalar = bench->scalar;
    grid.swapped = bench->swapped;
    memcpy(grid.size, bench->size, sizeof grid.size);
    qn_surface_options_init(&options);
    options.isovalues = &bench->iso;
    options.isovalue_count = 1;
    options.open = true;
    options.simplify = simplify;
    options.simplify_passes = passes;
    options.no_reproject = middle;
    options.relax = relax;
    if (qn_volume_create(context, &grid, NULL, NULL, &volume, NULL) != QN_OK ||
        qn_surface(context, volume, &options, &mesh, &report, NULL) != QN_OK)
        return NULL;
    qn_volume_destroy(volume);
    last_removal.merged = report.merged_quads;
    last_removal.shrunk = report.shrunk_quads;
    return mesh;
}

static qn_mesh *plain(qn_context *context, const bench_volume *volume) {
    return surface(context, volume, false, 0, false, 0);
}

static qn_mesh *simplified(qn_context *context, const bench_volume *volume) {
    return surface(context, volume, true, 0, false, 0);
}

static qn_mesh *relaxed(qn_context *context, const bench_volume *volume) {
    return surface(context, volume, true, 0, false, 3);
}

static qn_mesh *simplified_as_paper(qn_context *context, const bench_volume *volume) {
    return surface(context, volume, true, -1, true, 0);
}

/* ---- measuring ------------------------------------------------------------------------------- */

typedef struct formula {
    const test_analytic *analytic;
    double last;
} formula;

/* iWP's formula is one of the cosines. */
static double value_of_formula(const void *user, const double index[3]) {
    const formula *f = user;
    double c[3];
    for (int a = 0; a < 3; ++a) {
        c[a] = f->analytic->first + f->analytic->span * index[a] / f->last;
        if (strcmp(f->analytic->name, "iwp") == 0)
            c[a] = cos(c[a]);
    }
    return f->analytic->value(c[0], c[1], c[2]);
}

static bool make_volume(const data_set *set, bench_volume *volume) {
    if (!set->formula)
        return bench_volume_make(set->index, volume);
    memset(volume, 0, sizeof *volume);
    snprintf(volume->name, sizeof volume->name, "%s", set->name);
    volume->scalar = QN_F32;
    volume->size[0] = volume->size[1] = volume->size[2] = set->n;
    volume->samples = test_analytic_samples(test_analytic_find(set->formula), set->n, QN_F32);
    return true;
}

static results measure_set(qn_context *context, const data_set *set) {
    results r;
    bench_volume volume;
    memset(&r, 0, sizeof r);
    if (!make_volume(set, &volume))
        return r;
    const formula f = {set->formula ? test_analytic_find(set->formula) : NULL,
                       (double)(volume.size[0] - 1)};
    for (int n = 0; n < method_count; ++n) {
        fprintf(stderr, "%s: %s\n", set->name, methods[n].name);
        qn_mesh *mesh = methods[n].surface(context, &volume);
        if (n == DMCS)
            r.until_none = last_removal;
        if (n == DMCS_MIDDLE)
            r.as_paper = last_removal;
        if (mesh)
            r.of[n] = tables_measure_mesh(context, &volume, f.analytic ? value_of_formula : NULL,
                                          &f, mesh);
        qn_mesh_destroy(mesh);
    }
    bench_volume_free(&volume);
    r.known = true;
    return r;
}

/* ---- tables ---------------------------------------------------------------------------------- */

static void print_head(const char *title, const char *first, const int *columns, int count) {
    printf("\n### %s\n\n| %s |", title, first);
    for (int n = 0; n < count; ++n)
        printf(" %s |", methods[columns[n]].name);
    printf("\n|---|");
    for (int n = 0; n < count; ++n)
        printf("---|");
    printf("\n");
}

/* The paper's column of a method, or -1. */
static int printed_column(int method) {
    return method == DMC                                                 ? 0
           : method == DMCS_MIDDLE                                       ? 1
           : method == DC                                                ? 2
           : method == MC || strcmp(methods[method].name, "VTK MC") == 0 ? 4
                                                                         : -1;
}

static void print_count(int64_t value, long printed) {
    printf(" %lld", (long long)value);
    if (printed > 0)
        printf(" (%ld)", printed);
    printf(" |");
}

/* One row of a table of a mean; figures that are not known are left out. */
static void print_row(const data_set *set, const results *r, const int *columns, int count,
                      double (*figure)(const tables_measure *m), const double *printed,
                      int printed_count, const char *format, const char *printed_format) {
    printf("| %s |", set->name);
    for (int n = 0; n < count; ++n) {
        const tables_measure *m = r->of + columns[n];
        const int column = printed_column(columns[n]);
        if (!m->known || isnan(figure(m))) {
            printf(" - |");
            continue;
        }
        printf(" ");
        printf(format, figure(m));
        if (column >= 0 && column < printed_count && set->dmc_quads + (set->formula != NULL)) {
            printf(" (");
            printf(printed_format, printed[column]);
            printf(")");
        }
        printf(" |");
    }
    printf("\n");
}

static double formula_deviation(const tables_measure *m) {
    return m->deviation_formula;
}
static double relative_deviation(const tables_measure *m) {
    return m->deviation / m->range;
}
static double quad_quality(const tables_measure *m) {
    return m->quads ? m->quad_quality : (double)NAN;
}
static double quad_irregular(const tables_measure *m) {
    return m->quads ? m->irregular_quads : (double)NAN;
}
static double quad_irregular_inner(const tables_measure *m) {
    return m->quads ? m->irregular_inner : (double)NAN;
}
static double triangle_quality(const tables_measure *m) {
    return m->triangle_quality;
}
static double triangle_irregular(const tables_measure *m) {
    return m->irregular_triangles;
}
static double nonmanifold(const tables_measure *m) {
    return m->nonmanifold;
}

static void print_table_3(const results *all) {
    printf("\n### Table 3: number of elements\n\n"
           "| | vertices DMC | vertices MC | quads DMC | triangles MC | vertices DC |\n"
           "|---|---|---|---|---|---|\n");
    for (int s = 0; s < SETS; ++s) {
        const tables_measure *m = all[s].of;
        if (!all[s].known)
            continue;
        printf("| %s |", sets[s].name);
        print_count(m[DMC].vertices, sets[s].dmc_vertices);
        print_count(m[MC].vertices, sets[s].mc_vertices);
        print_count(m[DMC].quads, sets[s].dmc_quads);
        print_count(m[MC].triangles, sets[s].mc_triangles);
        print_count(m[DC].vertices, 0);
        printf("\n");
    }
}

static void print_removal(const removal *done) {
    printf(" %lld | %lld | %lld |", (long long)done->merged, (long long)done->shrunk,
           (long long)(done->merged + done->shrunk));
}

static void print_table_4(const results *all) {
    printf(
        "\n### Table 4: quads removed\n\n"
        "| | 3-X-3-Y | 3-3-3-3 | total | by the paper's single pass: 3-X-3-Y | 3-3-3-3 | total | "
        "printed: 3-X-3-Y | 3-3-3-3 |\n|---|---|---|---|---|---|---|---|---|\n");
    for (int s = 0; s < SETS; ++s) {
        if (!all[s].known)
            continue;
        printf("| %s |", sets[s].name);
        print_removal(&all[s].until_none);
        print_removal(&all[s].as_paper);
        if (sets[s].merged >= 0)
            printf(" %ld | %ld |\n", sets[s].merged, sets[s].shrunk);
        else
            printf(" - | - |\n");
    }
}

static void print_valences(const results *all) {
    printf(
        "\n### Valences (Figure 11): percent of the vertices\n\n| | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9 "
        "and more |\n|---|---|---|---|---|---|---|---|---|\n");
    static const int columns[] = {DMC, DMCS};
    for (int s = 0; s < SETS; ++s)
        for (int n = 0; n < 2 && all[s].known; ++n) {
            printf("| %s, %s |", sets[s].name, methods[columns[n]].name);
            for (int v = 2; v < TABLES_VALENCES; ++v)
                printf(" %.2f |", all[s].of[columns[n]].valences[v]);
            printf("\n");
        }
}

static void print_tables(const results *all) {
    static const int quads[] = {DMC, DMCS_MIDDLE, DMCS, DMCS_RELAXED, DC};
    int every[MOST_METHODS];
    for (int n = 0; n < method_count; ++n)
        every[n] = n < 4 ? quads[n] : n;
#define ROWS(columns, count, figure, printed, printed_count, format, printed_format)               \
    for (int s = 0; s < SETS; ++s)                                                                 \
        if (all[s].known)                                                                          \
    print_row(&sets[s], &all[s], columns, count, figure, sets[s].printed, printed_count, format,   \
              printed_format)
    print_table_3(all);
    print_table_4(all);
    print_head("Table 6: mean deviation from the iso-value, of the formula", "", every,
               method_count);
    for (int s = 0; s < PAPER_SETS; ++s)
        if (all[s].known)
            print_row(&sets[s], &all[s], every, method_count, formula_deviation, sets[s].deviation,
                      5, "%.3g", "%.3g");
    print_head("Mean deviation from the iso-value, of the trilinear interpolant, as part of the "
               "samples' range",
               "", every, method_count);
    ROWS(every, method_count, relative_deviation, deviation, 0, "%.1e", "%.1e");
    print_head("Table 7: mean quality of the triangles (8)", "", every, method_count);
    ROWS(every, method_count, triangle_quality, triangle_quality, 5, "%.3f", "%.2f");
    print_head("Table 7: irregular vertices of the triangles, percent", "", every, method_count);
    ROWS(every, method_count, triangle_irregular, triangle_irregular, 5, "%.2f", "%.2f");
    print_head("Table 8: mean quality of the quads (9)", "", quads, 5);
    ROWS(quads, 5, quad_quality, quad_quality, 3, "%.3f", "%.2f");
    print_head("Table 8: irregular vertices of the quads, percent", "", quads, 5);
    ROWS(quads, 5, quad_irregular, quad_irregular, 3, "%.2f", "%.2f");
    print_head("The same without the vertices on the boundary", "", quads, 5);
    ROWS(quads, 5, quad_irregular_inner, quad_irregular, 0, "%.2f", "%.2f");
    print_head("Table 8: non-manifold vertices, percent", "", quads, 5);
    ROWS(quads, 5, nonmanifold, quad_quality, 0, "%.3f", "%.2f");
    print_valences(all);
#undef ROWS
}

int tables_main(const tables_method *rivals, int rival_count, int argc, char **argv) {
    static const tables_method own[OWN_METHODS] = {
        [DMC] = {"DMC", plain},
        [DMCS] = {"DMCS", simplified},
        [DMCS_RELAXED] = {"DMCS, relaxed", relaxed},
        [DMCS_MIDDLE] = {"DMCS as in the paper", simplified_as_paper},
        [DC] = {"DC", tables_dual_contouring},
        [MC] = {"MC", tables_marching_cubes},
    };
    static results all[SETS];
    memcpy(methods, own, sizeof own);
    for (int n = 0; n < rival_count && method_count < MOST_METHODS; ++n)
        methods[method_count++] = rivals[n];
    qn_context *context = test_context(0);
    for (int s = 0; s < SETS; ++s)
        if (argc < 2 || strstr(sets[s].name, argv[1]))
            all[s] = measure_set(context, &sets[s]);
    print_tables(all);
    qn_context_destroy(context);
    return 0;
}
