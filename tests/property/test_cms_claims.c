// SPDX-License-Identifier: MIT
/* What Cubical Marching Squares claims beside the four promises: edges and corners exact and
 * tagged, flat parts coarse, thin walls closed, the same bytes for every thread count, failures
 * without leaks. */
#include "lib/random_solid.h"
#include "core/context.h"

#include <math.h>

static qn_mesh *surface(qn_context *context, const qn_solid *solid, int depth, int base,
                        qn_solid_surface_report *report) {
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    options.base = base;
    qn_mesh *mesh;
    qn_error error;
    if (qn_solid_surface(context, solid, &options, &mesh, report, &error) != QN_OK)
        fail_msg("%s", error.message);
    return mesh;
}

static qn_mesh_report check_clean(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_report report;
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    assert_int_equal(report.degenerate_faces, 0);
    return report;
}

static const double cube_half = 0.6;

static qn_solid *turned_cube(qn_context *context, test_random *random, test_frame *frame) {
    *frame = test_random_frame(random, 0.1);
    const double half[3] = {cube_half, cube_half, cube_half};
    qn_solid *cube = test_box(context, frame, half, 0);
    test_solid_set_box(cube, -1.3, 1.3);
    return cube;
}

/* Distances of a body point from the cube's edges and corners: the second smallest and the largest
 * of | |x| - half |. */
static void edge_distances(const test_frame *frame, const float *place, double *edge,
                           double *corner) {
    double off[3];
    for (int k = 0; k < 3; ++k) {
        double x = 0;
        for (int m = 0; m < 3; ++m)
            x += frame->turn[k][m] * ((double)place[m] - frame->origin[m]);
        off[k] = fabs(fabs(x) - cube_half);
    }
    const double least = fmin(off[0], fmin(off[1], off[2])),
                 most = fmax(off[0], fmax(off[1], off[2]));
    *edge = off[0] + off[1] + off[2] - least - most;
    *corner = most;
}

static double distance(const float *a, const float *b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k)
        sum += ((double)a[k] - (double)b[k]) * ((double)a[k] - (double)b[k]);
    return sqrt(sum);
}

/* Tagged edges lie near the cube's. How many cubes have exactly their twelve edges and eight
 * corners is told: where the finest lattice hides a plane near a corner a piece of edge can be
 * missing, or up to half a cell off. */
static void tagged_edges_lie_near_a_turned_cubes_edges(void **state) {
    (void)state;
    test_random random = {test_seed()};
    const int64_t count = test_count(12, 200);
    int64_t whole = 0, corners_found = 0;
    double farthest = 0, missing = 0;
    for (int64_t n = 0; n < count; ++n) {
        qn_context *context = test_context(1);
        test_frame frame;
        qn_solid *cube = turned_cube(context, &random, &frame);
        const int depth = 5 + (int)(n % 3);
        qn_solid_surface_report report;
        qn_mesh *mesh = surface(context, cube, depth, n & 1 ? 2 : 8, &report);
        check_clean(context, mesh);
        const qn_mesh_view view = qn_mesh_get_view(mesh);
        double length = 0, worst = 0;
        bool corners[8] = {false};
        for (int64_t e = 0; e < view.crease_edge_count; ++e) {
            const float *ends[2] = {view.positions + 3 * view.crease_edges[2 * e],
                                    view.positions + 3 * view.crease_edges[2 * e + 1]};
            length += distance(ends[0], ends[1]);
            for (int k = 0; k < 2; ++k) {
                double edge, corner;
                edge_distances(&frame, ends[k], &edge, &corner);
                worst = fmax(worst, edge);
                if (corner > 1e-4 * report.finest_cell)
                    continue;
                int which = 0;
                for (int m = 0; m < 3; ++m) {
                    double x = 0;
                    for (int i = 0; i < 3; ++i)
                        x += frame.turn[m][i] * ((double)ends[k][i] - frame.origin[i]);
                    which |= (x > 0) << m;
                }
                corners[which] = true;
            }
        }
        assert_true(worst < 0.5 * report.finest_cell);
        whole += fabs(length - 24 * cube_half) < 1e-5 && worst < 1e-4 * report.finest_cell;
        for (int k = 0; k < 8; ++k)
            corners_found += corners[k];
        farthest = fmax(farthest, worst / report.finest_cell);
        missing = fmax(missing, (24 * cube_half - length) / report.finest_cell);
        qn_mesh_destroy(mesh);
        qn_solid_destroy(cube);
        test_context_end(context);
    }
    print_message("%lld of %lld cubes have exactly their edges, at most %.2f cells are missing in "
                  "one; %lld of %lld corners; "
                  "farthest crease vertex %.2g cells off\n",
                  (long long)whole, (long long)count, missing, (long long)corners_found,
                  (long long)(8 * count), farthest);
}

/* A cube has 12 triangles at any depth; the count of leaves does not grow, nor that of the leaves
 * along the edges: all leaves of a cube but those at its corners lie on one plane or one edge. */
static void flat_parts_and_straight_edges_stay_coarse(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    test_random random = {42};
    test_frame frame;
    qn_solid *cube = turned_cube(context, &random, &frame);
    for (int base = 2; base <= 8; base += 6) {
        int64_t first_leaves = 0, first_along = 0;
        for (int depth = 6; depth <= (test_is_long() ? 10 : 8); ++depth) {
            qn_solid_surface_report report;
            qn_mesh_destroy(surface(context, cube, depth, base, &report));
            print_message("base %d depth %d: %lld triangles, %lld leaves, %lld along edges, %lld "
                          "of the two finest levels\n",
                          base, depth, (long long)report.triangles, (long long)report.leaves,
                          (long long)report.crease_loops,
                          (long long)(report.leaves_by_level[0] + report.leaves_by_level[1]));
            first_leaves = first_leaves ? first_leaves : report.leaves;
            first_along = first_along ? first_along : report.crease_loops;
            assert_true((double)report.crease_loops < 1.1 * (double)first_along + 4);
            assert_int_equal(report.triangles, 12);
            assert_true((double)report.leaves < 1.05 * (double)first_leaves);
        }
    }
    qn_solid_destroy(cube);
    test_context_end(context);
}

/* Plates thinner than a cell come out with both sides. */
static void thin_plates_are_closed_and_whole(void **state) {
    (void)state;
    test_random random = {test_seed()};
    const int depth = 5;
    const double cell = 2.6 / qn_depth_cells(depth);
    for (int n = 0; n < 15; ++n) {
        qn_context *context = test_context(1);
        const double thickness = cell * (0.2 + 0.1 * n), half[3] = {0.7, 0.7, 0.5 * thickness};
        const test_frame frame = test_random_frame(&random, 0.1);
        qn_solid *plate = test_box(context, &frame, half, 0);
        test_solid_set_box(plate, -1.3, 1.3);
        qn_solid_surface_report report;
        qn_mesh *mesh = surface(context, plate, depth, 8, &report);
        const qn_mesh_report mesh_report = check_clean(context, mesh);
        const double volume = 1.4 * 1.4 * thickness;
        print_message("plate of %.1f cells: volume %.4f of it, %lld components, genus %lld\n",
                      0.2 + 0.1 * n, mesh_report.volume / volume, (long long)mesh_report.components,
                      (long long)mesh_report.genus_sum);
        qn_mesh_destroy(mesh);
        qn_solid_destroy(plate);
        test_context_end(context);
    }
}

/* Plates of some cells lose nothing at their rims, where coarse leaves meet fine ones. */
static void plates_keep_their_rims(void **state) {
    (void)state;
    test_random random = {test_seed()};
    const int depth = 6;
    const double cell = 2.6 / qn_depth_cells(depth);
    double least = 1, most = 1;
    for (int64_t n = 0; n < test_count(8, 100); ++n) {
        qn_context *context = test_context(2);
        const double thickness = cell * (2.5 + 4 * test_random_unit(&random));
        const double half[3] = {0.7, 0.7, 0.5 * thickness};
        const test_frame frame = test_random_frame(&random, 0.1);
        qn_solid *plate = test_box(context, &frame, half, 0);
        test_solid_set_box(plate, -1.3, 1.3);
        qn_solid_surface_report report;
        qn_mesh *mesh = surface(context, plate, depth, 8, &report);
        const double share = check_clean(context, mesh).volume / (1.4 * 1.4 * thickness);
        least = fmin(least, share);
        most = fmax(most, share);
        qn_mesh_destroy(mesh);
        qn_solid_destroy(plate);
        test_context_end(context);
    }
    print_message("volume %.6f to %.6f of the plates'\n", least, most);
    assert_true(least > 0.999 && most < 1.001);
}

static uint64_t hash_with_threads(uint64_t seed, int32_t threads) {
    qn_context *context = test_context(threads);
    test_random random = {seed};
    qn_solid *scene = test_random_scene(context, &random, 0.05);
    qn_solid_surface_report report;
    qn_mesh *mesh = surface(context, scene, 6, 8, &report);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    uint64_t hash = test_hash_mesh(mesh);
    hash = test_hash(hash, view.triangle_owners, (size_t)view.triangle_count * sizeof(int32_t));
    hash =
        test_hash(hash, view.crease_edges, (size_t)view.crease_edge_count * 2 * sizeof(uint32_t));
    qn_mesh_destroy(mesh);
    qn_solid_destroy(scene);
    test_context_end(context);
    return hash;
}

static void bytes_do_not_depend_on_threads(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    for (uint64_t n = 0; n < (uint64_t)test_count(4, 60); ++n) {
        const uint64_t one = hash_with_threads(seed + n, 1);
        assert_true(one == hash_with_threads(seed + n, 2));
        assert_true(one == hash_with_threads(seed + n, 5));
    }
}

typedef struct failing {
    int64_t left;
} failing;

static void *failing_alloc(void *user, size_t size, size_t alignment) {
    failing *f = user;
    if (f->left-- <= 0)
        return NULL;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void failing_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

/* Every allocation fails once: the right code, nothing held. */
static void lack_of_memory_is_an_error_without_leak(void **state) {
    (void)state;
    qn_context *ground = test_context(1);
    test_random random = {7};
    test_frame frame;
    qn_solid *cube = turned_cube(ground, &random, &frame);
    qn_status status = QN_ERROR_OUT_OF_MEMORY;
    for (int64_t allowed = 1; status != QN_OK; allowed += 1 + allowed / 16) {
        failing f = {allowed + 1};
        qn_context_options options;
        qn_context_options_init(&options);
        options.threads = 1;
        options.allocator.user = &f;
        options.allocator.alloc = failing_alloc;
        options.allocator.free = failing_free;
        qn_context *context;
        assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
        qn_solid_surface_options surface_options;
        qn_solid_surface_options_init(&surface_options);
        surface_options.depth = 4;
        qn_mesh *mesh;
        status = qn_solid_surface(context, cube, &surface_options, &mesh, NULL, NULL);
        assert_true(status == QN_OK || (status == QN_ERROR_OUT_OF_MEMORY && !mesh));
        qn_mesh_destroy(mesh);
        assert_int_equal(qn_context_memory(context).current_bytes, 0);
        qn_context_destroy(context);
    }
    qn_solid_destroy(cube);
    test_context_end(ground);
}

static int stop_at(void *user, const char *stage, double fraction) {
    (void)stage;
    (void)fraction;
    return --*(int *)user < 0;
}

static void cancelling_is_an_error_without_leak(void **state) {
    (void)state;
    qn_context *ground = test_context(1);
    test_random random = {7};
    test_frame frame;
    qn_solid *cube = turned_cube(ground, &random, &frame);
    qn_status status = QN_ERROR_CANCELLED;
    int cancelled = 0;
    for (int allowed = 0; status != QN_OK; ++allowed) {
        int left = allowed;
        qn_context_options options;
        qn_context_options_init(&options);
        options.threads = 1;
        options.progress = stop_at;
        options.user = &left;
        qn_context *context;
        assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
        qn_mesh *mesh;
        qn_solid_surface_options surface_options;
        qn_solid_surface_options_init(&surface_options);
        surface_options.depth = 6;
        status = qn_solid_surface(context, cube, &surface_options, &mesh, NULL, NULL);
        assert_true(status == QN_OK || (status == QN_ERROR_CANCELLED && !mesh));
        cancelled += status != QN_OK;
        qn_mesh_destroy(mesh);
        assert_int_equal(qn_context_memory(context).current_bytes, 0);
        qn_context_destroy(context);
    }
    assert_true(cancelled > 4);
    qn_solid_destroy(cube);
    test_context_end(ground);
}

/* A box that cuts the solid: closed by exact caps, or left open with all boundary at the lattice's
 * outer planes. */
static void a_box_cuts_the_solid(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    const double centre[3] = {0, 0, 0};
    qn_solid *sphere = test_sphere(context, centre, 1, 0);
    test_solid_set_box(sphere, -1.1, 1.1);
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = 6;
    options.has_box = true;
    for (int k = 0; k < 3; ++k) {
        options.low[k] = -2;
        options.high[k] = 2;
    }
    options.high[0] = 0.25;
    for (int open = 0; open < 2; ++open) {
        options.open = open;
        qn_mesh *mesh;
        qn_mesh_report report;
        assert_int_equal(qn_solid_surface(context, sphere, &options, &mesh, NULL, NULL), QN_OK);
        assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
        assert_int_equal(report.self_intersections, 0);
        assert_true(report.manifold && report.oriented && report.closed == !open);
        assert_true(report.bounds[1][0] <= 0.25 + 1e-6);
        if (!open) {
            const double cut =
                3.14159265358979 * 0.75 * 0.75 * (3 - 0.75) / 3; /* the cap that is gone */
            assert_true(fabs(report.volume - (4 * 3.14159265358979 / 3 - cut)) < 0.02);
            assert_true(fabs(report.bounds[1][0] - 0.25) < 1e-6);
        }
        qn_mesh_destroy(mesh);
    }
    qn_solid_destroy(sphere);
    test_context_end(context);
}

/* Cells of a size that is no share of the solid: as many as that takes, or a sentence. */
static void cells_have_the_size_asked_for(void **state) {
    (void)state;
    qn_context *context = test_context(2);
    const double centre[3] = {0.3, 0.2, 0.1};
    qn_solid *sphere = test_sphere(context, centre, 1, 0);
    test_solid_set_box(sphere, -1, 1.5);
    for (int n = 0; n < 6; ++n) {
        const double cell = 0.3 / (1 + 2.3 * n);
        qn_solid_surface_options options;
        qn_solid_surface_options_init(&options);
        options.cell = cell;
        qn_solid_surface_report report;
        qn_mesh *mesh;
        assert_int_equal(qn_solid_surface(context, sphere, &options, &mesh, &report, NULL), QN_OK);
        assert_true(fabs(report.finest_cell / cell - 1) < 1e-12);
        check_clean(context, mesh);
        qn_mesh_destroy(mesh);
        options.depth = 6;
        assert_int_equal(qn_solid_surface(context, sphere, &options, &mesh, NULL, NULL),
                         QN_ERROR_INVALID_ARGUMENT);
        options.depth = 0;
        options.cell = 2.5 / (1.01 * qn_depth_cells(QN_MAX_DEPTH));
        assert_int_equal(qn_depth_of_cell(options.cell, 2.5), QN_MAX_DEPTH + 1);
        assert_int_equal(qn_solid_surface(context, sphere, &options, &mesh, NULL, NULL),
                         QN_ERROR_INVALID_ARGUMENT);
    }
    qn_solid_destroy(sphere);
    test_context_end(context);
}

/* Split on request: each corner's normal is that of its face, and the mesh itself stays closed. */
static void normals_split_at_creases(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    test_random random = {test_seed()};
    test_frame frame;
    qn_solid *cube = turned_cube(context, &random, &frame);
    qn_solid_surface_report report;
    qn_mesh *mesh = surface(context, cube, 6, 8, &report), *split;
    assert_int_equal(qn_mesh_split_normals(context, mesh, &split, NULL), QN_OK);
    check_clean(context, mesh);
    const qn_mesh_view view = qn_mesh_get_view(split), whole = qn_mesh_get_view(mesh);
    assert_int_equal(view.triangle_count, whole.triangle_count);
    assert_true(view.vertex_count > whole.vertex_count);
    qn_mesh_report split_report;
    assert_int_equal(qn_mesh_check(context, split, NULL, &split_report, NULL), QN_OK);
    assert_int_equal(split_report.components, 6);
    for (int64_t h = 0; h < 3 * view.triangle_count; ++h) {
        const float *normal = view.normals + 3 * view.triangles[h];
        double most = 0;
        assert_memory_equal(view.positions + 3 * view.triangles[h],
                            whole.positions + 3 * whole.triangles[h], 3 * sizeof(float));
        for (int m = 0; m < 3; ++m) {
            double along = 0;
            for (int k = 0; k < 3; ++k)
                along += frame.turn[m][k] * (double)normal[k];
            most = fmax(most, fabs(along));
        }
        assert_true(most > 1 - 1e-5);
    }
    qn_mesh_destroy(split);
    qn_mesh_destroy(mesh);
    qn_solid_destroy(cube);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tagged_edges_lie_near_a_turned_cubes_edges),
        cmocka_unit_test(flat_parts_and_straight_edges_stay_coarse),
        cmocka_unit_test(cells_have_the_size_asked_for),
        cmocka_unit_test(normals_split_at_creases),
        cmocka_unit_test(thin_plates_are_closed_and_whole),
        cmocka_unit_test(plates_keep_their_rims),
        cmocka_unit_test(bytes_do_not_depend_on_threads),
        cmocka_unit_test(lack_of_memory_is_an_error_without_leak),
        cmocka_unit_test(cancelling_is_an_error_without_leak),
        cmocka_unit_test(a_box_cuts_the_solid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
