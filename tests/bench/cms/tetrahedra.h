// SPDX-License-Identifier: MIT
/* Unions of random tetrahedra, as solids and as their exact surface. */
#ifndef BENCH_CMS_TETRAHEDRA_H
#define BENCH_CMS_TETRAHEDRA_H

#include "lib/mesh_distance.h"

enum { TETRAHEDRA = 3 };

typedef struct tetrahedra {
    double corners[TETRAHEDRA][4][3];
    double planes[TETRAHEDRA][4][4]; /* n . p < d inside, n of unit length */
} tetrahedra;

/* Corners anywhere in [-1, 1]^3; slivers are drawn again. */
tetrahedra tetrahedra_random(test_random *random);
qn_solid *tetrahedra_solid(qn_context *context, const tetrahedra *three);
/* The union's surface: each face less what lies in the other tetrahedra. */
test_distance_tree *tetrahedra_surface(qn_context *context, const tetrahedra *three);

#endif
