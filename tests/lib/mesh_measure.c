// SPDX-License-Identifier: MIT
/* Edges, area, volume, pieces and shape of a mesh, in the plainest way. */
#include "lib/mesh_measure.h"

#include <math.h>

typedef struct side {
    uint32_t low, high;
    int32_t forward; /* +1 from low to high, -1 back */
} side;

static int compare_sides(const void *a, const void *b) {
    const side *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    return (x->high > y->high) - (x->high < y->high);
}

static side *add_face(side *next, const uint32_t *face, int corners) {
    for (int k = 0; k < corners; ++k) {
        uint32_t from = face[k], to = face[(k + 1) % corners];
        side one = {from < to ? from : to, from < to ? to : from, from < to ? 1 : -1};
        *next++ = one;
    }
    return next;
}

/* All sides of all faces, those along the same edge side by side; to be freed. */
static side *sorted_sides(const qn_mesh_view *view, int64_t *count) {
    *count = 4 * view->quad_count + 3 * view->triangle_count;
    side *sides = test_alloc((size_t)*count, sizeof *sides), *next = sides;
    for (int64_t q = 0; q < view->quad_count; ++q)
        next = add_face(next, view->quads + 4 * q, 4);
    for (int64_t t = 0; t < view->triangle_count; ++t)
        next = add_face(next, view->triangles + 3 * t, 3);
    qsort(sides, (size_t)*count, sizeof *sides, compare_sides);
    return sides;
}

/* The end of the run of sides along one edge, and how many more go forward than back. */
static int64_t edge_end(const side *sides, int64_t count, int64_t first, int64_t *balance) {
    int64_t end = first;
    for (*balance = 0; end < count && compare_sides(&sides[first], &sides[end]) == 0; ++end)
        *balance += sides[end].forward;
    return end;
}

test_edges test_mesh_edges(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    int64_t count, balance;
    side *sides = sorted_sides(&view, &count);
    test_edges edges = {0, 0, 0, 0};
    for (int64_t i = 0, end; i < count; i = end) {
        end = edge_end(sides, count, i, &balance);
        edges.count += 1;
        edges.unbalanced += balance != 0;
        edges.once += end - i == 1;
        edges.more_than_two += end - i > 2;
    }
    free(sides);
    return edges;
}

static bool within(const float *place, const double low[3], const double high[3]) {
    for (int a = 0; a < 3; ++a)
        if (!((double)place[a] > low[a] && (double)place[a] < high[a]))
            return false;
    return true;
}

int64_t test_mesh_cracks(const qn_mesh *mesh, const double low[3], const double high[3]) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    int64_t count, balance, cracks = 0;
    side *sides = sorted_sides(&view, &count);
    for (int64_t i = 0, end; i < count; i = end) {
        end = edge_end(sides, count, i, &balance);
        cracks += balance != 0 && (within(view.positions + 3 * (int64_t)sides[i].low, low, high) ||
                                   within(view.positions + 3 * (int64_t)sides[i].high, low, high));
    }
    free(sides);
    return cracks;
}

static void subtract(const float *a, const float *b, double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = (double)a[i] - (double)b[i];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double length(const double a[3]) {
    return sqrt(dot(a, a));
}

static void add_triangle(const qn_mesh_view *view, uint32_t a, uint32_t b, uint32_t c, double *area,
                         double *volume) {
    const float *origin = view->positions; /* the first vertex: less cancellation far from 0 */
    double ab[3], ac[3], normal[3], from_origin[3];
    subtract(view->positions + 3 * (int64_t)b, view->positions + 3 * (int64_t)a, ab);
    subtract(view->positions + 3 * (int64_t)c, view->positions + 3 * (int64_t)a, ac);
    subtract(view->positions + 3 * (int64_t)a, origin, from_origin);
    cross(ab, ac, normal);
    *area += length(normal) / 2;
    *volume += dot(from_origin, normal) / 6;
}

void test_mesh_area_volume(const qn_mesh *mesh, double *area, double *volume) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    *area = *volume = 0;
    for (int64_t q = 0; q < view.quad_count; ++q) {
        const uint32_t *quad = view.quads + 4 * q;
        add_triangle(&view, quad[0], quad[1], quad[2], area, volume);
        add_triangle(&view, quad[0], quad[2], quad[3], area, volume);
    }
    for (int64_t t = 0; t < view.triangle_count; ++t) {
        const uint32_t *triangle = view.triangles + 3 * t;
        add_triangle(&view, triangle[0], triangle[1], triangle[2], area, volume);
    }
}

static int64_t find_root(int64_t *parent, int64_t v) {
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

int64_t test_mesh_pieces(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    int64_t *parent = test_alloc((size_t)view.vertex_count, sizeof *parent), pieces = 0;
    for (int64_t v = 0; v < view.vertex_count; ++v)
        parent[v] = v;
    for (int64_t q = 0; q < view.quad_count; ++q)
        for (int k = 1; k < 4; ++k)
            parent[find_root(parent, view.quads[4 * q + k])] = find_root(parent, view.quads[4 * q]);
    for (int64_t t = 0; t < view.triangle_count; ++t)
        for (int k = 1; k < 3; ++k)
            parent[find_root(parent, view.triangles[3 * t + k])] =
                find_root(parent, view.triangles[3 * t]);
    for (int64_t v = 0; v < view.vertex_count; ++v)
        pieces += parent[v] == v;
    free(parent);
    return pieces;
}

bool test_mesh_is_finite(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    for (int64_t i = 0; i < 3 * view.vertex_count; ++i)
        if (!isfinite(view.positions[i]) || (view.normals && !isfinite(view.normals[i])))
            return false;
    return true;
}

/* min over the corners of 2 A / (l^2 + l'^2), A the parallelogram of the corner's two sides. */
static double quad_quality(const qn_mesh_view *view, const uint32_t quad[4]) {
    double least = HUGE_VAL;
    for (int k = 0; k < 4; ++k) {
        double next[3], previous[3], normal[3];
        subtract(view->positions + 3 * (int64_t)quad[(k + 1) % 4],
                 view->positions + 3 * (int64_t)quad[k], next);
        subtract(view->positions + 3 * (int64_t)quad[(k + 3) % 4],
                 view->positions + 3 * (int64_t)quad[k], previous);
        cross(next, previous, normal);
        double sides = dot(next, next) + dot(previous, previous);
        least = fmin(least, sides > 0 ? 2 * length(normal) / sides : 0);
    }
    return least;
}

/* 4 sqrt(3) A / (l1^2 + l2^2 + l3^2): 1 for the equilateral one. */
static double triangle_quality(const qn_mesh_view *view, const uint32_t triangle[3]) {
    double sides[3][3], normal[3], sum = 0;
    for (int k = 0; k < 3; ++k) {
        subtract(view->positions + 3 * (int64_t)triangle[(k + 1) % 3],
                 view->positions + 3 * (int64_t)triangle[k], sides[k]);
        sum += dot(sides[k], sides[k]);
    }
    cross(sides[0], sides[1], normal);
    return sum > 0 ? 2 * sqrt(3.0) * length(normal) / sum : 0;
}

double test_mean_quad_quality(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    double sum = 0;
    for (int64_t q = 0; q < view.quad_count; ++q)
        sum += quad_quality(&view, view.quads + 4 * q);
    return sum / (double)view.quad_count;
}

double test_mean_triangle_quality(const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    double sum = 0;
    for (int64_t t = 0; t < view.triangle_count; ++t)
        sum += triangle_quality(&view, view.triangles + 3 * t);
    return sum / (double)view.triangle_count;
}
