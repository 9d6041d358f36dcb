// SPDX-License-Identifier: MIT
/* Every vertex lies in its cell, on the trilinear surface but for the rounding to float, and on the
 * branch of the surface that its polygon goes round. */
#include "lib/branches.h"
#include "lib/random_volume.h"
#include "lib/reference_match.h"
#include "lib/trilinear.h"

#include <math.h>

typedef struct branch_tally {
    int64_t vertices;
    int64_t shared;        /* vertices of cells with several polygons */
    int64_t branch_checks; /* of these, told by brute force */
    int64_t joined, unseen;
    int64_t slice_points, degenerate_points, fallback_points;
    double largest_deviation; /* relative to the range, rounding included */
    double largest_excess;    /* beyond the rounding of the coordinates */
} branch_tally;

static void check_standing(const test_field *field, const test_polygon *polygon, const float *place,
                           int64_t vertex, branch_tally *tally) {
    test_standing standing = test_vertex_standing(field, polygon->cell, place);
    double range = fmax(field->maximum - field->minimum, 2 * field->largest_distance);
    if (!(standing.outside <= 0))
        fail_msg("%s: vertex %lld lies %g outside of its cell %lld %lld %lld", field->name,
                 (long long)vertex, standing.outside, (long long)polygon->cell[0],
                 (long long)polygon->cell[1], (long long)polygon->cell[2]);
    if (!(standing.deviation <= 1e-6 * range + standing.allowance))
        fail_msg(
            "%s: vertex %lld of cell %lld %lld %lld is %g off the iso-value, range %g, rounding %g",
            field->name, (long long)vertex, (long long)polygon->cell[0],
            (long long)polygon->cell[1], (long long)polygon->cell[2], standing.deviation, range,
            standing.allowance);
    if (range > 0) {
        tally->largest_deviation = fmax(tally->largest_deviation, standing.deviation / range);
        tally->largest_excess =
            fmax(tally->largest_excess, (standing.deviation - standing.allowance) / range);
    }
    tally->vertices += 1;
}

static void local_place(const test_field *field, const int64_t cell[3], const float *place,
                        double local[3], double reach[3]) {
    test_to_index(field, place, local);
    test_rounding(field, place, reach);
    for (int a = 0; a < 3; ++a) {
        local[a] -= (double)cell[a];
        reach[a] *= 2;
    }
}

/* Where polygons overlap: the branch at the vertex, by brute force. */
static void check_branch(const test_field *field, const int64_t cell[3], const uint16_t polygons[4],
                         int count, int own, const double local[3], const double reach[3],
                         branch_tally *tally) {
    test_branches branches = test_branches_make(field, cell, polygons, count, 40);
    tally->joined += branches.joined;
    if (!branches.joined) {
        unsigned mask = test_branches_at(&branches, count, local, reach);
        tally->branch_checks += 1;
        tally->unseen +=
            mask == 0; /* the surface bulges into a box without changing a corner's sign */
        if (mask != 0 && !(mask >> own & 1))
            fail_msg("%s: the vertex of polygon %d (edges %03x) of cell %lld %lld %lld lies on the "
                     "branch of polygons %x, at %.9g %.9g %.9g",
                     field->name, own, polygons[own], (long long)cell[0], (long long)cell[1],
                     (long long)cell[2], mask, local[0], local[1], local[2]);
    }
    test_branches_free(&branches);
}

/* A vertex lies in the box of its polygon, since the branch does; when it lies in the box of
 * another polygon of the cell too, brute force tells. */
static void check_branches(const test_field *field, const test_reference *reference,
                           const test_match *match, const float *positions, int64_t first,
                           int64_t end, branch_tally *tally) {
    const int count = (int)(end - first);
    const int64_t *cell = reference->polygons[first].cell;
    uint16_t polygons[4];
    test_box boxes[4];
    for (int p = 0; p < count; ++p) {
        polygons[p] = reference->polygons[first + p].edges;
        boxes[p] = test_polygon_box(field, cell, polygons[p]);
    }
    for (int64_t v = first; v < end; ++v) {
        const int own = (int)(match->vertex_polygon[v] - first);
        double local[3], reach[3];
        bool elsewhere = false;
        local_place(field, cell, positions + 3 * v, local, reach);
        if (!test_box_holds(&boxes[own], local, reach))
            fail_msg(
                "%s: the vertex of polygon %d (edges %03x) of cell %lld %lld %lld lies outside of "
                "the polygon's box, at %.9g %.9g %.9g",
                field->name, own, polygons[own], (long long)cell[0], (long long)cell[1],
                (long long)cell[2], local[0], local[1], local[2]);
        for (int p = 0; p < count; ++p)
            elsewhere |= p != own && test_box_holds(&boxes[p], local, reach);
        tally->shared += count > 1;
        if (elsewhere)
            check_branch(field, cell, polygons, count, own, local, reach, tally);
    }
}

static int64_t cell_end(const test_reference *reference, int64_t first) {
    int64_t end = first + 1;
    while (end < reference->polygon_count &&
           memcmp(reference->polygons[first].cell, reference->polygons[end].cell,
                  sizeof reference->polygons[first].cell) == 0)
        ++end;
    return end;
}

static void check_field(qn_context *context, const test_field *field, branch_tally *tally) {
    qn_surface_report report;
    qn_mesh *mesh = test_field_surface(context, field, &report);
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    qn_mesh_view view = qn_mesh_get_view(mesh);
    for (int64_t first = 0, end; first < view.vertex_count; first = end) {
        end = cell_end(&reference, first);
        for (int64_t v = first; v < end; ++v)
            check_standing(field, &reference.polygons[first], view.positions + 3 * v, v, tally);
        if (!field->open) /* in closed meshes each vertex's polygon is known */
            check_branches(field, &reference, &match, view.positions, first, end, tally);
    }
    tally->slice_points += report.slice_points;
    tally->degenerate_points += report.degenerate_points;
    tally->fallback_points += report.fallback_points;
    test_match_free(&match);
    test_reference_free(&reference);
    qn_mesh_destroy(mesh);
}

static void print_tally(const char *name, const branch_tally *tally) {
    printf("%-15s %8lld vertices: deviation %.2g of the range (%.2g beyond rounding); %lld "
           "share a cell, %lld told by force, %lld joined, %lld unseen; %lld slices, %lld "
           "degenerate, %lld fallbacks\n",
           name, (long long)tally->vertices, tally->largest_deviation, tally->largest_excess,
           (long long)tally->shared, (long long)tally->branch_checks, (long long)tally->joined,
           (long long)tally->unseen, (long long)tally->slice_points,
           (long long)tally->degenerate_points, (long long)tally->fallback_points);
}

static void vertices_of_random_volumes_lie_on_their_branch(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    const int64_t count = test_count(16, 100);
    for (int kind = 0; kind < TEST_KIND_COUNT; ++kind) {
        branch_tally tally = {0};
        for (int64_t i = 0; i < count; ++i) {
            test_random random = {seed + (uint64_t)(i * TEST_KIND_COUNT + kind)};
            test_field field = test_random_field(&random, (test_kind)kind, 20);
            check_field(context, &field, &tally);
            test_field_free(&field);
        }
        print_tally(test_kind_name((test_kind)kind), &tally);
        assert_true(tally.vertices > 100 && tally.unseen * 20 <= tally.branch_checks);
    }
    test_context_end(context);
}

/* Cells of many polygons, as closed volumes of one cell so that every polygon's quads name it. */
static void vertices_of_single_cells_lie_on_their_branch(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    test_field field = test_field_make(2, 2, 2);
    branch_tally tally = {0};
    for (int64_t i = 0; i < test_count(9000, 60000); ++i) {
        static const int patterns[] = {0x69, 0x96, 0x81, 0x18, 0x42, 0x24, 0x41, 0x14, 0x9f, 0x61};
        test_random_fill(&field, &random, (test_kind)(i % TEST_KIND_COUNT));
        for (int c = 0; c < 8; ++c) {
            double d = field.values[c] - field.iso;
            bool high = patterns[i % 10] >> c & 1;
            field.values[c] = field.iso + ((d < 0) == high ? -d : d);
        }
        field.inside = i & 16 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_prepare(&field);
        check_field(context, &field, &tally);
    }
    print_tally("single cells", &tally);
    assert_true(tally.branch_checks > 300 && tally.unseen * 20 <= tally.branch_checks);
    test_field_free(&field);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertices_of_single_cells_lie_on_their_branch),
        cmocka_unit_test(vertices_of_random_volumes_lie_on_their_branch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
