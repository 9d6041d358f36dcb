// SPDX-License-Identifier: MIT
/* Small volume files for tests, made byte by byte in memory: a block of 4 x 3 x 5 samples whose
 * values follow from their index, in every format, type and byte order. */
#ifndef TESTS_LIB_VOLUME_FILES_H
#define TESTS_LIB_VOLUME_FILES_H

#include <qn/volume.h>
#include "qni_config.h"
#include "volume/load.h"
#include "volume/volume.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { BLOCK_X = 4, BLOCK_Y = 3, BLOCK_Z = 5, BLOCK_COUNT = BLOCK_X * BLOCK_Y * BLOCK_Z };

typedef struct bytes {
    unsigned char data[16384];
    int64_t size;
} bytes;

static inline void put(bytes *to, const void *data, size_t size) {
    if (to->size + (int64_t)size > (int64_t)sizeof to->data)
        abort();
    memcpy(to->data + to->size, data, size);
    to->size += (int64_t)size;
}

static inline void put_text(bytes *to, const char *text) {
    put(to, text, strlen(text));
}

static inline void put_zeros(bytes *to, int64_t until) {
    while (to->size < until)
        put(to, "", 1);
}

/* Bytes of a number of this machine, in the byte order asked for. */
static inline void put_ordered(bytes *to, const void *number, size_t size, bool big) {
    unsigned char own[8];
    memcpy(own, number, size);
    for (size_t b = 0; b < size; ++b)
        put(to, &own[big != qni_machine_is_big_endian() ? size - 1 - b : b], 1);
}

static inline void put_scalar(bytes *to, qn_scalar scalar, double value, bool big) {
    switch (scalar) {
#define PUT_CASE(name, type, text)                                                                 \
    case QN_##name: {                                                                              \
        type number = (type)value;                                                                 \
        put_ordered(to, &number, sizeof number, big);                                              \
        break;                                                                                     \
    }
        QN_SCALAR_MAP(PUT_CASE)
#undef PUT_CASE
    case QN_SCALAR_COUNT:
        abort();
    }
}

/* The stored value of sample number `index`: within the type, both ends of it among the values. */
static inline double block_value(qn_scalar scalar, int64_t index) {
    static const double low[] = {0, INT8_MIN, 0, INT16_MIN, 0, INT32_MIN};
    static const double high[] = {UINT8_MAX, INT8_MAX,   UINT16_MAX,
                                  INT16_MAX, UINT32_MAX, INT32_MAX};
    if (scalar == QN_F32 || scalar == QN_F64)
        return (double)index * 0.375 - 3;
    return index == 0   ? low[scalar]
           : index == 1 ? high[scalar]
                        : low[scalar] + (double)(index * 7 % 251);
}

static inline void put_block(bytes *to, qn_scalar scalar, bool big) {
    for (int64_t i = 0; i < BLOCK_COUNT; ++i)
        put_scalar(to, scalar, block_value(scalar, i), big);
}

/* window: 31 for gzip, 15 for zlib */
static inline void put_packed(bytes *to, const void *data, int64_t size, int window) {
    z_stream stream;
    memset(&stream, 0, sizeof stream);
    if (deflateInit2(&stream, 6, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        abort();
    stream.next_in = (Bytef *)(uintptr_t)data;
    stream.avail_in = (uInt)size;
    stream.next_out = to->data + to->size;
    stream.avail_out = (uInt)((int64_t)sizeof to->data - to->size);
    if (deflate(&stream, Z_FINISH) != Z_STREAM_END)
        abort();
    to->size += (int64_t)stream.total_out;
    deflateEnd(&stream);
}

static inline void pack_all(bytes *file) {
    bytes *packed = calloc(1, sizeof *packed);
    put_packed(packed, file->data, file->size, 31);
    *file = *packed;
    free(packed);
}

/* Whether the volume holds the block, exactly. */
static inline bool holds_block(const qn_volume *volume, qn_scalar scalar) {
    const qn_grid *grid = qn_volume_grid(volume);
    if (grid->scalar != scalar || grid->size[0] != BLOCK_X || grid->size[1] != BLOCK_Y ||
        grid->size[2] != BLOCK_Z)
        return false;
    for (int64_t i = 0; i < BLOCK_COUNT; ++i)
        if (qni_grid_stored(grid, i % BLOCK_X, i / BLOCK_X % BLOCK_Y, i / (BLOCK_X * BLOCK_Y)) !=
            block_value(scalar, i))
            return false;
    return true;
}

/* ---- headers ---- */

typedef struct nifti_fields {
    qn_scalar scalar;
    bool big, paired;
    int version; /* 1 or 2 */
    int qform_code, sform_code;
    double pixdim[4];
    double quatern[3], qoffset[3], srow[3][4];
    double slope, intercept;
    int units, datatype; /* datatype 0: by the scalar */
    int64_t dim[8];      /* all 0: the block */
} nifti_fields;

static inline void put_integer(bytes *to, int64_t value, size_t size, bool big) {
    int16_t two = (int16_t)value;
    int32_t four = (int32_t)value;
    put_ordered(to,
                size == 2   ? (void *)&two
                : size == 4 ? (void *)&four
                            : (void *)&value,
                size, big);
}

static inline void put_reals(bytes *to, const double *values, int count, int version, bool big) {
    for (int i = 0; i < count; ++i)
        put_scalar(to, version == 1 ? QN_F32 : QN_F64, values[i], big);
}

/* Field by field at the offsets of the two standards. */
static inline void put_nifti_header(bytes *to, const nifti_fields *f) {
    static const int codes[] = {2, 256, 512, 4, 768, 8, 16, 64};
    static const int64_t block_dim[8] = {3, BLOCK_X, BLOCK_Y, BLOCK_Z, 1, 1, 1, 1};
    const int64_t *dim = f->dim[0] ? f->dim : block_dim;
    bool one = f->version == 1;
    size_t integer = one ? 2 : 8;
    double pixdim[8] = {f->pixdim[0], f->pixdim[1], f->pixdim[2], f->pixdim[3]};
    double offset = f->paired ? 0 : one ? 352 : 544, scaling[2] = {f->slope, f->intercept};
    int datatype = f->datatype ? f->datatype : codes[f->scalar];
    int64_t start = to->size;
    put_integer(to, one ? 348 : 540, 4, f->big);
    if (!one) {
        put(to, f->paired ? "ni2\0\r\n\032\n" : "n+2\0\r\n\032\n", 8);
        put_integer(to, datatype, 2, f->big);
        put_integer(to, (int64_t)qn_scalar_size(f->scalar) * 8, 2, f->big);
    }
    put_zeros(to, start + (one ? 40 : 16));
    for (int i = 0; i < 8; ++i)
        put_integer(to, dim[i], integer, f->big);
    if (one) {
        put_zeros(to, start + 70);
        put_integer(to, datatype, 2, f->big);
        put_integer(to, (int64_t)qn_scalar_size(f->scalar) * 8, 2, f->big);
    }
    put_zeros(to, start + (one ? 76 : 104));
    put_reals(to, pixdim, 8, f->version, f->big);
    if (one)
        put_reals(to, &offset, 1, 1, f->big);
    else
        put_integer(to, (int64_t)offset, 8, f->big);
    put_reals(to, scaling, 2, f->version, f->big);
    if (one) {
        put_zeros(to, start + 123);
        put(to, &(char){(char)f->units}, 1);
    }
    put_zeros(to, start + (one ? 252 : 344));
    put_integer(to, f->qform_code, one ? 2 : 4, f->big);
    put_integer(to, f->sform_code, one ? 2 : 4, f->big);
    put_reals(to, f->quatern, 3, f->version, f->big);
    put_reals(to, f->qoffset, 3, f->version, f->big);
    put_reals(to, f->srow[0], 12, f->version, f->big);
    if (one) {
        put_zeros(to, start + 344);
        put(to, f->paired ? "ni1" : "n+1", 4);
    } else {
        put_zeros(to, start + 500);
        put_integer(to, f->units, 4, f->big);
        put_zeros(to, start + 540);
    }
}

static inline void put_nifti(bytes *to, const nifti_fields *f) {
    put_nifti_header(to, f);
    if (f->paired)
        return;
    put_zeros(to, to->size + 4);
    put_block(to, f->scalar, f->big);
}

static inline void put_npy_header(bytes *to, const char *text, int version) {
    unsigned char mark[8] = {0x93, 'N', 'U', 'M', 'P', 'Y', (unsigned char)version, 0};
    size_t length = strlen(text);
    unsigned char sizes[4] = {(unsigned char)length, (unsigned char)(length >> 8), 0, 0};
    put(to, mark, 8);
    put(to, sizes, version == 1 ? 2 : 4);
    put_text(to, text);
}

/* ---- one example of each format, to damage ---- */

/* The first three are NIfTI, which may not be built in. */
enum { FIRST_EXAMPLE = QNI_HAVE_NIFTI ? 0 : 3, EXAMPLE_COUNT = 15 };

/* The name to read it by; *text_out: the samples are text, whose last digits can be cut unseen. */
static inline const char *put_example(bytes *to, int which, bool *text_out) {
    static const char nrrd[] =
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 5\nendian: little\n";
    static const char mha[] =
        "ObjectType = Image\nNDims = 3\nDimSize = 4 3 5\nElementType = MET_SHORT\n";
    static const char inr[] = "#INRIMAGE-4#{\nXDIM=4\nYDIM=3\nZDIM=5\nVDIM=1\nTYPE=signed fixed\n"
                              "PIXSIZE=16 bits\nCPU=decm\nVX=1\n";
    nifti_fields f = {.scalar = QN_I16, .version = 1, .pixdim = {1, 1, 1, 1}, .slope = 1};
    bytes *block = calloc(1, sizeof *block);
    char line[64];
    put_block(block, QN_I16, false);
    to->size = 0;
    *text_out = which == 5;
    const char *name = "x.nii";
    switch (which) {
    case 0:
        put_nifti(to, &f);
        break;
    case 1:
        put_nifti(to, &f);
        pack_all(to);
        name = "x.nii.gz";
        break;
    case 2:
        f.version = 2;
        f.big = true;
        put_nifti(to, &f);
        break;
    case 3:
        put_text(to, nrrd);
        put_text(to, "encoding: raw\n\n");
        put(to, block->data, (size_t)block->size);
        name = "x.nrrd";
        break;
    case 4:
        put_text(to, nrrd);
        put_text(to, "encoding: gzip\n\n");
        put_packed(to, block->data, block->size, 31);
        name = "x.nrrd";
        break;
    case 5:
        put_text(to, nrrd);
        put_text(to, "encoding: text\n\n");
        for (int i = 0; i < BLOCK_COUNT; ++i) {
            snprintf(line, sizeof line, "%d\n", (int)block_value(QN_I16, i));
            put_text(to, line);
        }
        name = "x.nrrd";
        break;
    case 6:
        put_text(to, mha);
        put_text(to, "ElementDataFile = LOCAL\n");
        put(to, block->data, (size_t)block->size);
        name = "x.mha";
        break;
    case 7:
        put_text(to, mha);
        put_text(to, "CompressedData = True\nElementDataFile = LOCAL\n");
        put_packed(to, block->data, block->size, 15);
        name = "x.mha";
        break;
    case 8:
        put_npy_header(to, "{'descr': '<i2', 'fortran_order': True, 'shape': (4, 3, 5), }\n", 1);
        put(to, block->data, (size_t)block->size);
        name = "x.npy";
        break;
    case 9:
        put_npy_header(to, "{'descr': '<i2', 'fortran_order': True, 'shape': (4, 3, 5), }\n", 2);
        put(to, block->data, (size_t)block->size);
        pack_all(to);
        name = "x.npy.gz";
        break;
    case 10:
        put(to, block->data, (size_t)block->size);
        name = "x.raw";
        break;
    case 11:
        put(to, block->data, (size_t)block->size);
        pack_all(to);
        name = "x.raw.gz";
        break;
    case 12:
        put_text(to, inr);
        while (to->size < 252)
            put_text(to, "\n");
        put_text(to, "##}\n");
        put(to, block->data, (size_t)block->size);
        name = "x.inr";
        break;
    case 13: /* two gzip members, one after the other */
        put_packed(to, block->data, 50, 31);
        put_packed(to, block->data + 50, block->size - 50, 31);
        name = "x.raw.gz";
        break;
    case 14:
        put(to, "VOL\x03", 4);
        put(to, (const int32_t[5]){1, 4, 3, 5, 1}, 20);
        put(to, (const float[6]){0, 0, 0, 1, 1, 1}, 24);
        put_block(to, QN_F32, false);
        name = "x.vol";
        break;
    default:
        abort();
    }
    free(block);
    return name;
}

static inline void example_options(int which, qn_volume_read_options *options) {
    qn_volume_read_options_init(options);
    if (which != 10 && which != 11 && which != 13)
        return;
    options->raw_size[0] = BLOCK_X;
    options->raw_size[1] = BLOCK_Y;
    options->raw_size[2] = BLOCK_Z;
    options->raw_scalar = QN_I16;
}

/* ---- files on disk ---- */

static inline void write_file(const char *folder, const char *name, const void *data, int64_t size,
                              char path_out[256]) {
    snprintf(path_out, 256, "%s/%s", folder, name);
    FILE *file = fopen(path_out, "wb");
    if (!file || fwrite(data, 1, (size_t)size, file) != (size_t)size || fclose(file) != 0)
        abort();
}

static inline bool near_matrix(const qn_volume *volume, const double rows[3][4], double tolerance) {
    const qn_grid *grid = qn_volume_grid(volume);
    for (int i = 0; i < 12; ++i) {
        double difference = grid->index_to_world[i / 4][i % 4] - rows[i / 4][i % 4];
        if (!(difference <= tolerance && difference >= -tolerance))
            return false;
    }
    return true;
}

#endif
