// SPDX-License-Identifier: MIT
/* Statistics: exact against a plain count for every type, stride and byte order; the same for every
 * thread count; suggestions that make a surface on synthetic and real volumes. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "lib/failing.h"
#include "lib/support.h"
#include "lib/volume_files.h"

static qn_context *make_context(int32_t threads) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = threads;
    qn_context *context;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    return context;
}

static void get(qn_context *context, const qn_grid *grid, qn_volume_statistics *statistics) {
    qn_volume *volume;
    qn_error error = {.message = ""};
    if (qn_volume_create(context, grid, NULL, NULL, &volume, &error) != QN_OK ||
        qn_volume_get_statistics(context, volume, statistics, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_volume_destroy(volume);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
}

static int64_t histogram_total(const qn_volume_statistics *statistics) {
    int64_t total = 0;
    for (int b = 0; b < QN_HISTOGRAM_BINS; ++b)
        total += statistics->histogram[b];
    return total;
}

/* ---- against a plain count ---- */

static void every_type_stride_and_byte_order(void **state) {
    (void)state;
    qn_context *context = make_context(2);
    enum { X = 37, Y = 5, Z = 7, COUNT = X * Y * Z };
    for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar)
        for (int way = 0; way < 8; ++way) {
            int64_t size = (int64_t)qn_scalar_size((qn_scalar)scalar);
            int64_t gap = way & 2 ? 3 * size + 1 : size; /* strided and not aligned */
            bool big = (way & 1) != qni_machine_is_big_endian();
            unsigned char *samples = calloc(COUNT, (size_t)gap);
            double low = 1e300, high = -1e300, sum = 0;
            for (int64_t n = 0; n < COUNT; ++n) {
                bytes one = {.size = 0};
                double value = block_value((qn_scalar)scalar, n);
                put_scalar(&one, (qn_scalar)scalar, value, big);
                memcpy(samples + (way & 4 ? COUNT - 1 - n : n) * gap, one.data, (size_t)size);
                low = fmin(low, value);
                high = fmax(high, value);
                sum += value;
            }
            qn_grid grid = {.samples = way & 4 ? samples + (COUNT - 1) * gap : samples,
                            .scalar = (qn_scalar)scalar,
                            .swapped = way & 1,
                            .size = {X, Y, Z},
                            .stride = {gap, gap * X, gap * X * Y},
                            .slope = -0.5,
                            .intercept = 3};
            for (int a = 0; way & 4 && a < 3; ++a)
                grid.stride[a] = -grid.stride[a];
            qn_volume_statistics statistics;
            get(context, &grid, &statistics);
            assert_int_equal(statistics.sample_count, COUNT);
            assert_true(statistics.minimum == -0.5 * high + 3);
            assert_true(statistics.maximum == -0.5 * low + 3);
            assert_true(fabs(statistics.mean - (-0.5 * sum / COUNT + 3)) <=
                        1e-12 * fabs(high - low));
            assert_int_equal(histogram_total(&statistics), COUNT);
            int64_t bins[QN_HISTOGRAM_BINS] = {0};
            for (int64_t n = 0; n < COUNT;
                 ++n) { /* the negative slope turns the stored order round */
                double place = (block_value((qn_scalar)scalar, n) - low) / (high - low);
                ++bins[QN_HISTOGRAM_BINS - 1 -
                       (int)fmin(place * QN_HISTOGRAM_BINS, QN_HISTOGRAM_BINS - 1)];
            }
            int64_t moved =
                0; /* rounding may move a sample over the edge it lies on, in wide types */
            for (int b = 0; b < QN_HISTOGRAM_BINS; ++b)
                moved += llabs(bins[b] - statistics.histogram[b]);
            assert_true(moved <= (size <= 2 ? 0 : COUNT / 50));
            free(samples);
        }
    qn_context_destroy(context);
}

static void not_a_number_and_infinity_are_counted_apart(void **state) {
    (void)state;
    qn_context *context = make_context(2);
    float samples[4 * 5 * 50];
    for (int n = 0; n < 1000; ++n)
        samples[n] = n % 10 == 0   ? NAN
                     : n % 10 == 1 ? INFINITY
                     : n % 10 == 2 ? -INFINITY
                                   : (float)(n % 10);
    samples[7] = 0.25f;
    qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {50, 5, 4}};
    qn_volume_statistics statistics;
    get(context, &grid, &statistics);
    assert_int_equal(statistics.nan_count, 100);
    assert_int_equal(statistics.infinite_count, 200);
    assert_true(statistics.minimum == 0.25 && statistics.maximum == 9);
    assert_true(fabs(statistics.mean - (4200 - 6.75) / 700) < 1e-12);
    assert_int_equal(histogram_total(&statistics), 700);

    for (int n = 0; n < 1000; ++n)
        samples[n] = NAN;
    get(context, &grid, &statistics);
    assert_int_equal(statistics.nan_count, 1000);
    assert_true(isnan(statistics.minimum) && isnan(statistics.mean) && isnan(statistics.suggested));
    assert_int_equal(statistics.suggestion_count, 0);
    qn_context_destroy(context);
}

static void extreme_numbers_do_not_overflow(void **state) {
    (void)state;
    qn_context *context = make_context(1);
    static const double ranges[][2] = {{-DBL_MAX, DBL_MAX},
                                       {0, 5e-324},
                                       {1e-310, 2e-310},
                                       {-1e-300, DBL_MAX},
                                       {1, 1 + DBL_EPSILON}};
    for (size_t r = 0; r < sizeof ranges / sizeof ranges[0]; ++r) {
        double samples[64];
        for (int n = 0; n < 64; ++n)
            samples[n] = ranges[r][n % 2];
        qn_grid grid = {.samples = samples, .scalar = QN_F64, .size = {4, 4, 4}};
        qn_volume_statistics statistics;
        get(context, &grid, &statistics);
        assert_true(statistics.minimum == ranges[r][0] && statistics.maximum == ranges[r][1]);
        assert_true(isfinite(statistics.mean));
        assert_int_equal(histogram_total(&statistics), 64);
    }
    qn_context_destroy(context);
}

static void the_same_for_every_thread_count(void **state) {
    (void)state;
    enum { N = 48 };
    float *samples = malloc(sizeof(float) * N * N * N);
    uint32_t random = 1;
    for (int n = 0; n < N * N * N; ++n) {
        random = random * 1664525u + 1013904223u;
        samples[n] = (float)random * 1e-3f - 1e5f;
    }
    qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {N, N, N}};
    qn_volume_statistics first;
    for (int32_t threads = 1; threads <= 8; ++threads) {
        qn_context *context = make_context(threads);
        qn_volume_statistics statistics;
        get(context, &grid, &statistics);
        if (threads == 1)
            first = statistics;
        assert_memory_equal(&statistics, &first, sizeof first);
        qn_context_destroy(context);
    }
    free(samples);
}

/* ---- suggestions ---- */

static void check_suggestions(const qn_volume_statistics *statistics) {
    assert_true(statistics->suggestion_count >= 1 && statistics->suggestion_count <= 3);
    bool among = false;
    for (int s = 0; s < statistics->suggestion_count; ++s) {
        assert_true(statistics->suggestions[s] > statistics->minimum &&
                    statistics->suggestions[s] < statistics->maximum);
        assert_true(s == 0 || statistics->suggestions[s] > statistics->suggestions[s - 1]);
        among |= statistics->suggestions[s] == statistics->suggested;
    }
    assert_true(among);
}

static void two_classes_are_parted_in_the_middle(void **state) {
    (void)state;
    qn_context *context = make_context(1);
    uint8_t samples[1000];
    for (int n = 0; n < 1000; ++n)
        samples[n] = n % 4 == 0 ? 200 : 100;
    qn_grid grid = {.samples = samples, .scalar = QN_U8, .size = {10, 10, 10}};
    qn_volume_statistics statistics;
    get(context, &grid, &statistics);
    check_suggestions(&statistics);
    assert_true(fabs(statistics.suggested - 150) <= 1);
    assert_true(statistics.suggested != floor(statistics.suggested));

    for (int n = 0; n < 1000; ++n)
        samples[n] = 7; /* all alike: there is no surface to suggest */
    get(context, &grid, &statistics);
    assert_int_equal(statistics.suggestion_count, 0);
    assert_true(isnan(statistics.suggested));
    qn_context_destroy(context);
}

static void a_far_off_sample_does_not_spoil_the_scale(void **state) {
    (void)state;
    qn_context *context = make_context(1);
    enum { N = 40 };
    float *samples = malloc(sizeof(float) * N * N * N);
    for (int n = 0; n < N * N * N; ++n)
        samples[n] = (n % 3 == 0 ? 2.0f : 1.0f) + (float)(n % 7) * 0.01f;
    samples[5] = 1e30f;
    qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {N, N, N}};
    qn_volume_statistics statistics;
    get(context, &grid, &statistics);
    assert_true(statistics.suggested > 1.1 && statistics.suggested < 2);
    free(samples);
    qn_context_destroy(context);
}

static void a_distance_has_its_surface_at_zero(void **state) {
    (void)state;
    qn_context *context = make_context(1);
    enum { N = 32 };
    float *samples = malloc(sizeof(float) * N * N * N);
    for (int n = 0; n < N * N * N; ++n) {
        double x = n % N - 15.5, y = n / N % N - 15.5, z = n / N / N - 15.5;
        samples[n] = (float)(sqrt(x * x + y * y + z * z) - 10);
    }
    qn_grid grid = {.samples = samples, .scalar = QN_F32, .size = {N, N, N}};
    qn_volume_statistics statistics;
    get(context, &grid, &statistics);
    assert_true(statistics.suggested == 0);
    check_suggestions(&statistics);
    free(samples);
    qn_context_destroy(context);
}

static void memory_may_be_missing(void **state) {
    (void)state;
    qn_context *context = make_context(1);
    uint8_t samples[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    qn_grid grid = {.samples = samples, .scalar = QN_U8, .size = {2, 2, 2}};
    qn_volume *volume;
    assert_int_equal(qn_volume_create(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    for (int64_t limit = 1;; ++limit) {
        test_failing memory = {.allocations_left = limit, .looks_left = -1};
        qn_context *none = test_failing_context(&memory);
        assert_non_null(none);
        qn_volume_statistics statistics;
        qn_status status = qn_volume_get_statistics(none, volume, &statistics, NULL);
        assert_int_equal(qn_context_memory(none).current_bytes, 0);
        qn_context_destroy(none);
        if (status == QN_OK)
            break;
        assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
        assert_true(limit < 20);
    }
    qn_volume_destroy(volume);
    qn_context_destroy(context);
}

/* ---- real volumes ---- */

static const struct real_volume {
    const char *name;
    int64_t size[3];
    qn_scalar scalar;
    bool big;
    double low,
        high; /* the suggestion lies between, for a surface as the data's description means it */
} real_volumes[] = {
    {"aneurism_xa_256x256x256_u8.raw.gz", {256, 256, 256}, QN_U8, false, 30, 180},
    {"boston_teapot_ct_256x256x174_u8.raw.gz", {256, 256, 174}, QN_U8, false, 20, 130},
    {"brainsmall_female_mri_128x128x84_u8.raw.gz", {128, 128, 84}, QN_U8, false, 20, 95},
    {"carotid_mra_76x49x45_f32le.raw.gz", {76, 49, 45}, QN_F32, false, 150, 350},
    {"ch2.nii.gz", {0}, QN_U8, false, 30, 100},
    {"ch2better.nii.gz", {0}, QN_U8, false, 1, 100},
    {"cranium_ct_256x256x108_i16le.raw.gz", {256, 256, 108}, QN_I16, false, 150, 700},
    {"cthead_male_ct_256x256x113_u16be.raw.gz", {256, 256, 113}, QN_U16, true, 1000, 1800},
    {"engine_ct_256x256x128_u8.raw.gz", {256, 256, 128}, QN_U8, false, 50, 180},
    {"eun.nii.gz", {0}, QN_U8, false, 20, 100},
    {"headsq_ct_64x64x93_i16le.raw.gz", {64, 64, 93}, QN_I16, false, 1000, 1800},
    {"MR_Gd.nii.gz", {0}, QN_U8, false, 60, 450},
    {"neghip_64x64x64_u8.raw.gz", {64, 64, 64}, QN_U8, false, 40, 180},
    {"noisy_synthetic_256x256x256_u16le.raw.gz", {256, 256, 256}, QN_U16, false, 1000, 2500},
    {"skull_2.9_64x64x64_f32le.inr", {0}, QN_F32, false, 0.7, 3.5},
    {"tooth_103x94x161_u8.nrrd", {0}, QN_U8, false, 100, 200},
    {"torus_sdfgrid_40x40x40_f32le.vol", {0}, QN_F32, false, 0, 0},
};

static void check_real(qn_context *context, const struct real_volume *real) {
    char name[128], path[512];
    snprintf(name, sizeof name, "volumes/%s", real->name);
    if (!test_data_path(name, path, sizeof path))
        return;
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    memcpy(options.raw_size, real->size, sizeof real->size);
    options.raw_scalar = real->scalar;
    options.raw_big_endian = real->big;
    qn_volume *volume;
    qn_error error = {.message = ""};
    qn_status status = qn_volume_read(context, path, &options, &volume, &error);
    if (status == QN_ERROR_UNSUPPORTED)
        return;
    if (status != QN_OK)
        fail_msg("%s", error.message);
    qn_volume_statistics statistics;
    assert_int_equal(qn_volume_get_statistics(context, volume, &statistics, NULL), QN_OK);
    check_suggestions(&statistics);
    if (statistics.suggested < real->low || statistics.suggested > real->high)
        fail_msg("%s: %g is suggested", real->name, statistics.suggested);
    const qn_grid *grid = qn_volume_grid(volume);
    int64_t above = 0;
    for (int64_t k = 0; k < grid->size[2]; k += 2)
        for (int64_t j = 0; j < grid->size[1]; j += 2)
            for (int64_t i = 0; i < grid->size[0]; i += 2)
                above += qni_grid_value(grid, i, j, k) >= statistics.suggested;
    double share = 8.0 * (double)above / (double)statistics.sample_count;
    if (real->low < real->high && (share < 0.003 || share > 0.6))
        fail_msg("%s: %g of the samples lie above %g", real->name, share, statistics.suggested);
    qn_volume_destroy(volume);
}

static void real_volumes_get_sensible_suggestions(void **state) {
    (void)state;
    char path[512];
    if (!test_data_path("volumes/ch2.nii.gz", path, sizeof path))
        skip();
    qn_context *context = make_context(0);
    for (size_t v = 0; v < sizeof real_volumes / sizeof real_volumes[0]; ++v)
        check_real(context, &real_volumes[v]);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_stride_and_byte_order),
        cmocka_unit_test(not_a_number_and_infinity_are_counted_apart),
        cmocka_unit_test(extreme_numbers_do_not_overflow),
        cmocka_unit_test(the_same_for_every_thread_count),
        cmocka_unit_test(two_classes_are_parted_in_the_middle),
        cmocka_unit_test(a_far_off_sample_does_not_spoil_the_scale),
        cmocka_unit_test(a_distance_has_its_surface_at_zero),
        cmocka_unit_test(memory_may_be_missing),
        cmocka_unit_test(real_volumes_get_sensible_suggestions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
