// SPDX-License-Identifier: MIT
/* The benchmark's frame: every case runs in a process of its own, so that "first" is a first
 * extraction, one case's memory is not another's, and the floors are measured between the
 * extractions they are compared with. */
#include "bench/bench.h"
#include "bench/measure.h"
#include "lib/support.h"

#include <math.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MAX_RUNS = 101 };

typedef struct settings {
    int runs;
    int threads[2], thread_counts;
    const char *only; /* part of the names of the volumes wanted, or NULL */
    FILE *csv;
} settings;

typedef struct bench_case {
    const bench_engine *engine;
    const bench_volume *volume;
    int threads, runs;
    bool normals;
} bench_case;

typedef struct result {
    bool good;
    bench_outcome outcome;
    bench_time first, median, best;  /* of the extraction; `best` wall and CPU each for itself */
    bench_time read, output;         /* floors, the best of each */
    double classify_wall, emit_wall; /* of the runs after the first, the best of each */
    int64_t first_extra_bytes; /* resident at most during the first extraction, beside what was
                                  before and the output */
} result;

/* ---- one case, in a process of its own ----------------------------------------------------------
 */

static double median_of(double *values, int count) {
    for (int i = 1; i < count; ++i)
        for (int j = i; j > 0 && values[j - 1] > values[j]; --j) {
            const double swap = values[j];
            values[j] = values[j - 1];
            values[j - 1] = swap;
        }
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

static void keep_best(bench_time *best, bench_time time) {
    best->wall = fmin(best->wall, time.wall);
    best->cpu = fmin(best->cpu, time.cpu);
}

static void measure_floors(const bench_case *one, uint8_t *bits, result *out) {
    bench_time start = bench_now();
    bench_read_pass(one->volume, one->threads, bits);
    keep_best(&out->read, bench_since(start));
    start = bench_now();
    bench_output_pass(out->outcome.output_bytes, one->threads);
    keep_best(&out->output, bench_since(start));
}

static bool first_extraction(const bench_case *one, void *state, result *out) {
    bench_reset_peak_resident();
    const int64_t before = bench_resident();
    const bench_time start = bench_now();
    const bool good = one->engine->extract(state, &out->outcome);
    out->first = bench_since(start);
    out->first_extra_bytes = bench_peak_resident() - before - out->outcome.output_bytes;
    one->engine->clear(state);
    return good;
}

static result run_case(const bench_case *one) {
    const bench_time never = {INFINITY, INFINITY};
    double walls[MAX_RUNS] = {0}, cpus[MAX_RUNS] = {0};
    result out = {.best = never,
                  .read = never,
                  .output = never,
                  .classify_wall = INFINITY,
                  .emit_wall = INFINITY};
    void *state = one->engine->prepare(one->volume, one->threads, one->normals);
    if (!state || !first_extraction(one, state, &out))
        return out;
    uint8_t *bits = test_alloc((size_t)bench_sample_count(one->volume) / 8 + 64, 1);
    for (int n = 0; n < one->runs; ++n) {
        measure_floors(one, bits, &out);
        const bench_time start = bench_now();
        if (!one->engine->extract(state, &out.outcome))
            return out;
        const bench_time time = bench_since(start);
        one->engine->clear(state);
        walls[n] = time.wall;
        cpus[n] = time.cpu;
        keep_best(&out.best, time);
        out.classify_wall = fmin(out.classify_wall, out.outcome.classify_wall);
        out.emit_wall = fmin(out.emit_wall, out.outcome.emit_wall);
    }
    free(bits);
    out.median.wall = median_of(walls, one->runs);
    out.median.cpu = median_of(cpus, one->runs);
    out.good = true;
    return out;
}

static void run_in_child(const void *job, void *out) {
    *(result *)out = run_case(job);
}

static result run_apart(const bench_case *one) {
    result out = {.good = false};
    if (!bench_run_apart(run_in_child, one, &out, sizeof out))
        out.good = false;
    return out;
}

/* ---- tables
 * -------------------------------------------------------------------------------------- */

/* One thread is judged by its CPU time, which other work on the machine disturbs least; several by
 * wall. */
static double judged(const bench_case *one, bench_time time) {
    return one->threads == 1 ? time.cpu : time.wall;
}

static void print_state(FILE *file, const char *mark, const bench_engine *engine, int argc,
                        char **argv) {
    fprintf(file,
            "%sengine: %s; machine: %s, %ld cores; compiler: %s; Quoin %s (%s); read pass: %s\n",
            mark, engine->name, bench_processor(), sysconf(_SC_NPROCESSORS_ONLN), bench_compiler(),
            qn_version(), bench_commit(), bench_read_pass_name());
    fprintf(file, "%scommand:", mark);
    for (int n = 0; n < argc; ++n)
        fprintf(file, " %s", argv[n]);
    fprintf(file, "\n");
}

static void print_heads(const settings *set) {
    printf(
        "\n| engine | volume | thr | normals | V | F | first ms | again ms: median (min) | CPU min "
        "ms | Mvoxel/s | "
        "Mvertex/s | read pass ms | x read | x (read + output) | classify / emit ms | beside the "
        "output, B/voxel: "
        "counted, resident |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    if (set->csv)
        fprintf(set->csv, "engine,volume,scalar,nx,ny,nz,isovalue,threads,normals,runs,vertices,"
                          "faces,first_wall,first_cpu,"
                          "again_wall_median,again_wall_min,again_cpu_median,again_cpu_min,read_"
                          "wall_min,read_cpu_min,"
                          "output_wall_min,output_cpu_min,judged_by,times_read,times_read_and_"
                          "output,classify_wall_min,"
                          "emit_wall_min,output_bytes,scratch_bytes,resident_extra_bytes\n");
}

static void print_row(const bench_case *one, const result *out) {
    const double voxels = (double)bench_sample_count(one->volume), time = judged(one, out->best);
    const double read = judged(one, out->read), output = judged(one, out->output);
    printf("| %s | %s | %d | %s | %lld | %lld | %.1f | %.1f (%.1f) | %.1f | %.0f | %.1f | %.2f | "
           "%.1f | %.2f | ",
           one->engine->name, one->volume->name, one->threads, one->normals ? "yes" : "no",
           (long long)out->outcome.vertices, (long long)out->outcome.faces, 1e3 * out->first.wall,
           1e3 * out->median.wall, 1e3 * out->best.wall, 1e3 * out->best.cpu, 1e-6 * voxels / time,
           1e-6 * (double)out->outcome.vertices / time, 1e3 * read, time / read,
           time / (read + output));
    if (out->classify_wall >= 0)
        printf("%.1f / %.1f | %.3f, ", 1e3 * out->classify_wall, 1e3 * out->emit_wall,
               (double)out->outcome.scratch_bytes / voxels);
    else
        printf("- | -, ");
    printf("%.3f |\n", (double)out->first_extra_bytes / voxels);
    fflush(stdout);
}

static void print_csv(FILE *csv, const bench_case *one, const result *out) {
    const bench_volume *v = one->volume;
    const double time = judged(one, out->best), read = judged(one, out->read);
    fprintf(csv, "%s,%s,%s,%lld,%lld,%lld,%g,%d,%d,%d,%lld,%lld,", one->engine->name, v->name,
            qn_scalar_name(v->scalar), (long long)v->size[0], (long long)v->size[1],
            (long long)v->size[2], v->iso, one->threads, one->normals, one->runs,
            (long long)out->outcome.vertices, (long long)out->outcome.faces);
    fprintf(
        csv,
        "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%s,%.2f,%.2f,%.6f,%.6f,%lld,%lld,%lld\n",
        out->first.wall, out->first.cpu, out->median.wall, out->best.wall, out->median.cpu,
        out->best.cpu, out->read.wall, out->read.cpu, out->output.wall, out->output.cpu,
        one->threads == 1 ? "cpu" : "wall", time / read, time / (read + judged(one, out->output)),
        out->classify_wall, out->emit_wall, (long long)out->outcome.output_bytes,
        (long long)out->outcome.scratch_bytes, (long long)out->first_extra_bytes);
    fflush(csv);
}

/* ---- all cases
 * ----------------------------------------------------------------------------------- */

static void run_volume(const settings *set, const bench_engine *engine,
                       const bench_volume *volume) {
    for (int t = 0; t < set->thread_counts; ++t)
        for (int normals = 0; normals < 2; ++normals) {
            if (normals ? !engine->can_make_normals : !engine->can_leave_normals)
                continue;
            const bench_case one = {engine, volume, set->threads[t], set->runs, normals != 0};
            const result out = run_apart(&one);
            if (!out.good) {
                fprintf(stderr, "%s on %s with %d threads failed\n", engine->name, volume->name,
                        one.threads);
                continue;
            }
            print_row(&one, &out);
            if (set->csv)
                print_csv(set->csv, &one, &out);
        }
}

static int usage(const char *program) {
    fprintf(stderr,
            "usage: %s [--runs N] [--threads 1|2|1,2] [--only PART-OF-A-VOLUME'S-NAME] [--csv "
            "FILE]\nvolumes:",
            program);
    for (int n = 0; n < BENCH_VOLUMES; ++n)
        fprintf(stderr, " %s", bench_volume_name(n));
    fprintf(stderr, "\n");
    return 2;
}

static bool parse(settings *set, int argc, char **argv) {
    for (int n = 1; n + 1 < argc; n += 2) {
        const char *value = argv[n + 1];
        if (strcmp(argv[n], "--runs") == 0)
            set->runs = atoi(value);
        else if (strcmp(argv[n], "--threads") == 0)
            set->thread_counts = sscanf(value, "%d,%d", &set->threads[0], &set->threads[1]);
        else if (strcmp(argv[n], "--only") == 0)
            set->only = value;
        else if (strcmp(argv[n], "--csv") == 0)
            set->csv = fopen(value, "w");
        else
            return false;
        if (strcmp(argv[n], "--csv") == 0 && !set->csv)
            return false;
    }
    bool good = argc % 2 == 1 && set->runs > 0 && set->runs <= MAX_RUNS && set->thread_counts > 0;
    for (int t = 0; good && t < set->thread_counts; ++t)
        good = set->threads[t] >= 1 && set->threads[t] <= 64;
    return good;
}

int bench_main(const bench_engine *engine, int argc, char **argv) {
    settings set = {.runs = 7, .threads = {1, 2}, .thread_counts = 2};
    if (!parse(&set, argc, argv))
        return usage(argv[0]);
    print_state(stdout, "", engine, argc, argv);
    if (set.csv)
        print_state(set.csv, "# ", engine, argc, argv);
    print_heads(&set);
    for (int n = 0; n < BENCH_VOLUMES; ++n) {
        bench_volume volume;
        if ((set.only && !strstr(bench_volume_name(n), set.only)) || !bench_volume_make(n, &volume))
            continue;
        if (!volume.swapped || engine->can_read_swapped)
            run_volume(&set, engine, &volume);
        bench_volume_free(&volume);
    }
    return set.csv ? fclose(set.csv) : 0;
}
