// SPDX-License-Identifier: MIT
/* Narrow bands of meshes: distances and signs against brute force, offsets and shells of known
 * volume, closed surfaces, the same bytes for any number of threads, failures. */
#include "lib/closed_mesh.h"
#include "lib/failing.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* ---- looking into a band -----------------------------------------------------------------------
 */

/* A sparse grid with an index of its leaves, small ones only. */
typedef struct opened_band {
    const qn_sparse_grid *grid;
    int32_t low[3], size[3]; /* in leaves */
    int64_t *leaf;           /* -1: none */
} opened_band;

static opened_band open_band(const qn_volume *volume) {
    opened_band band = {.grid = qn_volume_sparse_grid(volume)};
    int32_t high[3];
    assert_non_null(band.grid);
    assert_true(band.grid->leaf_count > 0);
    for (int i = 0; i < 3; ++i) {
        band.low[i] = INT32_MAX;
        high[i] = INT32_MIN;
        for (int64_t n = 0; n < band.grid->leaf_count; ++n) {
            const int32_t at = band.grid->origins[n][i] >> 3;
            band.low[i] = at < band.low[i] ? at : band.low[i];
            high[i] = at > high[i] ? at : high[i];
        }
        band.size[i] = high[i] - band.low[i] + 1;
    }
    const int64_t count = (int64_t)band.size[0] * band.size[1] * band.size[2];
    band.leaf = test_alloc((size_t)count, sizeof *band.leaf);
    for (int64_t n = 0; n < count; ++n)
        band.leaf[n] = -1;
    for (int64_t n = 0; n < band.grid->leaf_count; ++n) {
        const int32_t *o = band.grid->origins[n];
        band.leaf[((int64_t)((o[2] >> 3) - band.low[2]) * band.size[1] + (o[1] >> 3) -
                   band.low[1]) *
                      band.size[0] +
                  (o[0] >> 3) - band.low[0]] = n;
    }
    return band;
}

/* The value at a sample by the value rule, and whether the band has it. */
static double value_at(const opened_band *band, const int32_t p[3], bool *active) {
    int64_t place = 0;
    bool within = true;
    for (int i = 2; i >= 0; --i) {
        const int32_t at = (p[i] >> 3) - band->low[i];
        within = within && at >= 0 && at < band->size[i];
        place = place * band->size[i] + at;
    }
    const int64_t n = within ? band->leaf[place] : -1;
    *active = false;
    if (n >= 0) {
        const int at = (p[0] & 7) + 8 * (p[1] & 7);
        *active = band->grid->masks[n][p[2] & 7] >> at & 1;
        return (double)((const float *)band->grid->values)[512 * n + 64 * (p[2] & 7) + at];
    }
    for (int64_t t = 0; t < band->grid->tile_count; ++t) {
        const qn_sparse_tile *tile = &band->grid->tiles[t];
        bool holds = true;
        for (int i = 0; i < 3; ++i)
            holds = holds && p[i] >= tile->origin[i] && p[i] - tile->origin[i] < tile->size[i];
        if (holds)
            return tile->value;
    }
    return band->grid->background;
}

static void place_of(const opened_band *band, const int32_t p[3], double place[3]) {
    for (int i = 0; i < 3; ++i)
        place[i] = band->grid->index_to_world[i][3] + band->grid->index_to_world[i][i] * p[i];
}

/* ---- random models -----------------------------------------------------------------------------
 */

static qn_mesh *random_model(qn_context *context, test_random *random) {
    test_pieces pieces = {0};
    const int64_t count = test_random_range(random, 1, 3);
    for (int64_t n = 0; n < count; ++n) {
        double centre[3], half[3];
        for (int i = 0; i < 3; ++i) {
            centre[i] = test_random_unit(random);
            half[i] = 0.1 + 0.4 * test_random_unit(random);
        }
        const int64_t kind = test_random_range(random, 0, 3);
        if (kind == 0) /* axis-parallel or nearly so: faces and edges along lattice lines */
            test_add_box(&pieces, random, centre, half,
                         1e-7 * (double)test_random_range(random, 0, 1));
        else if (kind == 1)
            test_add_box(&pieces, random, centre, half, 3 * test_random_unit(random));
        else
            test_add_ball(&pieces, random, centre, half[0], 0.3 * test_random_unit(random),
                          (int)test_random_range(random, 1, 6),
                          (int)test_random_range(random, 3, 9));
    }
    return test_pieces_mesh(context, &pieces);
}

static void check_sample(const qn_mesh *mesh, const opened_band *band, const int32_t p[3],
                         double width) {
    double place[3];
    bool active;
    place_of(band, p, place);
    const double value = value_at(band, p, &active);
    const double distance = test_mesh_distance_to(mesh, place);
    const double slack = 1e-6 * width; /* values are floats */
    assert_true(fabs(fabs(value) - fmin(distance, width)) <= slack);
    assert_true(active ? distance < width + slack : distance > width - slack);
    if (distance < 1e-9)
        return;
    const double winding = test_winding_number(mesh, place);
    assert_true(fabs(winding - floor(winding + 0.5)) < 1e-3 || distance < 1e-4);
    if (distance > 1e-4)
        assert_true((value < 0) == (fabs(winding) > 0.5));
}

static void try_random_model(test_random *random) {
    qn_context *context = test_context(2);
    qn_mesh *mesh = random_model(context, random);
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = (int32_t)test_random_range(random, 8, 40);
    options.half_width = 2 + 2 * test_random_unit(random);
    qn_volume *volume = NULL;
    qn_band_report report;
    assert_int_equal(qn_volume_from_mesh(context, mesh, &options, &volume, &report, NULL), QN_OK);
    assert_true(report.disagreeing_lines == 0 && report.lines > 0);
    opened_band band = open_band(volume);
    for (int n = 0; n < 500; ++n) {
        int32_t p[3];
        for (int i = 0; i < 3; ++i)
            p[i] =
                8 * band.low[i] - 8 + (int32_t)test_random_range(random, 0, 8 * band.size[i] + 15);
        check_sample(mesh, &band, p, report.background);
    }
    free(band.leaf);
    qn_volume_destroy(volume);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void values_are_signed_distances(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int64_t n = 0; n < test_count(40, 2000); ++n)
        try_random_model(&random);
}

/* Two samples that share a ball without surface are on one side; and inside never meets the
 * background outside. */
static void check_neighbours(const opened_band *band, const int32_t p[3], double voxel) {
    bool active;
    const double value = value_at(band, p, &active);
    for (int axis = 0; axis < 3; ++axis) {
        int32_t q[3] = {p[0], p[1], p[2]};
        ++q[axis];
        const double other = value_at(band, q, &active);
        if (fmax(fabs(value), fabs(other)) > voxel * (1 + 1e-6))
            assert_true((value < 0) == (other < 0));
        assert_true(fabs(fabs(value) - fabs(other)) <= voxel * (1 + 1e-5));
    }
}

static void signs_never_leak(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int64_t n = 0; n < test_count(20, 1000); ++n) {
        qn_context *context = test_context(1);
        qn_mesh *mesh = random_model(context, &random);
        qn_band_options options;
        qn_band_options_init(&options);
        options.dim = (int32_t)test_random_range(&random, 8, 32);
        options.sign = test_random_range(&random, 0, 1) ? QN_MESH_SIGN_PARITY : QN_MESH_SIGN_AUTO;
        qn_volume *volume = NULL;
        qn_band_report report;
        assert_int_equal(qn_volume_from_mesh(context, mesh, &options, &volume, &report, NULL),
                         QN_OK);
        assert_int_equal(report.disagreeing_lines, 0);
        opened_band band = open_band(volume);
        int32_t p[3];
        for (p[2] = 8 * band.low[2] - 1; p[2] <= 8 * (band.low[2] + band.size[2]); ++p[2])
            for (p[1] = 8 * band.low[1] - 1; p[1] <= 8 * (band.low[1] + band.size[1]); ++p[1])
                for (p[0] = 8 * band.low[0] - 1; p[0] <= 8 * (band.low[0] + band.size[0]); ++p[0])
                    check_neighbours(&band, p, report.voxel);
        free(band.leaf);
        qn_volume_destroy(volume);
        qn_mesh_destroy(mesh);
        test_context_end(context);
    }
}

/* ---- surfaces ----------------------------------------------------------------------------------
 */

static qn_mesh *one_box(qn_context *context, const double half[3]) {
    test_pieces pieces = {0};
    test_random random = {1};
    const double centre[3] = {0.1, -0.2, 0.3};
    test_add_box(&pieces, &random, centre, half, 0);
    return test_pieces_mesh(context, &pieces);
}

/* The surface of the band by dual marching cubes, which must be closed and manifold. */
static qn_mesh_report surface_of(qn_context *context, const qn_mesh *mesh,
                                 const qn_band_options *options) {
    qn_volume *volume = NULL;
    qn_mesh *surface = NULL;
    qn_mesh_report check;
    qn_surface_options how;
    qn_surface_options_init(&how);
    how.inside = QN_INSIDE_BELOW;
    assert_int_equal(qn_volume_from_mesh(context, mesh, options, &volume, NULL, NULL), QN_OK);
    assert_int_equal(qn_surface(context, volume, &how, &surface, NULL, NULL), QN_OK);
    assert_int_equal(qn_mesh_check(context, surface, NULL, &check, NULL), QN_OK);
    assert_true(check.closed && check.manifold && check.oriented);
    qn_mesh_destroy(surface);
    qn_volume_destroy(volume);
    return check;
}

/* Steiner's formula: the volume within a distance of a box. */
static double grown_box(const double half[3], double d) {
    const double a = 2 * half[0], b = 2 * half[1], c = 2 * half[2];
    return a * b * c + 2 * (a * b + b * c + c * a) * d + pi * (a + b + c) * d * d +
           4.0 / 3 * pi * d * d * d;
}

static double shrunk_box(const double half[3], double d) {
    return 8 * (half[0] - d) * (half[1] - d) * (half[2] - d);
}

static void offsets_are_round_outside_and_sharp_inside(void **state) {
    (void)state;
    const double half[3] = {0.5, 0.4, 0.3};
    qn_context *context = test_context(0);
    qn_mesh *mesh = one_box(context, half);
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = 80;
    const double offsets[4] = {0, 0.1, 0.3, -0.12};
    for (int n = 0; n < 4; ++n) {
        options.offset = offsets[n];
        const qn_mesh_report check = surface_of(context, mesh, &options);
        const double d = offsets[n];
        const double expected = d >= 0 ? grown_box(half, d) : shrunk_box(half, -d);
        assert_true(fabs(check.volume / expected - 1) < 4e-3);
        assert_int_equal(check.components, 1);
        for (int i = 0; i < 3; ++i) /* flat sides lie where they should */
            assert_true(fabs(check.bounds[1][i] - check.bounds[0][i] - 2 * half[i] - 2 * d) < 1e-3);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

static void shells_have_two_sides(void **state) {
    (void)state;
    const double half[3] = {0.5, 0.4, 0.3};
    qn_context *context = test_context(0);
    qn_mesh *mesh = one_box(context, half);
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = 80;
    const double cases[3][2] = {{0, 0.1}, {0.1, 0.1}, {-0.05, 0.1}}; /* offset, thickness */
    for (int n = 0; n < 3; ++n) {
        options.offset = cases[n][0];
        options.shell = cases[n][1];
        const qn_mesh_report check = surface_of(context, mesh, &options);
        const double out = options.offset + options.shell / 2;
        const double in = options.offset - options.shell / 2;
        const double expected =
            grown_box(half, fmax(out, 0)) - (in >= 0 ? grown_box(half, in) : shrunk_box(half, -in));
        assert_true(fabs(check.volume / expected - 1) < 4e-3);
        assert_int_equal(check.components, 2);
    }
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

/* A shell needs no inside: one sheet alone becomes a slab round it. */
static void a_sheet_becomes_a_slab(void **state) {
    (void)state;
    const float positions[4][3] = {{0, 0, 0.01f}, {1, 0, 0}, {1, 1, 0.02f}, {0, 1, 0}};
    const uint32_t quads[4] = {0, 1, 2, 3};
    const qn_mesh_view view = {
        .vertex_count = 4, .quad_count = 1, .positions = positions[0], .quads = quads};
    qn_context *context = test_context(1);
    qn_mesh *mesh = NULL;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = 60;
    options.shell = 0.2;
    const qn_mesh_report check = surface_of(context, mesh, &options);
    const double expected = 0.2 + pi * 0.1 * 0.1 * 2 + 4.0 / 3 * pi * 1e-3;
    assert_true(check.components == 1 && fabs(check.volume / expected - 1) < 5e-3);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

/* A box without some of its sides: lines along x see only holes across x, the others are seen by
 * torn pairs. The sheets over them close it. */
static void holes_are_closed_by_sheets(void **state) {
    (void)state;
    const double half[3] = {0.5, 0.5, 0.5};
    qn_context *context = test_context(2);
    for (int side = 0; side < 3; ++side) {
        qn_mesh *whole = one_box(context, half), *open = NULL;
        qn_mesh_view view = qn_mesh_get_view(whole);
        uint32_t kept[30];
        const int missing[3] = {8, 4, 0}; /* the first of two triangles at low x, y, z */
        for (int t = 0, n = 0; t < 12; ++t)
            if (t / 2 != missing[side] / 2)
                memcpy(kept + 3 * n++, view.triangles + 3 * t, 3 * sizeof *kept);
        view.triangles = kept;
        view.triangle_count = 10;
        assert_int_equal(qn_mesh_create(context, &view, &open, NULL), QN_OK);
        qn_band_options options;
        qn_band_options_init(&options);
        options.dim = 30;
        qn_volume *volume = NULL;
        qn_band_report report;
        assert_int_equal(qn_volume_from_mesh(context, open, &options, &volume, &report, NULL),
                         QN_OK);
        assert_int_equal(report.holes, 1);
        assert_true(side == 0 ? report.disagreeing_lines > 0 : report.torn_pairs > 0);
        qn_volume_destroy(volume);
        const qn_mesh_report check = surface_of(context, open, &options);
        assert_true(check.volume > 0.7 && check.volume < 1.05 && check.components == 1);
        qn_mesh_destroy(open);
        qn_mesh_destroy(whole);
    }
    test_context_end(context);
}

/* ---- solids ------------------------------------------------------------------------------------
 */

/* A box with a round hole through it: volume and genus are known. */
static qn_solid *drilled_box(qn_context *context) {
    const double low[3] = {-1, -0.8, -0.5}, high[3] = {1, 0.8, 0.5};
    const double down[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, -1}};
    qn_solid *parts[2] = {NULL, NULL}, *drill = NULL, *solid = NULL;
    assert_int_equal(qn_solid_box(context, low, high, &parts[0], NULL), QN_OK);
    assert_int_equal(qn_solid_cylinder(context, 2, 0.4, 0.4, 0, &drill, NULL), QN_OK);
    assert_int_equal(qn_solid_transform(context, drill, down, &parts[1], NULL), QN_OK);
    assert_int_equal(qn_solid_difference(context, 2, parts, &solid, NULL), QN_OK);
    qn_solid_destroy(parts[0]);
    qn_solid_destroy(parts[1]);
    qn_solid_destroy(drill);
    return solid;
}

static void check_solid_samples(const qn_solid *solid, const opened_band *band) {
    int32_t p[3];
    for (p[2] = 8 * band->low[2]; p[2] < 8 * (band->low[2] + band->size[2]); ++p[2])
        for (p[1] = 8 * band->low[1]; p[1] < 8 * (band->low[1] + band->size[1]); ++p[1])
            for (p[0] = 8 * band->low[0]; p[0] < 8 * (band->low[0] + band->size[0]); ++p[0]) {
                double place[1][3], value;
                bool active;
                place_of(band, p, place[0]);
                assert_int_equal(qn_solid_values(solid, 1, (const double(*)[3])place, &value, NULL),
                                 QN_OK);
                const double sampled = value_at(band, p, &active);
                assert_true((sampled < 0) == (value < 0));
                assert_true(!active || fabs(sampled - value) <= 1e-6);
            }
}

static void bands_of_solids_hold_their_values(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    qn_solid *solid = drilled_box(context);
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = 64;
    qn_volume *volume = NULL;
    qn_band_report report;
    assert_int_equal(qn_volume_from_solid(context, solid, &options, &volume, &report, NULL), QN_OK);
    opened_band band = open_band(volume);
    check_solid_samples(solid, &band);
    free(band.leaf);
    qn_mesh *mesh = NULL;
    qn_mesh_report check;
    qn_surface_options how;
    qn_surface_options_init(&how);
    how.inside = QN_INSIDE_BELOW;
    assert_int_equal(qn_surface(context, volume, &how, &mesh, NULL, NULL), QN_OK);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &check, NULL), QN_OK);
    assert_true(check.closed && check.manifold && check.largest_genus == 1);
    assert_true(fabs(check.volume / (3.2 - pi * 0.16) - 1) < 8e-3);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    qn_solid_destroy(solid);
    test_context_end(context);
}

static int ball_values(void *user, int64_t count, const double (*points)[3], double *values) {
    (void)user;
    for (int64_t n = 0; n < count; ++n)
        values[n] = points[n][0] * points[n][0] + points[n][1] * points[n][1] +
                    points[n][2] * points[n][2] - 1;
    return 0;
}

static int stopping_values(void *user, int64_t count, const double (*points)[3], double *values) {
    int64_t *left = user;
    ball_values(NULL, count, points, values);
    return --*left < 0;
}

/* A function without bounds is sampled everywhere; one that stops ends the work. */
static void a_function_alone_is_enough(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid_callback callback;
    qn_solid_callback_init(&callback);
    callback.values = ball_values;
    for (int i = 0; i < 3; ++i) {
        callback.low[i] = -1;
        callback.high[i] = 1;
    }
    qn_solid *solid = NULL;
    qn_volume *volume = NULL;
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = 40;
    assert_int_equal(qn_solid_from_callback(context, &callback, &solid, NULL), QN_OK);
    assert_int_equal(qn_volume_from_solid(context, solid, &options, &volume, NULL, NULL), QN_OK);
    opened_band band = open_band(volume);
    check_solid_samples(solid, &band);
    free(band.leaf);
    qn_volume_destroy(volume);
    qn_solid_destroy(solid);
    int64_t left = 20;
    callback.values = stopping_values;
    callback.user = &left;
    assert_int_equal(qn_solid_from_callback(context, &callback, &solid, NULL), QN_OK);
    assert_int_equal(qn_volume_from_solid(context, solid, &options, &volume, NULL, NULL),
                     QN_ERROR_CANCELLED);
    assert_null(volume);
    qn_solid_destroy(solid);
    test_context_end(context);
}

/* ---- order and failures ------------------------------------------------------------------------
 */

static uint64_t hash_band(const qn_volume *volume) {
    const qn_sparse_grid *grid = qn_volume_sparse_grid(volume);
    const size_t count = (size_t)grid->leaf_count;
    uint64_t hash = test_hash(TEST_HASH_START, grid->origins, count * sizeof *grid->origins);
    hash = test_hash(hash, grid->values, count * 512 * sizeof(float));
    hash = test_hash(hash, grid->masks, count * sizeof *grid->masks);
    for (int64_t t = 0; t < grid->tile_count; ++t)
        hash = test_hash(hash, grid->tiles[t].origin, 2 * sizeof grid->tiles[t].origin);
    return hash;
}

static void threads_change_nothing(void **state) {
    (void)state;
    const test_random start = {test_seed()};
    uint64_t hashes[3];
    for (int n = 0; n < 3; ++n) {
        test_random random = start;
        qn_context *context = test_context(1 + 2 * n);
        qn_mesh *mesh = random_model(context, &random);
        qn_band_options options;
        qn_band_options_init(&options);
        options.dim = 60;
        options.offset = -0.03;
        qn_volume *volume = NULL;
        assert_int_equal(qn_volume_from_mesh(context, mesh, &options, &volume, NULL, NULL), QN_OK);
        hashes[n] = hash_band(volume);
        qn_volume_destroy(volume);
        qn_mesh_destroy(mesh);
        test_context_end(context);
        assert_true(hashes[n] == hashes[0]);
    }
}

static qn_status band_of_a_box(qn_context *context) {
    const double half[3] = {0.5, 0.4, 0.3};
    qn_mesh *mesh = one_box(context, half);
    qn_volume *volume = NULL;
    qn_band_options options;
    qn_band_options_init(&options);
    options.dim = 24;
    const qn_status status = qn_volume_from_mesh(context, mesh, &options, &volume, NULL, NULL);
    assert_true((volume != NULL) == (status == QN_OK));
    qn_volume_destroy(volume);
    qn_mesh_destroy(mesh);
    return status;
}

static void each_allocation_and_each_look_may_fail(void **state) {
    (void)state;
    const int64_t made_before = 4; /* the context and the mesh */
    bool finished = false;
    for (int64_t n = made_before; !finished; ++n) {
        test_failing failing = {n, -1, 0};
        qn_context *context = test_failing_context(&failing);
        const qn_status status = band_of_a_box(context);
        finished = failing.allocations_left >= 0;
        assert_int_equal(status, finished ? QN_OK : QN_ERROR_OUT_OF_MEMORY);
        qn_context_destroy(context);
        assert_int_equal(failing.held, 0);
    }
    finished = false;
    for (int64_t n = 0; !finished; ++n) {
        test_failing failing = {-1, n, 0};
        qn_context *context = test_failing_context(&failing);
        const qn_status status = band_of_a_box(context);
        finished = failing.looks_left >= 0;
        assert_int_equal(status, finished ? QN_OK : QN_ERROR_CANCELLED);
        qn_context_destroy(context);
        assert_int_equal(failing.held, 0);
    }
}

static void refuse(qn_context *context, const qn_mesh *mesh, const qn_band_options *options,
                   qn_status expected) {
    qn_volume *volume = NULL;
    qn_error error;
    assert_int_equal(qn_volume_from_mesh(context, mesh, options, &volume, NULL, &error), expected);
    assert_null(volume);
    assert_true(error.message[0] != '\0');
}

static void what_is_refused(void **state) {
    (void)state;
    const double half[3] = {0.5, 0.4, 0.3}, none[3] = {0, 0, 0};
    qn_context *context = test_context(1);
    qn_mesh *mesh = one_box(context, half), *empty = one_box(context, none);
    qn_band_options good, options;
    qn_band_options_init(&good);
    const double bad_voxels[4] = {-1, (double)NAN, (double)INFINITY, 1e-12};
    for (int n = 0; n < 4; ++n) {
        options = good;
        options.voxel = bad_voxels[n];
        refuse(context, mesh, &options, QN_ERROR_INVALID_ARGUMENT);
    }
    options = good;
    options.half_width = 1;
    refuse(context, mesh, &options, QN_ERROR_INVALID_ARGUMENT);
    options = good;
    options.shell = -0.1;
    refuse(context, mesh, &options, QN_ERROR_INVALID_ARGUMENT);
    options = good;
    options.offset = (double)NAN;
    refuse(context, mesh, &options, QN_ERROR_INVALID_ARGUMENT);
    options = good;
    options.struct_size = 0;
    refuse(context, mesh, &options, QN_ERROR_INVALID_ARGUMENT);
    refuse(context, empty, &good, QN_ERROR_EMPTY);
    qn_mesh_destroy(mesh);
    qn_mesh_destroy(empty);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_signed_distances),
        cmocka_unit_test(signs_never_leak),
        cmocka_unit_test(offsets_are_round_outside_and_sharp_inside),
        cmocka_unit_test(shells_have_two_sides),
        cmocka_unit_test(a_sheet_becomes_a_slab),
        cmocka_unit_test(holes_are_closed_by_sheets),
        cmocka_unit_test(bands_of_solids_hold_their_values),
        cmocka_unit_test(a_function_alone_is_enough),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(each_allocation_and_each_look_may_fail),
        cmocka_unit_test(what_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
