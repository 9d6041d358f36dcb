// SPDX-License-Identifier: MIT
/* NRRD, MetaImage and INRIMAGE: every type, byte order and encoding; matrices, detached data, what
 * is refused. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <locale.h>
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

static qn_status read_all(const bytes *file, const char *name, qn_volume **volume,
                          qn_error *error) {
    return qni_volume_read_memory(context, name, file->data, file->size, NULL, volume, error);
}

static void expect_block(const bytes *file, const char *name, qn_scalar scalar) {
    qn_volume *volume;
    qn_error error = {.message = ""};
    if (read_all(file, name, &volume, &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_true(holds_block(volume, scalar));
    qn_volume_destroy(volume);
}

/* A header followed by enough bytes for any block must be refused with these words. */
static void expect_refusal(const char *text, const char *name, const char *words) {
    bytes file = {.size = 0};
    put_text(&file, text);
    put_block(&file, QN_F64, false);
    qn_volume *volume;
    qn_error error = {.message = ""};
    qn_status status = read_all(&file, name, &volume, &error);
    if (status != QN_ERROR_INPUT || !strstr(error.message, words))
        fail_msg("status %d, '%s' where '%s' was meant", (int)status, error.message, words);
}

static void put_text_block(bytes *file, qn_scalar scalar, const char *gap) {
    for (int i = 0; i < BLOCK_COUNT; ++i) {
        char number[64];
        snprintf(number, sizeof number, "%.17g%s", block_value(scalar, i), gap);
        put_text(file, number);
    }
}

/* ---- NRRD ---- */

static void nrrd_types_by_all_their_names(void **state) {
    (void)state;
    static const struct {
        const char *name;
        qn_scalar scalar;
    } types[] = {{"signed char", QN_I8},
                 {"int8", QN_I8},
                 {"int8_t", QN_I8},
                 {"uchar", QN_U8},
                 {"unsigned char", QN_U8},
                 {"uint8", QN_U8},
                 {"uint8_t", QN_U8},
                 {"short", QN_I16},
                 {"short int", QN_I16},
                 {"signed short", QN_I16},
                 {"signed short int", QN_I16},
                 {"int16", QN_I16},
                 {"int16_t", QN_I16},
                 {"ushort", QN_U16},
                 {"unsigned short", QN_U16},
                 {"unsigned short int", QN_U16},
                 {"uint16", QN_U16},
                 {"uint16_t", QN_U16},
                 {"int", QN_I32},
                 {"signed int", QN_I32},
                 {"int32", QN_I32},
                 {"int32_t", QN_I32},
                 {"uint", QN_U32},
                 {"unsigned int", QN_U32},
                 {"uint32", QN_U32},
                 {"uint32_t", QN_U32},
                 {"float", QN_F32},
                 {"double", QN_F64}};
    static const char *const encodings[] = {"raw", "gzip", "gz", "text", "txt", "ascii"};
    for (size_t t = 0; t < sizeof types / sizeof types[0]; ++t)
        for (int e = 0; e < 6; ++e)
            for (int big = 0; big < 2; ++big) {
                bytes file = {.size = 0}, block = {.size = 0};
                char text[256];
                snprintf(
                    text, sizeof text,
                    "NRRD0005\r\n# a comment: of any kind\nkey:=value\ntype: %s\ndimension: 3\n"
                    "sizes: 4 3 5\nendian: %s\nencoding: %s\n\n",
                    types[t].name, big ? "big" : "little", encodings[e]);
                put_text(&file, text);
                put_block(&block, types[t].scalar, big);
                if (e == 0)
                    put(&file, block.data, (size_t)block.size);
                else if (e < 3)
                    put_packed(&file, block.data, block.size, 31);
                else
                    put_text_block(&file, types[t].scalar, e == 3 ? "\n" : e == 4 ? " \t" : ", ");
                expect_block(&file, "x.nrrd", types[t].scalar);
            }
}

#define NRRD_START "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n"

static void nrrd_space_directions_origin_and_units(void **state) {
    (void)state;
    bytes file = {.size = 0};
    put_text(&file, NRRD_START "space: left-posterior-superior\n"
                               "space directions: (0, 2,0) (-3,0,0.25)  (0,0,4)\n"
                               "space origin: (1.5,-2,1e1)\nspace units: \"mm\" \"mm\" \"mm\"\n\n");
    put_block(&file, QN_U8, false);
    const double rows[3][4] = {{0, -3, 0, 1.5}, {2, 0, 0, -2}, {0, 0.25, 4, 10}};
    qn_volume *volume;
    assert_int_equal(read_all(&file, "x.nrrd", &volume, NULL), QN_OK);
    assert_true(near_matrix(volume, rows, 0));
    assert_string_equal(qn_volume_grid(volume)->space, "LPS");
    assert_string_equal(qn_volume_grid(volume)->unit, "mm");
    qn_volume_destroy(volume);

    file.size = 0;
    put_text(&file, NRRD_START "spacings: 0.5 nan 2\nunits: \"mm\" \"cm\" \"mm\"\n\n");
    put_block(&file, QN_U8, false);
    const double spaced[3][4] = {{0.5, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 2, 0}};
    assert_int_equal(read_all(&file, "x.nrrd", &volume, NULL), QN_OK);
    assert_true(near_matrix(volume, spaced, 0));
    assert_string_equal(qn_volume_grid(volume)->space, "");
    assert_string_equal(qn_volume_grid(volume)->unit, "");
    qn_volume_destroy(volume);
}

static void nrrd_skips_lines_and_bytes(void **state) {
    (void)state;
    bytes file = {.size = 0};
    put_text(&file, NRRD_START "line skip: 2\nbyte skip: 3\n\none\ntwo\nabc");
    put_block(&file, QN_U8, false);
    expect_block(&file, "x.nrrd", QN_U8);
    file.size = 0;
    put_text(&file, NRRD_START "byte skip: -1\n\nanything of any length");
    put_block(&file, QN_U8, false);
    expect_block(&file, "x.nrrd", QN_U8);
}

static void nrrd_data_in_a_file_of_its_own(void **state) {
    (void)state;
    char folder[] = "/tmp/quoin-nrrd-XXXXXX", header_path[256], data_path[256];
    assert_non_null(mkdtemp(folder));
    static const char *const endings[] = {
        "encoding: raw\ndata file: the data.raw\n",
        "encoding: raw\ndata file: the data.raw", /* no line end */
        "encoding: gzip\ndatafile: the data.raw\n\n",
        "encoding: text\ndata file: the data.raw\n\n"};
    for (int e = 0; e < 4; ++e) {
        bytes header = {.size = 0}, data = {.size = 0};
        put_text(&header, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 5\n");
        put_text(&header, endings[e]);
        if (e == 3)
            put_text_block(&data, QN_U8, " ");
        else
            put_block(&data, QN_U8, false);
        if (e == 2)
            pack_all(&data);
        write_file(folder, "a.nhdr", header.data, header.size, header_path);
        write_file(folder, "the data.raw", data.data, data.size, data_path);
        qn_volume *volume;
        qn_error error = {.message = ""};
        if (qn_volume_read(context, header_path, NULL, &volume, &error) != QN_OK)
            fail_msg("%s", error.message);
        assert_true(holds_block(volume, QN_U8));
        qn_volume_destroy(volume);
    }
    unlink(data_path);
    qn_volume *volume;
    qn_error error;
    assert_int_equal(qn_volume_read(context, header_path, NULL, &volume, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "the data.raw"));
    unlink(header_path);
    rmdir(folder);
}

static void nrrd_refusals_say_why(void **state) {
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 4 3 5\nencoding: raw\n\n", "4 axes"},
        {"NRRD0004\ntype: long long\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n", "long long"},
        {"NRRD0004\ntype: block\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n", "block"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 5\nencoding: bzip2\n\n", "bzip2"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 5\nencoding: hex\n\n", "hex"},
        {"NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n", "endian"},
        {"NRRD0004\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n", "'type'"},
        {"NRRD0004\ntype: uchar\nsizes: 4 3 5\nencoding: raw\n\n", "'dimension'"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nencoding: raw\n\n", "'sizes'"},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 5\n\n", "'encoding'"},
        {NRRD_START "space directions: (1,0,0) none (0,0,1)\n\n", "space directions"},
        {NRRD_START "space directions: (1,0,0) (1,0,0) (0,0,1)\n\n", "no inverse"},
        {NRRD_START "spacings: 1 0 1\n\n", "no inverse"},
        {NRRD_START "space dimension: 4\n\n", "space dimension"},
        {NRRD_START "data file: LIST\n\n", "several"},
        {NRRD_START "data file: a%03d.raw 1 5 1\n\n", "several"},
        {NRRD_START "byte skip: -2\n\n", "byte skip"},
        {NRRD_START "byte skip: 9000000000000000000\n\n", "truncated"},
        {NRRD_START "nonsense\n\n", "colon"},
        {"NRRD0009\n\n", "NRRD0001"},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c)
        expect_refusal(cases[c].text, "x.nrrd", cases[c].words);
}

static void text_samples_must_be_numbers_of_the_type(void **state) {
    (void)state;
    static const char *const wrong[] = {"256", "-1", "1.5", "1e9", "x", "1x", "nan"};
    for (size_t w = 0; w < sizeof wrong / sizeof wrong[0]; ++w) {
        bytes file = {.size = 0};
        put_text(&file, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 5\nencoding: text\n\n");
        for (int i = 0; i < BLOCK_COUNT; ++i) {
            put_text(&file, i == 7 ? wrong[w] : "9");
            put_text(&file, " ");
        }
        qn_volume *volume;
        qn_error error;
        assert_int_equal(read_all(&file, "x.nrrd", &volume, &error), QN_ERROR_INPUT);
        assert_non_null(strstr(error.message, "number 7"));
    }
}

/* Programs with a user interface set the locale; 0.5 must stay a half. */
static void numbers_do_not_depend_on_the_locale(void **state) {
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    for (int n = 0; n < 4 && !setlocale(LC_NUMERIC, names[n]); ++n) {
    }
    nrrd_space_directions_origin_and_units(state);
    setlocale(LC_NUMERIC, "C");
}

/* ---- MetaImage ---- */

static void metaimage_types_byte_orders_and_packing(void **state) {
    (void)state;
    static const struct {
        const char *name;
        qn_scalar scalar;
    } types[] = {{"MET_CHAR", QN_I8},    {"MET_UCHAR", QN_U8},  {"MET_SHORT", QN_I16},
                 {"MET_USHORT", QN_U16}, {"MET_INT", QN_I32},   {"MET_UINT", QN_U32},
                 {"MET_LONG", QN_I32},   {"MET_ULONG", QN_U32}, {"MET_FLOAT", QN_F32},
                 {"MET_DOUBLE", QN_F64}};
    for (size_t t = 0; t < sizeof types / sizeof types[0]; ++t)
        for (int way = 0; way < 8; ++way) {
            bytes file = {.size = 0}, block = {.size = 0}, packed = {.size = 0};
            bool big = way % 2, pack = way / 2 % 2;
            char text[512];
            put_block(&block, types[t].scalar, big);
            put_packed(&packed, block.data, block.size, 15);
            snprintf(
                text, sizeof text,
                "ObjectType = Image\r\nNDims = 3\nBinaryData = True\n%s = %s\n"
                "CompressedData = %s\nCompressedDataSize = %d\nDimSize = 4 3 5\nElementType = %s\n"
                "ElementDataFile = LOCAL\n",
                way / 4 ? "ElementByteOrderMSB" : "BinaryDataByteOrderMSB", big ? "True" : "False",
                pack ? "True" : "False", (int)packed.size, types[t].name);
            put_text(&file, text);
            put(&file, pack ? packed.data : block.data, (size_t)(pack ? packed.size : block.size));
            expect_block(&file, "x.mha", types[t].scalar);
        }
    bytes file = {.size = 0};
    put_text(&file, "NDims = 3\nBinaryData = False\nDimSize = 4 3 5\nElementType = MET_SHORT\n"
                    "ElementDataFile = LOCAL\n");
    put_text_block(&file, QN_I16, " ");
    expect_block(&file, "x.mha", QN_I16);
}

#define META_START "ObjectType = Image\nNDims = 3\nDimSize = 4 3 5\nElementType = MET_UCHAR\n"
#define META_LOCAL "ElementDataFile = LOCAL\n"

static void metaimage_matrices(void **state) {
    (void)state;
    static const char *const offsets[] = {"Offset", "Origin", "Position"};
    static const char *const matrices[] = {"TransformMatrix", "Rotation", "Orientation"};
    static const char *const spacings[] = {"ElementSpacing", "ElementSize", "ElementSpacing"};
    const double rows[3][4] = {{0, -3, 0, 1}, {2, 0, 0, 2}, {0, 0, 4, 3}};
    for (int n = 0; n < 3; ++n) {
        bytes file = {.size = 0};
        char text[512];
        snprintf(text, sizeof text,
                 META_START "%s = 1 2 3\n%s = 0 1 0 -1 0 0 0 0 1\n%s = 2 3 4\n"
                            "AnatomicalOrientation = RAI\nDistanceUnits = mm\n" META_LOCAL,
                 offsets[n], matrices[n], spacings[n]);
        put_text(&file, text);
        put_block(&file, QN_U8, false);
        qn_volume *volume;
        assert_int_equal(read_all(&file, "x.mha", &volume, NULL), QN_OK);
        assert_true(near_matrix(volume, rows, 0));
        assert_string_equal(qn_volume_grid(volume)->space, "LPS");
        assert_string_equal(qn_volume_grid(volume)->unit, "mm");
        qn_volume_destroy(volume);
    }
}

static void metaimage_data_in_a_file_of_its_own(void **state) {
    (void)state;
    char folder[] = "/tmp/quoin-meta-XXXXXX", header_path[256], data_path[256];
    assert_non_null(mkdtemp(folder));
    static const char *const lines[] = {"", "HeaderSize = 7\n", "HeaderSize = -1\n",
                                        "CompressedData = True\n"};
    for (int n = 0; n < 4; ++n) {
        bytes header = {.size = 0}, data = {.size = 0}, block = {.size = 0};
        put_text(&header, META_START);
        put_text(&header, lines[n]);
        put_text(&header, "ElementDataFile = a.raw");
        put_block(&block, QN_U8, false);
        if (n == 1 || n == 2)
            put_text(&data, "header!");
        if (n == 3)
            put_packed(&data, block.data, block.size, 15);
        else
            put(&data, block.data, (size_t)block.size);
        write_file(folder, "a.mhd", header.data, header.size, header_path);
        write_file(folder, "a.raw", data.data, data.size, data_path);
        qn_volume *volume;
        qn_error error = {.message = ""};
        if (qn_volume_read(context, header_path, NULL, &volume, &error) != QN_OK)
            fail_msg("%s", error.message);
        assert_true(holds_block(volume, QN_U8));
        qn_volume_destroy(volume);
    }
    unlink(data_path);
    unlink(header_path);
    rmdir(folder);
}

static void metaimage_refusals_say_why(void **state) {
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"ObjectType = Tube\n", "Tube"},
        {"ObjectType = Image\nNDims = 2\n", "2 dimensions"},
        {META_START "ElementNumberOfChannels = 3\n" META_LOCAL, "3 channels"},
        {META_START "ElementDataFile = LIST\na.raw\n", "several"},
        {META_START "ElementDataFile = a%02d.raw 1 5 1\n", "several"},
        {META_START "HeaderSize = -2\n" META_LOCAL, "HeaderSize"},
        {META_START "CompressedData = True\nCompressedDataSize = 99999999\n" META_LOCAL,
         "truncated"},
        {META_START "CompressedData = True\n" META_LOCAL, "damaged"},
        {META_START "ElementSpacing = 1 0 1\n" META_LOCAL, "no inverse"},
        {META_START "TransformMatrix = 1 2 3\n" META_LOCAL, "TransformMatrix"},
        {META_START "nonsense\n" META_LOCAL, "'='"},
        {"NDims = 3\nDimSize = 4 3 5\nElementType = MET_LONG_LONG\n" META_LOCAL, "MET_LONG_LONG"},
        {"NDims = 3\nElementType = MET_UCHAR\n" META_LOCAL, "DimSize"},
        {"NDims = 3\nDimSize = 4 3 5\n" META_LOCAL, "ElementType"},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c)
        expect_refusal(cases[c].text, "x.mha", cases[c].words);
}

/* ---- INRIMAGE ---- */

static void inrimage_types_and_byte_orders(void **state) {
    (void)state;
    for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar)
        for (int big = 0; big < 2; ++big) {
            bytes file = {.size = 0};
            char text[256];
            snprintf(
                text, sizeof text,
                "#INRIMAGE-4#{\nXDIM=4\nYDIM=3\nZDIM=5\nVDIM=1\nTYPE=%s\nPIXSIZE=%d bits\nCPU=%s\n"
                "VX=0.5\nVY=2\nVZ=3\nTX=7\n",
                scalar >= QN_F32                              ? "float"
                : qn_scalar_name((qn_scalar)scalar)[0] == 'i' ? "signed fixed"
                                                              : "unsigned fixed",
                (int)qn_scalar_size((qn_scalar)scalar) * 8, big ? "sun" : "decm");
            put_text(&file, text);
            while (file.size < 252)
                put_text(&file, "\n");
            put_text(&file, "##}\n");
            put_block(&file, (qn_scalar)scalar, big);
            qn_volume *volume;
            const double rows[3][4] = {{0.5, 0, 0, 7}, {0, 2, 0, 0}, {0, 0, 3, 0}};
            assert_int_equal(read_all(&file, "x.inr", &volume, NULL), QN_OK);
            assert_true(holds_block(volume, (qn_scalar)scalar));
            assert_true(near_matrix(volume, rows, 0));
            qn_volume_destroy(volume);
        }
    expect_refusal("#INRIMAGE-4#{\nXDIM=4\nYDIM=3\nZDIM=5\nVDIM=3\n##}\n", "x.inr", "VDIM");
    expect_refusal("#INRIMAGE-4#{\nXDIM=four\n##}\n", "x.inr", "XDIM");
    expect_refusal("#INRIMAGE-4#{\nXDIM=4\n", "x.inr", "##}");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nrrd_types_by_all_their_names),
        cmocka_unit_test(nrrd_space_directions_origin_and_units),
        cmocka_unit_test(nrrd_skips_lines_and_bytes),
        cmocka_unit_test(nrrd_data_in_a_file_of_its_own),
        cmocka_unit_test(nrrd_refusals_say_why),
        cmocka_unit_test(text_samples_must_be_numbers_of_the_type),
        cmocka_unit_test(numbers_do_not_depend_on_the_locale),
        cmocka_unit_test(metaimage_types_byte_orders_and_packing),
        cmocka_unit_test(metaimage_matrices),
        cmocka_unit_test(metaimage_data_in_a_file_of_its_own),
        cmocka_unit_test(metaimage_refusals_say_why),
        cmocka_unit_test(inrimage_types_and_byte_orders),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
