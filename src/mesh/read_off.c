// SPDX-License-Identifier: MIT
/* OFF with its prefixes ST, C, N: one vertex or face a line, what follows its numbers (colours)
 * left out. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/text.h"

typedef struct reader {
    const qni_content *content;
    qni_builder *builder;
    qni_text text;
    uint32_t *corners;
    int64_t capacity;
    bool normals;
} reader;

static qn_status fail_line(const reader *r, qn_error *error, const char *what) {
    return qni_fail_at(r->content, "line", r->text.line, error, "%s", what);
}

/* To the next line with something on it but a comment; false at the end of the file. */
static bool find_data(qni_text *text) {
    for (;;) {
        qni_skip_blanks(text);
        if (text->at == text->end)
            return false;
        if (!qni_at_line_end(text) && *text->at != '#')
            return true;
        qni_next_line(text);
    }
}

static bool take_letters(qni_text *text, const char *letters) {
    size_t length = strlen(letters);
    if ((size_t)(text->end - text->at) < length || memcmp(text->at, letters, length) != 0)
        return false;
    text->at += length;
    return true;
}

/* [ST][C][N][4][n]OFF [BINARY]; the keyword may be missing. */
static qn_status read_keyword(reader *r, qn_error *error) {
    qni_text *text = &r->text;
    if (!find_data(text))
        return qni_fail(error, QN_ERROR_INPUT, "cannot read '%.200s': it is empty",
                        r->content->path);
    if (*text->at >= '0' && *text->at <= '9' && qni_word_length(text) > 0 &&
        !(text->at[0] == '4' && text->end - text->at > 1 && text->at[1] == 'O'))
        return QN_OK;
    take_letters(text, "ST");
    take_letters(text, "C");
    r->normals = take_letters(text, "N");
    if (take_letters(text, "4") || take_letters(text, "n"))
        return fail_line(r, error, "vertices of other than three dimensions cannot be read");
    if (!take_letters(text, "OFF"))
        return fail_line(r, error, "an OFF file begins with 'OFF'; give the right format");
    qni_skip_blanks(text);
    if (qni_take_word(text, "BINARY"))
        return fail_line(r, error, "binary OFF files cannot be read; convert it to PLY");
    return QN_OK;
}

static qn_status read_counts(reader *r, int64_t *vertices_out, int64_t *faces_out,
                             qn_error *error) {
    if (!find_data(&r->text) || !qni_take_integer(&r->text, vertices_out) ||
        !qni_take_integer(&r->text, faces_out) || *vertices_out < 0 || *faces_out < 0)
        return fail_line(r, error, "the numbers of vertices and faces are expected here");
    qni_next_line(&r->text);
    /* "0 0 0" and a line end; "3 0 0 0", but lines of fewer corners as well. */
    int64_t left = r->text.end - r->text.at + 1;
    if (*vertices_out > left / 6 || *faces_out > left / 2)
        return qni_fail_at(
            r->content, "line", r->text.line, error,
            "%lld vertices and %lld faces are announced, but only %lld bytes follow; the "
            "file is cut short or damaged",
            (long long)*vertices_out, (long long)*faces_out, (long long)(left - 1));
    return QN_OK;
}

static qn_status read_vertices(reader *r, int64_t count, qn_error *error) {
    if (!qni_builder_reserve(r->builder, count, r->normals))
        return qni_fail_read_memory(r->content, error);
    for (int64_t i = 0; i < count; ++i) {
        float position[3], normal[3];
        if (i % QNI_PROGRESS_STEP == 0 && qni_read_stopped(r->content, r->text.at))
            return qni_fail_read_stopped(r->content, error);
        if (!find_data(&r->text))
            return qni_fail_at(r->content, "line", r->text.line, error,
                               "the file ends after %lld of %lld vertices; it is cut short",
                               (long long)i, (long long)count);
        if (!qni_take_vector(&r->text, position))
            return fail_line(r, error, "a vertex needs three numbers");
        if (r->normals && !qni_take_vector(&r->text, normal))
            return fail_line(r, error,
                             "a vertex of a NOFF file needs three numbers more, its normal");
        qni_next_line(&r->text);
        if (!qni_builder_add_vertex(r->builder, position, r->normals ? normal : NULL))
            return qni_fail_read_memory(r->content, error);
    }
    return QN_OK;
}

static bool reserve_corners(reader *r, int64_t count) {
    if (count <= r->capacity)
        return true;
    qni_free(r->content->context, r->corners, r->capacity, sizeof *r->corners);
    r->corners = qni_alloc(r->content->context, count, sizeof *r->corners);
    r->capacity = r->corners ? count : 0;
    return r->corners != NULL;
}

static qn_status read_face(reader *r, qn_error *error) {
    int64_t count, index;
    if (!qni_take_integer(&r->text, &count) || count < 0)
        return fail_line(r, error, "a face begins with the number of its corners");
    if (count > (r->text.end - r->text.at) / 2)
        return qni_fail_at(r->content, "line", r->text.line, error,
                           "a face of %lld corners is announced, but only %lld bytes follow",
                           (long long)count, (long long)(r->text.end - r->text.at));
    if (!reserve_corners(r, count))
        return qni_fail_read_memory(r->content, error);
    for (int64_t c = 0; c < count; ++c) {
        if (!qni_take_integer(&r->text, &index))
            return qni_fail_at(r->content, "line", r->text.line, error,
                               "a face of %lld corners names only %lld vertices", (long long)count,
                               (long long)c);
        if (index < 0 || index >= r->builder->positions.count)
            return qni_fail_at(r->content, "line", r->text.line, error,
                               "a face names vertex %lld, but there are %lld, counted from 0",
                               (long long)index, (long long)r->builder->positions.count);
        r->corners[c] = (uint32_t)index;
    }
    if (!qni_builder_add_face(r->builder, r->corners, count, r->text.line))
        return qni_fail_read_memory(r->content, error);
    qni_next_line(&r->text);
    return QN_OK;
}

static qn_status read_faces(reader *r, int64_t count, qn_error *error) {
    for (int64_t i = 0; i < count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 && qni_read_stopped(r->content, r->text.at))
            return qni_fail_read_stopped(r->content, error);
        if (!find_data(&r->text))
            return qni_fail_at(r->content, "line", r->text.line, error,
                               "the file ends after %lld of %lld faces; it is cut short",
                               (long long)i, (long long)count);
        QN_TRY(read_face(r, error));
    }
    return QN_OK;
}

static qn_status read_all(reader *r, qn_error *error) {
    int64_t vertices, faces;
    QN_TRY(read_keyword(r, error));
    QN_TRY(read_counts(r, &vertices, &faces, error));
    QN_TRY(read_vertices(r, vertices, error));
    return read_faces(r, faces, error);
}

qn_status qni_read_off(const qni_content *content, qni_builder *builder, qn_error *error) {
    reader r = {content, builder, qni_text_of(content), NULL, 0, false};
    qn_status status = read_all(&r, error);
    qni_free(content->context, r.corners, r.capacity, sizeof *r.corners);
    return status;
}
