// SPDX-License-Identifier: MIT
/* Simplification by the kernels of gpu/ leaves the mesh that the CPU leaves, to the byte. */
#include "gpu/host.h"
#include "gpu/session.h"
#include "parity/cases.h"
#include "parity/cpu_device.h"

#include <math.h>

/* What all volumes together had: a test on nothing would pass. */
static struct { int64_t merged, shrunk, unprojected, passes; } met;

static void compare(const char *name, const test_sampled *s, const qn_surface_options *options,
                    uint64_t shuffle) {
    qn_context *context = test_context(2);
    test_cpu_device cpu;
    qn_surface_report report[2];
    qn_volume *volume;
    qn_mesh *mesh[2];
    qn_error error;
    assert_int_equal(qn_volume_create(context, &s->grid, NULL, NULL, &volume, &error), QN_OK);
    mesh[0] = test_cpu_surface(context, volume, options, report);
    test_cpu_device_init(&cpu, shuffle);
    assert_null(qni_gpu_cannot(volume, options));
    if (qni_gpu_host_surface(context, &cpu.device, volume, s->iso, options, 0, mesh + 1, report + 1,
                             &error) != QN_OK)
        fail_msg("%s: %s", name, error.message);
    test_expect_mesh(name, mesh[1], mesh[0]);
    if (report[0].cells > 0)
        test_expect_report(name, report + 1, report);
    assert_int_equal(cpu.bytes, 0);
    met.merged += report[1].merged_quads;
    met.shrunk += report[1].shrunk_quads;
    met.unprojected += report[1].unprojected_points;
    met.passes = report[1].simplify_passes > met.passes ? report[1].simplify_passes : met.passes;
    qn_mesh_destroy(mesh[0]);
    qn_mesh_destroy(mesh[1]);
    qn_volume_destroy(volume);
    test_context_end(context);
}

static void bytes_are_those_of_the_cpu(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    const int64_t count = test_count(48, 500);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + 31337 + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 30);
        test_sampled s = test_sample(&field, test_scalars[i / TEST_KIND_COUNT % 8], &random);
        qn_surface_options options = test_field_options(&field);
        char name[128];
        options.device = QN_DEVICE_CPU;
        options.isovalues = &s.iso;
        options.simplify = true;
        options.simplify_passes = i % 4 == 3 ? (int32_t)(i / 4 % 4) - 1 : 0;
        options.keep_doubled = i % 3 == 0 || options.open;
        options.halfedges = i % 2 != 0;
        options.skip_normals = i % 9 == 8;
        options.no_reproject = i % 7 == 6;
        options.relax = i % 11 == 10;
        snprintf(name, sizeof name, "volume %lld (%s)", (long long)i, field.name);
        compare(name, &s, &options, random.state);
        free(s.samples);
        test_field_free(&field);
    }
    printf("%lld volumes, %lld quads merged, %lld shrunk, %lld points out of reach, up to %lld "
           "passes: the same bytes\n",
           (long long)count, (long long)met.merged, (long long)met.shrunk,
           (long long)met.unprojected, (long long)met.passes);
    assert_true(met.merged > 1000 && met.shrunk > 100 && met.unprojected > 0 && met.passes > 2);
}

/* Samples and mesh stay on the device. */
static void resident_meshes_are_simplified(void **state) {
    (void)state;
    enum { N = 40 };
    float *samples = test_alloc(N * N * N, sizeof *samples);
    test_random random = {5};
    for (int64_t n = 0; n < N * N * N; ++n) {
        const double x = (double)(n % N), y = (double)(n / N % N), z = (double)(n / N / N);
        samples[n] = (float)(sin(0.5 * x) * cos(0.4 * y) + sin(0.45 * z) +
                             0.3 * (test_random_unit(&random) - 0.5));
    }
    const qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {N, N, N}};
    qn_context *context = test_context(1);
    qn_surface_options options;
    qn_surface_report report[2];
    qn_cuda_mesh found;
    qn_volume *volume;
    qn_error error;
    test_cpu_device cpu;
    test_cpu_device_init(&cpu, 6);
    qni_gpu_pool pool = {.device = &cpu.device};
    assert_int_equal(qn_volume_create(context, &grid, NULL, NULL, &volume, &error), QN_OK);
    qn_surface_options_init(&options);
    options.simplify = true;
    options.device = QN_DEVICE_CPU;
    for (int i = 0; i < 3; ++i) {
        options.halfedges = i == 1;
        qn_mesh *mesh = test_cpu_surface(context, volume, &options, report);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        const qn_halfedges halves = qn_mesh_get_halfedges(mesh);
        if (qni_gpu_resident_surface(context, &pool, &grid, 0, &options, &found, report + 1,
                                     &error) != QN_OK)
            fail_msg("%s", error.message);
        test_expect_number("resident", "vertices", found.vertex_count, view.vertex_count);
        test_expect_equal("resident", "position", found.positions, view.positions,
                          view.vertex_count, 12);
        test_expect_equal("resident", "normal", found.normals, view.normals, view.vertex_count, 12);
        test_expect_equal("resident", "quad", found.quads, view.quads, view.quad_count, 16);
        assert_true((found.twin != NULL) == options.halfedges);
        test_expect_equal("resident", "twin", found.twin, halves.twin, halves.count, 4);
        test_expect_report("resident", report + 1, report);
        assert_true(report[1].merged_quads > 100);
        qn_mesh_destroy(mesh);
    }
    options.simplify_passes = -1;
    assert_int_equal(
        qni_gpu_resident_surface(context, &pool, &grid, 0, &options, &found, NULL, &error),
        QN_ERROR_UNSUPPORTED);
    qni_gpu_pool_free(&pool);
    qn_volume_destroy(volume);
    test_context_end(context);
    free(samples);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_those_of_the_cpu),
        cmocka_unit_test(resident_meshes_are_simplified),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
