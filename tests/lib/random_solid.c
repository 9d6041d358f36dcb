// SPDX-License-Identifier: MIT
#include "lib/random_solid.h"

#include <math.h>

static qn_solid *random_primitive(qn_context *context, test_random *random, double cell,
                                  int32_t owner) {
    const test_frame frame = test_random_range(random, 0, 3)
                                 ? test_random_frame(random, 0.6)
                                 : test_frame_at(0.5 * test_random_unit(random), 0.1, -0.2);
    const double size = 0.15 + 0.4 * test_random_unit(random);
    switch (test_random_range(random, 0, 6)) {
    case 0:
        return test_sphere(context, frame.origin, size, owner);
    case 1:
        return test_finite_cylinder(context, &frame, 0.6 * size, 0.3 + size, owner);
    case 2:
        return test_finite_cone(context, &frame, 0.15 + 0.8 * test_random_unit(random), size,
                                owner);
    case 3:
        return test_torus(context, &frame, size, 0.3 * size, owner);
    case 4: { /* a plate of 0.2 to 1.6 cells */
        const double half[3] = {0.4, 0.4, 0.5 * cell * (0.2 + 1.4 * test_random_unit(random))};
        return test_box(context, &frame, half, owner);
    }
    default: {
        const double half[3] = {size, 0.2 + 0.3 * test_random_unit(random),
                                0.2 + 0.3 * test_random_unit(random)};
        return test_box(context, &frame, half, owner);
    }
    }
}

/* Two bodies that nearly, or exactly, share a face or a tangent. */
static qn_solid *close_pair(qn_context *context, test_random *random, double cell, int32_t owner) {
    static const double gaps[] = {0, 1e-9, 1e-6, 1e-3, 0.3, 1.1};
    const double gap =
        cell * gaps[test_random_range(random, 0, 5)] * (test_random_range(random, 0, 1) ? 1 : -1);
    test_frame frame =
        test_random_range(random, 0, 1) ? test_random_frame(random, 0.4) : test_frame_at(0, 0, 0);
    const double size = 0.2 + 0.2 * test_random_unit(random), half[3] = {size, size, size};
    test_frame other = frame;
    if (test_random_range(random, 0, 1)) { /* tangent spheres */
        for (int k = 0; k < 3; ++k)
            other.origin[k] += (2 * size + gap) * frame.turn[0][k];
        return test_union(test_sphere(context, frame.origin, size, owner),
                          test_sphere(context, other.origin, size, owner + 1));
    }
    const bool beside = test_random_range(random, 0, 1);
    for (int k = 0; k < 3; ++k) /* boxes side by side, or with coplanar tops */
        other.origin[k] += beside ? (2 * size + gap) * frame.turn[0][k] + 0.1 * frame.turn[1][k]
                                  : gap * frame.turn[2][k] + 0.3 * size * frame.turn[0][k] +
                                        0.2 * size * frame.turn[1][k];
    return test_union(test_box(context, &frame, half, owner),
                      test_box(context, &other, half, owner + 6));
}

qn_solid *test_random_scene(qn_context *context, test_random *random, double cell) {
    const int64_t count = test_random_range(random, 2, 12);
    qn_solid *scene = random_primitive(context, random, cell, 0);
    for (int64_t n = 1; n < count; ++n) {
        const int32_t owner = (int32_t)(20 * n);
        qn_solid *next = test_random_range(random, 0, 5)
                             ? random_primitive(context, random, cell, owner)
                             : close_pair(context, random, cell, owner);
        const int64_t way = test_random_range(random, 0, 5);
        scene = way < 3   ? test_union(scene, next)
                : way < 5 ? test_difference(scene, next)
                          : test_intersection(scene, next);
    }
    test_solid_set_box(scene, -1.7, 1.7);
    return scene;
}
