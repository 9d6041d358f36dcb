// SPDX-License-Identifier: MIT
/* Writing volumes: .npy and .nii sample by sample, row after row, so that a sparse volume is never
 * dense in memory; .vdb by the shim (write_vdb.c). */
#include "core/context.h"
#include "core/file.h"
#include "core/status.h"
#include "volume/header_text.h"
#include "volume/sparse.h"
#include "volume/write.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A sparse volume as a dense file: never more than the first, and from the second on only when it
 * is not all but empty. A damaged file can hold two leaves at the ends of the world. */
static const int64_t largest_dense = INT64_C(8) << 30, large_dense = INT64_C(1) << 30;
enum { MOST_TIMES_THE_LEAVES = 256 };
enum { LARGEST_NIFTI_SIDE = 32767, NIFTI_HEADER = 352, NPY_HEADER = 128 };

/* ---- rows of samples ------------------------------------------------------------------------- */

static void store(qn_scalar scalar, double value, char *to) {
    switch (scalar) {
#define STORE(name, type, text)                                                                    \
    case QN_##name: {                                                                              \
        const type stored = (type)value;                                                           \
        memcpy(to, &stored, sizeof stored);                                                        \
        break;                                                                                     \
    }
        QN_SCALAR_MAP(STORE)
#undef STORE
    case QN_SCALAR_COUNT:
        break;
    }
}

/* Row (j, k) of the box of a sparse volume. */
static void sparse_row(const qn_volume *volume, int64_t j, int64_t k, char *row) {
    const qni_sparse *sparse = volume->sparse;
    const size_t size = qn_scalar_size(sparse->grid.scalar);
    for (int64_t b = 0; b < volume->grid.size[0] / QNI_BLOCK; ++b) {
        /* the lattice begins one block below the box */
        const qni_block block =
            qni_sparse_block(sparse, b + 1, j / QNI_BLOCK + 1, k / QNI_BLOCK + 1);
        char *to = row + (size_t)b * QNI_BLOCK * size;
        if (block.samples)
            memcpy(to, block.samples + (size_t)(8 * (j & 7) + 64 * (k & 7)) * size,
                   QNI_BLOCK * size);
        for (size_t n = 0; !block.samples && n < QNI_BLOCK; ++n)
            store(sparse->grid.scalar, block.value, to + n * size);
    }
}

static void dense_row(const qn_grid *grid, int64_t j, int64_t k, bool as_values, char *row) {
    const size_t size = qn_scalar_size(as_values ? QN_F64 : grid->scalar);
    for (int64_t i = 0; i < grid->size[0]; ++i)
        if (as_values)
            store(QN_F64, qni_grid_value(grid, i, j, k), row + (size_t)i * size);
        else
            store(grid->scalar, qni_grid_stored(grid, i, j, k), row + (size_t)i * size);
}

static qn_status write_rows(const qn_volume *volume, bool as_values, qni_output *output,
                            qn_error *error) {
    const qn_grid *grid = &volume->grid;
    const size_t bytes = qn_scalar_size(as_values ? QN_F64 : grid->scalar);
    char *row = qni_alloc(volume->context, grid->size[0], bytes);
    if (!row)
        return qni_fail_memory(error, "a row of samples");
    for (int64_t k = 0; k < grid->size[2]; ++k) {
        if (qni_output_stopped(output, (double)k / (double)grid->size[2]))
            break; /* commit says why */
        for (int64_t j = 0; j < grid->size[1]; ++j) {
            if (volume->sparse)
                sparse_row(volume, j, k, row);
            else
                dense_row(grid, j, k, as_values, row);
            qni_output_write(output, row, (size_t)grid->size[0] * bytes);
        }
    }
    qni_free(volume->context, row, grid->size[0], bytes);
    return QN_OK;
}

/* ---- headers --------------------------------------------------------------------------------- */

static bool is_scaled(const qn_grid *grid) {
    return grid->slope != 1 || grid->intercept != 0;
}

/* NumPy's arrays are indexed a[i, j, k] here, i fastest in memory ("Fortran order"), as the reader
 * takes them. Scaled samples are written as their values. */
static void npy_header(const qn_grid *grid, char header[NPY_HEADER + 1]) {
    static const char *const types[QN_SCALAR_COUNT] = {
        [QN_U8] = "|u1",  [QN_I8] = "|i1",  [QN_U16] = "<u2", [QN_I16] = "<i2",
        [QN_U32] = "<u4", [QN_I32] = "<i4", [QN_F32] = "<f4", [QN_F64] = "<f8"};
    char text[NPY_HEADER];
    snprintf(text, sizeof text,
             "{'descr': '%s', 'fortran_order': True, 'shape': (%lld, %lld, %lld), }",
             is_scaled(grid) ? "<f8" : types[grid->scalar], (long long)grid->size[0],
             (long long)grid->size[1], (long long)grid->size[2]);
    memcpy(header, "\x93NUMPY\x01\x00\x76\x00", 10);
    snprintf(header + 10, NPY_HEADER + 1 - 10, "%-117.117s\n", text);
}

static void put_i16(unsigned char *at, int value) {
    at[0] = (unsigned char)(value & 0xff);
    at[1] = (unsigned char)(value >> 8 & 0xff);
}

static void put_i32(unsigned char *at, uint32_t value) {
    for (int b = 0; b < 4; ++b)
        at[b] = (unsigned char)(value >> (8 * b));
}

static void put_f32(unsigned char *at, double value) {
    const float stored = (float)value;
    uint32_t bits;
    memcpy(&bits, &stored, sizeof bits);
    put_i32(at, bits);
}

/* NIfTI's world is RAS: x to the right, y to the front. */
static double to_ras(const qn_grid *grid, int row) {
    const bool lps = qni_text_same(grid->space, "LPS");
    return lps && row < 2 ? -1 : 1;
}

/* The fields of NIfTI-1 by their offsets. */
static void nifti_header(const qn_grid *grid, unsigned char header[NIFTI_HEADER]) {
    static const int types[QN_SCALAR_COUNT] = {
        [QN_U8] = 2,    [QN_I8] = 256, [QN_U16] = 512, [QN_I16] = 4,
        [QN_U32] = 768, [QN_I32] = 8,  [QN_F32] = 16,  [QN_F64] = 64};
    const int units = strcmp(grid->unit, "mm") == 0   ? 2
                      : strcmp(grid->unit, "m") == 0  ? 1
                      : strcmp(grid->unit, "um") == 0 ? 3
                                                      : 0;
    memset(header, 0, NIFTI_HEADER);
    put_i32(header, 348);
    put_i16(header + 40, 3);
    put_i16(header + 70, types[grid->scalar]);
    put_i16(header + 72, (int)(8 * qn_scalar_size(grid->scalar)));
    put_f32(header + 76, 1); /* pixdim[0]: the handedness of the unused qform */
    for (int a = 0; a < 3; ++a) {
        double squares = 0;
        for (int r = 0; r < 3; ++r)
            squares += grid->index_to_world[r][a] * grid->index_to_world[r][a];
        put_i16(header + 42 + 2 * a, (int)grid->size[a]);
        put_f32(header + 80 + 4 * a, sqrt(squares));
    }
    for (int a = 3; a < 7; ++a)
        put_i16(header + 42 + 2 * a, 1);
    put_f32(header + 108, NIFTI_HEADER);
    put_f32(header + 112, grid->slope);
    put_f32(header + 116, grid->intercept);
    header[123] = (unsigned char)units;
    put_i16(header + 254, 2); /* sform_code: aligned to some other space */
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            put_f32(header + 280 + 16 * r + 4 * c, to_ras(grid, r) * grid->index_to_world[r][c]);
    memcpy(header + 344, "n+1", 4);
}

/* ---- files ----------------------------------------------------------------------------------- */

/* Bytes of the samples of a dense file; INT64_MAX where they cannot be counted. */
static int64_t dense_bytes(const qn_grid *grid) {
    int64_t bytes = (int64_t)qn_scalar_size(grid->scalar);
    for (int a = 0; a < 3; ++a)
        if (__builtin_mul_overflow(bytes, grid->size[a], &bytes))
            return INT64_MAX;
    return bytes;
}

static bool is_too_empty(const qn_volume *volume, int64_t bytes) {
    const qn_sparse_grid *grid = &volume->sparse->grid;
    const int64_t leaf_bytes = 512 * (int64_t)qn_scalar_size(grid->scalar);
    return bytes > large_dense && bytes / MOST_TIMES_THE_LEAVES > grid->leaf_count * leaf_bytes;
}

static qn_status check_dense(const qn_volume *volume, const char *path, bool nifti,
                             qn_error *error) {
    const qn_grid *grid = &volume->grid;
    const int64_t bytes = dense_bytes(grid);
    bool too_long = false;
    for (int a = 0; a < 3; ++a)
        too_long = too_long || grid->size[a] > LARGEST_NIFTI_SIDE;
    const bool too_large = volume->sparse && (bytes > largest_dense || is_too_empty(volume, bytes));
    if (!too_large && !(too_long && nifti))
        return QN_OK;
    return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                    "%.200s: the box of %lld x %lld x %lld samples is too large for a dense file "
                    "(%.1f GB); write a .vdb",
                    path, (long long)grid->size[0], (long long)grid->size[1],
                    (long long)grid->size[2], (double)bytes / 1e9);
}

static qn_status write_dense(qn_context *context, const qn_volume *volume, const char *path,
                             bool nifti, qn_error *error) {
    qni_output output;
    unsigned char nifti_bytes[NIFTI_HEADER];
    char npy_bytes[NPY_HEADER + 1];
    QN_TRY(check_dense(volume, path, nifti, error));
    QN_TRY(qni_output_open(&output, context, path, error));
    if (nifti) {
        nifti_header(&volume->grid, nifti_bytes);
        qni_output_write(&output, nifti_bytes, NIFTI_HEADER);
    } else {
        npy_header(&volume->grid, npy_bytes);
        qni_output_write(&output, npy_bytes, NPY_HEADER);
    }
    const qn_status status = write_rows(volume, !nifti && is_scaled(&volume->grid), &output, error);
    if (status != QN_OK) {
        qni_output_abandon(&output);
        return status;
    }
    return qni_output_commit(&output, error);
}

qn_status qn_volume_write(qn_context *context, const qn_volume *volume, const char *path,
                          qn_error *error) {
    if (qni_text_ends(path, ".vdb"))
        return qni_write_vdb(context, volume, path, error);
    if (qni_text_ends(path, ".npy") || qni_text_ends(path, ".nii"))
        return write_dense(context, volume, path, qni_text_ends(path, ".nii"), error);
    return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                    "%.300s: volumes are written as .vdb, .npy or .nii", path);
}
