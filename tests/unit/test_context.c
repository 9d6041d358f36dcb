// SPDX-License-Identifier: MIT
/* The context: options are checked, memory is counted, allocation failure and overflow are errors.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>
#include <string.h>

#include <qn/qn.h>
#include "core/context.h"
#include "core/pool.h"

static void version_is_the_header_s(void **state) {
    (void)state;
    int major, minor, patch;
    assert_int_equal(sscanf(qn_version(), "%d.%d.%d", &major, &minor, &patch), 3);
    assert_int_equal(major, QN_VERSION_MAJOR);
    assert_int_equal(minor, QN_VERSION_MINOR);
    assert_int_equal(patch, QN_VERSION_PATCH);
}

static void forgotten_init_is_named(void **state) {
    (void)state;
    qn_context_options options;
    memset(&options, 0, sizeof options);
    qn_context *context = (qn_context *)&options;
    qn_error error;
    assert_int_equal(qn_context_create(&options, &context, &error), QN_ERROR_INVALID_ARGUMENT);
    assert_null(context);
    assert_non_null(strstr(error.message, "qn_context_options_init"));
}

static void memory_is_counted(void **state) {
    (void)state;
    qn_context *context;
    assert_int_equal(qn_context_create(NULL, &context, NULL), QN_OK);
    void *a = qni_alloc(context, 10, 100);
    assert_int_equal(qn_context_memory(context).current_bytes, 1000);
    a = qni_realloc(context, a, 10, 20, 100);
    assert_int_equal(qn_context_memory(context).current_bytes, 2000);
    assert_int_equal(qn_context_memory(context).peak_bytes, 3000);
    qni_free(context, a, 20, 100);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_reset_peak(context);
    assert_int_equal(qn_context_memory(context).peak_bytes, 0);
    qn_context_destroy(context);
}

static void products_that_overflow_fail(void **state) {
    (void)state;
    qn_context *context;
    assert_int_equal(qn_context_create(NULL, &context, NULL), QN_OK);
    assert_null(qni_alloc(context, INT64_MAX, 16));
    assert_null(qni_alloc(context, -1, 1));
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_destroy(context);
}

static void pieces_of_a_pool_keep_apart(void **state) {
    (void)state;
    enum { PIECES = 400 };
    static const int64_t sizes[] = {0, 1, 7, 100, 3000, 70000, 200000};
    qn_context *context;
    qni_pool pool = {0};
    unsigned char *piece[PIECES];
    assert_int_equal(qn_context_create(NULL, &context, NULL), QN_OK);
    for (int n = 0; n < PIECES; ++n) {
        const int64_t size = sizes[n % 7];
        piece[n] = qni_pool_take(context, &pool, size, 1);
        assert_non_null(piece[n]);
        assert_int_equal((uintptr_t)piece[n] % _Alignof(max_align_t), 0);
        memset(piece[n], n & 255, (size_t)size);
    }
    for (int n = 0; n < PIECES; ++n)
        for (int64_t i = 0; i < sizes[n % 7]; ++i)
            assert_int_equal(piece[n][i], n & 255);
    assert_null(qni_pool_take(context, &pool, -1, 1));
    assert_null(qni_pool_take(context, &pool, INT64_MAX, 16));
    assert_null(qni_pool_take(context, &pool, INT64_MAX - 8, 1));
    qni_pool_free(context, &pool);
    assert_null(pool.last);
    assert_int_equal(qn_context_memory(context).current_bytes, 0);
    qn_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(version_is_the_header_s),
        cmocka_unit_test(forgotten_init_is_named),
        cmocka_unit_test(memory_is_counted),
        cmocka_unit_test(products_that_overflow_fail),
        cmocka_unit_test(pieces_of_a_pool_keep_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
