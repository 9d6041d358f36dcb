// SPDX-License-Identifier: MIT
/* INRIMAGE-4 volumes (.inr): a text header padded to a multiple of 256 bytes, ending in "##}", then
 * samples. */
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/load.h"

#include <string.h>

typedef struct inr_header {
    int64_t size[3], channels, bits;
    double spacing[3], origin[3];
    bool is_float, is_signed, big_endian;
} inr_header;

static bool parse_field(const char *key, const char *value, inr_header *header) {
    static const char axes[] = "XYZ";
    for (int a = 0; a < 3; ++a) {
        char size[] = "XDIM", spacing[] = "VX", origin[] = "TX";
        size[0] = spacing[1] = origin[1] = axes[a];
        if (qni_text_same(key, size))
            return qni_text_integers(value, 1, &header->size[a]);
        if (qni_text_same(key, spacing))
            return qni_text_doubles(value, 1, &header->spacing[a]);
        if (qni_text_same(key, origin))
            return qni_text_doubles(value, 1, &header->origin[a]);
    }
    if (qni_text_same(key, "VDIM"))
        return qni_text_integers(value, 1, &header->channels);
    if (qni_text_same(key, "PIXSIZE")) /* "32 bits" */
        return qni_text_integer(&value, &header->bits);
    if (qni_text_same(key, "TYPE")) {
        header->is_float = qni_text_same(value, "float") || qni_text_same(value, "double");
        header->is_signed = qni_text_same(value, "signed fixed");
        return header->is_float || header->is_signed || qni_text_same(value, "unsigned fixed");
    }
    if (qni_text_same(key, "CPU"))
        header->big_endian = qni_text_same(value, "sun") || qni_text_same(value, "sgi");
    return true;
}

static bool choose_scalar(const inr_header *header, qn_scalar *scalar) {
    static const struct {
        int bits;
        bool is_float, is_signed;
        qn_scalar scalar;
    } types[] = {{8, false, false, QN_U8},  {8, false, true, QN_I8},    {16, false, false, QN_U16},
                 {16, false, true, QN_I16}, {32, false, false, QN_U32}, {32, false, true, QN_I32},
                 {32, true, false, QN_F32}, {64, true, false, QN_F64}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (types[i].bits == header->bits && types[i].is_float == header->is_float &&
            types[i].is_signed == header->is_signed) {
            *scalar = types[i].scalar;
            return true;
        }
    return false;
}

static qn_status parse_header(qni_source *source, inr_header *header, qn_error *error) {
    char line[256];
    bool ended;
    QN_TRY(qni_source_line(source, line, sizeof line, &ended, error));
    if (strncmp(line, "#INRIMAGE-4#{", 13) != 0)
        return qni_source_fail(source, error, "does not begin with the mark of an INRIMAGE-4 file");
    for (;;) {
        char *key, *value;
        QN_TRY(qni_source_line(source, line, sizeof line, &ended, error));
        if (ended)
            return qni_source_fail(source, error,
                                   "truncated: its INRIMAGE header has no end mark '##}'");
        if (strncmp(line, "##}", 3) == 0)
            break;
        if (line[0] != '#' && qni_text_split(line, '=', &key, &value) &&
            !parse_field(key, value, header))
            return qni_source_fail(source, error,
                                   "its INRIMAGE header has '%.40s=%.80s', which makes no "
                                   "sense",
                                   key, value);
    }
    if (header->channels != 1)
        return qni_source_fail(source, error, "has %lld numbers a sample (VDIM); a volume has one",
                               (long long)header->channels);
    return qni_source_skip(source, (256 - source->offset % 256) % 256, error);
}

qn_status qni_read_inr(qni_source *source, const qn_volume_read_options *options,
                       qn_volume **volume_out, qn_error *error) {
    inr_header header = {.spacing = {1, 1, 1}, .channels = 1};
    QN_TRY(parse_header(source, &header, error));
    qn_grid grid = {.slope = 1, .swapped = header.big_endian != qni_machine_is_big_endian()};
    if (!choose_scalar(&header, &grid.scalar))
        return qni_source_fail(
            source, error,
            "samples of %lld bits of its TYPE are not read; convert them to integers of 8 "
            "to 32 bits, or to float",
            (long long)header.bits);
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = header.size[a];
        grid.index_to_world[a][a] = header.spacing[a];
        grid.index_to_world[a][3] = header.origin[a];
    }
    grid.index_to_world[3][3] = 1;
    QN_TRY(qni_load_overrides(source, options, grid.index_to_world, error));
    return qni_load(source, &grid, QNI_BINARY, "inr", NULL, volume_out, error);
}
