// SPDX-License-Identifier: MIT
/* From a header to a volume: sizes are checked, samples read into one block of their stored type.
 */
#include "volume/load.h"
#include "core/context.h"
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/volume.h"

#include <math.h>
#include <string.h>

qn_status qni_load_overrides(const qni_source *source, const qn_volume_read_options *options,
                             double matrix[4][4], qn_error *error) {
    for (int a = 0; options->has_spacing && a < 3; ++a) {
        double length = hypot(hypot(matrix[0][a], matrix[1][a]), matrix[2][a]);
        if (!(length > 0) || !isfinite(length))
            return qni_source_fail(
                source, error,
                "the direction of axis %d has no length, so it cannot be given a spacing", a);
        for (int row = 0; row < 3; ++row)
            matrix[row][a] = matrix[row][a] / length * options->spacing[a];
    }
    for (int row = 0; options->has_origin && row < 3; ++row)
        matrix[row][3] = options->origin[row];
    return QN_OK;
}

qn_status qni_load_bytes(const qni_source *source, const qn_grid *grid, int64_t *bytes_out,
                         qn_error *error) {
    const int64_t largest = (INT64_C(1) << 31) - 16;
    int64_t bytes = (int64_t)qn_scalar_size(grid->scalar);
    for (int a = 0; a < 3; ++a)
        if (grid->size[a] < 1 || grid->size[a] > largest ||
            __builtin_mul_overflow(bytes, grid->size[a], &bytes))
            return qni_source_fail(
                source, error,
                "its header asks for %lld x %lld x %lld samples, which makes no sense",
                (long long)grid->size[0], (long long)grid->size[1], (long long)grid->size[2]);
    *bytes_out = bytes;
    return QN_OK;
}

static qn_status read_binary(qni_source *source, char *samples, int64_t bytes, qn_error *error) {
    const int64_t largest_step = INT64_C(1)
                                 << 24; /* so that progress is told and asked often enough */
    int64_t offset = source->offset;
    for (int64_t done = 0, found; done < bytes; done += found) {
        int64_t step = bytes - done < largest_step ? bytes - done : largest_step;
        if (qni_progress(source->context, "read", (double)done / (double)bytes))
            return qni_fail(error, QN_ERROR_CANCELLED, "reading was cancelled");
        QN_TRY(qni_source_read_some(source, samples + done, step, &found, error));
        if (found < step)
            return qni_source_fail_truncated(source, bytes, offset, done + found, error);
    }
    return QN_OK;
}

/* One number as text. Words are short: a longer one is no number. */
static qn_status read_word(qni_source *source, char word[64], qn_error *error) {
    int length = 0;
    for (char c;;) {
        int64_t found;
        QN_TRY(qni_source_read_some(source, &c, 1, &found, error));
        bool gap = found == 0 || c == ' ' || c == ',' || (c >= '\t' && c <= '\r');
        if (gap && (length > 0 || found == 0))
            break;
        if (!gap && length < 63)
            word[length++] = c;
    }
    word[length] = 0;
    return QN_OK;
}

static bool store_number(const char *word, qn_scalar scalar, char *sample) {
    double number;
    const char *at = word;
    if (!qni_text_double(&at, &number) || *at)
        return false;
    switch (scalar) {
    case QN_F32: {
        float value = (float)number;
        memcpy(sample, &value, sizeof value);
        return true;
    }
    case QN_F64:
        memcpy(sample, &number, sizeof number);
        return true;
#define STORE_INTEGER(name, type, lowest, highest)                                                 \
    case QN_##name: {                                                                              \
        if (!(number >= (double)(lowest) && number <= (double)(highest)) ||                        \
            number != floor(number))                                                               \
            return false;                                                                          \
        type value = (type)number;                                                                 \
        memcpy(sample, &value, sizeof value);                                                      \
        return true;                                                                               \
    }
        STORE_INTEGER(U8, uint8_t, 0, UINT8_MAX)
        STORE_INTEGER(I8, int8_t, INT8_MIN, INT8_MAX)
        STORE_INTEGER(U16, uint16_t, 0, UINT16_MAX)
        STORE_INTEGER(I16, int16_t, INT16_MIN, INT16_MAX)
        STORE_INTEGER(U32, uint32_t, 0, UINT32_MAX)
        STORE_INTEGER(I32, int32_t, INT32_MIN, INT32_MAX)
#undef STORE_INTEGER
    case QN_SCALAR_COUNT:
        break;
    }
    return false;
}

static qn_status read_text(qni_source *source, char *samples, int64_t count, qn_scalar scalar,
                           qn_error *error) {
    size_t size = qn_scalar_size(scalar);
    for (int64_t i = 0; i < count; ++i) {
        char word[64];
        if (i % 65536 == 0 && qni_progress(source->context, "read", (double)i / (double)count))
            return qni_fail(error, QN_ERROR_CANCELLED, "reading was cancelled");
        QN_TRY(read_word(source, word, error));
        if (!word[0])
            return qni_source_fail(source, error,
                                   "truncated: wanted %lld numbers as text, found %lld",
                                   (long long)count, (long long)i);
        if (!store_number(word, scalar, samples + (size_t)i * size))
            return qni_source_fail(source, error, "'%s', number %lld of the samples, is no %s",
                                   word, (long long)i, qn_scalar_name(scalar));
    }
    return QN_OK;
}

/* A matrix that cannot be used is the file's fault here, not the caller's. */
static qn_status own_samples(qni_source *source, qn_grid *grid, void *samples, int64_t bytes,
                             const char *format, qn_volume **volume_out, qn_error *error) {
    qn_error inner;
    qn_status status =
        qni_volume_own(source->context, grid, samples, bytes, format, volume_out, &inner);
    if (status == QN_ERROR_INVALID_ARGUMENT)
        return qni_source_fail(source, error, "%s", inner.message);
    return status == QN_OK ? QN_OK : qni_fail(error, status, "%s", inner.message);
}

qn_status qni_load(qni_source *source, qn_grid *grid, qni_encoding encoding, const char *format,
                   bool *more_out, qn_volume **volume_out, qn_error *error) {
    int64_t bytes = 0, bound = qni_source_bound(source);
    bool more = false;
    QN_TRY(qni_load_bytes(source, grid, &bytes, error));
    int64_t count = bytes / (int64_t)qn_scalar_size(grid->scalar);
    int64_t needed = encoding == QNI_TEXT ? 2 * count - 1 : bytes; /* a digit and a gap each */
    if (needed > bound)
        return qni_source_fail(
            source, error,
            "truncated: %lld x %lld x %lld samples of type %s need %lld bytes at "
            "offset %lld, the file holds%s %lld",
            (long long)grid->size[0], (long long)grid->size[1], (long long)grid->size[2],
            qn_scalar_name(grid->scalar), (long long)needed, (long long)source->offset,
            source->inflate ? " at most" : "", (long long)bound);
    void *samples = qni_alloc(source->context, bytes, 1);
    if (!samples)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "not enough memory for %lld bytes of samples", (long long)bytes);
    qn_status status = encoding == QNI_TEXT ? read_text(source, samples, count, grid->scalar, error)
                                            : read_binary(source, samples, bytes, error);
    if (status == QN_OK)
        status = qni_source_check_end(source, &more, error);
    if (status == QN_OK)
        status = own_samples(source, grid, samples, bytes, format, volume_out, error);
    if (status != QN_OK)
        qni_free(source->context, samples, bytes, 1);
    if (more_out)
        *more_out = more;
    return status;
}
