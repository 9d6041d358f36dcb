// SPDX-License-Identifier: MIT
/* Time of each stage, triangles a second, what is asked of the solid, and memory a surface cell, by
 * threads; every case in a process of its own, the least CPU time (one thread) or wall time
 * (several) of some runs. */
#include "bench/cms/counting.h"
#include "bench/cms/scenes.h"
#include "bench/measure.h"

#include <math.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct speed_case {
    const char *name; /* a file's, or NULL: 200 primitives */
    int depth, threads, runs;
} speed_case;

typedef struct speed_result {
    bool good;
    qn_solid_surface_report report; /* of the run that took least */
    bench_time time;
    double writing;
    int64_t mesh_bytes, peak_bytes, resident_bytes; /* the peaks beside the mesh */
} speed_result;

static qn_solid *make_scene(qn_context *context, const char *name) {
    return name ? scene_file(context, name) : scene_primitives(context, 200);
}

static speed_result run_case(const speed_case *one) {
    speed_result out = {.time = {INFINITY, INFINITY}};
    qn_context *context = test_context(one->threads);
    qn_solid *solid = make_scene(context, one->name);
    if (!solid)
        return out;
    for (int n = 0; n < one->runs; ++n) {
        const int64_t held = qn_context_memory(context).current_bytes, before = bench_resident();
        qn_context_reset_peak(context);
        bench_reset_peak_resident();
        const bench_time start = bench_now();
        scene_surface surface = scene_make_surface(context, solid, one->depth, 0, false);
        const bench_time time = bench_since(start);
        if (n == 0) { /* later runs find memory that was given back */
            out.mesh_bytes = surface.report.output_bytes;
            out.peak_bytes = qn_context_memory(context).peak_bytes - held - out.mesh_bytes;
            out.resident_bytes = bench_peak_resident() - before - out.mesh_bytes;
        }
        if (one->threads == 1 ? time.cpu < out.time.cpu : time.wall < out.time.wall) {
            out.report = surface.report;
            out.time = time;
        }
        char path[] = "bench-cms-XXXXXX.ply";
        const int file = mkstemps(path, 4);
        const bench_time write_start = bench_now();
        if (file >= 0 && qn_mesh_write(context, surface.mesh, path, NULL, NULL) == QN_OK)
            out.writing = bench_since(write_start).wall;
        if (file >= 0) {
            close(file);
            unlink(path);
        }
        qn_mesh_destroy(surface.mesh);
        out.good = true;
    }
    qn_solid_destroy(solid);
    test_context_end(context);
    return out;
}

static void run_in_child(const void *job, void *out) {
    *(speed_result *)out = run_case(job);
}

static speed_result run_apart(const speed_case *one) {
    speed_result out = {.good = false};
    if (!bench_run_apart(run_in_child, one, &out, sizeof out))
        out.good = false;
    return out;
}

/* Finest cells with surface, and what the solid is asked for. */
static int64_t count_work(const char *name, int depth, counting_tally *tally) {
    qn_context *context = test_context(1);
    qn_solid *solid = make_scene(context, name);
    if (!solid)
        return 0;
    memset(tally, 0, sizeof *tally);
    qn_solid *counted = counting_create(solid, tally);
    scene_surface surface = scene_make_surface(context, counted, depth, 0, false);
    qn_mesh_destroy(surface.mesh);
    qn_solid_destroy(counted);
    surface = scene_make_surface(context, solid, depth, 0, true);
    qn_mesh_destroy(surface.mesh);
    qn_solid_destroy(solid);
    test_context_end(context);
    return surface.report.leaves;
}

static void print_case(const speed_case *one, const speed_result *out, int64_t cells) {
    const qn_solid_surface_report *r = &out->report;
    printf("| %s | %d | %d | %s | %.2f | %.3f | %.3f | %.3f | %.3f | %.2f | %.0f | %.0f |\n",
           one->name ? one->name : "200 primitives", one->depth, one->threads,
           scene_count(r->triangles), one->threads == 1 ? out->time.cpu : out->time.wall,
           r->seconds_sampling, r->seconds_octree, r->seconds_cms, out->writing,
           1e-6 * (double)r->triangles / r->seconds_cms, (double)out->peak_bytes / (double)cells,
           (double)out->resident_bytes / (double)cells);
    fflush(stdout);
}

typedef struct speed_settings {
    int runs, low_depth, high_depth, low_threads, high_threads;
    const char *only; /* part of the names of the solids wanted, or NULL */
} speed_settings;

static bool parse(speed_settings *set, int argc, char **argv) {
    for (int n = 1; n + 1 < argc; n += 2) {
        const char *value = argv[n + 1];
        if (strcmp(argv[n], "--runs") == 0)
            set->runs = atoi(value);
        else if (strcmp(argv[n], "--only") == 0)
            set->only = value;
        else if (strcmp(argv[n], "--depth") == 0)
            set->low_depth = set->high_depth = atoi(value);
        else if (strcmp(argv[n], "--threads") == 0)
            set->low_threads = set->high_threads = atoi(value);
        else
            return false;
    }
    return argc % 2 == 1 && set->runs > 0 && set->low_depth >= QN_MIN_DEPTH &&
           set->high_depth <= QN_MAX_DEPTH && set->low_threads > 0;
}

static const char *const names[] = {"colonnade.vm", "CSG.csg", NULL};
enum { SCENES = 3 };

static const char *title(int scene) {
    return names[scene] ? names[scene] : "200 primitives";
}

static void run_all(const speed_settings *set) {
    printf("| solid | depth | threads | triangles | s | sampling | octree | cms | writing | "
           "million triangles/s in cms | bytes a finest surface cell: counted | resident |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    char asked[4096] = "";
    for (int n = 0; n < SCENES; ++n)
        for (int depth = set->low_depth; depth <= set->high_depth; ++depth) {
            counting_tally tally;
            if (set->only && !strstr(title(n), set->only))
                continue;
            const int64_t cells = count_work(names[n], depth, &tally);
            for (int t = set->low_threads; cells && t <= set->high_threads; ++t) {
                const speed_case one = {names[n], depth, t, set->runs};
                const speed_result out = run_apart(&one);
                if (out.good)
                    print_case(&one, &out, cells);
            }
            const double each = (double)cells;
            const size_t used = strlen(asked);
            if (cells)
                snprintf(asked + used, sizeof asked - used,
                         "| %s | %d | %s | %.1f | %.2f | %.2f | %.2f | %.3f |\n", title(n), depth,
                         scene_count(cells), (double)tally.values / each,
                         (double)tally.gradients / each, (double)tally.bounds / each,
                         (double)tally.segments / each, (double)tally.restrictions / each);
        }
    printf(
        "\nAsked of the solid, for each finest surface cell:\n\n| solid | depth | finest surface "
        "cells | values | gradients | bounds | segments | restrictions |\n"
        "|---|---|---|---|---|---|---|---|\n%s",
        asked);
}

int main(int argc, char **argv) {
    speed_settings set = {3, 8, 9, 1, 2, NULL};
    if (!parse(&set, argc, argv)) {
        fprintf(stderr, "usage: %s [--runs N] [--only PART-OF-A-NAME] [--depth D] [--threads T]\n",
                argv[0]);
        return 2;
    }
    printf("machine: %s, %ld cores; compiler: %s; Quoin %s (%s); least of %d runs\n\n",
           bench_processor(), sysconf(_SC_NPROCESSORS_ONLN), bench_compiler(), qn_version(),
           bench_commit(), set.runs);
    run_all(&set);
    return 0;
}
