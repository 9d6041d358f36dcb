// SPDX-License-Identifier: MIT
/* Volumes: scalar samples on a regular lattice with an affine map from sample index to world. */
#ifndef QN_VOLUME_H
#define QN_VOLUME_H

#include <qn/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Scalar types: name, C type, text as in --dtype. */
#define QN_SCALAR_MAP(X)                                                                           \
    X(U8, uint8_t, "u8")                                                                           \
    X(I8, int8_t, "i8")                                                                            \
    X(U16, uint16_t, "u16")                                                                        \
    X(I16, int16_t, "i16")                                                                         \
    X(U32, uint32_t, "u32")                                                                        \
    X(I32, int32_t, "i32")                                                                         \
    X(F32, float, "f32")                                                                           \
    X(F64, double, "f64")

typedef enum qn_scalar {
#define QN_SCALAR_ENUM(name, type, text) QN_##name,
    QN_SCALAR_MAP(QN_SCALAR_ENUM) QN_SCALAR_COUNT
#undef QN_SCALAR_ENUM
} qn_scalar;

QN_API size_t qn_scalar_size(qn_scalar scalar);      /* bytes a sample; 0 for no such type */
QN_API const char *qn_scalar_name(qn_scalar scalar); /* "u8" ... "f64" */

/* A dense grid of samples. The sample of index (i, j, k) lies at
 * (char *)samples + i * stride[0] + j * stride[1] + k * stride[2]; its value is
 * slope * stored + intercept; its place is index_to_world * (i, j, k, 1), row by row, so that
 * index_to_world[0] gives the world x. A sample is a point; nothing is shifted by half a voxel. */
typedef struct qn_grid {
    const void *samples;
    qn_scalar scalar;
    bool swapped;      /* stored in the other byte order than this machine's */
    int64_t size[3];   /* samples along x, y, z; each at least 1 */
    int64_t stride[3]; /* bytes, may be negative; all 0: packed, x fastest */
    double slope;      /* 0 stands for 1 */
    double intercept;
    double index_to_world[4][4]; /* all 0 stands for the identity; the last row must be 0 0 0 1 */
    char space[32];              /* name of the world space ("RAS"), or empty */
    char unit[16];               /* unit of length ("mm"), or empty */
} qn_grid;

typedef struct qn_volume qn_volume;

/* Called once when an owned volume's samples are no longer needed, on the destroying thread. */
typedef void (*qn_release)(void *user, const void *samples);

/* Make a volume of a grid. The samples are never copied: with release == NULL they are borrowed and
 * must outlive the volume; else the volume owns them and calls `release` once, on success only.
 *
 * QN_ERROR_INVALID_ARGUMENT  a size below 1 or beyond 2^31 - 16, a product that overflows 64 bit, a
 *                            matrix that is not finite or not invertible, a slope that is not
 * finite QN_ERROR_OUT_OF_MEMORY */
QN_API qn_status qn_volume_create(qn_context *context, const qn_grid *grid, qn_release release,
                                  void *release_user, qn_volume **volume_out, qn_error *error);
QN_API void qn_volume_destroy(qn_volume *volume);

/* The grid of a volume, with strides, slope and matrix filled in. Valid while the volume lives. Of
 * a sparse volume: the box of its leaves and tiles, with `samples` NULL and the matrix of the box.
 */
QN_API const qn_grid *qn_volume_grid(const qn_volume *volume);

/* ---- sparse volumes -------------------------------------------------------------------------- */

/* What the values of a sparse volume mean, as OpenVDB names it. */
typedef enum qn_sparse_class {
    QN_SPARSE_UNKNOWN,
    QN_SPARSE_LEVEL_SET, /* a distance, negative inside; the surface is at 0 */
    QN_SPARSE_FOG        /* a density, 0 outside */
} qn_sparse_class;

/* A box of samples of one value. Its corner and sides are multiples of 8. */
typedef struct qn_sparse_tile {
    int32_t origin[3]; /* its lowest sample */
    int32_t size[3];   /* samples along x, y, z */
    double value;
    bool active;
} qn_sparse_tile;

/* A sparse volume: leaves of 8^3 samples, tiles, and the background everywhere else. Samples have
 * integer places (i, j, k), negative ones too; the world place is index_to_world * (i, j, k, 1).
 *
 * Value rule: the value at a place is that of the leaf that holds it, active or not; else that of
 * the tile that holds it; else the background. Surfaces follow from the values alone: a tile inside
 * next to a leaf or background outside gives a surface, and there is no border to be open or
 * closed. So inactive samples must carry the right sign, as OpenVDB's do, and one thing is added:
 * where a level set with a positive background leaves blocks of 8^3 samples free between two leaves
 * or tiles of the same row along x, and all the samples that face the gap on both sides are
 * negative, the gap is inside and holds minus the background. So a narrow band needs no tiles of
 * its own, and one that lost its inner tiles shows no false surface (`filled_blocks` counts them).
 */
typedef struct qn_sparse_grid {
    qn_scalar scalar; /* of the leaves' values: set it, QN_F32 in most cases */
    int64_t leaf_count;
    const int32_t (*origins)[3]; /* of each leaf its lowest sample: multiples of 8, in any order */
    const void *values;          /* [leaf_count][512]: sample x + 8 y + 64 z of each leaf */
    const uint64_t (*masks)[8];  /* bit x + 8 y of word z: the sample is active; NULL: all are */
    int64_t tile_count;
    const qn_sparse_tile *tiles; /* may not overlap each other or leaves; in any order */
    double background;           /* as the tiles' values: rounded to f32, exact for integer types */
    qn_sparse_class kind;
    double index_to_world[4][4]; /* all 0 stands for the identity; the last row must be 0 0 0 1 */
    char space[32];              /* name of the world space, or empty */
    char unit[16];               /* unit of length, or empty */
    char name[64];               /* of the grid, or empty */
} qn_sparse_grid;

/* Make a volume of sparse leaves. The arrays are never copied: with release == NULL they are
 * borrowed and must outlive the volume; else the volume owns them and calls `release` once with
 * `values`, on success only. Beside them it takes about 32 bytes a run of leaves or tile blocks
 * along x, never memory for places without either.
 *
 * QN_ERROR_INVALID_ARGUMENT  an origin or size that is no multiple of 8, two leaves or tiles at one
 *                            place, a spread too large to number (over 2^31 samples along an axis),
 *                            more than 2^26 rows of tiles, a matrix as qn_volume_create() says
 * QN_ERROR_OUT_OF_MEMORY */
QN_API qn_status qn_volume_create_sparse(qn_context *context, const qn_sparse_grid *grid,
                                         qn_release release, void *release_user,
                                         qn_volume **volume_out, qn_error *error);

/* The sparse grid of a volume, matrix filled in; NULL for a dense volume. Valid while it lives. */
QN_API const qn_sparse_grid *qn_volume_sparse_grid(const qn_volume *volume);

/* Counts of a sparse volume. */
typedef struct qn_sparse_info {
    int64_t leaf_count, tile_count;
    int64_t active_count;    /* active samples, those of active tiles too */
    int64_t filled_blocks;   /* blocks of 8^3 samples found inside by the value rule */
    int64_t low[3], high[3]; /* the box of leaves and tiles: first and last sample */
} qn_sparse_info;

/* QN_ERROR_INVALID_ARGUMENT for a dense volume. */
QN_API qn_status qn_volume_sparse_info(qn_context *context, const qn_volume *volume,
                                       qn_sparse_info *info_out, qn_error *error);

/* ---- files ----------------------------------------------------------------------------------- */

/* Which of a NIfTI file's transforms to use. AUTO: the one with the higher code, sform on ties. */
typedef enum qn_transform_choice {
    QN_TRANSFORM_AUTO,
    QN_TRANSFORM_SFORM,
    QN_TRANSFORM_QFORM,
    QN_TRANSFORM_PIXDIM
} qn_transform_choice;

/* What a file without a header needs told, or what shall replace the header's word. */
typedef struct qn_volume_read_options {
    size_t struct_size;
    char format[16];      /* "" by the file's name and first bytes; "nifti" "nrrd" "metaimage" "npy"
                             "raw" */
    int64_t raw_size[3];  /* raw: samples along x, y, z */
    qn_scalar raw_scalar; /* raw: type of a sample */
    bool raw_big_endian;  /* raw: byte order of a sample */
    int64_t raw_header;   /* raw: bytes to skip before the first sample (after unpacking gzip) */
    bool has_spacing;     /* replace the header's spacing, keep its directions */
    double spacing[3];
    bool has_origin; /* replace the header's world position of sample (0, 0, 0) */
    double origin[3];
    qn_transform_choice transform;
    char grid[64]; /* of a file with several grids: the name of the one to read */
} qn_volume_read_options;

static inline void qn_volume_read_options_init(qn_volume_read_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* Read a volume file: NIfTI-1/2 (.nii .nii.gz .hdr), NRRD (.nrrd .nhdr), MetaImage (.mha .mhd),
 * NumPy (.npy), raw (.raw .raw.gz and any other name, with options), and the sparse OpenVDB (.vdb)
 * and NanoVDB (.nvdb). options may be NULL.
 *
 * Of OpenVDB and NanoVDB files scalar grids with an affine map are read: float, double, half-saved,
 * int32, int64 (as f64, exact or refused), bool and mask (0 and 1). Vector and point grids and
 * frustum maps are refused by name. A file with several scalar grids needs options->grid.
 *
 * QN_ERROR_INPUT             no such file, not of a known format, truncated, or a header that makes
 * no sense; the message names the file, what was found and what to do QN_ERROR_INVALID_ARGUMENT
 * options that contradict each other, or a raw file without its shape QN_ERROR_OUT_OF_MEMORY,
 * QN_ERROR_UNSUPPORTED (NIfTI without -Dnifti) */
QN_API qn_status qn_volume_read(qn_context *context, const char *path,
                                const qn_volume_read_options *options, qn_volume **volume_out,
                                qn_error *error);
/* What a grid of an OpenVDB or NanoVDB file is, without reading its values. */
typedef struct qn_grid_info {
    char name[64];
    char type[32]; /* "float", "double", "int32", "bool", "vec3s" ... */
    qn_sparse_class kind;
    bool half;     /* its values are stored as 16-bit floats */
    bool frustum;  /* its map is no affine one */
    bool readable; /* qn_volume_read() can read it */
} qn_grid_info;

/* List the grids of a file: the first `capacity` of them in infos_out, their number in *count_out.
 * A file of another format has none.
 *
 * QN_ERROR_INPUT, QN_ERROR_UNSUPPORTED as qn_volume_read() */
QN_API qn_status qn_volume_list_grids(qn_context *context, const char *path,
                                      qn_grid_info *infos_out, int32_t capacity,
                                      int32_t *count_out, qn_error *error);

/* Write a volume into a file, by its name's ending: .vdb (sparse f32 volumes: leaves, tiles,
 * background, class and map), .npy (samples alone, axes x, y, z in Fortran order) or .nii (samples,
 * map and unit). Of a sparse volume .npy and .nii get the dense box of its leaves and tiles. The
 * file appears whole or not at all.
 *
 * QN_ERROR_INVALID_ARGUMENT  another ending; a .vdb of a dense volume or of other samples than f32;
 *                            a dense box above 8 GiB, or above 32767 samples a side in .nii
 * QN_ERROR_OUTPUT, QN_ERROR_OUT_OF_MEMORY, QN_ERROR_CANCELLED; QN_ERROR_UNSUPPORTED (.vdb without
 * -Dopenvdb) */
QN_API qn_status qn_volume_write(qn_context *context, const qn_volume *volume, const char *path,
                                 qn_error *error);

/* The format a volume was read from ("nifti", "nrrd" ...), "" for one made from a grid. */
QN_API const char *qn_volume_format(const qn_volume *volume);

enum { QN_HISTOGRAM_BINS = 256, QN_SUGGESTION_COUNT = 3 };

/* What the samples hold. Values are after slope and intercept. Of a sparse volume: the samples that
 * its leaves store, active or not. */
typedef struct qn_volume_statistics {
    int64_t sample_count;
    int64_t nan_count;
    int64_t infinite_count;
    double minimum, maximum, mean;        /* of the finite samples; NaN when there are none */
    int64_t histogram[QN_HISTOGRAM_BINS]; /* equal bins from minimum to maximum */
    /* Iso-values worth trying, ascending, by Otsu's thresholds of the histogram, placed off the
     * stored integers' values so that no sample ties; `suggested` is the one to start with, NaN
     * when all samples are alike and there is none. */
    double suggestions[QN_SUGGESTION_COUNT];
    int32_t suggestion_count;
    double suggested;
} qn_volume_statistics;

QN_API qn_status qn_volume_get_statistics(qn_context *context, const qn_volume *volume,
                                          qn_volume_statistics *statistics_out, qn_error *error);

/* Which side of the iso-value is solid. Normals point out of the solid either way. */
typedef enum qn_inside {
    QN_INSIDE_ABOVE, /* density-like data (CT, fog): inside is value >= iso */
    QN_INSIDE_BELOW  /* distance-like data: inside is value < iso */
} qn_inside;

#ifdef __cplusplus
}
#endif
#endif
