// SPDX-License-Identifier: MIT
/* Seams: a polygon model, a CSG solid and a level set, random ones in random Booleans, in cells so
 * large that many hold several corners. The mesh is clean, and the seams come out unbroken but
 * where corners are lost, beyond a wall that no lattice edge tells of or several in one cell: of
 * what turns by more than 40 degrees 99 points of 100 have a tagged edge within a tenth of a cell,
 * and 99 of 100 sharp edges where two owners meet are tagged, or beside a seam that is not sharp.
 */
#include "lib/level_set.h"
#include "lib/polygon_models.h"
#include "lib/seams.h"

#include <math.h>

typedef struct tree {
    qn_context *context;
    test_random *random;
    qn_volume *volume;
    test_parts parts;
    qn_solid *pair; /* the first two as one */
} tree;

static double between(tree *t, double low, double high) {
    return low + (high - low) * test_random_unit(t->random);
}

static qn_solid *make_polygons(tree *t, bool ball) {
    double low[3], high[3], matrix[3][4];
    const double origin[3] = {0, 0, 0};
    test_model model = {0};
    test_random_matrix(t->random, 0.3, matrix);
    for (int k = 0; k < 3; ++k) {
        low[k] = -between(t, 0.4, 0.8);
        high[k] = between(t, 0.4, 0.8);
    }
    if (ball)
        test_model_ball(&model, origin, between(t, 0.6, 0.9),
                        (int)test_random_range(t->random, 3, 4));
    else
        test_model_box(&model, low, high, matrix);
    return test_model_solid(t->context, &model, 1);
}

/* A block, a column, or a block with a round hole in it, turned. */
static qn_solid *make_csg(tree *t, int kind) {
    double low[3], high[3], matrix[3][4];
    qn_solid *parts[2], *both, *turned, *solid;
    for (int k = 0; k < 3; ++k) {
        low[k] = -between(t, 0.3, 0.7);
        high[k] = between(t, 0.3, 0.7);
    }
    test_random_matrix(t->random, 0.5, matrix);
    const double radius = between(t, 0.2, 0.3);
    assert_int_equal(qn_solid_box(t->context, low, high, &parts[0], NULL), QN_OK);
    assert_int_equal(qn_solid_cylinder(t->context, 1.2, radius, radius, 0, &parts[1], NULL), QN_OK);
    both = parts[kind == 1];
    if (kind == 2)
        assert_int_equal(qn_solid_difference(t->context, 2, parts, &both, NULL), QN_OK);
    assert_int_equal(qn_solid_transform(t->context, both, matrix, &turned, NULL), QN_OK);
    assert_int_equal(qn_solid_with_owner(t->context, turned, 2, &solid, NULL), QN_OK);
    if (kind == 2)
        qn_solid_destroy(both);
    qn_solid_destroy(parts[0]);
    qn_solid_destroy(parts[1]);
    qn_solid_destroy(turned);
    return solid;
}

static qn_solid *join(tree *t, qn_solid *a, qn_solid *b, int sign) {
    qn_solid *const both[2] = {a, b};
    qn_solid *solid;
    assert_int_equal(sign < 0 ? qn_solid_difference(t->context, 2, both, &solid, NULL)
                              : qn_solid_union(t->context, 2, both, &solid, NULL),
                     QN_OK);
    return solid;
}

static void grow(tree *t, int64_t number) {
    double centre[3];
    for (int k = 0; k < 3; ++k)
        centre[k] = between(t, -0.5, 0.5);
    t->volume = test_ball_level_set(t->context, centre, between(t, 0.4, 0.7));
    t->parts.parts[0] = make_polygons(t, number % 2);
    t->parts.parts[1] = make_csg(t, (int)(number % 3));
    t->parts.parts[2] = test_level_set_solid(t->context, t->volume, 3);
    t->parts.signs[0] = 1;
    for (int n = 1; n < TEST_SEAM_PARTS; ++n)
        t->parts.signs[n] = test_random_unit(t->random) < 0.5 ? -1 : 1;
    t->pair = join(t, t->parts.parts[0], t->parts.parts[1], t->parts.signs[1]);
    t->parts.whole = join(t, t->pair, t->parts.parts[2], t->parts.signs[2]);
}

static void fell(tree *t) {
    qn_solid_destroy(t->parts.whole);
    qn_solid_destroy(t->pair);
    for (int n = 0; n < TEST_SEAM_PARTS; ++n)
        qn_solid_destroy(t->parts.parts[n]);
    qn_volume_destroy(t->volume);
}

/* How many corners had to be moved into their cells. */
static int64_t measure(uint64_t seed, int64_t number, test_seams *one) {
    test_random random = {seed};
    tree t = {.context = test_context(1), .random = &random};
    grow(&t, number);
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = 5 + (int)(number % 2);
    options.has_box = true;
    for (int k = 0; k < 3; ++k) {
        options.low[k] = -1.9 - between(&t, 0, 0.1);
        options.high[k] = 1.9 + between(&t, 0, 0.1);
    }
    qn_mesh *mesh;
    qn_mesh_report report;
    qn_solid_surface_report surface;
    qn_error error;
    if (qn_solid_surface(t.context, t.parts.whole, &options, &mesh, &surface, &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_int_equal(qn_mesh_check(t.context, mesh, NULL, &report, NULL), QN_OK);
    assert_true(report.closed && report.manifold && report.oriented);
    assert_int_equal(report.self_intersections, 0);
    test_measure_seams(&t.parts, mesh, surface.finest_cell, one);
    qn_mesh_destroy(mesh);
    fell(&t);
    test_context_end(t.context);
    return surface.escaped_corners;
}

static void random_trees(void **state) {
    (void)state;
    const uint64_t seed = test_seed();
    const int64_t count = test_count(40, 1000);
    test_seams sum = {0};
    int64_t lost = 0;
    for (int64_t n = 0; n < count; ++n) {
        test_seams one = {0};
        const int64_t escaped = measure(seed + 1000003 * (uint64_t)n, n, &one);
        if (one.missing || one.untagged > one.shallow)
            print_message(
                "tree %lld: %lld of %lld points missing, up to %.2f cells off, %lld edges "
                "not tagged, %lld of them shallow, %lld corners moved; at %.6f %.6f "
                "%.6f\n",
                (long long)n, (long long)one.missing, (long long)one.points, one.farthest,
                (long long)one.untagged, (long long)one.shallow, (long long)escaped, one.where[0],
                one.where[1], one.where[2]);
        lost += one.missing || one.untagged > one.shallow;
        sum.edges += one.edges;
        sum.flat += one.flat;
        sum.untagged += one.untagged;
        sum.shallow += one.shallow;
        sum.points += one.points;
        sum.missing += one.missing;
    }
    print_message("%lld trees, %lld of them with a broken seam; %lld edges between owners, %lld of "
                  "them flat, %lld sharp and not tagged, %lld of these shallow; %lld points of "
                  "seams, %lld missing\n",
                  (long long)count, (long long)lost, (long long)sum.edges, (long long)sum.flat,
                  (long long)sum.untagged, (long long)sum.shallow, (long long)sum.points,
                  (long long)sum.missing);
    assert_true(100 * sum.missing <= sum.points);
    assert_true(100 * (sum.untagged - sum.shallow) <= sum.edges);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_trees)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
