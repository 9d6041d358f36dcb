// SPDX-License-Identifier: MIT
/* Values of options that are lists: iso-values, places, shapes, types. */
#include "option_values.h"
#include "number.h"
#include "session.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool option_wrong(const cli_option_row *row, const char *text, const char *form) {
    cli_say("--%s %s: not of the right form; for example --%s %s", row->name, text, row->name,
            form);
    return false;
}

bool option_set_isovalues(cli_options *options, const cli_option_row *row, const char *text) {
    free(options->isovalues);
    options->isovalues = NULL;
    options->isovalue_count = 0;
    if (strcmp(text, "auto") == 0)
        return true;
    int count = 1;
    for (const char *c = text; *c; ++c)
        count += *c == ',';
    options->isovalues = calloc((size_t)count, sizeof *options->isovalues);
    if (!options->isovalues || !number_parse_reals(text, ',', count, options->isovalues))
        return option_wrong(row, text, "300 or --iso 300,-500 or --iso auto");
    options->isovalue_count = count;
    for (int i = 0; i < count; ++i) {
        if (!isfinite(options->isovalues[i]))
            return option_wrong(row, text, "300 (a finite number)");
        for (int j = 0; j < i; ++j)
            if (options->isovalues[i] == options->isovalues[j]) {
                cli_say("--iso %s: an iso-value is given twice; leave one out", text);
                return false;
            }
    }
    return true;
}

bool option_set_spacing(cli_options *options, const cli_option_row *row, const char *text) {
    double *spacing = options->read.spacing;
    if (!number_parse_reals(text, ',', 3, spacing))
        return option_wrong(row, text, "0.5,0.5,1.2");
    for (int axis = 0; axis < 3; ++axis)
        if (!(spacing[axis] > 0 && isfinite(spacing[axis])))
            return option_wrong(row, text, "0.5,0.5,1.2 (three positive numbers)");
    return options->read.has_spacing = true;
}

bool option_set_origin(cli_options *options, const cli_option_row *row, const char *text) {
    double *origin = options->read.origin;
    if (!number_parse_reals(text, ',', 3, origin) || !isfinite(origin[0]) || !isfinite(origin[1]) ||
        !isfinite(origin[2]))
        return option_wrong(row, text, "-90,-126,-72");
    return options->read.has_origin = true;
}

bool option_set_shape(cli_options *options, const cli_option_row *row, const char *text) {
    int64_t *size = options->read.raw_size;
    if (!number_parse_integers(text, ',', 3, size) || size[0] < 1 || size[1] < 1 || size[2] < 1)
        return option_wrong(row, text, "512,512,300 (three whole numbers of at least 1)");
    return true;
}

bool option_set_dtype(cli_options *options, const cli_option_row *row, const char *text) {
    for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar) {
        const char *name = qn_scalar_name((qn_scalar)scalar);
        size_t length = strlen(name);
        if (strncmp(text, name, length) != 0)
            continue;
        const char *order = text + length;
        bool big = strcmp(order, "be") == 0;
        if (*order && !big && strcmp(order, "le") != 0)
            break;
        options->read.raw_scalar = (qn_scalar)scalar;
        options->read.raw_big_endian = big;
        return true;
    }
    return option_wrong(row, text, "i16le (u8 i8 u16 i16 u32 i32 f32 f64, with le or be)");
}

bool option_set_size(cli_options *options, const cli_option_row *row, const char *text) {
    int64_t size[2];
    if (!number_parse_integers(text, 'x', 2, size) || size[0] < 1 || size[1] < 1 ||
        size[0] > 16384 || size[1] > 16384)
        return option_wrong(row, text, "800x600 (at most 16384x16384)");
    options->width = (int32_t)size[0];
    options->height = (int32_t)size[1];
    return true;
}
