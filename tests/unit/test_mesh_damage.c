// SPDX-License-Identifier: MIT
/* Mesh files that are damaged are refused in one sentence; without memory, and cancelled, nothing
 * is left behind. */
#include "lib/failing.h"
#include "unit/mesh_files.h"

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
    const struct CMUnitTest tests[] = {
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
