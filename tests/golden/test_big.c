// SPDX-License-Identifier: MIT
/* A volume of more than 2^31 samples: balls, one of them at the far corner, come out whole and at
 * their places, and the memory beside the mesh stays under half a byte a sample. Long run only. */
#include "lib/mesh_measure.h"

#include <math.h>

enum { NX = 2048, NY = 2048, NZ = 600 };

typedef struct ball {
    double x, y, z, radius;
} ball;

static const ball balls[] = {
    {30, 40, 25, 20.3},         {1024.5, 1000.25, 300, 60.7}, {2010, 2015, 565, 30.1},
    {2046.5, 1024, 511.7, 0.8}, {17.2, 2020, 580, 14.6},      {1500, 20, 513, 12.4},
};
enum { BALLS = sizeof balls / sizeof balls[0] };

static int64_t clamp_index(double at, int64_t size) {
    return at < 0 ? 0 : at >= (double)size ? size - 1 : (int64_t)at;
}

/* 127.5 is on the ball, 24 steps a voxel; all else stays 0 and is never touched. */
static void draw(uint8_t *samples, const ball *b) {
    double reach = b->radius + 6;
    for (int64_t k = clamp_index(b->z - reach, NZ); k <= clamp_index(b->z + reach, NZ); ++k)
        for (int64_t j = clamp_index(b->y - reach, NY); j <= clamp_index(b->y + reach, NY); ++j)
            for (int64_t i = clamp_index(b->x - reach, NX); i <= clamp_index(b->x + reach, NX);
                 ++i) {
                double dx = (double)i - b->x, dy = (double)j - b->y, dz = (double)k - b->z;
                double value = 127.5 + 24 * (b->radius - sqrt(dx * dx + dy * dy + dz * dz));
                samples[i + NX * (j + (int64_t)NY * k)] =
                    (uint8_t)fmin(fmax(floor(value + 0.5), 0), 255);
            }
}

static bool memory_is_there(int64_t needed) {
    long long kilobytes = 0;
    char line[256];
    FILE *file = fopen("/proc/meminfo", "r");
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "MemAvailable: %lld kB", &kilobytes) == 1)
            break;
    if (file)
        fclose(file);
    return kilobytes * 1024 >= needed;
}

/* Vertices within a voxel of a ball's surface; their number grows with its area. */
static int64_t vertices_on(const qn_mesh_view *view, const ball *b) {
    int64_t count = 0;
    for (int64_t v = 0; v < view->vertex_count; ++v) {
        const float *p = view->positions + 3 * v;
        double dx = (double)p[0] - b->x, dy = (double)p[1] - b->y, dz = (double)p[2] - b->z;
        count += fabs(sqrt(dx * dx + dy * dy + dz * dz) - b->radius) < 0.6;
    }
    return count;
}

static void check_mesh(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    test_edges edges = test_mesh_edges(mesh);
    double area, volume, expected = 0;
    test_mesh_area_volume(mesh, &area, &volume);
    int64_t found = 0;
    for (int b = 0; b < BALLS; ++b) {
        int64_t on = vertices_on(&view, &balls[b]);
        expected += 4.0 / 3 * 3.14159265358979 * pow(balls[b].radius, 3);
        assert_true(on > 0);
        found += on;
    }
    printf("%lld vertices, %lld quads, volume %.6g, expected %.6g\n", (long long)view.vertex_count,
           (long long)view.quad_count, volume, expected);
    assert_int_equal(found, view.vertex_count);
    assert_int_equal(edges.unbalanced, 0);
    assert_int_equal(test_mesh_pieces(mesh), BALLS);
    assert_int_equal(view.vertex_count - edges.count + view.quad_count, 2 * BALLS);
    assert_true(fabs(volume / expected - 1) < 0.005);
}

static void more_than_2_31_samples_work(void **state) {
    (void)state;
    const int64_t count = (int64_t)NX * NY * NZ;
    if (!test_is_long() || !memory_is_there(count + (INT64_C(5) << 29))) {
        printf("skipped: %s\n", test_is_long() ? "not enough memory" : "set QUOIN_LONG=1");
        skip();
    }
    uint8_t *samples = calloc((size_t)count, 1);
    assert_non_null(samples);
    for (int b = 0; b < BALLS; ++b)
        draw(samples, &balls[b]);
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.samples = samples;
    grid.scalar = QN_U8;
    grid.size[0] = NX, grid.size[1] = NY, grid.size[2] = NZ;
    const double iso = 127.5;
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = &iso;
    options.isovalue_count = 1;
    qn_context *context = test_context(0);
    qn_volume *volume;
    qn_mesh *mesh;
    qn_surface_report report;
    assert_int_equal(qn_volume_create(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    assert_int_equal(qn_surface(context, volume, &options, &mesh, &report, NULL), QN_OK);
    int64_t peak = qn_context_memory(context).peak_bytes;
    printf("%lld samples in %.2f s, most memory %.1f MB\n", (long long)count, report.seconds_total,
           1e-6 * (double)peak);
    assert_true(peak - report.output_bytes < count / 2);
    assert_int_equal(report.cells, (int64_t)(NX + 1) * (NY + 1) * (NZ + 1));
    check_mesh(mesh);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
    free(samples);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(more_than_2_31_samples_work)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
