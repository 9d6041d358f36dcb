// SPDX-License-Identifier: MIT
/* With exact topology a closed mesh has the pieces and the Euler characteristic of the trilinear
 * surface, found by cutting the lattice's cells finely; it stays a 2-manifold of quads with right
 * halfedges, the same for any thread count. */
#include "lib/random_volume.h"
#include "lib/trilinear_topology.h"

static qn_mesh *surface(qn_context *context, const test_field *field, qn_topology topology,
                        bool halfedges, qn_surface_report *report) {
    qn_surface_options options = test_field_options(field);
    options.keep_doubled = false;
    options.topology = topology;
    options.halfedges = halfedges;
    return test_field_surface_with(context, field, &options, report);
}

/* ---- claims ---------------------------------------------------------------------------------- */

typedef struct agreement {
    int64_t grids, exact, discs, tunnels, late;
} agreement;

static void compare_grid(qn_context *context, const test_field *field, agreement *sum) {
    qn_surface_report report;
    qn_mesh *exact = surface(context, field, QN_TOPOLOGY_EXACT, false, &report);
    qn_mesh *discs = surface(context, field, QN_TOPOLOGY_DISCS, false, NULL);
    const qn_mesh_report of_exact = test_mesh_topology(context, exact),
                         of_discs = test_mesh_topology(context, discs);
    bool late;
    const test_topology found = test_trilinear_topology(field, &of_exact, &late);
    sum->late += late;
    if (!test_topology_agrees(&found, &of_exact))
        print_message("%s: mesh of %lld pieces, Euler %lld, %lld tunnels; by brute force %lld "
                      "pieces, Euler %lld, %lld tunnels\n",
                      field->name, (long long)of_exact.components,
                      (long long)of_exact.euler_characteristic, (long long)report.tunnels,
                      (long long)found.components, (long long)found.euler,
                      (long long)found.tunnels);
    ++sum->grids;
    sum->exact += test_topology_agrees(&found, &of_exact);
    sum->discs += test_topology_agrees(&found, &of_discs);
    sum->tunnels += report.tunnels;
    qn_mesh_destroy(exact);
    qn_mesh_destroy(discs);
}

static void compare_grids(qn_context *context, test_kind kind, int64_t count) {
    agreement sum = {0};
    const uint64_t seed = test_seed();
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_field_make(5, 5, 5);
        test_random_fill(&field, &random, kind);
        field.inside = i & 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_prepare(&field);
        compare_grid(context, &field, &sum);
        test_field_free(&field);
    }
    printf("%s: %lld grids of 5 x 5 x 5, %lld tunnels; as the trilinear surface: %lld with exact "
           "topology, %lld with discs; %lld "
           "needed more than 32 boxes\n",
           test_kind_name(kind), (long long)sum.grids, (long long)sum.tunnels, (long long)sum.exact,
           (long long)sum.discs, (long long)sum.late);
    assert_int_equal(sum.exact, sum.grids);
    assert_true(sum.discs < sum.grids);
}

static void as_the_trilinear_surface(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    compare_grids(context, TEST_GAUSSIAN, test_count(200, 10000));
    compare_grids(context, TEST_SMALL_INTEGERS, test_count(100, 2000));
    test_context_end(context);
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
    qn_mesh_destroy(copy);
}

static void stays_a_manifold(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2), *other = test_context(7);
    int64_t tunnels = 0, open_tunnels = 0, left = 0, points = 0;
    for (int64_t i = 0; i < test_count(80, 2000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 24);
        qn_surface_report report, plain;
        qn_mesh *discs = surface(context, &field, QN_TOPOLOGY_DISCS, false, &plain);
        qn_mesh *mesh = surface(context, &field, QN_TOPOLOGY_EXACT, true, &report);
        qn_mesh *again = surface(other, &field, QN_TOPOLOGY_EXACT, false, NULL);
        const qn_mesh_report found = test_mesh_topology(context, mesh),
                             before = test_mesh_topology(context, discs);
        if (found.nonmanifold_edges || found.duplicate_faces || found.orientation_conflicts ||
            found.unused_vertices != before.unused_vertices ||
            found.nonmanifold_vertices != before.nonmanifold_vertices ||
            found.boundary_edges != before.boundary_edges || found.nonfinite_vertices)
            fail_msg("%s, number %lld: %lld and %lld boundary, %lld non-manifold edges, %lld "
                     "vertices, %lld duplicate faces, %lld "
                     "conflicts, %lld unused",
                     field.name, (long long)i, (long long)found.boundary_edges,
                     (long long)before.boundary_edges, (long long)found.nonmanifold_edges,
                     (long long)found.nonmanifold_vertices, (long long)found.duplicate_faces,
                     (long long)found.orientation_conflicts, (long long)found.unused_vertices);
        assert_int_equal(plain.tunnels, 0); /* not looked for: discs cost nothing more */
        if (!field.open)
            assert_int_equal(report.restored_tunnels, report.tunnels);
        assert_int_equal(found.euler_characteristic,
                         before.euler_characteristic - 2 * report.restored_tunnels);
        compare_halfedges(context, &field, mesh);
        assert_true(test_hash_mesh(mesh) == test_hash_mesh(again));
        tunnels += report.restored_tunnels;
        open_tunnels += report.tunnels - report.restored_tunnels;
        left += report.fallback_points - plain.fallback_points;
        points += report.vertices - plain.vertices;
        qn_mesh_destroy(discs);
        qn_mesh_destroy(mesh);
        qn_mesh_destroy(again);
        test_field_free(&field);
    }
    printf("%lld tunnels restored, %lld left at the rim of open surfaces; of %lld new points, %lld "
           "not on the surface\n",
           (long long)tunnels, (long long)open_tunnels, (long long)points, (long long)left);
    assert_true(tunnels > 100);
    test_context_end(context);
    test_context_end(other);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_the_trilinear_surface),
        cmocka_unit_test(stays_a_manifold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
