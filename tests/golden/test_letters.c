// SPDX-License-Identifier: MIT
/* [CMS05] table 4 and figure 9: a text remeshed at three feature thresholds. With the angle alone
 * deciding what is divided, as there (section 3.2), the flat letter keeps its triangles to the last
 * one and the curved one gains at every step. */
#include "lib/support.h"

#include <math.h>

enum { THRESHOLDS = 3, DEPTH = 6 };

/* Cosines, as q in the paper. */
static const double cosines[THRESHOLDS] = {0.7, 0.8, 0.9};
/* Between the E and the G, as letters.csg says. */
static const float split = 12;

static qn_mesh *surface_of(qn_context *context, const qn_solid *solid, int32_t depth,
                           const double *cosine) {
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    if (cosine) {
        options.crease = acos(*cosine) * 180 / 3.14159265358979323846;
        options.tolerance = 1000; /* more than the model: the angle decides */
    }
    qn_mesh *mesh;
    qn_error error = {0};
    if (qn_solid_surface(context, solid, &options, &mesh, NULL, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

/* The polygon model of a .csg file. */
static qn_solid *polygon_model(qn_context *context, const char *path) {
    qn_solid *letters, *model;
    qn_error error = {0};
    if (qn_solid_read(context, path, NULL, &letters, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh *mesh = surface_of(context, letters, 7, NULL);
    assert_int_equal(qn_solid_from_mesh(context, mesh, NULL, &model, NULL, &error), QN_OK);
    qn_mesh_destroy(mesh);
    qn_solid_destroy(letters);
    return model;
}

static void count_sides(const qn_mesh *mesh, int64_t counts[2]) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    counts[0] = counts[1] = 0;
    for (int64_t n = 0; n < view.triangle_count; ++n) {
        float middle = 0;
        for (int i = 0; i < 3; ++i)
            middle += view.positions[3 * (int64_t)view.triangles[3 * n + i]] / 3;
        ++counts[middle > split];
    }
}

static void flat_letters_keep_their_triangles_and_curved_ones_gain(void **state) {
    qn_context *context = test_context(1);
    qn_solid *model = polygon_model(context, *state);
    int64_t before[2] = {0, 0};
    for (int n = 0; n < THRESHOLDS; ++n) {
        qn_mesh *mesh = surface_of(context, model, DEPTH, &cosines[n]);
        qn_mesh_report report;
        int64_t counts[2];
        assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
        assert_true(report.closed && report.manifold && report.oriented);
        assert_int_equal(report.self_intersections, 0);
        count_sides(mesh, counts);
        print_message("q %.1f: %lld triangles of the flat letter, %lld of the curved one\n",
                      cosines[n], (long long)counts[0], (long long)counts[1]);
        assert_true(n == 0 || counts[0] == before[0]);
        assert_true(counts[1] > before[1]);
        memcpy(before, counts, sizeof before);
        qn_mesh_destroy(mesh);
    }
    qn_solid_destroy(model);
    test_context_end(context);
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: test_letters letters.csg\n");
        return 2;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(flat_letters_keep_their_triangles_and_curved_ones_gain, argv[1])};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
