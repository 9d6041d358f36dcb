// SPDX-License-Identifier: MIT
/* A binary tree of boxes, halved at the middle triangle of the longest side; searched nearest box
 * first. Points are spread over a mesh by equal steps of area, so that no random number is needed.
 */
#include "lib/mesh_distance.h"

#include <math.h>

enum { LEAF = 4 };

typedef struct box_node {
    double low[3], high[3];
    int64_t first, count; /* triangles; of inner nodes the second child is at `other` */
    int64_t other;        /* 0: a leaf; the first child follows the node */
} box_node;

typedef struct corners {
    double at[3][3];
} corners;

struct test_distance_tree {
    corners *triangles;
    int64_t triangle_count;
    box_node *nodes;
    int64_t node_count;
};

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void corners_of(const qn_mesh_view *view, int64_t triangle, corners *out) {
    for (int k = 0; k < 3; ++k)
        for (int m = 0; m < 3; ++m)
            out->at[k][m] =
                (double)view->positions[3 * (int64_t)view->triangles[3 * triangle + k] + m];
}

static int sort_axis; /* the tests build their trees one at a time */

static int compare_middles(const void *a, const void *b) {
    const corners *p = a, *q = b;
    double x = 0, y = 0;
    for (int k = 0; k < 3; ++k) {
        x += p->at[k][sort_axis];
        y += q->at[k][sort_axis];
    }
    return (x > y) - (x < y);
}

static int64_t build(test_distance_tree *tree, int64_t first, int64_t count) {
    const int64_t index = tree->node_count++;
    box_node *node = &tree->nodes[index];
    node->first = first;
    node->count = count;
    node->other = 0;
    for (int m = 0; m < 3; ++m) {
        node->low[m] = INFINITY;
        node->high[m] = -INFINITY;
        for (int64_t n = first; n < first + count; ++n)
            for (int k = 0; k < 3; ++k) {
                node->low[m] = fmin(node->low[m], tree->triangles[n].at[k][m]);
                node->high[m] = fmax(node->high[m], tree->triangles[n].at[k][m]);
            }
    }
    if (count <= LEAF)
        return index;
    sort_axis = 0;
    for (int m = 1; m < 3; ++m)
        if (node->high[m] - node->low[m] > node->high[sort_axis] - node->low[sort_axis])
            sort_axis = m;
    qsort(tree->triangles + first, (size_t)count, sizeof *tree->triangles, compare_middles);
    build(tree, first, count / 2);
    node->other = build(tree, first + count / 2, count - count / 2);
    return index;
}

test_distance_tree *test_distance_tree_create(const qn_mesh *mesh) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    test_distance_tree *tree = test_alloc(1, sizeof *tree);
    assert_true(view.triangle_count > 0);
    tree->triangle_count = view.triangle_count;
    tree->triangles = test_alloc((size_t)view.triangle_count, sizeof *tree->triangles);
    tree->nodes = test_alloc((size_t)view.triangle_count * 2, sizeof *tree->nodes);
    tree->node_count = 0;
    for (int64_t n = 0; n < view.triangle_count; ++n)
        corners_of(&view, n, &tree->triangles[n]);
    build(tree, 0, view.triangle_count);
    return tree;
}

void test_distance_tree_destroy(test_distance_tree *tree) {
    if (!tree)
        return;
    free(tree->triangles);
    free(tree->nodes);
    free(tree);
}

/* ---- distances ----------------------------------------------------------------------------------
 */

static double segment_distance2(const double p[3], const double a[3], const double b[3]) {
    double way[3], from[3], off[3];
    for (int k = 0; k < 3; ++k) {
        way[k] = b[k] - a[k];
        from[k] = p[k] - a[k];
    }
    const double length2 = dot(way, way);
    const double t = length2 > 0 ? fmin(1, fmax(0, dot(from, way) / length2)) : 0;
    for (int k = 0; k < 3; ++k)
        off[k] = from[k] - t * way[k];
    return dot(off, off);
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double triangle_distance2(const double p[3], const corners *t) {
    double sides[3][3], normal[3], off[3][3];
    for (int k = 0; k < 3; ++k)
        for (int m = 0; m < 3; ++m) {
            sides[k][m] = t->at[(k + 1) % 3][m] - t->at[k][m];
            off[k][m] = p[m] - t->at[k][m];
        }
    cross(sides[0], sides[1], normal);
    const double length2 = dot(normal, normal);
    bool over = length2 > 0;
    for (int k = 0; k < 3 && over; ++k) {
        double turned[3];
        cross(normal, sides[k], turned);
        over = dot(turned, off[k]) >= 0;
    }
    if (over)
        return dot(normal, off[0]) * dot(normal, off[0]) / length2;
    double least = INFINITY;
    for (int k = 0; k < 3; ++k)
        least = fmin(least, segment_distance2(p, t->at[k], t->at[(k + 1) % 3]));
    return least;
}

static double box_distance2(const double p[3], const box_node *node) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double off = fmax(0, fmax(node->low[k] - p[k], p[k] - node->high[k]));
        sum += off * off;
    }
    return sum;
}

static void search(const test_distance_tree *tree, int64_t index, const double p[3],
                   double *least) {
    const box_node *node = &tree->nodes[index];
    if (!node->other) {
        for (int64_t n = node->first; n < node->first + node->count; ++n)
            *least = fmin(*least, triangle_distance2(p, &tree->triangles[n]));
        return;
    }
    const int64_t children[2] = {index + 1, node->other};
    const double off[2] = {box_distance2(p, &tree->nodes[children[0]]),
                           box_distance2(p, &tree->nodes[children[1]])};
    const int nearer = off[1] < off[0];
    if (off[nearer] < *least)
        search(tree, children[nearer], p, least);
    if (off[!nearer] < *least)
        search(tree, children[!nearer], p, least);
}

double test_distance_to_mesh(const test_distance_tree *tree, const double point[3]) {
    double least = INFINITY;
    search(tree, 0, point, &least);
    return sqrt(least);
}

static double area_of(const corners *t) {
    double sides[2][3], normal[3];
    for (int k = 0; k < 2; ++k)
        for (int m = 0; m < 3; ++m)
            sides[k][m] = t->at[k + 1][m] - t->at[0][m];
    cross(sides[0], sides[1], normal);
    return 0.5 * sqrt(dot(normal, normal));
}

static double note(const test_distance_tree *tree, const double point[3], test_deviation *out) {
    const double distance = test_distance_to_mesh(tree, point);
    if (distance > out->largest) {
        out->largest = distance;
        memcpy(out->where, point, sizeof out->where);
    }
    ++out->samples;
    return distance;
}

/* Point n of a triangle: weights from two irrational steps, folded into it. */
static void point_in(const corners *t, int64_t n, double point[3]) {
    double u = fmod(0.5 + 0.7548776662466927 * (double)n, 1),
           v = fmod(0.5 + 0.5698402909980532 * (double)n, 1);
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int m = 0; m < 3; ++m)
        point[m] = t->at[0][m] + u * (t->at[1][m] - t->at[0][m]) + v * (t->at[2][m] - t->at[0][m]);
}

test_deviation test_mesh_deviation(const qn_mesh *mesh, int64_t count,
                                   const test_distance_tree *tree) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    test_deviation out = {0, 0, 0, {0, 0, 0}};
    double total = 0, sum = 0, passed = 0;
    corners t;
    for (int64_t n = 0; n < view.triangle_count; ++n) {
        corners_of(&view, n, &t);
        total += area_of(&t);
    }
    for (int64_t n = 0; n < view.vertex_count; ++n) {
        double point[3];
        for (int m = 0; m < 3; ++m)
            point[m] = (double)view.positions[3 * n + m];
        note(tree, point, &out);
    }
    int64_t taken = 0;
    for (int64_t n = 0; n < view.triangle_count; ++n) {
        corners_of(&view, n, &t);
        passed += area_of(&t);
        for (; (double)taken + 0.5 < (double)count * passed / total; ++taken) {
            double point[3];
            point_in(&t, taken, point);
            sum += note(tree, point, &out);
        }
    }
    out.mean = taken ? sum / (double)taken : 0;
    return out;
}
