// SPDX-License-Identifier: MIT
/* qn_mesh_check() on found models against other judges: edges, components and Euler characteristic
 * counted with NumPy and SciPy, intersecting pairs of triangles with CGAL 5.5.1
 * (box_self_intersection_d and exact predicates, with Quoin's rule for shared vertices; quads cut
 * as Quoin cuts them). None of these numbers came from Quoin. */
#include "lib/support.h"

typedef struct model {
    const char *name;
    int64_t vertices, faces, edges, boundary_edges, nonmanifold_edges, orientation_conflicts;
    int64_t components, euler_characteristic, self_intersections;
} model;

// clang-format off
static const model models[] = {
    {"3holes.off", 3596, 7200, 10800, 0, 0, 0, 1, -4, 0},
    {"ADIS16480.STL.gz", 3672, 7436, 11154, 0, 0, 0, 1, -46, 0},
    {"anchor_dense.off", 3793, 7598, 11397, 0, 0, 0, 1, -6, 0},
    {"armadillo.obj.gz", 43243, 86482, 129723, 0, 0, 0, 1, 2, 0},
    {"beetle-alt.obj.gz", 19887, 38656, 58552, 1136, 0, 0, 1, -9, 5},
    {"boeing.off", 2741, 2564, 5203, 2714, 0, 0, 122, 102, 10976},
    {"bumpy-cube.obj.gz", 19970, 39936, 59904, 0, 0, 0, 1, 2, 0},
    {"busted.STL", 1941, 3878, 5817, 0, 0, 0, 1, 2, 0},
    {"cheese.off", 8629, 17786, 26679, 0, 0, 0, 1, -264, 0},
    {"couplingdown.off", 1841, 3714, 5571, 0, 0, 0, 1, -16, 0},
    {"cow.obj", 2903, 5804, 8706, 0, 0, 0, 1, 1, 81},
    {"cross.off", 40, 76, 114, 0, 0, 0, 1, 2, 0},
    {"elephant.obj", 6034, 12064, 18096, 0, 0, 0, 1, 2, 0},
    {"fandisk.obj", 6475, 12946, 19419, 0, 0, 0, 1, 2, 0},
    {"fandisk_quads.off", 766, 764, 1528, 0, 0, 0, 1, 2, 0},
    {"featuretype.STL", 2010, 3476, 5502, 576, 0, 0, 1, -16, 1216},
    {"gears.stl.gz", 9723, 19426, 29139, 0, 0, 0, 7, 10, 110},
    {"hemisphere.off", 1861, 3600, 5460, 120, 0, 0, 1, 1, 0},
    {"holes.off", 4291, 8288, 12584, 304, 0, 0, 1, -5, 0},
    {"igl-truck.obj", 2956, 4770, 7822, 1388, 54, 64, 59, -96, 422},
    {"itemb.off", 162, 320, 480, 0, 0, 0, 1, 2, 0},
    {"joint.off", 221, 446, 669, 0, 0, 0, 1, -2, 0},
    {"knot1.off", 3200, 6400, 9600, 0, 0, 0, 1, 0, 0},
    {"mech-holes-shark.off", 5246, 10192, 15440, 304, 0, 0, 1, -2, 0},
    {"netgen_part1.stl", 190, 380, 570, 0, 0, 0, 1, 0, 0},
    {"octagonal_pocket.stl", 1658, 3262, 4920, 54, 0, 0, 5, 0, 114},
    {"part.off", 175, 346, 519, 0, 0, 0, 1, 2, 0},
    {"pinion.off", 650, 1300, 1950, 0, 0, 0, 1, 0, 0},
    {"plate_holes.STL", 618, 1252, 1878, 0, 0, 0, 1, -8, 0},
    {"quadknot.obj", 1440, 1440, 2880, 0, 0, 0, 1, 0, 0},
    {"rocker-arm.obj", 10044, 20088, 30132, 0, 0, 0, 1, 0, 0},
    {"rotor_small.off", 2400, 4800, 7200, 0, 0, 0, 1, 0, 0},
    {"screwdriver.off", 3395, 6786, 10179, 0, 0, 0, 1, 2, 0},
    {"self_intersectA.obj.gz", 8582, 17160, 25740, 0, 0, 0, 1, 2, 338},
    {"self_intersectB.obj.gz", 8582, 17160, 25740, 0, 0, 0, 1, 2, 338},
    {"soup.stl", 300, 100, 300, 300, 0, 0, 100, 100, 1248},
    {"spot.obj", 2930, 5856, 8784, 0, 0, 0, 1, 2, 0},
    {"stanford-bunny.obj.gz", 34834, 69451, 104288, 223, 0, 0, 1, -3, 0},
    {"star.off", 14, 24, 36, 0, 0, 0, 1, 2, 0},
    {"suzanne.obj", 507, 500, 1005, 42, 0, 0, 3, 2, 164},
    {"teapot.obj", 3644, 6320, 9998, 1036, 0, 0, 19, -34, 3263},
    {"thingi10k_112932.stl", 3932, 7880, 11820, 0, 0, 0, 2, -8, 0},
    {"thingi10k_472042.stl", 1814, 3632, 5448, 0, 0, 0, 1, -2, 0},
    {"thingi10k_72214.stl", 830, 1660, 2490, 0, 0, 0, 1, 0, 0},
    {"thingi10k_99865.stl.gz", 35987, 71974, 107961, 0, 0, 0, 4, 0, 0},
};
// clang-format on

static void assert_judged(const model *m, const qn_mesh_report *r) {
    assert_int_equal(r->vertex_count - r->unused_vertices, m->vertices);
    assert_int_equal(r->quad_count + r->triangle_count, m->faces);
    assert_int_equal(r->edge_count, m->edges);
    assert_int_equal(r->boundary_edges, m->boundary_edges);
    assert_int_equal(r->nonmanifold_edges, m->nonmanifold_edges);
    assert_int_equal(r->orientation_conflicts, m->orientation_conflicts);
    assert_int_equal(r->components, m->components);
    assert_int_equal(r->euler_characteristic, m->euler_characteristic);
    assert_int_equal(r->self_intersections, m->self_intersections);
}

static void models_are_judged_as_by_others(void **state) {
    (void)state;
    int judged = 0;
    for (size_t i = 0; i < sizeof models / sizeof models[0]; ++i) {
        char name[128], path[1024];
        snprintf(name, sizeof name, "meshes/%s", models[i].name);
        if (!test_data_path(name, path, sizeof path))
            continue;
        qn_context *context = test_context(0);
        qn_mesh *mesh;
        qn_mesh_report report;
        qn_error error = {QN_OK, ""};
        printf("%s\n", models[i].name);
        if (qn_mesh_read(context, path, NULL, &mesh, &error) != QN_OK)
            fail_msg("%s", error.message);
        assert_int_equal(qn_mesh_check(context, mesh, NULL, &report, &error), QN_OK);
        assert_judged(&models[i], &report);
        qn_mesh_destroy(mesh);
        test_context_end(context);
        ++judged;
    }
    if (judged == 0)
        skip();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(models_are_judged_as_by_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
