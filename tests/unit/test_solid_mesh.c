// SPDX-License-Identifier: MIT
/* Polygon models as solids: which rule is chosen, that all answers agree, that holes are closed,
 * that memory may run out at any moment. */
#include "lib/failing.h"
#include "lib/polygon_models.h"
#include "lib/solid_claims.h"
#include "solid/model.h"

#include <math.h>

static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};

static qn_solid *solid_of(qn_context *context, const test_model *model, qn_mesh_sign sign,
                          qn_solid_mesh_report *report) {
    qn_mesh *mesh = test_model_mesh(context, model);
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    options.sign = sign;
    qn_solid *solid = NULL;
    qn_error error = {0};
    if (qn_solid_from_mesh(context, mesh, &options, &solid, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_mesh_destroy(mesh);
    return solid;
}

static bool is_inside(const qn_solid *solid, double x, double y, double z) {
    const double p[1][3] = {{x, y, z}};
    double value;
    bool inside;
    assert_int_equal(solid->ops->values(solid, 1, p, &value), QN_OK);
    assert_int_equal(solid->ops->inside(solid, 1, p, &inside), QN_OK);
    assert_int_equal(inside, value < 0);
    return inside;
}

/* Claims of every solid, over the model's box and somewhat more. */
static void make_claims(const char *name, const qn_solid *solid, bool all, double difference) {
    test_random random = {test_seed()};
    test_claims claims = {
        .rounds = 150, .slope = all ? 1 : 0, .all = all, .difference = difference};
    for (int k = 0; k < 3; ++k) {
        double size = solid->box.high[k] - solid->box.low[k];
        claims.low[k] = solid->box.low[k] - 0.2 * size;
        claims.high[k] = solid->box.high[k] + 0.2 * size;
    }
    test_solid_claims(name, solid, &claims, &random);
}

static void a_closed_model_is_exact(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    qn_solid_mesh_report report;
    test_model_ball(&model, zero, 1, 3);
    qn_solid *solid = solid_of(context, &model, QN_MESH_SIGN_AUTO, &report);
    assert_int_equal(report.used, QN_MESH_SIGN_WINDING);
    assert_true(report.closed);
    assert_int_equal(report.triangles, 512);
    assert_int_equal(report.disagreeing_lines, 0);
    assert_int_equal(report.lines, 3072);
    assert_true(is_inside(solid, 0, 0, 0));
    assert_false(is_inside(solid, 1.01, 0, 0));
    make_claims("ball", solid, true, 0);
    qn_solid_destroy(solid);
    test_model_free(&model);
    test_context_end(context);
}

/* All that is asked lies on the lattice of the model's own corners. */
static void points_on_faces_edges_and_corners_have_one_side(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    qn_solid_mesh_report report;
    test_model_box(&model, zero, one, NULL);
    qn_solid *solid = solid_of(context, &model, QN_MESH_SIGN_AUTO, &report);
    for (int n = 0; n < 125; ++n) {
        const int at[3] = {n % 5, n / 5 % 5, n / 25};
        double p[3];
        bool expected = true; /* moved by (e, e^2, e^3) it lies within: 0 <= p < 1 */
        for (int k = 0; k < 3; ++k) {
            p[k] = 0.5 * at[k] - 0.5;
            expected = expected && p[k] >= 0 && p[k] < 1;
        }
        assert_int_equal(is_inside(solid, p[0], p[1], p[2]), expected);
        for (int axis = 0; axis < 3; ++axis) {
            double q[3] = {p[0], p[1], p[2]};
            qni_crossing found[8];
            int32_t count;
            q[axis] += 0.5;
            assert_int_equal(solid->ops->crossings(solid, p, q, 8, found, &count), QN_OK);
            bool end = is_inside(solid, q[0], q[1], q[2]);
            assert_int_equal(count, expected != end);
            if (count)
                assert_int_equal(found[0].enters, end);
        }
    }
    qn_solid_destroy(solid);
    test_model_free(&model);
    test_context_end(context);
}

/* Two boxes that overlap, one that touches, one inside: their union has no inner walls. */
static void overlapping_parts_become_one(void **state) {
    (void)state;
    static const double lows[4][3] = {{0, 0, 0}, {0.5, 0.25, 0.25}, {-1, 0, 0}, {0.2, 0.2, 0.2}};
    static const double highs[4][3] = {{1, 1, 1}, {2, 0.75, 0.75}, {0, 1, 1}, {0.3, 0.3, 0.3}};
    qn_context *context = test_context(1);
    test_model model = {0};
    qn_solid_mesh_report report;
    for (int n = 0; n < 4; ++n)
        test_model_box(&model, lows[n], highs[n], NULL);
    qn_solid *solid = solid_of(context, &model, QN_MESH_SIGN_AUTO, &report);
    assert_true(report.closed);
    assert_true(report.disagreeing_lines > 0);
    static const double a[3] = {-3, 0.26, 0.27}, b[3] = {3, 0.26, 0.27};
    qni_crossing found[8];
    int32_t count;
    assert_int_equal(solid->ops->crossings(solid, a, b, 8, found, &count), QN_OK);
    assert_int_equal(count, 2);
    assert_true(found[0].enters && fabs(found[0].at - 1.0 / 3) < 1e-12);
    assert_true(fabs(found[0].normal[0] + 1) < 1e-12 && fabs(found[1].normal[0] - 1) < 1e-12);
    assert_true(fabs(found[1].at - 5.0 / 6) < 1e-12);
    qn_solid_destroy(solid);
    solid = solid_of(context, &model, QN_MESH_SIGN_PARITY, &report);
    assert_int_equal(report.used, QN_MESH_SIGN_PARITY);
    assert_false(is_inside(solid, 0.25, 0.25, 0.25)); /* behind two walls */
    make_claims("boxes by parity", solid, true, 0);
    qn_solid_destroy(solid);
    test_model_free(&model);
    test_context_end(context);
}

/* The surface's volume, and that the mesh is sound. */
static double volume_of(qn_context *context, const qn_solid *solid, int32_t depth) {
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    qn_mesh *mesh = NULL;
    qn_mesh_report check;
    qn_error error = {0};
    qn_status status = qn_solid_surface(context, solid, &options, &mesh, NULL, &error);
    if (status == QN_ERROR_UNSUPPORTED)
        return -1;
    assert_int_equal(status, QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &check, &error), QN_OK);
    assert_true(check.closed && check.manifold && check.oriented);
    assert_int_equal(check.self_intersections, 0);
    qn_mesh_destroy(mesh);
    return check.volume;
}

static void inside_out_is_turned(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    qn_solid_mesh_report report;
    test_model_ball(&model, zero, 1, 2);
    test_model_turn_round(&model, 0); /* all of it */
    qn_solid *solid = solid_of(context, &model, QN_MESH_SIGN_AUTO, &report);
    assert_true(report.closed && is_inside(solid, 0, 0, 0));
    double volume = volume_of(context, solid, 5);
    assert_true(volume < 0 || volume > 3);
    qn_solid_destroy(solid);
    test_model_turn_round(&model, 20); /* most of it back: neighbours clash */
    solid = solid_of(context, &model, QN_MESH_SIGN_AUTO, &report);
    assert_int_equal(report.used, QN_MESH_SIGN_WINDING);
    assert_true(report.rim_edges > 0 && report.odd_edges == 0 && report.closed);
    assert_int_equal(report.turned_triangles, 20);
    assert_true(is_inside(solid, 0, 0, 0));
    qn_solid_destroy(solid);
    test_model_free(&model);
    test_context_end(context);
}

/* Without its last triangles a ball has holes; the sheet over them has the sign's own gradient. */
static void holes_are_closed(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    qn_solid_mesh_report report;
    test_model_ball(&model, zero, 1, 3);
    model.triangle_count -= 24;
    qn_solid *solid = solid_of(context, &model, QN_MESH_SIGN_AUTO, &report);
    assert_int_equal(report.used, QN_MESH_SIGN_WINDING);
    assert_false(report.closed);
    assert_true(report.holes > 0 && report.disagreeing_lines > 0);
    make_claims("ball with holes", solid, false, 0);
    int64_t before = qn_solid_get_hole_crossings(solid);
    double volume = volume_of(context, solid, 5);
    assert_true(volume < 0 || (volume > 3.6 && volume < 4 * 3.1416 / 3));
    assert_true(volume < 0 || qn_solid_get_hole_crossings(solid) > before);
    qn_solid_destroy(solid);
    solid = solid_of(context, &model, QN_MESH_SIGN_PARITY, &report);
    assert_false(report.closed);
    make_claims("ball with flat caps", solid, true, 0);
    volume = volume_of(context, solid, 5);
    assert_true(volume < 0 || (volume > 3.6 && volume < 4 * 3.1416 / 3));
    qn_solid_destroy(solid);
    test_model_free(&model);
    test_context_end(context);
}

/* The sum of the angles of a closed model is its winding number; the gradient is that of
 * differences. */
/* A part knows only the panels that meet its box: of large triangles few do, whose boxes all do. */
static void parts_of_a_soup_answer_as_the_whole(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    test_random random = {test_seed()};
    for (uint32_t n = 0; n < 40; ++n) {
        for (int i = 0; i < 3; ++i)
            test_model_point(&model, test_random_unit(&random), test_random_unit(&random),
                             test_random_unit(&random));
        test_model_triangle(&model, 3 * n, 3 * n + 1, 3 * n + 2);
    }
    qn_solid *whole = solid_of(context, &model, QN_MESH_SIGN_AUTO, NULL);
    for (int n = 0; n < 300; ++n) {
        double points[8][3], values[2][8];
        qni_box box;
        qn_solid *part;
        for (int k = 0; k < 3; ++k) {
            box.low[k] = 1.2 * test_random_unit(&random) - 0.1;
            box.high[k] = box.low[k] + 0.001 + 0.3 * test_random_unit(&random) * (n % 2);
            for (int i = 0; i < 8; ++i)
                points[i][k] = box.low[k] + test_random_unit(&random) * (box.high[k] - box.low[k]);
        }
        assert_int_equal(whole->ops->restrict_to(whole, &box, &part), QN_OK);
        whole->ops->values(whole, 8, (const double(*)[3])points, values[0]);
        part->ops->values(part, 8, (const double(*)[3])points, values[1]);
        assert_memory_equal(values[0], values[1], sizeof values[0]);
        for (int i = 1; i < 8; ++i) {
            qni_crossing found[2][QNI_CROSSINGS] = {{{0}}};
            int32_t counts[2];
            whole->ops->crossings(whole, points[0], points[i], QNI_CROSSINGS, found[0], &counts[0]);
            part->ops->crossings(part, points[0], points[i], QNI_CROSSINGS, found[1], &counts[1]);
            assert_int_equal(counts[0], counts[1]);
            for (int32_t c = 0; c < counts[0]; ++c)
                assert_memory_equal(&found[0][c].at, &found[1][c].at, sizeof found[0][c].at);
        }
        qn_solid_destroy(part);
    }
    qn_solid_destroy(whole);
    test_model_free(&model);
    test_context_end(context);
}

static void solid_angles_are_right(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int round = 0; round < 200; ++round) {
        qni_panel panel = {.number = 0};
        double p[3], slope[3] = {0, 0, 0};
        for (int n = 0; n < 9; ++n)
            panel.at[n / 3][n % 3] = (float)test_random_gaussian(&random);
        for (int k = 0; k < 3; ++k)
            p[k] = test_random_gaussian(&random);
        double nearest[3], distance = sqrt(qni_panel_nearest(&panel, p, nearest));
        if (distance < 0.05)
            continue;
        qni_panel_angle(&panel, p, slope);
        for (int k = 0; k < 3; ++k) {
            const double step = 1e-5;
            double q[3] = {p[0], p[1], p[2]};
            q[k] += step;
            double up = qni_panel_angle(&panel, q, NULL);
            q[k] -= 2 * step;
            double down = qni_panel_angle(&panel, q, NULL);
            assert_true(fabs((up - down) / (2 * step) - slope[k]) < 1e-4);
        }
    }
    qn_context *context = test_context(1);
    test_model model = {0};
    test_model_ball(&model, zero, 1, 3);
    qni_panel_tree tree = {0};
    for (int64_t n = 0; n < model.triangle_count; ++n) {
        qni_panel panel = {.number = (int32_t)n};
        for (int i = 0; i < 3; ++i)
            memcpy(panel.at[i], model.points[model.triangles[n][i]], sizeof panel.at[i]);
        assert_true(qni_panel_tree_add(context, &tree, &panel));
    }
    assert_true(qni_panel_tree_build(context, &tree, true));
    for (int round = 0; round < 200; ++round) {
        double p[3], length = 0;
        for (int k = 0; k < 3; ++k) {
            p[k] = test_random_gaussian(&random);
            length += p[k] * p[k];
        }
        if (fabs(sqrt(length) - 1) < 0.05)
            continue;
        assert_true(fabs(qni_panel_tree_angle(&tree, p, NULL) - (length < 1)) < 0.02);
    }
    qni_panel_tree_free(context, &tree);
    test_model_free(&model);
    test_context_end(context);
}

static void owners_come_through(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    test_model_box(&model, zero, one, NULL);
    int32_t owners[12];
    for (int n = 0; n < 12; ++n)
        owners[n] = 100 + n / 2;
    qn_mesh_view view;
    memset(&view, 0, sizeof view);
    view.vertex_count = 8;
    view.triangle_count = 12;
    view.positions = model.points[0];
    view.triangles = model.triangles[0];
    view.triangle_owners = owners;
    qn_mesh *mesh;
    qn_solid *solid;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    assert_int_equal(qn_solid_from_mesh(context, mesh, NULL, &solid, NULL, NULL), QN_OK);
    static const double a[3] = {-1, 0.3, 0.4}, b[3] = {2, 0.3, 0.4};
    qni_crossing found[4];
    int32_t count, owner;
    assert_int_equal(solid->ops->crossings(solid, a, b, 4, found, &count), QN_OK);
    assert_int_equal(count, 2);
    assert_int_equal(found[0].owner, 100);
    assert_int_equal(found[1].owner, 101);
    const double top[1][3] = {{0.4, 0.4, 1.25}};
    double gradient[1][3];
    assert_int_equal(solid->ops->gradients(solid, 1, top, gradient, &owner), QN_OK);
    assert_int_equal(owner, 105);
    assert_true(fabs(gradient[0][2] - 1) < 1e-12);
    qn_solid_destroy(solid);
    qn_mesh_destroy(mesh);
    test_model_free(&model);
    test_context_end(context);
}

static void nothing_is_refused(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_model model = {0};
    for (int n = 0; n < 3; ++n)
        test_model_point(&model, n, n, NAN);
    test_model_triangle(&model, 0, 1, 2);
    test_model_triangle(&model, 0, 0, 1);
    qn_mesh *mesh = test_model_mesh(context, &model);
    qn_solid *solid;
    qn_error error = {0};
    assert_int_equal(qn_solid_from_mesh(context, mesh, NULL, &solid, NULL, &error), QN_ERROR_INPUT);
    assert_null(solid);
    assert_non_null(strstr(error.message, "no triangle"));
    assert_int_equal(qn_solid_from_mesh(context, NULL, NULL, &solid, NULL, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_solid_mesh_options options = {0};
    assert_int_equal(qn_solid_from_mesh(context, mesh, &options, &solid, NULL, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_mesh_destroy(mesh);
    test_model_free(&model);
    test_context_end(context);
}

static qn_status build_and_ask(qn_context *context, const qn_mesh_view *view) {
    qn_mesh *mesh;
    qn_solid *solid, *local = NULL;
    qni_crossing found[8];
    int32_t count;
    const qni_box box = {{-0.5, -0.5, -0.5}, {1.5, 0.5, 0.5}};
    QN_TRY(qn_mesh_create(context, view, &mesh, NULL));
    qn_status status = qn_solid_from_mesh(context, mesh, NULL, &solid, NULL, NULL);
    qn_mesh_destroy(mesh);
    QN_TRY(status);
    status = solid->ops->restrict_to(solid, &box, &local);
    if (status == QN_OK)
        status = local->ops->crossings(local, zero, one, 8, found, &count);
    qn_solid_destroy(local);
    qn_solid_destroy(solid);
    return status;
}

static void memory_may_run_out(void **state) {
    (void)state;
    test_model model = {0};
    test_model_ball(&model, zero, 1, 1);
    test_model_turn_round(&model, 20);
    model.triangle_count -= 2;
    qn_mesh_view view;
    memset(&view, 0, sizeof view);
    view.vertex_count = model.point_count;
    view.triangle_count = model.triangle_count;
    view.positions = model.points[0];
    view.triangles = model.triangles[0];
    int64_t failures = 0;
    for (int64_t n = 0; n < 1000; ++n) {
        test_failing failing = {.allocations_left = n, .looks_left = -1};
        qn_context *context = test_failing_context(&failing);
        qn_status status = context ? build_and_ask(context, &view) : QN_ERROR_OUT_OF_MEMORY;
        qn_context_destroy(context);
        assert_int_equal(failing.held, 0);
        if (status == QN_OK)
            break;
        assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
        ++failures;
    }
    assert_true(failures > 15 && failures < 1000);
    test_model_free(&model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_closed_model_is_exact),
        cmocka_unit_test(points_on_faces_edges_and_corners_have_one_side),
        cmocka_unit_test(overlapping_parts_become_one),
        cmocka_unit_test(inside_out_is_turned),
        cmocka_unit_test(holes_are_closed),
        cmocka_unit_test(parts_of_a_soup_answer_as_the_whole),
        cmocka_unit_test(solid_angles_are_right),
        cmocka_unit_test(owners_come_through),
        cmocka_unit_test(nothing_is_refused),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
