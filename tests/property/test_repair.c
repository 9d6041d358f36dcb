// SPDX-License-Identifier: MIT
/* Doubled edges are taken apart: on any volume the closed mesh is a 2-manifold, of the Euler
 * characteristic and the pieces that its polygons and segments have; its halfedges are those of the
 * indices; vertices stay on the surface. */
#include "lib/random_volume.h"
#include "lib/test_volume.h"
#include "lib/trilinear.h"

#include <math.h>

static qn_mesh *surface(qn_context *context, const test_field *field, bool keep_doubled,
                        bool halfedges, qn_surface_report *report) {
    qn_surface_options options = test_field_options(field);
    options.keep_doubled = keep_doubled;
    options.halfedges = halfedges;
    return test_field_surface_with(context, field, &options, report);
}

static void compare_halfedges(qn_context *context, const test_field *field, qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const qn_halfedges he = qn_mesh_get_halfedges(mesh);
    qn_mesh *copy;
    assert_int_equal(qn_mesh_create(context, &view, &copy, NULL), QN_OK);
    assert_int_equal(qn_mesh_build_halfedges(context, copy, NULL), QN_OK);
    const qn_halfedges sorted = qn_mesh_get_halfedges(copy);
    assert_int_equal(he.count, 4 * view.quad_count);
    for (int64_t h = 0; h < he.count; ++h)
        if (he.twin[h] != sorted.twin[h])
            fail_msg("%s: halfedge %lld has twin %u, by sorting %u", field->name, (long long)h,
                     he.twin[h], sorted.twin[h]);
    for (int64_t v = 0; v < view.vertex_count; ++v)
        if (he.vertex_halfedge[v] != QN_NO_HALFEDGE)
            assert_int_equal(view.quads[he.vertex_halfedge[v]], v);
    /* A vertex' own halfedge is the one without a twin where there is one, so that its fan is seen
     * whole. */
    for (int64_t h = 0; h < he.count; ++h)
        if (he.twin[h] == QN_NO_HALFEDGE)
            assert_int_equal(he.twin[he.vertex_halfedge[view.quads[h]]], QN_NO_HALFEDGE);
    qn_mesh_destroy(copy);
}

static void closed_meshes_are_manifold(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t repaired = 0, fallbacks = 0;
    for (int64_t i = 0; i < test_count(300, 2000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 24);
        qn_surface_report raw_report, report;
        field.open = false;
        qn_mesh *raw = surface(context, &field, true, false, &raw_report);
        qn_mesh *mesh = surface(context, &field, false, true, &report);
        const qn_mesh_report found = test_mesh_topology(context, mesh),
                             before = test_mesh_topology(context, raw);
        assert_int_equal(report.doubled_edges, raw_report.doubled_edges);
        assert_int_equal(report.repaired_edges, report.doubled_edges);
        assert_int_equal(before.nonmanifold_edges, report.doubled_edges);
        if (found.boundary_edges || found.nonmanifold_edges || found.nonmanifold_vertices ||
            found.duplicate_faces || found.orientation_conflicts || found.unused_vertices)
            fail_msg("%s, number %lld: %lld boundary, %lld non-manifold edges, %lld vertices, "
                     "%lld duplicate faces, %lld conflicts, %lld unused",
                     field.name, (long long)i, (long long)found.boundary_edges,
                     (long long)found.nonmanifold_edges, (long long)found.nonmanifold_vertices,
                     (long long)found.duplicate_faces, (long long)found.orientation_conflicts,
                     (long long)found.unused_vertices);
        /* Each quad has four sides and each side two quads, doubled or not: V - 2 F + F. */
        assert_int_equal(found.euler_characteristic, raw_report.vertices - raw_report.quads);
        compare_halfedges(context, &field, mesh);
        repaired += report.repaired_edges;
        fallbacks += report.fallback_points - raw_report.fallback_points;
        qn_mesh_destroy(raw);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld doubled edges taken apart, %lld of their %lld points left on a face\n",
           (long long)repaired, (long long)fallbacks, (long long)(4 * repaired));
    assert_true(repaired > 10000);
    test_context_end(context);
}

/* At an open border too: no vertex joins several fans, whatever lattice edges have no quads. */
static void open_meshes_are_manifold(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t split = 0;
    for (int64_t i = 0; i < test_count(300, 2000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 16);
        qn_surface_report report;
        field.open = true;
        qn_mesh *mesh = surface(context, &field, false, true, &report);
        const qn_mesh_report found = test_mesh_topology(context, mesh);
        if (found.nonmanifold_edges || found.nonmanifold_vertices || found.duplicate_faces ||
            found.orientation_conflicts)
            fail_msg("%s, number %lld: %lld non-manifold edges, %lld vertices, %lld duplicate "
                     "faces, %lld conflicts",
                     field.name, (long long)i, (long long)found.nonmanifold_edges,
                     (long long)found.nonmanifold_vertices, (long long)found.duplicate_faces,
                     (long long)found.orientation_conflicts);
        compare_halfedges(context, &field, mesh);
        split += report.split_rim_vertices;
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld vertices more at open borders\n", (long long)split);
    assert_true(split > 1000);
    test_context_end(context);
}

/* The plain part of a closed mesh stays where it is, byte for byte, and so does all of any mesh for
 * any thread count. */
static void nothing_else_changes(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int round = 0; round < 20; ++round) {
        test_field field = test_random_field(&random, (test_kind)(round % TEST_KIND_COUNT), 30);
        qn_context *one = test_context(1), *eight = test_context(8);
        qn_mesh *raw = surface(one, &field, true, false, NULL);
        qn_mesh *a = surface(one, &field, false, false, NULL),
                *b = surface(eight, &field, false, false, NULL);
        const qn_mesh_view plain = qn_mesh_get_view(raw), repaired = qn_mesh_get_view(a);
        if (plain.vertex_count && !field.open)
            assert_memory_equal(plain.positions, repaired.positions,
                                (size_t)plain.vertex_count * 3 * sizeof(float));
        assert_true(test_hash_mesh(a) == test_hash_mesh(b));
        qn_mesh_destroy(raw);
        qn_mesh_destroy(a);
        qn_mesh_destroy(b);
        test_context_end(one);
        test_context_end(eight);
        test_field_free(&field);
    }
}

/* Compilers have left the MMX registers in use, which spoils long double arithmetic on the calling
 * thread. */
static void long_doubles_survive(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (int round = 0; round < TEST_KIND_COUNT; ++round) {
        test_field field = test_random_field(&random, (test_kind)round, 24);
        volatile long double parts[8] = {1, 2, 3, 4, 5, 6, 7, 8};
        qn_mesh_destroy(surface(context, &field, false, true, NULL));
        const long double sum = (((parts[0] + parts[1]) + (parts[2] + parts[3])) +
                                 ((parts[4] + parts[5]) + (parts[6] + parts[7])));
        assert_true(sum == 36);
        test_field_free(&field);
    }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_meshes_are_manifold),
        cmocka_unit_test(open_meshes_are_manifold),
        cmocka_unit_test(nothing_else_changes),
        cmocka_unit_test(long_doubles_survive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
