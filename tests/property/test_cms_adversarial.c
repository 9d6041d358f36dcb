// SPDX-License-Identifier: MIT
/* Inputs made to break surfacers: every mesh is closed, manifold and free of self-intersections,
 * whatever else can be had. What Quoin does with each stands in docs/guide-csg.md. */
#include "lib/test_solid.h"

#include <math.h>

static qn_mesh_report surface_of(qn_context *context, qn_solid *solid, int depth, double crease) {
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    options.crease = crease;
    qn_mesh *mesh;
    qn_error error;
    qn_mesh_report report;
    if (qn_solid_surface(context, solid, &options, &mesh, NULL, &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    assert_int_equal(report.degenerate_faces, 0);
    qn_mesh_destroy(mesh);
    return report;
}

/* Two planes through the z axis that enclose an angle, in a box. */
static qn_solid *wedge(qn_context *context, double angle, double tilt, double tip) {
    const double half = 0.5 * angle, up[3] = {sin(tilt - half), cos(tilt - half), 0.01},
                 down[3] = {-sin(tilt + half), -cos(tilt + half), 0.013};
    const test_frame frame = test_frame_at(0, 0, 0);
    const double size[3] = {0.9, 0.9, 0.9};
    qn_solid *planes = test_intersection(test_plane(context, up, tip * up[1], 1),
                                         test_plane(context, down, tip * down[1], 2));
    qn_solid *solid = test_intersection(planes, test_box(context, &frame, size, 3));
    test_solid_set_box(solid, -1, 1);
    return solid;
}

static void wedges_whose_planes_hit_every_cell(void **state) {
    (void)state;
    for (int n = 0; n < 12; ++n) {
        qn_context *context = test_context(1);
        const double degree = 3.14159265358979 / 180;
        qn_solid *solid = wedge(context, (n % 3 ? 4.0 * n : 1) * degree, 0.02 * n, 0.003 * n);
        surface_of(context, solid, 4 + n % 3, 0.5);
        qn_solid_destroy(solid);
        test_context_end(context);
    }
}

static void a_concave_edge_may_move(void **state) {
    (void)state;
    for (int n = 0; n < 16; ++n) {
        qn_context *context = test_context(1);
        test_frame frame = test_frame_at(0, 0, 0), bite = test_frame_at(0.6, 0.6, 0);
        for (int k = 0; k < 2; ++k)
            bite.origin[k] += 0.0071 * n;
        const double size[3] = {0.8, 0.8, 0.8}, bite_size[3] = {0.6, 0.6, 2};
        qn_solid *solid = test_difference(test_box(context, &frame, size, 1),
                                          test_box(context, &bite, bite_size, 7));
        test_solid_set_box(solid, -1, 1);
        const qn_mesh_report report = surface_of(context, solid, 5, 0);
        const double notch = 0.8 - 0.0071 * n, volume = 1.6 * (2.56 - notch * notch);
        assert_true(fabs(report.volume - volume) < 1e-5);
        qn_solid_destroy(solid);
        test_context_end(context);
    }
}

/* The lattice's planes are at (8 n + 3) / 8 of a cell. */
static void faces_may_lie_on_the_lattice(void **state) {
    (void)state;
    for (int n = 0; n < 16; ++n) {
        qn_context *context = test_context(1);
        const double unit = 1.0 / 256,
                     half[3] = {(8 * 8 + n) * unit, (8 * 6 + 3) * unit, (8 * 7 - 5) * unit};
        const test_frame frame = test_frame_at((n % 8) * unit, 0, 0);
        qn_solid *solid = test_box(context, &frame, half, 1);
        test_solid_set_box(solid, -0.9, 0.9);
        const qn_mesh_report report = surface_of(context, solid, 6, 0);
        assert_true(fabs(report.volume - 8 * half[0] * half[1] * half[2]) < 1e-5);
        qn_solid_destroy(solid);
        test_context_end(context);
    }
}

/* Found when some lattice edge meets it, else nothing: closed either way. */
static void a_sphere_of_half_a_cell(void **state) {
    (void)state;
    for (int n = 0; n < 24; ++n) {
        qn_context *context = test_context(1);
        const double cell = 2.0 / 29, centre[3] = {0.013 * n, 0.007 * n, 0.003 * n};
        qn_solid *solid = test_sphere(context, centre, 0.25 * cell, 1);
        test_solid_set_box(solid, -1, 1);
        surface_of(context, solid, 5, 0);
        qn_solid_destroy(solid);
        test_context_end(context);
    }
}

/* ---- callbacks ----------------------------------------------------------------------------------
 */

enum { NOT_NUMBERS, NO_GRADIENT, FULL, EMPTY };

static int odd_values(void *user, int64_t count, const double (*points)[3], double *values) {
    for (int64_t n = 0; n < count; ++n) {
        const double *p = points[n], r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        const int kind = *(const int *)user;
        values[n] = kind == FULL ? -1 : kind == EMPTY ? 1 : r - 0.6;
        if (kind == NOT_NUMBERS && p[0] > 0.2 + 0.1 * p[1])
            values[n] = NAN;
    }
    return 0;
}

static int no_gradients(void *user, int64_t count, const double (*points)[3],
                        double (*gradients)[3], int32_t *owners) {
    (void)user;
    (void)points;
    for (int64_t n = 0; n < count; ++n) {
        for (int k = 0; k < 3 && gradients; ++k)
            gradients[n][k] = 0;
        if (owners)
            owners[n] = 1;
    }
    return 0;
}

static qn_mesh_report surface_of_callback(int kind, bool bounded) {
    qn_context *context = test_context(1);
    qn_solid_callback callback;
    qn_solid_callback_init(&callback);
    callback.user = &kind;
    callback.values = odd_values;
    callback.gradients = kind == NO_GRADIENT ? no_gradients : NULL;
    callback.lipschitz = bounded && kind == NO_GRADIENT ? 1 : 0;
    for (int k = 0; k < 3; ++k) {
        callback.low[k] = -1;
        callback.high[k] = 1;
    }
    qn_solid *solid;
    assert_int_equal(qn_solid_from_callback(context, &callback, &solid, NULL), QN_OK);
    const qn_mesh_report report = surface_of(context, solid, 5, 0);
    qn_solid_destroy(solid);
    test_context_end(context);
    return report;
}

static void callbacks_may_say_odd_things(void **state) {
    (void)state;
    const double ball = 4 * 3.14159265358979 / 3 * 0.6 * 0.6 * 0.6;
    const qn_mesh_report cut = surface_of_callback(NOT_NUMBERS, false);
    assert_true(cut.volume > 0.5 * ball && cut.volume < 0.9 * ball); /* NaN is outside */
    for (int bounded = 0; bounded < 2; ++bounded)
        assert_true(fabs(surface_of_callback(NO_GRADIENT, bounded).volume - ball) < 0.05 * ball);
    assert_int_equal(surface_of_callback(EMPTY, false).components, 0);
    assert_true(fabs(surface_of_callback(FULL, false).volume - 8) < 0.05);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wedges_whose_planes_hit_every_cell),
        cmocka_unit_test(a_concave_edge_may_move),
        cmocka_unit_test(faces_may_lie_on_the_lattice),
        cmocka_unit_test(a_sphere_of_half_a_cell),
        cmocka_unit_test(callbacks_may_say_odd_things),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
