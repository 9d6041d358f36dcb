// SPDX-License-Identifier: MIT
/* Halfedges from the grid: an oriented involution whose vertices are single fans, on any volume;
 * equal to pairing by sorting wherever a mesh edge has one or two faces, and a pairing of the same
 * bundle where it has three or four. */
#include "lib/random_volume.h"
#include "lib/test_volume.h"

static qn_mesh *surface_with_halfedges(qn_context *context, const test_field *field) {
    qn_volume *volume = test_field_volume(context, field);
    qn_surface_options options = test_field_options(field);
    qn_mesh *mesh;
    qn_error error;
    options.halfedges = true;
    if (qn_surface(context, volume, &options, &mesh, NULL, &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    qn_volume_destroy(volume);
    return mesh;
}

static uint32_t after(uint32_t h) {
    return (h & 3) == 3 ? h - 3 : h + 1;
}

static uint32_t before(uint32_t h) {
    return (h & 3) == 0 ? h + 3 : h - 1;
}

static void check_involution(const test_field *field, const qn_mesh_view *view,
                             const qn_halfedges *he) {
    for (int64_t h = 0; h < he->count; ++h) {
        const uint32_t twin = he->twin[h];
        if (twin == QN_NO_HALFEDGE)
            continue;
        if (twin >= he->count || he->twin[twin] != h || twin == h)
            fail_msg("%s: halfedge %lld and its twin %u do not agree", field->name, (long long)h,
                     twin);
        if (view->quads[twin] != view->quads[after((uint32_t)h)] ||
            view->quads[h] != view->quads[after(twin)])
            fail_msg("%s: halfedge %lld and its twin do not run against each other", field->name,
                     (long long)h);
    }
}

/* Every vertex is one fan: from its halfedge, turning over twins reaches all the halfedges that
 * start there. */
static void check_fans(const test_field *field, const qn_mesh_view *view, const qn_halfedges *he) {
    int64_t *starts = test_alloc((size_t)view->vertex_count + 1, sizeof *starts);
    memset(starts, 0, (size_t)view->vertex_count * sizeof *starts);
    for (int64_t h = 0; h < he->count; ++h)
        ++starts[view->quads[h]];
    for (int64_t v = 0; v < view->vertex_count; ++v) {
        const uint32_t first = he->vertex_halfedge[v];
        if (first == QN_NO_HALFEDGE) {
            assert_int_equal(starts[v], 0);
            continue;
        }
        assert_int_equal(view->quads[first], v);
        int64_t turned = 0;
        uint32_t h = first;
        do {
            ++turned;
            h = he->twin[before(h)];
        } while (h != QN_NO_HALFEDGE && h != first && turned <= starts[v]);
        /* A closed vertex is one full turn; an open one may be cut into several fans by the
         * lattice's border. */
        if (field->open ? turned > starts[v] : turned != starts[v])
            fail_msg("%s: vertex %lld has %lld quads, its fan %lld", field->name, (long long)v,
                     (long long)starts[v], (long long)turned);
        if (he->twin[first] != QN_NO_HALFEDGE && h == QN_NO_HALFEDGE)
            fail_msg("%s: vertex %lld is at the boundary, its halfedge is not", field->name,
                     (long long)v);
    }
    free(starts);
}

/* Against sorting: the sides of an edge with one or two faces have one possible pairing. Only where
 * a doubled edge has lost one quad of each of its two pairs at an open border does sorting join the
 * two that are left, which the surface does not. */
static void compare_with_sorting(qn_context *context, const test_field *field, qn_mesh *mesh,
                                 int64_t *doubled, int64_t *cut) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const qn_halfedges he = qn_mesh_get_halfedges(mesh);
    qn_mesh *copy;
    assert_int_equal(qn_mesh_create(context, &view, &copy, NULL), QN_OK);
    assert_int_equal(qn_mesh_build_halfedges(context, copy, NULL), QN_OK);
    const qn_halfedges sorted = qn_mesh_get_halfedges(copy);
    assert_int_equal(sorted.count, he.count);
    for (int64_t h = 0; h < he.count; ++h) {
        if (sorted.twin[h] == he.twin[h])
            continue;
        /* Sorting leaves edges of three and four faces unpaired; the grid pairs them within the
         * edge. */
        const uint32_t other = sorted.twin[h];
        if (other != QN_NO_HALFEDGE && field->open && he.twin[h] == QN_NO_HALFEDGE &&
            he.twin[other] == QN_NO_HALFEDGE) {
            ++*cut;
            continue;
        }
        if (other != QN_NO_HALFEDGE)
            fail_msg("%s: halfedge %lld has twin %u, by sorting %u", field->name, (long long)h,
                     he.twin[h], sorted.twin[h]);
        ++*doubled;
    }
    qn_mesh_destroy(copy);
}

static void random_volumes_have_true_halfedges(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t doubled = 0, cut = 0, halfedges = 0;
    const int64_t count = test_count(300, 2000);
    for (int64_t i = 0; i < count; ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 24);
        qn_mesh *mesh = surface_with_halfedges(context, &field);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        const qn_halfedges he = qn_mesh_get_halfedges(mesh);
        assert_int_equal(he.count, 4 * view.quad_count);
        if (view.quad_count)
            assert_int_equal(he.corners, 4);
        check_involution(&field, &view, &he);
        check_fans(&field, &view, &he);
        compare_with_sorting(context, &field, mesh, &doubled, &cut);
        halfedges += he.count;
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld halfedges, %lld at doubled edges, %lld at doubled edges cut by an open border\n",
           (long long)halfedges, (long long)doubled, (long long)cut);
    assert_true(doubled > 1000);
    assert_true(cut * 100 < doubled);
    test_context_end(context);
}

/* No boundary on closed meshes; the same bytes for any thread count. */
static void closed_meshes_have_no_boundary_and_threads_agree(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int round = 0; round < 20; ++round) {
        test_field field = test_random_field(&random, (test_kind)(round % TEST_KIND_COUNT), 40);
        field.open = false;
        qn_context *one = test_context(1), *eight = test_context(8);
        qn_mesh *a = surface_with_halfedges(one, &field),
                *b = surface_with_halfedges(eight, &field);
        const qn_halfedges ha = qn_mesh_get_halfedges(a), hb = qn_mesh_get_halfedges(b);
        for (int64_t h = 0; h < ha.count; ++h)
            assert_true(ha.twin[h] != QN_NO_HALFEDGE);
        assert_int_equal(ha.count, hb.count);
        if (ha.count) {
            assert_memory_equal(ha.twin, hb.twin, (size_t)ha.count * sizeof *ha.twin);
            assert_memory_equal(ha.vertex_halfedge, hb.vertex_halfedge,
                                (size_t)qn_mesh_get_view(a).vertex_count * sizeof(uint32_t));
        }
        qn_mesh_destroy(a);
        qn_mesh_destroy(b);
        test_context_end(one);
        test_context_end(eight);
        test_field_free(&field);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_volumes_have_true_halfedges),
        cmocka_unit_test(closed_meshes_have_no_boundary_and_threads_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
