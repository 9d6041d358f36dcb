// SPDX-License-Identifier: MIT
/* What the tests of mesh files share: a scratch folder, a mesh of odd numbers, the formats. */
#ifndef TEST_MESH_FILES_H
#define TEST_MESH_FILES_H

#include "lib/scratch.h"
#include "lib/support.h"

#include <math.h>
#include <zlib.h>

enum { VERTICES = 200, QUADS = 150, TRIANGLES = 70 };

static test_scratch scratch;

static inline int make_scratch(void **state) {
    (void)state;
    test_scratch_make(&scratch);
    return 0;
}

static inline int remove_scratch(void **state) {
    (void)state;
    test_scratch_remove(&scratch);
    return 0;
}

typedef struct arrays {
    float positions[VERTICES][3], normals[VERTICES][3];
    uint32_t quads[QUADS][4], triangles[TRIANGLES][3];
} arrays;

/* Coordinates of all sizes, no two vertices at the same place. */
static inline qn_mesh_view random_view(arrays *a, int64_t vertices, int64_t quads,
                                       int64_t triangles) {
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

static inline qn_mesh *make_mesh(qn_context *context, int64_t vertices, int64_t quads,
                                 int64_t triangles) {
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

static inline void write_form(qn_context *context, const qn_mesh *mesh, const form *f) {
    qn_mesh_write_options options;
    qn_mesh_write_options_init(&options);
    options.ascii = f->ascii;
    qn_error error;
    if (qn_mesh_write(context, mesh, test_scratch_path(&scratch, f->name), &options, &error) !=
        QN_OK)
        fail_msg("%s", error.message);
}

static inline qn_mesh *read_form(qn_context *context, const char *name) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_mesh_read(context, test_scratch_path(&scratch, name), NULL, &mesh, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

static inline qn_mesh *read_bytes(qn_context *context, const char *name, const void *bytes,
                                  size_t size) {
    test_put_file(test_scratch_path(&scratch, name), bytes, size);
    return read_form(context, name);
}

static inline void assert_counts(const qn_mesh *mesh, int64_t vertices, int64_t quads,
                                 int64_t triangles) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    assert_int_equal(view.vertex_count, vertices);
    assert_int_equal(view.quad_count, quads);
    assert_int_equal(view.triangle_count, triangles);
}

static inline void put_packed(const char *path, const void *bytes, size_t size) {
    gzFile file = gzopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(gzwrite(file, bytes, (unsigned)size), size);
    assert_int_equal(gzclose(file), Z_OK);
}

#define FILE_TEST(name) cmocka_unit_test_setup_teardown(name, make_scratch, remove_scratch)

#endif
