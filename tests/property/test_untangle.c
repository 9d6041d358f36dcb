// SPDX-License-Identifier: MIT
/* Untangling: only positions change, what is reported as left is what a check finds, looking at
 * bent quads finds nearly all that looking everywhere does, scans and level sets end without a
 * crossing, meshes without one keep their bytes, and the number of threads does not matter. */
#include "lib/failing.h"
#include "lib/random_volume.h"
#include "lib/test_volume.h"

#include <math.h>

static qn_mesh *surface(qn_context *context, const test_field *field, qn_untangle untangle,
                        qn_surface_report *report) {
    qn_surface_options options = test_field_options(field);
    options.untangle = untangle;
    return test_field_surface_with(context, field, &options, report);
}

static int64_t crossings_of(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    return report.self_intersections;
}

/* Faces, counts and normals are those of the tangled mesh; as many vertices moved as is said. */
static void only_positions_change(const qn_mesh *before, const qn_mesh *after,
                                  const qn_surface_report *report) {
    const qn_mesh_view a = qn_mesh_get_view(before), b = qn_mesh_get_view(after);
    int64_t moved = 0;
    assert_int_equal(a.vertex_count, b.vertex_count);
    assert_int_equal(a.quad_count, b.quad_count);
    if (a.quad_count)
        assert_memory_equal(a.quads, b.quads, (size_t)a.quad_count * 4 * sizeof *a.quads);
    if (a.vertex_count)
        assert_memory_equal(a.normals, b.normals, (size_t)a.vertex_count * 3 * sizeof *a.normals);
    for (int64_t v = 0; v < a.vertex_count; ++v)
        moved += memcmp(a.positions + 3 * v, b.positions + 3 * v, 3 * sizeof(float)) != 0;
    assert_int_equal(moved, report->untangled_vertices);
    assert_int_equal(moved > 0, report->untangled_farthest > 0);
    assert_true(report->crossings_left <= report->crossings);
}

static void random_volumes_are_untangled(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *one = test_context(1), *three = test_context(3);
    int64_t before = 0, found = 0, left = 0, near_found = 0;
    const int64_t count = test_count(150, 3000);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 20);
        qn_surface_report report, again, near;
        qn_mesh *tangled = surface(one, &field, QN_UNTANGLE_OFF, &report);
        assert_int_equal(report.crossings, 0);
        qn_mesh *mesh = surface(one, &field, QN_UNTANGLE_ALL, &report);
        qn_mesh *same = surface(three, &field, QN_UNTANGLE_ALL, &again);
        qn_mesh *nearly = surface(one, &field, QN_UNTANGLE_NEAR, &near);
        const int64_t crossings = crossings_of(one, tangled);
        only_positions_change(tangled, mesh, &report);
        only_positions_change(tangled, nearly, &near);
        assert_int_equal(report.crossings, crossings);
        if (crossings_of(one, mesh) != report.crossings_left)
            fail_msg("%s: %lld pairs cross, %lld are reported as left", field.name,
                     (long long)crossings_of(one, mesh), (long long)report.crossings_left);
        assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(same));
        if (crossings == 0)
            assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(tangled));
        before += crossings;
        found += report.crossings;
        left += report.crossings_left;
        near_found += near.crossings;
        qn_mesh_destroy(nearly);
        qn_mesh_destroy(same);
        qn_mesh_destroy(mesh);
        qn_mesh_destroy(tangled);
        test_field_free(&field);
    }
    printf("%lld volumes: %lld crossing pairs, %lld left; at bent quads %lld were found\n",
           (long long)count, (long long)before, (long long)left, (long long)near_found);
    assert_true(before > 1000);
    assert_true(left * 50 <= found);
    assert_true(near_found * 100 >= found * 99);
    test_context_end(one);
    test_context_end(three);
}

/* Smooth surfaces on samples of their own value: a box on lattice planes, and a plate one sample
 * thick whose two sides lie on each other. */
static void fill_box(test_field *field, int64_t low, int64_t high, int64_t bottom, int64_t top) {
    for (int64_t n = 0; n < field->size[0] * field->size[1] * field->size[2]; ++n) {
        const int64_t x = n % field->size[0], y = n / field->size[0] % field->size[1],
                      z = n / field->size[0] / field->size[1];
        const double out = fmax(fmax((double)(low - x), (double)(x - high)),
                                fmax((double)(low - y), (double)(y - high)));
        field->values[n] = -fmax(out, fmax((double)(bottom - z), (double)(z - top)));
    }
}

static void samples_at_the_isovalue_are_parted(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    const int64_t tops[] = {12, 8};
    for (int n = 0; n < 4; ++n) {
        test_field field = test_field_make(24, 24, 20);
        fill_box(&field, 4, 18, 8, tops[n % 2]);
        field.inside = QN_INSIDE_ABOVE;
        if (n >= 2) { /* the same surface with its sides swapped: a gap instead of a plate */
            field.inside = QN_INSIDE_BELOW;
            field.open = true;
        }
        test_field_prepare(&field);
        qn_surface_report report;
        qn_mesh *mesh = surface(context, &field, QN_UNTANGLE_NEAR, &report);
        assert_true(tops[n % 2] != 8 || report.crossings > 0);
        assert_int_equal(report.crossings_left, 0);
        assert_int_equal(crossings_of(context, mesh), 0);
        assert_true(report.untangled_farthest < 1);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    test_context_end(context);
}

static void files_are_clean(void **state) {
    (void)state;
    const struct {
        const char *name;
        double iso;
        qn_inside inside;
    } files[] = {{"vdb/smoke-blosc.nvdb", 0.5, QN_INSIDE_ABOVE},
                 {"vdb/smoke-blosc.nvdb", 0.1, QN_INSIDE_ABOVE},
                 {"volumes/tooth_103x94x161_u8.nrrd", 100, QN_INSIDE_ABOVE}};
    qn_context *context = test_context(2);
    for (size_t n = 0; n < sizeof files / sizeof *files; ++n) {
        char path[4096];
        qn_volume *volume = NULL;
        qn_error error;
        if (!test_data_path(files[n].name, path, sizeof path))
            continue;
        if (qn_volume_read(context, path, NULL, &volume, &error) != QN_OK) {
            printf("skipped: %s\n", error.message);
            continue;
        }
        qn_surface_options options;
        qn_surface_options_init(&options);
        options.isovalues = &files[n].iso;
        options.isovalue_count = 1;
        options.inside = files[n].inside;
        options.untangle = QN_UNTANGLE_NEAR;
        qn_surface_report report;
        qn_mesh *mesh;
        assert_int_equal(qn_surface(context, volume, &options, &mesh, &report, &error), QN_OK);
        assert_true(report.crossings > 0);
        const int64_t left = crossings_of(context, mesh);
        printf("%s at %g: %lld crossing pairs, %lld left\n", files[n].name, files[n].iso,
               (long long)report.crossings, (long long)left);
        assert_int_equal(left, 0);
        qn_mesh_destroy(mesh);
        qn_volume_destroy(volume);
    }
    test_context_end(context);
}

static qn_status troubled(test_failing *failing, const test_field *field) {
    const test_failing asked = *failing;
    *failing = (test_failing){-1, -1, 0};
    qn_context *context = test_failing_context(failing);
    assert_non_null(context);
    qn_volume *volume = test_field_volume(context, field);
    qn_surface_options options = test_field_options(field);
    options.untangle = QN_UNTANGLE_ALL;
    qn_mesh *mesh = NULL;
    failing->allocations_left = asked.allocations_left;
    failing->looks_left = asked.looks_left;
    const qn_status status = qn_surface(context, volume, &options, &mesh, NULL, NULL);
    assert_int_equal(status == QN_OK, mesh != NULL);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
    assert_int_equal(failing->held, 0);
    return status;
}

static void failures_leave_nothing(void **state) {
    (void)state;
    test_random random = {test_seed()};
    test_field field = test_field_make(7, 8, 6);
    test_random_fill(&field, &random, TEST_SMALL_INTEGERS);
    test_field_prepare(&field);
    for (int cancels = 0; cancels < 2; ++cancels) {
        int64_t n = 0;
        qn_status status;
        do {
            test_failing failing = {cancels ? -1 : n, cancels ? n : -1, 0};
            ++n;
            status = troubled(&failing, &field);
            assert_true(status == QN_OK ||
                        status == (cancels ? QN_ERROR_CANCELLED : QN_ERROR_OUT_OF_MEMORY));
        } while (status != QN_OK);
        printf("%s at %lld places\n", cancels ? "cancelled" : "an allocation failed",
               (long long)(n - 1));
        assert_true(n > 20);
    }
    test_field_free(&field);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_volumes_are_untangled),
        cmocka_unit_test(samples_at_the_isovalue_are_parted),
        cmocka_unit_test(files_are_clean),
        cmocka_unit_test(failures_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
