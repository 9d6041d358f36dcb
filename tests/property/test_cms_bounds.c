// SPDX-License-Identifier: MIT
/* An expression goes on beyond the box where it is looked for: what the bounds cut off has the same
 * sharp edges and keeps to the same tolerance as all else, and a smooth surface costs nothing more.
 */
#include "lib/support.h"

#include <math.h>
#include <string.h>

/* x^2 + y^2 < 1/2 where x < 0 and y < 0; all along z. */
static const char *const quarter = "y var-y\nx var-x\nm max x y\ny2 square y\nx2 square x\n"
                                   "r add x2 y2\nf const 0.5\nc sub r f\nout max m c\n";

/* A waved sheet that the sides of the box cut. */
static const char *const waves = "z var-z\nx var-x\ny var-y\nx2 square x\ny2 square y\n"
                                 "a mul x2 y\nb mul y2 x\ns add a b\nout sub z s\n";

static qn_solid *expression(qn_context *context, const char *text) {
    qn_solid *solid;
    qn_error error;
    if (qn_solid_read_text(context, "model.vm", text, (int64_t)strlen(text), NULL, &solid,
                           &error) != QN_OK)
        fail_msg("%s", error.message);
    return solid;
}

static qn_mesh *surface(qn_context *context, const qn_solid *solid,
                        const qn_solid_surface_options *options, qn_solid_surface_report *report) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_solid_surface(context, solid, options, &mesh, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh_report check;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &check, NULL), QN_OK);
    assert_true(check.closed && check.manifold && check.oriented);
    assert_int_equal(check.self_intersections, 0);
    return mesh;
}

/* From the nearest of the pieces that a quarter is made of. */
static double off_quarter(const double p[3], double half) {
    const double pieces = fmax(fmax(p[0], p[1]), hypot(p[0], p[1]) - sqrt(0.5));
    return fabs(fmax(pieces, fabs(p[2]) - half));
}

/* Over the middles of all triangles and of their sides. */
static double farthest_off_quarter(const qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    double half = 0, most = 0;
    for (int64_t v = 0; v < view.vertex_count; ++v)
        half = fmax(half, (double)view.positions[3 * v + 2]);
    for (int64_t t = 0; t < view.triangle_count; ++t)
        for (int left_out = 0; left_out < 4; ++left_out) {
            double p[3] = {0, 0, 0};
            for (int corner = 0; corner < 3; ++corner)
                for (int k = 0; k < 3 && corner != left_out; ++k)
                    p[k] += (double)view.positions[3 * view.triangles[3 * t + corner] + k] /
                            (left_out < 3 ? 2 : 3);
            most = fmax(most, off_quarter(p, half));
        }
    return most;
}

static void caps_of_expressions_keep_to_the_tolerance(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *solid = expression(context, quarter);
    for (int depth = 5; depth <= 7; ++depth)
        for (int base = 2; base <= 8; base *= 4)
            for (int n = 0; n < 3; ++n) {
                static const double tolerances[3] = {0, 0.2, 0.5}; /* finest cells */
                qn_solid_surface_options options;
                qn_solid_surface_report report;
                qn_solid_surface_options_init(&options);
                options.depth = depth;
                options.base = base;
                options.tolerance = tolerances[n] * 2 / (1 << depth);
                qn_mesh *mesh = surface(context, solid, &options, &report);
                const double tolerance = n ? options.tolerance : report.finest_cell / 20;
                const double most = farthest_off_quarter(mesh);
                print_message("depth %d, base %d, tolerance %.3g: %lld triangles, %.3g of it off\n",
                              depth, base, tolerance, (long long)report.triangles,
                              most / tolerance);
                assert_true(most <= 1.1 * tolerance);
                assert_int_equal(report.dropped_face_features, 0);
                assert_int_equal(report.escaped_corners, 0);
                qn_mesh_destroy(mesh);
            }
    qn_solid_destroy(solid);
    test_context_end(context);
}

/* The edges where the box cuts a sheet are found, so that little must be divided for them. */
static void cut_sheets_need_no_more_triangles(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *solid = expression(context, waves);
    qn_solid_surface_options options;
    qn_solid_surface_report ends[2];
    qn_solid_surface_options_init(&options);
    options.depth = 6;
    for (int given = 0; given < 2; ++given) {
        options.has_box = given; /* within the box of the expression, or a little beyond it */
        for (int k = 0; k < 3; ++k) {
            options.low[k] = -0.998;
            options.high[k] = 0.998;
        }
        qn_mesh_destroy(surface(context, solid, &options, &ends[given]));
        print_message("%lld triangles, %lld features dropped\n", (long long)ends[given].triangles,
                      (long long)ends[given].dropped_face_features);
        assert_int_equal(ends[given].dropped_face_features, 0);
    }
    assert_true((double)ends[0].triangles < 1.25 * (double)ends[1].triangles);
    qn_solid_destroy(solid);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(caps_of_expressions_keep_to_the_tolerance),
        cmocka_unit_test(cut_sheets_need_no_more_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
