// SPDX-License-Identifier: MIT
/* A level set of a ball in a lattice of N^3 samples, made leaf by leaf, and its surface: leaves,
 * quads, seconds, and the most memory held. Usage: bench_sparse [N] [threads]; N is 4096. */
#include <qn/qn.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

static const double half_width = 3;

typedef struct band {
    int32_t (*origins)[3];
    float (*values)[512];
    int64_t count, capacity;
} band;

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Whether the band comes into a block, by the nearest and the farthest of its samples. */
static bool meets(const int32_t at[3], double radius) {
    double near = 0, far = 0;
    for (int a = 0; a < 3; ++a) {
        const double low = at[a], high = low + 7;
        const double nearest = low > 0 ? low : high < 0 ? high : 0;
        const double farthest = fabs(low) > fabs(high) ? low : high;
        near += nearest * nearest;
        far += farthest * farthest;
    }
    return sqrt(near) < radius + half_width && sqrt(far) > radius - half_width;
}

static void fill(float values[512], const int32_t at[3], double radius) {
    for (int n = 0; n < 512; ++n) {
        const double i = at[0] + (n & 7), j = at[1] + (n >> 3 & 7), k = at[2] + (n >> 6);
        const double d = sqrt(i * i + j * j + k * k) - radius;
        values[n] = (float)fmax(-half_width, fmin(half_width, d));
    }
}

/* Counts the leaves, or fills them once there is room. */
static int64_t make_band(int32_t blocks, double radius, band *b) {
    int64_t count = 0;
    for (int32_t z = -blocks; z < blocks; ++z)
        for (int32_t y = -blocks; y < blocks; ++y)
            for (int32_t x = -blocks; x < blocks; ++x) {
                const int32_t at[3] = {8 * x, 8 * y, 8 * z};
                if (!meets(at, radius))
                    continue;
                if (b->origins) {
                    memcpy(b->origins[count], at, sizeof at);
                    fill(b->values[count], at, radius);
                }
                ++count;
            }
    return count;
}

int main(int argument_count, char **arguments) {
    const int32_t size = argument_count > 1 ? atoi(arguments[1]) : 4096;
    const double radius = size / 2 - 8.3, start = seconds();
    band b = {NULL, NULL, 0, 0};
    qn_context_options options;
    qn_context *context;
    qn_volume *volume;
    qn_mesh *mesh;
    qn_surface_report report;
    qn_error error;
    struct rusage use;
    b.count = make_band(size / 16, radius, &b);
    b.origins = malloc((size_t)b.count * sizeof *b.origins);
    b.values = malloc((size_t)b.count * sizeof *b.values);
    if (!b.origins || !b.values)
        return 5;
    make_band(size / 16, radius, &b);
    const double made = seconds();
    qn_context_options_init(&options);
    options.threads = argument_count > 2 ? atoi(arguments[2]) : 1;
    const qn_sparse_grid grid = {.scalar = QN_F32,
                                 .leaf_count = b.count,
                                 .origins = (const int32_t(*)[3])b.origins,
                                 .values = b.values,
                                 .background = half_width,
                                 .kind = QN_SPARSE_LEVEL_SET};
    if (qn_context_create(&options, &context, &error) != QN_OK ||
        qn_volume_create_sparse(context, &grid, NULL, NULL, &volume, &error) != QN_OK ||
        qn_surface(context, volume, NULL, &mesh, &report, &error) != QN_OK) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    getrusage(RUSAGE_SELF, &use);
    printf("samples,leaves,leaf_mb,vertices,quads,seconds_band,seconds_surface,scratch_mb,peak_mb\n"
           "%d^3,%lld,%lld,%lld,%lld,%.2f,%.2f,%lld,%ld\n",
           (int)size, (long long)b.count, (long long)(b.count >> 9), (long long)report.vertices,
           (long long)report.quads, made - start, seconds() - made,
           (long long)(report.scratch_bytes >> 20), use.ru_maxrss >> 10);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    qn_context_destroy(context);
    free(b.origins);
    free(b.values);
    return 0;
}
