// SPDX-License-Identifier: MIT
/* Distances of meshes to the solid, against their triangles: `libfive` on the model of libfive's
 * figures, `levels` as in [CMS05] table 3, `tolerance` on the solids of the data folder;
 * `adaptivity`: what grows with depth. */
#include "bench/cms/scenes.h"
#include "bench/measure.h"
#include "lib/mesh_distance.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { SAMPLES = 10000 };

/* Largest and mean of both directions: the larger of the two. */
static test_deviation both_ways(const qn_mesh *mesh, const qn_mesh *truth,
                                const test_distance_tree *truth_tree) {
    test_distance_tree *tree = test_distance_tree_create(mesh);
    const test_deviation to = test_mesh_deviation(mesh, SAMPLES, truth_tree),
                         from = test_mesh_deviation(truth, SAMPLES, tree);
    test_deviation out = to.largest > from.largest ? to : from;
    out.mean = fmax(to.mean, from.mean);
    test_distance_tree_destroy(tree);
    return out;
}

static qn_mesh_report check(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    return report;
}

/* ---- beside libfive
 * ------------------------------------------------------------------------------ */

typedef struct libfive_row {
    double cell, largest, seconds;
    int64_t triangles[2], crossings[2], degenerate[2]; /* as it is, turned */
} libfive_row;

/* libfive's dual contouring, built from source in 2026, on one thread with max_err 1e-8: measured
 * once on a machine of this kind, its largest distance against its own finest mesh of the model as
 * it is. */
static const libfive_row libfive_rows[] = {
    {0.2, 0.0106, 0.021, {1348, 3752}, {604, 8}, {112, 0}},
    {0.1, 0.0024, 0.078, {4234, 14752}, {1040, 16}, {112, 0}},
    {0.05, 0.0007, 0.241, {14572, 57858}, {2110, 61}, {122, 0}},
    {0.025, 0.0002, 0.701, {54438, 228966}, {4307, 77}, {128, 0}},
};
enum { LIBFIVE_ROWS = sizeof libfive_rows / sizeof *libfive_rows };

typedef struct own_row {
    int depth;
    double tolerance; /* cells */
    int64_t triangles;
    double seconds, largest;
} own_row;

static own_row run_own(qn_context *context, const qn_solid *solid, int depth, double tolerance,
                       const qn_mesh *truth, const test_distance_tree *tree) {
    own_row row = {depth, tolerance, 0, INFINITY, 0};
    for (int run = 0; run < (depth < 8 ? 5 : 1); ++run) {
        const bench_time start = bench_now();
        scene_surface surface = scene_make_surface(context, solid, depth, tolerance, false);
        row.seconds = fmin(row.seconds, bench_since(start).cpu);
        if (run == 0) {
            const qn_mesh_report report = check(context, surface.mesh);
            const test_deviation off = both_ways(surface.mesh, truth, tree);
            row.triangles = surface.report.triangles;
            row.largest = off.largest;
            printf("| %d | %.3g | %s | %.6f | %.7f | %lld | %lld | %lld | ", depth, tolerance,
                   scene_count(row.triangles), off.largest, off.mean,
                   (long long)(report.boundary_edges + report.nonmanifold_edges),
                   (long long)report.self_intersections, (long long)report.degenerate_faces);
        }
        qn_mesh_destroy(surface.mesh);
    }
    printf("%.3f |\n", row.seconds);
    return row;
}

static void compare(const own_row *rows, int count, int turned) {
    printf(
        "\n| libfive: cell | largest distance | triangles | s | self-intersections | degenerate | "
        "Quoin at that distance or less: triangles | s | depth, tolerance |\n"
        "|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 0; n < LIBFIVE_ROWS; ++n) {
        const libfive_row *theirs = &libfive_rows[n];
        const own_row *best = NULL;
        for (int m = 0; m < count; ++m)
            if (rows[m].largest <= theirs->largest &&
                (!best || rows[m].triangles < best->triangles))
                best = &rows[m];
        printf("| %g | %g | %s | %.3f | %lld | %lld | ", theirs->cell, theirs->largest,
               scene_count(theirs->triangles[turned]), theirs->seconds,
               (long long)theirs->crossings[turned], (long long)theirs->degenerate[turned]);
        if (best)
            printf("%s | %.3f | %d, %.3g |\n", scene_count(best->triangles), best->seconds,
                   best->depth, best->tolerance);
        else
            printf("none of those above | | |\n");
    }
}

/* Tolerances just below each of libfive's distances, where they are neither far below a cell nor
 * far above it. */
static int run_depth(qn_context *context, const qn_solid *solid, int depth, const qn_mesh *truth,
                     const test_distance_tree *tree, own_row *rows) {
    double low[3], high[3];
    int count = 0;
    qn_solid_get_box(solid, low, high);
    const double extent = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    for (int n = 0; n < LIBFIVE_ROWS; ++n)
        for (int part = 0; part < 3; ++part) {
            static const double parts[3] = {0.98, 0.8, 0.65};
            const double cells = parts[part] * libfive_rows[n].largest / extent * (1 << depth);
            if (cells > 0.015 && cells < (depth < 9 ? 1 : 0.2))
                rows[count++] = run_own(context, solid, depth, cells, truth, tree);
        }
    return count;
}

static void run_libfive(void) {
    enum { LOW = 5, HIGH = 9 };
    for (int turned = 0; turned < 2; ++turned) {
        qn_context *context = test_context(1);
        qn_solid *solid = scene_libfive(context, turned);
        scene_surface truth = scene_make_surface(context, solid, 9, 0, true);
        test_distance_tree *tree = test_distance_tree_create(truth.mesh);
        own_row rows[3 * (HIGH - LOW + 1) * LIBFIVE_ROWS];
        int count = 0;
        printf("%s### libfive's model, %s\n\n| depth | tolerance, cells | triangles | largest "
               "distance | mean | cracks, non-manifold | self-intersections | degenerate | s, one "
               "thread |\n|---|---|---|---|---|---|---|---|---|\n",
               turned ? "\n" : "", turned ? "turned" : "as it is");
        for (int depth = LOW; depth <= HIGH; ++depth)
            count += run_depth(context, solid, depth, truth.mesh, tree, rows + count);
        compare(rows, count, turned);
        test_distance_tree_destroy(tree);
        qn_mesh_destroy(truth.mesh);
        qn_solid_destroy(solid);
        test_context_end(context);
    }
}

/* ---- adaptivity
 * -------------------------------------------------------------------------------- */

static void run_adaptivity(void) {
    qn_context *context = test_context(1);
    qn_solid *cube = scene_turned_cube(context);
    printf("| base | depth | triangles | leaves | of these along an edge | at a corner | cms ms |\n"
           "|---|---|---|---|---|---|---|\n");
    for (int base = 8; base >= 2; base -= 6)
        for (int depth = 6; depth <= 10; ++depth) {
            qn_solid_surface_options options;
            qn_solid_surface_report report;
            qn_mesh *mesh;
            qn_solid_surface_options_init(&options);
            options.depth = depth;
            options.base = base;
            assert_int_equal(qn_solid_surface(context, cube, &options, &mesh, &report, NULL),
                             QN_OK);
            printf("| %d | %d | %s | %s | %s | %s | %.1f |\n", base, depth,
                   scene_count(report.triangles), scene_count(report.leaves),
                   scene_count(report.crease_loops), scene_count(report.corner_loops),
                   1e3 * report.seconds_cms);
            qn_mesh_destroy(mesh);
        }
    qn_solid_destroy(cube);
    test_context_end(context);
}

/* ---- levels of detail
 * ---------------------------------------------------------------------------- */

static void run_levels(void) {
    static const int64_t printed[3] = {1688, 4880, 14568};
    static const double printed_ms[3] = {16.23, 32.14, 66.08};
    qn_context *context = test_context(1);
    qn_solid *solid = scene_figure_8(context);
    printf("| level | depth | triangles | cracks, non-manifold | self-intersections | cms ms | "
           "with sampling and octree ms | [CMS05]: triangles | ms |\n"
           "|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 0; n < 3; ++n) {
        double cms = INFINITY, total = INFINITY;
        qn_mesh_report report;
        int64_t triangles = 0;
        for (int run = 0; run < 5; ++run) {
            scene_surface surface = scene_make_surface(context, solid, 5 + n, 0, false);
            cms = fmin(cms, surface.report.seconds_cms);
            total = fmin(total, surface.report.seconds_total);
            triangles = surface.report.triangles;
            report = check(context, surface.mesh);
            qn_mesh_destroy(surface.mesh);
        }
        printf("| %d | %d | %s | %lld | %lld | %.1f | %.1f | %s | %.1f |\n", n + 1, 5 + n,
               scene_count(triangles),
               (long long)(report.boundary_edges + report.nonmanifold_edges +
                           report.nonmanifold_vertices),
               (long long)report.self_intersections, 1e3 * cms, 1e3 * total,
               scene_count(printed[n]), printed_ms[n]);
    }
    qn_solid_destroy(solid);
    test_context_end(context);
}

/* ---- tolerances
 * ---------------------------------------------------------------------------------- */

static const char *const models[] = {"CSG",
                                     "candleStand",
                                     "cube-tests",
                                     "cylinder-tests",
                                     "difference-tests",
                                     "example001",
                                     "example003",
                                     "example005",
                                     "example014",
                                     "example017",
                                     "example018",
                                     "example021",
                                     "horn-torus",
                                     "hull3-tests",
                                     "intersection-tests",
                                     "issue1105",
                                     "issue1105b",
                                     "issue1215",
                                     "issue13",
                                     "issue945",
                                     "rotate_extrude-angle",
                                     "sphere-tests",
                                     "transform-tests",
                                     "union-tests",
                                     "colonnade.vm",
                                     "hi.vm",
                                     "quarter.vm",
                                     "tanglecube.vm"};
enum { MODELS = sizeof models / sizeof *models, DEPTH = 7 };

/* OpenSCAD's mesh; of a .vm file Quoin's own, at twice the depth's cells. */
static qn_mesh *truth_of(qn_context *context, const char *model, const qn_solid *solid) {
    static const char *const endings[] = {"stl", "stl.gz"};
    qn_mesh *mesh = NULL;
    if (strstr(model, ".vm"))
        return scene_make_surface(context, solid, DEPTH + 1, 0.01, false).mesh;
    char name[256], path[4096];
    snprintf(name, sizeof name, "csg/%s.csg", model);
    if (!test_data_path(name, path, sizeof path - 16))
        return NULL;
    char *const ending = path + strlen(path) - strlen("csg");
    for (int n = 0; n < 2 && !mesh; ++n) {
        sprintf(ending, "expected.%s", endings[n]);
        if (access(path, R_OK) == 0)
            assert_int_equal(qn_mesh_read(context, path, NULL, &mesh, NULL), QN_OK);
    }
    return mesh;
}

static void run_model(const char *model, FILE *csv) {
    static const double tolerances[] = {0.01, 0.05, 0.25, 1};
    char name[128];
    snprintf(name, sizeof name, "%s%s", model, strstr(model, ".vm") ? "" : ".csg");
    qn_context *context = test_context(0);
    qn_solid *solid = scene_file(context, name);
    qn_mesh *truth = solid ? truth_of(context, model, solid) : NULL;
    if (truth) {
        test_distance_tree *tree = test_distance_tree_create(truth);
        printf("| %s |", name);
        for (int n = 0; n < 4; ++n) {
            scene_surface surface = scene_make_surface(context, solid, DEPTH, tolerances[n], false);
            const test_deviation off = both_ways(surface.mesh, truth, tree);
            const double cell = surface.report.finest_cell;
            printf(" %s: %.2f, %.4f |", scene_count(surface.report.triangles), off.largest / cell,
                   off.mean / cell);
            if (csv)
                fprintf(csv, "%s,%g,%lld,%.6g,%.6g,%.6g\n", name, tolerances[n],
                        (long long)surface.report.triangles, cell, off.largest, off.mean);
            qn_mesh_destroy(surface.mesh);
        }
        printf("\n");
        fflush(stdout);
        test_distance_tree_destroy(tree);
    }
    qn_mesh_destroy(truth);
    qn_solid_destroy(solid);
    test_context_end(context);
}

static int run_tolerance(const char *path) {
    FILE *csv = path ? fopen(path, "w") : NULL;
    if (path && !csv) {
        fprintf(stderr, "%s: cannot be written\n", path);
        return 2;
    }
    if (csv)
        fprintf(csv, "model,tolerance_cells,triangles,cell,largest,mean\n");
    printf("| triangles: largest, mean distance in cells, at --tol | 0.01 cells | 0.05 (default) | "
           "0.25 | 1 |\n|---|---|---|---|---|\n");
    for (int n = 0; n < MODELS; ++n)
        run_model(models[n], csv);
    return csv && fclose(csv) != 0;
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "libfive") == 0)
        run_libfive();
    else if (argc == 2 && strcmp(argv[1], "levels") == 0)
        run_levels();
    else if (argc == 2 && strcmp(argv[1], "adaptivity") == 0)
        run_adaptivity();
    else if ((argc == 2 || argc == 3) && strcmp(argv[1], "tolerance") == 0)
        return run_tolerance(argc == 3 ? argv[2] : NULL);
    else {
        fprintf(stderr, "usage: %s libfive | levels | adaptivity | tolerance [CSV-FILE]\n",
                argv[0]);
        return 2;
    }
    return 0;
}
