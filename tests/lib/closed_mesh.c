// SPDX-License-Identifier: MIT
#include "lib/closed_mesh.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

static uint32_t add_vertex(test_pieces *pieces, const double p[3]) {
    pieces->positions =
        realloc(pieces->positions, (size_t)(pieces->vertex_count + 1) * 3 * sizeof(float));
    for (int i = 0; i < 3; ++i)
        pieces->positions[3 * pieces->vertex_count + i] = (float)p[i];
    return (uint32_t)pieces->vertex_count++;
}

static void add_triangle(test_pieces *pieces, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t corners[3] = {a, b, c};
    pieces->triangles =
        realloc(pieces->triangles, (size_t)(pieces->triangle_count + 1) * sizeof corners);
    memcpy(pieces->triangles + 3 * pieces->triangle_count++, corners, sizeof corners);
}

static uint32_t add_ball_vertex(test_pieces *pieces, test_random *random, const double centre[3],
                                double radius, double bumps, double polar, double round) {
    const double r = radius * (1 + bumps * (2 * test_random_unit(random) - 1));
    const double p[3] = {centre[0] + r * sin(polar) * cos(round),
                         centre[1] + r * sin(polar) * sin(round), centre[2] + r * cos(polar)};
    return add_vertex(pieces, p);
}

void test_add_ball(test_pieces *pieces, test_random *random, const double centre[3], double radius,
                   double bumps, int rings, int segments) {
    const uint32_t top = add_ball_vertex(pieces, random, centre, radius, bumps, 0, 0);
    const uint32_t bottom = add_ball_vertex(pieces, random, centre, radius, bumps, pi, 0);
    for (int ring = 0; ring < rings; ++ring)
        for (int s = 0; s < segments; ++s)
            add_ball_vertex(pieces, random, centre, radius, bumps, pi * (ring + 1) / (rings + 1),
                            2 * pi * s / segments);
    for (int s = 0; s < segments; ++s) {
        const uint32_t here = bottom + 1 + (uint32_t)s,
                       next = bottom + 1 + (uint32_t)((s + 1) % segments);
        const uint32_t last = (uint32_t)((rings - 1) * segments);
        add_triangle(pieces, top, here, next);
        add_triangle(pieces, bottom, next + last, here + last);
        for (uint32_t row = 0; row < last; row += (uint32_t)segments) {
            add_triangle(pieces, here + row, here + row + (uint32_t)segments, next + row);
            add_triangle(pieces, next + row, here + row + (uint32_t)segments,
                         next + row + (uint32_t)segments);
        }
    }
}

/* Rodrigues' formula about a random axis. */
static void turn_about(test_random *random, double angle, double turn[3][3]) {
    double axis[3], length = 0;
    for (int i = 0; i < 3; ++i) {
        axis[i] = test_random_gaussian(random);
        length += axis[i] * axis[i];
    }
    const double c = cos(angle), s = sin(angle);
    for (int i = 0; i < 3; ++i)
        axis[i] /= sqrt(length);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int k = 3 - i - j;
            const double sign = (j - i + 3) % 3 == 1 ? -1 : 1;
            turn[i][j] = axis[i] * axis[j] * (1 - c) + (i == j ? c : sign * s * axis[k % 3]);
        }
}

void test_add_box(test_pieces *pieces, test_random *random, const double centre[3],
                  const double half[3], double angle) {
    static const uint32_t faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                          {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                          {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    double turn[3][3];
    turn_about(random, angle, turn);
    const uint32_t first = (uint32_t)pieces->vertex_count;
    for (int v = 0; v < 8; ++v) {
        double p[3] = {centre[0], centre[1], centre[2]};
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i)
                p[i] += turn[i][j] * (v >> j & 1 ? half[j] : -half[j]);
        add_vertex(pieces, p);
    }
    for (int f = 0; f < 12; ++f)
        add_triangle(pieces, first + faces[f][0], first + faces[f][1], first + faces[f][2]);
}

qn_mesh *test_pieces_mesh(qn_context *context, test_pieces *pieces) {
    const qn_mesh_view view = {.vertex_count = pieces->vertex_count,
                               .triangle_count = pieces->triangle_count,
                               .positions = pieces->positions,
                               .triangles = pieces->triangles};
    qn_mesh *mesh = NULL;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    free(pieces->positions);
    free(pieces->triangles);
    memset(pieces, 0, sizeof *pieces);
    return mesh;
}

/* ---- slow and plain measures -------------------------------------------------------------------
 */

typedef struct place {
    double x, y, z;
} place;

static place from(const float *p, const double origin[3]) {
    const place q = {(double)p[0] - origin[0], (double)p[1] - origin[1], (double)p[2] - origin[2]};
    return q;
}

static double dot(place a, place b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static place cross(place a, place b) {
    const place c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return c;
}

static place minus(place a, place b) {
    const place c = {a.x - b.x, a.y - b.y, a.z - b.z};
    return c;
}

double test_winding_number(const qn_mesh *mesh, const double p[3]) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    double sum = 0;
    for (int64_t t = 0; t < view.triangle_count; ++t) {
        const uint32_t *v = view.triangles + 3 * t;
        const place a = from(view.positions + 3 * v[0], p), b = from(view.positions + 3 * v[1], p);
        const place c = from(view.positions + 3 * v[2], p);
        const double la = sqrt(dot(a, a)), lb = sqrt(dot(b, b)), lc = sqrt(dot(c, c));
        sum += 2 * atan2(dot(a, cross(b, c)),
                         la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum / (4 * pi);
}

static double to_segment(place a, place b) {
    const place along = minus(b, a);
    const double length = dot(along, along);
    double t = length > 0 ? -dot(a, along) / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    const place foot = {a.x + t * along.x, a.y + t * along.y, a.z + t * along.z};
    return dot(foot, foot);
}

/* From the origin: the least over the sides and, where the foot lies within, the plane. */
static double to_triangle(place a, place b, place c) {
    double squared = fmin(to_segment(a, b), fmin(to_segment(b, c), to_segment(c, a)));
    const place n = cross(minus(b, a), minus(c, a));
    const double length = dot(n, n), height = dot(n, a);
    const bool within =
        dot(n, cross(a, b)) >= 0 && dot(n, cross(b, c)) >= 0 && dot(n, cross(c, a)) >= 0;
    if (within && length > 0)
        squared = fmin(squared, height * height / length);
    return squared;
}

double test_mesh_distance_to(const qn_mesh *mesh, const double p[3]) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    double squared = (double)INFINITY;
    for (int64_t t = 0; t < view.triangle_count; ++t) {
        const uint32_t *v = view.triangles + 3 * t;
        squared = fmin(squared, to_triangle(from(view.positions + 3 * v[0], p),
                                            from(view.positions + 3 * v[1], p),
                                            from(view.positions + 3 * v[2], p)));
    }
    return sqrt(squared);
}
