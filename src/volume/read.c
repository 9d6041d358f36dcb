// SPDX-License-Identifier: MIT
/* Reading a volume file: which reader, by the options, else by the first bytes, else by the name.
 */
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/load.h"

#include <math.h>
#include <string.h>

typedef struct volume_format {
    const char *name;
    qni_reader *read;
    qni_lister *list; /* NULL: one grid without a name */
    const char *const endings[6];
} volume_format;

static const volume_format formats[] = {
    {"nifti", qni_read_nifti, NULL, {".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"}},
    {"nrrd", qni_read_nrrd, NULL, {".nrrd", ".nhdr"}},
    {"metaimage", qni_read_metaimage, NULL, {".mha", ".mhd"}},
    {"npy", qni_read_npy, NULL, {".npy", ".npy.gz"}},
    {"inr", qni_read_inr, NULL, {".inr", ".inr.gz"}},
    {"mitsuba", qni_read_mitsuba, NULL, {".vol"}},
    {"vdb", qni_read_vdb, qni_list_vdb, {".vdb"}},
    {"nvdb", qni_read_nvdb, qni_list_nvdb, {".nvdb"}},
    {"raw", qni_read_raw, NULL, {".raw", ".raw.gz", ".bin", ".dat"}},
};
enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

static const volume_format *format_by_name(const char *name) {
    for (int i = 0; i < FORMAT_COUNT; ++i)
        if (qni_text_same(formats[i].name, name))
            return &formats[i];
    return NULL;
}

static const volume_format *format_by_ending(const char *path) {
    for (int i = 0; i < FORMAT_COUNT; ++i)
        for (int e = 0; e < 6 && formats[i].endings[e]; ++e)
            if (qni_text_ends(path, formats[i].endings[e]))
                return &formats[i];
    return NULL;
}

static bool begins(const unsigned char *bytes, int64_t count, const char *mark) {
    return count >= (int64_t)strlen(mark) && memcmp(bytes, mark, strlen(mark)) == 0;
}

static bool is_nifti(const unsigned char *bytes, int64_t count) {
    if (count >= 348)
        for (int i = 0; i < 2; ++i)
            if (memcmp(bytes + 344, i ? "ni1" : "n+1", 4) == 0)
                return true;
    return count >= 540 && (memcmp(bytes + 4, "n+2", 4) == 0 || memcmp(bytes + 4, "ni2", 4) == 0);
}

/* The name of the format whose mark the file begins with, or NULL. */
static const char *format_by_bytes(const unsigned char *bytes, int64_t count) {
    if (begins(bytes, count, "NRRD000"))
        return "nrrd";
    if (begins(bytes, count, "\x93NUMPY"))
        return "npy";
    if (begins(bytes, count, "#INRIMAGE-4"))
        return "inr";
    if (begins(bytes, count, "VOL\x03"))
        return "mitsuba";
    if (count >= 8 && memcmp(bytes, " BDV\0\0\0", 8) == 0)
        return "vdb";
    if (begins(bytes, count, "NanoVDB0"))
        return "nvdb";
    if (begins(bytes, count, "ObjectType") || begins(bytes, count, "NDims"))
        return "metaimage";
    return is_nifti(bytes, count) ? "nifti" : NULL;
}

static bool has_shape(const qn_volume_read_options *options) {
    return options->raw_size[0] || options->raw_size[1] || options->raw_size[2];
}

static qn_status choose_format(qni_source *source, const qn_volume_read_options *options,
                               const volume_format **format_out, qn_error *error) {
    if (options->format[0]) { /* checked before */
        *format_out = format_by_name(options->format);
        return QN_OK;
    }
    const unsigned char *bytes;
    int64_t count;
    QN_TRY(qni_source_peek(source, 540, &bytes, &count, error));
    const char *name = format_by_bytes(bytes, count);
    if (name && has_shape(options))
        return qni_source_fail_as(
            source, QN_ERROR_INVALID_ARGUMENT, error,
            "is a %s file and says its own shape and type; leave --shape and --dtype "
            "out, or give --from raw",
            name);
    *format_out = name                 ? format_by_name(name)
                  : has_shape(options) ? format_by_name("raw")
                                       : format_by_ending(source->path);
    if (!*format_out)
        return qni_source_fail(
            source, error,
            "is of no known format (NIfTI, NRRD, MetaImage, NumPy, INRIMAGE, Mitsuba, OpenVDB, "
            "NanoVDB); "
            "for samples without a header give --shape X,Y,Z --dtype u8");
    return QN_OK;
}

static qn_status check_numbers(const qn_volume_read_options *options, qn_error *error) {
    for (int a = 0; a < 3; ++a) {
        if (options->has_spacing && !(options->spacing[a] > 0 && isfinite(options->spacing[a])))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "a spacing of %g along axis %d: give numbers above 0",
                            options->spacing[a], a);
        if (options->has_origin && !isfinite(options->origin[a]))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "the origin must be three finite numbers");
        if (has_shape(options) &&
            (options->raw_size[a] < 1 || options->raw_size[a] > INT32_MAX - 15))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "a shape of %lld x %lld x %lld: each side must be from 1 to %d",
                            (long long)options->raw_size[0], (long long)options->raw_size[1],
                            (long long)options->raw_size[2], INT32_MAX - 15);
    }
    return QN_OK;
}

static qn_status check_options(const qn_volume_read_options *options, qn_error *error) {
    if (memchr(options->format, 0, sizeof options->format) == NULL ||
        (options->format[0] && !format_by_name(options->format)))
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "'%.15s' is no volume format; there are nifti nrrd metaimage npy inr mitsuba vdb nvdb "
            "raw",
            options->format);
    QN_TRY(check_numbers(options, error));
    if (memchr(options->grid, 0, sizeof options->grid) == NULL)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "the name of the grid has no end");
    if ((int)options->raw_scalar < 0 || options->raw_scalar >= QN_SCALAR_COUNT)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "%d is no scalar type",
                        (int)options->raw_scalar);
    if (options->raw_header < 0)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a header of %lld bytes: give the number of bytes before the first sample",
                        (long long)options->raw_header);
    if ((int)options->transform < QN_TRANSFORM_AUTO || options->transform > QN_TRANSFORM_PIXDIM)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "%d is no choice of transform",
                        (int)options->transform);
    return QN_OK;
}

/* Read from an opened source and close it. */
static qn_status read_and_close(qni_source *source, const qn_volume_read_options *options,
                                qn_volume **volume_out, qn_error *error) {
    const volume_format *format;
    qn_status status = choose_format(source, options, &format, error);
    if (status == QN_OK)
        status = format->read(source, options, volume_out, error);
    qni_source_close(source);
    return status;
}

qn_status qn_volume_read(qn_context *context, const char *path,
                         const qn_volume_read_options *options, qn_volume **volume_out,
                         qn_error *error) {
    *volume_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_volume_read_options_init", error);
    qn_volume_read_options own;
    qn_volume_read_options_init(&own);
    if (options)
        own = *options;
    QN_TRY(check_options(&own, error));
    qni_source source;
    QN_TRY(qni_source_open(context, path, &source, error));
    return read_and_close(&source, &own, volume_out, error);
}

qn_status qni_volume_read_memory(qn_context *context, const char *name, const void *bytes,
                                 int64_t size, const qn_volume_read_options *options,
                                 qn_volume **volume_out, qn_error *error) {
    *volume_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_volume_read_options_init", error);
    qn_volume_read_options own;
    qn_volume_read_options_init(&own);
    if (options)
        own = *options;
    QN_TRY(check_options(&own, error));
    qni_source source;
    QN_TRY(qni_source_open_memory(context, name, bytes, size, &source, error));
    return read_and_close(&source, &own, volume_out, error);
}

qn_status qn_volume_list_grids(qn_context *context, const char *path, qn_grid_info *infos_out,
                               int32_t capacity, int32_t *count_out, qn_error *error) {
    qn_volume_read_options options;
    const volume_format *format;
    qni_source source;
    *count_out = 0;
    qn_volume_read_options_init(&options);
    QN_TRY(qni_source_open(context, path, &source, error));
    qn_status status = choose_format(&source, &options, &format, error);
    if (status == QN_OK && format->list)
        status = format->list(&source, infos_out, capacity, count_out, error);
    qni_source_close(&source);
    return status;
}
