// SPDX-License-Identifier: MIT
/* NumPy arrays (.npy, versions 1 to 3) of three axes: array[i, j, k] lies at world position (i, j,
 * k) times the spacing plus the origin. In C order k is fastest in memory: the lattice is then the
 * array with its axes reversed, so that x stays the fastest, and the matrix sends lattice x to
 * world z. */
#include "core/context.h"
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/load.h"

#include <string.h>

enum { LARGEST_HEADER = 65535 };

typedef struct npy_header {
    char type[16]; /* as "<f4" */
    bool fortran_order;
    int64_t shape[3];
} npy_header;

/* The text after 'key': of the header, which is a Python dictionary. NULL when it is not there. */
static const char *find_value(const char *text, const char *key) {
    char quoted[32];
    size_t length = strlen(key);
    for (const char *quotes = "'\""; *quotes; ++quotes) {
        quoted[0] = quoted[length + 1] = *quotes;
        memcpy(quoted + 1, key, length);
        quoted[length + 2] = 0;
        const char *at = strstr(text, quoted);
        if (!at)
            continue;
        at += length + 2;
        at += strspn(at, " ");
        if (*at != ':')
            return NULL;
        return at + 1 + strspn(at + 1, " ");
    }
    return NULL;
}

static bool parse_type(const char *at, char type[16]) {
    if (!at || (*at != '\'' && *at != '"'))
        return false;
    const char *end = strchr(at + 1, *at);
    if (!end || end - at - 1 > 15)
        return false;
    memcpy(type, at + 1, (size_t)(end - at - 1));
    type[end - at - 1] = 0;
    return true;
}

/* "(3, 4, 5)"; the number of axes, or -1. Only the first three are kept. */
static int parse_shape(const char *at, int64_t shape[3]) {
    if (!at || *at++ != '(')
        return -1;
    int count = 0;
    for (;;) {
        at += strspn(at, " ,");
        if (*at == ')')
            return count;
        int64_t size;
        if (*at < '0' || *at > '9' || !qni_text_integer(&at, &size) || count >= 64)
            return -1;
        if (*at == 'L') /* written by Python 2 */
            ++at;
        if (count < 3)
            shape[count] = size;
        ++count;
    }
}

static qn_status parse_header(const qni_source *source, const char *text, npy_header *header,
                              qn_error *error) {
    const char *order = find_value(text, "fortran_order");
    int axes = parse_shape(find_value(text, "shape"), header->shape);
    if (!parse_type(find_value(text, "descr"), header->type))
        return qni_source_fail(
            source, error,
            "its NumPy header names no plain type (a structured array?); save one field "
            "as a plain array");
    if (!order || axes < 0)
        return qni_source_fail(source, error, "its NumPy header makes no sense: %.120s", text);
    if (axes != 3)
        return qni_source_fail(
            source, error,
            "its array has %d axes, a volume has 3; save a[..., 0], a.squeeze() or the "
            "like",
            axes);
    header->fortran_order = strncmp(order, "True", 4) == 0;
    return QN_OK;
}

static qn_status parse_scalar(const qni_source *source, const char *type, qn_grid *grid,
                              qn_error *error) {
    static const struct {
        const char *name;
        qn_scalar scalar;
    } types[] = {{"b1", QN_U8},  {"u1", QN_U8},  {"i1", QN_I8},  {"u2", QN_U16}, {"i2", QN_I16},
                 {"u4", QN_U32}, {"i4", QN_I32}, {"f4", QN_F32}, {"f8", QN_F64}};
    bool ordered = strchr("<>|=", type[0]) != NULL && type[0];
    const char *name = type + ordered;
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (strcmp(name, types[i].name) == 0) {
            grid->scalar = types[i].scalar;
            bool big = type[0] == '>' || (type[0] != '<' && qni_machine_is_big_endian());
            grid->swapped = big != qni_machine_is_big_endian();
            return QN_OK;
        }
    return qni_source_fail(
        source, error,
        "samples of NumPy type '%s' are not read; save a.astype('float32') or another of "
        "u1 i1 u2 i2 u4 i4 f4 f8",
        type);
}

/* Magic, version, header length: where the text begins and how long it is. */
static qn_status read_preamble(qni_source *source, int64_t *length_out, qn_error *error) {
    unsigned char bytes[8], more[4] = {0};
    QN_TRY(qni_source_read(source, bytes, 8, error));
    if (memcmp(bytes, "\x93NUMPY", 6) != 0)
        return qni_source_fail(source, error, "does not begin with the mark of a NumPy file");
    if (bytes[6] < 1 || bytes[6] > 3)
        return qni_source_fail(source, error,
                               "NumPy format version %d.%d is not known; 1, 2 and 3 are", bytes[6],
                               bytes[7]);
    QN_TRY(qni_source_read(source, more, bytes[6] == 1 ? 2 : 4, error));
    *length_out = more[0] | more[1] << 8 | more[2] << 16 | (int64_t)more[3] << 24;
    if (*length_out > LARGEST_HEADER)
        return qni_source_fail(source, error, "a NumPy header of %lld bytes makes no sense",
                               (long long)*length_out);
    return QN_OK;
}

static qn_status read_header(qni_source *source, npy_header *header, qn_error *error) {
    int64_t length = 0;
    QN_TRY(read_preamble(source, &length, error));
    char *text = qni_alloc(source->context, length + 1, 1);
    if (!text)
        return qni_fail_memory(error, "a NumPy header");
    text[length] = 0;
    qn_status status = qni_source_read(source, text, length, error);
    if (status == QN_OK)
        status = parse_header(source, text, header, error);
    qni_free(source->context, text, length + 1, 1);
    return status;
}

qn_status qni_read_npy(qni_source *source, const qn_volume_read_options *options,
                       qn_volume **volume_out, qn_error *error) {
    npy_header header = {.fortran_order = false};
    qn_grid grid = {.slope = 1};
    QN_TRY(read_header(source, &header, error));
    QN_TRY(parse_scalar(source, header.type, &grid, error));
    double by_index[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    QN_TRY(qni_load_overrides(source, options, by_index, error));
    for (int a = 0; a < 3; ++a) {
        int axis = header.fortran_order ? a : 2 - a; /* of the array, for lattice axis a */
        grid.size[a] = header.shape[axis];
        for (int row = 0; row < 3; ++row)
            grid.index_to_world[row][a] = by_index[row][axis];
    }
    for (int row = 0; row < 4; ++row)
        grid.index_to_world[row][3] = by_index[row][3];
    return qni_load(source, &grid, QNI_BINARY, "npy", NULL, volume_out, error);
}
