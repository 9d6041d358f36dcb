// SPDX-License-Identifier: MIT
/* Damaged files of every format: cut at every byte, one byte changed, memory running out at every
 * allocation. Always one status of the right kind, a sentence that names the file, and no memory
 * left behind. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "lib/failing.h"
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

static qn_status read_bytes(const bytes *file, int64_t size, const char *name, int which,
                            bool *same_out, qn_error *error) {
    qn_volume_read_options options;
    example_options(which, &options);
    qn_volume *volume;
    /* A copy of its own, so that a read beyond the end is seen by the sanitizer. */
    unsigned char *exact = malloc(size ? (size_t)size : 1);
    memcpy(exact, file->data, (size_t)size);
    qn_status status = qni_volume_read_memory(context, name, exact, size, &options, &volume, error);
    free(exact);
    *same_out = status == QN_OK && holds_block(volume, which == 14 ? QN_F32 : QN_I16);
    if (status != QN_OK)
        assert_null(volume);
    qn_volume_destroy(volume);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    return status;
}

static void whole_files_are_read(void **state) {
    (void)state;
    for (int which = FIRST_EXAMPLE; which < EXAMPLE_COUNT; ++which) {
        bytes file = {.size = 0};
        bool text, same;
        qn_error error = {.message = ""};
        const char *name = put_example(&file, which, &text);
        qn_status status = read_bytes(&file, file.size, name, which, &same, &error);
        if (status != QN_OK || !same)
            fail_msg("example %d: %s", which, error.message);
    }
}

static void cut_files_are_errors(void **state) {
    (void)state;
    for (int which = FIRST_EXAMPLE; which < EXAMPLE_COUNT; ++which) {
        bytes file = {.size = 0};
        bool text, same;
        const char *name = put_example(&file, which, &text);
        for (int64_t size = 0; size < file.size; ++size) {
            qn_error error = {.message = ""};
            qn_status status = read_bytes(&file, size, name, which, &same, &error);
            if (text && size >= file.size - 6 && status == QN_OK)
                continue; /* the last number lost digits or its line end */
            if (status != QN_ERROR_INPUT)
                fail_msg("example %d cut at %d: status %d", which, (int)size, (int)status);
            if (!strstr(error.message, ": ")) /* a cut data file name is a name as well */
                fail_msg("example %d cut at %d says: %s", which, (int)size, error.message);
        }
    }
}

/* Any answer is right but a crash, a leak, or a status that says nothing of the file. */
static void changed_bytes_do_no_harm(void **state) {
    (void)state;
    static const unsigned char changes[] = {0x00, 0xff, 0x7f, 0x80, '0', '-', ' ', '\n'};
    for (int which = FIRST_EXAMPLE; which < EXAMPLE_COUNT; ++which) {
        bytes file = {.size = 0};
        bool text, same;
        const char *name = put_example(&file, which, &text);
        for (int64_t at = 0; at < file.size; ++at)
            for (size_t c = 0; c < sizeof changes; ++c) {
                unsigned char before = file.data[at];
                file.data[at] = changes[c];
                qn_status status = read_bytes(&file, file.size, name, which, &same, NULL);
                assert_true(status == QN_OK || status == QN_ERROR_INPUT ||
                            status == QN_ERROR_OUT_OF_MEMORY ||
                            status == QN_ERROR_INVALID_ARGUMENT);
                file.data[at] = before;
            }
    }
}

/* A packed file says by its checksum that samples were changed; none passes for the block
 * unnoticed. */
static void wrong_checksums_are_errors(void **state) {
    (void)state;
    static const int packed[] = {1, 4, 7, 9, 11, 13};
    for (size_t p = QNI_HAVE_NIFTI ? 0 : 1; p < sizeof packed / sizeof packed[0]; ++p) {
        bytes file = {.size = 0};
        bool text, same;
        qn_error error;
        const char *name = put_example(&file, packed[p], &text);
        file.data[file.size - (packed[p] == 7 ? 1 : 5)] ^= 1; /* CRC-32, or Adler-32 for zlib */
        assert_int_equal(read_bytes(&file, file.size, name, packed[p], &same, &error),
                         QN_ERROR_INPUT);
        assert_non_null(strstr(error.message, "damaged"));
    }
}

/* ---- memory ---- */

static void memory_may_run_out_anywhere(void **state) {
    (void)state;
    for (int which = FIRST_EXAMPLE; which < EXAMPLE_COUNT; ++which) {
        bytes file = {.size = 0};
        bool text;
        const char *name = put_example(&file, which, &text);
        qn_volume_read_options options;
        example_options(which, &options);
        qn_status status = QN_ERROR_OUT_OF_MEMORY;
        for (int64_t n = 1; status != QN_OK; ++n) { /* the first block is the context */
            test_failing memory = {.allocations_left = n, .looks_left = -1};
            qn_context *limited = test_failing_context(&memory);
            qn_volume *volume;
            qn_error error;
            assert_non_null(limited);
            status = qni_volume_read_memory(limited, name, file.data, file.size, &options, &volume,
                                            &error);
            assert_true(status == QN_OK || status == QN_ERROR_OUT_OF_MEMORY);
            assert_int_equal(status == QN_OK, memory.allocations_left >= 0);
            qn_volume_destroy(volume);
            assert_int_equal(qn_context_memory(limited).current_bytes, 0);
            qn_context_destroy(limited);
            assert_int_equal(memory.held, 0);
        }
    }
}

/* ---- hostile headers ---- */

static void absurd_sizes_cost_no_memory(void **state) {
    (void)state;
    static const char *const sizes[] = {"2000000000 2000000000 2000000000",
                                        "100000 100000 1000",
                                        "-4 3 5",
                                        "0 3 5",
                                        "4294967300 3 5",
                                        "4 3 9223372036854775807",
                                        "4 3",
                                        "4 3 5 6",
                                        "4 3 99999999999999999999"};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        char text[512];
        qn_volume *volume;
        qn_error error;
        snprintf(
            text, sizeof text,
            "NRRD0004\ntype: float\ndimension: 3\nsizes: %s\nendian: little\nencoding: raw\n\n%s",
            sizes[s], "0123456789012345678901234567890123456789");
        qn_context_reset_peak(context);
        assert_int_equal(qni_volume_read_memory(context, "x.nrrd", text, (int64_t)strlen(text),
                                                NULL, &volume, &error),
                         QN_ERROR_INPUT);
        assert_null(volume);
        assert_true(qn_context_memory(context).peak_bytes < 1000);
    }
}

/* A kilobyte of gzip that says it holds a terabyte. */
static void absurd_packed_sizes_cost_no_memory(void **state) {
    (void)state;
    bytes file = {.size = 0};
    nifti_fields f = {
        .scalar = QN_F64, .version = 2, .pixdim = {1, 1, 1, 1}, .dim = {3, 5000, 5000, 5000}};
    put_nifti(&file, &f);
    pack_all(&file);
    qn_volume *volume;
    qn_error error;
    qn_context_reset_peak(context);
    qn_status status =
        qni_volume_read_memory(context, "x.nii.gz", file.data, file.size, NULL, &volume, &error);
    assert_true(status == QN_ERROR_INPUT || status == QN_ERROR_UNSUPPORTED);
    assert_true(qn_context_memory(context).peak_bytes < 200000);
}

static void files_that_are_none(void **state) {
    (void)state;
    qn_volume *volume;
    qn_error error;
    assert_int_equal(qn_volume_read(context, "/no/such/file.nii", NULL, &volume, &error),
                     QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "/no/such/file.nii"));
    assert_int_equal(qn_volume_read(context, "/", NULL, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "folder"));
    assert_int_equal(qni_volume_read_memory(context, "x.xyz", "hello", 5, NULL, &volume, &error),
                     QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "--shape"));
    assert_int_equal(qni_volume_read_memory(context, "x.xyz", "", 0, NULL, &volume, &error),
                     QN_ERROR_INPUT);
}

static int cancel_at_once(void *user, const char *stage, double fraction) {
    (void)user;
    (void)stage;
    (void)fraction;
    return 1;
}

static void reading_can_be_cancelled(void **state) {
    (void)state;
    qn_context_options options;
    qn_context_options_init(&options);
    options.progress = cancel_at_once;
    qn_context *stopping;
    assert_int_equal(qn_context_create(&options, &stopping, NULL), QN_OK);
    bytes file = {.size = 0};
    bool text;
    const char *name = put_example(&file, 3, &text);
    qn_volume *volume;
    assert_int_equal(
        qni_volume_read_memory(stopping, name, file.data, file.size, NULL, &volume, NULL),
        QN_ERROR_CANCELLED);
    assert_int_equal(qn_context_memory(stopping).current_bytes, 0);
    qn_context_destroy(stopping);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_files_are_read),
        cmocka_unit_test(cut_files_are_errors),
        cmocka_unit_test(changed_bytes_do_no_harm),
        cmocka_unit_test(wrong_checksums_are_errors),
        cmocka_unit_test(memory_may_run_out_anywhere),
        cmocka_unit_test(absurd_sizes_cost_no_memory),
        cmocka_unit_test(absurd_packed_sizes_cost_no_memory),
        cmocka_unit_test(files_that_are_none),
        cmocka_unit_test(reading_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
