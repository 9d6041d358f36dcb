// SPDX-License-Identifier: MIT
#include "lib/crease_share.h"

#include <math.h>

typedef struct side {
    uint32_t ends[2];
    int64_t triangle;
} side;

static void to_doubles(const float *from, double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = (double)from[k];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit_normal(const test_model *model, int64_t triangle, double normal[3]) {
    double p[3][3], a[3], b[3];
    for (int n = 0; n < 3; ++n)
        to_doubles(model->points[model->triangles[triangle][n]], p[n]);
    for (int k = 0; k < 3; ++k) {
        a[k] = p[1][k] - p[0][k];
        b[k] = p[2][k] - p[0][k];
    }
    for (int k = 0; k < 3; ++k)
        normal[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    const double length = sqrt(dot(normal, normal));
    for (int k = 0; k < 3; ++k)
        normal[k] /= length;
}

static int compare_sides(const void *a, const void *b) {
    return memcmp(a, b, sizeof(uint32_t[2]));
}

static side *sorted_sides(const test_model *model) {
    side *sides = test_alloc((size_t)model->triangle_count * 3, sizeof *sides);
    for (int64_t n = 0; n < 3 * model->triangle_count; ++n) {
        const uint32_t a = model->triangles[n / 3][n % 3], b = model->triangles[n / 3][(n + 1) % 3];
        memset(&sides[n], 0, sizeof sides[n]);
        sides[n].ends[0] = a < b ? a : b;
        sides[n].ends[1] = a < b ? b : a;
        sides[n].triangle = n / 3;
    }
    qsort(sides, (size_t)model->triangle_count * 3, sizeof *sides, compare_sides);
    return sides;
}

static double segment_distance(const double p[3], const float *from, const float *to) {
    double a[3], b[3], way[3], off[3];
    to_doubles(from, a);
    to_doubles(to, b);
    for (int k = 0; k < 3; ++k) {
        way[k] = b[k] - a[k];
        off[k] = p[k] - a[k];
    }
    const double length2 = dot(way, way), t = length2 > 0 ? dot(off, way) / length2 : 0;
    for (int k = 0; k < 3; ++k)
        off[k] -= fmin(fmax(t, 0), 1) * way[k];
    return sqrt(dot(off, off));
}

double test_distance_to_tagged(const qn_mesh_view *view, const double p[3]) {
    double least = HUGE_VAL;
    for (int64_t e = 0; e < view->crease_edge_count; ++e) {
        const uint32_t *ends = view->crease_edges + 2 * e;
        least = fmin(least, segment_distance(p, view->positions + 3 * (int64_t)ends[0],
                                             view->positions + 3 * (int64_t)ends[1]));
    }
    return least;
}

static void measure_edge(const float *from, const float *to, const qn_mesh_view *view, double cell,
                         test_crease_share *share) {
    double a[3], b[3], length = 0;
    to_doubles(from, a);
    to_doubles(to, b);
    for (int k = 0; k < 3; ++k)
        length += (b[k] - a[k]) * (b[k] - a[k]);
    length = sqrt(length) / cell;
    const int steps = (int)ceil(4 * length);
    for (int n = 0; n < steps; ++n) {
        double p[3];
        for (int k = 0; k < 3; ++k)
            p[k] = a[k] + (n + 0.5) / steps * (b[k] - a[k]);
        const double off = test_distance_to_tagged(view, p) / cell;
        ++share->points;
        share->missing += off > 0.1;
        if (off > share->farthest) {
            share->farthest = off;
            memcpy(share->where, p, sizeof p);
        }
    }
}

test_crease_share test_measure_creases(const test_model *model, double degrees, const qn_mesh *mesh,
                                       double cell) {
    const double cosine = cos(degrees * 3.14159265358979323846 / 180);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    test_crease_share share = {0, 0, 0, {0, 0, 0}};
    side *sides = sorted_sides(model);
    for (int64_t n = 0; n + 1 < 3 * model->triangle_count; ++n) {
        double normals[2][3];
        if (compare_sides(&sides[n], &sides[n + 1]) != 0)
            continue;
        unit_normal(model, sides[n].triangle, normals[0]);
        unit_normal(model, sides[n + 1].triangle, normals[1]);
        if (dot(normals[0], normals[1]) < cosine)
            measure_edge(model->points[sides[n].ends[0]], model->points[sides[n].ends[1]], &view,
                         cell, &share);
    }
    free(sides);
    return share;
}
