// SPDX-License-Identifier: MIT
/* Simplification and relaxation keep what a mesh is: topology, orientation, halfedges, the surface
 * under the vertices; and reach the figures of [DMC21] Tables 4 and 8. */
#include "lib/analytic.h"
#include "lib/random_volume.h"
#include "lib/trilinear.h"
#include "dmc/relax.h"
#include "dmc/simplify.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdatomic.h>

static void expect_same(const char *name, const char *what, int64_t before, int64_t after) {
    if (before != after)
        fail_msg("%s: %s were %lld and are %lld", name, what, (long long)before, (long long)after);
}

/* Everything that a removal of quads must leave as it was. */
static void expect_same_surface(const char *name, const qn_mesh_report *before,
                                const qn_mesh_report *after) {
    expect_same(name, "non-manifold edges", before->nonmanifold_edges, after->nonmanifold_edges);
    expect_same(name, "non-manifold vertices", before->nonmanifold_vertices,
                after->nonmanifold_vertices);
    expect_same(name, "orientation conflicts", before->orientation_conflicts,
                after->orientation_conflicts);
    expect_same(name, "boundary edges", before->boundary_edges, after->boundary_edges);
    expect_same(name, "components", before->components, after->components);
    expect_same(name, "closed components", before->closed_components, after->closed_components);
    expect_same(name, "Euler characteristics", before->euler_characteristic,
                after->euler_characteristic);
    expect_same(name, "unused vertices", before->unused_vertices, after->unused_vertices);
    if (after->duplicate_faces > before->duplicate_faces)
        fail_msg("%s: new duplicate faces", name);
}

/* The halfedges are those that are found from the indices alone. */
static void expect_right_halfedges(qn_context *context, const char *name, const qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    qn_mesh *again;
    assert_int_equal(qn_mesh_create(context, &view, &again, NULL), QN_OK);
    assert_int_equal(qn_mesh_build_halfedges(context, again, NULL), QN_OK);
    const qn_halfedges patched = qn_mesh_get_halfedges(mesh), built = qn_mesh_get_halfedges(again);
    expect_same(name, "halfedges", built.count, patched.count);
    for (int64_t h = 0; h < built.count; ++h)
        if (built.twin[h] != patched.twin[h])
            fail_msg("%s: twin of %lld is %u, not %u", name, (long long)h, patched.twin[h],
                     built.twin[h]);
    for (int64_t v = 0; v < view.vertex_count; ++v) {
        const uint32_t own = patched.vertex_halfedge[v], other = built.vertex_halfedge[v];
        if ((own == QN_NO_HALFEDGE) != (other == QN_NO_HALFEDGE))
            fail_msg("%s: vertex %lld has, or has not, a halfedge", name, (long long)v);
        if (own != QN_NO_HALFEDGE &&
            (view.quads[own] != (uint32_t)v ||
             (built.twin[other] == QN_NO_HALFEDGE && built.twin[own] != QN_NO_HALFEDGE)))
            fail_msg("%s: halfedge of vertex %lld is %u, %u would be right", name, (long long)v,
                     own, other);
    }
    qn_mesh_destroy(again);
}

/* Off the surface beyond rounding, in the cell that holds the place moved by `nudge` along each
 * axis. */
static double excess(const test_field *field, const float world[3], const double index[3],
                     const double nudge[3]) {
    const double moved[3] = {index[0] + nudge[0], index[1] + nudge[1], index[2] + nudge[2]};
    int64_t cell[3];
    test_cell_of(field, moved, cell);
    const test_standing standing = test_vertex_standing(field, cell, world);
    return standing.deviation - standing.allowance;
}

/* Vertices stand on the trilinear surface as closely as floats can, in whichever cell they are (on
 * a border between cells rounding may have put them on the other side). */
static void expect_on_surface(const test_field *field, const qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    for (int64_t v = 0; v < view.vertex_count; ++v) {
        const float *world = view.positions + 3 * v;
        double index[3], rounding[3], least = INFINITY;
        test_to_index(field, world, index);
        test_rounding(field, world, rounding);
        for (int n = 0; n < 27; ++n) {
            const double nudge[3] = {(n % 3 - 1) * rounding[0], (n / 3 % 3 - 1) * rounding[1],
                                     (n / 9 - 1) * rounding[2]};
            least = fmin(least, excess(field, world, index, nudge));
        }
        if (!(least <= 1e-12 * field->largest_distance))
            fail_msg("%s: vertex %lld is off the surface by %g more than rounding allows",
                     field->name, (long long)v, least);
    }
}

static qn_mesh *surface(qn_context *context, const test_field *field,
                        const qn_surface_options *extra, qn_surface_report *report) {
    qn_surface_options options = test_field_options(field);
    qn_volume *volume = test_field_volume(context, field);
    qn_mesh *mesh;
    qn_error error;
    options.simplify = extra->simplify;
    options.simplify_passes = extra->simplify_passes;
    options.no_reproject = extra->no_reproject;
    options.relax = extra->relax;
    options.skip_normals = extra->skip_normals;
    options.halfedges = extra->halfedges;
    options.keep_doubled = extra->keep_doubled;
    options.topology = extra->topology;
    if (qn_surface(context, volume, &options, &mesh, report, &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    qn_volume_destroy(volume);
    return mesh;
}

/* Kinds in which simplification finds something to do. */
static test_field field_of(test_random *random, int64_t i) {
    return test_random_field(
        random, i % 2 ? TEST_SMOOTHED_NOISE : (test_kind)(i / 2 % TEST_KIND_COUNT), 30);
}

static void topology_and_surface_stay(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t merged = 0, shrunk = 0, moved = 0, unprojected = 0;
    for (int64_t i = 0; i < test_count(120, 2000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = field_of(&random, i);
        qn_surface_options options;
        qn_surface_options_init(&options);
        options.skip_normals = i % 5 == 4;
        options.keep_doubled = i % 4 == 3;
        qn_mesh *mesh = surface(context, &field, &options, NULL);
        const qn_mesh_report before = test_mesh_topology(context, mesh);
        qn_mesh_destroy(mesh);
        options.simplify = true;
        options.relax = i % 3 == 2 ? 2 : 0;
        options.simplify_passes = i % 7 == 6 ? -1 : 0;
        qn_surface_report report;
        mesh = surface(context, &field, &options, &report);
        const qn_mesh_report after = test_mesh_topology(context, mesh);
        expect_same_surface(field.name, &before, &after);
        expect_same(field.name, "quads less those removed",
                    before.quad_count - report.merged_quads - report.shrunk_quads,
                    after.quad_count);
        expect_same(field.name, "reported vertices", report.vertices, after.vertex_count);
        expect_on_surface(&field, mesh);
        merged += report.merged_quads;
        shrunk += report.shrunk_quads;
        moved += report.relaxed_vertices;
        unprojected += report.unprojected_points;
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    printf("%lld quads merged (%lld without projection), %lld shrunk, %lld vertices relaxed\n",
           (long long)merged, (long long)unprojected, (long long)shrunk, (long long)moved);
    assert_true(merged > 1000 && shrunk > 100 && moved > 1000);
    test_context_end(context);
}

/* Where a doubled edge was kept, pairs of quads on both sides of it could be merged: their vertices
 * got two edges as well, and the quads between were there twice. */
static void ends_of_doubled_edges_stay(void **state) {
    (void)state;
    static const int64_t found[2] = {1163, 1715};
    qn_context *context = test_context(1);
    for (int n = 0; n < 2; ++n) {
        test_random random = {20240607 + (uint64_t)found[n]};
        test_field field = field_of(&random, found[n]);
        qn_surface_options options;
        qn_surface_options_init(&options);
        options.keep_doubled = true;
        qn_mesh *mesh = surface(context, &field, &options, NULL);
        const qn_mesh_report before = test_mesh_topology(context, mesh);
        assert_true(before.nonmanifold_edges > 0);
        qn_mesh_destroy(mesh);
        options.simplify = true;
        mesh = surface(context, &field, &options, NULL);
        const qn_mesh_report after = test_mesh_topology(context, mesh);
        expect_same_surface(field.name, &before, &after);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    test_context_end(context);
}

static void nothing_is_left_and_halfedges_are_right(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    for (int64_t i = 0; i < test_count(120, 2000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = field_of(&random, i);
        qn_surface_options with_halfedges;
        qn_surface_options_init(&with_halfedges);
        with_halfedges.halfedges = true;
        with_halfedges.keep_doubled =
            i % 4 == 3; /* then sorting pairs otherwise than the grid does */
        qn_mesh *mesh = surface(context, &field, &with_halfedges, NULL);
        const qni_simplify_options until_done = {.passes = 0};
        qni_simplify_report report;
        if (qn_mesh_get_view(mesh).quad_count == 0) {
            qn_mesh_destroy(mesh);
            test_field_free(&field);
            continue;
        }
        assert_int_equal(qni_simplify(context, mesh, &until_done, &report, NULL), QN_OK);
        if (!with_halfedges.keep_doubled)
            expect_right_halfedges(context, field.name, mesh);
        assert_int_equal(qni_simplify(context, mesh, &until_done, &report, NULL), QN_OK);
        if (report.merged_quads + report.shrunk_quads > 0)
            fail_msg("%s: %lld and %lld quads could still be removed", field.name,
                     (long long)report.merged_quads, (long long)report.shrunk_quads);
        qn_mesh_destroy(mesh);
        test_field_free(&field);
    }
    test_context_end(context);
}

static void bytes_are_equal_for_1_2_8_threads(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    for (int64_t i = 0; i < test_count(30, 300); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = field_of(&random, i);
        uint64_t hash[3];
        for (int n = 0; n < 3; ++n) {
            static const int32_t threads[3] = {1, 2, 8};
            qn_context *context = test_context(threads[n]);
            qn_surface_options options;
            qn_surface_options_init(&options);
            options.simplify = true;
            options.relax = 2;
            qn_mesh *mesh = surface(context, &field, &options, NULL);
            hash[n] = test_hash_mesh(mesh);
            qn_mesh_destroy(mesh);
            test_context_end(context);
        }
        if (hash[1] != hash[0] || hash[2] != hash[0])
            fail_msg("%s: other bytes with other numbers of threads", field.name);
        test_field_free(&field);
    }
}

/* With halfedges the quads round a vertex are found through them, without by the grid. Returns how
 * many quads were removed. */
static int64_t expect_same_with_halfedges(const test_field *field, qn_surface_options options) {
    qn_context *context = test_context(2);
    qn_mesh *mesh[2];
    qn_surface_report report[2];
    options.simplify = true;
    for (int n = 0; n < 2; ++n) {
        options.halfedges = n == 1;
        mesh[n] = surface(context, field, &options, report + n);
    }
    if (!options.keep_doubled) /* else sorting pairs otherwise than the grid does */
        expect_right_halfedges(context, field->name, mesh[1]);
    expect_same(field->name, "merged quads", report[0].merged_quads, report[1].merged_quads);
    expect_same(field->name, "shrunk quads", report[0].shrunk_quads, report[1].shrunk_quads);
    if (test_hash_mesh(mesh[0]) != test_hash_mesh(mesh[1]))
        fail_msg("%s: other bytes with halfedges", field->name);
    for (int n = 0; n < 2; ++n)
        qn_mesh_destroy(mesh[n]);
    test_context_end(context);
    return report[0].merged_quads + report[0].shrunk_quads;
}

static void halfedges_change_nothing(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    int64_t removed = 0;
    for (int64_t i = 0; i < test_count(60, 2000); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = field_of(&random, i);
        qn_surface_options options;
        qn_surface_options_init(&options);
        options.keep_doubled = i % 4 == 3;
        options.simplify_passes = i % 7 == 6 ? -1 : 0;
        options.topology = i % 3 == 1 ? QN_TOPOLOGY_EXACT : QN_TOPOLOGY_DISCS;
        removed += expect_same_with_halfedges(&field, options);
        test_field_free(&field);
    }
    assert_true(removed > 1000);
}

/* Rows of more leaves than a word has bits, with gaps: stretches of few values among empty ones. */
static test_field long_field(test_random *random) {
    test_field field = test_field_make(1400, 14, 14);
    const int64_t rows = field.size[1] * field.size[2];
    for (int64_t x = 0, end = 0, empty = 0; x < field.size[0]; ++x) {
        if (x == end) {
            end = x + 1 + test_random_range(random, 0, 59);
            empty = test_random_range(random, 0, 2) == 0;
        }
        for (int64_t n = 0; n < rows; ++n)
            field.values[x + field.size[0] * n] =
                empty ? -1 : (double)test_random_range(random, 0, 8) - 4.5;
    }
    snprintf(field.name, sizeof field.name, "long rows");
    return field;
}

static void long_rows_of_leaves_change_nothing(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    int64_t removed = 0;
    for (int64_t i = 0; i < test_count(2, 40); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = long_field(&random);
        qn_surface_options options;
        qn_surface_options_init(&options);
        removed += expect_same_with_halfedges(&field, options);
        test_field_free(&field);
    }
    assert_true(removed > 1000);
}

/* ---- the papers' figures --------------------------------------------------------------------- */

typedef struct figure_row {
    const char *name;
    int64_t n;
    qn_scalar scalar;
    qn_inside inside;
    int64_t merged;          /* [DMC21] Table 4 at least, where it says */
    double irregular;        /* [DMC21] Table 8, DMCS, percent */
    double deviation;        /* mean, of the formula, at most: Table 6; 0: not to be compared */
    double quality, relaxed; /* equation (9), mean: Table 8, and the aim with relaxation */
} figure_row;

static const figure_row figures[] = {
    {"gen2", 64, QN_F64, QN_INSIDE_BELOW, 0, 8.85, 0, 0.87, 0.90},
    {"gen2", 128, QN_F64, QN_INSIDE_BELOW, 0, 5.95, 0, 0.87, 0.90},
    {"gen2", 256, QN_F64, QN_INSIDE_BELOW, 16158, 5.14, 0, 0.87, 0.90},
    {"iwp", 512, QN_F32, QN_INSIDE_ABOVE, 346907, 4.22, 0.97e-4, 0.90, 0.92},
};

static qn_mesh *figure_mesh(qn_context *context, const qn_volume *volume, const figure_row *row,
                            int32_t passes, int32_t relax, qn_surface_report *report) {
    qn_surface_options options;
    qn_error error;
    qn_mesh *mesh;
    qn_surface_options_init(&options);
    options.inside = row->inside;
    options.open = true;
    options.simplify = true;
    options.simplify_passes = passes;
    options.relax = relax;
    if (qn_surface(context, volume, &options, &mesh, report, &error) != QN_OK)
        fail_msg("%s %lld: %s", row->name, (long long)row->n, error.message);
    return mesh;
}

/* From iWP's formula, which is one of the cosines. */
static double mean_deviation(const figure_row *row, const qn_mesh *mesh) {
    const test_analytic *analytic = test_analytic_find(row->name);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    double sum = 0;
    for (int64_t v = 0; v < view.vertex_count; ++v) {
        double c[3];
        for (int a = 0; a < 3; ++a)
            c[a] = cos(analytic->first +
                       analytic->span * (double)view.positions[3 * v + a] / (double)(row->n - 1));
        sum += fabs(analytic->value(c[0], c[1], c[2]));
    }
    return sum / (double)view.vertex_count;
}

static void figures_of_the_paper_are_reached(void **state) {
    (void)state;
    qn_context *context = test_context(0);
    for (size_t i = 0; i < (test_is_long() ? 4 : 3); ++i) {
        const figure_row *row = figures + i;
        void *samples;
        qn_surface_report report;
        qn_volume *volume = test_analytic_volume(context, test_analytic_find(row->name), row->n,
                                                 row->scalar, &samples);
        qn_mesh *mesh = figure_mesh(context, volume, row, -1, 0, &report);
        printf("%s %lld: by the paper's rule %lld + %lld quads removed", row->name,
               (long long)row->n, (long long)report.merged_quads, (long long)report.shrunk_quads);
        qn_mesh_destroy(mesh);
        mesh = figure_mesh(context, volume, row, 0, 0, &report);
        const qn_mesh_report plain = test_mesh_topology(context, mesh);
        const double deviation = row->deviation > 0 ? mean_deviation(row, mesh) : 0;
        qn_mesh_destroy(mesh);
        printf("; %lld (%lld) + %lld in %d passes, irregular %.2f %% (at most %.2f), quality %.4f "
               "(%.2f)",
               (long long)report.merged_quads, (long long)row->merged,
               (long long)report.shrunk_quads, (int)report.simplify_passes,
               100 * plain.irregular_vertices, row->irregular, plain.quad_quality_mean,
               row->quality);
        mesh = figure_mesh(context, volume, row, 0, 3, &report);
        const qn_mesh_report relaxed = test_mesh_topology(context, mesh);
        qn_mesh_destroy(mesh);
        printf(", relaxed %.4f (%.2f), least %.3f after %.3f\n", relaxed.quad_quality_mean,
               row->relaxed, relaxed.quad_quality_min, plain.quad_quality_min);
        assert_true(report.merged_quads >= row->merged);
        assert_true(100 * plain.irregular_vertices <= row->irregular);
        assert_true(deviation <= row->deviation);
        assert_true(plain.quad_quality_mean >= row->quality &&
                    relaxed.quad_quality_mean >= row->relaxed);
        assert_true(plain.manifold && plain.oriented && relaxed.manifold && relaxed.oriented);
        qn_volume_destroy(volume);
        free(samples);
    }
    test_context_end(context);
}

/* ---- a rod, a cube ----------------------------------------------------------------------------
 */

/* A rod of square section on a plate would be eaten from its end if rings were removed one after
 * the other. */
static void a_rod_keeps_its_length(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_field field = test_field_make(9, 9, 40);
    for (int z = 0; z < 40; ++z)
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 9; ++x)
                field.values[(z * 9 + y) * 9 + x] =
                    (x == 4 && y == 4 && z < 37) || (z < 3) ? 1 : -1;
    test_field_prepare(&field);
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.simplify = true;
    qn_mesh *mesh = surface(context, &field, &options, NULL);
    const qn_mesh_report report = test_mesh_topology(context, mesh);
    assert_true(report.bounds[1][2] > 36.25 && report.manifold && report.closed);
    assert_int_equal(report.euler_characteristic, 2);
    qn_mesh_destroy(mesh);
    test_field_free(&field);
    test_context_end(context);
}

/* All eight vertices of valence 3: nothing can go without making the mesh non-manifold. */
static void a_cube_stays(void **state) {
    (void)state;
    static const float positions[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                          {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    static const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const qn_mesh_view view = {
        .vertex_count = 8, .quad_count = 6, .positions = positions[0], .quads = quads[0]};
    const qni_simplify_options until_done = {.passes = 0};
    qn_context *context = test_context(1);
    qni_simplify_report report;
    qn_mesh *mesh;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    assert_int_equal(qni_simplify(context, mesh, &until_done, &report, NULL),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_int_equal(qn_mesh_build_halfedges(context, mesh, NULL), QN_OK);
    assert_int_equal(qni_simplify(context, mesh, &until_done, &report, NULL), QN_OK);
    assert_int_equal(qn_mesh_get_view(mesh).quad_count, 6);
    assert_memory_equal(qn_mesh_get_view(mesh).quads, quads, sizeof quads);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

/* ---- no memory --------------------------------------------------------------------------------
 */

typedef struct trouble {
    _Atomic int64_t allocations;
    int64_t failing;
} trouble;

static void *alloc_or_fail(void *user, size_t size, size_t alignment) {
    trouble *t = user;
    void *memory = NULL;
    if (atomic_fetch_add(&t->allocations, 1) + 1 == t->failing)
        return NULL;
    return posix_memalign(&memory, alignment, size) == 0 ? memory : NULL;
}

static void plain_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

static void failed_allocations_leave_nothing(void **state) {
    (void)state;
    test_random random = {test_seed()};
    test_field field = test_random_field(&random, TEST_SMOOTHED_NOISE, 16);
    qn_status status = QN_ERROR_OUT_OF_MEMORY;
    int64_t n = 0;
    while (status != QN_OK) {
        trouble t = {0, 0};
        qn_context_options options;
        qn_context_options_init(&options);
        options.allocator = (qn_allocator){&t, alloc_or_fail, plain_free};
        options.threads = 2;
        qn_context *context;
        assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
        qn_volume *volume = test_field_volume(context, &field);
        qn_surface_options how = test_field_options(&field);
        how.simplify = true;
        how.relax = 1;
        how.skip_normals = true;
        qn_mesh *mesh;
        qn_error error;
        t.failing = atomic_load(&t.allocations) + ++n;
        status = qn_surface(context, volume, &how, &mesh, NULL, &error);
        if (status != QN_OK) {
            assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
            assert_null(mesh);
        }
        qn_mesh_destroy(mesh);
        qn_volume_destroy(volume);
        test_context_end(context);
    }
    printf("%lld allocations failed in turn\n", (long long)(n - 1));
    assert_true(n > 15);
    test_field_free(&field);
}

static void wrong_options_are_named(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_field field = test_field_make(3, 3, 3);
    test_field_prepare(&field);
    qn_volume *volume = test_field_volume(context, &field);
    qn_surface_options options = test_field_options(&field);
    qn_mesh *mesh;
    qn_error error;
    options.relax = -1;
    assert_int_equal(qn_surface(context, volume, &options, &mesh, NULL, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    options.relax = 0;
    options.simplify_passes = -2;
    assert_int_equal(qn_surface(context, volume, &options, &mesh, NULL, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    qn_volume_destroy(volume);
    test_field_free(&field);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(topology_and_surface_stay),
        cmocka_unit_test(ends_of_doubled_edges_stay),
        cmocka_unit_test(nothing_is_left_and_halfedges_are_right),
        cmocka_unit_test(bytes_are_equal_for_1_2_8_threads),
        cmocka_unit_test(halfedges_change_nothing),
        cmocka_unit_test(long_rows_of_leaves_change_nothing),
        cmocka_unit_test(figures_of_the_paper_are_reached),
        cmocka_unit_test(a_rod_keeps_its_length),
        cmocka_unit_test(a_cube_stays),
        cmocka_unit_test(failed_allocations_leave_nothing),
        cmocka_unit_test(wrong_options_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
