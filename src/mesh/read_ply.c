// SPDX-License-Identifier: MIT
/* PLY: text or binary of either byte order, properties of any order and type; faces may have an
 * owner, material_index, material or group. Other elements are passed over. */
#include "core/context.h"
#include "core/status.h"
#include "mesh/format.h"
#include "mesh/ply_header.h"

typedef struct reader {
    const qni_content *content;
    qni_builder *builder;
    qni_ply_header header;
    qni_text text;
    uint32_t *corners;
    int64_t capacity, corner_count;
} reader;

static qn_status fail_here(const reader *r, qn_error *error, const char *what) {
    if (r->header.ascii)
        return qni_fail_at(r->content, "line", r->text.line, error, "%s", what);
    return qni_fail_at(r->content, "byte", r->text.at - r->content->bytes, error, "%s", what);
}

static qn_status fail_end(const reader *r, qn_error *error) {
    return fail_here(r, error, "the file ends within its data; it is cut short");
}

static double value_of(const unsigned char bytes[8], qni_ply_type type) {
    uint64_t bits = 0;
    int64_t size = qni_ply_size(type);
    for (int64_t b = 0; b < size; ++b)
        bits |= (uint64_t)bytes[b] << (8 * b);
    switch (type) {
    case QNI_PLY_I8:
        return (int8_t)bits;
    case QNI_PLY_I16:
        return (int16_t)bits;
    case QNI_PLY_I32:
        return (int32_t)bits;
    case QNI_PLY_F32: {
        uint32_t low = (uint32_t)bits;
        float value;
        memcpy(&value, &low, sizeof value);
        return (double)value;
    }
    case QNI_PLY_F64: {
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    default:
        return (double)bits;
    }
}

static bool take_binary(reader *r, qni_ply_type type, double *value_out) {
    int64_t size = qni_ply_size(type);
    if (r->text.end - r->text.at < size)
        return false;
    unsigned char bytes[8];
    for (int64_t b = 0; b < size; ++b)
        bytes[b] = (unsigned char)r->text.at[r->header.big_endian ? size - 1 - b : b];
    *value_out = value_of(bytes, type);
    r->text.at += size;
    return true;
}

/* Lines mean nothing to the data of a text file but blanks between numbers. */
static bool take_ascii(qni_text *text, double *value_out) {
    for (qni_skip_blanks(text); text->at < text->end && qni_at_line_end(text);
         qni_skip_blanks(text))
        qni_next_line(text);
    return qni_take_double(text, value_out);
}

static qn_status take_value(reader *r, qni_ply_type type, double *value_out, qn_error *error) {
    if (r->header.ascii ? take_ascii(&r->text, value_out) : take_binary(r, type, value_out))
        return QN_OK;
    return r->text.at == r->text.end || !r->header.ascii
               ? fail_end(r, error)
               : fail_here(r, error, "a number is expected here");
}

static bool reserve_corners(reader *r, int64_t count) {
    if (count <= r->capacity)
        return true;
    qni_free(r->content->context, r->corners, r->capacity, sizeof *r->corners);
    r->corners = qni_alloc(r->content->context, count, sizeof *r->corners);
    r->capacity = r->corners ? count : 0;
    return r->corners != NULL;
}

static qn_status take_corners(reader *r, qni_ply_type type, int64_t count, qn_error *error) {
    if (!reserve_corners(r, count))
        return qni_fail_read_memory(r->content, error);
    r->corner_count = count;
    for (int64_t i = 0; i < count; ++i) {
        double index;
        QN_TRY(take_value(r, type, &index, error));
        if (!(index >= 0 && index <= (double)UINT32_MAX) || index != (double)(uint32_t)index)
            return fail_here(r, error, "the number of a vertex must be a whole number from 0");
        r->corners[i] = (uint32_t)index;
    }
    return QN_OK;
}

static qn_status take_list(reader *r, const qni_ply_property *property, qn_error *error) {
    double length;
    QN_TRY(take_value(r, property->count_type, &length, error));
    int64_t least = r->header.ascii ? 1 : qni_ply_size(property->type);
    if (!(length >= 0 && length <= (double)((r->text.end - r->text.at) / least)))
        return fail_here(r, error, "a list here is longer than the rest of the file");
    int64_t count = (int64_t)length;
    if (property->role == QNI_PLY_CORNERS)
        return take_corners(r, property->type, count, error);
    if (!r->header.ascii) {
        r->text.at += count * least;
        return QN_OK;
    }
    for (int64_t i = 0; i < count; ++i)
        QN_TRY(take_value(r, property->type, &length, error));
    return QN_OK;
}

/* The vectors of a vertex, by role; of a face the corners and the owner. */
static qn_status take_item(reader *r, const qni_ply_element *element, float vectors[6],
                           qn_error *error) {
    for (int p = element->first; p < element->last; ++p) {
        const qni_ply_property *property = r->header.properties + p;
        if (property->count_type != QNI_PLY_NO_TYPE) {
            QN_TRY(take_list(r, property, error));
            continue;
        }
        double value;
        QN_TRY(take_value(r, property->type, &value, error));
        if (property->role >= QNI_PLY_X && property->role <= QNI_PLY_NZ)
            vectors[property->role - QNI_PLY_X] = (float)value;
        else if (property->role == QNI_PLY_OWNER)
            r->builder->owner = value >= INT32_MIN && value <= INT32_MAX ? (int32_t)value : 0;
    }
    return QN_OK;
}

static qn_status read_items(reader *r, const qni_ply_element *element, qn_error *error) {
    bool normals = element->has_role[QNI_PLY_NX] && element->has_role[QNI_PLY_NY] &&
                   element->has_role[QNI_PLY_NZ];
    if (element->is_vertex && !qni_builder_reserve(r->builder, element->count, normals))
        return qni_fail_read_memory(r->content, error);
    for (int64_t i = 0; i < element->count; ++i) {
        if (i % QNI_PROGRESS_STEP == 0 && qni_read_stopped(r->content, r->text.at))
            return qni_fail_read_stopped(r->content, error);
        float vectors[6] = {0};
        r->corner_count = 0;
        QN_TRY(take_item(r, element, vectors, error));
        bool good = true;
        if (element->is_vertex)
            good = qni_builder_add_vertex(r->builder, vectors, normals ? vectors + 3 : NULL);
        else if (element->is_face)
            good = qni_builder_add_face(r->builder, r->corners, r->corner_count, i + 1);
        if (!good)
            return qni_fail_read_memory(r->content, error);
    }
    return QN_OK;
}

static qn_status check_element(const reader *r, const qni_ply_element *element, qn_error *error) {
    int64_t left = r->text.end - r->text.at + 1;
    if (element->least_bytes && element->count > left / element->least_bytes)
        return qni_fail_at(
            r->content, "byte", r->text.at - r->content->bytes, error,
            "%lld %s are announced, but only %lld bytes follow; the file is cut short or "
            "damaged",
            (long long)element->count,
            element->is_vertex ? "vertices"
            : element->is_face ? "faces"
                               : "items",
            (long long)(left - 1));
    if (element->is_vertex && element->count &&
        !(element->has_role[QNI_PLY_X] && element->has_role[QNI_PLY_Y] &&
          element->has_role[QNI_PLY_Z]))
        return fail_here(r, error, "the vertices have no x, y and z");
    if (element->is_face && element->count && !element->has_role[QNI_PLY_CORNERS])
        return fail_here(r, error, "the faces have no list vertex_indices");
    return QN_OK;
}

static qn_status read_elements(reader *r, qn_error *error) {
    bool seen_vertices = false, seen_faces = false;
    for (int e = 0; e < r->header.element_count; ++e) {
        const qni_ply_element *element = r->header.elements + e;
        if ((element->is_vertex && seen_vertices) || (element->is_face && seen_faces))
            return fail_here(r, error, "the same element a second time");
        seen_vertices = seen_vertices || element->is_vertex;
        seen_faces = seen_faces || element->is_face;
        QN_TRY(check_element(r, element, error));
        if (element->first < element->last) /* what has no properties has no data */
            QN_TRY(read_items(r, element, error));
    }
    return QN_OK;
}

qn_status qni_read_ply(const qni_content *content, qni_builder *builder, qn_error *error) {
    reader r = {.content = content, .builder = builder, .text = qni_text_of(content)};
    QN_TRY(qni_ply_read_header(content, &r.text, &r.header, error));
    memcpy(builder->space, r.header.space, sizeof builder->space);
    memcpy(builder->unit, r.header.unit, sizeof builder->unit);
    qn_status status = read_elements(&r, error);
    qni_free(content->context, r.corners, r.capacity, sizeof *r.corners);
    return status;
}
