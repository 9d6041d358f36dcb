// SPDX-License-Identifier: MIT
/* What options may and may not change: several iso-values are each alone, a dry run reports what
 * the real one makes, the other side inside turns an open mesh over, triangles are the quads split,
 * normals do not touch the rest. */
#include "lib/mesh_measure.h"
#include "lib/random_volume.h"

static qn_mesh *surface(qn_context *context, const qn_volume *volume,
                        const qn_surface_options *options, qn_surface_report *report) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface(context, volume, options, &mesh, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

static void expect_same_counters(const qn_surface_report *a, const qn_surface_report *b) {
    assert_true(a->isovalue == b->isovalue);
    assert_int_equal(a->cells, b->cells);
    assert_int_equal(a->active_leaves, b->active_leaves);
    assert_int_equal(a->active_cells, b->active_cells);
    assert_int_equal(a->ambiguous_faces, b->ambiguous_faces);
    assert_int_equal(a->tied_faces, b->tied_faces);
    assert_int_equal(a->multiple_cells, b->multiple_cells);
    assert_int_equal(a->vertices, b->vertices);
    assert_int_equal(a->quads, b->quads);
    assert_int_equal(a->nan_samples, b->nan_samples);
    assert_int_equal(a->infinite_samples, b->infinite_samples);
    assert_int_equal(a->output_bytes, b->output_bytes);
}

static void several_isovalues_are_each_alone(const test_field *field, qn_context *context,
                                             const qn_volume *volume) {
    const double isovalues[4] = {field->iso + 0.3, field->iso, field->iso - 5, field->iso + 0.3};
    qn_surface_options options = test_field_options(field);
    options.isovalues = isovalues;
    options.isovalue_count = 4;
    qn_mesh *meshes[4];
    qn_surface_report reports[4], dry[4], alone;
    assert_int_equal(qn_surface(context, volume, &options, meshes, reports, NULL), QN_OK);
    options.count_only = true;
    qn_mesh *none[4] = {meshes[0], meshes[0], meshes[0], meshes[0]};
    assert_int_equal(qn_surface(context, volume, &options, none, dry, NULL), QN_OK);
    options.count_only = false;
    options.isovalue_count = 1;
    for (int i = 0; i < 4; ++i) {
        assert_null(none[i]);
        options.isovalues = &isovalues[i];
        qn_mesh *mesh = surface(context, volume, &options, &alone);
        assert_true(test_hash_mesh(mesh) == test_hash_mesh(meshes[i]));
        assert_int_equal(alone.vertices, qn_mesh_get_view(mesh).vertex_count);
        assert_int_equal(alone.quads, qn_mesh_get_view(mesh).quad_count);
        expect_same_counters(&alone, &reports[i]);
        expect_same_counters(&alone, &dry[i]);
        assert_int_equal(alone.slice_points, reports[i].slice_points);
        assert_int_equal(alone.fallback_points, reports[i].fallback_points);
        assert_int_equal(alone.degenerate_points, reports[i].degenerate_points);
        qn_mesh_destroy(mesh);
        qn_mesh_destroy(meshes[i]);
    }
}

/* The other way round, from any corner. */
static bool is_turned_over(const uint32_t a[4], const uint32_t b[4]) {
    for (int turn = 0; turn < 4; ++turn)
        if (a[0] == b[turn] && a[1] == b[(turn + 3) % 4] && a[2] == b[(turn + 2) % 4] &&
            a[3] == b[(turn + 1) % 4])
            return true;
    return false;
}

static void the_other_side_turns_an_open_mesh_over(const test_field *field, qn_context *context,
                                                   const qn_volume *volume) {
    qn_surface_options options = test_field_options(field);
    options.open = true;
    qn_mesh *one = surface(context, volume, &options, NULL);
    options.inside = field->inside == QN_INSIDE_ABOVE ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
    qn_mesh *other = surface(context, volume, &options, NULL);
    qn_mesh_view a = qn_mesh_get_view(one), b = qn_mesh_get_view(other);
    assert_int_equal(a.vertex_count, b.vertex_count);
    assert_int_equal(a.quad_count, b.quad_count);
    for (int64_t i = 0; i < 3 * a.vertex_count; ++i)
        assert_true(a.positions[i] == b.positions[i] && a.normals[i] == -b.normals[i]);
    for (int64_t q = 0; q < a.quad_count; ++q)
        assert_true(is_turned_over(a.quads + 4 * q, b.quads + 4 * q));
    qn_mesh_destroy(one);
    qn_mesh_destroy(other);
}

static void triangles_and_normals_change_nothing_else(const test_field *field, qn_context *context,
                                                      const qn_volume *volume) {
    qn_surface_options options = test_field_options(field);
    qn_mesh *quads = surface(context, volume, &options, NULL);
    options.skip_normals = true;
    qn_mesh *bare = surface(context, volume, &options, NULL);
    options.triangles = true;
    options.skip_normals = false;
    qn_mesh *split = surface(context, volume, &options, NULL);
    qn_mesh_view view = qn_mesh_get_view(quads), bare_view = qn_mesh_get_view(bare);
    assert_null(bare_view.normals);
    assert_int_equal(bare_view.vertex_count, view.vertex_count);
    assert_int_equal(bare_view.quad_count, view.quad_count);
    if (view.vertex_count > 0)
        assert_memory_equal(bare_view.positions, view.positions,
                            (size_t)view.vertex_count * 3 * sizeof(float));
    if (view.quad_count > 0)
        assert_memory_equal(bare_view.quads, view.quads,
                            (size_t)view.quad_count * 4 * sizeof(uint32_t));
    int64_t quad_count = view.quad_count;
    assert_int_equal(qn_mesh_triangulate(context, quads, NULL), QN_OK);
    assert_int_equal(qn_mesh_get_view(split).triangle_count, 2 * quad_count);
    assert_true(test_hash_mesh(quads) == test_hash_mesh(split));
    qn_mesh_destroy(quads);
    qn_mesh_destroy(bare);
    qn_mesh_destroy(split);
}

static void options_change_what_they_say(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    for (int64_t i = 0; i < test_count(90, 900); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 26);
        qn_volume *volume = test_field_volume(context, &field);
        several_isovalues_are_each_alone(&field, context, volume);
        the_other_side_turns_an_open_mesh_over(&field, context, volume);
        triangles_and_normals_change_nothing_else(&field, context, volume);
        qn_volume_destroy(volume);
        test_field_free(&field);
    }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(options_change_what_they_say)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
