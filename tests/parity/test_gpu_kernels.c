// SPDX-License-Identifier: MIT
/* The kernels of gpu/, run on the processor with blocks and threads in shuffled order, give the
 * bytes of the CPU path: vertices, normals, quads, halfedges, repair, and the report's counts. */
#include "gpu/driver.h"
#include "gpu/host.h"
#include "gpu/session.h"
#include "lib/analytic.h"
#include "lib/random_volume.h"
#include "parity/cpu_device.h"

#include <math.h>

/* ---- volumes of every type ------------------------------------------------------------------- */

static const qn_scalar scalars[] = {QN_F32, QN_U8, QN_U16, QN_I16, QN_F64, QN_I8, QN_U32, QN_I32};

static double range_of(qn_scalar scalar, bool high) {
    switch (scalar) {
    case QN_U8:
        return high ? UINT8_MAX : 0;
    case QN_I8:
        return high ? INT8_MAX : INT8_MIN;
    case QN_U16:
        return high ? UINT16_MAX : 0;
    case QN_I16:
        return high ? INT16_MAX : INT16_MIN;
    case QN_U32:
        return high ? UINT32_MAX : 0;
    default:
        return high ? INT32_MAX : INT32_MIN;
    }
}

typedef struct sampled {
    qn_grid grid;
    void *samples;
    double iso;
} sampled;

/* The field's samples in another type: integers on a scale of their own, clamped. */
static sampled sample(const test_field *field, qn_scalar scalar, test_random *random) {
    sampled s = {.iso = field->iso};
    const int64_t count = field->size[0] * field->size[1] * field->size[2];
    const bool whole = scalar != QN_F32 && scalar != QN_F64;
    const double middle = whole ? floor((range_of(scalar, false) + range_of(scalar, true)) / 2) : 0;
    const double scale = whole ? (double)test_random_range(random, 1, 40) : 1;
    s.samples = test_alloc((size_t)count, qn_scalar_size(scalar));
    for (int64_t n = 0; n < count; ++n) {
        double value = field->values[n];
        if (whole) {
            value = round((value - field->iso) * scale + middle);
            value = isnan(value) ? middle : value;
            value = fmin(fmax(value, range_of(scalar, false)), range_of(scalar, true));
        }
        switch (scalar) {
#define STORE(name, type, text)                                                                    \
    case QN_##name:                                                                                \
        ((type *)s.samples)[n] = (type)value;                                                      \
        break;
            QN_SCALAR_MAP(STORE)
#undef STORE
        case QN_SCALAR_COUNT:
            break;
        }
    }
    if (whole)
        s.iso = middle + (test_random_range(random, 0, 1) ? 0.5 : 0.0);
    for (int64_t n = 0; !whole && n < count && random->state % 5 == 0; n += 1 + n / 2) {
        const double odd[3] = {NAN, INFINITY, -INFINITY};
        const double value = odd[test_random_range(random, 0, 2)];
        if (scalar == QN_F32)
            ((float *)s.samples)[n] = (float)value;
        else
            ((double *)s.samples)[n] = value;
    }
    if (random->state % 3 == 0) { /* twice the value, or its negative */
        s.grid.slope = random->state % 2 ? 2 : -1;
        s.grid.intercept = 0.125;
        s.iso = s.grid.slope * s.iso + s.grid.intercept;
    }
    s.grid.samples = s.samples;
    s.grid.scalar = scalar;
    memcpy(s.grid.size, field->size, sizeof s.grid.size);
    memcpy(s.grid.index_to_world, field->matrix, sizeof s.grid.index_to_world);
    return s;
}

/* ---- both ways ------------------------------------------------------------------------------- */

static void expect_equal(const char *name, const char *what, const void *found,
                         const void *expected, int64_t count, size_t size) {
    for (int64_t n = 0; n < count; ++n)
        if (memcmp((const char *)found + n * (int64_t)size,
                   (const char *)expected + n * (int64_t)size, size) != 0) {
            const uint32_t *f = (const void *)((const char *)found + n * (int64_t)size);
            const uint32_t *e = (const void *)((const char *)expected + n * (int64_t)size);
            fail_msg("%s: %s %lld of %lld is other than on the CPU: %08x %08x, not %08x %08x", name,
                     what, (long long)n, (long long)count, f[0], f[size > 4], e[0], e[size > 4]);
        }
}

static void expect_number(const char *name, const char *what, int64_t found, int64_t expected) {
    if (found != expected)
        fail_msg("%s: %s %lld, on the CPU %lld", name, what, (long long)found, (long long)expected);
}

static void expect_report(const char *name, const qn_surface_report *found,
                          const qn_surface_report *expected) {
#define EXPECT(field) expect_number(name, #field, found->field, expected->field)
    EXPECT(cells);
    EXPECT(active_leaves);
    EXPECT(active_cells);
    EXPECT(ambiguous_faces);
    EXPECT(multiple_cells);
    EXPECT(tied_faces);
    EXPECT(vertices);
    EXPECT(quads);
    EXPECT(doubled_edges);
    EXPECT(repaired_edges);
    EXPECT(slice_points);
    EXPECT(degenerate_points);
    EXPECT(fallback_points);
    EXPECT(zero_gradients);
    EXPECT(nan_samples);
    EXPECT(infinite_samples);
    EXPECT(output_bytes);
#undef EXPECT
}

/* What all volumes together had: a test on nothing would pass. */
static struct { int64_t vertices, quads, halfedges, doubled, nonfinite; } met;

static void expect_mesh(const char *name, const qni_gpu_job *job, const qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const qni_gpu_args *a = &job->args;
    expect_number(name, "vertices", job->vertex_count, view.vertex_count);
    expect_number(name, "quads", job->quad_count, view.quad_count);
    expect_equal(name, "position", a->positions, view.positions, view.vertex_count, 12);
    if (view.normals)
        expect_equal(name, "normal", a->normals, view.normals, view.vertex_count, 12);
    expect_equal(name, "quad", a->quads, view.quads, view.quad_count, 16);
    const qn_halfedges halves = qn_mesh_get_halfedges(mesh);
    expect_equal(name, "twin", a->twins, halves.twin, halves.count, 4);
    if (halves.count > 0)
        expect_equal(name, "halfedge of vertex", a->vertex_halfedges, halves.vertex_halfedge,
                     view.vertex_count, 4);
    met.halfedges += halves.count;
}

static qn_mesh *cpu_surface(qn_context *context, const qn_volume *volume,
                            const qn_surface_options *options, qn_surface_report *report) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface(context, volume, options, &mesh, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

static void compare(const char *name, const sampled *s, const qn_surface_options *options,
                    uint64_t shuffle) {
    qn_context *context = test_context(1);
    qn_volume *volume;
    qn_error error;
    qn_surface_report expected, found;
    qni_field field;
    memset(&found, 0, sizeof found);
    assert_int_equal(qn_volume_create(context, &s->grid, NULL, NULL, &volume, &error), QN_OK);
    qn_mesh *mesh = cpu_surface(context, volume, options, &expected);
    assert_int_equal(qni_field_init(volume, s->iso, options->inside == QN_INSIDE_BELOW,
                                    options->open, &field, &error),
                     QN_OK);
    test_cpu_device cpu;
    test_cpu_device_init(&cpu, shuffle);
    qni_gpu_pool pool = {.device = &cpu.device};
    qni_gpu_job job;
    qni_gpu_job_init(&job, &pool, &field, s->samples, s->grid.size[0],
                     s->grid.size[0] * s->grid.size[1]);
    job.with_normals = !options->skip_normals;
    job.with_halfedges = options->halfedges;
    job.with_repair = !options->keep_doubled;
    if (qni_gpu_count_surface(&job, &error) != QN_OK ||
        qni_gpu_emit_surface(&job, &error) != QN_OK ||
        qni_gpu_finish_surface(&job, &error) != QN_OK)
        fail_msg("%s: %s", name, error.message);
    qni_gpu_fill_report(&job, &found);
    if (field.leaves[0] * field.leaves[1] * field.leaves[2] > 0)
        expect_report(name, &found, &expected);
    expect_mesh(name, &job, mesh);
    met.vertices += job.vertex_count;
    met.quads += job.quad_count;
    met.doubled += job.doubled_count;
    met.nonfinite += job.field.nan_count + job.field.infinite_count;
    qni_gpu_pool_free(&pool);
    assert_int_equal(cpu.bytes, 0);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
}

static void bytes_are_those_of_the_cpu(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    const int64_t count = test_count(60, 500);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 28);
        const qn_scalar scalar = scalars[i / TEST_KIND_COUNT % 8];
        sampled s = sample(&field, scalar, &random);
        qn_surface_options options = test_field_options(&field);
        options.device = QN_DEVICE_CPU;
        char name[128];
        options.isovalues = &s.iso;
        options.keep_doubled = i % 3 == 0 || options.open;
        options.halfedges = i % 4 != 0;
        options.skip_normals = i % 9 == 8;
        snprintf(name, sizeof name, "volume %lld (%s, %s)", (long long)i, field.name,
                 qn_scalar_name(scalar));
        compare(name, &s, &options, random.state);
        free(s.samples);
        test_field_free(&field);
    }
    printf("%lld volumes, %lld vertices, %lld quads, %lld doubled edges, %lld non-finite samples: "
           "the same bytes\n",
           (long long)count, (long long)met.vertices, (long long)met.quads, (long long)met.doubled,
           (long long)met.nonfinite);
    assert_true(met.vertices > 10000 && met.halfedges > 10000 && met.doubled > 100);
    assert_true(met.nonfinite > 2);
}

/* ---- volumes in the processor's memory ------------------------------------------------------- */

/* All that a mesh holds, halfedges too. */
static uint64_t hash_all(const qn_mesh *mesh) {
    const qn_halfedges halves = qn_mesh_get_halfedges(mesh);
    uint64_t hash = test_hash_mesh(mesh);
    if (halves.count == 0)
        return hash;
    hash = test_hash(hash, halves.twin, (size_t)halves.count * 4);
    return test_hash(hash, halves.vertex_halfedge, (size_t)qn_mesh_get_view(mesh).vertex_count * 4);
}

/* A volume of gen2 with noise, whose rows and planes lie apart. */
typedef struct padded {
    float *samples;
    qn_grid grid;
} padded;

static padded make_padded(uint64_t seed) {
    enum { N = 40, ROW = 44, ROWS = 43 };
    padded p = {.samples = test_alloc(ROW * ROWS * N, sizeof(float))};
    test_random random = {seed};
    for (int64_t n = 0; n < ROW * ROWS * N; ++n)
        p.samples[n] = 1e30f;
    for (int z = 0; z < N; ++z)
        for (int y = 0; y < N; ++y)
            for (int x = 0; x < N; ++x)
                p.samples[(z * ROWS + y) * ROW + x] =
                    (float)(sin(0.5 * x) * cos(0.4 * y) + sin(0.45 * z) +
                            0.7 * (test_random_unit(&random) - 0.5));
    p.grid = (qn_grid){.samples = p.samples, .scalar = QN_F32, .size = {N, N, N}};
    p.grid.stride[0] = 4;
    p.grid.stride[1] = 4 * ROW;
    p.grid.stride[2] = 4 * ROW * ROWS;
    return p;
}

static void improved_meshes_are_those_of_the_cpu(void **state) {
    (void)state;
    padded p = make_padded(7);
    qn_context *context = test_context(2);
    qn_volume *volume;
    qn_error error;
    assert_int_equal(qn_volume_create(context, &p.grid, NULL, NULL, &volume, &error), QN_OK);
    for (int i = 0; i < 4; ++i) {
        qn_surface_options options;
        qn_surface_report report[2];
        qn_mesh *mesh[2];
        qn_surface_options_init(&options);
        options.relax = i & 2;
        options.halfedges = i == 3;
        options.device = QN_DEVICE_CPU;
        mesh[0] = cpu_surface(context, volume, &options, report);
        test_cpu_device cpu;
        test_cpu_device_init(&cpu, (uint64_t)i);
        options.device = QN_DEVICE_CUDA;
        assert_null(qni_gpu_cannot(volume, &options));
        if (qni_gpu_host_surface(context, &cpu.device, volume, 0, &options, mesh + 1, report + 1,
                                 &error) != QN_OK)
            fail_msg("%s", error.message);
        assert_true(hash_all(mesh[0]) == hash_all(mesh[1]));
        expect_report("improved", report + 1, report);
        assert_int_equal(report[0].device, QN_DEVICE_CPU);
        assert_int_equal(report[1].device, QN_DEVICE_CUDA);
        options.simplify = true;
        assert_non_null(qni_gpu_cannot(volume, &options));
        assert_int_equal(report[1].relaxed_vertices, report[0].relaxed_vertices);
        assert_true(report[0].repaired_edges > 0);
        assert_int_equal(cpu.finishes, 3); /* counts, what pass 2 counted, the mesh */
        assert_int_equal(cpu.bytes, 0);
        qn_mesh_destroy(mesh[0]);
        qn_mesh_destroy(mesh[1]);
    }
    qn_volume_destroy(volume);
    test_context_end(context);
    free(p.samples);
}

static void little_device_memory_is_an_error(void **state) {
    (void)state;
    padded p = make_padded(8);
    qn_context *context = test_context(1);
    qn_volume *volume;
    qn_error error;
    qn_surface_options options;
    qn_surface_report report;
    qn_mesh *mesh = NULL;
    test_cpu_device cpu;
    int64_t limit = 1;
    assert_int_equal(qn_volume_create(context, &p.grid, NULL, NULL, &volume, &error), QN_OK);
    qn_surface_options_init(&options);
    options.halfedges = true;
    for (int tries = 0; !mesh; ++tries) {
        test_cpu_device_init(&cpu, 1);
        cpu.limit = limit;
        const qn_status status =
            qni_gpu_host_surface(context, &cpu.device, volume, 0, &options, &mesh, &report, &error);
        assert_int_equal(status, mesh ? QN_OK : QN_ERROR_OUT_OF_MEMORY);
        assert_int_equal(cpu.bytes, 0);
        assert_true(tries < 1000);
        limit += 50000;
    }
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
    free(p.samples);
}

/* Samples and mesh in device memory; a call like the one before allocates nothing. */
static void resident_meshes_are_those_of_the_cpu(void **state) {
    (void)state;
    padded p = make_padded(9);
    qn_context *context = test_context(1);
    qn_volume *volume;
    qn_error error;
    test_cpu_device cpu;
    test_cpu_device_init(&cpu, 4);
    qni_gpu_pool pool = {.device = &cpu.device};
    assert_int_equal(qn_volume_create(context, &p.grid, NULL, NULL, &volume, &error), QN_OK);
    int64_t allocations = 0;
    for (int i = 0; i < 3; ++i) {
        const double iso = i == 2 ? 0.9 : 0;
        qn_surface_options options;
        qn_surface_report report[2];
        qn_cuda_mesh found;
        qn_surface_options_init(&options);
        options.isovalues = &iso;
        options.isovalue_count = 1;
        options.halfedges = i != 1;
        options.device = QN_DEVICE_CPU;
        qn_mesh *mesh = cpu_surface(context, volume, &options, report);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        if (qni_gpu_resident_surface(context, &pool, &p.grid, iso, &options, &found, report + 1,
                                     &error) != QN_OK)
            fail_msg("%s", error.message);
        expect_number("resident", "vertices", found.vertex_count, view.vertex_count);
        expect_equal("resident", "normal", found.normals, view.normals, view.vertex_count, 12);
        expect_equal("resident", "quad", found.quads, view.quads, view.quad_count, 16);
        assert_true((found.twin != NULL) == options.halfedges);
        expect_report("resident", report + 1, report);
        assert_true(i == 0 || cpu.allocations == allocations);
        allocations = cpu.allocations;
        options.simplify = true;
        assert_int_equal(
            qni_gpu_resident_surface(context, &pool, &p.grid, iso, &options, &found, NULL, &error),
            QN_ERROR_UNSUPPORTED);
        qn_mesh_destroy(mesh);
    }
    qni_gpu_pool_free(&pool);
    assert_int_equal(cpu.bytes, 0);
    qn_volume_destroy(volume);
    test_context_end(context);
    free(p.samples);
}

/* Scratch on the device, halfedges and repair included: bits and counts of all leaves, records of
 * those with surface, marks of quads, lists of multiple cells and doubled edges. Half a byte a
 * voxel at most on iWP 512^3, the densest of the benchmark's volumes. */
static void scratch_is_small(void **state) {
    (void)state;
    const char *names[2] = {"iwp", "gen2"};
    for (int i = 0; i < 2; ++i) {
        const int64_t size = test_count(96, i == 0 ? 512 : 256);
        qn_context *context = test_context(1);
        void *samples;
        qn_volume *volume =
            test_analytic_volume(context, test_analytic_find(names[i]), size, QN_U16, &samples);
        qn_surface_options options;
        qn_surface_report report;
        qn_mesh *mesh;
        qn_error error;
        test_cpu_device cpu;
        qn_surface_options_init(&options);
        options.halfedges = true;
        test_cpu_device_init(&cpu, 3);
        assert_int_equal(qni_gpu_host_surface(context, &cpu.device, volume,
                                              test_analytic_iso(QN_U16), &options, &mesh, &report,
                                              &error),
                         QN_OK);
        const double voxels = (double)(size * size * size);
        const double share = (double)report.scratch_bytes / voxels;
        const double bound = 0.23 * voxels + 330.0 * (double)report.active_leaves +
                             0.3 * (double)report.quads + 8.0 * (double)report.multiple_cells +
                             700.0 * (double)report.doubled_edges + 65536.0;
        printf("%s %lld^3: %.3f bytes of scratch a voxel\n", names[i], (long long)size, share);
        assert_true((double)report.scratch_bytes < bound);
        assert_true(size < 256 || share < 0.5);
        qn_mesh_destroy(mesh);
        qn_volume_destroy(volume);
        free(samples);
        test_context_end(context);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_those_of_the_cpu),
        cmocka_unit_test(improved_meshes_are_those_of_the_cpu),
        cmocka_unit_test(little_device_memory_is_an_error),
        cmocka_unit_test(resident_meshes_are_those_of_the_cpu),
        cmocka_unit_test(scratch_is_small),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
