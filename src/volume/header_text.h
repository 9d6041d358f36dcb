// SPDX-License-Identifier: MIT
/* Reading the text headers of volume files: strict numbers, words, names without regard to case.
 * Numbers are read with a point, whatever the program's locale says. */
#ifndef QNI_VOLUME_HEADER_TEXT_H
#define QNI_VOLUME_HEADER_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Cut white space at both ends, in place; returns the new beginning. */
char *qni_text_trim(char *text);
bool qni_text_same(const char *a, const char *b);         /* ignoring case */
bool qni_text_ends(const char *text, const char *ending); /* ignoring case */
/* Split "key = value" at the first `separator`; both parts trimmed. False without a separator. */
bool qni_text_split(char *line, char separator, char **key_out, char **value_out);

/* One number at *at, which moves past it. False when there is none. Reads "nan" and "inf" as well.
 */
bool qni_text_double(const char **at, double *value_out);
bool qni_text_integer(const char **at, int64_t *value_out);
/* Exactly `count` numbers between white space and commas, and nothing after them. */
bool qni_text_doubles(const char *text, int count, double *values_out);
bool qni_text_integers(const char *text, int count, int64_t *values_out);
/* The number of words between white space. */
int qni_text_word_count(const char *text);
/* "true", "yes", "1" or "false", "no", "0", by the first letter. */
bool qni_text_boolean(const char *text);

#endif
