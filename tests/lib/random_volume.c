// SPDX-License-Identifier: MIT
/* Random fields: all reproducible from the seed. */
#include "lib/random_volume.h"

#include <math.h>

const char *test_kind_name(test_kind kind) {
    static const char *const names[TEST_KIND_COUNT] = {
        "gaussian", "heavy-tailed", "small-integers", "checkerboard", "smoothed",
        "binary",   "thousand",     "symmetric",      "near-ties",    "sparse"};
    return names[kind];
}

static double kind_iso(test_kind kind, test_random *random) {
    switch (kind) {
    case TEST_BINARY:
        return 0.5;
    case TEST_THOUSAND:
        return 1000;
    case TEST_SMALL_INTEGERS:
        return (double)test_random_range(random, -1, 1);
    default:
        return 0;
    }
}

double test_random_sample(test_random *random, test_kind kind) {
    double u = 2 * test_random_unit(random) - 1;
    switch (kind) {
    case TEST_HEAVY_TAILED:
        return u * u * u * u * u;
    case TEST_SMALL_INTEGERS:
        return (double)test_random_range(random, -2, 2);
    case TEST_BINARY:
        return (double)test_random_range(random, 0, 1);
    case TEST_THOUSAND:
        return (double)(1000.0f + (float)u);
    case TEST_SYMMETRIC:
        return (double)(test_random_range(random, 1, 2) * (u < 0 ? -1 : 1));
    case TEST_NEAR_TIES:
        return (u < 0 ? -1 : 1) * (1 - 0x1p-53 * (double)test_random_range(random, 0, 9));
    case TEST_SPARSE:
        return test_random_range(random, 0, 299) == 0 ? test_random_gaussian(random) : -0.7;
    default:
        return test_random_gaussian(random);
    }
}

/* One pass of (1 2 1) / 4 along an axis, ends repeated. */
static void smooth_axis(test_field *field, int axis) {
    const int64_t *n = field->size;
    const int64_t step = axis == 0 ? 1 : axis == 1 ? n[0] : n[0] * n[1];
    double *copy = test_alloc((size_t)(n[0] * n[1] * n[2]), sizeof *copy);
    memcpy(copy, field->values, (size_t)(n[0] * n[1] * n[2]) * sizeof *copy);
    for (int64_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        int64_t place = i / step % n[axis];
        double before = copy[place > 0 ? i - step : i];
        double after = copy[place < n[axis] - 1 ? i + step : i];
        field->values[i] = (before + 2 * copy[i] + after) / 4;
    }
    free(copy);
}

void test_random_fill(test_field *field, test_random *random, test_kind kind) {
    const int64_t *n = field->size;
    snprintf(field->name, sizeof field->name, "%s %lldx%lldx%lld", test_kind_name(kind),
             (long long)n[0], (long long)n[1], (long long)n[2]);
    field->iso = kind_iso(kind, random);
    double noise = test_random_unit(random);
    for (int64_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        double sample = test_random_sample(random, kind);
        int64_t parity = (i % n[0] + i / n[0] % n[1] + i / n[0] / n[1]) & 1;
        field->values[i] = kind == TEST_CHECKERBOARD ? (parity ? 1 : -1) + noise * sample : sample;
    }
    if (kind == TEST_SMOOTHED_NOISE)
        for (int pass = 0; pass < 6; ++pass)
            smooth_axis(field, pass % 3);
}

test_field test_random_field(test_random *random, test_kind kind, int64_t largest) {
    int64_t n[3];
    for (int a = 0; a < 3; ++a) /* mostly small, so that borders count; 1 sample thick too */
        n[a] = test_random_range(random, 0, 19) == 0 ? 1
               : test_random_range(random, 0, 2) == 0
                   ? test_random_range(random, 2, largest)
                   : test_random_range(random, 2, (largest + 3) / 2);
    test_field field = test_field_make(n[0], n[1], n[2]);
    test_random_fill(&field, random, kind);
    field.inside = test_random_bits(random) & 1 ? QN_INSIDE_ABOVE : QN_INSIDE_BELOW;
    field.open = test_random_bits(random) & 1;
    if (test_random_bits(random) & 1)
        test_field_random_matrix(&field, random);
    test_field_prepare(&field);
    return field;
}
