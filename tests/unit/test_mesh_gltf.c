// SPDX-License-Identifier: MIT
/* glTF as text: data as base64 or in files beside it, whole-number positions, and refusals: files
 * elsewhere, extensions that are needed, buffers that are too short. */
#include "lib/scratch.h"
#include "lib/support.h"

#include <math.h>
#include <sys/stat.h>

static test_scratch scratch;

static int make_scratch(void **state) {
    (void)state;
    test_scratch_make(&scratch);
    return 0;
}

static int remove_scratch(void **state) {
    (void)state;
    test_scratch_remove(&scratch);
    return 0;
}

enum { DATA_BYTES = 60 };

/* The corners of a tetrahedron as floats, then the indices of its four triangles as bytes. */
static void make_data(char data[DATA_BYTES]) {
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const char indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    for (int n = 0; n < 12; ++n) {
        uint32_t bits;
        memcpy(&bits, corners + n, 4);
        for (int b = 0; b < 4; ++b)
            data[4 * n + b] = (char)(bits >> (8 * b) & 255);
    }
    memcpy(data + 48, indices, 12);
}

/* base64 of bytes whose count is a multiple of three. */
static void encode(const char *bytes, int count, char *text) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int n = 0; n < count; n += 3) {
        const unsigned char *b = (const unsigned char *)bytes + n;
        const unsigned bits = (unsigned)b[0] << 16 | (unsigned)b[1] << 8 | b[2];
        for (int d = 0; d < 4; ++d)
            *text++ = digits[bits >> (18 - 6 * d) & 63];
    }
    *text = '\0';
}

/* A .gltf file whose buffer has this URI. */
static const char *put_gltf(const char *uri, const char *more) {
    char text[4096];
    snprintf(
        text, sizeof text,
        "\n{\"asset\":{\"version\":\"2.0\"},%s\"buffers\":[{\"byteLength\":60,\"uri\":\"%s\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]}",
        more, uri);
    const char *path = test_scratch_path(&scratch, "a.gltf");
    test_put_file(path, text, strlen(text));
    return path;
}

static void assert_tetrahedron(qn_context *context, const char *path, const char *format) {
    qn_mesh *mesh;
    qn_error error;
    qn_mesh_report report;
    if (qn_mesh_read(context, path, format, &mesh, &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_int_equal(qn_mesh_get_view(mesh).triangle_count, 4);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_int_equal(report.boundary_edges, 0);
    assert_true(fabs(report.volume - 1 / 6.0) < 1e-7);
    qn_mesh_destroy(mesh);
}

static void data_within_and_beside_the_text_is_read(void **state) {
    (void)state;
    char data[DATA_BYTES], uri[200] = "data:application/octet-stream;base64,";
    make_data(data);
    encode(data, DATA_BYTES, uri + strlen(uri));
    qn_context *context = test_context(1);
    assert_tetrahedron(context, put_gltf(uri, ""), NULL);
    test_put_file(test_scratch_path(&scratch, "a b.bin"), data, DATA_BYTES);
    assert_tetrahedron(context, put_gltf("a%20b.bin", ""), NULL);
    assert_tetrahedron(context, put_gltf("./a b.bin", ""), "gltf");
    char folder[300];
    snprintf(folder, sizeof folder, "%s", test_scratch_path(&scratch, "below"));
    assert_int_equal(mkdir(folder, 0700), 0);
    test_put_file(test_scratch_path(&scratch, "below/c.bin"), data, DATA_BYTES);
    assert_tetrahedron(context,
                       put_gltf("below/c.bin", "\"extensionsRequired\":[\"KHR_materials_unlit\"],"),
                       NULL);
    /* its first bytes tell as well as its name */
    char moved[300];
    snprintf(moved, sizeof moved, "%s", test_scratch_path(&scratch, "model"));
    assert_int_equal(rename(put_gltf(uri, ""), moved), 0);
    char text[8] = "";
    FILE *file = fopen(moved, "rb");
    assert_int_equal(fread(text, 1, 2, file), 2);
    fclose(file);
    assert_tetrahedron(context, moved, "GLTF");
    remove(test_scratch_path(&scratch, "below/c.bin"));
    remove(folder);
    test_context_end(context);
}

/* KHR_mesh_quantization: corners as signed 16-bit numbers, four bytes of padding each. */
static void quantized_positions_are_read(void **state) {
    (void)state;
    static const int numbers[4][3] = {{0, 0, 0}, {32767, 0, 0}, {0, -32768, 0}, {0, 0, 32767}};
    for (int normalized = 0; normalized < 2; ++normalized) {
        char data[33] = "", uri[200] = "data:;base64,", text[2048];
        for (int n = 0; n < 12; ++n) {
            data[8 * (n / 3) + 2 * (n % 3)] = (char)(numbers[n / 3][n % 3] & 255);
            data[8 * (n / 3) + 2 * (n % 3) + 1] = (char)(numbers[n / 3][n % 3] >> 8 & 255);
        }
        encode(data, 33, uri + strlen(uri));
        snprintf(text, sizeof text,
                 "{\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
                 "\"buffers\":[{\"byteLength\":32,\"uri\":\"%s\"}],"
                 "\"bufferViews\":[{\"buffer\":0,\"byteLength\":32,\"byteStride\":8}],"
                 "\"accessors\":[{\"bufferView\":0,\"componentType\":5122,\"count\":4,%s"
                 "\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":["
                 "{\"attributes\":{\"POSITION\":0},\"mode\":5}]}]}",
                 uri, normalized ? "\"normalized\":true," : "");
        const char *path = test_scratch_path(&scratch, "q.gltf");
        test_put_file(path, text, strlen(text));
        qn_context *context = test_context(1);
        qn_mesh *mesh;
        qn_error error;
        if (qn_mesh_read(context, path, NULL, &mesh, &error) != QN_OK)
            fail_msg("%s", error.message);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        assert_int_equal(view.vertex_count, 4);
        const float one = normalized ? 1 : 32767, least = normalized ? -1 : -32768;
        const float expected[4][3] = {{0, 0, 0}, {one, 0, 0}, {0, least, 0}, {0, 0, one}};
        assert_memory_equal(view.positions, expected, sizeof expected);
        qn_mesh_destroy(mesh);
        test_context_end(context);
    }
}

static void what_cannot_be_read_is_refused_with_the_reason(void **state) {
    (void)state;
    static const struct {
        const char *uri, *more, *words;
    } cases[] = {
        {"missing.bin", "", "missing.bin': No such file"},
        {"../a.bin", "", "outside the folder"},
        {"%2e%2e/a.bin", "", "outside the folder"},
        {"b/../../a.bin", "", "outside the folder"},
        {"/dev/zero", "", "outside the folder"},
        {"file:///dev/zero", "", "outside the folder"},
        {"https://example.com/a.bin", "", "outside the folder"},
        {"", "", "too long or empty"},
        {"%00", "", "too long or empty"},
        {"data:text/plain,hello", "", "not base64"},
        {"data:;base64,AB!C", "", "not base64"},
        {"data:;base64,AB=C", "", "not base64"},
        {"data:;base64,AAAA", "", "shorter than"},
        {".", "", "no file"},
        {"short.bin", "", "shorter than"},
        {"short.bin", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],",
         "KHR_draco_mesh_compression"},
    };
    test_put_file(test_scratch_path(&scratch, "short.bin"), "12345", 5);
    qn_context *context = test_context(1);
    const int64_t held = qn_context_memory(context).current_bytes;
    for (size_t n = 0; n < sizeof cases / sizeof *cases; ++n) {
        qn_mesh *mesh;
        qn_error error;
        assert_int_equal(
            qn_mesh_read(context, put_gltf(cases[n].uri, cases[n].more), NULL, &mesh, &error),
            QN_ERROR_INPUT);
        if (!strstr(error.message, cases[n].words))
            fail_msg("case %zu: '%s' does not say '%s'", n, error.message, cases[n].words);
        assert_null(mesh);
        assert_int_equal(qn_context_memory(context).current_bytes, held);
    }
    test_context_end(context);
}

/* A mesh is not written as text: the sentence names what can be. */
static void texts_are_not_written(void **state) {
    (void)state;
    char data[DATA_BYTES], uri[200] = "data:;base64,";
    make_data(data);
    encode(data, DATA_BYTES, uri + strlen(uri));
    qn_context *context = test_context(1);
    qn_mesh *mesh;
    qn_error error;
    assert_int_equal(qn_mesh_read(context, put_gltf(uri, ""), NULL, &mesh, NULL), QN_OK);
    assert_int_equal(
        qn_mesh_write(context, mesh, test_scratch_path(&scratch, "b.gltf"), NULL, &error),
        QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, ".glb"));
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

int main(void) {
#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, make_scratch, remove_scratch)
    const struct CMUnitTest tests[] = {
        FILE_TEST(data_within_and_beside_the_text_is_read),
        FILE_TEST(quantized_positions_are_read),
        FILE_TEST(what_cannot_be_read_is_refused_with_the_reason),
        FILE_TEST(texts_are_not_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
