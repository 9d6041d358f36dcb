// SPDX-License-Identifier: MIT
/* A volume that goes through a device in slabs gives the bytes and the report of the CPU path,
 * wherever it is cut, and memory decides where. */
#include "gpu/host.h"
#include "parity/cases.h"
#include "parity/cpu_device.h"

/* What all volumes together had: a test on nothing would pass. */
static struct { int64_t vertices, doubled, borders, nonfinite; } met;

static void compare(const char *name, const qn_volume *volume, qn_context *context, double iso,
                    const qn_surface_options *options, const qn_mesh *mesh,
                    const qn_surface_report *expected, int32_t layers, uint64_t shuffle) {
    test_cpu_device cpu;
    qn_surface_report report;
    qn_mesh *found;
    qn_error error;
    char full[160];
    snprintf(full, sizeof full, "%s, slabs of %d layers", name, layers);
    test_cpu_device_init(&cpu, shuffle);
    if (qni_gpu_host_surface(context, &cpu.device, volume, iso, options, layers, &found, &report,
                             &error) != QN_OK)
        fail_msg("%s: %s", full, error.message);
    test_expect_mesh(full, found, mesh);
    test_expect_report(full, &report, expected);
    assert_int_equal(cpu.bytes, 0);
    met.borders += report.device_slabs - 1;
    qn_mesh_destroy(found);
}

/* Larger than elsewhere, so that there are layers to cut. */
static void bytes_do_not_depend_on_slabs(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    const int64_t count = test_count(32, 500);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 48);
        test_sampled s = test_sample(&field, test_scalars[i / TEST_KIND_COUNT % 8], &random);
        qn_surface_options options = test_field_options(&field);
        qn_context *context = test_context(1);
        qn_volume *volume;
        qn_surface_report report;
        qn_error error;
        char name[128];
        options.device = QN_DEVICE_CPU;
        options.isovalues = &s.iso;
        options.keep_doubled = i % 4 == 0 || options.open;
        options.halfedges = i % 3 != 0;
        options.skip_normals = i % 9 == 8;
        options.simplify = i % 5 < 2;
        snprintf(name, sizeof name, "volume %lld (%s)", (long long)i, field.name);
        assert_int_equal(qn_volume_create(context, &s.grid, NULL, NULL, &volume, &error), QN_OK);
        qn_mesh *mesh = test_cpu_surface(context, volume, &options, &report);
        if (report.cells > 0)
            for (int32_t layers = 1; layers <= 3; ++layers)
                compare(name, volume, context, s.iso, &options, mesh, &report, layers,
                        random.state);
        met.vertices += report.vertices;
        met.doubled += report.repaired_edges;
        met.nonfinite += report.nan_samples + report.infinite_samples;
        qn_mesh_destroy(mesh);
        qn_volume_destroy(volume);
        test_context_end(context);
        free(s.samples);
        test_field_free(&field);
    }
    printf("%lld volumes, %lld vertices, %lld repaired edges, %lld borders of slabs, %lld "
           "non-finite samples: the same bytes\n",
           (long long)count, (long long)met.vertices, (long long)met.doubled,
           (long long)met.borders, (long long)met.nonfinite);
    assert_true(met.vertices > 10000 && met.doubled > 100 && met.borders > count);
}

/* Less and less memory: more and more slabs, until one layer is too much. */
static void memory_decides_the_slabs(void **state) {
    (void)state;
    enum { N = 20, LENGTH = 90 };
    test_random random = {11};
    float *samples = test_alloc(N * N * LENGTH, sizeof *samples);
    for (int64_t n = 0; n < N * N * LENGTH; ++n)
        samples[n] = (float)(test_random_unit(&random) - (n % 5 ? 0.2 : 0.8));
    const qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {N, N, LENGTH}};
    qn_context *context = test_context(2);
    qn_volume *volume;
    qn_surface_options options;
    qn_surface_report report[2];
    qn_error error;
    test_cpu_device cpu;
    assert_int_equal(qn_volume_create(context, &grid, NULL, NULL, &volume, &error), QN_OK);
    qn_surface_options_init(&options);
    options.halfedges = true;
    options.device = QN_DEVICE_CPU;
    qn_mesh *mesh = test_cpu_surface(context, volume, &options, report);
    int32_t slabs = 0, different = 0;
    qn_status status = QN_OK;
    test_cpu_device_init(&cpu, 5);
    for (int64_t limit = 0; status == QN_OK; limit = cpu.most * 9 / 10) {
        qn_mesh *found;
        test_cpu_device_init(&cpu, 5);
        cpu.limit = limit;
        status = qni_gpu_host_surface(context, &cpu.device, volume, 0, &options, 0, &found,
                                      report + 1, &error);
        assert_int_equal(cpu.bytes, 0);
        assert_true(limit == 0 || cpu.most <= limit);
        if (status != QN_OK)
            break;
        assert_true(test_hash_all(found) == test_hash_all(mesh));
        test_expect_report("less memory", report + 1, report);
        assert_true(report[1].device_slabs >= slabs);
        different += report[1].device_slabs != slabs;
        slabs = report[1].device_slabs;
        qn_mesh_destroy(found);
    }
    printf("up to %d slabs; then: %s\n", (int)slabs, error.message);
    assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
    assert_int_equal(slabs, (LENGTH + 2 - 1 + 7) / 8);
    assert_true(different >= 4);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
    free(samples);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_do_not_depend_on_slabs),
        cmocka_unit_test(memory_decides_the_slabs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
