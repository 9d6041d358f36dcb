// SPDX-License-Identifier: MIT
/* Solids from files: the whole text is read, and the name's ending says which reader takes it. */
#include "solid/read.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static bool ends_with(const char *name, const char *ending) {
    size_t length = strlen(name), tail = strlen(ending);
    return length >= tail && strcasecmp(name + length - tail, ending) == 0;
}

static qn_status region_of(const qn_solid_read_options *options, qni_box *region, qn_error *error) {
    *region = (qni_box){{-1, -1, -1}, {1, 1, 1}};
    bool given = false;
    for (int k = 0; options && k < 3; ++k)
        given = given || options->low[k] != 0 || options->high[k] != 0;
    for (int k = 0; given && k < 3; ++k) {
        region->low[k] = options->low[k];
        region->high[k] = options->high[k];
        if (!isfinite(region->low[k]) || !isfinite(region->high[k]) ||
            !(region->low[k] < region->high[k]))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "the region runs from %g to %g along axis %d: low must be below high, "
                            "and both finite",
                            region->low[k], region->high[k], k);
    }
    return QN_OK;
}

qn_status qn_solid_read_text(qn_context *context, const char *name, const char *bytes, int64_t size,
                             const qn_solid_read_options *options, qn_solid **solid_out,
                             qn_error *error) {
    *solid_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_solid_read_options_init", error);
    qni_box region;
    QN_TRY(region_of(options, &region, error));
    qni_text text = {name, bytes, size};
    if (ends_with(name, ".vm"))
        return qni_read_vm(context, &text, &region, solid_out, error);
    if (ends_with(name, ".csg"))
        return qni_read_csg(context, &text, options && options->smooth_primitives, solid_out,
                            error);
    return qni_fail(error, QN_ERROR_UNSUPPORTED,
                    "'%s': the ending names no format of solids; known are .vm and .csg%s", name,
                    ends_with(name, ".scad") ? " (openscad -o MODEL.csg MODEL.scad writes one)"
                                             : "");
}

static qn_status read_all(qn_context *context, FILE *file, const char *path, char **bytes_out,
                          int64_t *size_out, qn_error *error) {
    int64_t room = 1 << 16, size = 0;
    char *bytes = qni_alloc(context, room, 1);
    while (bytes) {
        size += (int64_t)fread(bytes + size, 1, (size_t)(room - size), file);
        if (size < room)
            break;
        char *more = qni_realloc(context, bytes, room, 2 * room, 1);
        if (!more)
            qni_free(context, bytes, room, 1);
        bytes = more;
        room *= 2;
    }
    if (!bytes)
        return qni_fail_memory(error, "the text of a model");
    if (ferror(file)) {
        qni_free(context, bytes, room, 1);
        return qni_fail(error, QN_ERROR_INPUT, "cannot read '%s': %s", path, strerror(errno));
    }
    *bytes_out = qni_realloc(context, bytes, room, size, 1);
    *size_out = size;
    if (*bytes_out)
        return QN_OK;
    qni_free(context, bytes, room, 1);
    return qni_fail_memory(error, "the text of a model");
}

qn_status qn_solid_read(qn_context *context, const char *path, const qn_solid_read_options *options,
                        qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    FILE *file = fopen(path, "rb");
    if (!file)
        return qni_fail(error, QN_ERROR_INPUT, "cannot open '%s': %s", path, strerror(errno));
    char *bytes = NULL;
    int64_t size = 0;
    qn_status status = read_all(context, file, path, &bytes, &size, error);
    fclose(file);
    QN_TRY(status);
    status = qn_solid_read_text(context, path, bytes, size, options, solid_out, error);
    qni_free(context, bytes, size, 1);
    return status;
}
