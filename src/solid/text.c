// SPDX-License-Identifier: MIT
/* Numbers and words out of text that need not end in a zero byte. */
#define _GNU_SOURCE /* strtod_l, newlocale */
#include "solid/text.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>

static bool belongs_to_number(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
           c == '+' || c == '-';
}

int64_t qni_text_number(const char *at, const char *end, double *value_out) {
    /* A copy that ends in zero; longer numbers than this mean no other double. */
    char copy[64];
    int64_t length = 0;
    while (at + length < end && length < (int64_t)sizeof copy - 1 &&
           belongs_to_number(at[length])) {
        copy[length] = at[length];
        ++length;
    }
    copy[length] = 0;
    if (strpbrk(copy, "xXpP")) /* hexadecimal numbers are not of these formats */
        return 0;
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0)
        return 0;
    char *stop;
    *value_out = strtod_l(copy, &stop, plain);
    freelocale(plain);
    return stop - copy;
}

qni_word qni_word_of(const char *begin, int64_t length) {
    qni_word word;
    int64_t room = (int64_t)sizeof word.text - 4, used = length < room ? length : room;
    for (int64_t i = 0; i < used; ++i)
        word.text[i] = begin[i] >= ' ' && begin[i] < 127 ? begin[i] : '?';
    strcpy(word.text + used, used < length ? "..." : "");
    return word;
}
