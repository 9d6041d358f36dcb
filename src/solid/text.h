// SPDX-License-Identifier: MIT
/* The text of a model in memory, and where in it one is, for messages. */
#ifndef QNI_SOLID_TEXT_H
#define QNI_SOLID_TEXT_H

#include "solid/node.h"

typedef struct qni_text {
    const char *name; /* of the file, for messages */
    const char *bytes;
    int64_t size;
} qni_text;

/* A number at `at`, which ends at `end`, read in the C locale: a sign, digits, a point, an
 * exponent; also inf and nan. The number of bytes used, 0 when there is no number. */
int64_t qni_text_number(const char *at, const char *end, double *value_out);

/* A word for messages: what cannot be printed becomes '?', and it is cut to fit. */
typedef struct qni_word {
    char text[40];
} qni_word;
qni_word qni_word_of(const char *begin, int64_t length);

#endif
