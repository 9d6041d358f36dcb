// SPDX-License-Identifier: MIT
/* Cubical Marching Squares on volumes: whatever the samples, the mesh is closed, 2-manifold,
 * oriented and free of self-intersections, adaptive or not, and the same for every thread count. */
#include "lib/random_volume.h"

#include <math.h>

/* Axes to axes: any order, any signs, any spacing. */
static void set_aligned_matrix(test_field *field, test_random *random) {
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                     {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const int *order = orders[test_random_range(random, 0, 5)];
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k)
            field->matrix[row][k] = 0;
        field->matrix[row][3] = 20 * test_random_unit(random) - 10;
    }
    for (int k = 0; k < 3; ++k)
        field->matrix[order[k]][k] =
            (test_random_range(random, 0, 1) ? 1 : -1) * (0.3 + 3 * test_random_unit(random));
    test_field_prepare(field);
}

static qn_mesh *surface(qn_context *context, const test_field *field,
                        const qn_solid_surface_options *options, qn_solid_surface_report *report) {
    qn_volume *volume = test_field_volume(context, field);
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface_adaptive(context, volume, field->iso, field->inside, options, &mesh, report,
                            &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    qn_volume_destroy(volume);
    return mesh;
}

static qn_solid_surface_options any_options(const test_field *field, test_random *random) {
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.open = field->open;
    options.uniform = test_random_range(random, 0, 2) == 0;
    options.no_features = test_random_range(random, 0, 2) == 0;
    options.creases = test_random_range(random, 0, 7) == 0 ? QN_CREASES_ON : QN_CREASES_OFF;
    options.base = 1 << test_random_range(random, 0, 3);
    options.tolerance = test_random_range(random, 0, 1) ? 0.3 * test_random_unit(random) : 0;
    return options;
}

typedef struct tally {
    int64_t meshes, triangles, coarse, moved, nested;
} tally;

static void check_mesh(qn_context *context, const test_field *field, int64_t number,
                       const qn_mesh *mesh, const qn_solid_surface_report *report) {
    qn_mesh_report found;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &found, NULL), QN_OK);
    if ((!field->open && !found.closed) || (!field->open && !found.manifold) || !found.oriented ||
        found.nonmanifold_edges || found.self_intersections || found.degenerate_faces ||
        found.nonfinite_vertices || report->unresolved_cells ||
        (found.triangle_count > 0 && !field->open && !(found.volume > 0)))
        fail_msg("%s, number %lld: closed %d, manifold %d, oriented %d, %lld self-intersections, "
                 "%lld degenerate faces, %lld unresolved cells, volume %g",
                 field->name, (long long)number, found.closed, found.manifold, found.oriented,
                 (long long)found.self_intersections, (long long)found.degenerate_faces,
                 (long long)report->unresolved_cells, found.volume);
}

static void any_volume_gives_a_clean_mesh(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(1), *other = test_context(3);
    tally sum = {0};
    for (int64_t n = 0; n < test_count(300, 6000); ++n) {
        test_random random = {seed + (uint64_t)n};
        test_field field = test_random_field(&random, (test_kind)(n % TEST_KIND_COUNT), 12);
        set_aligned_matrix(&field, &random);
        const qn_solid_surface_options options = any_options(&field, &random);
        qn_solid_surface_report report;
        qn_mesh *mesh = surface(context, &field, &options, &report);
        check_mesh(context, &field, n, mesh, &report);
        assert_false(report.rounded);
        if (n % 8 == 0) {
            qn_mesh *again = surface(other, &field, &options, NULL);
            assert_true(test_hash_mesh(mesh) == test_hash_mesh(again));
            qn_mesh_destroy(again);
        }
        ++sum.meshes;
        sum.triangles += report.triangles;
        sum.coarse += report.leaves - report.leaves_by_level[0];
        sum.moved += report.moved_loops;
        sum.nested += report.nested_cells;
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld meshes, %lld triangles, %lld coarse leaves, %lld moved loops, %lld nested cells\n",
           (long long)sum.meshes, (long long)sum.triangles, (long long)sum.coarse,
           (long long)sum.moved, (long long)sum.nested);
    assert_true(sum.coarse > 0);
    test_context_end(context);
    test_context_end(other);
}

/* A ball and a slab: flat parts come out coarse, everything near the true surface. */
static double ball(const double p[3]) {
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 11;
}

static double slab(const double p[3]) {
    return fabs(0.6 * p[0] + 0.8 * p[2]) - 4.3;
}

static void fill(test_field *field, double (*distance)(const double p[3])) {
    for (int64_t z = 0; z < field->size[2]; ++z)
        for (int64_t y = 0; y < field->size[1]; ++y)
            for (int64_t x = 0; x < field->size[0]; ++x) {
                const double p[3] = {(double)x - 15.5, (double)y - 15.5, (double)z - 15.5};
                field->values[(z * field->size[1] + y) * field->size[0] + x] = distance(p);
            }
    field->inside = QN_INSIDE_BELOW;
    for (int row = 0; row < 3; ++row)
        field->matrix[row][3] = -15.5;
    test_field_prepare(field);
}

static void flat_parts_are_coarse(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    double (*const shapes[2])(const double p[3]) = {ball, slab};
    for (int shape = 0; shape < 2; ++shape) {
        test_field field = test_field_make(32, 32, 32);
        fill(&field, shapes[shape]);
        qn_solid_surface_options options;
        qn_solid_surface_options_init(&options);
        options.tolerance = shape ? 0.02 : 0.15;
        qn_solid_surface_report adaptive, uniform;
        qn_mesh *mesh = surface(context, &field, &options, &adaptive);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        double worst = 0;
        for (int64_t v = 0; v < view.vertex_count; ++v) {
            const double p[3] = {(double)view.positions[3 * v], (double)view.positions[3 * v + 1],
                                 (double)view.positions[3 * v + 2]};
            if (fabs(p[0]) < 15 && fabs(p[1]) < 15 && fabs(p[2]) < 15)
                worst = fmax(worst, fabs(shapes[shape](p)));
        }
        check_mesh(context, &field, shape, mesh, &adaptive);
        qn_mesh_destroy(mesh);
        options.uniform = true;
        mesh = surface(context, &field, &options, &uniform);
        qn_mesh_destroy(mesh);
        printf("%s: %lld triangles, %lld uniform; vertices at most %.4f off\n",
               shape ? "slab" : "ball", (long long)adaptive.triangles, (long long)uniform.triangles,
               worst);
        assert_true(worst < 0.2);
        assert_true(adaptive.triangles < uniform.triangles / 2);
        test_field_free(&field);
    }
    test_context_end(context);
}

/* A turned matrix moves the mesh after it was made. */
static void a_turned_volume_is_moved(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(1);
    int64_t crossing = 0, meshes = 0;
    for (int64_t n = 0; n < test_count(60, 1000); ++n) {
        test_random random = {seed + (uint64_t)n};
        test_field field = test_random_field(&random, TEST_SMOOTHED_NOISE, 12);
        test_field_random_matrix(&field, &random);
        field.open = false;
        test_field_prepare(&field);
        const qn_solid_surface_options options = any_options(&field, &random);
        qn_solid_surface_report report;
        qn_mesh *mesh = surface(context, &field, &options, &report);
        qn_mesh_report found;
        assert_int_equal(qn_mesh_check(context, mesh, NULL, &found, NULL), QN_OK);
        assert_true(report.rounded && found.closed && found.manifold && found.oriented);
        assert_true(found.triangle_count == 0 || found.volume > 0);
        crossing += found.self_intersections > 0;
        ++meshes;
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld turned volumes, %lld with self-intersections by the last rounding\n",
           (long long)meshes, (long long)crossing);
    assert_true(crossing * 20 <= meshes);
    test_context_end(context);
}

static void options_that_make_no_sense_are_refused(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_field field = test_field_make(3, 3, 3);
    test_field_prepare(&field);
    qn_volume *volume = test_field_volume(context, &field);
    qn_solid_surface_options options;
    qn_mesh *mesh;
    qn_error error;
    qn_solid_surface_options_init(&options);
    options.depth = 7;
    assert_int_equal(
        qn_surface_adaptive(context, volume, 0, QN_INSIDE_BELOW, &options, &mesh, NULL, &error),
        QN_ERROR_INVALID_ARGUMENT);
    qn_solid_surface_options_init(&options);
    options.has_box = true;
    assert_int_equal(
        qn_surface_adaptive(context, volume, 0, QN_INSIDE_BELOW, &options, &mesh, NULL, &error),
        QN_ERROR_INVALID_ARGUMENT);
    assert_int_equal(qn_surface_adaptive(context, volume, (double)NAN, QN_INSIDE_BELOW, NULL, &mesh,
                                         NULL, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_volume_destroy(volume);
    test_field_free(&field);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_volume_gives_a_clean_mesh),
        cmocka_unit_test(flat_parts_are_coarse),
        cmocka_unit_test(a_turned_volume_is_moved),
        cmocka_unit_test(options_that_make_no_sense_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
