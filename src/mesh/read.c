// SPDX-License-Identifier: MIT
/* Reading a mesh: which format it is, by what was asked, the file's name, or its first bytes. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/text.h"

#include <stdarg.h>
#include <stdio.h>

qn_status qni_fail_at(const qni_content *content, const char *place, int64_t number,
                      qn_error *error, const char *format, ...) {
    char reason[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(reason, sizeof reason, format, arguments);
    va_end(arguments);
    return qni_fail(error, QN_ERROR_INPUT, "cannot read '%.200s': %s %lld: %s", content->path,
                    place, (long long)number, reason);
}

qn_status qni_fail_read_memory(const qni_content *content, qn_error *error) {
    return qni_fail(error, QN_ERROR_OUT_OF_MEMORY, "not enough memory for the mesh of '%.200s'",
                    content->path);
}

bool qni_read_stopped(const qni_content *content, const char *at) {
    double share = (double)(at - content->bytes) / (double)(content->size + 1);
    return qni_progress(content->context, "read", 0.5 + 0.5 * share);
}

qn_status qni_fail_read_stopped(const qni_content *content, qn_error *error) {
    return qni_fail(error, QN_ERROR_CANCELLED, "cancelled while reading '%.200s'", content->path);
}

/* The first word of a line that is no comment, as OBJ files have it. */
static bool looks_like_obj(const qni_content *content) {
    static const char *const words[] = {"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"};
    qni_text text = qni_text_of(content);
    while (text.at < text.end && text.line < 1000) {
        qni_skip_blanks(&text);
        if (!qni_at_line_end(&text) && *text.at != '#') {
            for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
                if (qni_take_word(&text, words[i]))
                    return true;
            return false;
        }
        qni_next_line(&text);
    }
    return false;
}

static bool begins(const qni_content *content, const char *text) {
    size_t length = strlen(text);
    return (size_t)content->size >= length && memcmp(content->bytes, text, length) == 0;
}

static qni_mesh_format format_of_content(const qni_content *content) {
    if (begins(content, "ply\n") || begins(content, "ply\r"))
        return QNI_PLY;
    if (begins(content, "OFF") || begins(content, "NOFF") || begins(content, "COFF") ||
        begins(content, "CNOFF") || begins(content, "STOFF"))
        return QNI_OFF;
    if (begins(content, "glTF") || begins(content, "{"))
        return QNI_GLB;
    if (qni_is_binary_stl(content) || begins(content, "solid"))
        return QNI_STL;
    return looks_like_obj(content) ? QNI_OBJ : QNI_NO_FORMAT;
}

static qn_status choose_format(const qni_content *content, const char *format,
                               qni_mesh_format *format_out, qn_error *error) {
    const char *path = content->path;
    if (format && *format) {
        *format_out = qni_mesh_format_named(format, strlen(format), true);
        if (*format_out == QNI_NO_FORMAT)
            return qni_fail(
                error, QN_ERROR_INVALID_ARGUMENT,
                "'%.16s' is no mesh format to read: take ply, obj, stl, off, glb or gltf", format);
    } else {
        *format_out = qni_mesh_format_of_path(path, true);
        if (*format_out == QNI_NO_FORMAT)
            *format_out = format_of_content(content);
    }
    if (*format_out == QNI_NO_FORMAT)
        return qni_fail(
            error, QN_ERROR_INPUT,
            "cannot read '%.200s': neither its name nor its first bytes are those of a PLY, OBJ, "
            "STL, OFF, GLB or glTF file; give the format",
            path);
    return QN_OK;
}

static qn_status read_content(const qni_content *content, const char *format, qni_builder *builder,
                              const char **place_out, qn_error *error) {
    qni_mesh_format chosen;
    QN_TRY(choose_format(content, format, &chosen, error));
    *place_out = chosen == QNI_OBJ || chosen == QNI_OFF ? "line" : "face";
    static qn_status (*const readers[])(const qni_content *, qni_builder *, qn_error *) = {
        qni_read_ply, qni_read_obj, qni_read_stl, qni_read_off, qni_read_gltf};
    return readers[chosen](content, builder, error);
}

qn_status qn_mesh_read(qn_context *context, const char *path, const char *format,
                       qn_mesh **mesh_out, qn_error *error) {
    *mesh_out = NULL;
    qni_content content;
    QN_TRY(qni_content_load(context, path, &content, error));
    qni_builder builder;
    qni_builder_start(&builder, context);
    const char *place = "line";
    qn_status status = read_content(&content, format, &builder, &place, error);
    qni_content_free(&content);
    if (status == QN_OK)
        return qni_builder_finish(&builder, path, place, mesh_out, error);
    qni_builder_free(&builder);
    return status;
}
