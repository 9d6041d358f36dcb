// SPDX-License-Identifier: MIT
/* Walking through text line by line: blanks, words, numbers, and where we are. */
#ifndef QNI_MESH_TEXT_H
#define QNI_MESH_TEXT_H

#include "mesh/content.h"
#include "mesh/number.h"

#include <strings.h>

typedef struct qni_text {
    const char *at, *end;
    int64_t line; /* from 1 */
} qni_text;

static inline qni_text qni_text_of(const qni_content *content) {
    return (qni_text){content->bytes, content->bytes + content->size, 1};
}

static inline bool qni_is_line_end(char c) {
    return c == '\n' || c == '\r';
}

/* Over blanks within the line. */
static inline void qni_skip_blanks(qni_text *text) {
    while (text->at < text->end &&
           (*text->at == ' ' || *text->at == '\t' || *text->at == '\f' || *text->at == '\v'))
        ++text->at;
}

static inline bool qni_at_line_end(const qni_text *text) {
    return text->at == text->end || qni_is_line_end(*text->at);
}

/* To the start of the next line; lines end in LF, CR LF or CR. */
static inline void qni_next_line(qni_text *text) {
    while (!qni_at_line_end(text))
        ++text->at;
    if (text->at == text->end)
        return;
    if (*text->at == '\r' && text->at + 1 < text->end && text->at[1] == '\n')
        ++text->at;
    ++text->at;
    ++text->line;
}

/* The length of the word that starts here, up to a blank or the line's end. */
static inline int64_t qni_word_length(const qni_text *text) {
    const char *at = text->at;
    while (at < text->end && !qni_is_line_end(*at) && *at != ' ' && *at != '\t')
        ++at;
    return at - text->at;
}

/* Over the word, when it is this one, in any case. */
static inline bool qni_take_word(qni_text *text, const char *word) {
    int64_t length = qni_word_length(text);
    for (int64_t i = 0; i < length; ++i)
        if (!word[i] || (text->at[i] | 0x20) != (word[i] | 0x20))
            return false;
    if (word[length])
        return false;
    text->at += length;
    return length > 0;
}

/* A number behind blanks, on this line. */
static inline bool qni_take_double(qni_text *text, double *value_out) {
    qni_skip_blanks(text);
    const char *behind = qni_parse_double(text->at, text->end, value_out);
    if (behind)
        text->at = behind;
    return behind != NULL;
}

static inline bool qni_take_integer(qni_text *text, int64_t *value_out) {
    qni_skip_blanks(text);
    const char *behind = qni_parse_integer(text->at, text->end, value_out);
    if (behind)
        text->at = behind;
    return behind != NULL;
}

static inline bool qni_take_vector(qni_text *text, float out[3]) {
    for (int a = 0; a < 3; ++a) {
        double value;
        if (!qni_take_double(text, &value))
            return false;
        out[a] = (float)value;
    }
    return true;
}

#endif
