// SPDX-License-Identifier: MIT
/* The data folder's meshes, of many makers: all are read, with the counts that its README states,
 * and come back the same from PLY. Skipped where the folder is not. */
#include "lib/scratch.h"
#include "lib/support.h"

static const struct {
    const char *name;
    int64_t vertices, faces, quads;
} meshes[] = {
    {"3holes.off", 3596, 7200, 0},
    {"ADIS16480.STL.gz", 3672, 7436, 0},
    {"anchor_dense.off", 3793, 7598, 0},
    {"armadillo.obj.gz", 43243, 86482, 0},
    {"beetle-alt.obj.gz", 19887, 38656, 0},
    {"boeing.off", 2741, 2564, 0},
    {"bumpy-cube.obj.gz", 19970, 39936, 0},
    {"busted.STL", 1941, 3878, 0},
    {"cheese.off", 8629, 17786, 0},
    {"couplingdown.off", 1841, 3714, 0},
    {"cow.obj", 2903, 5804, 0},
    {"cross.off", 40, 76, 0},
    {"elephant.obj", 6034, 12064, 0},
    {"fandisk.obj", 6475, 12946, 0},
    {"fandisk_quads.off", 766, 764, 764},
    {"featuretype.STL", 2010, 3476, 0},
    {"gears.stl.gz", 9723, 19426, 0},
    {"hemisphere.off", 1861, 3600, 0},
    {"holes.off", 4291, 8288, 0},
    {"igl-truck.obj", 2956, 4770, 0},
    {"itemb.off", 162, 320, 0},
    {"joint.off", 221, 446, 0},
    {"knot1.off", 3200, 6400, 0},
    {"mech-holes-shark.off", 5246, 10192, 0},
    {"netgen_part1.stl", 190, 380, 0},
    {"octagonal_pocket.stl", 1658, 3262, 0},
    {"part.off", 175, 346, 0},
    {"pinion.off", 650, 1300, 0},
    {"plate_holes.STL", 618, 1252, 0},
    {"quadknot.obj", 1440, 1440, 1440},
    {"rocker-arm.obj", 10044, 20088, 0},
    {"rotor_small.off", 2400, 4800, 0},
    {"screwdriver.off", 3395, 6786, 0},
    {"self_intersectA.obj.gz", 8582, 17160, 0},
    {"self_intersectB.obj.gz", 8582, 17160, 0},
    {"soup.stl", 300, 100, 0},
    {"spot.obj", 2930, 5856, 0},
    {"stanford-bunny.obj.gz", 35947, 69451, 0},
    {"star.off", 14, 24, 0},
    {"suzanne.obj", 507, 500, 468},
    {"teapot.obj", 3644, 6320, 0},
    {"thingi10k_112932.stl", 3932, 7880, 0},
    {"thingi10k_472042.stl", 1814, 3632, 0},
    {"thingi10k_72214.stl", 830, 1660, 0},
    {"thingi10k_99865.stl.gz", 35987, 71974, 0},
};

static void each_mesh_has_its_counts(void **state) {
    (void)state;
    test_scratch scratch;
    char path[4096];
    test_scratch_make(&scratch);
    for (size_t i = 0; i < sizeof meshes / sizeof *meshes; ++i) {
        char name[128];
        snprintf(name, sizeof name, "meshes/%s", meshes[i].name);
        if (!test_data_path(name, path, sizeof path))
            break;
        qn_context *context = test_context(1);
        qn_mesh *mesh, *again;
        qn_error error;
        if (qn_mesh_read(context, path, NULL, &mesh, &error) != QN_OK)
            fail_msg("%s", error.message);
        qn_mesh_view view = qn_mesh_get_view(mesh);
        if (view.vertex_count != meshes[i].vertices || view.quad_count != meshes[i].quads ||
            view.quad_count + view.triangle_count != meshes[i].faces)
            fail_msg("%s: %lld vertices, %lld quads, %lld triangles", name,
                     (long long)view.vertex_count, (long long)view.quad_count,
                     (long long)view.triangle_count);
        const char *copy = test_scratch_path(&scratch, "m.ply");
        assert_int_equal(qn_mesh_write(context, mesh, copy, NULL, NULL), QN_OK);
        assert_int_equal(qn_mesh_read(context, copy, NULL, &again, NULL), QN_OK);
        assert_int_equal(test_hash_mesh(mesh), test_hash_mesh(again));
        qn_mesh_destroy(again);
        qn_mesh_destroy(mesh);
        test_context_end(context);
    }
    test_scratch_remove(&scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_mesh_has_its_counts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
