// SPDX-License-Identifier: MIT
/* Mesh files: what is written reads back to the same bits, and so does what others write. */
#include "unit/mesh_files.h"

static void assert_same_triangles(const qn_mesh *expected, const qn_mesh *mesh) {
    qn_mesh_view a = qn_mesh_get_view(expected), b = qn_mesh_get_view(mesh);
    assert_int_equal(b.quad_count, 0);
    assert_int_equal(a.triangle_count, b.triangle_count);
    for (int64_t i = 0; i < 3 * a.triangle_count; ++i)
        for (int c = 0; c < 3; ++c) /* 0 and -0 are one place to an STL file's reader */
            assert_true(a.positions[3 * a.triangles[i] + c] == b.positions[3 * b.triangles[i] + c]);
}

static void each_format_reads_back_the_same_bits(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, VERTICES, QUADS, TRIANGLES);
    qn_mesh *split = make_mesh(context, VERTICES, QUADS, TRIANGLES);
    assert_int_equal(qn_mesh_triangulate(context, split, NULL), QN_OK);
    qn_mesh_view a = qn_mesh_get_view(mesh);
    for (int f = 0; f < FORMS; ++f) {
        write_form(context, mesh, forms + f);
        qn_mesh *again = read_form(context, forms[f].name);
        qn_mesh_view b = qn_mesh_get_view(again);
        if (forms[f].shares) {
            assert_int_equal(a.vertex_count, b.vertex_count);
            assert_int_equal(a.quad_count, b.quad_count);
            assert_int_equal(a.triangle_count, b.triangle_count);
            assert_memory_equal(a.positions, b.positions, sizeof(float[VERTICES][3]));
            assert_memory_equal(a.quads, b.quads, sizeof(uint32_t[QUADS][4]));
            assert_memory_equal(a.triangles, b.triangles, sizeof(uint32_t[TRIANGLES][3]));
        } else {
            assert_same_triangles(split, again);
        }
        assert_int_equal(b.normals != NULL, forms[f].normals);
        if (b.normals)
            assert_memory_equal(a.normals, b.normals, sizeof(float[VERTICES][3]));
        if (f < 2) {
            assert_string_equal(b.space, "RAS");
            assert_string_equal(b.unit, "mm");
        }
        qn_mesh_destroy(again);
    }
    assert_int_equal(test_scratch_count(&scratch), FORMS);
    qn_mesh_destroy(split);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void writing_twice_gives_the_same_bytes(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, VERTICES, QUADS, TRIANGLES);
    for (int f = 0; f < FORMS; ++f) {
        size_t first_size, second_size;
        write_form(context, mesh, forms + f);
        char *first = test_get_file(test_scratch_path(&scratch, forms[f].name), &first_size);
        write_form(context, mesh, forms + f);
        char *second = test_get_file(test_scratch_path(&scratch, forms[f].name), &second_size);
        assert_int_equal(first_size, second_size);
        assert_memory_equal(first, second, first_size);
        free(first);
        free(second);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void normals_are_left_out_on_request(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, 20, 5, 5);
    qn_mesh_write_options options;
    qn_mesh_write_options_init(&options);
    options.skip_normals = true;
    strcpy(options.format, "OFF");
    const char *path = test_scratch_path(&scratch, "m.data");
    assert_int_equal(qn_mesh_write(context, mesh, path, &options, NULL), QN_OK);
    qn_mesh *again = read_form(context, "m.data"); /* known by its first bytes */
    assert_null(qn_mesh_get_view(again).normals);
    assert_int_equal(qn_mesh_get_view(again).vertex_count, 20);
    qn_mesh_destroy(again);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void an_empty_mesh_is_written_and_read(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh_view view = {0};
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    for (int f = 0; f < FORMS; ++f) {
        write_form(context, mesh, forms + f);
        qn_mesh *again = read_form(context, forms[f].name);
        assert_int_equal(qn_mesh_get_view(again).vertex_count, 0);
        assert_int_equal(qn_mesh_get_view(again).triangle_count, 0);
        qn_mesh_destroy(again);
    }
    assert_int_equal(qn_mesh_write(context, mesh, test_scratch_path(&scratch, "m.glb"), NULL, NULL),
                     QN_OK);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static uint32_t word_at(const char *bytes, size_t at) {
    const unsigned char *b = (const unsigned char *)bytes + at;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* The n-th number behind a key of the JSON chunk. */
static double number_behind(const char *json, const char *key, int n) {
    const char *at = json;
    for (int i = 0; i <= n; ++i) {
        at = strstr(at, key);
        assert_non_null(at);
        at += strlen(key);
    }
    return strtod(at, NULL);
}

static void glb_holds_the_mesh_in_triangles(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, VERTICES, QUADS, TRIANGLES);
    const char *path = test_scratch_path(&scratch, "m.glb");
    assert_int_equal(qn_mesh_write(context, mesh, path, NULL, NULL), QN_OK);
    assert_int_equal(qn_mesh_triangulate(context, mesh, NULL), QN_OK);
    qn_mesh_view view = qn_mesh_get_view(mesh);
    size_t size;
    char *bytes = test_get_file(path, &size);
    assert_memory_equal(bytes, "glTF", 4);
    assert_int_equal(word_at(bytes, 4), 2);
    assert_int_equal(word_at(bytes, 8), size);
    uint32_t json_size = word_at(bytes, 12);
    assert_memory_equal(bytes + 16, "JSON", 4);
    assert_int_equal(json_size % 4, 0);
    size_t bin = 20 + json_size;
    assert_memory_equal(bytes + bin + 4, "BIN", 4);
    assert_int_equal(bin + 8 + word_at(bytes, bin), size);
    bytes[bin - 1] = 0; /* a blank or the last brace: enough for looking things up */
    const char *json = bytes + 20;
    assert_non_null(strstr(json, "\"generator\":\"quoin"));
    assert_non_null(strstr(json, "\"extras\":{\"space\":\"RAS\",\"unit\":\"mm\"}"));
    assert_true(number_behind(json, "\"count\":", 0) == VERTICES);
    assert_true(number_behind(json, "\"count\":", 1) == VERTICES);
    assert_true(number_behind(json, "\"count\":", 2) == 3 * (2 * QUADS + TRIANGLES));
    float low = view.positions[0];
    for (int i = 1; i < VERTICES; ++i)
        low = fminf(low, view.positions[3 * i]);
    assert_true((float)number_behind(json, "\"min\":[", 0) == low);
    const char *data = bytes + bin + 8;
    size_t vector_bytes = VERTICES * 12;
    assert_memory_equal(data, view.positions, vector_bytes);
    assert_memory_equal(data + vector_bytes, view.normals, vector_bytes);
    assert_memory_equal(data + 2 * vector_bytes, view.triangles, 12 * (2 * QUADS + TRIANGLES));
    free(bytes);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void unknown_formats_are_named(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, 4, 1, 0);
    qn_error error;
    assert_int_equal(qn_mesh_write(context, mesh, "mesh.fbx", NULL, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, ".ply, .obj, .stl, .off or .glb"));
    qn_mesh_write_options options;
    qn_mesh_write_options_init(&options);
    strcpy(options.format, "fbx");
    assert_int_equal(qn_mesh_write(context, mesh, "m.ply", &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options.struct_size = 0;
    assert_int_equal(qn_mesh_write(context, mesh, "m.ply", &options, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_mesh_destroy(mesh);
    assert_int_equal(qn_mesh_read(context, "m.ply", "fbx", &mesh, &error), QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "check the name"));
    assert_null(mesh);
    test_context_end(context);
}

/* ---- reading what others write ----------------------------------------------------------------
 */

static void assert_text_reads(const char *name, const char *text, int64_t vertices, int64_t quads,
                              int64_t triangles) {
    qn_context *context = test_context(1);
    qn_mesh *mesh = read_bytes(context, name, text, strlen(text));
    assert_counts(mesh, vertices, quads, triangles);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void others_text_is_read(void **state) {
    (void)state;
    assert_text_reads("a.obj",
                      "# c\r\nmtllib x\r\nv 0 0 0 1 0 0\r\nv 1 0 0\r\nv 1 1 0 # c\r\nv 0 1 0\r\n"
                      "vt 0 0\nvn 0 0 1\no x\ng\ns off\nusemtl y\n"
                      "f 1/1/1 2/1/1 3/1/1\nf -4 -3 -2 -1\nf 1//1 2//1 \\\n3//1\nl 1 2\nf 1 2\n",
                      4, 1, 2);
    assert_text_reads("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv .5 2 0\nv 0 1 0\nf 1 2 3 4 5\n", 5, 0,
                      3);
    assert_text_reads("a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 1 1 0", 3, 0, 1);
    assert_text_reads(
        "a.off",
        "OFF 4 2 0\n0 0 0\n1 0 0\n\n# c\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n4 0 1 2 3 0.5 0.5 0.5\n", 4,
        1, 1);
    assert_text_reads(
        "a.off", "# c\nCOFF\n# c\n3 1\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n1 1 0 0 0 0 1\n3 0 1 2", 3,
        0, 1);
    assert_text_reads("a.off", "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n3 0 1 2\n", 3,
                      0, 1);
    assert_text_reads(
        "a.ply",
        "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 1\r\nproperty float f\r\n"
        "property list uchar int l\r\nelement vertex 3\r\nproperty uchar red\r\n"
        "property double z\r\nproperty float x\r\nproperty float32 y\r\n"
        "element face 1\r\nproperty int flag\r\nproperty list int uint vertex_index\r\n"
        "end_header\r\n1.5 2 7 8\r\n255 0 0 0\r\n1 0 1 0\r\n2 0 1 1\r\n5 3 0 1 2\r\n",
        3, 0, 1);
    assert_text_reads("a.stl",
                      "solid x y\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                      "VERTEX 1 1 0\nendloop\nendfacet\nendsolid x y\n"
                      "solid\n facet normal 0 0 1\n  outer loop\n vertex 0 0 -0\n vertex 1 1 0\n"
                      " vertex 0 1e0 0\n endloop\n endfacet\nendsolid\n",
                      4, 0, 2);
}

static size_t put_big(unsigned char *to, uint64_t value, size_t size) {
    for (size_t b = 0; b < size; ++b)
        to[b] = (unsigned char)(value >> (8 * (size - 1 - b)));
    return size;
}

static void big_endian_ply_is_read(void **state) {
    (void)state;
    unsigned char bytes[600];
    size_t at = (size_t)sprintf(
        (char *)bytes, "ply\nformat binary_big_endian 1.0\nelement vertex 3\n"
                       "property short y\nproperty double x\nproperty uchar z\n"
                       "element face 1\nproperty list ushort short vertex_indices\nend_header\n");
    for (uint64_t v = 0; v < 3; ++v) {
        double x = 0.25 + (double)v;
        uint64_t bits;
        memcpy(&bits, &x, 8);
        at += put_big(bytes + at, 0xfffe + v, 2); /* -2, -1, 0 */
        at += put_big(bytes + at, bits, 8);
        at += put_big(bytes + at, 200 + v, 1);
    }
    at += put_big(bytes + at, 3, 2);
    for (uint64_t v = 0; v < 3; ++v)
        at += put_big(bytes + at, 2 - v, 2);
    qn_context *context = test_context(1);
    qn_mesh *mesh = read_bytes(context, "big.ply", bytes, at);
    assert_counts(mesh, 3, 0, 1);
    qn_mesh_view view = qn_mesh_get_view(mesh);
    static const float expected[9] = {0.25f, -2, 200, 1.25f, -1, 201, 2.25f, 0, 202};
    assert_memory_equal(view.positions, expected, sizeof expected);
    assert_int_equal(view.triangles[0], 2);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void binary_stl_that_begins_with_solid_is_read(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, 30, 0, 10);
    write_form(context, mesh, forms + 4);
    qn_mesh_destroy(mesh);
    size_t size;
    char *bytes = test_get_file(test_scratch_path(&scratch, "m.stl"), &size);
    assert_memory_not_equal(bytes, "solid", 5);
    memset(bytes, ' ', 80);
    memcpy(bytes, "solid facet", 11);
    mesh = read_bytes(context, "s.stl", bytes, size);
    assert_counts(mesh, 30, 0, 10);
    qn_mesh_destroy(mesh);
    free(bytes);
    test_context_end(context);
}

static void packed_files_are_read(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, VERTICES, QUADS, TRIANGLES);
    for (int f = 0; f < FORMS; ++f) {
        size_t size;
        char name[32];
        write_form(context, mesh, forms + f);
        char *bytes = test_get_file(test_scratch_path(&scratch, forms[f].name), &size);
        snprintf(name, sizeof name, "%s.gz", forms[f].name);
        put_packed(test_scratch_path(&scratch, name), bytes, size);
        qn_mesh *plain = read_form(context, forms[f].name), *packed = read_form(context, name);
        assert_int_equal(test_hash_mesh(plain), test_hash_mesh(packed));
        qn_mesh_destroy(plain);
        qn_mesh_destroy(packed);
        free(bytes);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        FILE_TEST(each_format_reads_back_the_same_bits),
        FILE_TEST(writing_twice_gives_the_same_bytes),
        FILE_TEST(normals_are_left_out_on_request),
        FILE_TEST(an_empty_mesh_is_written_and_read),
        FILE_TEST(glb_holds_the_mesh_in_triangles),
        FILE_TEST(unknown_formats_are_named),
        FILE_TEST(others_text_is_read),
        FILE_TEST(big_endian_ply_is_read),
        FILE_TEST(binary_stl_that_begins_with_solid_is_read),
        FILE_TEST(packed_files_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
