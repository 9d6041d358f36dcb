// SPDX-License-Identifier: MIT
/* Mesh files: what is written reads back to the same bits; what is damaged is refused in one
 * sentence. */
#include "lib/failing.h"
#include "lib/scratch.h"
#include "lib/support.h"

#include <math.h>
#include <zlib.h>

enum { VERTICES = 200, QUADS = 150, TRIANGLES = 70 };

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

typedef struct arrays {
    float positions[VERTICES][3], normals[VERTICES][3];
    uint32_t quads[QUADS][4], triangles[TRIANGLES][3];
} arrays;

/* Coordinates of all sizes, no two vertices at the same place. */
static qn_mesh_view random_view(arrays *a, int64_t vertices, int64_t quads, int64_t triangles) {
    test_random random = {test_seed()};
    static const float odd[] = {-0.0f, 1e-45f, 3.4e38f, -1.17549435e-38f, 16777216, 0.1f, 1e-7f};
    for (int64_t i = 0; i < vertices; ++i)
        for (int c = 0; c < 3; ++c) {
            double value =
                ldexp(test_random_gaussian(&random), (int)test_random_range(&random, -30, 30));
            a->positions[i][c] = i < 7 && c == 1 ? odd[i] : (float)value;
            a->normals[i][c] = (float)(2 * test_random_unit(&random) - 1);
        }
    for (int64_t i = 0; i < quads; ++i)
        for (uint32_t c = 0; c < 4; ++c)
            a->quads[i][c] = (uint32_t)((i + c * (1 + i % 7)) % vertices);
    for (int64_t i = 0; i < triangles; ++i)
        for (uint32_t c = 0; c < 3; ++c)
            a->triangles[i][c] = (uint32_t)((3 * i + c) % vertices);
    return (qn_mesh_view){vertices,
                          quads,
                          triangles,
                          &a->positions[0][0],
                          &a->normals[0][0],
                          &a->quads[0][0],
                          &a->triangles[0][0],
                          "RAS",
                          "mm",
                          NULL,
                          0,
                          NULL,
                          NULL};
}

static qn_mesh *make_mesh(qn_context *context, int64_t vertices, int64_t quads, int64_t triangles) {
    static arrays a;
    qn_mesh_view view = random_view(&a, vertices, quads, triangles);
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    return mesh;
}

typedef struct form {
    const char *name;            /* of the file */
    bool ascii, normals, shares; /* shares: vertices keep their numbers */
} form;

static const form forms[] = {
    {"m.ply", false, true, true},   {"text.PLY", true, true, true},
    {"m.obj", false, false, true},  {"m.Off", false, true, true},
    {"m.stl", false, false, false}, {"text.stl", true, false, false},
    {"m.glb", false, false, false},
};
enum { FORMS = sizeof forms / sizeof *forms };

static void write_form(qn_context *context, const qn_mesh *mesh, const form *f) {
    qn_mesh_write_options options;
    qn_mesh_write_options_init(&options);
    options.ascii = f->ascii;
    qn_error error;
    if (qn_mesh_write(context, mesh, test_scratch_path(&scratch, f->name), &options, &error) !=
        QN_OK)
        fail_msg("%s", error.message);
}

static qn_mesh *read_form(qn_context *context, const char *name) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_mesh_read(context, test_scratch_path(&scratch, name), NULL, &mesh, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

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

static qn_mesh *read_bytes(qn_context *context, const char *name, const void *bytes, size_t size) {
    test_put_file(test_scratch_path(&scratch, name), bytes, size);
    return read_form(context, name);
}

static void assert_counts(const qn_mesh *mesh, int64_t vertices, int64_t quads, int64_t triangles) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    assert_int_equal(view.vertex_count, vertices);
    assert_int_equal(view.quad_count, quads);
    assert_int_equal(view.triangle_count, triangles);
}

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

static void put_packed(const char *path, const void *bytes, size_t size) {
    gzFile file = gzopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(gzwrite(file, bytes, (unsigned)size), size);
    assert_int_equal(gzclose(file), Z_OK);
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

/* ---- what is damaged --------------------------------------------------------------------------
 */

static void assert_refused(const char *name, const void *bytes, size_t size, const char *words) {
    qn_context *context = test_context(1);
    const char *path = test_scratch_path(&scratch, name);
    test_put_file(path, bytes, size);
    qn_mesh *mesh;
    qn_error error = {0};
    qn_status status = qn_mesh_read(context, path, NULL, &mesh, &error);
    if (status != QN_ERROR_INPUT || !strstr(error.message, words) || !strstr(error.message, path))
        fail_msg("%s: status %d, '%s' does not say '%s'", name, (int)status, error.message, words);
    assert_null(mesh);
    test_context_end(context);
}

static void damaged_text_is_refused(void **state) {
    (void)state;
    static const struct {
        const char *name, *text, *words;
    } cases[] = {
        {"a.obj", "v 0 0\n", "line 1: a vertex needs three numbers"},
        {"a.obj", "v 0 0 x\n", "line 1"},
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4 names vertex 3"},
        {"a.obj", "v 0 0 0\nf 0 1 1\n", "line 2: a face names vertex 0"},
        {"a.obj", "v 0 0 0\nf 1 1 -2\n", "line 2"},
        {"a.obj", "v 0 0 0\nf 1 1 99999999999999999999\n", "line 2"},
        {"a.obj", "what is this\n", "no vertices"},
        {"a.off", "", "empty"},
        {"a.off", "OFX\n1 1 0\n", "begins with 'OFF'"},
        {"a.off", "OFF\n-1 1 0\n", "line 2"},
        {"a.off", "OFF\n4000000000 1 0\n0 0 0\n", "4000000000 vertices"},
        {"a.off", "OFF\n1 9223372036854775807 0\n0 0 0\n", "line"},
        {"a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4: a face names vertex 1"},
        {"a.off", "OFF\n1 1 0\n0 0 0\n4000000000 0 0 1\n", "corners"},
        {"a.off", "OFF\n2 1 0\n0 0 0 0 0 0 0 0\n# nothing more\n", "cut short"},
        {"a.off", "OFF BINARY\n", "binary"},
        {"a.ply", "plx\n", "begins with 'ply'"},
        {"a.ply", "ply\nformat ascii 1.0\n", "does not end"},
        {"a.ply", "ply\nelement vertex 0\nend_header\n", "no format"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
         "no x, y and z"},
        {"a.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n", "line 3"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "line 3"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 9223372036854775807\nend_header\n",
         "line 3"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n1 2 3\n",
         "4000000000 vertices"},
        {"a.ply",
         "ply\nformat binary_little_endian 1.0\nelement face 1\n"
         "property list uint uint vertex_indices\nend_header\n\xff\xff\xff\xff....",
         "longer than"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n3 0 0 -1\n",
         "whole number"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n3 0 0 7\n",
         "face 1 names vertex 7"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\nend_header\n",
         "line 4"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n",
         "line 4"},
        {"a.stl", "solid\nvertex 0 0 0\n", "endsolid"},
        {"a.stl", "solid\nfacet normal 0 0 1\nouter loop\nendloop\n", "line 4"},
        {"a.stl", "solid\nnonsense\n", "'nonsense'"},
        {"a.stl", "short", "binary STL"},
        {"a.glb", "glTF....", "no GLB file of version 2"},
        {"a.glb", "glTF\2...", "no GLB file of version 2"},
        {"a.xyz", "1 2 3\n", "give the format"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_refused(cases[i].name, cases[i].text, strlen(cases[i].text), cases[i].words);
    char stl[84 + 50] = "absurd";
    memset(stl + 80, 0xff, 4);
    assert_refused("a.stl", stl, sizeof stl, "4294967295 triangles");
}

/* A binary file knows its length: no cut goes unseen. A text may end in a shorter number. */
static void every_cut_is_survived(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, 12, 5, 4);
    for (int f = 0; f < FORMS; ++f) {
        write_form(context, mesh, forms + f);
        size_t size;
        char *bytes = test_get_file(test_scratch_path(&scratch, forms[f].name), &size);
        bool sure = f == 0 || f >= 4;
        int refused = 0;
        for (size_t cut = 0; cut < size; ++cut) {
            char name[32];
            snprintf(name, sizeof name, "cut.%.3s", strchr(forms[f].name, '.') + 1);
            const char *path = test_scratch_path(&scratch, name);
            test_put_file(path, bytes, cut);
            qn_mesh *part;
            qn_error error = {0};
            int64_t held = qn_context_memory(context).current_bytes;
            qn_status status = qn_mesh_read(context, path, NULL, &part, &error);
            refused += status != QN_OK;
            if (status != QN_OK) {
                assert_int_equal(status, QN_ERROR_INPUT);
                assert_non_null(strstr(error.message, "cannot read"));
                assert_null(part);
            } else if (sure && cut + 10 < size) { /* "endsolid" may go without what follows */
                fail_msg("%s cut to %zu of %zu bytes was read", forms[f].name, cut, size);
            }
            qn_mesh_destroy(part);
            assert_int_equal(qn_context_memory(context).current_bytes, held);
        }
        assert_true(refused > 0);
        free(bytes);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void every_cut_of_a_packed_file_is_refused(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, 12, 5, 4);
    write_form(context, mesh, forms);
    qn_mesh_destroy(mesh);
    size_t size;
    char *bytes = test_get_file(test_scratch_path(&scratch, "m.ply"), &size);
    put_packed(test_scratch_path(&scratch, "m.ply.gz"), bytes, size);
    free(bytes);
    bytes = test_get_file(test_scratch_path(&scratch, "m.ply.gz"), &size);
    for (size_t cut = 0; cut < size; ++cut)
        assert_refused("cut.ply.gz", bytes, cut, "cannot read");
    for (size_t at = 12; at < size; at += 7) {
        bytes[at] = (char)~bytes[at];
        assert_refused("bad.ply.gz", bytes, size, "cannot read");
        bytes[at] = (char)~bytes[at];
    }
    free(bytes);
    test_context_end(context);
}

static void not_finite_coordinates_are_read(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    const char text[] = "v nan 0 0\nv inf 0 -inf\nv 0 0 0\nf 1 2 3\n";
    qn_mesh *mesh = read_bytes(context, "a.obj", text, sizeof text - 1);
    assert_true(isnan(qn_mesh_get_view(mesh).positions[0]));
    assert_true(isinf(qn_mesh_get_view(mesh).positions[3]));
    for (int f = 0; f < FORMS; ++f) {
        write_form(context, mesh, forms + f);
        qn_mesh *again = read_form(context, forms[f].name);
        assert_counts(again, 3, 0, 1);
        qn_mesh_destroy(again);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

/* ---- memory and cancelling --------------------------------------------------------------------
 */

static void every_failing_allocation_is_reported(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = make_mesh(context, VERTICES, QUADS, TRIANGLES);
    const char polygon[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv .5 2 0\nv 0 1 0\nf 1 2 3 4 5\n";
    for (int f = 0; f <= FORMS; ++f) {
        const char *name = f < FORMS ? forms[f].name : "polygon.obj";
        if (f < FORMS)
            write_form(context, mesh, forms + f);
        else
            test_put_file(test_scratch_path(&scratch, name), polygon, sizeof polygon - 1);
        int64_t failures = 0;
        for (bool done = false; !done; ++failures) {
            test_failing failing = {failures, -1, 0};
            qn_context *poor = test_failing_context(&failing);
            qn_mesh *again = NULL;
            qn_error error = {0};
            qn_status status =
                poor ? qn_mesh_read(poor, test_scratch_path(&scratch, name), NULL, &again, &error)
                     : QN_ERROR_OUT_OF_MEMORY;
            done = status == QN_OK;
            if (!done) {
                assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
                assert_null(again);
            }
            qn_mesh_destroy(again);
            qn_context_destroy(poor);
            assert_int_equal(failing.held, 0);
        }
        assert_true(failures > 4);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void writing_without_memory_leaves_nothing(void **state) {
    (void)state;
    for (int64_t n = 0, done = 0; !done; ++n) {
        test_failing failing = {n, -1, 0};
        qn_context *poor = test_failing_context(&failing);
        if (!poor)
            continue;
        static arrays a;
        qn_mesh_view view = random_view(&a, 10, 3, 3);
        qn_mesh *mesh;
        const char *path = test_scratch_path(&scratch, "m.ply");
        if (qn_mesh_create(poor, &view, &mesh, NULL) == QN_OK) {
            qn_status status = qn_mesh_write(poor, mesh, path, NULL, NULL);
            done = status == QN_OK;
            assert_int_equal(status, done ? QN_OK : QN_ERROR_OUT_OF_MEMORY);
            assert_int_equal(test_scratch_count(&scratch), done ? 1 : 0);
            qn_mesh_destroy(mesh);
        }
        qn_context_destroy(poor);
        assert_int_equal(failing.held, 0);
    }
}

static void cancelling_leaves_nothing(void **state) {
    (void)state;
    for (int64_t n = 0, done = 0; !done; ++n) {
        test_failing failing = {-1, -1, 0};
        qn_context *context = test_failing_context(&failing);
        qn_mesh *mesh = make_mesh(context, VERTICES, QUADS, TRIANGLES), *again;
        const char *path = test_scratch_path(&scratch, "m.obj");
        failing.looks_left = n;
        qn_status status = qn_mesh_write(context, mesh, path, NULL, NULL);
        if (status == QN_OK)
            status = qn_mesh_read(context, path, NULL, &again, NULL);
        else
            assert_int_equal(test_scratch_count(&scratch), 0);
        done = status == QN_OK;
        if (done)
            qn_mesh_destroy(again);
        else
            assert_int_equal(status, QN_ERROR_CANCELLED);
        if (test_scratch_count(&scratch))
            remove(path);
        qn_mesh_destroy(mesh);
        test_context_end(context);
        assert_int_equal(failing.held, 0);
        assert_true(done || n < 100);
    }
}

int main(void) {
#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, make_scratch, remove_scratch)
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
        FILE_TEST(damaged_text_is_refused),
        FILE_TEST(every_cut_is_survived),
        FILE_TEST(every_cut_of_a_packed_file_is_refused),
        FILE_TEST(not_finite_coordinates_are_read),
        FILE_TEST(every_failing_allocation_is_reported),
        FILE_TEST(writing_without_memory_leaves_nothing),
        FILE_TEST(cancelling_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
