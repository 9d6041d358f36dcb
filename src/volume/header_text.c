// SPDX-License-Identifier: MIT
/* Words and numbers of text headers. */
#define _GNU_SOURCE /* strtod_l, newlocale */
#include "volume/header_text.h"

#include <ctype.h>
#include <errno.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static bool is_space(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

char *qni_text_trim(char *text) {
    while (is_space(*text))
        ++text;
    size_t length = strlen(text);
    while (length > 0 && is_space(text[length - 1]))
        text[--length] = 0;
    return text;
}

bool qni_text_same(const char *a, const char *b) {
    return strcasecmp(a, b) == 0;
}

bool qni_text_ends(const char *text, const char *ending) {
    size_t length = strlen(text), ending_length = strlen(ending);
    return length >= ending_length && strcasecmp(text + length - ending_length, ending) == 0;
}

bool qni_text_split(char *line, char separator, char **key_out, char **value_out) {
    char *at = strchr(line, separator);
    if (!at)
        return false;
    *at = 0;
    *key_out = qni_text_trim(line);
    *value_out = qni_text_trim(at + 1);
    return true;
}

static void skip_gap(const char **at) {
    while (is_space(**at) || **at == ',')
        ++*at;
}

bool qni_text_double(const char **at, double *value_out) {
    /* A static object of the C library, not an allocation. */
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0)
        return false;
    skip_gap(at);
    char *end;
    *value_out = strtod_l(*at, &end, plain);
    freelocale(plain);
    bool found = end != *at;
    *at = end;
    return found;
}

bool qni_text_integer(const char **at, int64_t *value_out) {
    skip_gap(at);
    char *end;
    errno = 0;
    long long value = strtoll(*at, &end, 10);
    bool found = end != *at && errno == 0;
    *value_out = value;
    *at = end;
    return found;
}

bool qni_text_doubles(const char *text, int count, double *values_out) {
    for (int i = 0; i < count; ++i)
        if (!qni_text_double(&text, &values_out[i]))
            return false;
    skip_gap(&text);
    return *text == 0;
}

bool qni_text_integers(const char *text, int count, int64_t *values_out) {
    for (int i = 0; i < count; ++i)
        if (!qni_text_integer(&text, &values_out[i]))
            return false;
    skip_gap(&text);
    return *text == 0;
}

int qni_text_word_count(const char *text) {
    int count = 0;
    for (bool inside = false; *text; ++text) {
        count += !is_space(*text) && !inside;
        inside = !is_space(*text);
    }
    return count;
}

bool qni_text_boolean(const char *text) {
    int first = tolower((unsigned char)text[0]);
    return first == 't' || first == 'y' || first == '1';
}
