// SPDX-License-Identifier: MIT
/* Sharp edges come back from sampled distances: turned boxes in clamped narrow bands, the cube of
 * the data folder; nothing sharp is made up in smooth ones, nor in scans. */
#include "lib/random_volume.h"
#include "lib/test_solid.h"

#include <math.h>

enum { SIDE = 40 };

typedef struct scene {
    test_frame frame; /* of the box, about the middle, voxels */
    double half[3];
    double outside; /* 1: the box, -1: what is not the box */
} scene;

static void to_body(const scene *s, const double p[3], double q[3]) {
    for (int k = 0; k < 3; ++k) {
        q[k] = 0;
        for (int m = 0; m < 3; ++m)
            q[k] += s->frame.turn[k][m] * (p[m] - s->frame.origin[m]);
    }
}

/* Exact distance from a box. */
static double distance(const scene *s, const double p[3]) {
    double q[3], square = 0, most = -1e9;
    to_body(s, p, q);
    for (int k = 0; k < 3; ++k) {
        const double off = fabs(q[k]) - s->half[k];
        square += off > 0 ? off * off : 0;
        most = fmax(most, off);
    }
    return s->outside * (most > 0 ? sqrt(square) : most);
}

/* How far a point is from the nearest edge of the box, and from its surface. */
static void measure(const scene *s, const float *place, double *edge, double *surface) {
    const double p[3] = {(double)place[0], (double)place[1], (double)place[2]};
    double q[3], best = 1e9;
    to_body(s, p, q);
    for (int axis = 0; axis < 3; ++axis) { /* the four edges along it */
        double square = 0;
        for (int k = 0; k < 3; ++k) {
            const double off =
                k == axis ? fmax(fabs(q[k]) - s->half[k], 0) : fabs(q[k]) - s->half[k];
            square += off * off;
        }
        best = fmin(best, sqrt(square));
    }
    *edge = best;
    *surface = fabs(distance(s, p));
}

static scene make_scene(test_random *random) {
    scene s = {.frame = test_random_frame(random, 0), .outside = 1};
    for (int k = 0; k < 3; ++k) {
        s.frame.origin[k] = SIDE / 2.0 + test_random_unit(random);
        s.half[k] = 7 + 4 * test_random_unit(random);
    }
    return s;
}

static test_field sample(const scene *s, double band) {
    test_field field = test_field_make(SIDE, SIDE, SIDE);
    for (int64_t n = 0; n < (int64_t)SIDE * SIDE * SIDE; ++n) {
        const double p[3] = {(double)(n % SIDE), (double)(n / SIDE % SIDE),
                             (double)(n / SIDE / SIDE)};
        field.values[n] = fmax(-band, fmin(band, distance(s, p)));
    }
    field.inside = QN_INSIDE_BELOW;
    test_field_prepare(&field);
    return field;
}

static qn_mesh *surface(qn_context *context, const test_field *field,
                        const qn_solid_surface_options *options, qn_solid_surface_report *report) {
    qn_volume *volume = test_field_volume(context, field);
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface_adaptive(context, volume, field->iso, field->inside, options, &mesh, report,
                            &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_volume_destroy(volume);
    qn_mesh_report check;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &check, NULL), QN_OK);
    assert_true(check.closed && check.manifold && check.oriented);
    assert_int_equal(check.self_intersections, 0);
    return mesh;
}

static void boxes_have_their_edges(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    double worst_edge = 0, worst_surface = 0, least_length = 1e9;
    int64_t crease_vertices = 0, near = 0, triangles = 0;
    const int64_t count = test_count(4, 60);
    for (int64_t n = 0; n < count; ++n) {
        scene s = make_scene(&random);
        s.outside = n % 3 == 2 ? -1 : 1;
        test_field field = sample(&s, 3);
        qn_solid_surface_options options;
        qn_solid_surface_options_init(&options);
        options.creases = s.outside < 0 ? QN_CREASES_ON : QN_CREASES_AUTO;
        options.tolerance = 0.1;
        qn_solid_surface_report report;
        qn_mesh *mesh = surface(context, &field, &options, &report);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        double length = 0;
        for (int64_t e = 0; e < view.crease_edge_count; ++e) {
            double square = 0;
            for (int k = 0; k < 3; ++k) {
                const double d = (double)view.positions[3 * view.crease_edges[2 * e] + k] -
                                 (double)view.positions[3 * view.crease_edges[2 * e + 1] + k];
                square += d * d;
            }
            length += sqrt(square);
            for (int k = 0; k < 2; ++k) {
                double edge, off;
                measure(&s, view.positions + 3 * view.crease_edges[2 * e + k], &edge, &off);
                if (s.outside < 0 && edge > 2) /* the volume's own border */
                    continue;
                worst_edge = fmax(worst_edge, edge);
                near += edge < 0.05;
                ++crease_vertices;
            }
        }
        for (int64_t v = 0; v < view.vertex_count; ++v) {
            double edge, off;
            measure(&s, view.positions + 3 * v, &edge, &off);
            if (s.outside > 0)
                worst_surface = fmax(worst_surface, off);
        }
        const double edges = 8 * (s.half[0] + s.half[1] + s.half[2]);
        if (s.outside > 0)
            least_length = fmin(least_length, length / edges);
        triangles += report.triangles;
        printf("box %lld: %lld triangles, creases %.3f of its edges, %lld sharp crossings\n",
               (long long)n, (long long)report.triangles, length / edges,
               (long long)report.sharp_crossings);
        assert_true(report.creases);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld crease ends, %.2f %% within 0.05 voxel of the true edges, farthest %.3f; vertices "
           "at most %.3f off the surface; least share of edges found %.3f\n",
           (long long)crease_vertices, 100.0 * (double)near / (double)crease_vertices, worst_edge,
           worst_surface, least_length);
    assert_true(near > 0.8 * (double)crease_vertices);
    assert_true(worst_edge < 0.25);
    assert_true(least_length > 0.7);
    test_context_end(context);
}

/* The edges of a cube that is upright: all of its twelve edges, whole, and few triangles. */
static void the_level_set_of_a_cube_is_a_cube(void **state) {
    (void)state;
    static const double half = 5.5, voxel = 0.05;
    char path[512];
    if (!test_data_path("vdb/cube.vdb", path, sizeof path))
        return;
    qn_context *context = test_context(2);
    qn_volume *volume;
    qn_error error;
    const qn_status status = qn_volume_read(context, path, NULL, &volume, &error);
    if (status == QN_ERROR_UNSUPPORTED) {
        printf("skipped: %s\n", error.message);
        test_context_end(context);
        return;
    }
    assert_int_equal(status, QN_OK);
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.creases = QN_CREASES_AUTO;
    options.tolerance = 0.1 * voxel;
    qn_solid_surface_report report;
    qn_mesh *mesh;
    assert_int_equal(
        qn_surface_adaptive(context, volume, 0, QN_INSIDE_BELOW, &options, &mesh, &report, &error),
        QN_OK);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    double length = 0, worst = 0;
    bool corners[8] = {false};
    for (int64_t e = 0; e < view.crease_edge_count; ++e) {
        double square = 0;
        for (int end = 0; end < 2; ++end) {
            const float *p = view.positions + 3 * view.crease_edges[2 * e + end];
            double off[3], most = 0, sum = 0;
            int corner = 0;
            for (int k = 0; k < 3; ++k) {
                off[k] = fabs(fabs((double)p[k]) - half);
                most = fmax(most, off[k]);
                sum += off[k];
                corner |= (p[k] > 0) << k;
            }
            worst = fmax(worst, sum - most); /* the two walls that it must lie on */
            if (most < 0.05 * voxel)
                corners[corner] = true;
        }
        for (int k = 0; k < 3; ++k) {
            const double d = (double)view.positions[3 * view.crease_edges[2 * e] + k] -
                             (double)view.positions[3 * view.crease_edges[2 * e + 1] + k];
            square += d * d;
        }
        length += sqrt(square);
    }
    int found = 0;
    for (int n = 0; n < 8; ++n)
        found += corners[n];
    printf(
        "cube.vdb: %lld triangles, %.4f of its edges tagged, %d corners, crease ends at most %.5f "
        "voxel off\n",
        (long long)report.triangles, length / (24 * half), found, worst / voxel);
    assert_true(report.creases && report.triangles < 2000);
    assert_int_equal(found, 8);
    assert_true(worst < 0.05 * voxel && fabs(length / (24 * half) - 1) < 1e-3);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
}

/* A small ball is round, and what is no distance has no creases. */
static void nothing_sharp_is_made_up(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    test_field ball = test_field_make(24, 24, 24);
    for (int64_t n = 0; n < 24 * 24 * 24; ++n) {
        const double x = (double)(n % 24) - 11.3, y = (double)(n / 24 % 24) - 11.6,
                     z = (double)(n / 576) - 11.8;
        ball.values[n] = fmax(-3, fmin(3, sqrt(x * x + y * y + z * z) - 7));
    }
    ball.inside = QN_INSIDE_BELOW;
    test_field_prepare(&ball);
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.creases = QN_CREASES_ON;
    qn_solid_surface_report report;
    qn_mesh *mesh = surface(context, &ball, &options, &report);
    assert_int_equal(report.crease_edges, 0);
    qn_mesh_destroy(mesh);
    test_field_free(&ball);
    options.creases = QN_CREASES_AUTO;
    for (int n = 0; n < 4; ++n) {
        test_field field = test_field_make(20, 20, 20);
        test_random_fill(&field, &random, n & 1 ? TEST_SMOOTHED_NOISE : TEST_GAUSSIAN);
        field.inside = QN_INSIDE_BELOW;
        test_field_prepare(&field);
        mesh = surface(context, &field, &options, &report);
        assert_false(report.creases);
        assert_int_equal(report.crease_edges, 0);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_have_their_edges),
        cmocka_unit_test(the_level_set_of_a_cube_is_a_cube),
        cmocka_unit_test(nothing_sharp_is_made_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
