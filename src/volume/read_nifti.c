// SPDX-License-Identifier: MIT
/* NIfTI-1 and NIfTI-2, single (.nii) and paired (.hdr with .img), in either byte order.
 * Of nifti_clib only the header structs and the calls that compute (byte swapping, quaternion, type
 * names) are used: its readers print and trust headers, so every field is checked here and samples
 * come from our source. */
#include "core/status.h"
#include "qni_config.h"
#include "volume/header_text.h"
#include "volume/load.h"

#if QNI_HAVE_NIFTI

#include <math.h>
#include <nifti/nifti2_io.h>
#include <string.h>

/* What both versions say, in this machine's byte order. */
typedef struct nifti_facts {
    int64_t dim[8];
    double pixdim[8];
    int datatype;
    double offset, slope, intercept;
    int qform_code, sform_code, units;
    double quatern[3], qoffset[3], srow[3][4];
    bool swapped;
    bool paired;     /* samples are in an .img file */
    int header_size; /* 348 or 540 */
} nifti_facts;

#define COPY_FACTS(facts, header)                                                                  \
    do {                                                                                           \
        for (int i_ = 0; i_ < 8; ++i_) {                                                           \
            (facts)->dim[i_] = (header).dim[i_];                                                   \
            (facts)->pixdim[i_] = (double)(header).pixdim[i_];                                     \
        }                                                                                          \
        for (int i_ = 0; i_ < 4; ++i_) {                                                           \
            (facts)->srow[0][i_] = (double)(header).srow_x[i_];                                    \
            (facts)->srow[1][i_] = (double)(header).srow_y[i_];                                    \
            (facts)->srow[2][i_] = (double)(header).srow_z[i_];                                    \
        }                                                                                          \
        (facts)->datatype = (header).datatype;                                                     \
        (facts)->offset = (double)(header).vox_offset;                                             \
        (facts)->slope = (double)(header).scl_slope;                                               \
        (facts)->intercept = (double)(header).scl_inter;                                           \
        (facts)->qform_code = (header).qform_code;                                                 \
        (facts)->sform_code = (header).sform_code;                                                 \
        (facts)->units = XYZT_TO_SPACE((header).xyzt_units);                                       \
        (facts)->quatern[0] = (double)(header).quatern_b;                                          \
        (facts)->quatern[1] = (double)(header).quatern_c;                                          \
        (facts)->quatern[2] = (double)(header).quatern_d;                                          \
        (facts)->qoffset[0] = (double)(header).qoffset_x;                                          \
        (facts)->qoffset[1] = (double)(header).qoffset_y;                                          \
        (facts)->qoffset[2] = (double)(header).qoffset_z;                                          \
    } while (0)

static qn_status read_version_1(qni_source *source, nifti_facts *facts, qn_error *error) {
    nifti_1_header header;
    QN_TRY(qni_source_read(source, &header, sizeof header, error));
    if (memcmp(header.magic, "n+1", 4) != 0 && memcmp(header.magic, "ni1", 4) != 0)
        return qni_source_fail(
            source, error,
            "has no NIfTI mark at byte 344 (an ANALYZE 7.5 header?); convert it to "
            "NIfTI first");
    facts->swapped = header.sizeof_hdr != 348;
    if (facts->swapped)
        nifti_swap_as_nifti1(&header);
    facts->paired = header.magic[1] == 'i';
    facts->header_size = 348;
    COPY_FACTS(facts, header);
    return QN_OK;
}

static qn_status read_version_2(qni_source *source, nifti_facts *facts, qn_error *error) {
    nifti_2_header header;
    QN_TRY(qni_source_read(source, &header, sizeof header, error));
    if (memcmp(header.magic, "n+2\0\r\n\032\n", 8) != 0 &&
        memcmp(header.magic, "ni2\0\r\n\032\n", 8) != 0)
        return qni_source_fail(
            source, error, "has no NIfTI-2 mark at byte 4; was it changed in a transfer as text?");
    facts->swapped = header.sizeof_hdr != 540;
    if (facts->swapped)
        nifti_swap_as_nifti2(&header);
    facts->paired = header.magic[1] == 'i';
    facts->header_size = 540;
    COPY_FACTS(facts, header);
    return QN_OK;
}

static qn_status read_facts(qni_source *source, nifti_facts *facts, qn_error *error) {
    const unsigned char *bytes;
    int64_t found;
    QN_TRY(qni_source_peek(source, 4, &bytes, &found, error));
    if (found < 4)
        return qni_source_fail_truncated(source, 348, 0, found, error);
    int32_t size, size_swapped;
    memcpy(&size, bytes, 4);
    size_swapped = (int32_t)__builtin_bswap32((uint32_t)size);
    if (size == 348 || size_swapped == 348)
        return read_version_1(source, facts, error);
    if (size == 540 || size_swapped == 540)
        return read_version_2(source, facts, error);
    return qni_source_fail(source, error,
                           "is no NIfTI file: it begins with %d where 348 or 540 must stand", size);
}

static qn_status check_sizes(const qni_source *source, const nifti_facts *facts, qn_grid *grid,
                             qn_error *error) {
    int64_t count = facts->dim[0];
    if (count < 1 || count > 7)
        return qni_source_fail(source, error,
                               "its NIfTI header asks for %lld dimensions, of 1 to 7",
                               (long long)count);
    for (int a = 0; a < 3; ++a)
        grid->size[a] = a < count ? facts->dim[a + 1] : 1;
    for (int a = 4; a <= count; ++a)
        if (facts->dim[a] > 1)
            return qni_source_fail(
                source, error,
                "holds %lld volumes along dimension %d; only single volumes are read: "
                "write the one you want to a file of its own",
                (long long)facts->dim[a], a);
    return QN_OK;
}

static qn_status choose_scalar(const qni_source *source, int datatype, qn_scalar *scalar,
                               qn_error *error) {
    switch (datatype) {
    case NIFTI_TYPE_UINT8:
        *scalar = QN_U8;
        return QN_OK;
    case NIFTI_TYPE_INT8:
        *scalar = QN_I8;
        return QN_OK;
    case NIFTI_TYPE_UINT16:
        *scalar = QN_U16;
        return QN_OK;
    case NIFTI_TYPE_INT16:
        *scalar = QN_I16;
        return QN_OK;
    case NIFTI_TYPE_UINT32:
        *scalar = QN_U32;
        return QN_OK;
    case NIFTI_TYPE_INT32:
        *scalar = QN_I32;
        return QN_OK;
    case NIFTI_TYPE_FLOAT32:
        *scalar = QN_F32;
        return QN_OK;
    case NIFTI_TYPE_FLOAT64:
        *scalar = QN_F64;
        return QN_OK;
    default:
        return qni_source_fail(
            source, error,
            "samples of NIfTI type %d (%s) are not read; convert it to an integer type of "
            "8 to 32 bits, or to float",
            datatype, nifti_datatype_to_string(datatype));
    }
}

/* Method 1 of the NIfTI standard: spacing alone. */
static qn_status pixdim_matrix(const qni_source *source, const nifti_facts *facts,
                               const qn_volume_read_options *options, double matrix[4][4],
                               qn_error *error) {
    memset(matrix, 0, sizeof(double[4][4]));
    for (int a = 0; a < 3; ++a) {
        matrix[a][a] = fabs(facts->pixdim[a + 1]);
        if (options->has_spacing)
            matrix[a][a] = 1; /* replaced below in any case */
        else if (!(matrix[a][a] > 0) || !isfinite(matrix[a][a]))
            return qni_source_fail(
                source, error,
                "its NIfTI header has a spacing of %g along axis %d; give --spacing X,Y,Z",
                facts->pixdim[a + 1], a);
    }
    matrix[3][3] = 1;
    return QN_OK;
}

static void sform_matrix(const nifti_facts *facts, double matrix[4][4]) {
    memcpy(matrix, facts->srow, sizeof facts->srow);
    matrix[3][0] = matrix[3][1] = matrix[3][2] = 0;
    matrix[3][3] = 1;
}

static void qform_matrix(const nifti_facts *facts, double matrix[4][4]) {
    nifti_dmat44 computed = nifti_quatern_to_dmat44(
        facts->quatern[0], facts->quatern[1], facts->quatern[2], facts->qoffset[0],
        facts->qoffset[1], facts->qoffset[2], facts->pixdim[1], facts->pixdim[2], facts->pixdim[3],
        facts->pixdim[0] < 0 ? -1.0 : 1.0);
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            matrix[row][column] = computed.m[row][column];
}

/* The transform with the higher code, the sform on ties; one with code 0 says nothing. */
static qn_status choose_matrix(const qni_source *source, const nifti_facts *facts,
                               const qn_volume_read_options *options, qn_grid *grid,
                               qn_error *error) {
    qn_transform_choice choice = options->transform;
    if (choice == QN_TRANSFORM_AUTO && (facts->sform_code > 0 || facts->qform_code > 0))
        choice = facts->sform_code >= facts->qform_code ? QN_TRANSFORM_SFORM : QN_TRANSFORM_QFORM;
    bool sform = choice == QN_TRANSFORM_SFORM;
    if (!sform && choice != QN_TRANSFORM_QFORM)
        return pixdim_matrix(source, facts, options, grid->index_to_world, error);
    int code = sform ? facts->sform_code : facts->qform_code;
    if (code <= 0)
        return qni_source_fail(
            source, error,
            "its %s has code %d, which means it is not set; use --transform %s or pixdim",
            sform ? "sform" : "qform", code,
            (sform ? facts->qform_code : facts->sform_code) <= 0 ? "auto"
            : sform                                              ? "qform"
                                                                 : "sform");
    if (sform)
        sform_matrix(facts, grid->index_to_world);
    else
        qform_matrix(facts, grid->index_to_world);
    strcpy(grid->space, "RAS");
    return QN_OK;
}

static qn_status choose_values(const qni_source *source, const nifti_facts *facts, qn_grid *grid,
                               qn_error *error) {
    static const char *const units[] = {"", "m", "mm", "um"};
    if (facts->units >= 1 && facts->units <= 3)
        strcpy(grid->unit, units[facts->units]);
    grid->slope = 1;
    if (facts->slope == 0 || isnan(facts->slope)) /* both mean: not scaled */
        return QN_OK;
    if (!isfinite(facts->slope) || !isfinite(facts->intercept))
        return qni_source_fail(source, error,
                               "its scl_slope %g and scl_inter %g are not both finite numbers",
                               facts->slope, facts->intercept);
    grid->slope = facts->slope;
    grid->intercept = facts->intercept;
    return QN_OK;
}

/* Samples begin at vox_offset; a single file has them after the header and four bytes of flags. */
static qn_status skip_to_samples(qni_source *source, const nifti_facts *facts, qn_error *error) {
    double first = facts->paired ? 0 : facts->header_size + 4;
    double offset = facts->offset == 0 ? first : facts->offset;
    const double largest = 9e15; /* integers up to here are exact in a double */
    if (!(offset >= first && offset <= largest) || offset != floor(offset))
        return qni_source_fail(source, error, "its samples begin at byte %g, which makes no sense",
                               facts->offset);
    return qni_source_skip(source, (int64_t)offset - source->offset, error);
}

static qn_status load(qni_source *source, const nifti_facts *facts, qn_grid *grid,
                      qn_volume **volume_out, qn_error *error) {
    QN_TRY(skip_to_samples(source, facts, error));
    return qni_load(source, grid, QNI_BINARY, "nifti", NULL, volume_out, error);
}

/* The other file of a pair: "head.hdr" and "head.img", either of them perhaps with ".gz". */
static qn_status open_partner(const qni_source *source, const char *from, const char *to,
                              qni_source *partner, qn_error *error) {
    const char *slash = strrchr(source->path, '/');
    const char *own = slash ? slash + 1 : source->path;
    char name[512];
    size_t length = strlen(own);
    if (qni_text_ends(own, ".gz"))
        length -= 3;
    if (length < 4 || length > sizeof name - 8 || strncasecmp(own + length - 4, from, 4) != 0)
        return qni_source_fail(source, error,
                               "is one of a NIfTI pair, whose files must be named .hdr and .img");
    memcpy(name, own, length);
    bool upper = own[length - 1] >= 'A' && own[length - 1] <= 'Z';
    for (int i = 0; i < 4; ++i)
        name[length - 4 + (size_t)i] = (char)(upper && i > 0 ? to[i] - 'a' + 'A' : to[i]);
    strcpy(name + length, ".gz");
    if (qni_source_open_beside(source, name, partner, NULL) == QN_OK)
        return QN_OK;
    name[length] = 0;
    return qni_source_open_beside(source, name, partner, error);
}

static qn_status read_header(qni_source *source, const qn_volume_read_options *options,
                             nifti_facts *facts, qn_grid *grid, qn_error *error) {
    QN_TRY(read_facts(source, facts, error));
    QN_TRY(check_sizes(source, facts, grid, error));
    QN_TRY(choose_scalar(source, facts->datatype, &grid->scalar, error));
    grid->swapped = facts->swapped;
    QN_TRY(choose_matrix(source, facts, options, grid, error));
    QN_TRY(qni_load_overrides(source, options, grid->index_to_world, error));
    return choose_values(source, facts, grid, error);
}

static bool is_image_name(const char *path) {
    return qni_text_ends(path, ".img") || qni_text_ends(path, ".img.gz");
}

qn_status qni_read_nifti(qni_source *source, const qn_volume_read_options *options,
                         qn_volume **volume_out, qn_error *error) {
    nifti_facts facts = {.swapped = false};
    qn_grid grid = {.slope = 1};
    qni_source partner;
    if (is_image_name(source->path)) {
        QN_TRY(open_partner(source, ".img", ".hdr", &partner, error));
        qn_status status = read_header(&partner, options, &facts, &grid, error);
        qni_source_close(&partner);
        QN_TRY(status);
        if (!facts.paired)
            return qni_source_fail(source, error,
                                   "its header beside it says that it is a single file");
        return load(source, &facts, &grid, volume_out, error);
    }
    QN_TRY(read_header(source, options, &facts, &grid, error));
    if (!facts.paired)
        return load(source, &facts, &grid, volume_out, error);
    QN_TRY(open_partner(source, ".hdr", ".img", &partner, error));
    qn_status status = load(&partner, &facts, &grid, volume_out, error);
    qni_source_close(&partner);
    return status;
}

#else

qn_status qni_read_nifti(qni_source *source, const qn_volume_read_options *options,
                         qn_volume **volume_out, qn_error *error) {
    (void)options;
    *volume_out = NULL;
    return qni_source_fail_as(
        source, QN_ERROR_UNSUPPORTED, error,
        "NIfTI volumes are not built in: install libnifti2-dev and configure with "
        "-Dnifti=enabled");
}

#endif
