// SPDX-License-Identifier: MIT
/* MetaImage volumes: .mha with its samples inside, .mhd with a data file; plain, zlib-packed or
 * text. The numbers of TransformMatrix are the world directions of the axes, one axis after
 * another. */
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/load.h"

#include <math.h>
#include <string.h>

typedef struct meta_header {
    bool has_size, has_type, has_spacing;
    int64_t size[3];
    qn_scalar scalar;
    double spacing[3], element_size[3], origin[3];
    double direction[3][3]; /* direction[a]: unit step along axis a in the world */
    bool big_endian, packed, text;
    int64_t packed_size; /* 0: not said */
    int64_t
        header_size; /* bytes before the samples in the data file; -1: the samples are at its end */
    char space[32], unit[16];
    char data_file[1024];
} meta_header;

static bool parse_type(const char *text, qn_scalar *scalar) {
    static const struct {
        const char *name;
        qn_scalar scalar;
    } types[] = {{"MET_CHAR", QN_I8},    {"MET_UCHAR", QN_U8},  {"MET_SHORT", QN_I16},
                 {"MET_USHORT", QN_U16}, {"MET_INT", QN_I32},   {"MET_UINT", QN_U32},
                 {"MET_LONG", QN_I32},   {"MET_ULONG", QN_U32}, /* four bytes in MetaImage */
                 {"MET_FLOAT", QN_F32},  {"MET_DOUBLE", QN_F64}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (qni_text_same(text, types[i].name)) {
            *scalar = types[i].scalar;
            return true;
        }
    return false;
}

static bool is_one_of(const char *key, const char *a, const char *b, const char *c) {
    return qni_text_same(key, a) || qni_text_same(key, b) || (c && qni_text_same(key, c));
}

/* What says where and what the samples are; false when the value makes no sense. */
static bool parse_numbers(const char *key, const char *value, meta_header *header) {
    if (qni_text_same(key, "DimSize"))
        return header->has_size = qni_text_integers(value, 3, header->size);
    if (qni_text_same(key, "ElementSpacing"))
        return header->has_spacing = qni_text_doubles(value, 3, header->spacing);
    if (qni_text_same(key, "ElementSize"))
        return qni_text_doubles(value, 3, header->element_size);
    if (is_one_of(key, "Offset", "Origin", "Position"))
        return qni_text_doubles(value, 3, header->origin);
    if (is_one_of(key, "TransformMatrix", "Rotation", "Orientation"))
        return qni_text_doubles(value, 9, header->direction[0]);
    if (qni_text_same(key, "CompressedDataSize"))
        return qni_text_integers(value, 1, &header->packed_size) && header->packed_size >= 0;
    if (qni_text_same(key, "HeaderSize"))
        return qni_text_integers(value, 1, &header->header_size) && header->header_size >= -1;
    return true;
}

static void parse_words(const char *key, const char *value, meta_header *header) {
    if (is_one_of(key, "BinaryDataByteOrderMSB", "ElementByteOrderMSB", NULL))
        header->big_endian = qni_text_boolean(value);
    else if (qni_text_same(key, "CompressedData"))
        header->packed = qni_text_boolean(value);
    else if (qni_text_same(key, "BinaryData"))
        header->text = !qni_text_boolean(value);
    else if (qni_text_same(key, "AnatomicalOrientation"))
        strcpy(header->space, "LPS"); /* the world of all programs that write this field */
    else if (qni_text_same(key, "DistanceUnits") && is_one_of(value, "mm", "cm", "um"))
        strcpy(header->unit, value);
}

static qn_status check_scope(const qni_source *source, const char *key, const char *value,
                             qn_error *error) {
    if (qni_text_same(key, "ObjectType") && !qni_text_same(value, "Image"))
        return qni_source_fail(source, error, "is a MetaIO file of a %.40s, not of an Image",
                               value);
    if (qni_text_same(key, "NDims") && !qni_text_same(value, "3"))
        return qni_source_fail(source, error, "is a MetaImage of %.20s dimensions; a volume has 3",
                               value);
    if (qni_text_same(key, "ElementNumberOfChannels") && !qni_text_same(value, "1"))
        return qni_source_fail(
            source, error,
            "has %.20s channels; a volume has one number a sample: save one channel as a "
            "file of its own",
            value);
    return QN_OK;
}

static qn_status parse_data_file(const qni_source *source, const char *value, meta_header *header,
                                 qn_error *error) {
    if (strncmp(value, "LIST", 4) == 0 || strchr(value, '%'))
        return qni_source_fail(
            source, error, "its header names several data files (%.60s); join them into one file",
            value);
    if (!value[0] || strlen(value) >= sizeof header->data_file)
        return qni_source_fail(source, error, "the name of its data file is empty or too long");
    strcpy(header->data_file, value);
    return QN_OK;
}

static qn_status parse_field(const qni_source *source, char *line, meta_header *header,
                             qn_error *error) {
    char *key, *value;
    if (!qni_text_split(line, '=', &key, &value))
        return qni_source_fail(source, error, "its MetaImage header has a line without '=': %.60s",
                               line);
    QN_TRY(check_scope(source, key, value, error));
    if (qni_text_same(key, "ElementType")) {
        header->has_type = parse_type(value, &header->scalar);
        if (!header->has_type)
            return qni_source_fail(
                source, error,
                "samples of type '%.40s' are not read; convert them to integers of 8 to 32 "
                "bits, or to float",
                value);
    }
    if (qni_text_same(key, "ElementDataFile"))
        return parse_data_file(source, value, header, error);
    parse_words(key, value, header);
    if (!parse_numbers(key, value, header))
        return qni_source_fail(source, error,
                               "its header has '%.40s = %.80s', which makes no sense", key, value);
    return QN_OK;
}

/* ElementDataFile is the last field by definition. */
static qn_status parse_header(qni_source *source, meta_header *header, qn_error *error) {
    while (!header->data_file[0]) {
        char line[4096];
        bool ended;
        QN_TRY(qni_source_line(source, line, sizeof line, &ended, error));
        if (ended)
            return qni_source_fail(source, error,
                                   "its MetaImage header has no field 'ElementDataFile'");
        if (*qni_text_trim(line))
            QN_TRY(parse_field(source, line, header, error));
    }
    if (!header->has_size || !header->has_type)
        return qni_source_fail(source, error, "its MetaImage header has no field '%s'",
                               header->has_size ? "ElementType" : "DimSize");
    return QN_OK;
}

static void fill_matrix(const meta_header *header, double matrix[4][4]) {
    const double *spacing = header->has_spacing ? header->spacing : header->element_size;
    for (int a = 0; a < 3; ++a) {
        for (int row = 0; row < 3; ++row)
            matrix[row][a] = header->direction[a][row] * spacing[a];
        matrix[a][3] = header->origin[a];
    }
    matrix[3][3] = 1;
}

static qn_status skip_to_samples(qni_source *source, const meta_header *header, const qn_grid *grid,
                                 qn_error *error) {
    int64_t skip = header->header_size;
    if (skip < 0) {
        int64_t rest = qni_source_bound(source), bytes = header->packed_size;
        if (!header->packed)
            QN_TRY(qni_load_bytes(source, grid, &bytes, error));
        if (source->inflate || source->file_size < 0 || (header->packed && bytes == 0) ||
            header->text)
            return qni_source_fail(source, error,
                                   "'HeaderSize = -1' needs a plain data file of known size");
        if (rest < bytes)
            return qni_source_fail_truncated(source, bytes, source->offset, rest, error);
        skip = rest - bytes;
    }
    return qni_source_skip(source, skip, error);
}

static qn_status load(qni_source *source, const meta_header *header, qn_grid *grid,
                      qn_volume **volume_out, qn_error *error) {
    QN_TRY(skip_to_samples(source, header, grid, error));
    if (header->packed && !source->inflate) {
        if (header->packed_size > qni_source_bound(source))
            return qni_source_fail_truncated(source, header->packed_size, source->offset,
                                             qni_source_bound(source), error);
        QN_TRY(qni_source_inflate(source, error));
    }
    return qni_load(source, grid, header->text ? QNI_TEXT : QNI_BINARY, "metaimage", NULL,
                    volume_out, error);
}

qn_status qni_read_metaimage(qni_source *source, const qn_volume_read_options *options,
                             qn_volume **volume_out, qn_error *error) {
    meta_header header = {.element_size = {1, 1, 1},
                          .direction = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    QN_TRY(parse_header(source, &header, error));
    qn_grid grid = {.slope = 1, .scalar = header.scalar};
    for (int a = 0; a < 3; ++a)
        grid.size[a] = header.size[a];
    grid.swapped = !header.text && header.big_endian != qni_machine_is_big_endian();
    memcpy(grid.space, header.space, sizeof grid.space);
    memcpy(grid.unit, header.unit, sizeof grid.unit);
    fill_matrix(&header, grid.index_to_world);
    QN_TRY(qni_load_overrides(source, options, grid.index_to_world, error));
    if (qni_text_same(header.data_file, "LOCAL"))
        return load(source, &header, &grid, volume_out, error);
    qni_source data;
    QN_TRY(qni_source_open_beside(source, header.data_file, &data, error));
    qn_status status = load(&data, &header, &grid, volume_out, error);
    qni_source_close(&data);
    return status;
}
