// SPDX-License-Identifier: MIT
/* What gpu/check runs: random volumes on both ways, byte against byte, and the benchmark. It needs
 * no test library, so that it builds where there is little beside nvcc.
 *
 * usage: check_gpu parity COUNT SEED | bench REPEATS [SHRINK]      (SHRINK divides the sizes) */
#include "dmc/dmc.h"
#include "gpu/cuda.h"
#include "gpu/driver.h"
#include "gpu/host.h"
#include "gpu/simplify.h"
#include "mesh/mesh.h"
#include "parity/check_volumes.h"
#ifdef QNI_CHECK_ON_PROCESSOR
#include "parity/cpu_device.h"
#endif

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NO_GPU = 77 };

static qn_context *context;

static void stop(const char *what, const qn_error *error) {
    fprintf(stderr, "check_gpu: %s: %s\n", what, error->message);
    exit(1);
}

static void must(qn_status status, const char *what, const qn_error *error) {
    if (status != QN_OK)
        stop(what, error);
}

static qni_device *open_device(void) {
    qni_device *device;
    qn_error error;
#ifdef QNI_CHECK_ON_PROCESSOR
    static test_cpu_device cpu;
    (void)error;
    test_cpu_device_init(&cpu, 1);
    device = &cpu.device;
    printf("device: the processor, running the kernel bodies (no GPU is measured)\n");
#else
    char name[128];
    const qn_status status = qni_cuda_open(NULL, &device, &error);
    if (status == QN_ERROR_UNSUPPORTED) {
        printf("skipped: %s\n", error.message);
        exit(NO_GPU);
    }
    must(status, "opening the GPU", &error);
    must(qni_cuda_describe(device, name, &error), "naming the GPU", &error);
    printf("device: %s\n", name);
#endif
    return device;
}

/* ---- parity ---------------------------------------------------------------------------------- */

static int differs(const char *what, const void *a, const void *b, int64_t bytes) {
    if (bytes == 0 || (a && b && memcmp(a, b, (size_t)bytes) == 0) || (!a && !b))
        return 0;
    printf("DIFFERENT %s\n", what);
    return 1;
}

static int meshes_differ(const qn_mesh *a, const qn_mesh *b) {
    if (a->vertex_count != b->vertex_count || a->quad_count != b->quad_count) {
        printf("DIFFERENT counts: %lld and %lld vertices, %lld and %lld quads\n",
               (long long)a->vertex_count, (long long)b->vertex_count, (long long)a->quad_count,
               (long long)b->quad_count);
        return 1;
    }
    return differs("positions", a->positions, b->positions, 12 * a->vertex_count) |
           differs("normals", a->normals, b->normals, 12 * a->vertex_count) |
           differs("quads", a->quads, b->quads, 16 * a->quad_count) |
           differs("twins", a->twins, b->twins, 16 * a->quad_count) |
           differs("halfedges of vertices", a->vertex_halfedges, b->vertex_halfedges,
                   4 * a->vertex_count);
}

/* What all volumes together had: a check of nothing would pass. */
typedef struct sums {
    int64_t vertices, doubled, borders, sparse, removed, wrong;
} sums;

static qn_surface_options random_options(int64_t n) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.inside = check_below(2) ? QN_INSIDE_ABOVE : QN_INSIDE_BELOW;
    options.open = check_below(3) == 0;
    options.keep_doubled = options.open || check_below(3) == 0;
    options.halfedges = check_below(3) > 0;
    options.skip_normals = check_below(8) == 0;
    options.relax = n % 10 == 9;
    options.simplify = n % 4 == 1;
    return options;
}

/* Every third volume goes through in slabs of one to three layers of leaves. */
static int32_t slab_layers(int64_t n) {
    return n % 3 == 2 ? 1 + (int32_t)(n / 3 % 3) : 0;
}

/* On both ways; every fifth one sparse. */
static bool compare(qni_device *device, const check_volume *v, int64_t n, sums *sum) {
    const qn_surface_options options = random_options(n);
    const bool is_sparse = n % 5 == 4;
    check_sparse sparse = {.origins = NULL};
    qn_surface_report report[2];
    qn_volume *in;
    qn_mesh *mesh[2];
    qn_error error;
    if (is_sparse) {
        sparse = check_make_sparse(v);
        sparse.grid.origins = (const int32_t(*)[3])sparse.origins;
        sparse.grid.tiles = &sparse.tile;
        sparse.grid.tile_count = 1;
        must(qn_volume_create_sparse(context, &sparse.grid, NULL, NULL, &in, &error), "volume",
             &error);
    } else {
        must(qn_volume_create(context, &v->grid, NULL, NULL, &in, &error), "volume", &error);
    }
    must(qni_dmc_surface(context, in, v->iso, &options, mesh, report, &error), "CPU", &error);
    must(qni_gpu_host_surface(context, device, in, v->iso, &options, slab_layers(n), mesh + 1,
                              report + 1, &error),
         "GPU", &error);
    const bool good = !meshes_differ(mesh[0], mesh[1]) &&
                      report[0].fallback_points == report[1].fallback_points &&
                      report[0].ambiguous_faces == report[1].ambiguous_faces &&
                      report[0].merged_quads == report[1].merged_quads &&
                      report[0].unprojected_points == report[1].unprojected_points;
    sum->vertices += mesh[0]->vertex_count;
    sum->doubled += report[0].doubled_edges;
    sum->borders += report[1].device_slabs - 1;
    sum->sparse += is_sparse;
    sum->removed += report[1].merged_quads + report[1].shrunk_quads;
    qn_mesh_destroy(mesh[0]);
    qn_mesh_destroy(mesh[1]);
    qn_volume_destroy(in);
    free(sparse.origins);
    free(sparse.values);
    return good;
}

static int parity(qni_device *device, int64_t count, uint64_t seed) {
    sums sum = {0};
    for (int64_t n = 0; n < count; ++n) {
        check_seed(seed + (uint64_t)n);
        const check_volume v = check_random_volume();
        const int64_t *size = v.grid.size;
        if (!compare(device, &v, n, &sum)) {
            ++sum.wrong;
            printf("  volume %lld of seed %llu: %s %s %lld x %lld x %lld\n", (long long)n,
                   (unsigned long long)seed, v.kind, qn_scalar_name(v.grid.scalar),
                   (long long)size[0], (long long)size[1], (long long)size[2]);
        }
        free(v.samples);
    }
    printf("parity: %lld random volumes, %lld sparse, %lld vertices, %lld doubled edges, %lld "
           "borders of slabs, %lld quads simplified: %lld differ\n",
           (long long)count, (long long)sum.sparse, (long long)sum.vertices, (long long)sum.doubled,
           (long long)sum.borders, (long long)sum.removed, (long long)sum.wrong);
    const bool met = sum.vertices && sum.doubled && sum.borders && sum.sparse && sum.removed;
    return sum.wrong > 0 || (count > 20 && !met);
}

/* ---- measuring ------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count) {
    qsort(values, (size_t)count, sizeof *values, ascending);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

/* Bytes a millisecond, read and written together, of a copy larger than any cache. */
static double copy_speed(qni_device *device, int64_t bytes, int repeats) {
    void *memory[2];
    double *ms = malloc((size_t)repeats * sizeof *ms);
    qn_error error;
    for (int n = 0; n < 2; ++n)
        must(device->alloc(device, bytes, memory + n, &error), "memory for copies", &error);
    must(device->fill(device, memory[0], 1, bytes, &error), "filling", &error);
    for (int n = -2; n < repeats; ++n) {
        must(device->mark(device, 0, &error), "mark", &error);
        must(device->copy(device, memory[1], memory[0], bytes, &error), "copy", &error);
        must(device->mark(device, 1, &error), "mark", &error);
        must(device->elapsed(device, ms + (n < 0 ? 0 : n), &error), "time", &error);
    }
    for (int n = 0; n < 2; ++n)
        device->free(device, memory[n]);
    const double speed = 2 * (double)bytes / median(ms, repeats);
    free(ms);
    return speed;
}

typedef struct stage {
    const char *name;
    bool halfedges, repair, simplify;
} stage;

static void run_once(qni_gpu_job *job, qni_gpu_pool *pool, const qni_field *field,
                     const void *samples, const stage *of) {
    const int64_t *size = field->grid->size;
    qn_error error;
    qni_gpu_job_init(job, pool, field, samples, size[0], size[0] * size[1]);
    job->with_normals = true;
    job->with_halfedges = of->halfedges;
    job->with_repair = of->repair;
    job->with_valences = of->simplify;
    must(qni_gpu_count_surface(job, &error), "pass 1", &error);
    must(qni_gpu_emit_surface(job, &error), "pass 2", &error);
    must(qni_gpu_finish_surface(job, &error), "the end", &error);
    qn_surface_options options;
    qn_surface_report report;
    qn_surface_options_init(&options);
    if (of->simplify)
        must(qni_gpu_simplify(job, &options, &report, &error), "simplification", &error);
}

/* Samples read once, mesh written once; halfedges read the quads once more; simplification reads
 * mesh and halfedges once and writes what is left once. */
static double floor_bytes(const qni_gpu_job *job, int64_t sample_bytes, const stage *of) {
    const double left_v = (double)job->vertex_count, left_q = (double)job->quad_count;
    const double removed = of->simplify ? (double)(job->totals.merged + job->totals.shrunk) : 0;
    const double v = left_v + removed, q = left_q + removed;
    const double mesh = (double)sample_bytes + 24 * v + 16 * q;
    const double linked = mesh + (of->halfedges ? 32 * q + 4 * v : 0);
    return linked + (of->simplify ? 28 * v + 32 * q + 28 * left_v + 32 * left_q : 0);
}

static void bench_one(qni_device *device, const check_bench_volume *b, int repeats, int shrink,
                      double speed) {
    static const stage stages[4] = {{"mesh", false, false, false},
                                    {"+ halfedges", true, false, false},
                                    {"+ repair", true, true, false},
                                    {"+ simplify", true, true, true}};
    const int64_t size[3] = {b->size[0] / shrink, b->size[1] / shrink, b->size[2] / shrink};
    void *samples = check_bench_samples(b, size), *on_device;
    qn_grid grid = {.samples = samples, .scalar = b->scalar, .size = {size[0], size[1], size[2]}};
    const int64_t bytes = size[0] * size[1] * size[2] * (int64_t)qn_scalar_size(b->scalar);
    double *ms = malloc((size_t)repeats * sizeof *ms);
    qni_gpu_pool pool = {.device = device};
    qni_gpu_job job;
    qni_field field;
    qn_volume *in;
    qn_error error;
    must(qn_volume_create(context, &grid, NULL, NULL, &in, &error), b->name, &error);
    must(qni_field_init(in, check_bench_iso(b), false, false, &field, &error), b->name, &error);
    must(device->alloc(device, bytes, &on_device, &error), b->name, &error);
    must(device->upload(device, on_device, samples, bytes, &error), b->name, &error);
    must(device->finish(device, &error), b->name, &error);
    for (int s = 0; s < 4; ++s) {
        for (int n = -3; n < repeats; ++n) {
            must(device->mark(device, 0, &error), "mark", &error);
            run_once(&job, &pool, &field, on_device, stages + s);
            must(device->mark(device, 1, &error), "mark", &error);
            must(device->elapsed(device, ms + (n < 0 ? 0 : n), &error), "time", &error);
        }
        const double took = median(ms, repeats);
        const double least = floor_bytes(&job, bytes, stages + s) / speed;
        char paper[32] = "";
        const double sum = b->paper[0] + (s > 0 ? b->paper[1] : 0) + (s == 3 ? b->paper[2] : 0);
        if (s != 2 && shrink == 1) /* [MDMC21] gives no times of its own for the repair */
            snprintf(paper, sizeof paper, "%.0f", sum);
        printf(
            "| %-5s %4lldx%lldx%lld %s | %-11s | %9lld | %7lld | %8.3f | %7.3f | %6.2f | %6s |\n",
            b->name, (long long)size[0], (long long)size[1], (long long)size[2],
            qn_scalar_name(b->scalar), stages[s].name, (long long)job.quad_count,
            (long long)(stages[s].repair ? job.doubled_count : 0), took, least, took / least,
            paper);
        fflush(stdout);
        if (s >= 2)
            printf("  scratch %.3f bytes a voxel\n",
                   (double)qni_gpu_scratch_bytes(&job) /
                       ((double)size[0] * (double)size[1] * (double)size[2]));
    }
    device->free(device, on_device);
    qni_gpu_pool_free(&pool);
    qn_volume_destroy(in);
    free(samples);
    free(ms);
}

static int bench(qni_device *device, int repeats, int shrink) {
    static const check_bench_volume volumes[] = {
        {"iWP", 0, {512, 512, 512}, QN_F32, {99, 73, 15}},
        {"iWP", 0, {512, 512, 512}, QN_U16, {99, 73, 15}},
        {"gen2", 1, {256, 256, 256}, QN_F32, {7, 2, 1}},
        {"gen2", 1, {256, 256, 256}, QN_U16, {7, 2, 1}},
        /* beside the paper's skull of the same size */
        {"scan", 2, {512, 512, 641}, QN_F32, {68, 58, 13}},
        {"scan", 2, {512, 512, 641}, QN_U16, {68, 58, 13}},
    };
    const double speed = copy_speed(device, ((int64_t)1 << 30) / shrink / shrink / shrink, repeats);
    printf("copies: %.0f GB/s, read and write\n", speed / 1e6);
    printf("| volume                | stage       |     quads | repairs |       ms | floor   | x "
           "floor | paper  |\n|---|---|---:|---:|---:|---:|---:|---:|\n");
    for (size_t n = 0; n < sizeof volumes / sizeof *volumes; ++n)
        bench_one(device, volumes + n, repeats, shrink, speed);
    printf(
        "ms: median of %d, events, samples resident; each row holds the ones above it. paper: "
        "[DMC21] on an RTX 2080\nTi, mesh 99, 7, 68, halfedges 73, 2, 58, simplification 15, 1, 13 "
        "ms, added up; its skull stands beside our scan.\n",
        repeats);
    return 0;
}

int main(int argc, char **argv) {
    qn_error error;
    if (argc < 3 || (strcmp(argv[1], "parity") != 0 && strcmp(argv[1], "bench") != 0)) {
        fprintf(stderr, "usage: check_gpu parity COUNT SEED | bench REPEATS [SHRINK]\n");
        return 2;
    }
    qni_device *device = open_device();
    must(qn_context_create(NULL, &context, &error), "context", &error);
    const int64_t count = atoll(argv[2]), second = argc > 3 ? atoll(argv[3]) : 1;
    const int code = strcmp(argv[1], "parity") == 0
                         ? parity(device, count, (uint64_t)second)
                         : bench(device, count > 0 ? (int)count : 1, second > 0 ? (int)second : 1);
#ifndef QNI_CHECK_ON_PROCESSOR
    qni_cuda_close(device);
#endif
    qn_context_destroy(context);
    return code;
}
