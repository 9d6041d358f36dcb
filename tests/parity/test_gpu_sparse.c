// SPDX-License-Identifier: MIT
/* A sparse volume goes to a device as a pool of leaves and rows of runs, and gives the bytes and
 * the report of the CPU's sparse path. */
#include "gpu/host.h"
#include "lib/random_sparse.h"
#include "parity/cases.h"
#include "parity/cpu_device.h"

#include <math.h>

/* What all volumes together had: a test on nothing would pass. */
static struct { int64_t vertices, doubled, tiles, nonfinite; } met;

static void compare(const char *name, const qn_sparse_grid *grid, double iso,
                    const qn_surface_options *options, uint64_t shuffle) {
    qn_context *context = test_context(2);
    test_cpu_device cpu;
    qn_surface_report report[2];
    qn_volume *volume;
    qn_mesh *mesh[2];
    qn_error error;
    if (qn_volume_create_sparse(context, grid, NULL, NULL, &volume, &error) != QN_OK)
        fail_msg("%s: %s", name, error.message);
    mesh[0] = test_cpu_surface(context, volume, options, report);
    test_cpu_device_init(&cpu, shuffle);
    assert_null(qni_gpu_cannot(volume, options));
    if (qni_gpu_host_surface(context, &cpu.device, volume, iso, options, 0, mesh + 1, report + 1,
                             &error) != QN_OK)
        fail_msg("%s: %s", name, error.message);
    test_expect_mesh(name, mesh[1], mesh[0]);
    test_expect_report(name, report + 1, report);
    assert_int_equal(cpu.bytes, 0);
    met.vertices += report[0].vertices;
    met.doubled += report[0].repaired_edges;
    met.tiles += grid->tile_count;
    met.nonfinite += report[0].nan_samples + report[0].infinite_samples;
    qn_mesh_destroy(mesh[0]);
    qn_mesh_destroy(mesh[1]);
    qn_volume_destroy(volume);
    test_context_end(context);
}

/* Samples that are no numbers, in leaves and in one tile. */
static void spoil(test_sparse *sparse, test_random *random, int64_t i) {
    for (int64_t n = 0; n < sparse->grid.leaf_count * 512; ++n) {
        const double odd = n % 3 ? (double)NAN : n % 2 ? (double)INFINITY : -(double)INFINITY;
        if (test_random_range(random, 0, 199) != 0)
            continue;
        if (sparse->grid.scalar == QN_F32)
            ((float *)(uintptr_t)sparse->grid.values)[n] = (float)odd;
        else if (sparse->grid.scalar == QN_F64)
            ((double *)(uintptr_t)sparse->grid.values)[n] = odd;
    }
    const bool real = sparse->grid.scalar == QN_F32 || sparse->grid.scalar == QN_F64;
    if (real && sparse->grid.tile_count && i % 4 == 0)
        ((qn_sparse_tile *)(uintptr_t)sparse->grid.tiles)->value = (double)NAN;
}

static void bytes_are_those_of_the_cpu(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    const int64_t count = test_count(40, 150);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        const qn_scalar scalar = i % 2 ? QN_F32 : (qn_scalar)(i / 2 % QN_SCALAR_COUNT);
        test_sparse sparse =
            test_random_sparse(&random, (test_kind)(i % TEST_KIND_COUNT), scalar, 4);
        qn_surface_options options;
        char name[64];
        qn_surface_options_init(&options);
        options.isovalues = &sparse.iso;
        options.isovalue_count = 1;
        options.device = QN_DEVICE_CPU;
        options.inside = test_random_bits(&random) & 1 ? QN_INSIDE_ABOVE : QN_INSIDE_BELOW;
        options.halfedges = i % 4 != 0;
        options.keep_doubled = i % 3 == 0;
        options.open = i % 5 == 0;
        options.relax = i % 7 == 0 ? 2 : 0;
        options.simplify = i % 8 < 3;
        if (i % 6 == 5)
            spoil(&sparse, &random, i);
        snprintf(name, sizeof name, "sparse volume %lld (%s)", (long long)i,
                 qn_scalar_name(scalar));
        compare(name, &sparse.grid, sparse.iso, &options, random.state);
        test_sparse_free(&sparse);
    }
    printf("%lld sparse volumes, %lld vertices, %lld repaired edges, %lld tiles, %lld non-finite "
           "samples: the same bytes\n",
           (long long)count, (long long)met.vertices, (long long)met.doubled, (long long)met.tiles,
           (long long)met.nonfinite);
    assert_true(met.vertices > 10000 && met.doubled > 100 && met.tiles > 10 && met.nonfinite > 10);
}

/* 4096^3 samples in one tile, and specks far off: memory goes with what there is. */
static void huge_tiles_take_little_memory(void **state) {
    (void)state;
    const qn_sparse_tile tiles[3] = {{{0, 0, 0}, {4096, 4096, 4096}, 1, true},
                                     {{-8000000, 64, 0}, {8, 8, 8}, 3, true},
                                     {{4096, 0, 8000000}, {8, 8, 8}, 3, true}};
    const qn_sparse_grid grid = {
        .scalar = QN_F32, .tile_count = 3, .tiles = tiles, .kind = QN_SPARSE_FOG};
    const double iso = 2;
    qn_context *context = test_context(2);
    test_cpu_device cpu;
    qn_surface_options options;
    qn_surface_report report;
    qn_volume *volume;
    qn_mesh *mesh;
    qn_error error;
    qn_surface_options_init(&options);
    options.inside = QN_INSIDE_ABOVE;
    test_cpu_device_init(&cpu, 3);
    cpu.limit = INT64_C(64) << 20; /* 262,145 rows of runs, and hardly more */
    assert_int_equal(qn_volume_create_sparse(context, &grid, NULL, NULL, &volume, &error), QN_OK);
    if (qni_gpu_host_surface(context, &cpu.device, volume, iso, &options, 0, &mesh, &report,
                             &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_int_equal(report.active_leaves, 16);
    assert_int_equal(report.quads, 2 * 6 * 64);
    qn_mesh_destroy(mesh);
    cpu.limit = 1 << 16;
    assert_int_equal(qni_gpu_host_surface(context, &cpu.device, volume, iso, &options, 0, &mesh,
                                          &report, &error),
                     QN_ERROR_OUT_OF_MEMORY);
    assert_int_equal(cpu.bytes, 0);
    qn_volume_destroy(volume);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_those_of_the_cpu),
        cmocka_unit_test(huge_tiles_take_little_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
