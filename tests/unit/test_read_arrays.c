// SPDX-License-Identifier: MIT
/* NumPy, raw and Mitsuba files: types, orders, sizes, what options are for, and what is refused. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <unistd.h>

#include "lib/volume_files.h"

static qn_context *context;

static int set_up(void **state) {
    (void)state;
    return qn_context_create(NULL, &context, NULL);
}

static int tear_down(void **state) {
    (void)state;
    qn_context_destroy(context);
    return 0;
}

/* ---- NumPy ---- */

/* Element [i, j, k] of an array of shape 4 x 3 x 5. */
static double element(qn_scalar scalar, int64_t i, int64_t j, int64_t k) {
    return block_value(scalar, i + BLOCK_X * (j + BLOCK_Y * k));
}

static void put_array(bytes *file, qn_scalar scalar, bool big, bool fortran) {
    for (int64_t n = 0; n < BLOCK_COUNT; ++n)
        if (fortran)
            put_scalar(file, scalar, block_value(scalar, n), big);
        else
            put_scalar(file, scalar,
                       element(scalar, n / (BLOCK_Z * BLOCK_Y), n / BLOCK_Z % BLOCK_Y, n % BLOCK_Z),
                       big);
}

/* Every lattice sample lies where the array's element of that value belongs. */
static void expect_elements_in_place(const qn_volume *volume, qn_scalar scalar,
                                     const double spacing[3], const double origin[3]) {
    const qn_grid *grid = qn_volume_grid(volume);
    assert_int_equal(grid->scalar, scalar);
    assert_int_equal(grid->size[0] * grid->size[1] * grid->size[2], BLOCK_COUNT);
    assert_int_equal(grid->stride[0], qn_scalar_size(scalar)); /* lattice x is fastest in memory */
    for (int64_t n = 0; n < BLOCK_COUNT; ++n) {
        const int64_t at[3] = {n % grid->size[0], n / grid->size[0] % grid->size[1],
                               n / grid->size[0] / grid->size[1]};
        int64_t index[3];
        for (int row = 0; row < 3; ++row) {
            double world = grid->index_to_world[row][3];
            for (int a = 0; a < 3; ++a)
                world += grid->index_to_world[row][a] * (double)at[a];
            index[row] = (int64_t)round((world - origin[row]) / spacing[row]);
            assert_true((double)index[row] * spacing[row] + origin[row] == world);
        }
        assert_true(qni_grid_stored(grid, at[0], at[1], at[2]) ==
                    element(scalar, index[0], index[1], index[2]));
    }
}

static void npy_types_orders_and_versions(void **state) {
    (void)state;
    static const char *const names[] = {"u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"};
    const double spacing[3] = {0.5, 2, 4}, origin[3] = {1, -2, 3};
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    options.has_spacing = options.has_origin = true;
    memcpy(options.spacing, spacing, sizeof spacing);
    memcpy(options.origin, origin, sizeof origin);
    for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar)
        for (int way = 0; way < 12; ++way) {
            bool big = way & 1, fortran = way & 2;
            char text[128];
            bytes file = {.size = 0};
            snprintf(text, sizeof text,
                     "{'descr': '%c%s', 'fortran_order': %s, 'shape': (4, 3, 5), }  \n",
                     big ? '>' : '<', names[scalar], fortran ? "True" : "False");
            put_npy_header(&file, text, 1 + way / 4);
            put_array(&file, (qn_scalar)scalar, big, fortran);
            qn_volume *volume;
            qn_error error = {.message = ""};
            if (qni_volume_read_memory(context, "x", file.data, file.size, &options, &volume,
                                       &error))
                fail_msg("%s", error.message);
            expect_elements_in_place(volume, (qn_scalar)scalar, spacing, origin);
            assert_string_equal(qn_volume_format(volume), "npy");
            qn_volume_destroy(volume);
        }
}

static void npy_refusals_say_why(void **state) {
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"{'descr': '<i8', 'fortran_order': False, 'shape': (4, 3, 5)}", "<i8"},
        {"{'descr': '<f2', 'fortran_order': False, 'shape': (4, 3, 5)}", "<f2"},
        {"{'descr': '|O', 'fortran_order': False, 'shape': (4, 3, 5)}", "|O"},
        {"{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (4, 3, 5)}", "structured"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (60,)}", "1 axes"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': ()}", "0 axes"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3, 5, 1)}", "4 axes"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3, -5)}", "makes no sense"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3, 0)}", "makes no sense"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3, 6)}", "truncated"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4, 3", "makes no sense"},
        {"{'descr': '<f4', 'shape': (4, 3, 5)}", "makes no sense"},
        {"{'descr': '<f4", "no plain type"},
        {"", "no plain type"},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        bytes file = {.size = 0};
        put_npy_header(&file, cases[c].text, 1);
        put_array(&file, QN_F32, false, false);
        qn_volume *volume;
        qn_error error = {.message = ""};
        assert_int_equal(
            qni_volume_read_memory(context, "x.npy", file.data, file.size, NULL, &volume, &error),
            QN_ERROR_INPUT);
        if (!strstr(error.message, cases[c].words))
            fail_msg("'%s' where '%s' was meant", error.message, cases[c].words);
    }
}

/* ---- raw ---- */

static void raw_options(qn_volume_read_options *options, qn_scalar scalar) {
    qn_volume_read_options_init(options);
    options->raw_size[0] = BLOCK_X;
    options->raw_size[1] = BLOCK_Y;
    options->raw_size[2] = BLOCK_Z;
    options->raw_scalar = scalar;
}

static void raw_types_byte_orders_headers_and_gzip(void **state) {
    (void)state;
    char folder[] = "/tmp/quoin-raw-XXXXXX", path[256];
    assert_non_null(mkdtemp(folder));
    for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar)
        for (int way = 0; way < 8; ++way) {
            qn_volume_read_options options;
            raw_options(&options, (qn_scalar)scalar);
            options.raw_big_endian = way & 1;
            options.raw_header = way & 2 ? 11 : 0;
            bytes file = {.size = 0};
            put_zeros(&file, options.raw_header);
            put_block(&file, (qn_scalar)scalar, options.raw_big_endian);
            if (way & 4)
                pack_all(&file);
            write_file(folder, "a.bin", file.data, file.size, path);
            qn_volume *volume;
            qn_error error = {.message = ""};
            if (qn_volume_read(context, path, &options, &volume, &error) != QN_OK)
                fail_msg("%s", error.message);
            assert_true(holds_block(volume, (qn_scalar)scalar));
            assert_string_equal(qn_volume_format(volume), "raw");
            qn_volume_destroy(volume);
        }
    unlink(path);
    rmdir(folder);
}

static void raw_size_must_fit_the_file(void **state) {
    (void)state;
    for (int packed = 0; packed < 2; ++packed)
        for (int difference = -1; difference <= 1; ++difference) {
            qn_volume_read_options options;
            raw_options(&options, QN_U16);
            bytes file = {.size = 0};
            put_block(&file, QN_U16, false);
            if (difference > 0)
                put(&file, "x", 1);
            file.size += difference < 0 ? -1 : 0;
            if (packed)
                pack_all(&file);
            qn_volume *volume;
            qn_error error = {.message = ""};
            qn_status status = qni_volume_read_memory(context, "x.raw", file.data, file.size,
                                                      &options, &volume, &error);
            assert_int_equal(status, difference ? QN_ERROR_INPUT : QN_OK);
            if (difference) {
                assert_non_null(strstr(error.message, "120")); /* what is needed */
                if (!packed)
                    assert_non_null(strstr(error.message, difference < 0 ? "119" : "121"));
            }
            qn_volume_destroy(volume);
        }
}

static void raw_needs_its_shape_and_contradictions_are_named(void **state) {
    (void)state;
    qn_volume *volume;
    qn_error error;
    qn_volume_read_options options;
    assert_int_equal(qni_volume_read_memory(context, "x.raw", "abc", 3, NULL, &volume, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "--shape"));
    assert_non_null(strstr(error.message, "--dtype u8"));

    bytes file = {.size = 0};
    bool text;
    put_example(&file, 3, &text);
    raw_options(&options, QN_U8);
    assert_int_equal(
        qni_volume_read_memory(context, "x.nrrd", file.data, file.size, &options, &volume, &error),
        QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "--from raw"));
    strcpy(options.format, "raw");
    options.raw_header = file.size - BLOCK_COUNT;
    assert_int_equal(
        qni_volume_read_memory(context, "x.nrrd", file.data, file.size, &options, &volume, NULL),
        QN_OK);
    qn_volume_destroy(volume);

    static const struct {
        int64_t size;
        int scalar;
        int64_t header;
        const char *format;
    } wrong[] = {{0, 0, 0, ""},  {-1, 0, 0, ""},     {INT64_MAX, 0, 0, ""},
                 {3, 99, 0, ""}, {3, QN_U8, -1, ""}, {3, 0, 0, "jpeg"}};
    for (size_t w = 0; w < sizeof wrong / sizeof wrong[0]; ++w) {
        raw_options(&options, (qn_scalar)wrong[w].scalar);
        options.raw_size[1] = wrong[w].size;
        options.raw_header = wrong[w].header;
        strcpy(options.format, wrong[w].format);
        assert_int_equal(
            qni_volume_read_memory(context, "x.raw", "abc", 3, &options, &volume, &error),
            QN_ERROR_INVALID_ARGUMENT);
        assert_null(volume);
    }
    memset(&options, 0, sizeof options);
    assert_int_equal(qni_volume_read_memory(context, "x.raw", "abc", 3, &options, &volume, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "qn_volume_read_options_init"));
}

static void enormous_raw_shapes_end_in_a_sentence(void **state) {
    (void)state;
    qn_volume *volume;
    qn_error error;
    qn_volume_read_options options;
    raw_options(&options, QN_F64);
    for (int a = 0; a < 3; ++a)
        options.raw_size[a] = 2000000000;
    assert_int_equal(qni_volume_read_memory(context, "x.raw", "abc", 3, &options, &volume, &error),
                     QN_ERROR_INPUT);
    options.raw_size[0] = options.raw_size[1] = options.raw_size[2] = 1;
    options.raw_header = INT64_MAX;
    assert_int_equal(qni_volume_read_memory(context, "x.raw", "abc", 3, &options, &volume, &error),
                     QN_ERROR_INPUT);
}

/* ---- Mitsuba ---- */

static void mitsuba_box_and_refusals(void **state) {
    (void)state;
    bytes file = {.size = 0};
    put(&file, "VOL\x03", 4);
    for (int i = 0; i < 5; ++i)
        put_integer(&file, (const int[]){1, 4, 3, 5, 1}[i], 4, false);
    for (int i = 0; i < 6; ++i)
        put_scalar(&file, QN_F32, (const double[]){-1, -2, 0, 2, 2, 2}[i], false);
    put_block(&file, QN_F32, false);
    const double rows[3][4] = {{1, 0, 0, -1}, {0, 2, 0, -2}, {0, 0, 0.5, 0}};
    qn_volume *volume;
    assert_int_equal(
        qni_volume_read_memory(context, "x", file.data, file.size, NULL, &volume, NULL), QN_OK);
    assert_true(holds_block(volume, QN_F32));
    assert_true(near_matrix(volume, rows, 0));
    qn_volume_destroy(volume);
    qn_error error;
    file.data[20] = 3;
    assert_int_equal(
        qni_volume_read_memory(context, "x", file.data, file.size, NULL, &volume, &error),
        QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "3 channels"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(npy_types_orders_and_versions),
        cmocka_unit_test(npy_refusals_say_why),
        cmocka_unit_test(raw_types_byte_orders_headers_and_gzip),
        cmocka_unit_test(raw_size_must_fit_the_file),
        cmocka_unit_test(raw_needs_its_shape_and_contradictions_are_named),
        cmocka_unit_test(enormous_raw_shapes_end_in_a_sentence),
        cmocka_unit_test(mitsuba_box_and_refusals),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
