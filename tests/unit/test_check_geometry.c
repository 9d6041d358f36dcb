// SPDX-License-Identifier: MIT
/* qn_mesh_check() on small shapes: duplicates, faces without area, places that are not finite,
 * self-intersections; and what happens when memory is short or the caller stops it. */
#include "unit/check_shapes.h"

static void duplicates_are_counted_once_each(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    quad(s, s->quads[0][2], s->quads[0][1], s->quads[0][0], s->quads[0][3]);
    quad(s, s->quads[0][0], s->quads[0][2], s->quads[0][1], s->quads[0][3]);
    vertex(s, 5, 5, 0.0);
    vertex(s, 5, 5, -0.0);
    vertex(s, 5, 5, 0.0);
    uint32_t far = vertex(s, 6, 7, 8);
    triangle(s, 8, far, 0);
    triangle(s, 9, far, 0);
    triangle(s, 10, far, 0);
    triangle(s, 10, 0, far);
    qn_mesh_report r = check(s);
    assert_int_equal(r.duplicate_faces, 3);
    assert_int_equal(r.duplicate_positions, 2);
}

static void degenerate_faces_are_seen_exactly(void **state) {
    (void)state;
    shape *s = new_shape();
    uint32_t a = vertex(s, 0, 0, 0), b = vertex(s, 0.1f, 0.1f, 0.1f),
             c = vertex(s, 0.2f, 0.2f, 0.2f);
    uint32_t near_line = vertex(s, 0.3f, 0.3f, nextafterf(0.3f, 1));
    uint32_t d = vertex(s, 1, 0, 0), e = vertex(s, 0, 1, 0);
    triangle(s, a, b, c);         /* collinear */
    triangle(s, a, b, near_line); /* by one bit not collinear */
    triangle(s, a, a, b);         /* an index twice: not a polygon */
    quad(s, a, d, e, e);          /* an index twice: the triangle a, d, e */
    quad(s, a, d, a, e);          /* not a polygon */
    vertex(s, 4, 4, 4);
    quad(s, 6, 6, 6, 6);
    qn_mesh_report r = check(s);
    assert_int_equal(r.degenerate_faces, 5);
    assert_int_equal(r.edge_count, 5 + 3);
    assert_int_equal(r.unused_vertices, 1);
    assert_int_equal(r.components, 2);
    assert_int_equal(r.euler_characteristic, 6 - 8 + 3);
    assert_int_equal(r.quad_count, 3);
    assert_int_equal(r.self_intersections, 0);
    assert_true(r.triangle_quality_min == 0 && r.smallest_angle == 0);
}

static void nonfinite_vertices_take_their_faces_out_of_the_geometry(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    add_cube(s, 5, 0, 0, 1);
    s->positions[8][1] = NAN;
    s->positions[9][0] = INFINITY;
    qn_mesh_report r = check(s);
    assert_int_equal(r.nonfinite_vertices, 2);
    assert_int_equal(r.components, 2);
    assert_true(r.closed && r.manifold);
    assert_near(r.area, 6 + 2); /* of the second cube two faces are left */
    assert_near(r.bounds[1][0], 6);
    assert_int_equal(r.self_intersections, 0);
}

static void nested_and_apart_do_not_intersect(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 4);
    add_cube(s, 1, 1, 1, 1);
    add_tetrahedron(s, 2.5, 2.5, 2.5, 0.25);
    add_cube(s, 4.0000005, 0, 0, 1);
    qn_mesh_report r = check(s);
    assert_clean(&r);
    assert_int_equal(r.components, 4);
    assert_near(r.volume, 64 + 1 + 1 + 0.015625 / 6);
}

static void crossing_triangles_are_one_pair(void **state) {
    (void)state;
    shape *s = new_shape();
    triangle(s, vertex(s, -1, -1, 0), vertex(s, 1, -1, 0), vertex(s, 0, 2, 0));
    triangle(s, vertex(s, 0, 0, -1), vertex(s, 0, 0.5, 1), vertex(s, 0, -0.5, 1));
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 1);
}

static void touching_strangers_are_pairs(void **state) {
    (void)state;
    shape *s = new_shape();
    triangle(s, vertex(s, -1, -1, 0), vertex(s, 1, -1, 0), vertex(s, 0, 2, 0));
    triangle(s, vertex(s, 0, 0, 0), vertex(s, 0, 0.5, 1), vertex(s, 0, -0.5, 1));
    triangle(s, vertex(s, 10, 0, 0), vertex(s, 11, 0, 0), vertex(s, 10, 1, 0));
    triangle(s, vertex(s, 10, 0, 0), vertex(s, 11, 0, 0), vertex(s, 10, -1, 0)); /* equal edges */
    triangle(s, vertex(s, 20, 0, 0), vertex(s, 21, 0, 0), vertex(s, 20, 1, 0));
    triangle(s, vertex(s, 20, 0, 0), vertex(s, 19, 0, 0), vertex(s, 20, -1, 5)); /* equal corners */
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 3);
    assert_int_equal(r.duplicate_positions, 3);
}

static void neighbours_meet_only_beyond_what_they_share(void **state) {
    (void)state;
    shape *s = new_shape();
    uint32_t o = vertex(s, 0, 0, 0), x = vertex(s, 4, 0, 0), y = vertex(s, 0, 4, 0);
    triangle(s, o, x, y);
    triangle(s, o, vertex(s, 1, 1, 1), vertex(s, 1, 1, -1)); /* a pair: through the first */
    uint32_t p = vertex(s, 100, 0, 0), q = vertex(s, 101, 0, 0), r0 = vertex(s, 100, 1, 0);
    triangle(s, p, q, r0);
    triangle(s, q, p, vertex(s, 100.25, 0.25, 0)); /* a pair: folded flat onto it */
    triangle(s, p, r0, vertex(s, 99, 0.5f, 0));    /* no pair: flat, beside both */
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 2);
}

static void solids_pushed_into_each_other_intersect(void **state) {
    (void)state;
    shape *s = new_shape();
    add_tetrahedron(s, 0, 0, 0, 1);
    add_tetrahedron(s, -10, -10, 0.25,
                    100); /* its base cuts the three faces at the first one's tip */
    qn_mesh_report r = check(s);
    assert_int_equal(r.self_intersections, 3);
    assert_true(r.closed && r.manifold);
}

static void intersections_can_be_left_out(void **state) {
    (void)state;
    shape *s = new_shape();
    add_cube(s, 0, 0, 0, 1);
    qn_context *context;
    qn_mesh *mesh;
    qn_mesh_report report;
    qn_error error;
    qn_mesh_check_options options;
    qn_mesh_check_options_init(&options);
    options.skip_intersections = true;
    const qn_mesh_view view = {8, 6,    0,   s->positions[0], NULL, s->quads[0], NULL, "", "", NULL,
                               0, NULL, NULL};
    assert_int_equal(qn_context_create(NULL, &context, NULL), QN_OK);
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, &options, &report, &error), QN_OK);
    assert_int_equal(report.self_intersections, -1);
    assert_int_equal(report.edge_count, 12);
    options.struct_size = 0;
    assert_int_equal(qn_mesh_check(context, mesh, &options, &report, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_mesh_destroy(mesh);
    qn_context_destroy(context);
    free(s);
}

/* ---- failure -----------------------------------------------------------------------------------
 */

typedef struct limits {
    int allocations_left, steps_left;
} limits;

static void *limited_alloc(void *user, size_t size, size_t alignment) {
    limits *l = user;
    return l->allocations_left-- > 0
               ? aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
               : NULL;
}

static void limited_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

static int limited_progress(void *user, const char *stage, double fraction) {
    assert_string_equal(stage, "check");
    assert_true(fraction >= 0 && fraction <= 1);
    return ((limits *)user)->steps_left-- <= 0;
}

static qn_status check_within(limits *l, const qn_mesh_view *view) {
    int allocations = l->allocations_left;
    l->allocations_left = 1000;
    qn_context_options options;
    qn_context_options_init(&options);
    options.allocator = (qn_allocator){l, limited_alloc, limited_free};
    options.progress = limited_progress;
    options.user = l;
    qn_context *context;
    qn_mesh *mesh;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    assert_int_equal(qn_mesh_create(context, view, &mesh, NULL), QN_OK);
    int64_t held = qn_context_memory(context).current_bytes;
    l->allocations_left = allocations;
    qn_mesh_report report;
    qn_error error = {QN_OK, ""};
    qn_status status = qn_mesh_check(context, mesh, NULL, &report, &error);
    assert_int_equal(error.status, status);
    if (status != QN_OK)
        assert_int_equal(report.vertex_count, 0);
    assert_int_equal(qn_context_memory(context).current_bytes, held);
    qn_mesh_destroy(mesh);
    qn_context_destroy(context);
    return status;
}

static void every_failure_is_reported_and_leaks_nothing(void **state) {
    (void)state;
    shape *s = new_shape();
    add_torus(s, 24, 12);
    const qn_mesh_view view = {s->vertex_count,
                               s->quad_count,
                               0,
                               s->positions[0],
                               NULL,
                               s->quads[0],
                               NULL,
                               "",
                               "",
                               NULL,
                               0,
                               NULL,
                               NULL};
    int failures = 0, cancels = 0;
    for (qn_status status = QN_ERROR_INTERNAL; status != QN_OK; ++failures) {
        limits l = {failures, 1000};
        status = check_within(&l, &view);
        assert_true(status == QN_OK || status == QN_ERROR_OUT_OF_MEMORY);
    }
    for (qn_status status = QN_ERROR_INTERNAL; status != QN_OK; ++cancels) {
        limits l = {1000, cancels};
        status = check_within(&l, &view);
        assert_true(status == QN_OK || status == QN_ERROR_CANCELLED);
    }
    assert_true(failures > 12 && cancels > 8);
    free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(duplicates_are_counted_once_each),
        cmocka_unit_test(degenerate_faces_are_seen_exactly),
        cmocka_unit_test(nonfinite_vertices_take_their_faces_out_of_the_geometry),
        cmocka_unit_test(nested_and_apart_do_not_intersect),
        cmocka_unit_test(crossing_triangles_are_one_pair),
        cmocka_unit_test(touching_strangers_are_pairs),
        cmocka_unit_test(neighbours_meet_only_beyond_what_they_share),
        cmocka_unit_test(solids_pushed_into_each_other_intersect),
        cmocka_unit_test(intersections_can_be_left_out),
        cmocka_unit_test(every_failure_is_reported_and_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
