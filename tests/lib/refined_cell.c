// SPDX-License-Identifier: MIT
/* Brute force: see refined_cell.h. */
#include "lib/refined_cell.h"
#include "lib/support.h"

typedef struct grid {
    int n;
    double *value;
    int *parent;
} grid;

static int find(int *parent, int i) {
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

static void join(int *parent, int a, int b) {
    a = find(parent, a);
    b = find(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static int vertex(const grid *g, int x, int y, int z) {
    return (z * (g->n + 1) + y) * (g->n + 1) + x;
}

static void fill(grid *g, const double d[8]) {
    for (int z = 0; z <= g->n; ++z)
        for (int y = 0; y <= g->n; ++y)
            for (int x = 0; x <= g->n; ++x) {
                /* Times n^3: exact for small integers, so that ties stay ties. */
                const long double u = x, v = y, w = z, n = g->n;
                long double sum = 0;
                for (int c = 0; c < 8; ++c)
                    sum += (c & 1 ? u : n - u) * (c & 2 ? v : n - v) * (c & 4 ? w : n - w) *
                           (long double)d[c];
                const int i = vertex(g, x, y, z);
                g->value[i] = (double)sum;
                g->parent[i] = i;
            }
}

static bool differ(double a, double b) {
    return (a >= 0) != (b >= 0);
}

/* Joins within the square of a face; returns its segments. `parent` is of whatever the corners are
 * numbered by. */
static int join_square(const double v[4], const int id[4], int *parent) {
    int crossings = 0;
    for (int k = 0; k < 4; ++k) {
        if (differ(v[k], v[(k + 1) & 3]))
            ++crossings;
        else
            join(parent, id[k], id[(k + 1) & 3]);
    }
    if (crossings == 4) {
        const int up = v[0] >= 0 ? 0 : 1;
        const long double above = (long double)v[up] * (long double)v[up + 2];
        const long double below = (long double)v[1 - up] * (long double)v[3 - up];
        if (above >= below)
            join(parent, id[up], id[up + 2]);
        else
            join(parent, id[1 - up], id[3 - up]);
    }
    return crossings / 2;
}

static const int square_step[3][4][3] = {{{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}},
                                         {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}},
                                         {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};

/* The polygons of a box: one less than the regions of its border. */
static int polygons_of_box(const grid *g, int x, int y, int z) {
    int parent[8], count = 0;
    double v[8];
    bool mixed = false;
    for (int c = 0; c < 8; ++c) {
        parent[c] = c;
        v[c] = g->value[vertex(g, x + (c & 1), y + (c >> 1 & 1), z + (c >> 2))];
        mixed = mixed || differ(v[0], v[c]);
    }
    if (!mixed)
        return 0;
    for (int face = 0; face < 6; ++face) {
        double s[4];
        int id[4];
        for (int k = 0; k < 4; ++k) {
            const int *step = square_step[face >> 1][k];
            id[k] = (step[0] | step[1] << 1 | step[2] << 2) | (face & 1) << (face >> 1);
            s[k] = v[id[k]];
        }
        join_square(s, id, parent);
    }
    for (int c = 0; c < 8; ++c)
        count += find(parent, c) == c;
    return count - 1;
}

test_refined test_refine_cell(const double d[8], int n) {
    const size_t side = (size_t)n + 1, count = side * side * side;
    grid g = {n, test_alloc(count, sizeof(double)), test_alloc(count, sizeof(int))};
    test_refined result = {0};
    fill(&g, d);
    for (int z = 0; z <= n; ++z)
        for (int y = 0; y <= n; ++y)
            for (int x = 0; x <= n; ++x) {
                const int at[3] = {x, y, z}, i = vertex(&g, x, y, z);
                for (int axis = 0; axis < 3; ++axis)
                    if (at[axis] < n)
                        result.euler += differ(
                            g.value[i],
                            g.value[vertex(&g, x + (axis == 0), y + (axis == 1), z + (axis == 2))]);
                for (int axis = 0; axis < 3; ++axis) {
                    double v[4];
                    int id[4];
                    if (at[axis == 0 ? 1 : 0] == n || at[axis == 2 ? 1 : 2] == n)
                        continue;
                    for (int k = 0; k < 4; ++k) {
                        const int *step = square_step[axis][k];
                        id[k] = vertex(&g, x + step[0], y + step[1], z + step[2]);
                        v[k] = g.value[id[k]];
                    }
                    result.euler -= join_square(v, id, g.parent);
                }
                if (x < n && y < n && z < n)
                    result.euler += polygons_of_box(&g, x, y, z);
            }
    for (int i = 0; i < (int)count; ++i)
        result.regions += find(g.parent, i) == i;
    result.surfaces = result.regions - 1;
    for (int c = 0; c < 8; ++c)
        result.region[c] = find(g.parent, vertex(&g, (c & 1) * n, (c >> 1 & 1) * n, (c >> 2) * n));
    free(g.value);
    free(g.parent);
    return result;
}
