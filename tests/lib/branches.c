// SPDX-License-Identifier: MIT
/* Branches by flooding boxes. The boxes' sign is taken as the cell's is: zero counts as above. */
#include "lib/branches.h"
#include "lib/trilinear.h"

#include <math.h>

test_box test_polygon_box(const test_field *field, const int64_t cell[3], uint16_t polygon) {
    test_box box = {{1, 1, 1}, {0, 0, 0}};
    for (int e = 0; e < TEST_CELL_EDGES; ++e) {
        if (!(polygon >> e & 1))
            continue;
        test_edge edge = test_cell_edge(cell, e);
        const int64_t *s = edge.sample;
        double from = fabs(test_field_distance(field, s[0], s[1], s[2]));
        double to = fabs(test_field_distance(field, s[0] + (edge.axis == 0),
                                             s[1] + (edge.axis == 1), s[2] + (edge.axis == 2)));
        for (int a = 0; a < 3; ++a) {
            /* two samples on the iso-value: the whole edge is on the surface */
            double low = a == edge.axis ? (from + to > 0 ? from / (from + to) : 0)
                                        : (double)(s[a] - cell[a]);
            double high = a == edge.axis && from + to == 0 ? 1 : low;
            box.low[a] = fmin(box.low[a], low);
            box.high[a] = fmax(box.high[a], high);
        }
    }
    return box;
}

bool test_box_holds(const test_box *box, const double local[3], const double reach[3]) {
    for (int a = 0; a < 3; ++a) /* crossings are divided in double */
        if (local[a] < box->low[a] - reach[a] - 1e-9 || local[a] > box->high[a] + reach[a] + 1e-9)
            return false;
    return true;
}

static int find(int *parent, int b) {
    while (parent[b] != b)
        b = parent[b] = parent[parent[b]];
    return b;
}

/* Signs at the (n + 1)^3 points; at the cell's corners the samples' own bits. */
static bool *point_signs(const test_field *field, const int64_t cell[3], int n) {
    double corners[8];
    test_cell_corners(field, cell, corners);
    bool *signs = test_alloc((size_t)((n + 1) * (n + 1) * (n + 1)), sizeof *signs), *next = signs;
    for (int z = 0; z <= n; ++z)
        for (int y = 0; y <= n; ++y)
            for (int x = 0; x <= n; ++x) {
                const double local[3] = {(double)x / n, (double)y / n, (double)z / n};
                *next++ = test_trilinear(corners, local, NULL) >= 0;
            }
    for (int c = 0; c < 8; ++c)
        signs[n * ((c & 1) + (n + 1) * ((c >> 1 & 1) + (n + 1) * (c >> 2)))] =
            test_field_above(field, cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2));
    return signs;
}

/* True when the points of a block of (dx, dy, dz) steps from a point have both signs. */
static bool mixed(const bool *signs, int n, int x, int y, int z, int dx, int dy, int dz) {
    bool first = signs[x + (n + 1) * (y + (n + 1) * z)];
    for (int k = 0; k <= dz; ++k)
        for (int j = 0; j <= dy; ++j)
            for (int i = 0; i <= dx; ++i)
                if (signs[x + i + (n + 1) * (y + j + (n + 1) * (z + k))] != first)
                    return true;
    return false;
}

static void join_across(int *component, const bool *signs, int n, int x, int y, int z, int axis) {
    int to[3] = {x, y, z};
    to[axis] += 1;
    if (to[axis] == n || !mixed(signs, n, to[0], to[1], to[2], axis != 0, axis != 1, axis != 2))
        return;
    int a = find(component, x + n * (y + n * z)),
        b = find(component, to[0] + n * (to[1] + n * to[2]));
    component[a > b ? a : b] = a > b ? b : a;
}

/* The box that holds the crossing of a local edge: the signs change once along it. */
static int crossing_box(const bool *signs, int n, const int64_t cell[3], int local_edge) {
    test_edge edge = test_cell_edge(cell, local_edge);
    int p[3], box[3];
    for (int a = 0; a < 3; ++a)
        p[a] = n * (int)(edge.sample[a] - cell[a]);
    const int stride = edge.axis == 0 ? 1 : edge.axis == 1 ? n + 1 : (n + 1) * (n + 1);
    const bool *at = signs + p[0] + (n + 1) * (p[1] + (n + 1) * p[2]);
    while (p[edge.axis] < n - 1 && at[0] == at[stride])
        at += stride, p[edge.axis] += 1;
    for (int a = 0; a < 3; ++a)
        box[a] = p[a] == n ? n - 1 : p[a];
    return box[0] + n * (box[1] + n * box[2]);
}

static void find_roots(test_branches *branches, const bool *signs, const int64_t cell[3],
                       const uint16_t polygons[4], int polygon_count) {
    for (int p = 0; p < polygon_count; ++p) {
        branches->polygon_root[p] = -1;
        for (int e = 0; e < TEST_CELL_EDGES; ++e)
            if (polygons[p] >> e & 1) {
                int box = crossing_box(signs, branches->boxes, cell, e);
                int root = branches->component[box] < 0 ? -1 : find(branches->component, box);
                if (branches->polygon_root[p] < 0)
                    branches->polygon_root[p] = root;
                branches->joined |= root < 0 || root != branches->polygon_root[p];
            }
        for (int q = 0; q < p; ++q)
            branches->joined |= branches->polygon_root[p] == branches->polygon_root[q];
    }
}

test_branches test_branches_make(const test_field *field, const int64_t cell[3],
                                 const uint16_t polygons[4], int polygon_count, int boxes) {
    const int n = boxes;
    test_branches branches = {
        n, test_alloc((size_t)(n * n * n), sizeof(int)), {-1, -1, -1, -1}, false};
    bool *signs = point_signs(field, cell, n);
    for (int b = 0; b < n * n * n; ++b)
        branches.component[b] = mixed(signs, n, b % n, b / n % n, b / n / n, 1, 1, 1) ? b : -1;
    for (int b = 0; b < n * n * n; ++b)
        for (int axis = 0; axis < 3; ++axis)
            join_across(branches.component, signs, n, b % n, b / n % n, b / n / n, axis);
    find_roots(&branches, signs, cell, polygons, polygon_count);
    for (int b = 0; b < n * n * n; ++b)
        if (branches.component[b] >= 0)
            branches.component[b] = find(branches.component, b);
    free(signs);
    return branches;
}

void test_branches_free(test_branches *branches) {
    free(branches->component);
    branches->component = NULL;
}

unsigned test_branches_at(const test_branches *branches, int polygon_count, const double local[3],
                          const double reach[3]) {
    const int n = branches->boxes;
    int low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        low[a] = (int)floor((local[a] - reach[a]) * n - 1e-6);
        high[a] = (int)floor((local[a] + reach[a]) * n + 1e-6);
        low[a] = low[a] < 0 ? 0 : low[a] >= n ? n - 1 : low[a];
        high[a] = high[a] < 0 ? 0 : high[a] >= n ? n - 1 : high[a];
    }
    unsigned mask = 0;
    for (int z = low[2]; z <= high[2]; ++z)
        for (int y = low[1]; y <= high[1]; ++y)
            for (int x = low[0]; x <= high[0]; ++x)
                for (int p = 0; p < polygon_count; ++p)
                    if (branches->component[x + n * (y + n * z)] == branches->polygon_root[p])
                        mask |= 1u << p;
    return mask;
}
