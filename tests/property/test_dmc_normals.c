// SPDX-License-Identifier: MIT
/* Normals have unit length and point out of the solid: of a ball in world space, sampled through
 * any matrix, sheared and mirrored ones too, for either side inside; and of noise, wherever they
 * come from. */
#include "lib/mesh_measure.h"
#include "lib/random_volume.h"
#include "lib/trilinear.h"

#include <math.h>

/* The distance from a ball round the middle of the volume that just fits. Returns a lower bound of
 * its radius in cells, in whatever direction: a sheared ball is thin across the diagonal. */
static double fill_ball(test_field *field, double centre[3]) {
    const double middle[3] = {(double)(field->size[0] - 1) / 2, (double)(field->size[1] - 1) / 2,
                              (double)(field->size[2] - 1) / 2};
    double radius = HUGE_VAL, stretch = 0;
    test_to_world(field, middle, centre);
    for (int a = 0; a < 3; ++a) { /* an index grows at most so much a unit of length */
        const double *n = field->inverse[a];
        radius = fmin(radius, (middle[a] - 1) / sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]));
        for (int b = 0; b < 3; ++b)
            stretch += field->matrix[a][b] * field->matrix[a][b];
    }
    double *next = field->values;
    for (int64_t k = 0; k < field->size[2]; ++k)
        for (int64_t j = 0; j < field->size[1]; ++j)
            for (int64_t i = 0; i < field->size[0]; ++i) {
                const double index[3] = {(double)i, (double)j, (double)k};
                double p[3], sum = 0;
                test_to_world(field, index, p);
                for (int a = 0; a < 3; ++a)
                    sum += (p[a] - centre[a]) * (p[a] - centre[a]);
                *next++ = sqrt(sum) - radius;
            }
    return radius / sqrt(stretch);
}

/* Cosine of the angle between a normal and the direction away from the centre. */
static double outwardness(const float *place, const float *normal, const double centre[3]) {
    double along = 0, away = 0;
    for (int a = 0; a < 3; ++a) {
        double d = (double)place[a] - centre[a];
        along += d * (double)normal[a];
        away += d * d;
    }
    return along / sqrt(away);
}

static void check_length(const test_field *field, const float *normal) {
    double length =
        sqrt((double)normal[0] * (double)normal[0] + (double)normal[1] * (double)normal[1] +
             (double)normal[2] * (double)normal[2]);
    if (!(fabs(length - 1) < 1e-5))
        fail_msg("%s: a normal of length %.9g", field->name, length);
}

static void normals_of_balls_point_away(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    double least = 1;
    for (int64_t i = 0; i < test_count(40, 400); ++i) {
        test_field field =
            test_field_make(test_random_range(&random, 24, 40), test_random_range(&random, 24, 40),
                            test_random_range(&random, 24, 40));
        double centre[3];
        do {
            test_field_random_matrix(&field, &random);
            test_field_prepare(&field);
        } while (fill_ball(&field, centre) < 4);
        snprintf(field.name, sizeof field.name, "ball, number %lld", (long long)i);
        const double sign = i & 1 ? 1 : -1;
        field.inside = i & 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        field.open = true; /* with the inside out there, no box round it */
        test_field_prepare(&field);
        qn_mesh *mesh = test_field_surface(context, &field, NULL);
        qn_mesh_view view = qn_mesh_get_view(mesh);
        double area, volume;
        test_mesh_area_volume(mesh, &area, &volume);
        assert_true(view.vertex_count > 100);
        assert_true(sign * volume > 0);
        for (int64_t v = 0; v < view.vertex_count; ++v) {
            check_length(&field, view.normals + 3 * v);
            double cosine =
                sign * outwardness(view.positions + 3 * v, view.normals + 3 * v, centre);
            least = fmin(least, cosine);
            if (!(cosine > 0.998))
                fail_msg("%s: vertex %lld has a normal off by %.1f degrees", field.name,
                         (long long)v, acos(cosine) * 180 / 3.14159265358979);
        }
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("largest angle %.2f degrees\n", acos(least) * 180 / 3.14159265358979);
    test_context_end(context);
}

static void normals_of_noise_have_unit_length(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t zero_gradients = 0;
    for (int64_t i = 0; i < test_count(100, 1000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 16);
        qn_surface_report report;
        qn_mesh *mesh = test_field_surface(context, &field, &report);
        qn_mesh_view view = qn_mesh_get_view(mesh);
        for (int64_t v = 0; v < view.vertex_count; ++v)
            check_length(&field, view.normals + 3 * v);
        zero_gradients += report.zero_gradients;
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld normals taken from the polygon\n", (long long)zero_gradients);
    test_context_end(context);
}

/* Repair, simplification and relaxation bring the normals along. */
static void normals_stay_through_repair_and_simplification(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    int64_t merged = 0, repaired = 0;
    for (int64_t i = 0; i < test_count(30, 300); ++i) {
        const bool ball = i % 2 == 0;
        double centre[3];
        test_field field = test_field_make(30, 32, 28);
        if (ball) {
            do {
                test_field_random_matrix(&field, &random);
                test_field_prepare(&field);
            } while (fill_ball(&field, centre) < 6);
            field.inside = QN_INSIDE_BELOW;
            test_field_prepare(&field);
        } else {
            test_field_free(&field);
            field = test_random_field(&random, TEST_GAUSSIAN, 24);
        }
        qn_volume *volume = test_field_volume(context, &field);
        qn_surface_options options = test_field_options(&field);
        qn_surface_report report;
        qn_mesh *mesh;
        options.keep_doubled = false;
        options.simplify = true;
        options.relax = i % 4 < 2 ? 0 : 2;
        assert_int_equal(qn_surface(context, volume, &options, &mesh, &report, NULL), QN_OK);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        assert_true(view.normals != NULL || view.vertex_count == 0);
        for (int64_t v = 0; v < view.vertex_count; ++v) {
            check_length(&field, view.normals + 3 * v);
            if (ball && outwardness(view.positions + 3 * v, view.normals + 3 * v, centre) < 0.97)
                fail_msg("%s: normal %lld does not point away", field.name, (long long)v);
        }
        merged += report.merged_quads;
        repaired += report.repaired_edges;
        qn_mesh_destroy(mesh);
        qn_volume_destroy(volume);
        test_field_free(&field);
    }
    printf("%lld quads merged, %lld edges repaired\n", (long long)merged, (long long)repaired);
    assert_true(merged > 100 && repaired > 10);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normals_stay_through_repair_and_simplification),
        cmocka_unit_test(normals_of_balls_point_away),
        cmocka_unit_test(normals_of_noise_have_unit_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
