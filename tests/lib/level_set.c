// SPDX-License-Identifier: MIT
#include "lib/level_set.h"

#include <math.h>

enum { LEAVES = 5 };

qn_volume *test_ball_level_set(qn_context *context, const double centre[3], double radius) {
    static int32_t origins[LEAVES * LEAVES * LEAVES][3];
    static float values[LEAVES * LEAVES * LEAVES][512];
    const double voxel = 2.4 * radius / (8 * LEAVES);
    for (int leaf = 0; leaf < LEAVES * LEAVES * LEAVES; ++leaf) {
        const int at[3] = {leaf % LEAVES, leaf / LEAVES % LEAVES, leaf / LEAVES / LEAVES};
        for (int k = 0; k < 3; ++k)
            origins[leaf][k] = 8 * at[k];
        for (int n = 0; n < 512; ++n) {
            const int place[3] = {n % 8, n / 8 % 8, n / 64};
            double sum = 0;
            for (int k = 0; k < 3; ++k) {
                const double d = voxel * (8 * at[k] + place[k] - 4 * LEAVES + 0.5);
                sum += d * d;
            }
            values[leaf][n] = (float)(sqrt(sum) - radius);
        }
    }
    qn_sparse_grid grid = {.scalar = QN_F32,
                           .leaf_count = LEAVES * LEAVES * LEAVES,
                           .origins = origins,
                           .values = values,
                           .background = 3 * voxel,
                           .kind = QN_SPARSE_LEVEL_SET};
    for (int k = 0; k < 3; ++k) {
        grid.index_to_world[k][k] = voxel;
        grid.index_to_world[k][3] = centre[k] - voxel * (4 * LEAVES - 0.5);
    }
    grid.index_to_world[3][3] = 1;
    qn_volume *volume;
    assert_int_equal(qn_volume_create_sparse(context, &grid, NULL, NULL, &volume, NULL), QN_OK);
    return volume;
}

qn_solid *test_level_set_solid(qn_context *context, const qn_volume *volume, int32_t owner) {
    qn_solid_volume_options options;
    qn_solid_volume_options_init(&options);
    options.owner = owner;
    qn_solid *solid;
    assert_int_equal(
        qn_solid_from_volume(context, volume, 0, QN_INSIDE_BELOW, &options, &solid, NULL), QN_OK);
    return solid;
}
