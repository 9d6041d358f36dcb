// SPDX-License-Identifier: MIT
/* Analytic fields and their samples. */
#include "lib/analytic.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

static double gen2(double x, double y, double z) {
    double r = x * x + y * y;
    return 2 * y * (y * y - 3 * x * x) * (1 - z * z) + r * r - (9 * z * z - 1) * (1 - z * z);
}

static double iwp(double x, double y, double z) { /* of the cosines */
    return x * y + y * z + z * x - x * y * z;
}

static double sphere(double x, double y, double z) {
    return sqrt(x * x + y * y + z * z) - 0.73;
}

static double torus(double x, double y, double z) {
    double ring = sqrt(x * x + y * y) - 0.61;
    return sqrt(ring * ring + z * z) - 0.22;
}

static double gyroid(double x, double y, double z) {
    return sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x) - 0.1;
}

static double metaballs(double x, double y, double z) {
    double a = (x - 0.4) * (x - 0.4) + y * y + z * z, b = (x + 0.37) * (x + 0.37) + y * y + z * z;
    return 3.6 - 0.25 / (a + 0.01) - 0.25 / (b + 0.01);
}

static const test_analytic fields[] = {
    {"gen2", -2, 4, gen2, 4},
    {"iwp", 0, 10.02 * 3.14159265358979323846, iwp, 4},
    {"sphere", -1, 2, sphere, 1},
    {"torus", -1, 2, torus, 1},
    {"gyroid", 0.1, 13, gyroid, 1.5},
    {"metaballs", -1, 2, metaballs, 4},
    {NULL, 0, 0, NULL, 0},
};

const test_analytic *test_analytic_all(void) {
    return fields;
}

const test_analytic *test_analytic_find(const char *name) {
    for (const test_analytic *field = fields; field->name; ++field)
        if (strcmp(field->name, name) == 0)
            return field;
    return NULL;
}

double test_analytic_iso(qn_scalar scalar) {
    return scalar == QN_U8    ? 127.5
           : scalar == QN_U16 ? 32767.5
           : scalar == QN_U32 ? 2147483647.5
                              : 0;
}

static double quantised(double value, double scale, double low, double high) {
    double middle = (low + high) / 2, step = (high - low) / 2;
    return fmin(fmax(floor(middle + step * value / scale + 0.5), low), high);
}

static void store(void *samples, int64_t at, qn_scalar scalar, double value, double scale) {
    switch (scalar) {
    case QN_U8:
        ((uint8_t *)samples)[at] = (uint8_t)quantised(value, scale, 0, UINT8_MAX);
        break;
    case QN_I8:
        ((int8_t *)samples)[at] = (int8_t)quantised(value, scale, -INT8_MAX, INT8_MAX);
        break;
    case QN_U16:
        ((uint16_t *)samples)[at] = (uint16_t)quantised(value, scale, 0, UINT16_MAX);
        break;
    case QN_I16:
        ((int16_t *)samples)[at] = (int16_t)quantised(value, scale, -INT16_MAX, INT16_MAX);
        break;
    case QN_U32:
        ((uint32_t *)samples)[at] = (uint32_t)quantised(value, scale, 0, UINT32_MAX);
        break;
    case QN_I32:
        ((int32_t *)samples)[at] = (int32_t)quantised(value, scale, -INT32_MAX, INT32_MAX);
        break;
    case QN_F32:
        ((float *)samples)[at] = (float)value;
        break;
    default:
        ((double *)samples)[at] = value;
        break;
    }
}

void *test_analytic_samples(const test_analytic *analytic, int64_t n, qn_scalar scalar) {
    void *samples = test_alloc((size_t)(n * n * n), qn_scalar_size(scalar));
    double *place = test_alloc((size_t)n, sizeof *place);
    /* gen2 as in the issue: -2 + 4 i / (n - 1); iWP: its function takes the cosines of the places
     */
    for (int64_t i = 0; i < n; ++i) {
        place[i] = analytic->first + analytic->span * (double)i / (double)(n - 1);
        if (analytic->value == iwp)
            place[i] = cos(10.02 * pi * (double)i / (double)(n - 1));
    }
    for (int64_t k = 0; k < n; ++k)
        for (int64_t j = 0; j < n; ++j)
            for (int64_t i = 0; i < n; ++i)
                store(samples, i + n * (j + n * k), scalar,
                      analytic->value(place[i], place[j], place[k]), analytic->scale);
    free(place);
    return samples;
}

qn_volume *test_analytic_volume(qn_context *context, const test_analytic *analytic, int64_t n,
                                qn_scalar scalar, void **samples_out) {
    *samples_out = test_analytic_samples(analytic, n, scalar);
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.samples = *samples_out;
    grid.scalar = scalar;
    grid.size[0] = grid.size[1] = grid.size[2] = n;
    qn_volume *volume;
    assert_int_equal(qn_volume_create(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    return volume;
}
