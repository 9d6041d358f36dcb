// SPDX-License-Identifier: MIT
/* Cutting quads into triangles keeps a manifold one: no diagonal lies where another face has an
 * edge, unless both diagonals do. */
#include "lib/random_volume.h"
#include "lib/test_volume.h"
#include "mesh/diagonals.h"
#include "mesh/mesh.h"

enum { MOST_QUADS = 60 };

/* ---- meshes of volumes -------------------------------------------------------------------------
 */

static void cut_meshes_are_manifold(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t turned = 0, shared = 0;
    for (int64_t i = 0; i < test_count(300, 3000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 24);
        field.open = i % 5 == 4;
        qn_surface_options options = test_field_options(&field);
        options.keep_doubled = false;
        options.simplify = i % 2;
        options.topology = i % 3 == 1 ? QN_TOPOLOGY_EXACT : options.topology;
        qn_mesh *mesh = test_field_surface_with(context, &field, &options, NULL);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        qni_diagonals diagonals;
        assert_int_equal(qni_diagonals_choose(context, &view, &diagonals, NULL), QN_OK);
        turned += diagonals.turned;
        shared += diagonals.shared;
        const qn_mesh_report whole = test_mesh_topology(context, mesh);
        if (whole.nonmanifold_edges || whole.nonmanifold_vertices)
            fail_msg("%s, number %lld: %lld non-manifold edges, %lld vertices before the cut",
                     field.name, (long long)i, (long long)whole.nonmanifold_edges,
                     (long long)whole.nonmanifold_vertices);
        assert_int_equal(qn_mesh_triangulate(context, mesh, NULL), QN_OK);
        const qn_mesh_report cut = test_mesh_topology(context, mesh);
        if (diagonals.shared == 0 && (cut.nonmanifold_edges || cut.nonmanifold_vertices))
            fail_msg("%s, number %lld: %lld non-manifold edges, %lld vertices after the cut",
                     field.name, (long long)i, (long long)cut.nonmanifold_edges,
                     (long long)cut.nonmanifold_vertices);
        qni_diagonals_free(&diagonals);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld quads turned, %lld left on an edge of other faces\n", (long long)turned,
           (long long)shared);
    assert_true(turned > 100);
    assert_int_equal(shared, 0);
    test_context_end(context);
}

/* ---- any quads ---------------------------------------------------------------------------------
 */

static bool joins(const uint32_t *v, int corners, uint32_t a, uint32_t b) {
    for (int i = 0; i < corners; ++i) {
        const uint32_t from = v[i], to = v[(i + 1) % corners];
        if ((from == a && to == b) || (from == b && to == a))
            return true;
    }
    return false;
}

static bool has_choice(const uint32_t q[4]) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j)
            if (q[i] == q[j])
                return false;
    return true;
}

/* Whether another face has an edge along a diagonal of a quad, by looking at all of them. */
static bool is_taken(const qn_mesh_view *view, const qni_diagonals *diagonals, int64_t quad,
                     bool along_02) {
    const uint32_t *q = view->quads + 4 * quad;
    const uint32_t a = along_02 ? q[0] : q[1], b = along_02 ? q[2] : q[3];
    for (int64_t other = 0; other < view->quad_count; ++other) {
        const uint32_t *o = view->quads + 4 * other;
        const bool cut_02 = qni_along_02(diagonals, other);
        const uint32_t c = cut_02 ? o[0] : o[1], d = cut_02 ? o[2] : o[3];
        if (joins(o, 4, a, b) ||
            (other != quad && has_choice(o) && ((a == c && b == d) || (a == d && b == c))))
            return true;
    }
    for (int64_t t = 0; t < view->triangle_count; ++t)
        if (joins(view->triangles + 3 * t, 3, a, b))
            return true;
    return false;
}

static void every_taken_diagonal_is_given_up(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t turned = 0, shared = 0;
    for (int64_t i = 0; i < test_count(3000, 100000); ++i) {
        test_random random = {seed + (uint64_t)i};
        static float positions[3 * MOST_QUADS];
        static uint32_t quads[4 * MOST_QUADS], triangles[3 * MOST_QUADS];
        const int64_t vertices = 4 + (int64_t)(test_random_bits(&random) % (MOST_QUADS - 4));
        const bool hub = test_random_bits(&random) % 4 == 0; /* many quads share a corner */
        for (int64_t k = 0; k < 3 * vertices; ++k)
            positions[k] = (float)test_random_unit(&random);
        for (int64_t k = 0; k < 4 * MOST_QUADS; ++k)
            quads[k] =
                hub && k % 4 == 1 ? 0 : (uint32_t)(test_random_bits(&random) % (uint64_t)vertices);
        for (int64_t k = 0; k < 3 * MOST_QUADS; ++k)
            triangles[k] = (uint32_t)(test_random_bits(&random) % (uint64_t)vertices);
        const qn_mesh_view view = {.vertex_count = vertices,
                                   .quad_count = (int64_t)(test_random_bits(&random) % MOST_QUADS),
                                   .triangle_count = (int64_t)(test_random_bits(&random) % 4),
                                   .positions = positions,
                                   .quads = quads,
                                   .triangles = triangles};
        qni_diagonals diagonals;
        assert_int_equal(qni_diagonals_choose(context, &view, &diagonals, NULL), QN_OK);
        int64_t left = 0, other = 0;
        for (int64_t q = 0; q < view.quad_count; ++q) {
            const bool along_02 = qni_along_02(&diagonals, q);
            if (!has_choice(quads + 4 * q))
                continue;
            other += along_02 != qni_quad_splits_02(positions, quads + 4 * q);
            if (!is_taken(&view, &diagonals, q, along_02))
                continue;
            assert_true(is_taken(&view, &diagonals, q, !along_02));
            ++left;
        }
        assert_int_equal(left, diagonals.shared);
        assert_true(other <= diagonals.turned);
        turned += diagonals.turned;
        shared += diagonals.shared;
        qni_diagonals_free(&diagonals);
    }
    printf("%lld turned, %lld left\n", (long long)turned, (long long)shared);
    assert_true(turned > 1000 && shared > 1000);
    test_context_end(context);
}

/* A million quads round one vertex take no longer than others do. */
static void a_hub_is_no_trap(void **state) {
    (void)state;
    enum { COUNT = 200000 };
    qn_context *context = test_context(2);
    float *positions = calloc(3 * (2 * COUNT + 1), sizeof *positions);
    uint32_t *quads = calloc(4 * COUNT, sizeof *quads);
    assert_non_null(positions);
    assert_non_null(quads);
    for (int64_t q = 0; q < COUNT; ++q) {
        const uint32_t own[4] = {0, (uint32_t)(2 * q + 1), (uint32_t)(2 * q + 2),
                                 (uint32_t)((2 * q + 2) % (2 * COUNT) + 1)};
        for (int i = 0; i < 4; ++i)
            quads[4 * q + i] = own[i];
    }
    const qn_mesh_view view = {
        .vertex_count = 2 * COUNT + 1, .quad_count = COUNT, .positions = positions, .quads = quads};
    qni_diagonals diagonals;
    assert_int_equal(qni_diagonals_choose(context, &view, &diagonals, NULL), QN_OK);
    assert_int_equal(diagonals.shared, 0);
    qni_diagonals_free(&diagonals);
    free(positions);
    free(quads);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(cut_meshes_are_manifold),
                                       cmocka_unit_test(every_taken_diagonal_is_given_up),
                                       cmocka_unit_test(a_hub_is_no_trap)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
