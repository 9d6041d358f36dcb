// SPDX-License-Identifier: MIT
/* Pieces and Euler characteristic of the trilinear surface of a closed field, found without any
 * surfacer: by cutting the lattice's cells finely. */
#ifndef TEST_TRILINEAR_TOPOLOGY_H
#define TEST_TRILINEAR_TOPOLOGY_H

#include "lib/test_volume.h"

typedef struct test_topology {
    int64_t components, euler, tunnels;
} test_topology;

static inline bool test_topology_agrees(const test_topology *topology, const qn_mesh_report *mesh) {
    return topology->components == mesh->components &&
           topology->euler == mesh->euler_characteristic;
}

/* Cells of several polygons are cut into 9^3 boxes, and, while that does not agree with what is
 * expected, into more, up to 131^3: tunnels narrower than a box are missed, none is made up.
 * `late`: it took more than 32. */
test_topology test_trilinear_topology(const test_field *field, const qn_mesh_report *expected,
                                      bool *late_out);

#endif
