// SPDX-License-Identifier: MIT
/* Untangling: only positions change, what is reported as left is what a check finds, looking at
 * suspects finds all that looking everywhere does, of meshes as emitted, simplified and relaxed;
 * scans and level sets end without a crossing, meshes without one keep their bytes, and the number
 * of threads does not matter. */
#include "lib/failing.h"
#include "lib/random_volume.h"
#include "lib/test_volume.h"
#include "mesh/untangle.h"

#include <math.h>
#include <string.h>

/* `improved`: 0 not at all, 1 simplified, 2 relaxed as well. */
static qn_mesh *surface(qn_context *context, const test_field *field, int improved,
                        qn_untangle untangle, qn_surface_report *report) {
    qn_surface_options options = test_field_options(field);
    options.untangle = untangle;
    options.simplify = improved > 0;
    options.relax = improved > 1 ? 2 : 0;
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
    int64_t before = 0, found = 0, left = 0;
    const int64_t count = test_count(150, 3000);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 20);
        const int improved = (int)(i / TEST_KIND_COUNT % 3);
        qn_surface_report report, again, all;
        qn_mesh *tangled = surface(one, &field, improved, QN_UNTANGLE_OFF, &report);
        assert_int_equal(report.crossings, 0);
        qn_mesh *mesh = surface(one, &field, improved, QN_UNTANGLE_ON, &report);
        qn_mesh *same = surface(three, &field, improved, QN_UNTANGLE_ON, &again);
        qn_mesh *by_all = surface(one, &field, improved, QN_UNTANGLE_ALL, &all);
        const int64_t crossings = crossings_of(one, tangled);
        only_positions_change(tangled, mesh, &report);
        assert_int_equal(report.crossings, crossings);
        assert_int_equal(all.crossings, crossings);
        if (crossings_of(one, mesh) != report.crossings_left)
            fail_msg("%s: %lld pairs cross, %lld are reported as left", field.name,
                     (long long)crossings_of(one, mesh), (long long)report.crossings_left);
        assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(same));
        assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(by_all));
        if (crossings == 0)
            assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(tangled));
        before += crossings;
        found += report.crossings;
        left += report.crossings_left;
        qn_mesh_destroy(by_all);
        qn_mesh_destroy(same);
        qn_mesh_destroy(mesh);
        qn_mesh_destroy(tangled);
        test_field_free(&field);
    }
    printf("%lld volumes: %lld crossing pairs, all found at suspects, %lld left\n",
           (long long)count, (long long)before, (long long)left);
    assert_true(before > 1000);
    assert_true(left * 50 <= found);
    test_context_end(one);
    test_context_end(three);
}

/* The proofs of where no crossing can be hold for any places: all vertices are moved at random. */
static void shake(qn_mesh *mesh, uint64_t seed, double most) {
    test_random random = {seed};
    for (int64_t n = 0; n < 3 * mesh->vertex_count; ++n)
        mesh->positions[n] += (float)(most * (2 * test_random_unit(&random) - 1));
}

static void shaken_meshes_hide_no_crossing(void **state) {
    (void)state;
    static const double most[] = {0.02, 0.1, 0.3, 1, 4};
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t found = 0;
    const int64_t count = test_count(60, 1500);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 12);
        qni_untangle_options options = {.everywhere = false};
        qni_untangle_report by_proof, by_all;
        memcpy(options.to_world, field.matrix, sizeof options.to_world);
        qn_mesh *mesh = surface(context, &field, (int)(i % 2), QN_UNTANGLE_OFF, NULL);
        qn_mesh *same = surface(context, &field, (int)(i % 2), QN_UNTANGLE_OFF, NULL);
        shake(mesh, seed + (uint64_t)i, most[i / TEST_KIND_COUNT % 5]);
        shake(same, seed + (uint64_t)i, most[i / TEST_KIND_COUNT % 5]);
        assert_int_equal(qni_mesh_untangle(context, mesh, &options, &by_proof, NULL), QN_OK);
        options.everywhere = true;
        assert_int_equal(qni_mesh_untangle(context, same, &options, &by_all, NULL), QN_OK);
        assert_int_equal(by_proof.crossings, by_all.crossings);
        assert_int_equal(by_proof.crossings_left, by_all.crossings_left);
        assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(same));
        found += by_all.crossings;
        qn_mesh_destroy(same);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld shaken meshes: %lld crossing pairs, all found at suspects\n", (long long)count,
           (long long)found);
    assert_true(found > 1000);
    test_context_end(context);
}

/* ---- meshes made for the proofs, on the lattice of whole numbers ------------------------------
 */

enum { SIDE = 12, MOST = 1024 };

typedef struct hand_made {
    int64_t vertices, quads;
    float positions[3 * MOST];
    uint32_t corners[4 * MOST];
} hand_made;

static uint32_t add_vertex(hand_made *m, double x, double y, double z) {
    const float p[3] = {(float)x, (float)y, (float)z};
    memcpy(m->positions + 3 * m->vertices, p, sizeof p);
    return (uint32_t)m->vertices++;
}

static void add_quad(hand_made *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const uint32_t corner[4] = {a, b, c, d};
    memcpy(m->corners + 4 * m->quads++, corner, sizeof corner);
}

/* One vertex in each cell of a square, at `shift` in x and y, rising along x. */
static void add_sheet(hand_made *m, double shift, double height, double rise) {
    const uint32_t first = (uint32_t)m->vertices;
    for (uint32_t n = 0; n < SIDE * SIDE; ++n)
        add_vertex(m, n % SIDE + shift, n / SIDE + shift, height + rise * (n % SIDE));
    for (uint32_t n = first; n < first + SIDE * (SIDE - 1); ++n)
        if ((n - first) % SIDE < SIDE - 1)
            add_quad(m, n, n + 1, n + 1 + SIDE, n + SIDE);
}

/* Quads round a vertex that go round it twice, in one plane. */
static void add_double_fan(hand_made *m) {
    const uint32_t middle = add_vertex(m, 0.5, 0.5, 0.5);
    for (int n = 0; n < 20; ++n) {
        const double angle = 2 * 3.14159265358979 * n / 10, far = (n & 1 ? 2 : 1.5) + 0.01 * n;
        add_vertex(m, 0.5 + far * cos(angle), 0.5 + far * sin(angle), 0.5);
    }
    for (uint32_t n = 0; n < 20; n += 2)
        add_quad(m, middle, middle + 1 + n, middle + 2 + n, middle + 1 + (n + 2) % 20);
}

static int64_t crossings_in(qn_context *context, const hand_made *made, bool everywhere) {
    qn_mesh_view view;
    qn_mesh *mesh;
    qni_untangle_report report;
    qni_untangle_options options = {.everywhere = everywhere};
    memset(&view, 0, sizeof view);
    view.vertex_count = made->vertices;
    view.positions = made->positions;
    view.quad_count = made->quads;
    view.quads = made->corners;
    for (int a = 0; a < 4; ++a)
        options.to_world[a][a] = 1;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    assert_int_equal(qni_mesh_untangle(context, mesh, &options, &report, NULL), QN_OK);
    qn_mesh_destroy(mesh);
    return report.crossings;
}

/* Each is seen by one condition of the proofs alone. */
static void made_crossings_are_found(void **state) {
    (void)state;
    static hand_made made[5];
    qn_context *context = test_context(1);
    memset(made, 0, sizeof made);
    add_sheet(made, 0.5, 0.5, 0); /* two sheets that share their cells */
    add_sheet(made, 0.3, 0.2, 0.05);
    add_sheet(made + 1, 0.5, 0.5, 0); /* a long quad through a sheet */
    const uint32_t low = add_vertex(made + 1, 5.9, 5.9, -3);
    add_vertex(made + 1, 6.2, 6.1, -3);
    add_vertex(made + 1, 6.2, 6.1, 4);
    add_vertex(made + 1, 5.9, 5.9, 4);
    add_quad(made + 1, low, low + 1, low + 2, low + 3);
    add_double_fan(made + 2);
    add_sheet(made + 3, 0.5, 0.5, 0.05); /* and none */
    add_sheet(made + 4, 0.5, 0.5, 0);    /* a quad that meets more cells than can be walked over */
    const uint32_t far = add_vertex(made + 4, -3e8, 5.2, -3e8);
    add_vertex(made + 4, 3e8, 5.7, -3e8);
    add_vertex(made + 4, 3e8, 5.7, 3e8);
    add_vertex(made + 4, NAN, 5.2, 3e8);
    add_vertex(made + 4, -3e8, 5.2, 3e8);
    add_quad(made + 4, far, far + 1, far + 2, far + 3);
    add_quad(made + 4, far, far + 1, far + 2, far + 4);
    for (int n = 0; n < 5; ++n) {
        const int64_t all = crossings_in(context, made + n, true);
        assert_int_equal(crossings_in(context, made + n, false), all);
        assert_int_equal(all > 0, n != 3);
    }
    test_context_end(context);
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
        qn_mesh *mesh = surface(context, &field, 0, QN_UNTANGLE_ON, &report);
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
        options.untangle = QN_UNTANGLE_ON;
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
    options.untangle = QN_UNTANGLE_ON;
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
        cmocka_unit_test(shaken_meshes_hide_no_crossing),
        cmocka_unit_test(made_crossings_are_found),
        cmocka_unit_test(samples_at_the_isovalue_are_parted),
        cmocka_unit_test(files_are_clean),
        cmocka_unit_test(failures_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
