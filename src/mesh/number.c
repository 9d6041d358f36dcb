// SPDX-License-Identifier: MIT
/* Numbers as text. A float has at most nine significant digits that matter, which a double holds
 * with seven to spare: that makes shortest output and exact input cheap without big integers. */
#define _GNU_SOURCE /* strtod_l */
#include "mesh/number.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST_POWER = 60, EXACT_POWER = 22, FLOAT_DIGITS = 9 };

static double power_of_ten(int exponent) {
    // clang-format off
    static const double powers[LARGEST_POWER + 1] = {
        1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
        1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22, 1e23, 1e24, 1e25, 1e26, 1e27, 1e28, 1e29, 1e30, 1e31,
        1e32, 1e33, 1e34, 1e35, 1e36, 1e37, 1e38, 1e39, 1e40, 1e41, 1e42, 1e43, 1e44, 1e45, 1e46, 1e47,
        1e48, 1e49, 1e50, 1e51, 1e52, 1e53, 1e54, 1e55, 1e56, 1e57, 1e58, 1e59, 1e60};
    // clang-format on
    return powers[exponent];
}

static double scale_by_ten(double value, int exponent) {
    return exponent >= 0 ? value * power_of_ten(exponent) : value / power_of_ten(-exponent);
}

char *qni_format_integer(char *to, uint64_t value) {
    char digits[20];
    int count = 0;
    do {
        digits[count++] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    while (count)
        *to++ = digits[--count];
    return to;
}

/* Whether digits * 10^exponent reads back to `value`, with room for a reader's own rounding. */
static bool reads_back(uint32_t digits, int exponent, float value) {
    double read = scale_by_ten((double)digits, exponent);
    double slack = read * 1e-15;
    return (float)(read - slack) == value && (float)(read + slack) == value;
}

/* value = digits * 10^exponent, with as few digits as read back. value is positive and finite. */
static uint32_t shortest_digits(float value, int *exponent_out) {
    int binary;
    frexp((double)value, &binary);
    int decimal =
        (int)floor((binary - 1) * 0.30102999566398120); /* of the leading digit, or one less */
    if (scale_by_ten(1, decimal + 1) <= (double)value)
        ++decimal;
    int exponent = decimal - (FLOAT_DIGITS - 1);
    uint32_t digits = (uint32_t)llrint(scale_by_ten((double)value, -exponent));
    for (;;) {
        uint32_t fewer = (digits + 5) / 10;
        if (!reads_back(fewer, exponent + 1, value))
            break;
        digits = fewer;
        ++exponent;
        /* Whole numbers end in zeros, which cost nothing to drop. */
        while (digits % 10 == 0) {
            digits /= 10;
            ++exponent;
        }
    }
    *exponent_out = exponent;
    return digits;
}

static char *put_scientific(char *to, const char *digits, int count, int decimal) {
    *to++ = digits[0];
    if (count > 1) {
        *to++ = '.';
        memcpy(to, digits + 1, (size_t)(count - 1));
        to += count - 1;
    }
    *to++ = 'e';
    *to++ = decimal < 0 ? '-' : '+';
    int size = abs(decimal);
    *to++ = (char)('0' + size / 10);
    *to++ = (char)('0' + size % 10);
    return to;
}

/* `decimal` is the power of ten of the first digit. */
static char *put_fixed(char *to, const char *digits, int count, int decimal) {
    if (decimal < 0) {
        *to++ = '0';
        *to++ = '.';
        for (int i = -1; i > decimal; --i)
            *to++ = '0';
        memcpy(to, digits, (size_t)count);
        return to + count;
    }
    for (int i = 0; i < count || i <= decimal; ++i) {
        if (i == decimal + 1)
            *to++ = '.';
        *to++ = i < count ? digits[i] : '0';
    }
    return to;
}

char *qni_format_float(char *to, float value) {
    if (isnan(value)) {
        memcpy(to, "nan", 3);
        return to + 3;
    }
    if (signbit(value))
        *to++ = '-';
    value = fabsf(value);
    if (isinf(value)) {
        memcpy(to, "inf", 3);
        return to + 3;
    }
    if (value == 0) {
        *to++ = '0';
        return to;
    }
    int exponent;
    char digits[QNI_NUMBER_LENGTH];
    uint32_t significant = shortest_digits(value, &exponent);
    int count = (int)(qni_format_integer(digits, significant) - digits);
    int decimal = exponent + count - 1;
    if (decimal < -5 || decimal >= FLOAT_DIGITS)
        return put_scientific(to, digits, count, decimal);
    return put_fixed(to, digits, count, decimal);
}

static bool ends_number(const char *at, const char *end) {
    return at == end || *at == ' ' || *at == '\n' || *at == '\r' || *at == '\t' || *at == '/' ||
           *at == '\f' || *at == '\v' || *at == '#' || *at == '\\';
}

static const char *skip_word(const char *at, const char *end, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(end - at) < length)
        return NULL;
    for (size_t i = 0; i < length; ++i)
        if ((at[i] | 0x20) != word[i])
            return NULL;
    return at + length;
}

static const char *parse_special(const char *at, const char *end, double *value_out) {
    const char *behind;
    if ((behind = skip_word(at, end, "nan")))
        *value_out = (double)NAN;
    else if ((behind = skip_word(at, end, "infinity")) || (behind = skip_word(at, end, "inf")))
        *value_out = (double)INFINITY;
    return behind;
}

/* The long way, for numbers with more digits or a larger exponent than doubles multiply exactly. */
static double parse_slowly(const char *from, const char *to) {
    char text[128];
    size_t length = (size_t)(to - from);
    if (length >=
        sizeof text) { /* digits beyond a hundred change nothing; an exponent would be lost */
        const char *e =
            memchr(from, 'e', length) ? memchr(from, 'e', length) : memchr(from, 'E', length);
        size_t tail = e && to - e < 24 ? (size_t)(to - e) : 0;
        const char *point = memchr(from, '.', length);
        if (!point || point - from > 96)
            return (double)NAN;
        memcpy(text, from, 100);
        memcpy(text + 100, e, tail);
        length = 100 + tail;
    } else {
        memcpy(text, from, length);
    }
    text[length] = 0;
    locale_t c_locale =
        newlocale(LC_ALL_MASK, "C", (locale_t)0); /* glibc: a constant, nothing made */
    double value = strtod_l(text, NULL, c_locale);
    freelocale(c_locale);
    return value;
}

typedef struct decimal_number {
    uint64_t digits;
    int digit_count; /* without leading zeros */
    int exponent;
    bool any;
} decimal_number;

static const char *take_digits(const char *at, const char *end, decimal_number *number, int step) {
    for (; at < end && *at >= '0' && *at <= '9'; ++at) {
        number->any = true;
        if (number->digit_count < 19) {
            number->digits = 10 * number->digits + (uint64_t)(*at - '0');
            number->digit_count += number->digits != 0;
            number->exponent += step;
        } else {
            ++number->digit_count;
        }
        if (number->digit_count > 1000)
            return NULL;
    }
    return at;
}

static const char *take_exponent(const char *at, const char *end, int *exponent) {
    const char *digit = at + 1;
    bool negative = digit < end && *digit == '-';
    if (digit < end && (*digit == '-' || *digit == '+'))
        ++digit;
    if (digit == end || *digit < '0' || *digit > '9')
        return NULL;
    int value = 0;
    for (; digit < end && *digit >= '0' && *digit <= '9'; ++digit)
        value = value < 100000 ? 10 * value + (*digit - '0') : value;
    *exponent += negative ? -value : value;
    return digit;
}

const char *qni_parse_double(const char *at, const char *end, double *value_out) {
    bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+'))
        ++at;
    const char *from = at;
    decimal_number number = {0};
    at = take_digits(at, end, &number, 0);
    if (at && at < end && *at == '.')
        at = take_digits(at + 1, end, &number, -1);
    if (at && !number.any)
        at = parse_special(from, end, value_out);
    else if (at && at < end && (*at == 'e' || *at == 'E'))
        at = take_exponent(at, end, &number.exponent);
    if (!at || !ends_number(at, end))
        return NULL;
    if (number.any) {
        bool exact = number.digit_count <= 19 && number.digits <= (UINT64_C(1) << 53) &&
                     abs(number.exponent) <= EXACT_POWER;
        *value_out =
            exact ? scale_by_ten((double)number.digits, number.exponent) : parse_slowly(from, at);
    }
    if (negative)
        *value_out = -*value_out;
    return at;
}

const char *qni_parse_integer(const char *at, const char *end, int64_t *value_out) {
    bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+'))
        ++at;
    if (at == end || *at < '0' || *at > '9')
        return NULL;
    int64_t value = 0;
    for (; at < end && *at >= '0' && *at <= '9'; ++at) {
        if (value > INT64_MAX / 10 - 1)
            return NULL;
        value = 10 * value + (*at - '0');
    }
    if (!ends_number(at, end))
        return NULL;
    *value_out = negative ? -value : value;
    return at;
}
