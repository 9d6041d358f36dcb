// SPDX-License-Identifier: MIT
/* The shape of quads and triangles is at least that of [DMC21] Tables 8 and 7, and the surfaces
 * that end within the volume are closed, balanced and of the right genus. */
#include "golden/golden_case.h"
#include "lib/mesh_measure.h"

typedef struct quality_row {
    const char *name, *scalar, *inside;
    int64_t n;
    double quads, triangles; /* means of equations (9) and (8) that the paper reaches */
} quality_row;

static const quality_row rows[] = {
    {"gen2", "f64", "below", 64, 0.85, 0.87},
    {"gen2", "f64", "below", 128, 0.86, 0.87},
    {"gen2", "f64", "below", 256, 0.86, 0.87},
    {"iwp", "f32", "above", 512, 0.89, 0.84},
};

static qn_mesh *mesh_of(qn_context *context, const quality_row *row) {
    golden_case one;
    memset(&one, 0, sizeof one);
    snprintf(one.name, sizeof one.name, "%s", row->name);
    snprintf(one.scalar, sizeof one.scalar, "%s", row->scalar);
    snprintf(one.inside, sizeof one.inside, "%s", row->inside);
    snprintf(one.border, sizeof one.border, "open");
    one.n = row->n;
    return golden_mesh(context, &one);
}

static void shapes_are_as_good_as_the_paper_s(void **state) {
    (void)state;
    qn_context *context = test_context(0);
    int wrong = 0;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        qn_mesh *mesh = mesh_of(context, &rows[i]);
        double quads = test_mean_quad_quality(mesh);
        assert_int_equal(qn_mesh_triangulate(context, mesh, NULL), QN_OK);
        double triangles = test_mean_triangle_quality(mesh);
        printf("%s %lld: quads %.4f (at least %.2f), triangles %.4f (at least %.2f)\n",
               rows[i].name, (long long)rows[i].n, quads, rows[i].quads, triangles,
               rows[i].triangles);
        wrong += quads < rows[i].quads || triangles < rows[i].triangles;
        qn_mesh_destroy(mesh);
    }
    test_context_end(context);
    assert_int_equal(wrong, 0);
}

static void gen2_has_genus_2(void **state) {
    (void)state;
    qn_context *context = test_context(0);
    for (int i = 0; i < 3; ++i) {
        qn_mesh *mesh = mesh_of(context, &rows[i]);
        qn_mesh_view view = qn_mesh_get_view(mesh);
        test_edges edges = test_mesh_edges(mesh);
        double area, volume;
        test_mesh_area_volume(mesh, &area, &volume);
        assert_int_equal(edges.unbalanced, 0);
        assert_int_equal(edges.more_than_two, 0);
        assert_int_equal(test_mesh_pieces(mesh), 1);
        assert_int_equal(view.vertex_count - edges.count + view.quad_count, -2);
        assert_true(volume > 0);
        qn_mesh_destroy(mesh);
    }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gen2_has_genus_2),
        cmocka_unit_test(shapes_are_as_good_as_the_paper_s),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
