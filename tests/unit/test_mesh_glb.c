// SPDX-License-Identifier: MIT
/* GLB files of others: nodes move, turn and mirror what they hold, materials are owners, lists and
 * strips and all widths of indices are read; what reaches beyond its data is refused. */
#include "lib/scratch.h"
#include "lib/support.h"

#include <math.h>

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

static size_t put_word(char *to, size_t value) {
    for (int b = 0; b < 4; ++b)
        to[b] = (char)(value >> (8 * b) & 255);
    return 4;
}

/* A file of one JSON chunk and one of data: the corners of a tetrahedron as floats, then indices of
 * its four triangles as bytes, and as 16-bit numbers. */
static const char *put_glb(const char *json) {
    static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const char indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    char bytes[4096];
    const size_t length = strlen(json), padded = (length + 3) / 4 * 4;
    assert_true(padded < sizeof bytes - 200);
    memcpy(bytes, "glTF\2\0\0", 8);
    size_t at = 8;
    at += put_word(bytes + at, 12 + 8 + padded + 8 + 84);
    at += put_word(bytes + at, padded);
    memcpy(bytes + at, "JSON", 4);
    memset(bytes + at + 4, ' ', padded);
    memcpy(bytes + at + 4, json, length);
    at += 4 + padded;
    at += put_word(bytes + at, 84);
    memcpy(bytes + at, "BIN\0", 4);
    at += 4;
    for (int n = 0; n < 12; ++n) {
        uint32_t bits;
        memcpy(&bits, &corners[n / 3][n % 3], 4);
        at += put_word(bytes + at, bits);
    }
    memcpy(bytes + at, indices, 12);
    at += 12;
    for (int n = 0; n < 12; ++n) {
        bytes[at++] = indices[n];
        bytes[at++] = 0;
    }
    const char *path = test_scratch_path(&scratch, "a.glb");
    test_put_file(path, bytes, at);
    return path;
}

#define DATA                                                                                       \
    "\"buffers\":[{\"byteLength\":84}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"         \
    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12},"                                          \
    "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":24}],"
#define ACCESSORS                                                                                  \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"      \
    "{\"bufferView\":1,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"},"                  \
    "{\"bufferView\":2,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}],"
#define MESH(indices, rest)                                                                        \
    "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":" indices rest "}]}"
#define FILE_OF(rest) "{\"asset\":{\"version\":\"2.0\"}," DATA ACCESSORS rest "}"

static qn_mesh *read_glb(qn_context *context, const char *json) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_mesh_read(context, put_glb(json), NULL, &mesh, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

static qn_mesh_report check(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_int_equal(report.boundary_edges, 0);
    assert_int_equal(report.orientation_conflicts, 0);
    return report;
}

static void meshes_without_a_scene_are_read(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = read_glb(context, FILE_OF("\"meshes\":[" MESH("1", ",\"material\":4") "]"));
    qn_mesh_view view = qn_mesh_get_view(mesh);
    assert_int_equal(view.vertex_count, 4);
    assert_int_equal(view.triangle_count, 4);
    for (int n = 0; n < 4; ++n)
        assert_int_equal(view.triangle_owners[n], 5);
    assert_true(fabs(check(context, mesh).volume - 1 / 6.0) < 1e-7);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

/* A half turn round z with a shift above a mirror that makes it twice as large. */
static void nodes_move_and_mirror(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = read_glb(
        context,
        FILE_OF("\"meshes\":[" MESH("2", ",\"material\":0") "," MESH(
            "1",
            "") "],\"scene\":0,"
                "\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                "{\"children\":[1],\"rotation\":[0,0,1,0],\"translation\":[10,0,0],\"mesh\":1},"
                "{\"mesh\":0,\"matrix\":[2,0,0,0,0,2,0,0,0,0,-2,0,0,0,-5,1]}]"));
    qn_mesh_view view = qn_mesh_get_view(mesh);
    static const float places[8][3] = {{10, 0, 0},  {10, -1, 0}, {9, 0, 0},    {10, 0, 1},
                                       {10, 0, -5}, {8, 0, -5},  {10, -2, -5}, {10, 0, -7}};
    assert_int_equal(view.vertex_count, 8);
    assert_int_equal(view.triangle_count, 8);
    for (int n = 0; n < 8; ++n) {
        int found = 0;
        for (int v = 0; v < 8; ++v)
            found += view.positions[3 * v] == places[n][0] &&
                     view.positions[3 * v + 1] == places[n][1] &&
                     view.positions[3 * v + 2] == places[n][2];
        assert_int_equal(found, 1);
    }
    for (int n = 0; n < 8; ++n)
        assert_int_equal(view.triangle_owners[n], n < 4 ? 0 : 1);
    assert_true(fabs(check(context, mesh).volume - 9 / 6.0) < 1e-6); /* turned, so not -8 + 1 */
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void strips_and_plain_corners_are_read(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_mesh *mesh = read_glb(context, FILE_OF("\"meshes\":[{\"primitives\":["
                                              "{\"attributes\":{\"POSITION\":0},\"mode\":5},"
                                              "{\"attributes\":{\"POSITION\":0},\"mode\":6},"
                                              "{\"attributes\":{\"POSITION\":0},\"mode\":1},"
                                              "{\"attributes\":{\"POSITION\":0}}]}]"));
    qn_mesh_view view = qn_mesh_get_view(mesh);
    static const uint32_t expected[15] = {0, 1, 2, 1, 3, 2, 0, 1, 2, 0, 2, 3, 0, 1, 2};
    assert_int_equal(view.triangle_count, 5);
    assert_memory_equal(view.triangles, expected, sizeof expected);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void damaged_files_are_refused(void **state) {
    (void)state;
    static const char circle[] =
        FILE_OF("\"meshes\":[" MESH("1", "") "],\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                                             "{\"children\":[1]},{\"children\":[0]}]");
    static const char many[] =
        FILE_OF("\"meshes\":[" MESH("1", "") "],\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                                             "{\"children\":[1,1,1,1,1,1,1,1,1,1,1,1]},"
                                             "{\"children\":[2,2,2,2,2,2,2,2,2,2,2,2]},"
                                             "{\"children\":[3,3,3,3,3,3,3,3,3,3,3,3]},"
                                             "{\"children\":[4,4,4,4,4,4,4,4,4,4,4,4]},"
                                             "{\"children\":[5,5,5,5,5,5,5,5,5,5,5,5]},"
                                             "{\"children\":[6,6,6,6,6,6,6,6,6,6,6,6]},"
                                             "{\"mesh\":0}]");
    static const char long_accessor[] =
        "{\"asset\":{}," DATA "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":5,\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":["
        "{\"attributes\":{\"POSITION\":0}}]}]}";
    static const struct {
        const char *json, *words;
    } cases[] = {
        {"{\"asset\":", "JSON is damaged"},
        {circle, "in a circle"},
        {many, "size allows"},
        {long_accessor, "beyond the end"},
        {FILE_OF("\"meshes\":[" MESH("7", "") "]"), "no data"},
        {FILE_OF("\"meshes\":[" MESH("0", "") "]"), "whole numbers"},
        {FILE_OF("\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":1}}]}]"),
         "reaches beyond"},
        {FILE_OF("\"scenes\":[{\"nodes\":[3]}]"), "a node that is not there"},
        {FILE_OF("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":2}]"),
         "a mesh that is not there"},
    };
    qn_context *context = test_context(1);
    const int64_t held = qn_context_memory(context).current_bytes;
    for (size_t n = 0; n < sizeof cases / sizeof *cases; ++n) {
        qn_mesh *mesh;
        qn_error error;
        assert_int_equal(qn_mesh_read(context, put_glb(cases[n].json), NULL, &mesh, &error),
                         QN_ERROR_INPUT);
        if (!strstr(error.message, cases[n].words))
            fail_msg("case %zu: '%s' does not say '%s'", n, error.message, cases[n].words);
        assert_null(mesh);
        assert_int_equal(qn_context_memory(context).current_bytes, held);
    }
    test_context_end(context);
}

static void materials_and_groups_of_obj_files_are_owners(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int32_t quad, triangles[3];
    } cases[] = {
        {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nusemtl a\nf 1 2 3 4\ng x\nusemtl b\n"
         "f 1 2 4\nusemtl a\nf 2 3 4\n",
         1,
         {0, 2, 1}},
        {"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng one\nf 1 2 3\nf 1 2 3 4\ng two\nf 1 2 4\n"
         "g one\nf 2 3 4\n",
         1,
         {1, 2, 1}},
    };
    qn_context *context = test_context(1);
    for (size_t n = 0; n < sizeof cases / sizeof *cases; ++n) {
        const char *path = test_scratch_path(&scratch, "a.obj");
        test_put_file(path, cases[n].text, strlen(cases[n].text));
        qn_mesh *mesh;
        assert_int_equal(qn_mesh_read(context, path, NULL, &mesh, NULL), QN_OK);
        qn_mesh_view view = qn_mesh_get_view(mesh);
        assert_int_equal(view.triangle_count, 3);
        assert_int_equal(view.quad_owners[0], cases[n].quad);
        assert_memory_equal(view.triangle_owners, cases[n].triangles, sizeof cases[n].triangles);
        qn_mesh_destroy(mesh);
    }
    test_context_end(context);
}

/* The first of the names counts; a number that no owner can have is 0. */
static void owners_of_ply_files_are_read(void **state) {
    (void)state;
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 3\nproperty int material_index\n"
        "property list uchar int vertex_indices\nproperty int group\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 3 0 1 2 9\n-2 4 0 1 2 3 9\n1e300 3 0 2 3 9\n";
    qn_context *context = test_context(1);
    const char *path = test_scratch_path(&scratch, "a.ply");
    test_put_file(path, text, strlen(text));
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_read(context, path, NULL, &mesh, NULL), QN_OK);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    assert_int_equal(view.triangle_count, 2);
    assert_int_equal(view.quad_count, 1);
    assert_int_equal(view.triangle_owners[0], 7);
    assert_int_equal(view.triangle_owners[1], 0);
    assert_int_equal(view.quad_owners[0], -2);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

int main(void) {
#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, make_scratch, remove_scratch)
    const struct CMUnitTest tests[] = {
        FILE_TEST(meshes_without_a_scene_are_read),
        FILE_TEST(nodes_move_and_mirror),
        FILE_TEST(strips_and_plain_corners_are_read),
        FILE_TEST(damaged_files_are_refused),
        FILE_TEST(materials_and_groups_of_obj_files_are_owners),
        FILE_TEST(owners_of_ply_files_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
