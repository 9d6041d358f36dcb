// SPDX-License-Identifier: MIT
/* NIfTI: every type, version and byte order; which transform counts; slope, units, pairs; what is
 * refused. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <unistd.h>

#include "lib/volume_files.h"

static qn_context *context;

static int set_up(void **state) {
    (void)state;
    return qn_context_create(NULL, &context, NULL);
}

static int tear_down(void **state) {
    (void)state;
    qn_context_destroy(context);
    return 0;
}

static nifti_fields plain(void) {
    nifti_fields f = {.scalar = QN_I16, .version = 1, .pixdim = {1, 1, 1, 1}};
    return f;
}

static qn_status read_fields(const nifti_fields *f, qn_transform_choice choice, qn_volume **volume,
                             qn_error *error) {
    bytes file = {.size = 0};
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    options.transform = choice;
    put_nifti(&file, f);
    return qni_volume_read_memory(context, "x.nii", file.data, file.size, &options, volume, error);
}

static void every_type_version_and_byte_order(void **state) {
    (void)state;
    for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar)
        for (int way = 0; way < 4; ++way) {
            nifti_fields f = plain();
            f.scalar = (qn_scalar)scalar;
            f.version = 1 + way % 2;
            f.big = way / 2;
            qn_volume *volume;
            assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, NULL), QN_OK);
            assert_true(holds_block(volume, f.scalar));
            assert_string_equal(qn_volume_format(volume), "nifti");
            qn_volume_destroy(volume);
        }
}

/* A quarter turn about z: quaternion (cos 45, 0, 0, sin 45), and another matrix as sform. */
static nifti_fields with_transforms(int qform_code, int sform_code, int version) {
    nifti_fields f = plain();
    double s[3][4] = {{2, 0.5, 0, 10}, {0, 3, 0.25, 20}, {0, 0, 4, 30}};
    f.version = version;
    f.qform_code = qform_code;
    f.sform_code = sform_code;
    f.pixdim[1] = 2;
    f.pixdim[2] = 3;
    f.pixdim[3] = 4;
    f.quatern[2] = 0.70710678118654752;
    f.qoffset[0] = -1;
    f.qoffset[1] = -2;
    f.qoffset[2] = -3;
    memcpy(f.srow, s, sizeof s);
    return f;
}

static const double by_sform[3][4] = {{2, 0.5, 0, 10}, {0, 3, 0.25, 20}, {0, 0, 4, 30}};
static const double by_qform[3][4] = {{0, -3, 0, -1}, {2, 0, 0, -2}, {0, 0, 4, -3}};
static const double by_pixdim[3][4] = {{2, 0, 0, 0}, {0, 3, 0, 0}, {0, 0, 4, 0}};

static void the_higher_code_counts_and_sform_on_ties(void **state) {
    (void)state;
    static const struct {
        int qform, sform;
        const double (*rows)[4];
    } cases[] = {{0, 0, by_pixdim}, {1, 0, by_qform}, {0, 1, by_sform}, {1, 1, by_sform},
                 {2, 1, by_qform},  {1, 2, by_sform}, {4, 4, by_sform}, {4, 3, by_qform}};
    for (size_t c = 0; c < 2 * sizeof cases / sizeof cases[0]; ++c) {
        size_t which = c / 2;
        nifti_fields f = with_transforms(cases[which].qform, cases[which].sform, 1 + (int)(c % 2));
        qn_volume *volume;
        assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, NULL), QN_OK);
        assert_true(near_matrix(volume, cases[which].rows, 1e-6));
        assert_string_equal(qn_volume_grid(volume)->space,
                            cases[which].rows == by_pixdim ? "" : "RAS");
        qn_volume_destroy(volume);
    }
}

static void a_transform_can_be_chosen_but_not_one_that_is_unset(void **state) {
    (void)state;
    nifti_fields f = with_transforms(2, 1, 1);
    static const double(*const rows[])[4] = {by_qform, by_sform, by_qform, by_pixdim};
    for (int choice = QN_TRANSFORM_AUTO; choice <= QN_TRANSFORM_PIXDIM; ++choice) {
        qn_volume *volume;
        assert_int_equal(read_fields(&f, (qn_transform_choice)choice, &volume, NULL), QN_OK);
        assert_true(near_matrix(volume, rows[choice], 1e-6));
        qn_volume_destroy(volume);
    }
    qn_volume *volume;
    qn_error error;
    f = with_transforms(0, 1, 1);
    assert_int_equal(read_fields(&f, QN_TRANSFORM_QFORM, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "--transform sform"));
    f = with_transforms(1, 0, 1);
    assert_int_equal(read_fields(&f, QN_TRANSFORM_SFORM, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "--transform qform"));
}

static void a_negative_qfac_mirrors(void **state) {
    (void)state;
    nifti_fields f = with_transforms(1, 0, 1);
    f.pixdim[0] = -1;
    const double rows[3][4] = {{0, -3, 0, -1}, {2, 0, 0, -2}, {0, 0, -4, -3}};
    qn_volume *volume;
    assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, NULL), QN_OK);
    assert_true(near_matrix(volume, rows, 1e-6));
    qn_volume_destroy(volume);
}

static void slope_intercept_and_units(void **state) {
    (void)state;
    static const struct {
        double slope, intercept, slope_read, intercept_read;
        qn_status status;
    } cases[] = {{0, 7, 1, 0, QN_OK},
                 {0.5, -1024, 0.5, -1024, QN_OK},
                 {-2, 3, -2, 3, QN_OK},
                 {(double)NAN, 3, 1, 0, QN_OK},
                 {(double)INFINITY, 0, 0, 0, QN_ERROR_INPUT},
                 {1, (double)NAN, 0, 0, QN_ERROR_INPUT}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        nifti_fields f = plain();
        f.slope = cases[c].slope;
        f.intercept = cases[c].intercept;
        f.units = 2 + 8; /* mm and seconds */
        qn_volume *volume;
        assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, NULL), cases[c].status);
        if (!volume)
            continue;
        assert_true(qn_volume_grid(volume)->slope == cases[c].slope_read);
        assert_true(qn_volume_grid(volume)->intercept == cases[c].intercept_read);
        assert_string_equal(qn_volume_grid(volume)->unit, "mm");
        qn_volume_destroy(volume);
    }
}

static void pairs_are_found_from_either_file(void **state) {
    (void)state;
    char folder[] = "/tmp/quoin-nifti-XXXXXX", header_path[256], image_path[256], packed_path[256];
    assert_non_null(mkdtemp(folder));
    nifti_fields f = plain();
    f.paired = true;
    bytes header = {.size = 0}, image = {.size = 0};
    put_nifti(&header, &f);
    put_block(&image, f.scalar, f.big);
    write_file(folder, "a.hdr", header.data, header.size, header_path);
    write_file(folder, "a.img", image.data, image.size, image_path);
    for (int round = 0; round < 2; ++round) {
        const char *const paths[] = {header_path, round ? packed_path : image_path};
        for (int p = 0; p < 2; ++p) {
            qn_volume *volume;
            qn_error error = {.message = ""};
            if (qn_volume_read(context, paths[p], NULL, &volume, &error) != QN_OK)
                fail_msg("%s", error.message);
            assert_true(holds_block(volume, f.scalar));
            qn_volume_destroy(volume);
        }
        if (round == 0) { /* once more with the image packed */
            unlink(image_path);
            pack_all(&image);
            write_file(folder, "a.img.gz", image.data, image.size, packed_path);
        }
    }
    unlink(packed_path);
    qn_volume *volume;
    qn_error error;
    assert_int_equal(qn_volume_read(context, header_path, NULL, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "a.img"));
    unlink(header_path);
    rmdir(folder);
}

static void what_is_no_scalar_volume_is_refused(void **state) {
    (void)state;
    static const struct {
        int datatype;
        int64_t dim[8];
        const char *said;
    } cases[] = {{128, {0}, "RGB"},
                 {32, {0}, "COMPLEX"},
                 {1024, {0}, "INT64"},
                 {1536, {0}, "FLOAT128"},
                 {9999, {0}, "9999"},
                 {0, {4, 4, 3, 5, 2, 1, 1, 1}, "dimension 4"},
                 {0, {5, 4, 3, 5, 1, 3, 1, 1}, "dimension 5"},
                 {0, {0x7000, 4, 3, 5, 1, 1, 1, 1}, "dimensions"},
                 {0, {3, 4, -3, 5, 1, 1, 1, 1}, "-3"},
                 {0, {3, 4, 0, 5, 1, 1, 1, 1}, "makes no sense"},
                 {0, {3, 4, 4, 5, 1, 1, 1, 1}, "truncated"}};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        nifti_fields f = plain();
        f.datatype = cases[c].datatype;
        memcpy(f.dim, cases[c].dim, sizeof f.dim);
        qn_volume *volume;
        qn_error error = {.message = ""};
        assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, &error), QN_ERROR_INPUT);
        if (!strstr(error.message, cases[c].said))
            fail_msg("case %d says: %s", (int)c, error.message);
    }
    nifti_fields f = plain(); /* trailing sizes of one are a single volume */
    const int64_t dim[8] = {5, 4, 3, 5, 1, 1, 9, 9};
    memcpy(f.dim, dim, sizeof dim);
    qn_volume *volume;
    assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, NULL), QN_OK);
    qn_volume_destroy(volume);
}

static void spacing_of_zero_and_flat_matrices_are_errors(void **state) {
    (void)state;
    qn_volume *volume;
    qn_error error;
    nifti_fields f = plain();
    f.pixdim[2] = 0;
    assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "--spacing"));
    f = with_transforms(0, 1, 1);
    memset(f.srow[2], 0, sizeof f.srow[2]);
    assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "no inverse"));
    f = with_transforms(0, 1, 2);
    f.srow[1][1] = (double)NAN;
    assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, &error), QN_ERROR_INPUT);
}

static void options_replace_spacing_and_origin(void **state) {
    (void)state;
    nifti_fields f = with_transforms(1, 0, 1);
    bytes file = {.size = 0};
    put_nifti(&file, &f);
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    options.has_spacing = options.has_origin = true;
    options.spacing[0] = 5;
    options.spacing[1] = 6;
    options.spacing[2] = 7;
    options.origin[0] = 100;
    const double rows[3][4] = {{0, -6, 0, 100}, {5, 0, 0, 0}, {0, 0, 7, 0}};
    qn_volume *volume;
    assert_int_equal(
        qni_volume_read_memory(context, "x.nii", file.data, file.size, &options, &volume, NULL),
        QN_OK);
    assert_true(near_matrix(volume, rows, 1e-6));
    qn_volume_destroy(volume);
    options.spacing[1] = -6;
    assert_int_equal(
        qni_volume_read_memory(context, "x.nii", file.data, file.size, &options, &volume, NULL),
        QN_ERROR_INVALID_ARGUMENT);
}

static void without_the_library_it_says_how_to_get_it(void **state) {
    (void)state;
    nifti_fields f = plain();
    qn_volume *volume;
    qn_error error;
    assert_int_equal(read_fields(&f, QN_TRANSFORM_AUTO, &volume, &error), QN_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "libnifti2-dev"));
    assert_non_null(strstr(error.message, "-Dnifti"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_version_and_byte_order),
        cmocka_unit_test(the_higher_code_counts_and_sform_on_ties),
        cmocka_unit_test(a_transform_can_be_chosen_but_not_one_that_is_unset),
        cmocka_unit_test(a_negative_qfac_mirrors),
        cmocka_unit_test(slope_intercept_and_units),
        cmocka_unit_test(pairs_are_found_from_either_file),
        cmocka_unit_test(what_is_no_scalar_volume_is_refused),
        cmocka_unit_test(spacing_of_zero_and_flat_matrices_are_errors),
        cmocka_unit_test(options_replace_spacing_and_origin),
    };
    const struct CMUnitTest absent[] = {
        cmocka_unit_test(without_the_library_it_says_how_to_get_it),
    };
    return QNI_HAVE_NIFTI ? cmocka_run_group_tests(tests, set_up, tear_down)
                          : cmocka_run_group_tests(absent, set_up, tear_down);
}
