// SPDX-License-Identifier: MIT
/* Floats as text: back to the same bits, short, the same in every locale; decimals as strtod reads
 * them. */
#include "lib/support.h"
#include "mesh/number.h"

#include <locale.h>
#include <math.h>

static void assert_round_trip(float value) {
    char text[QNI_NUMBER_LENGTH + 1];
    char *end = qni_format_float(text, value);
    assert_in_range(end - text, 1, QNI_NUMBER_LENGTH);
    *end = 0;
    float by_c = strtof(text, NULL);
    double parsed;
    if (!qni_parse_double(text, end, &parsed))
        fail_msg("'%s' is not parsed", text);
    float by_us = (float)parsed;
    if (memcmp(&by_c, &value, sizeof value) != 0 || memcmp(&by_us, &value, sizeof value) != 0)
        fail_msg("%a became '%s'", (double)value, text);
}

static void every_float_reads_back(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int64_t i = test_count(1000000, 100000000); i > 0; --i) {
        uint32_t bits = (uint32_t)test_random_bits(&random);
        float value;
        memcpy(&value, &bits, sizeof value);
        if (!isnan(value))
            assert_round_trip(value);
    }
    for (int power = -149; power < 128; ++power) {
        float value = ldexpf(1, power);
        assert_round_trip(value);
        assert_round_trip(nextafterf(value, 0));
        assert_round_trip(-nextafterf(value, INFINITY));
    }
}

static void assert_text(float value, const char *expected) {
    char text[QNI_NUMBER_LENGTH + 1];
    *qni_format_float(text, value) = 0;
    assert_string_equal(text, expected);
}

static void the_text_is_short(void **state) {
    (void)state;
    assert_text(0, "0");
    assert_text(-0.0f, "-0");
    assert_text(1, "1");
    assert_text(-12.5f, "-12.5");
    assert_text(0.1f, "0.1");
    assert_text(100, "100");
    assert_text(16777216, "16777216");
    assert_text(0.00012f, "0.00012");
    assert_text(1e-7f, "1e-07");
    assert_text(3e38f, "3e+38");
    assert_text(1e-45f, "1e-45");
    assert_text(1.0f / 3, "0.33333334");
    assert_text(INFINITY, "inf");
    assert_text(-INFINITY, "-inf");
    assert_text(NAN, "nan");
}

static void decimals_are_read_as_c_reads_them(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int64_t i = test_count(200000, 10000000); i > 0; --i) {
        char text[80];
        double value =
            ldexp(test_random_gaussian(&random), (int)test_random_range(&random, -80, 80));
        const char *formats[] = {"%.17g", "%.3f", "%.9e", "%.25g", "%g", "%+.40f"};
        snprintf(text, sizeof text, formats[i % 6], value);
        double parsed, expected = strtod(text, NULL);
        if (!qni_parse_double(text, text + strlen(text), &parsed) || parsed != expected)
            fail_msg("'%s' was read as %a, not %a", text, parsed, expected);
    }
}

static void odd_numbers_are_read_or_refused(void **state) {
    (void)state;
    static const char *const good[] = {"1.", ".5", "+3", "1e5", "1E-5", "007", "-.5e+1", "1/2"};
    static const double values[] = {1, 0.5, 3, 1e5, 1e-5, 7, -5, 1};
    static const char *const bad[] = {"",     "-",   ".",   "e5",   "1e",  "1e+",
                                      "0x10", "1,5", "abc", "1..2", "infx"};
    double value;
    for (size_t i = 0; i < sizeof good / sizeof *good; ++i) {
        assert_non_null(qni_parse_double(good[i], good[i] + strlen(good[i]), &value));
        assert_true(value == values[i]);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_null(qni_parse_double(bad[i], bad[i] + strlen(bad[i]), &value));
    assert_non_null(qni_parse_double("-inf", "-inf" + 4, &value));
    assert_true(isinf(value) && value < 0);
    const char *nan_text = "nan";
    assert_non_null(qni_parse_double(nan_text, nan_text + 3, &value));
    assert_true(isnan(value));
    int64_t whole;
    const char *huge = "99999999999999999999";
    assert_null(qni_parse_integer(huge, huge + 20, &whole));
    const char *text = "-42 ";
    assert_ptr_equal(qni_parse_integer(text, text + 4, &whole), text + 3);
    assert_int_equal(whole, -42);
}

static void the_locale_changes_nothing(void **state) {
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "fr_FR",
                                        "nl_NL.UTF-8"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        if (!setlocale(LC_NUMERIC, names[i]))
            continue;
        double value;
        const char *text = "1.234567890123456789012345";
        assert_text(0.5f, "0.5");
        assert_non_null(qni_parse_double(text, text + strlen(text), &value));
        assert_true(value == 1.234567890123456789012345);
        setlocale(LC_NUMERIC, "C");
        return;
    }
    printf("skipped: no locale with a decimal comma\n");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_float_reads_back),
        cmocka_unit_test(the_text_is_short),
        cmocka_unit_test(decimals_are_read_as_c_reads_them),
        cmocka_unit_test(odd_numbers_are_read_or_refused),
        cmocka_unit_test(the_locale_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
