// SPDX-License-Identifier: MIT
/* Random CSG scenes: 2 to 12 turned primitives, near-tangent ones, thin walls, coplanar faces. */
#ifndef TEST_RANDOM_SOLID_H
#define TEST_RANDOM_SOLID_H

#include "lib/test_solid.h"

/* A scene in [-1.2, 1.2]^3 or so; `cell` sizes its thin walls. */
qn_solid *test_random_scene(qn_context *context, test_random *random, double cell);

#endif
