// SPDX-License-Identifier: MIT
/* A volume turned or mirrored in all 48 ways, its matrix turned back, gives the same solid: the
 * same counts, connectivity by the reference, and the same area and volume up to the places of the
 * vertices on their branches; never a mesh turned inside out. */
#include "lib/analytic.h"
#include "lib/mesh_measure.h"
#include "lib/random_volume.h"
#include "lib/reference_match.h"

#include <math.h>

/* Index axis a of the turned field runs along axis order[a] of the first, backward when flipped. */
static test_field turned(const test_field *field, const int order[3], int flips) {
    test_field other =
        test_field_make(field->size[order[0]], field->size[order[1]], field->size[order[2]]);
    other.iso = field->iso, other.inside = field->inside, other.open = field->open;
    snprintf(other.name, sizeof other.name, "%.30s axes %d%d%d flips %d", field->name, order[0],
             order[1], order[2], flips);
    int64_t step[3] = {1, field->size[0], field->size[0] * field->size[1]}, place[3];
    double *next = other.values;
    for (place[2] = 0; place[2] < other.size[2]; ++place[2])
        for (place[1] = 0; place[1] < other.size[1]; ++place[1])
            for (place[0] = 0; place[0] < other.size[0]; ++place[0]) {
                int64_t at = 0;
                for (int a = 0; a < 3; ++a)
                    at +=
                        step[order[a]] * (flips >> a & 1 ? other.size[a] - 1 - place[a] : place[a]);
                *next++ = field->values[at];
            }
    memcpy(other.matrix, field->matrix, sizeof other.matrix);
    for (int r = 0; r < 3; ++r)
        for (int a = 0; a < 3; ++a) {
            double column = field->matrix[r][order[a]];
            other.matrix[r][a] = flips >> a & 1 ? -column : column;
            if (flips >> a & 1)
                other.matrix[r][3] += column * (double)(other.size[a] - 1);
        }
    test_field_prepare(&other);
    return other;
}

typedef struct figures {
    int64_t vertices, quads, ambiguous, tied;
    double area, volume;
} figures;

static figures figures_of(qn_context *context, const test_field *field) {
    qn_surface_report report;
    qn_mesh *mesh = test_field_surface(context, field, &report);
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    figures result = {
        report.vertices, report.quads, report.ambiguous_faces, report.tied_faces, 0, 0};
    test_mesh_area_volume(mesh, &result.area, &result.volume);
    test_match_free(&match);
    test_reference_free(&reference);
    qn_mesh_destroy(mesh);
    return result;
}

/* How much the choice of points on the branches may move area and volume depends on the data. */
static void check_field(qn_context *context, const test_field *field, double tolerance,
                        double *largest) {
    static const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    figures first = figures_of(context, field);
    assert_true(first.volume > 0);
    for (int way = 0; way < 48; ++way) {
        test_field other = turned(field, orders[way / 8], way % 8);
        figures now = figures_of(context, &other);
        double area = fabs(now.area / first.area - 1), volume = fabs(now.volume / first.volume - 1);
        *largest = fmax(*largest, fmax(area, volume));
        if (now.vertices != first.vertices || now.quads != first.quads ||
            now.ambiguous != first.ambiguous || now.tied != first.tied || !(now.volume > 0) ||
            !(area <= tolerance) || !(volume <= tolerance))
            fail_msg("%s: %lld vertices, %lld quads, area %.9g, volume %.9g; unturned %lld, %lld, "
                     "%.9g, %.9g",
                     other.name, (long long)now.vertices, (long long)now.quads, now.area,
                     now.volume, (long long)first.vertices, (long long)first.quads, first.area,
                     first.volume);
        test_field_free(&other);
    }
}

static void smooth_surfaces_stay_where_they_are(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    for (const test_analytic *analytic = test_analytic_all(); analytic->name; ++analytic) {
        double largest = 0;
        test_field field = test_field_make(24, 24, 24);
        double *samples = test_analytic_samples(analytic, 24, QN_F64);
        memcpy(field.values, samples, 24 * 24 * 24 * sizeof *samples);
        free(samples);
        snprintf(field.name, sizeof field.name, "%s", analytic->name);
        field.inside = QN_INSIDE_BELOW;
        field.matrix[0][1] = 0.3, field.matrix[1][0] = -0.2, field.matrix[2][2] = 1.4;
        test_field_prepare(&field);
        check_field(context, &field, 1e-3, &largest);
        printf("%s: largest relative difference of area or volume %.2g\n", analytic->name, largest);
        test_field_free(&field);
    }
    test_context_end(context);
}

static void all_48_ways_give_the_same_solid(void **state) {
    (void)state;
    static const test_kind kinds[] = {TEST_GAUSSIAN, TEST_SMOOTHED_NOISE, TEST_HEAVY_TAILED,
                                      TEST_CHECKERBOARD};
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    double largest = 0;
    for (int64_t i = 0; i < test_count(8, 60); ++i) {
        test_field field =
            test_field_make(test_random_range(&random, 4, 13), test_random_range(&random, 4, 13),
                            test_random_range(&random, 4, 13));
        test_random_fill(&field, &random, kinds[i % 4]);
        field.inside = i & 4 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_random_matrix(&field, &random);
        test_field_prepare(&field);
        check_field(context, &field, 0.05, &largest);
        test_field_free(&field);
    }
    printf("largest relative difference of area or volume: %.2g\n", largest);
    test_context_end(context);
}

/* Ties: the counts and the solid's side stay, though a tied point may be found in another place. */
static void ties_are_turned_alike(void **state) {
    (void)state;
    static const test_kind kinds[] = {TEST_SMALL_INTEGERS, TEST_BINARY, TEST_SYMMETRIC,
                                      TEST_THOUSAND};
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    double largest = 0;
    for (int64_t i = 0; i < test_count(4, 40); ++i) {
        test_field field = test_field_make(6, 9, 7);
        test_random_fill(&field, &random, kinds[i % 4]);
        test_field_prepare(&field);
        check_field(context, &field, 0.1, &largest);
        test_field_free(&field);
    }
    printf("with ties, largest relative difference of area or volume: %.2g\n", largest);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smooth_surfaces_stay_where_they_are),
        cmocka_unit_test(all_48_ways_give_the_same_solid),
        cmocka_unit_test(ties_are_turned_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
