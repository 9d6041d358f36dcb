// SPDX-License-Identifier: MIT
/* A sparse volume gives the bytes that a dense one of the same values gives, whatever the type, the
 * order of its leaves, the options and the number of threads. */
#include "lib/random_sparse.h"

#include <math.h>

static uint64_t hash_all(uint64_t hash, const qn_mesh *mesh) {
    const qn_halfedges halfedges = qn_mesh_get_halfedges(mesh);
    const uint64_t one = test_hash_mesh(mesh);
    hash = test_hash(hash, &one, sizeof one);
    if (halfedges.twin)
        hash = test_hash(hash, halfedges.twin, (size_t)halfedges.count * sizeof *halfedges.twin);
    return hash;
}

static uint64_t surface_hash(qn_context *context, const qn_volume *volume,
                             const qn_surface_options *options, qn_surface_report *report) {
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface(context, volume, options, &mesh, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    const uint64_t hash = hash_all(TEST_HASH_START, mesh);
    qn_mesh_destroy(mesh);
    return hash;
}

static void expect_same_reports(const qn_surface_report *sparse, const qn_surface_report *dense) {
    assert_int_equal(sparse->cells, dense->cells);
    assert_int_equal(sparse->active_leaves, dense->active_leaves);
    assert_int_equal(sparse->active_cells, dense->active_cells);
    assert_int_equal(sparse->ambiguous_faces, dense->ambiguous_faces);
    assert_int_equal(sparse->vertices, dense->vertices);
    assert_int_equal(sparse->quads, dense->quads);
    assert_int_equal(sparse->repaired_edges, dense->repaired_edges);
    assert_int_equal(sparse->restored_tunnels, dense->restored_tunnels);
    assert_int_equal(sparse->nan_samples, dense->nan_samples);
    assert_int_equal(sparse->infinite_samples, dense->infinite_samples);
}

static qn_surface_options random_options(test_random *random, const double *iso) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = iso;
    options.isovalue_count = 1;
    options.inside = test_random_bits(random) & 1 ? QN_INSIDE_ABOVE : QN_INSIDE_BELOW;
    options.halfedges = test_random_bits(random) & 1;
    options.simplify = test_random_range(random, 0, 3) == 0;
    options.relax = test_random_range(random, 0, 3) == 0 ? 2 : 0;
    options.keep_doubled = test_random_range(random, 0, 3) == 0;
    if (test_random_bits(random) & 1)
        options.topology = QN_TOPOLOGY_EXACT;
    return options;
}

static void compare(const test_sparse *sparse, test_random *random) {
    qn_surface_options options = random_options(random, &sparse->iso);
    qn_surface_report reports[2];
    qn_error error;
    const qn_grid grid = test_sparse_dense(sparse);
    uint64_t hashes[2][2];
    for (int threads = 1; threads <= 3; threads += 2) {
        qn_context *context = test_context(threads);
        qn_volume *volumes[2];
        if (qn_volume_create_sparse(context, &sparse->grid, NULL, NULL, volumes, &error) != QN_OK)
            fail_msg("%s", error.message);
        if (qn_volume_create(context, &grid, NULL, NULL, volumes + 1, &error) != QN_OK)
            fail_msg("%s", error.message);
        for (int dense = 0; dense < 2; ++dense) {
            options.open = dense;
            hashes[threads / 2][dense] =
                surface_hash(context, volumes[dense], &options, reports + dense);
            qn_volume_destroy(volumes[dense]);
        }
        expect_same_reports(reports, reports + 1);
        test_context_end(context);
    }
    assert_true(hashes[0][0] == hashes[0][1]);
    assert_true(hashes[1][0] == hashes[0][0]);
    assert_true(hashes[1][1] == hashes[0][0]);
    free((void *)(uintptr_t)grid.samples);
}

static void bytes_are_those_of_the_dense_volume(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    for (int64_t i = 0; i < test_count(120, 3000); ++i) {
        test_random random = {seed + (uint64_t)i};
        const qn_scalar scalar = i % 2 ? QN_F32 : (qn_scalar)(i / 2 % QN_SCALAR_COUNT);
        test_sparse sparse =
            test_random_sparse(&random, (test_kind)(i % TEST_KIND_COUNT), scalar, 4);
        if (i % 3 == 1) {
            const double matrix[4][4] = {
                {0.5, 0.1, 0, -3}, {0, -0.7, 0.2, 11}, {0.3, 0, 0.9, 0.25}, {0, 0, 0, 1}};
            memcpy(sparse.grid.index_to_world, matrix, sizeof matrix);
        }
        compare(&sparse, &random);
        test_sparse_free(&sparse);
    }
}

static void samples_that_are_no_numbers_follow_the_dense_rule(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    for (int64_t i = 0; i < test_count(30, 500); ++i) {
        test_random random = {seed + 7000 + (uint64_t)i};
        const qn_scalar scalar = i % 2 ? QN_F32 : QN_F64;
        test_sparse sparse = test_random_sparse(&random, TEST_GAUSSIAN, scalar, 3);
        for (int64_t n = 0; n < sparse.grid.leaf_count * 512; ++n) {
            const double odd = n % 3 ? (double)NAN : n % 2 ? (double)INFINITY : -(double)INFINITY;
            if (test_random_range(&random, 0, 199) != 0)
                continue;
            if (scalar == QN_F32)
                ((float *)(uintptr_t)sparse.grid.values)[n] = (float)odd;
            else
                ((double *)(uintptr_t)sparse.grid.values)[n] = odd;
        }
        if (sparse.grid.tile_count && i % 4 == 0)
            ((qn_sparse_tile *)(uintptr_t)sparse.grid.tiles)->value = (double)NAN;
        compare(&sparse, &random);
        test_sparse_free(&sparse);
    }
}

/* ---- what a narrow band does where it ends ----------------------------------------------------
 */

typedef struct band {
    int32_t (*origins)[3];
    float (*values)[512];
    uint64_t (*masks)[8];
    qn_sparse_grid grid;
} band;

/* The leaves of a ball's distance that come nearer than `width` to its surface; values further out
 * are cut off and inactive. */
static band make_ball(double radius, double width) {
    const int32_t reach = (int32_t)(radius + width) / 8 + 1;
    const int64_t most = 8 * (int64_t)(reach + 1) * (reach + 1) * (reach + 1);
    band b = {test_alloc((size_t)most, sizeof *b.origins),
              test_alloc((size_t)most, sizeof *b.values),
              test_alloc((size_t)most, sizeof *b.masks),
              {.scalar = QN_F32}};
    int64_t count = 0;
    for (int32_t z = -reach; z < reach; ++z)
        for (int32_t y = -reach; y < reach; ++y)
            for (int32_t x = -reach; x < reach; ++x) {
                bool near = false;
                memset(b.masks[count], 0, sizeof b.masks[count]);
                for (int n = 0; n < 512; ++n) {
                    const double i = 8 * x + (n & 7), j = 8 * y + (n >> 3 & 7),
                                 k = 8 * z + (n >> 6);
                    const double d = sqrt(i * i + j * j + k * k) - radius;
                    b.values[count][n] = (float)fmax(-width, fmin(width, d));
                    if (fabs(d) < width) {
                        near = true;
                        b.masks[count][n >> 6] |= UINT64_C(1) << (n & 63);
                    }
                }
                const int32_t origin[3] = {8 * x, 8 * y, 8 * z};
                memcpy(b.origins[count], origin, sizeof origin);
                count += near;
            }
    b.grid.leaf_count = count;
    b.grid.origins = (const int32_t(*)[3])b.origins;
    b.grid.values = b.values;
    b.grid.masks = (const uint64_t(*)[8])b.masks;
    b.grid.background = width;
    b.grid.kind = QN_SPARSE_LEVEL_SET;
    return b;
}

static void free_band(band *b) {
    free(b->origins);
    free(b->values);
    free(b->masks);
}

/* The pieces of the surface, and the blocks that the gap rule filled. */
static int64_t components(const qn_sparse_grid *grid, int64_t *filled) {
    qn_context *context = test_context(2);
    qn_volume *volume;
    qn_mesh *mesh;
    qn_mesh_report check;
    qn_sparse_info info;
    qn_error error;
    if (qn_volume_create_sparse(context, grid, NULL, NULL, &volume, &error) != QN_OK ||
        qn_surface(context, volume, NULL, &mesh, NULL, &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &check, NULL), QN_OK);
    assert_int_equal(qn_volume_sparse_info(context, volume, &info, NULL), QN_OK);
    assert_int_equal(check.boundary_edges, 0);
    *filled = info.filled_blocks;
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
    return check.components;
}

static void a_band_that_ends_inside_shows_no_false_surface(void **state) {
    (void)state;
    band b = make_ball(40.3, 3);
    int64_t filled;
    assert_int_equal(components(&b.grid, &filled), 1);
    assert_true(filled > 0);
    b.grid.kind =
        QN_SPARSE_UNKNOWN; /* no rule: the values alone speak, and say there is a hollow */
    assert_int_equal(components(&b.grid, &filled), 2);
    assert_int_equal(filled, 0);
    free_band(&b);
}

static void an_inside_tile_beside_background_gives_a_surface(void **state) {
    (void)state;
    const qn_sparse_tile tile = {{-128, 0, 4096}, {128, 256, 512}, -1, true};
    qn_sparse_grid grid = {.scalar = QN_F32, .tile_count = 1, .tiles = &tile, .background = 1};
    int64_t filled;
    assert_int_equal(components(&grid, &filled), 1);
}

static void huge_tiles_cost_their_rows_only(void **state) {
    (void)state;
    /* 4096^3 samples of density and two specks far off: no surface at 2 but round the specks. */
    qn_sparse_tile tiles[3] = {{{0, 0, 0}, {4096, 4096, 4096}, 1, true},
                               {{-8000000, 64, 0}, {8, 8, 8}, 3, true},
                               {{4096, 0, 8000000}, {8, 8, 8}, 3, true}};
    qn_sparse_grid grid = {
        .scalar = QN_F32, .tile_count = 3, .tiles = tiles, .kind = QN_SPARSE_FOG};
    qn_context *context = test_context(1);
    qn_surface_options options;
    qn_surface_report report;
    const double iso = 2;
    qn_volume *volume;
    qn_mesh *mesh;
    qn_surface_options_init(&options);
    options.isovalues = &iso;
    options.isovalue_count = 1;
    options.inside = QN_INSIDE_ABOVE;
    assert_int_equal(qn_volume_create_sparse(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    assert_int_equal(qn_surface(context, volume, &options, &mesh, &report, NULL), QN_OK);
    assert_int_equal(report.active_leaves, 16);
    assert_int_equal(report.quads, 2 * 6 * 64);
    assert_true(qn_context_memory(context).peak_bytes < INT64_C(200) << 20);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_those_of_the_dense_volume),
        cmocka_unit_test(samples_that_are_no_numbers_follow_the_dense_rule),
        cmocka_unit_test(a_band_that_ends_inside_shows_no_false_surface),
        cmocka_unit_test(an_inside_tile_beside_background_gives_a_surface),
        cmocka_unit_test(huge_tiles_cost_their_rows_only),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
