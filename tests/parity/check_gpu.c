// SPDX-License-Identifier: MIT
/* What gpu/check runs: random volumes on both ways, byte against byte, and the benchmark. It needs
 * no test library, so that it builds where there is little beside nvcc.
 *
 * usage: check_gpu parity COUNT SEED | bench REPEATS [SHRINK]      (SHRINK divides the sizes) */
#include "dmc/dmc.h"
#include "gpu/cuda.h"
#include "gpu/driver.h"
#include "gpu/host.h"
#include "mesh/mesh.h"
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

/* ---- random volumes -------------------------------------------------------------------------- */

static uint64_t state;

static uint64_t random_bits(void) {
    uint64_t z = (state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static int64_t below(int64_t end) {
    return (int64_t)(random_bits() % (uint64_t)end);
}

static double unit(void) {
    return (double)(random_bits() >> 11) / 9007199254740992.0;
}

typedef struct volume {
    qn_grid grid;
    void *samples;
    double iso;
    const char *kind;
} volume;

/* Values about -1 to 1 round 0. */
static double sample_of(int kind, int64_t i, int64_t j, int64_t k) {
    const double u = 2 * unit() - 1;
    switch (kind) {
    case 0:
        return u;
    case 1:
        return u * u * u * u * u;
    case 2:
        return (double)(below(5) - 2) / 2;
    case 3:
        return ((i + j + k) & 1 ? 1 : -1) * (0.2 + 0.1 * u);
    case 4:
        return sin(0.6 * (double)i) * cos(0.5 * (double)j) + sin(0.55 * (double)k) + 0.4 * u;
    default:
        return below(40) == 0 ? 1 : -1;
    }
}

static const char *const kinds[6] = {"noise",        "heavy tails", "small integers",
                                     "checkerboard", "noisy waves", "specks"};

static volume random_volume(void) {
    static const qn_scalar scalars[4] = {QN_F32, QN_U16, QN_U8, QN_I16};
    const int kind = (int)below(6);
    volume v = {.kind = kinds[kind]};
    v.grid.scalar = scalars[below(4)];
    for (int a = 0; a < 3; ++a)
        v.grid.size[a] = 2 + below(32);
    const int64_t count = v.grid.size[0] * v.grid.size[1] * v.grid.size[2];
    const double middle = v.grid.scalar == QN_U8 ? 128 : v.grid.scalar == QN_U16 ? 2000 : 0;
    const double scale = v.grid.scalar == QN_F32 ? 1 : (double)(2 + below(60));
    v.iso = middle + (v.grid.scalar == QN_F32 || below(2) ? 0 : 0.5);
    v.samples = malloc((size_t)count * qn_scalar_size(v.grid.scalar));
    if (!v.samples)
        exit(1);
    for (int64_t n = 0; n < count; ++n) {
        const int64_t row = n / v.grid.size[0];
        double value = middle + scale * sample_of(kind, n % v.grid.size[0], row % v.grid.size[1],
                                                  row / v.grid.size[1]);
        switch (v.grid.scalar) {
        case QN_F32:
            ((float *)v.samples)[n] = below(4000) ? (float)value : NAN;
            break;
        case QN_U16:
            ((uint16_t *)v.samples)[n] = (uint16_t)value;
            break;
        case QN_U8:
            ((uint8_t *)v.samples)[n] = (uint8_t)fmin(fmax(value, 0), 255);
            break;
        default:
            ((int16_t *)v.samples)[n] = (int16_t)value;
        }
    }
    v.grid.samples = v.samples;
    const double matrix[4][4] = {
        {1 + unit(), 0.1, 0, 3}, {0, below(2) ? 1 : -1, 0.2, -1}, {0.3, 0, 1 + unit(), 2}};
    memcpy(v.grid.index_to_world, matrix, sizeof matrix);
    v.grid.index_to_world[3][3] = 1;
    return v;
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

static int parity(qni_device *device, int64_t count, uint64_t seed) {
    int64_t vertices = 0, doubled = 0, borders = 0, wrong = 0;
    for (int64_t n = 0; n < count; ++n) {
        state = seed + (uint64_t)n;
        volume v = random_volume();
        qn_surface_options options;
        qn_surface_report report[2];
        qn_volume *in;
        qn_mesh *mesh[2];
        qn_error error;
        qn_surface_options_init(&options);
        options.inside = below(2) ? QN_INSIDE_ABOVE : QN_INSIDE_BELOW;
        options.open = below(3) == 0;
        options.keep_doubled = options.open || below(3) == 0;
        options.halfedges = below(3) > 0;
        options.skip_normals = below(8) == 0;
        options.relax = n % 10 == 9;
        /* every third volume goes through in slabs of one to three layers of leaves */
        const bool thin = options.open && v.grid.size[2] < 2;
        const int32_t layers = n % 3 == 2 && !thin ? 1 + (int32_t)(n / 3 % 3) : 0;
        must(qn_volume_create(context, &v.grid, NULL, NULL, &in, &error), "volume", &error);
        must(qni_dmc_surface(context, in, v.iso, &options, mesh, report, &error), "CPU", &error);
        must(qni_gpu_host_surface(context, device, in, v.iso, &options, layers, mesh + 1,
                                  report + 1, &error),
             "GPU", &error);
        if (meshes_differ(mesh[0], mesh[1]) ||
            report[0].fallback_points != report[1].fallback_points ||
            report[0].ambiguous_faces != report[1].ambiguous_faces) {
            ++wrong;
            printf("  volume %lld of seed %llu: %s %s %lld x %lld x %lld\n", (long long)n,
                   (unsigned long long)seed, v.kind, qn_scalar_name(v.grid.scalar),
                   (long long)v.grid.size[0], (long long)v.grid.size[1], (long long)v.grid.size[2]);
        }
        vertices += mesh[0]->vertex_count;
        doubled += report[0].doubled_edges;
        borders += report[1].device_slabs - 1;
        qn_mesh_destroy(mesh[0]);
        qn_mesh_destroy(mesh[1]);
        qn_volume_destroy(in);
        free(v.samples);
    }
    printf("parity: %lld random volumes, %lld vertices, %lld doubled edges, %lld borders of slabs: "
           "%lld differ\n",
           (long long)count, (long long)vertices, (long long)doubled, (long long)borders,
           (long long)wrong);
    return wrong > 0 || (count > 20 && (vertices == 0 || doubled == 0 || borders == 0));
}

/* ---- the benchmark's volumes ----------------------------------------------------------------- */

/* [DMC21] (5) and (6); x, y, z from 0 to 1 over the volume. */
static double iwp(double x, double y, double z) {
    const double a = 10.02 * 3.14159265358979323846;
    const double cx = cos(a * x), cy = cos(a * y), cz = cos(a * z);
    return cx * cy + cy * cz + cz * cx - cx * cy * cz;
}

static double gen2(double u, double v, double w) {
    const double x = 4 * u - 2, y = 4 * v - 2, z = 4 * w - 2, r = x * x + y * y;
    return 2 * y * (y * y - 3 * x * x) * (1 - z * z) + r * r - (9 * z * z - 1) * (1 - z * z);
}

/* Noise that depends on the place alone. */
static double noise(int64_t i, int64_t j, int64_t k) {
    uint64_t z = (uint64_t)i * UINT64_C(0x9e3779b97f4a7c15) ^
                 (uint64_t)j * UINT64_C(0xbf58476d1ce4e5b9) ^
                 (uint64_t)k * UINT64_C(0x94d049bb133111eb);
    z = (z ^ (z >> 31)) * UINT64_C(0xd6e8feb86659fd93);
    return (double)((z ^ (z >> 32)) >> 11) / 9007199254740992.0 - 0.5;
}

/* A body of struts, 12 bits, with noise of a few grey values, as a scanner gives it. */
static double scan(int64_t i, int64_t j, int64_t k, double period) {
    const double f = 6.28318530717958647693 / period;
    const double x = f * (double)i, y = f * (double)j, z = f * (double)k;
    const double wave = sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x);
    return floor(2048 + 700 * wave + 40 * noise(i, j, k));
}

typedef struct bench_volume {
    const char *name;
    int kind; /* 0 iwp, 1 gen2, 2 scan */
    int64_t size[3];
    qn_scalar scalar;
    double paper[2]; /* ms: mesh, halfedges; on an RTX 2080 Ti */
} bench_volume;

static double value_of(const bench_volume *b, const int64_t size[3], int64_t i, int64_t j,
                       int64_t k) {
    if (b->kind == 2)
        return scan(i, j, k, 150.0 * (double)size[0] / 512);
    const double x = (double)i / (double)(size[0] - 1), y = (double)j / (double)(size[1] - 1),
                 z = (double)k / (double)(size[2] - 1);
    const double value = b->kind == 0 ? iwp(x, y, z) : gen2(x, y, z);
    if (b->scalar == QN_F32)
        return value;
    return fmin(fmax(round(32768 + (b->kind == 0 ? 8000 : 4000) * value), 0), 65535);
}

static double iso_of(const bench_volume *b) {
    return b->kind == 2 ? 2048.5 : b->scalar == QN_F32 ? 0 : 32768;
}

static void *make_samples(const bench_volume *b, const int64_t size[3]) {
    const int64_t count = size[0] * size[1] * size[2];
    void *samples = malloc((size_t)count * qn_scalar_size(b->scalar));
    if (!samples) {
        fprintf(stderr, "check_gpu: no memory for %s\n", b->name);
        exit(1);
    }
#pragma omp parallel for schedule(dynamic)
    for (int64_t k = 0; k < size[2]; ++k)
        for (int64_t j = 0; j < size[1]; ++j)
            for (int64_t i = 0; i < size[0]; ++i) {
                const int64_t n = i + size[0] * (j + size[1] * k);
                const double value = value_of(b, size, i, j, k);
                if (b->scalar == QN_F32)
                    ((float *)samples)[n] = (float)value;
                else
                    ((uint16_t *)samples)[n] = (uint16_t)value;
            }
    return samples;
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
    bool halfedges, repair;
} stage;

static void run_once(qni_gpu_job *job, qni_gpu_pool *pool, const qni_field *field,
                     const void *samples, const stage *of) {
    const int64_t *size = field->grid->size;
    qn_error error;
    qni_gpu_job_init(job, pool, field, samples, size[0], size[0] * size[1]);
    job->with_normals = true;
    job->with_halfedges = of->halfedges;
    job->with_repair = of->repair;
    must(qni_gpu_count_surface(job, &error), "pass 1", &error);
    must(qni_gpu_emit_surface(job, &error), "pass 2", &error);
    must(qni_gpu_finish_surface(job, &error), "the end", &error);
}

/* Samples read once, mesh written once; halfedges read the quads once more. */
static double floor_bytes(const qni_gpu_job *job, int64_t sample_bytes, const stage *of) {
    const double v = (double)job->vertex_count, q = (double)job->quad_count;
    return (double)sample_bytes + 24 * v + 16 * q + (of->halfedges ? 32 * q + 4 * v : 0);
}

static void bench_one(qni_device *device, const bench_volume *b, int repeats, int shrink,
                      double speed) {
    static const stage stages[3] = {
        {"mesh", false, false}, {"+ halfedges", true, false}, {"+ repair", true, true}};
    const int64_t size[3] = {b->size[0] / shrink, b->size[1] / shrink, b->size[2] / shrink};
    void *samples = make_samples(b, size), *on_device;
    qn_grid grid = {.samples = samples, .scalar = b->scalar, .size = {size[0], size[1], size[2]}};
    const int64_t bytes = size[0] * size[1] * size[2] * (int64_t)qn_scalar_size(b->scalar);
    double *ms = malloc((size_t)repeats * sizeof *ms);
    qni_gpu_pool pool = {.device = device};
    qni_gpu_job job;
    qni_field field;
    qn_volume *in;
    qn_error error;
    must(qn_volume_create(context, &grid, NULL, NULL, &in, &error), b->name, &error);
    must(qni_field_init(in, iso_of(b), false, false, &field, &error), b->name, &error);
    must(device->alloc(device, bytes, &on_device, &error), b->name, &error);
    must(device->upload(device, on_device, samples, bytes, &error), b->name, &error);
    must(device->finish(device, &error), b->name, &error);
    for (int s = 0; s < 3; ++s) {
        for (int n = -3; n < repeats; ++n) {
            must(device->mark(device, 0, &error), "mark", &error);
            run_once(&job, &pool, &field, on_device, stages + s);
            must(device->mark(device, 1, &error), "mark", &error);
            must(device->elapsed(device, ms + (n < 0 ? 0 : n), &error), "time", &error);
        }
        const double took = median(ms, repeats);
        const double least = floor_bytes(&job, bytes, stages + s) / speed;
        char paper[32] = "";
        if (s < 2 && shrink == 1)
            snprintf(paper, sizeof paper, "%.0f", b->paper[0] + (s ? b->paper[1] : 0));
        printf(
            "| %-5s %4lldx%lldx%lld %s | %-11s | %9lld | %7lld | %8.3f | %7.3f | %6.2f | %6s |\n",
            b->name, (long long)size[0], (long long)size[1], (long long)size[2],
            qn_scalar_name(b->scalar), stages[s].name, (long long)job.quad_count,
            (long long)(stages[s].repair ? job.doubled_count : 0), took, least, took / least,
            paper);
        fflush(stdout);
    }
    printf("  scratch %.3f bytes a voxel\n",
           (double)qni_gpu_scratch_bytes(&job) /
               ((double)size[0] * (double)size[1] * (double)size[2]));
    device->free(device, on_device);
    qni_gpu_pool_free(&pool);
    qn_volume_destroy(in);
    free(samples);
    free(ms);
}

static int bench(qni_device *device, int repeats, int shrink) {
    static const bench_volume volumes[] = {
        {"iWP", 0, {512, 512, 512}, QN_F32, {99, 73}},
        {"iWP", 0, {512, 512, 512}, QN_U16, {99, 73}},
        {"gen2", 1, {256, 256, 256}, QN_F32, {7, 2}},
        {"gen2", 1, {256, 256, 256}, QN_U16, {7, 2}},
        /* beside the paper's skull of the same size */
        {"scan", 2, {512, 512, 641}, QN_F32, {68, 58}},
        {"scan", 2, {512, 512, 641}, QN_U16, {68, 58}},
    };
    const double speed = copy_speed(device, ((int64_t)1 << 30) / shrink / shrink / shrink, repeats);
    printf("copies: %.0f GB/s, read and write\n", speed / 1e6);
    printf("| volume                | stage       |     quads | repairs |       ms | floor   | x "
           "floor | paper  |\n|---|---|---:|---:|---:|---:|---:|---:|\n");
    for (size_t n = 0; n < sizeof volumes / sizeof *volumes; ++n)
        bench_one(device, volumes + n, repeats, shrink, speed);
    printf("ms: median of %d, events, samples resident. paper: [DMC21] on an RTX 2080 Ti, mesh 99, "
           "7, 68, halfedges\n73, 2, 58, simplification 15, 1, 13 ms; its skull stands beside our "
           "scan. Simplification is not on the GPU: no row.\n",
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
