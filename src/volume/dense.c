// SPDX-License-Identifier: MIT
/* Dense volumes: checking a grid, owning or borrowing its samples, reading single samples. */
#include "volume/volume.h"
#include "volume/sparse.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* Lattice coordinates are int32_t, a few of them are needed beyond the ends. */
static const int64_t largest_size = (INT64_C(1) << 31) - 16;

size_t qn_scalar_size(qn_scalar scalar) {
    switch (scalar) {
#define SCALAR_SIZE(name, type, text)                                                              \
    case QN_##name:                                                                                \
        return sizeof(type);
        QN_SCALAR_MAP(SCALAR_SIZE)
#undef SCALAR_SIZE
    case QN_SCALAR_COUNT:
        break;
    }
    return 0;
}

const char *qn_scalar_name(qn_scalar scalar) {
    switch (scalar) {
#define SCALAR_NAME(name, type, text)                                                              \
    case QN_##name:                                                                                \
        return text;
        QN_SCALAR_MAP(SCALAR_NAME)
#undef SCALAR_NAME
    case QN_SCALAR_COUNT:
        break;
    }
    return "?";
}

static bool matrix_is_zero(const double m[4][4]) {
    for (int i = 0; i < 16; ++i)
        if (m[i / 4][i % 4] != 0)
            return false;
    return true;
}

static double determinant3(const double m[4][4]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

static qn_status check_matrix(const double m[4][4], qn_error *error) {
    for (int i = 0; i < 16; ++i)
        if (!isfinite(m[i / 4][i % 4]))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "the index-to-world matrix holds a number that is not finite");
    if (m[3][0] != 0 || m[3][1] != 0 || m[3][2] != 0 || m[3][3] != 1)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the last row of the index-to-world matrix must be 0 0 0 1");
    double determinant = determinant3(m);
    if (determinant == 0 || !isfinite(determinant) || !isfinite(1 / determinant))
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "the index-to-world matrix has no inverse: a spacing of zero, or two axes alike");
    return QN_OK;
}

qn_status qni_volume_settle_matrix(double matrix[4][4], qn_error *error) {
    if (matrix_is_zero((const double(*)[4])matrix))
        for (int i = 0; i < 4; ++i)
            matrix[i][i] = 1;
    return check_matrix((const double(*)[4])matrix, error);
}

static qn_status check_sizes(const qn_grid *grid, qn_error *error) {
    if (grid->scalar < 0 || grid->scalar >= QN_SCALAR_COUNT)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "%d is no scalar type",
                        (int)grid->scalar);
    int64_t bytes = (int64_t)qn_scalar_size(grid->scalar);
    for (int a = 0; a < 3; ++a) {
        if (grid->size[a] < 1 || grid->size[a] > largest_size)
            return qni_fail(
                error, QN_ERROR_INVALID_ARGUMENT,
                "a volume of %lld x %lld x %lld samples: each side must be from 1 to %lld",
                (long long)grid->size[0], (long long)grid->size[1], (long long)grid->size[2],
                (long long)largest_size);
        if (__builtin_mul_overflow(bytes, grid->size[a], &bytes))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "a volume of %lld x %lld x %lld samples is larger than any memory",
                            (long long)grid->size[0], (long long)grid->size[1],
                            (long long)grid->size[2]);
    }
    return QN_OK;
}

qn_status qn_volume_create(qn_context *context, const qn_grid *grid, qn_release release,
                           void *release_user, qn_volume **volume_out, qn_error *error) {
    *volume_out = NULL;
    QN_TRY(check_sizes(grid, error));
    qn_grid own = *grid;
    if (own.stride[0] == 0 && own.stride[1] == 0 && own.stride[2] == 0) {
        own.stride[0] = (int64_t)qn_scalar_size(own.scalar);
        own.stride[1] = own.stride[0] * own.size[0];
        own.stride[2] = own.stride[1] * own.size[1];
    }
    if (own.slope == 0)
        own.slope = 1;
    if (!isfinite(own.slope) || !isfinite(own.intercept))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "slope and intercept must be finite");
    QN_TRY(qni_volume_settle_matrix(own.index_to_world, error));
    own.space[sizeof own.space - 1] = 0;
    own.unit[sizeof own.unit - 1] = 0;

    qn_volume *volume = qni_alloc_zero(context, 1, sizeof *volume);
    if (!volume)
        return qni_fail_memory(error, "a volume");
    volume->context = context;
    volume->grid = own;
    volume->release = release;
    volume->release_user = release_user;
    *volume_out = volume;
    return QN_OK;
}

void qn_volume_destroy(qn_volume *volume) {
    if (!volume)
        return;
    if (volume->release)
        volume->release(volume->release_user,
                        volume->sparse ? volume->sparse->grid.values : volume->grid.samples);
    qni_sparse_destroy(volume->context, volume->sparse);
    qni_free(volume->context, volume, 1, sizeof *volume);
}

const qn_grid *qn_volume_grid(const qn_volume *volume) {
    return &volume->grid;
}

const char *qn_volume_format(const qn_volume *volume) {
    return volume->format;
}

typedef struct owned_samples {
    qn_context *context;
    int64_t bytes;
} owned_samples;

static void release_owned(void *user, const void *samples) {
    owned_samples *owned = user;
    qni_free(owned->context, (void *)(uintptr_t)samples, owned->bytes, 1);
    qni_free(owned->context, owned, 1, sizeof *owned);
}

/* Owned samples may be turned to this machine's byte order where they lie: one pass, after which
 * every reader of the volume takes the fast way. */
static void turn_bytes(void *samples, int64_t bytes, size_t size) {
    unsigned char *at = samples;
    for (int64_t n = 0; n + (int64_t)size <= bytes; n += (int64_t)size)
        for (size_t low = 0, high = size - 1; low < high; ++low, --high) {
            const unsigned char byte = at[n + (int64_t)low];
            at[n + (int64_t)low] = at[n + (int64_t)high];
            at[n + (int64_t)high] = byte;
        }
}

qn_status qni_volume_own(qn_context *context, qn_grid *grid, void *samples, int64_t bytes,
                         const char *format, qn_volume **volume_out, qn_error *error) {
    *volume_out = NULL;
    owned_samples *owned = qni_alloc(context, 1, sizeof *owned);
    if (!owned)
        return qni_fail_memory(error, "a volume");
    owned->context = context;
    owned->bytes = bytes;
    grid->samples = samples;
    if (grid->swapped) {
        turn_bytes(samples, bytes, qn_scalar_size(grid->scalar));
        grid->swapped = false;
    }
    qn_status status = qn_volume_create(context, grid, release_owned, owned, volume_out, error);
    if (status != QN_OK) {
        qni_free(context, owned, 1, sizeof *owned);
        return status;
    }
    strncpy((*volume_out)->format, format, sizeof(*volume_out)->format - 1);
    return QN_OK;
}

double qni_grid_stored(const qn_grid *grid, int64_t i, int64_t j, int64_t k) {
    const char *at = (const char *)grid->samples + i * grid->stride[0] + j * grid->stride[1] +
                     k * grid->stride[2];
    unsigned char bytes[8];
    if (grid->swapped) {
        const size_t size = qn_scalar_size(grid->scalar);
        for (size_t b = 0; b < size; ++b)
            bytes[b] = (unsigned char)at[size - 1 - b];
        at = (const char *)bytes;
    }
    switch (grid->scalar) {
#define SCALAR_LOAD(name, type, text)                                                              \
    case QN_##name: {                                                                              \
        type value;                                                                                \
        memcpy(&value, at, sizeof value);                                                          \
        return (double)value;                                                                      \
    }
        QN_SCALAR_MAP(SCALAR_LOAD)
#undef SCALAR_LOAD
    case QN_SCALAR_COUNT:
        break;
    }
    return 0;
}

double qni_grid_value(const qn_grid *grid, int64_t i, int64_t j, int64_t k) {
    double scaled = grid->slope * qni_grid_stored(grid, i, j, k);
    return scaled + grid->intercept;
}
