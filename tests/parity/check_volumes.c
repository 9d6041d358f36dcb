// SPDX-License-Identifier: MIT
#include "parity/check_volumes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- random volumes -------------------------------------------------------------------------- */

static uint64_t state;

void check_seed(uint64_t seed) {
    state = seed;
}

static uint64_t random_bits(void) {
    uint64_t z = (state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

int64_t check_below(int64_t end) {
    return (int64_t)(random_bits() % (uint64_t)end);
}

static double unit(void) {
    return (double)(random_bits() >> 11) / 9007199254740992.0;
}

/* Values about -1 to 1 round 0. */
static double sample_of(int kind, int64_t i, int64_t j, int64_t k) {
    const double u = 2 * unit() - 1;
    switch (kind) {
    case 0:
        return u;
    case 1:
        return u * u * u * u * u;
    case 2:
        return (double)(check_below(5) - 2) / 2;
    case 3:
        return ((i + j + k) & 1 ? 1 : -1) * (0.2 + 0.1 * u);
    case 4:
        return sin(0.6 * (double)i) * cos(0.5 * (double)j) + sin(0.55 * (double)k) + 0.4 * u;
    default:
        return check_below(40) == 0 ? 1 : -1;
    }
}

static const char *const kinds[6] = {"noise",        "heavy tails", "small integers",
                                     "checkerboard", "noisy waves", "specks"};

check_volume check_random_volume(void) {
    static const qn_scalar scalars[4] = {QN_F32, QN_U16, QN_U8, QN_I16};
    const int kind = (int)check_below(6);
    check_volume v = {.kind = kinds[kind]};
    v.grid.scalar = scalars[check_below(4)];
    for (int a = 0; a < 3; ++a)
        v.grid.size[a] = 2 + check_below(32);
    const int64_t count = v.grid.size[0] * v.grid.size[1] * v.grid.size[2];
    const double middle = v.grid.scalar == QN_U8 ? 128 : v.grid.scalar == QN_U16 ? 2000 : 0;
    const double scale = v.grid.scalar == QN_F32 ? 1 : (double)(2 + check_below(60));
    v.iso = middle + (v.grid.scalar == QN_F32 || check_below(2) ? 0 : 0.5);
    v.samples = malloc((size_t)count * qn_scalar_size(v.grid.scalar));
    if (!v.samples)
        exit(1);
    for (int64_t n = 0; n < count; ++n) {
        const int64_t row = n / v.grid.size[0];
        double value = middle + scale * sample_of(kind, n % v.grid.size[0], row % v.grid.size[1],
                                                  row / v.grid.size[1]);
        switch (v.grid.scalar) {
        case QN_F32:
            ((float *)v.samples)[n] = check_below(4000) ? (float)value : NAN;
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
        {1 + unit(), 0.1, 0, 3}, {0, check_below(2) ? 1 : -1, 0.2, -1}, {0.3, 0, 1 + unit(), 2}};
    memcpy(v.grid.index_to_world, matrix, sizeof matrix);
    v.grid.index_to_world[3][3] = 1;
    return v;
}

/* ---- sparse ---------------------------------------------------------------------------------- */

static double value_at(const check_volume *v, int64_t n) {
    switch (v->grid.scalar) {
    case QN_F32:
        return (double)((const float *)v->samples)[n];
    case QN_U16:
        return ((const uint16_t *)v->samples)[n];
    case QN_U8:
        return ((const uint8_t *)v->samples)[n];
    default:
        return ((const int16_t *)v->samples)[n];
    }
}

/* One leaf of 8^3 samples, read round the volume's ends. */
static void fill_leaf(const check_volume *v, const int32_t origin[3], char *leaf) {
    const size_t size = qn_scalar_size(v->grid.scalar);
    for (int n = 0; n < 512; ++n) {
        const int64_t i = (origin[0] + (n & 7)) % v->grid.size[0],
                      j = (origin[1] + (n >> 3 & 7)) % v->grid.size[1],
                      k = (origin[2] + (n >> 6)) % v->grid.size[2];
        memcpy(leaf + (size_t)n * size,
               (const char *)v->samples +
                   (size_t)(i + v->grid.size[0] * (j + v->grid.size[1] * k)) * size,
               size);
    }
}

check_sparse check_make_sparse(const check_volume *v) {
    enum { SIDE = 4, MOST = SIDE * SIDE * SIDE };
    check_sparse s = {.origins = calloc(MOST, sizeof *s.origins),
                      .values = calloc(MOST, 512 * qn_scalar_size(v->grid.scalar))};
    if (!s.origins || !s.values)
        exit(1);
    for (int n = 0; n < MOST; ++n) {
        const int32_t origin[3] = {8 * (n % SIDE), 8 * (n / SIDE % SIDE), 8 * (n / SIDE / SIDE)};
        if (check_below(3) == 0)
            continue;
        const int64_t leaf = s.grid.leaf_count++;
        memcpy(s.origins[leaf], origin, sizeof origin);
        fill_leaf(v, origin, s.values + (size_t)leaf * 512 * qn_scalar_size(v->grid.scalar));
    }
    /* A tile far off, and a background, of values that the type has. */
    s.tile = (qn_sparse_tile){.origin = {-80, 16, 0}, .size = {24, 8, 16}, .active = true};
    s.tile.value = value_at(v, 0);
    s.grid.background = value_at(v, 1);
    if (isnan(s.tile.value) || isnan(s.grid.background))
        s.tile.value = s.grid.background = 0;
    s.grid.scalar = v->grid.scalar;
    s.grid.values = s.values;
    memcpy(s.grid.index_to_world, v->grid.index_to_world, sizeof s.grid.index_to_world);
    return s;
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

static double value_of(const check_bench_volume *b, const int64_t size[3], int64_t i, int64_t j,
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

double check_bench_iso(const check_bench_volume *b) {
    return b->kind == 2 ? 2048.5 : b->scalar == QN_F32 ? 0 : 32768;
}

void *check_bench_samples(const check_bench_volume *b, const int64_t size[3]) {
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
