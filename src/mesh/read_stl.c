// SPDX-License-Identifier: MIT
/* STL, binary and text. Which of them it is, the length says first: there are binary files that
 * begin with "solid". Facet normals are left out; the winding says the same. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/text.h"
#include "mesh/weld.h"

enum { HEADER_LENGTH = 84, FACET_LENGTH = 50, LARGEST_LOOP = 64 };

static int64_t announced(const qni_content *content) {
    return content->size < HEADER_LENGTH ? -1 : (int64_t)qni_get_u32(content->bytes + 80);
}

bool qni_is_binary_stl(const qni_content *content) {
    int64_t count = announced(content);
    return count >= 0 && content->size == HEADER_LENGTH + FACET_LENGTH * count;
}

/* What begins with "solid" is text, unless zero bytes give it away. */
static bool is_text(const qni_content *content) {
    qni_text text = qni_text_of(content);
    while (text.at < text.end && (qni_is_line_end(*text.at) || *text.at == ' ' || *text.at == '\t'))
        ++text.at;
    int64_t head = content->size < 512 ? content->size : 512;
    return text.end - text.at >= 5 && strncasecmp(text.at, "solid", 5) == 0 &&
           !memchr(content->bytes, 0, (size_t)head);
}

static qn_status read_binary(const qni_content *content, qni_builder *builder, qni_weld *weld,
                             qn_error *error) {
    int64_t count = announced(content), whole = HEADER_LENGTH + FACET_LENGTH * count;
    if (count < 0 || content->size < whole)
        return qni_fail(
            error, QN_ERROR_INPUT,
            "cannot read '%.200s': a binary STL file of %lld triangles takes %lld bytes, this one "
            "has %lld; it is cut short or no STL file",
            content->path, (long long)(count < 0 ? 0 : count),
            (long long)(count < 0 ? HEADER_LENGTH : whole), (long long)content->size);
    const char *at = content->bytes + HEADER_LENGTH;
    for (int64_t i = 0; i < count; ++i, at += FACET_LENGTH) {
        if (i % QNI_PROGRESS_STEP == 0 && qni_read_stopped(content, at))
            return qni_fail_read_stopped(content, error);
        uint32_t corners[3];
        bool good = true;
        for (int c = 0; c < 3; ++c) {
            float position[3];
            for (int a = 0; a < 3; ++a)
                position[a] = qni_get_f32(at + 12 * (c + 1) + 4 * a);
            good = good && qni_weld_vertex(weld, position, corners + c);
        }
        if (!good || !qni_builder_add_face(builder, corners, 3, i + 1))
            return qni_fail_read_memory(content, error);
    }
    return QN_OK;
}

typedef struct loop {
    uint32_t corners[LARGEST_LOOP];
    int64_t count;
    bool in_solid;
} loop;

static qn_status read_text_line(const qni_content *content, qni_text *text, qni_builder *builder,
                                qni_weld *weld, loop *own, qn_error *error) {
    if (qni_take_word(text, "vertex")) {
        float position[3];
        if (!qni_take_vector(text, position))
            return qni_fail_at(content, "line", text->line, error, "a vertex needs three numbers");
        if (own->count == LARGEST_LOOP)
            return qni_fail_at(content, "line", text->line, error,
                               "a facet has more than %d corners; it should have 3", LARGEST_LOOP);
        if (!qni_weld_vertex(weld, position, own->corners + own->count++))
            return qni_fail_read_memory(content, error);
    } else if (qni_take_word(text, "endloop")) {
        if (own->count < 3)
            return qni_fail_at(content, "line", text->line, error,
                               "a facet has %lld corners; it should have 3", (long long)own->count);
        if (!qni_builder_add_face(builder, own->corners, own->count, text->line))
            return qni_fail_read_memory(content, error);
        own->count = 0;
    } else if (qni_take_word(text, "solid")) {
        own->in_solid = true;
    } else if (qni_take_word(text, "endsolid")) {
        own->in_solid = false;
    } else if (!qni_take_word(text, "facet") && !qni_take_word(text, "outer") &&
               !qni_take_word(text, "endfacet")) {
        return qni_fail_at(content, "line", text->line, error,
                           "'%.*s' is no word of an STL file; the file is damaged",
                           (int)(qni_word_length(text) < 24 ? qni_word_length(text) : 24),
                           text->at);
    }
    return QN_OK;
}

static qn_status read_text(const qni_content *content, qni_builder *builder, qni_weld *weld,
                           qn_error *error) {
    qni_text text = qni_text_of(content);
    loop own = {.count = 0};
    for (int64_t lines = 0; text.at < text.end; ++lines) {
        if (lines % QNI_PROGRESS_STEP == 0 && qni_read_stopped(content, text.at))
            return qni_fail_read_stopped(content, error);
        qni_skip_blanks(&text);
        if (!qni_at_line_end(&text))
            QN_TRY(read_text_line(content, &text, builder, weld, &own, error));
        qni_next_line(&text);
    }
    if (own.in_solid || own.count)
        return qni_fail_at(content, "line", text.line, error,
                           "the file ends before 'endsolid'; it is cut short");
    return QN_OK;
}

qn_status qni_read_stl(const qni_content *content, qni_builder *builder, qn_error *error) {
    qni_weld weld = {.builder = builder};
    qn_status status = !qni_is_binary_stl(content) && is_text(content)
                           ? read_text(content, builder, &weld, error)
                           : read_binary(content, builder, &weld, error);
    qni_weld_free(&weld);
    return status;
}
