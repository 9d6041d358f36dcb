// SPDX-License-Identifier: MIT
/* The header of a PLY file, line by line. */
#include "mesh/ply_header.h"
#include "core/status.h"
#include "mesh/format.h"

int64_t qni_ply_size(qni_ply_type type) {
    switch (type) {
#define PLY_SIZE(name, old, today, size)                                                           \
    case QNI_PLY_##name:                                                                           \
        return size;
        QNI_PLY_TYPES(PLY_SIZE)
#undef PLY_SIZE
    case QNI_PLY_NO_TYPE:
        break;
    }
    return 0;
}

static qn_status fail_line(const qni_content *content, const qni_text *text, qn_error *error,
                           const char *what) {
    return qni_fail_at(content, "line", text->line, error, "%s", what);
}

static qni_ply_type take_type(qni_text *text) {
    qni_skip_blanks(text);
#define PLY_TAKE(name, old, today, size)                                                           \
    if (qni_take_word(text, old) || qni_take_word(text, today))                                    \
        return QNI_PLY_##name;
    QNI_PLY_TYPES(PLY_TAKE)
#undef PLY_TAKE
    return QNI_PLY_NO_TYPE;
}

static qn_status read_format(const qni_content *content, qni_text *text, qni_ply_header *header,
                             qn_error *error) {
    qni_skip_blanks(text);
    if (qni_take_word(text, "ascii"))
        header->ascii = true;
    else if (qni_take_word(text, "binary_big_endian"))
        header->big_endian = true;
    else if (!qni_take_word(text, "binary_little_endian"))
        return fail_line(content, text, error,
                         "the format must be ascii, binary_little_endian or binary_big_endian");
    return QN_OK;
}

static qn_status read_element(const qni_content *content, qni_text *text, qni_ply_header *header,
                              qn_error *error) {
    if (header->element_count == QNI_PLY_ELEMENTS)
        return qni_fail_at(content, "line", text->line, error, "more than %d elements",
                           QNI_PLY_ELEMENTS);
    qni_ply_element *element = header->elements + header->element_count++;
    *element = (qni_ply_element){.first = header->property_count, .last = header->property_count};
    qni_skip_blanks(text);
    element->is_vertex = qni_take_word(text, "vertex");
    element->is_face = !element->is_vertex && qni_take_word(text, "face");
    text->at += qni_word_length(text);
    if (!qni_take_integer(text, &element->count) || element->count < 0)
        return fail_line(content, text, error, "an element needs a name and a count");
    return QN_OK;
}

static qni_ply_role role_of(qni_text *text, bool is_vertex, bool is_list) {
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int i = 0; is_vertex && !is_list && i < 6; ++i)
        if (qni_take_word(text, names[i]))
            return (qni_ply_role)(QNI_PLY_X + i);
    if (!is_vertex && is_list &&
        (qni_take_word(text, "vertex_indices") || qni_take_word(text, "vertex_index")))
        return QNI_PLY_CORNERS;
    static const char *const owners[] = {"owner", "material_index", "material", "group"};
    for (int i = 0; !is_vertex && !is_list && i < 4; ++i)
        if (qni_take_word(text, owners[i]))
            return QNI_PLY_OWNER;
    return QNI_PLY_OTHER;
}

static qn_status read_property(const qni_content *content, qni_text *text, qni_ply_header *header,
                               qn_error *error) {
    if (header->element_count == 0)
        return fail_line(content, text, error, "a property without an element before it");
    if (header->property_count == QNI_PLY_PROPERTIES)
        return qni_fail_at(content, "line", text->line, error, "more than %d properties",
                           QNI_PLY_PROPERTIES);
    qni_ply_element *element = header->elements + header->element_count - 1;
    qni_ply_property *property = header->properties + header->property_count++;
    ++element->last;
    *property = (qni_ply_property){.count_type = QNI_PLY_NO_TYPE};
    qni_skip_blanks(text);
    bool is_list = qni_take_word(text, "list");
    if (is_list) {
        property->count_type = take_type(text);
        if (property->count_type == QNI_PLY_NO_TYPE || property->count_type >= QNI_PLY_F32)
            return fail_line(content, text, error,
                             "the length of a list needs a whole-number type");
    }
    property->type = take_type(text);
    if (property->type == QNI_PLY_NO_TYPE)
        return fail_line(content, text, error, "a property needs a type such as float or uchar");
    qni_skip_blanks(text);
    property->role = role_of(text, element->is_vertex, is_list);
    bool second_owner = property->role == QNI_PLY_OWNER && element->has_role[QNI_PLY_OWNER];
    if ((!element->is_vertex && !element->is_face) || second_owner)
        property->role = QNI_PLY_OTHER;
    if (element->has_role[property->role] && property->role != QNI_PLY_OTHER)
        return fail_line(content, text, error, "the same property a second time");
    element->has_role[property->role] = true;
    element->least_bytes +=
        header->ascii ? 2 : qni_ply_size(is_list ? property->count_type : property->type);
    return QN_OK;
}

/* "comment space RAS", "comment unit mm": as Quoin writes them. */
static void read_comment(qni_text *text, qni_ply_header *header) {
    qni_skip_blanks(text);
    bool is_space = qni_take_word(text, "space");
    if (!is_space && !qni_take_word(text, "unit"))
        return;
    qni_skip_blanks(text);
    char *to = is_space ? header->space : header->unit;
    size_t room = is_space ? sizeof header->space : sizeof header->unit;
    size_t length = 0;
    while (length + 1 < room && text->at + length < text->end &&
           !qni_is_line_end(text->at[length])) {
        to[length] = text->at[length];
        ++length;
    }
    to[length] = 0;
}

static qn_status read_line(const qni_content *content, qni_text *text, qni_ply_header *header,
                           bool *has_format, qn_error *error) {
    if (qni_take_word(text, "format")) {
        *has_format = true;
        return read_format(content, text, header, error);
    }
    if (qni_take_word(text, "comment"))
        read_comment(text, header);
    else if (qni_take_word(text, "element"))
        return read_element(content, text, header, error);
    else if (qni_take_word(text, "property"))
        return read_property(content, text, header, error);
    else if (!qni_at_line_end(text) && !qni_take_word(text, "obj_info"))
        return qni_fail_at(content, "line", text->line, error, "'%.*s' is no word of a PLY header",
                           (int)(qni_word_length(text) < 24 ? qni_word_length(text) : 24),
                           text->at);
    return QN_OK;
}

qn_status qni_ply_read_header(const qni_content *content, qni_text *text, qni_ply_header *header,
                              qn_error *error) {
    *header = (qni_ply_header){0};
    bool has_format = false;
    if (!qni_take_word(text, "ply"))
        return fail_line(content, text, error,
                         "a PLY file begins with 'ply'; give the right format");
    for (;;) {
        qni_next_line(text);
        if (text->at == text->end)
            return fail_line(content, text, error,
                             "the header does not end; the file is cut short");
        qni_skip_blanks(text);
        if (qni_take_word(text, "end_header"))
            break;
        QN_TRY(read_line(content, text, header, &has_format, error));
    }
    if (!has_format)
        return fail_line(content, text, error, "the header names no format");
    if (text->at == text->end)
        return header->element_count
                   ? fail_line(content, text, error, "the file ends with its header")
                   : QN_OK;
    /* A data byte that happens to be a line feed must not be taken for the end of a line in CR
     * style: CR LF is taken whole only when the header's first line ended so. */
    bool crlf = content->size > 4 && content->bytes[3] == '\r' && content->bytes[4] == '\n';
    while (text->at < text->end && !qni_is_line_end(*text->at))
        ++text->at;
    if (text->at < text->end)
        text->at += crlf && text->at + 1 < text->end && text->at[1] == '\n' ? 2 : 1;
    ++text->line;
    return QN_OK;
}
