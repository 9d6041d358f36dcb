// SPDX-License-Identifier: MIT
/* NRRD volumes of three axes: attached (.nrrd) and detached (.nhdr with one data file), encodings
 * raw, gzip and text. Coordinates stay in the file's own space, whose name is kept in short form.
 */
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/load.h"

#include <math.h>
#include <string.h>

typedef enum nrrd_encoding { NRRD_NONE, NRRD_RAW, NRRD_GZIP, NRRD_TEXT } nrrd_encoding;

typedef struct nrrd_header {
    bool has_type, has_sizes, has_spacings, has_directions, has_endian;
    int64_t dimension;
    int64_t size[3];
    qn_scalar scalar;
    nrrd_encoding encoding;
    bool big_endian;
    double spacing[3];
    double direction[3][3]; /* direction[a] is the step along axis a in the world */
    double origin[3];
    char space[32], unit[16];
    int64_t line_skip, byte_skip;
    char data_file[1024];
} nrrd_header;

static bool parse_type(const char *text, qn_scalar *scalar) {
    static const struct {
        qn_scalar scalar;
        const char *names[7];
    } types[] = {
        {QN_I8, {"signed char", "int8", "int8_t"}},
        {QN_U8, {"uchar", "unsigned char", "uint8", "uint8_t"}},
        {QN_I16, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
        {QN_U16, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
        {QN_I32, {"int", "signed int", "int32", "int32_t"}},
        {QN_U32, {"uint", "unsigned int", "uint32", "uint32_t"}},
        {QN_F32, {"float"}},
        {QN_F64, {"double"}},
    };
    for (size_t t = 0; t < sizeof types / sizeof types[0]; ++t)
        for (int n = 0; n < 7 && types[t].names[n]; ++n)
            if (qni_text_same(text, types[t].names[n])) {
                *scalar = types[t].scalar;
                return true;
            }
    return false;
}

/* Short names of the three-dimensional spaces; others stay unnamed. */
static void parse_space(const char *text, char space[32]) {
    static const char *const names[][2] = {
        {"right-anterior-superior", "RAS"},   {"RAS", "RAS"},
        {"left-anterior-superior", "LAS"},    {"LAS", "LAS"},
        {"left-posterior-superior", "LPS"},   {"LPS", "LPS"},
        {"scanner-xyz", "scanner-xyz"},       {"3D-right-handed", "3D-right-handed"},
        {"3D-left-handed", "3D-left-handed"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (qni_text_same(text, names[i][0]))
            strcpy(space, names[i][1]);
}

/* "(1,0,0)" at *at, which moves past it. */
static bool parse_vector(const char **at, double vector[3]) {
    *at += strspn(*at, " \t");
    if (**at != '(')
        return false;
    ++*at;
    for (int i = 0; i < 3; ++i)
        if (!qni_text_double(at, &vector[i]))
            return false;
    *at += strspn(*at, " \t");
    return *(*at)++ == ')';
}

static bool parse_directions(const char *text, double direction[3][3]) {
    for (int a = 0; a < 3; ++a)
        if (!parse_vector(&text, direction[a]))
            return false;
    return text[strspn(text, " \t")] == 0;
}

/* `"mm" "mm" "mm"`: one unit for all axes, or none. */
static void parse_units(const char *text, char unit[16]) {
    char first[16] = "";
    for (int a = 0; a < 3; ++a) {
        const char *open = strchr(text, '"');
        const char *end = open ? strchr(open + 1, '"') : NULL;
        size_t length = end ? (size_t)(end - open - 1) : 16;
        if (length > 15 ||
            (a > 0 && (strlen(first) != length || memcmp(first, open + 1, length) != 0)))
            return;
        memcpy(first, open + 1, length);
        first[length] = 0;
        text = end + 1;
    }
    strcpy(unit, first);
}

static qn_status parse_encoding(const qni_source *source, const char *text, nrrd_encoding *encoding,
                                qn_error *error) {
    if (qni_text_same(text, "raw"))
        *encoding = NRRD_RAW;
    else if (qni_text_same(text, "gz") || qni_text_same(text, "gzip"))
        *encoding = NRRD_GZIP;
    else if (qni_text_same(text, "txt") || qni_text_same(text, "text") ||
             qni_text_same(text, "ascii"))
        *encoding = NRRD_TEXT;
    else
        return qni_source_fail(
            source, error, "NRRD encoding '%.40s' is not read; save it as raw, gzip or text", text);
    return QN_OK;
}

static qn_status parse_data_file(const qni_source *source, const char *text, nrrd_header *header,
                                 qn_error *error) {
    bool list = strncasecmp(text, "LIST", 4) == 0 && (text[4] == 0 || text[4] == ' ');
    if (list || strchr(text, '%'))
        return qni_source_fail(
            source, error,
            "its NRRD header names several data files (%.60s); join them into one file", text);
    if (strlen(text) >= sizeof header->data_file)
        return qni_source_fail(source, error, "the name of its data file is too long");
    strcpy(header->data_file, text);
    return QN_OK;
}

static qn_status parse_dimension(const qni_source *source, const char *text, nrrd_header *header,
                                 qn_error *error) {
    if (!qni_text_integers(text, 1, &header->dimension))
        return qni_source_fail(source, error, "its NRRD header has 'dimension: %.40s'", text);
    if (header->dimension != 3)
        return qni_source_fail(
            source, error,
            "is an NRRD file of %lld axes; a volume has 3, with one number a sample (no "
            "colours, vectors or time): save one channel as a file of its own",
            (long long)header->dimension);
    return QN_OK;
}

static qn_status parse_type_field(const qni_source *source, const char *text, nrrd_header *header,
                                  qn_error *error) {
    header->has_type = parse_type(text, &header->scalar);
    if (!header->has_type)
        return qni_source_fail(
            source, error,
            "samples of NRRD type '%.40s' are not read; convert them to integers of 8 to "
            "32 bits, or to float",
            text);
    return QN_OK;
}

/* The fields that are numbers or vectors; false when the value makes no sense. */
static bool parse_numbers(const char *key, const char *value, nrrd_header *header) {
    const char *at = value;
    if (qni_text_same(key, "sizes"))
        return header->has_sizes = qni_text_integers(value, 3, header->size);
    if (qni_text_same(key, "spacings"))
        return header->has_spacings = qni_text_doubles(value, 3, header->spacing);
    if (qni_text_same(key, "space directions"))
        return header->has_directions = parse_directions(value, header->direction);
    if (qni_text_same(key, "space origin"))
        return parse_vector(&at, header->origin);
    if (qni_text_same(key, "line skip") || qni_text_same(key, "lineskip"))
        return qni_text_integers(value, 1, &header->line_skip) && header->line_skip >= 0;
    if (qni_text_same(key, "byte skip") || qni_text_same(key, "byteskip"))
        return qni_text_integers(value, 1, &header->byte_skip) && header->byte_skip >= -1;
    if (qni_text_same(key, "endian")) {
        header->big_endian = qni_text_same(value, "big");
        return header->has_endian = header->big_endian || qni_text_same(value, "little");
    }
    if (qni_text_same(key, "space dimension"))
        return qni_text_same(value, "3");
    return true; /* a field that says nothing about where and what the samples are */
}

static qn_status parse_field(const qni_source *source, char *line, nrrd_header *header,
                             qn_error *error) {
    char *key, *value;
    const char *colon = strchr(line, ':');
    if (line[0] == '#' || (colon && colon[1] == '=')) /* a comment, or a key of the user's own */
        return QN_OK;
    if (!qni_text_split(line, ':', &key, &value))
        return qni_source_fail(source, error, "its NRRD header has a line without a colon: %.60s",
                               line);
    if (qni_text_same(key, "type"))
        return parse_type_field(source, value, header, error);
    if (qni_text_same(key, "dimension"))
        return parse_dimension(source, value, header, error);
    if (qni_text_same(key, "encoding"))
        return parse_encoding(source, value, &header->encoding, error);
    if (qni_text_same(key, "data file") || qni_text_same(key, "datafile"))
        return parse_data_file(source, value, header, error);
    if (qni_text_same(key, "space"))
        parse_space(value, header->space);
    if (qni_text_same(key, "space units") || (qni_text_same(key, "units") && !header->unit[0]))
        parse_units(value, header->unit);
    if (!parse_numbers(key, value, header))
        return qni_source_fail(
            source, error, "its NRRD header has '%.40s: %.80s', which makes no sense", key, value);
    return QN_OK;
}

static qn_status check_header(const qni_source *source, const nrrd_header *header,
                              qn_error *error) {
    const char *missing =
        !header->dimension              ? "dimension"
        : !header->has_type             ? "type"
        : !header->has_sizes            ? "sizes"
        : header->encoding == NRRD_NONE ? "encoding"
        : !header->has_endian && header->encoding != NRRD_TEXT && qn_scalar_size(header->scalar) > 1
            ? "endian"
            : NULL;
    if (missing)
        return qni_source_fail(source, error, "its NRRD header has no field '%s'", missing);
    return QN_OK;
}

static qn_status parse_header(qni_source *source, nrrd_header *header, qn_error *error) {
    char line[4096];
    bool ended;
    QN_TRY(qni_source_line(source, line, sizeof line, &ended, error));
    if (strncmp(line, "NRRD000", 7) != 0 || line[7] < '1' || line[7] > '5')
        return qni_source_fail(
            source, error, "does not begin with NRRD0001 to NRRD0005, the mark of an NRRD file");
    for (;;) {
        QN_TRY(qni_source_line(source, line, sizeof line, &ended, error));
        if (ended || !line[0])
            break;
        QN_TRY(parse_field(source, line, header, error));
    }
    return check_header(source, header, error);
}

static void fill_matrix(const nrrd_header *header, double matrix[4][4]) {
    for (int a = 0; a < 3; ++a) {
        double spacing =
            header->has_spacings && !isnan(header->spacing[a]) ? header->spacing[a] : 1;
        for (int row = 0; row < 3; ++row)
            matrix[row][a] = header->has_directions ? header->direction[a][row]
                             : row == a             ? spacing
                                                    : 0;
        matrix[a][3] = header->origin[a];
    }
    matrix[3][3] = 1;
}

/* From the end of the header, or the beginning of the data file, to the first sample. */
static qn_status skip_to_samples(qni_source *source, const nrrd_header *header, const qn_grid *grid,
                                 qn_error *error) {
    char line[8];
    bool ended = false;
    for (int64_t i = 0; i < header->line_skip && !ended; ++i)
        QN_TRY(qni_source_line(source, line, sizeof line, &ended, error));
    if (header->encoding == NRRD_GZIP &&
        !source->inflate) /* a data file may have unpacked itself */
        QN_TRY(qni_source_inflate(source, error));
    if (header->byte_skip >= 0)
        return qni_source_skip(source, header->byte_skip, error);
    int64_t bytes;
    QN_TRY(qni_load_bytes(source, grid, &bytes, error));
    if (source->inflate || header->encoding != NRRD_RAW || source->file_size < 0)
        return qni_source_fail(
            source, error,
            "'byte skip: -1' needs raw samples in a plain file; give the number of bytes");
    int64_t rest = qni_source_bound(source);
    if (rest < bytes)
        return qni_source_fail_truncated(source, bytes, source->offset, rest, error);
    return qni_source_skip(source, rest - bytes, error);
}

static qn_status load(qni_source *source, const nrrd_header *header, qn_grid *grid,
                      qn_volume **volume_out, qn_error *error) {
    QN_TRY(skip_to_samples(source, header, grid, error));
    return qni_load(source, grid, header->encoding == NRRD_TEXT ? QNI_TEXT : QNI_BINARY, "nrrd",
                    NULL, volume_out, error);
}

qn_status qni_read_nrrd(qni_source *source, const qn_volume_read_options *options,
                        qn_volume **volume_out, qn_error *error) {
    nrrd_header header = {.encoding = NRRD_NONE};
    QN_TRY(parse_header(source, &header, error));
    qn_grid grid = {.slope = 1, .scalar = header.scalar};
    for (int a = 0; a < 3; ++a)
        grid.size[a] = header.size[a];
    grid.swapped = header.encoding != NRRD_TEXT && header.has_endian &&
                   header.big_endian != qni_machine_is_big_endian();
    memcpy(grid.space, header.space, sizeof grid.space);
    memcpy(grid.unit, header.unit, sizeof grid.unit);
    fill_matrix(&header, grid.index_to_world);
    QN_TRY(qni_load_overrides(source, options, grid.index_to_world, error));
    if (!header.data_file[0])
        return load(source, &header, &grid, volume_out, error);
    qni_source data;
    QN_TRY(qni_source_open_beside(source, header.data_file, &data, error));
    qn_status status = load(&data, &header, &grid, volume_out, error);
    qni_source_close(&data);
    return status;
}
