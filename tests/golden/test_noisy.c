// SPDX-License-Identifier: MIT
/* The noisy volume, at an iso-value on which samples lie and at one between: each of its ambiguous
 * faces is decided as exact arithmetic says, and there is no crack. */
#include "lib/mesh_measure.h"
#include "lib/reference_match.h"

#include <math.h>
#include <zlib.h>

enum { SIDE = 256 };

static bool read_noisy(test_field *field) {
    char path[4096];
    if (!test_data_path("volumes/noisy_synthetic_256x256x256_u16le.raw.gz", path, sizeof path))
        return false;
    gzFile file = gzopen(path, "rb");
    assert_non_null(file);
    *field = test_field_make(SIDE, SIDE, SIDE);
    unsigned char row[2 * SIDE];
    for (int64_t r = 0; r < SIDE * SIDE; ++r) {
        assert_int_equal(gzread(file, row, sizeof row), sizeof row);
        for (int64_t i = 0; i < SIDE; ++i)
            field->values[r * SIDE + i] = row[2 * i] + 256 * row[2 * i + 1];
    }
    gzclose(file);
    return true;
}

/* Ambiguous faces whose two products differ by more than a millionth: those that the comparison of
 * surfacers counted, of which each took its own choice. */
static int64_t clear_faces(const test_field *field) {
    int64_t count = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int64_t k = 0; k < SIDE - (axis != 2); ++k)
            for (int64_t j = 0; j < SIDE - (axis != 1); ++j)
                for (int64_t i = 0; i < SIDE - (axis != 0); ++i) {
                    const test_face face = {{i, j, k}, axis};
                    if (test_face_decide(field, face, NULL) == TEST_FACE_PLAIN)
                        continue;
                    const int u = axis == 0, v = axis == 2 ? 1 : 2; /* the face's two axes */
                    double d[4];
                    for (int c = 0; c < 4; ++c) {
                        int64_t s[3] = {i, j, k};
                        s[u] += c & 1, s[v] += c >> 1;
                        d[c] = test_field_distance(field, s[0], s[1], s[2]);
                    }
                    double one = fabs(d[0] * d[3]), other = fabs(d[1] * d[2]);
                    count += fabs(one - other) > 1e-6 * (one + other);
                }
    return count;
}

static void check_iso(qn_context *context, test_field *field, double iso, int64_t *faces) {
    field->iso = iso;
    snprintf(field->name, sizeof field->name, "noisy at %g, %s", iso,
             field->open ? "open" : "closed");
    test_field_prepare(field);
    qn_surface_report report;
    qn_mesh *mesh = test_field_surface(context, field, &report);
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    test_match_report(field, &reference, &report);
    const double low[3] = {1, 1, 1}, high[3] = {SIDE - 2, SIDE - 2, SIDE - 2};
    assert_int_equal(test_mesh_cracks(mesh, low, high), 0);
    *faces = reference.ambiguous_faces;
    test_edges edges = test_mesh_edges(mesh);
    if (!field->open)
        assert_int_equal(edges.unbalanced, 0);
    printf("%s: %lld vertices, %lld quads, %lld ambiguous faces as decided, %lld edges "
           "of four quads, %lld slices, %lld degenerate, %lld fallbacks\n",
           field->name, (long long)report.vertices, (long long)report.quads, (long long)*faces,
           (long long)edges.more_than_two, (long long)report.slice_points,
           (long long)report.degenerate_points, (long long)report.fallback_points);
    test_match_free(&match);
    test_reference_free(&reference);
    qn_mesh_destroy(mesh);
}

static void noisy_faces_are_as_the_decider_says(void **state) {
    (void)state;
    test_field field;
    if (!read_noisy(&field))
        skip();
    qn_context *context = test_context(0);
    int64_t faces;
    field.open = true;
    check_iso(context, &field, 2048, &faces);
    check_iso(context, &field, 2048.5, &faces);
    assert_int_equal(faces, 36036);
    assert_int_equal(clear_faces(&field), 36032);
    if (test_is_long()) {
        field.open = false;
        check_iso(context, &field, 2048, &faces);
        check_iso(context, &field, 2048.5, &faces);
    }
    test_field_free(&field);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(noisy_faces_are_as_the_decider_says)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
