// SPDX-License-Identifier: MIT
/* The promises on random CSG scenes: closed, manifold, oriented, free of self-intersections, on the
 * coordinates as written; every face segment used once forward and once reversed (else the surface
 * ends with an error). */
#include "lib/random_solid.h"

typedef struct flaws {
    int64_t scenes, flawed, boundary, edges, vertices, conflicts, crossings, degenerate, unresolved;
} flaws;

static void add_flaws(flaws *sum, const qn_mesh_report *mesh,
                      const qn_solid_surface_report *surface, uint64_t seed, int depth, int mode) {
    const int64_t wrong = mesh->boundary_edges + mesh->nonmanifold_edges +
                          mesh->nonmanifold_vertices + mesh->orientation_conflicts +
                          mesh->self_intersections + mesh->degenerate_faces;
    ++sum->scenes;
    sum->boundary += mesh->boundary_edges;
    sum->edges += mesh->nonmanifold_edges;
    sum->vertices += mesh->nonmanifold_vertices;
    sum->conflicts += mesh->orientation_conflicts;
    sum->crossings += mesh->self_intersections;
    sum->degenerate += mesh->degenerate_faces;
    sum->unresolved += surface->unresolved_cells;
    if (wrong == 0)
        return;
    ++sum->flawed;
    print_message("scene seed %llu depth %d mode %d: %lld boundary, %lld edges, %lld vertices, "
                  "%lld conflicts, %lld "
                  "intersections, %lld degenerate; %lld unresolved, %lld triangles\n",
                  (unsigned long long)seed, depth, mode, (long long)mesh->boundary_edges,
                  (long long)mesh->nonmanifold_edges, (long long)mesh->nonmanifold_vertices,
                  (long long)mesh->orientation_conflicts, (long long)mesh->self_intersections,
                  (long long)mesh->degenerate_faces, (long long)surface->unresolved_cells,
                  (long long)mesh->triangle_count);
}

enum { PLAIN, UNIFORM, ADAPTIVE, MODES };

static void one_scene(flaws *sum, uint64_t seed, int depth, int mode) {
    qn_context *context = test_context(1);
    test_random random = {seed};
    qn_solid *scene = test_random_scene(context, &random, 3.4 / (1 << depth));
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = depth;
    options.no_features = mode == PLAIN;
    options.uniform = mode != ADAPTIVE;
    qn_mesh *mesh;
    qn_solid_surface_report surface;
    qn_mesh_report report;
    qn_error error;
    if (qn_solid_surface(context, scene, &options, &mesh, &surface, &error) != QN_OK)
        fail_msg("scene seed %llu depth %d mode %d: %s", (unsigned long long)seed, depth, mode,
                 error.message);
    assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, NULL), QN_OK);
    add_flaws(sum, &report, &surface, seed, depth, mode);
    qn_mesh_destroy(mesh);
    qn_solid_destroy(scene);
    test_context_end(context);
}

static void run_mode(int mode) {
    flaws sum = {0};
    const uint64_t seed = test_seed();
    const int64_t count = test_count(60, 1000);
    for (int64_t n = 0; n < count; ++n)
        one_scene(&sum, seed + (uint64_t)n, 4 + (int)(n % (test_is_long() ? 5 : 3)), mode);
    print_message("mode %d: %lld scenes, %lld flawed: %lld boundary edges, %lld non-manifold "
                  "edges, %lld non-manifold vertices, %lld "
                  "conflicts, %lld self-intersections, %lld degenerate; %lld unresolved cells\n",
                  mode, (long long)sum.scenes, (long long)sum.flawed, (long long)sum.boundary,
                  (long long)sum.edges, (long long)sum.vertices, (long long)sum.conflicts,
                  (long long)sum.crossings, (long long)sum.degenerate, (long long)sum.unresolved);
    assert_int_equal(sum.flawed, 0);
}

static void plain_marching_cubes_keep_the_promises(void **state) {
    (void)state;
    run_mode(PLAIN);
}

static void uniform_features_keep_the_promises(void **state) {
    (void)state;
    run_mode(UNIFORM);
}

static void adaptive_features_keep_the_promises(void **state) {
    (void)state;
    run_mode(ADAPTIVE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_marching_cubes_keep_the_promises),
        cmocka_unit_test(uniform_features_keep_the_promises),
        cmocka_unit_test(adaptive_features_keep_the_promises),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
