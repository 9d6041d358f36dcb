// SPDX-License-Identifier: MIT
/* The kernels of gpu/, run on the processor with blocks and threads in shuffled order, give the
 * bytes of the CPU path: vertices, normals, quads, halfedges, repair, and the report's counts. */
#include "gpu/driver.h"
#include "gpu/host.h"
#include "gpu/session.h"
#include "lib/analytic.h"
#include "parity/cases.h"
#include "parity/cpu_device.h"

#include <math.h>

/* What all volumes together had: a test on nothing would pass. */
static struct { int64_t vertices, quads, halfedges, doubled, nonfinite; } met;

static void expect_mesh(const char *name, const qni_gpu_job *job, const qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const qni_gpu_args *a = &job->args;
    test_expect_number(name, "vertices", job->vertex_count, view.vertex_count);
    test_expect_number(name, "quads", job->quad_count, view.quad_count);
    test_expect_equal(name, "position", a->positions, view.positions, view.vertex_count, 12);
    if (view.normals)
        test_expect_equal(name, "normal", a->normals, view.normals, view.vertex_count, 12);
    test_expect_equal(name, "quad", a->quads, view.quads, view.quad_count, 16);
    const qn_halfedges halves = qn_mesh_get_halfedges(mesh);
    test_expect_equal(name, "twin", a->twins, halves.twin, halves.count, 4);
    if (halves.count > 0)
        test_expect_equal(name, "halfedge of vertex", a->vertex_halfedges, halves.vertex_halfedge,
                          view.vertex_count, 4);
    met.halfedges += halves.count;
}

static void compare(const char *name, const test_sampled *s, const qn_surface_options *options,
                    uint64_t shuffle) {
    qn_context *context = test_context(1);
    qn_volume *volume;
    qn_error error;
    qn_surface_report expected, found;
    qni_field field;
    memset(&found, 0, sizeof found);
    assert_int_equal(qn_volume_create(context, &s->grid, NULL, NULL, &volume, &error), QN_OK);
    qn_mesh *mesh = test_cpu_surface(context, volume, options, &expected);
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
        test_expect_report(name, &found, &expected);
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
        const qn_scalar scalar = test_scalars[i / TEST_KIND_COUNT % 8];
        test_sampled s = test_sample(&field, scalar, &random);
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
    for (int i = 0; i < 8; ++i) {
        qn_surface_options options;
        qn_surface_report report[2];
        qn_mesh *mesh[2];
        qn_surface_options_init(&options);
        options.relax = i & 2;
        options.halfedges = i == 3 || i > 5;
        options.simplify = i > 3;
        options.device = QN_DEVICE_CPU;
        mesh[0] = test_cpu_surface(context, volume, &options, report);
        test_cpu_device cpu;
        test_cpu_device_init(&cpu, (uint64_t)i);
        options.device = QN_DEVICE_CUDA;
        assert_null(qni_gpu_cannot(volume, &options));
        if (qni_gpu_host_surface(context, &cpu.device, volume, 0, &options, 0, mesh + 1, report + 1,
                                 &error) != QN_OK)
            fail_msg("%s", error.message);
        assert_true(test_hash_all(mesh[0]) == test_hash_all(mesh[1]));
        test_expect_report("improved", report + 1, report);
        assert_int_equal(report[0].device, QN_DEVICE_CPU);
        assert_int_equal(report[1].device, QN_DEVICE_CUDA);
        assert_int_equal(report[1].relaxed_vertices, report[0].relaxed_vertices);
        assert_int_equal(report[1].merged_quads, report[0].merged_quads);
        assert_int_equal(report[1].simplify_passes, report[0].simplify_passes);
        assert_true((report[1].merged_quads > 0) == options.simplify);
        assert_true(report[0].repaired_edges > 0);
        if (!options.simplify) /* counts, what pass 2 counted, the mesh */
            assert_int_equal(cpu.finishes, 3);
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
        const qn_status status = qni_gpu_host_surface(context, &cpu.device, volume, 0, &options, 0,
                                                      &mesh, &report, &error);
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
        qn_mesh *mesh = test_cpu_surface(context, volume, &options, report);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        if (qni_gpu_resident_surface(context, &pool, &p.grid, iso, &options, &found, report + 1,
                                     &error) != QN_OK)
            fail_msg("%s", error.message);
        test_expect_number("resident", "vertices", found.vertex_count, view.vertex_count);
        test_expect_equal("resident", "normal", found.normals, view.normals, view.vertex_count, 12);
        test_expect_equal("resident", "quad", found.quads, view.quads, view.quad_count, 16);
        assert_true((found.twin != NULL) == options.halfedges);
        test_expect_report("resident", report + 1, report);
        assert_true(i == 0 || cpu.allocations == allocations);
        allocations = cpu.allocations;
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
                                              test_analytic_iso(QN_U16), &options, 0, &mesh,
                                              &report, &error),
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
