// SPDX-License-Identifier: MIT
/* The trilinear surface's topology: regions joined over the lattice, cells cut finely where it
 * takes that. */
#include "lib/trilinear_topology.h"
#include "lib/refined_cell.h"

#include <stdlib.h>

static int find(int *parent, int i) {
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/* Lattice points carry values less iso, below 0 where they are outside. */
typedef struct lattice {
    int size[3];
    double *value;
} lattice;

static int point(const lattice *l, int x, int y, int z) {
    return (z * l->size[1] + y) * l->size[0] + x;
}

static lattice make_lattice(const test_field *field) {
    lattice l = {{(int)field->size[0] + 2, (int)field->size[1] + 2, (int)field->size[2] + 2}, NULL};
    l.value = test_alloc((size_t)l.size[0] * (size_t)l.size[1] * (size_t)l.size[2], sizeof(double));
    for (int z = 0; z < l.size[2]; ++z)
        for (int y = 0; y < l.size[1]; ++y)
            for (int x = 0; x < l.size[0]; ++x) {
                const double value = test_field_distance(field, x - 1, y - 1, z - 1);
                l.value[point(&l, x, y, z)] =
                    value == 0 && !test_field_above(field, x - 1, y - 1, z - 1) ? -1e-200 : value;
            }
    return l;
}

/* Edges and face segments of the lattice, less and more: the Euler characteristic of the surface's
 * net on the faces. */
static int64_t net_euler(const lattice *l) {
    int64_t euler = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
        const int step[3] = {1, l->size[0], l->size[0] * l->size[1]};
        for (int z = 0; z < l->size[2]; ++z)
            for (int y = 0; y < l->size[1]; ++y)
                for (int x = 0; x < l->size[0]; ++x) {
                    const int at[3] = {x, y, z};
                    const double *v = l->value + point(l, x, y, z);
                    if (at[axis] + 1 < l->size[axis])
                        euler += (v[0] >= 0) != (v[step[axis]] >= 0);
                    if (at[p] + 1 == l->size[p] || at[q] + 1 == l->size[q])
                        continue;
                    const bool s[4] = {v[0] >= 0, v[step[p]] >= 0, v[step[p] + step[q]] >= 0,
                                       v[step[q]] >= 0};
                    euler -=
                        ((s[0] != s[1]) + (s[1] != s[2]) + (s[2] != s[3]) + (s[3] != s[0])) / 2;
                }
    }
    return euler;
}

/* Cells with several polygons are cut into `cuts` boxes a side. */
static test_topology topology_of(const lattice *l, int cuts) {
    const int points = l->size[0] * l->size[1] * l->size[2];
    test_topology result = {-1, net_euler(l), 0};
    int *parent = test_alloc((size_t)points, sizeof *parent);
    for (int i = 0; i < points; ++i)
        parent[i] = i;
    for (int z = 0; z + 1 < l->size[2]; ++z)
        for (int y = 0; y + 1 < l->size[1]; ++y)
            for (int x = 0; x + 1 < l->size[0]; ++x) {
                double d[8];
                int corner[8];
                for (int c = 0; c < 8; ++c) {
                    corner[c] = point(l, x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
                    d[c] = l->value[corner[c]];
                }
                test_refined cell = test_refine_cell(d, 1);
                const int polygons = cell.surfaces;
                if (polygons > 1)
                    cell = test_refine_cell(d, cuts);
                result.tunnels += polygons - cell.surfaces;
                result.euler += cell.euler;
                for (int a = 0; a < 8; ++a)
                    for (int b = 0; b < a; ++b)
                        if (cell.region[a] == cell.region[b])
                            parent[find(parent, corner[a])] = find(parent, corner[b]);
            }
    for (int i = 0; i < points; ++i)
        result.components += find(parent, i) == i;
    free(parent);
    return result;
}

test_topology test_trilinear_topology(const test_field *field, const qn_mesh_report *expected,
                                      bool *late_out) {
    lattice l = make_lattice(field);
    test_topology found = topology_of(&l, 9);
    *late_out = false;
    for (int cuts = 32; !test_topology_agrees(&found, expected) && cuts < 200;
         cuts = 2 * cuts + 1) {
        found = topology_of(&l, cuts);
        *late_out = *late_out || cuts > 32;
    }
    free(l.value);
    return found;
}
