// SPDX-License-Identifier: MIT
/* Numbers in and out. Nothing here depends on the locale: the tool never sets one. */
#include "number.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool number_parse_real(const char *text, double *value_out) {
    char *end;
    if (isspace((unsigned char)*text) || !*text)
        return false;
    *value_out = strtod(text, &end);
    return *end == '\0';
}

bool number_parse_integer(const char *text, int64_t *value_out) {
    char *end;
    if (isspace((unsigned char)*text) || !*text)
        return false;
    errno = 0;
    *value_out = strtoll(text, &end, 10);
    return *end == '\0' && errno == 0;
}

/* Copies the text up to the separator into `part`; returns what follows, NULL when it does not fit.
 */
static const char *next_part(const char *text, char separator, char *part, size_t size) {
    size_t length = strcspn(text, (char[]){separator, '\0'});
    if (length >= size)
        return NULL;
    memcpy(part, text, length);
    part[length] = '\0';
    return text + length;
}

bool number_parse_reals(const char *text, char separator, int count, double *values_out) {
    char part[64];
    for (int i = 0; i < count; ++i) {
        if (i > 0 && *text++ != separator)
            return false;
        text = next_part(text, separator, part, sizeof part);
        if (!text || !number_parse_real(part, &values_out[i]))
            return false;
    }
    return *text == '\0';
}

bool number_parse_integers(const char *text, char separator, int count, int64_t *values_out) {
    char part[64];
    for (int i = 0; i < count; ++i) {
        if (i > 0 && *text++ != separator)
            return false;
        text = next_part(text, separator, part, sizeof part);
        if (!text || !number_parse_integer(part, &values_out[i]))
            return false;
    }
    return *text == '\0';
}

const char *number_format_real(double value, char text[NUMBER_TEXT_SIZE]) {
    for (int digits = 1; digits <= 17; ++digits) {
        snprintf(text, NUMBER_TEXT_SIZE, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    double exponent = fabs(value);
    if (exponent < 1e15 && value == floor(value)) /* 300, not 3e+02 */
        snprintf(text, NUMBER_TEXT_SIZE, "%.0f", value + 0.0);
    return text;
}

const char *number_format_bytes(int64_t bytes, char text[NUMBER_TEXT_SIZE]) {
    static const char *const units[] = {"bytes", "kB", "MB", "GB", "TB", "PB", "EB"};
    double amount = (double)bytes;
    int unit = 0;
    while (amount >= 1000 && unit < 6) {
        amount /= 1000;
        ++unit;
    }
    snprintf(text, NUMBER_TEXT_SIZE, unit > 0 && amount < 100 ? "%.1f %s" : "%.0f %s", amount,
             units[unit]);
    return text;
}

const char *number_format_count(int64_t count, char text[NUMBER_TEXT_SIZE]) {
    char digits[NUMBER_TEXT_SIZE];
    snprintf(digits, sizeof digits, "%" PRId64, count);
    size_t length = strlen(digits), out = 0;
    for (size_t i = 0; i < length; ++i) {
        text[out++] = digits[i];
        size_t left = length - 1 - i;
        if (left > 0 && left % 3 == 0 && digits[i] != '-')
            text[out++] = ',';
    }
    text[out] = '\0';
    return text;
}

const char *number_format_duration(double seconds, char text[NUMBER_TEXT_SIZE]) {
    if (seconds < 10)
        snprintf(text, NUMBER_TEXT_SIZE, "%.2g s", seconds);
    else if (seconds < 120)
        snprintf(text, NUMBER_TEXT_SIZE, "%.0f s", seconds);
    else if (seconds < 7200)
        snprintf(text, NUMBER_TEXT_SIZE, "%.0f min", seconds / 60);
    else
        snprintf(text, NUMBER_TEXT_SIZE, "%.1f h", seconds / 3600);
    return text;
}
