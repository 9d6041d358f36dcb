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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(version_is_the_header_s),
        cmocka_unit_test(forgotten_init_is_named),
        cmocka_unit_test(memory_is_counted),
        cmocka_unit_test(products_that_overflow_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
