// SPDX-License-Identifier: MIT
/* Reading the text of .csg files: calls with named arguments, nested in braces. */
#include "solid/csg_tree.h"

#include <string.h>

enum { CHUNK_BYTES = 1 << 14, DEEPEST = 150 };

typedef struct qni_csg_chunk {
    struct qni_csg_chunk *next;
    size_t used;
    char bytes[CHUNK_BYTES];
} chunk;

typedef struct parser {
    const qni_text *text;
    const char *at, *end, *line_start;
    int64_t line;
    qni_csg_memory *memory;
    qn_error *error;
    int depth;
} parser;

/* Cleared memory for one small structure. */
static void *grab(parser *in, size_t size) {
    chunk *head = in->memory->chunks;
    size = (size + 15) & ~(size_t)15;
    if (!head || head->used + size > CHUNK_BYTES) {
        head = qni_alloc_zero(in->memory->context, 1, sizeof *head);
        if (!head)
            return NULL;
        head->next = in->memory->chunks;
        in->memory->chunks = head;
    }
    void *memory = head->bytes + head->used;
    head->used += size;
    return memory;
}

void qni_csg_memory_free(qni_csg_memory *memory) {
    while (memory->chunks) {
        chunk *next = memory->chunks->next;
        qni_free(memory->context, memory->chunks, 1, sizeof *memory->chunks);
        memory->chunks = next;
    }
}

static qn_status no_memory(parser *in) {
    return qni_fail_memory(in->error, "the tree of a .csg file");
}

/* "'FILE', line L, column C: expected WHAT, found 'WORD'". */
static qn_status expected(parser *in, const char *what) {
    int64_t length = 0;
    while (in->at + length < in->end && length < 20 && in->at[length] != '\n')
        ++length;
    return qni_fail(in->error, QN_ERROR_INPUT,
                    "'%s', line %lld, column %lld: expected %s, found %s%s%s", in->text->name,
                    (long long)in->line, (long long)(in->at - in->line_start + 1), what,
                    in->at == in->end ? "" : "'",
                    in->at == in->end ? "the end" : qni_word_of(in->at, length).text,
                    in->at == in->end ? "" : "'");
}

static bool starts(const parser *in, const char *text) {
    size_t length = strlen(text);
    return (size_t)(in->end - in->at) >= length && memcmp(in->at, text, length) == 0;
}

static void step(parser *in) {
    if (*in->at == '\n') {
        ++in->line;
        in->line_start = in->at + 1;
    }
    ++in->at;
}

/* Blanks and comments. */
static void skip(parser *in) {
    for (;;) {
        if (starts(in, "//")) {
            while (in->at < in->end && *in->at != '\n')
                step(in);
        } else if (starts(in, "/*")) {
            while (in->at < in->end && !starts(in, "*/"))
                step(in);
            for (int i = 0; i < 2 && in->at < in->end; ++i)
                step(in);
        } else if (in->at < in->end && (*in->at == ' ' || (*in->at >= '\t' && *in->at <= '\r'))) {
            step(in);
        } else {
            return;
        }
    }
}

static bool accept(parser *in, char c) {
    skip(in);
    if (in->at == in->end || *in->at != c)
        return false;
    step(in);
    return true;
}

static bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '$';
}

static qni_csg_span word(parser *in) {
    skip(in);
    const char *begin = in->at;
    while (in->at < in->end &&
           (is_letter(*in->at) || (in->at > begin && *in->at >= '0' && *in->at <= '9')))
        ++in->at;
    return (qni_csg_span){begin, in->at - begin};
}

static bool same(qni_csg_span span, const char *text) {
    return (size_t)span.length == strlen(text) && memcmp(span.at, text, (size_t)span.length) == 0;
}

static qn_status value(parser *in, qni_csg_value *out);

static qn_status vector(parser *in, qni_csg_value *out) {
    out->kind = QNI_CSG_VECTOR;
    qni_csg_value **tail = &out->items;
    if (++in->depth > DEEPEST)
        return expected(in, "less nesting");
    while (!accept(in, ']')) {
        if (out->count > 0 && !accept(in, ','))
            return expected(in, "',' or ']'");
        qni_csg_value *item = grab(in, sizeof *item);
        if (!item)
            return no_memory(in);
        QN_TRY(value(in, item));
        *tail = item;
        tail = &item->next;
        ++out->count;
    }
    --in->depth;
    return QN_OK;
}

static qn_status string(parser *in, qni_csg_value *out) {
    out->kind = QNI_CSG_STRING;
    out->text.at = in->at;
    while (in->at < in->end && *in->at != '"') {
        if (*in->at == '\\' && in->at + 1 < in->end)
            step(in);
        step(in);
    }
    out->text.length = in->at - out->text.at;
    return accept(in, '"') ? QN_OK : expected(in, "'\"' at the end of the text");
}

static qn_status value(parser *in, qni_csg_value *out) {
    if (accept(in, '['))
        return vector(in, out);
    if (accept(in, '"'))
        return string(in, out);
    const char *begin = in->at;
    qni_csg_span name = word(in);
    bool yes = same(name, "true"), no = same(name, "false");
    if (yes || no) {
        out->kind = QNI_CSG_BOOL;
        out->number = yes;
        return QN_OK;
    }
    if (same(name, "undef"))
        return QN_OK;
    in->at = begin;
    int64_t used = qni_text_number(begin, in->end, &out->number);
    if (used == 0)
        return expected(in, "a number, true, false, undef, a text or '['");
    in->at += used;
    out->kind = QNI_CSG_NUMBER;
    return QN_OK;
}

static qn_status arguments(parser *in, qni_csg_call *call) {
    qni_csg_argument **tail = &call->arguments;
    if (!accept(in, '('))
        return expected(in, "'('");
    while (!accept(in, ')')) {
        if (call->arguments && !accept(in, ','))
            return expected(in, "',' or ')'");
        qni_csg_argument *argument = grab(in, sizeof *argument);
        if (!argument)
            return no_memory(in);
        skip(in);
        const char *begin = in->at;
        argument->name = word(in);
        if (argument->name.length == 0 || !accept(in, '=')) {
            argument->name.length = 0;
            in->at = begin;
        }
        QN_TRY(value(in, &argument->value));
        *tail = argument;
        tail = &argument->next;
    }
    return QN_OK;
}

static qn_status calls(parser *in, qni_csg_call *parent);

/* %, *, # and ! before a call; whether it counts. */
static qn_status modifiers(parser *in, bool *counts_out) {
    *counts_out = true;
    for (;;) {
        if (accept(in, '%') || accept(in, '*'))
            *counts_out = false;
        else if (accept(in, '!'))
            return qni_fail(
                in->error, QN_ERROR_UNSUPPORTED,
                "'%s', line %lld: the modifier '!' (show only this) is not supported; take it out",
                in->text->name, (long long)in->line);
        else if (!accept(in, '#'))
            return QN_OK;
    }
}

static qn_status one_call(parser *in, qni_csg_call *call) {
    call->line = in->line;
    call->column = in->at - in->line_start + 1;
    call->name = word(in);
    if (call->name.length == 0)
        return expected(in, "the name of a module such as cube or union");
    QN_TRY(arguments(in, call));
    if (accept(in, ';'))
        return QN_OK;
    if (!accept(in, '{'))
        return expected(in, "';' or '{'");
    QN_TRY(calls(in, call));
    return accept(in, '}') ? QN_OK : expected(in, "'}'");
}

static qn_status calls(parser *in, qni_csg_call *parent) {
    qni_csg_call **tail = &parent->children;
    if (++in->depth > DEEPEST)
        return expected(in, "less nesting");
    for (;;) {
        while (accept(in, ';')) {
        }
        skip(in);
        if (in->at == in->end || *in->at == '}')
            break;
        bool counts;
        QN_TRY(modifiers(in, &counts));
        qni_csg_call *call = grab(in, sizeof *call);
        if (!call)
            return no_memory(in);
        QN_TRY(one_call(in, call));
        if (!counts)
            continue;
        *tail = call;
        tail = &call->next;
        ++parent->child_count;
    }
    --in->depth;
    return QN_OK;
}

qn_status qni_csg_parse(const qni_text *text, qni_csg_memory *memory, qni_csg_call **root_out,
                        qn_error *error) {
    parser in = {.text = text,
                 .at = text->bytes,
                 .end = text->bytes + text->size,
                 .line_start = text->bytes,
                 .line = 1,
                 .memory = memory,
                 .error = error};
    if (starts(&in, "\xef\xbb\xbf"))
        in.at += 3;
    *root_out = grab(&in, sizeof **root_out);
    if (!*root_out)
        return no_memory(&in);
    (*root_out)->line = (*root_out)->column = 1;
    QN_TRY(calls(&in, *root_out));
    return in.at == in.end ? QN_OK : expected(&in, "the end or the name of a module");
}

bool qni_csg_is(const qni_csg_call *call, const char *name) {
    return same(call->name, name);
}

const qni_csg_value *qni_csg_find(const qni_csg_call *call, const char *name) {
    for (const qni_csg_argument *argument = call->arguments; argument; argument = argument->next)
        if (same(argument->name, name))
            return argument->value.kind == QNI_CSG_UNDEF ? NULL : &argument->value;
    return NULL;
}
