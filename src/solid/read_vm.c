// SPDX-License-Identifier: MIT
/* Expression tapes as text (.vm): one operation a line, "NAME OPERATION OPERANDS", where operands
 * are names of earlier lines; '#' begins a comment. The last line is the result. */
#include "solid/read.h"
#include "solid/tape.h"

#include <math.h>
#include <string.h>

typedef struct span {
    const char *at;
    int64_t length;
} span;

/* Names seen so far: an open hash table of twice as many places as there can be names. */
typedef struct reader {
    qn_context *context;
    const qni_text *text;
    qn_error *error;
    int64_t line;
    qni_tape_op *ops;
    span *names;
    int64_t count, capacity;
    int32_t *table;
    int64_t table_size; /* a power of two */
} reader;

static uint64_t hash(span name) {
    uint64_t value = 14695981039346656037u; /* FNV-1a */
    for (int64_t i = 0; i < name.length; ++i)
        value = (value ^ (unsigned char)name.at[i]) * 1099511628211u;
    return value;
}

static bool same(span a, span b) {
    return a.length == b.length && memcmp(a.at, b.at, (size_t)a.length) == 0;
}

static bool is(span word, const char *text) {
    return same(word, (span){text, (int64_t)strlen(text)});
}

/* The place of the name in the table: it holds the name's number plus one, or 0. */
static int32_t *find(const reader *in, span name) {
    for (uint64_t at = hash(name);; ++at) {
        int32_t *place = &in->table[at & (uint64_t)(in->table_size - 1)];
        if (*place == 0 || same(in->names[*place - 1], name))
            return place;
    }
}

static qn_status bad(const reader *in, const char *what, span word, const char *cure) {
    return qni_fail(in->error, QN_ERROR_INPUT, "'%s', line %lld: %s '%s'; %s", in->text->name,
                    (long long)in->line, what, qni_word_of(word.at, word.length).text, cure);
}

/* The words of one line, at most `room`, and how many there are. */
static int words_of(const char *at, const char *end, span *words, int room) {
    int count = 0;
    for (;;) {
        while (at < end && (*at == ' ' || *at == '\t' || *at == '\r'))
            ++at;
        if (at == end || *at == '#')
            return count;
        const char *begin = at;
        while (at < end && *at != ' ' && *at != '\t' && *at != '\r' && *at != '#')
            ++at;
        if (count < room)
            words[count] = (span){begin, at - begin};
        ++count;
    }
}

static int code_of(span word) {
    if (is(word, "log"))
        return QNI_TAPE_LOG;
    for (int code = 0; code < QNI_TAPE_CODES; ++code)
        if (is(word, qni_tape_name((qni_tape_code)code)))
            return code;
    return -1;
}

static qn_status operand(const reader *in, span word, int32_t *number_out) {
    int32_t place = *find(in, word);
    if (place == 0)
        return bad(in, "no earlier line has the name", word, "operands are names of lines above");
    *number_out = place - 1;
    return QN_OK;
}

static qn_status read_line(reader *in, const span *words, int count) {
    if (count < 2)
        return bad(in, "nothing follows the name", words[0], "expected NAME OPERATION OPERANDS");
    int code = code_of(words[1]);
    if (code < 0)
        return bad(in, "unknown operation", words[1],
                   "known are const, var-x, var-y, var-z, neg, abs, recip, square, sqrt, sin, cos, "
                   "tan, asin, "
                   "acos, atan, exp, ln, add, sub, mul, div, min, max");
    int operands = code == QNI_TAPE_CONST ? 1 : qni_tape_operands((qni_tape_code)code);
    if (count != 2 + operands)
        return qni_fail(in->error, QN_ERROR_INPUT,
                        "'%s', line %lld: '%s' takes %d operand%s, but %d follow", in->text->name,
                        (long long)in->line, qni_tape_name((qni_tape_code)code), operands,
                        operands == 1 ? "" : "s", count - 2);
    qni_tape_op op = {.code = code};
    if (code == QNI_TAPE_CONST) {
        const char *end = words[2].at + words[2].length;
        if (qni_text_number(words[2].at, end, &op.value) != words[2].length || !isfinite(op.value))
            return bad(in, "not a finite number:", words[2], "expected one such as -1.5e-3");
    } else {
        if (operands > 0)
            QN_TRY(operand(in, words[2], &op.left));
        op.right = op.left;
        if (operands > 1)
            QN_TRY(operand(in, words[3], &op.right));
    }
    int32_t *place = find(in, words[0]);
    if (*place != 0)
        return bad(in, "a second line has the name", words[0], "each name is given once");
    in->names[in->count] = words[0];
    in->ops[in->count++] = op;
    *place = (int32_t)in->count;
    return QN_OK;
}

static qn_status read_lines(reader *in) {
    const char *at = in->text->bytes, *end = at + in->text->size;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        ++in->line;
        span words[4];
        int count = words_of(at, stop, words, 4);
        if (count > 0)
            QN_TRY(read_line(in, words, count));
        at = stop < end ? stop + 1 : end;
    }
    if (in->count == 0)
        return qni_fail(in->error, QN_ERROR_INPUT,
                        "'%s' has no operation: a .vm file has lines of NAME OPERATION OPERANDS",
                        in->text->name);
    return QN_OK;
}

static int64_t lines_of(const qni_text *text) {
    int64_t lines = 1;
    for (int64_t i = 0; i < text->size; ++i)
        lines += text->bytes[i] == '\n';
    return lines;
}

qn_status qni_read_vm(qn_context *context, const qni_text *text, const qni_box *region,
                      qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    reader in = {.context = context,
                 .text = text,
                 .error = error,
                 .capacity = lines_of(text),
                 .table_size = 16};
    if (in.capacity > INT32_MAX / 4)
        return qni_fail(error, QN_ERROR_INPUT, "'%s' has %lld lines: more than a tape can have",
                        text->name, (long long)in.capacity);
    while (in.table_size < 2 * in.capacity)
        in.table_size *= 2;
    in.ops = qni_alloc(context, in.capacity, sizeof *in.ops);
    in.names = qni_alloc(context, in.capacity, sizeof *in.names);
    in.table = qni_alloc_zero(context, in.table_size, sizeof *in.table);
    qn_status status =
        in.ops && in.names && in.table ? read_lines(&in) : qni_fail_memory(error, "a tape");
    if (status == QN_OK) {
        qni_tape *tape = qni_tape_create(context, in.ops, in.count, region);
        *solid_out = tape ? &tape->base : NULL;
        status = tape ? QN_OK : qni_fail_memory(error, "a tape");
    }
    qni_free(context, in.ops, in.capacity, sizeof *in.ops);
    qni_free(context, in.names, in.capacity, sizeof *in.names);
    qni_free(context, in.table, in.table_size, sizeof *in.table);
    return status;
}
