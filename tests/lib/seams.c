// SPDX-License-Identifier: MIT
#include "lib/seams.h"
#include "lib/crease_share.h"
#include "solid/solid.h"

#include <math.h>

enum { NEWTON_STEPS = 30, TRIES = 12 };
static const double degree = 3.14159265358979323846 / 180;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double distance(const double a[3], const double b[3]) {
    const double off[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(off, off));
}

static double value_at(const qn_solid *solid, const double p[3]) {
    const double points[1][3] = {{p[0], p[1], p[2]}};
    double value;
    assert_int_equal(qn_solid_values(solid, 1, points, &value, NULL), QN_OK);
    return value;
}

/* A part's value and gradient, as the whole has it. */
static double sheet_at(const test_parts *parts, int part, const double p[3], double gradient[3]) {
    const qn_solid *solid = parts->parts[part];
    const double points[1][3] = {{p[0], p[1], p[2]}};
    double found[1][3];
    assert_int_equal(solid->ops->gradients(solid, 1, points, found, NULL), QN_OK);
    for (int k = 0; k < 3; ++k)
        gradient[k] = parts->signs[part] * found[0][k];
    return parts->signs[part] * value_at(solid, p);
}

/* Is the point on an edge of the whole, not on a sheet that is hidden in it? Of the four sides of
 * two sheets, those inside must depend on both sheets. */
static bool is_bare(const test_parts *parts, const double p[3], const double g[2][3], double step) {
    double ways[2][3];
    bool inside[2][2];
    for (int n = 0; n < 2; ++n) {
        const double share = dot(g[n], g[1 - n]) / dot(g[1 - n], g[1 - n]);
        for (int k = 0; k < 3; ++k)
            ways[n][k] = g[n][k] - share * g[1 - n][k];
        const double length = sqrt(dot(ways[n], ways[n]));
        for (int k = 0; k < 3; ++k)
            ways[n][k] *= step / length;
    }
    for (int n = 0; n < 4; ++n) {
        double beside[3];
        for (int k = 0; k < 3; ++k)
            beside[k] = p[k] + (n & 1 ? 1 : -1) * ways[0][k] + (n & 2 ? 1 : -1) * ways[1][k];
        inside[n & 1][n >> 1] = value_at(parts->whole, beside) < 0;
    }
    return (inside[0][0] != inside[1][0] || inside[0][1] != inside[1][1]) &&
           (inside[0][0] != inside[0][1] || inside[1][0] != inside[1][1]);
}

/* To where two parts meet, next to a point; how much they turn there. */
static bool find_seam(const test_parts *parts, const int pair[2], double cell, double p[3],
                      double *turn) {
    double g[2][3], f[2];
    for (int step = 0; step <= NEWTON_STEPS; ++step) {
        for (int n = 0; n < 2; ++n)
            f[n] = sheet_at(parts, pair[n], p, g[n]);
        if (fabs(f[0]) < 1e-7 * cell && fabs(f[1]) < 1e-7 * cell)
            break;
        const double aa = dot(g[0], g[0]), bb = dot(g[1], g[1]), ab = dot(g[0], g[1]),
                     determinant = aa * bb - ab * ab;
        if (step == NEWTON_STEPS || !(determinant > 1e-6 * aa * bb))
            return false;
        for (int k = 0; k < 3; ++k)
            p[k] += ((f[1] * ab - f[0] * bb) * g[0][k] + (f[0] * ab - f[1] * aa) * g[1][k]) /
                    determinant;
    }
    const double cosine = dot(g[0], g[1]) / sqrt(dot(g[0], g[0]) * dot(g[1], g[1]));
    *turn = acos(fmin(fmax(cosine, -1), 1)) / degree;
    return fabs(value_at(parts->whole, p)) < 1e-6 * cell &&
           is_bare(parts, p, (const double(*)[3])g, 0.02 * cell);
}

/* ---- the mesh
 * ------------------------------------------------------------------------------------
 */

typedef struct side {
    uint32_t low, high; /* the edge's ends */
    uint32_t triangle;
} side;

static int compare_sides(const void *a, const void *b) {
    const side *p = a, *q = b;
    if (p->low != q->low)
        return p->low < q->low ? -1 : 1;
    return p->high < q->high ? -1 : p->high > q->high;
}

static side *sorted_sides(const qn_mesh_view *view) {
    const size_t count = 3 * (size_t)view->triangle_count;
    side *sides = test_alloc(count, sizeof *sides);
    for (size_t n = 0; n < count; ++n) {
        const uint32_t a = view->triangles[n], b = view->triangles[n % 3 == 2 ? n - 2 : n + 1];
        const side one = {a < b ? a : b, a < b ? b : a, (uint32_t)(n / 3)};
        sides[n] = one;
    }
    qsort(sides, count, sizeof *sides, compare_sides);
    return sides;
}

static void place_of(const qn_mesh_view *view, uint32_t vertex, double p[3]) {
    for (size_t k = 0; k < 3; ++k)
        p[k] = (double)view->positions[3 * (size_t)vertex + k];
}

static void normal_of(const qn_mesh_view *view, uint32_t triangle, double normal[3]) {
    double p[3][3], a[3], b[3];
    for (size_t n = 0; n < 3; ++n)
        place_of(view, view->triangles[3 * (size_t)triangle + n], p[n]);
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

static bool is_tagged(const qn_mesh_view *view, const side *edge) {
    for (int64_t n = 0; n < view->crease_edge_count; ++n) {
        const uint32_t a = view->crease_edges[2 * n], b = view->crease_edges[2 * n + 1];
        if ((a < b ? a : b) == edge->low && (a < b ? b : a) == edge->high)
            return true;
    }
    return false;
}

/* ---- both
 * ----------------------------------------------------------------------------------------
 */

typedef struct work {
    const test_parts *parts;
    const qn_mesh_view *view;
    double cell;
    test_random random;
    test_seams *sum;
} work;

/* Where both sheets are off by a twentieth of a cell, as the tolerance allows, their edge is off by
 * more, the sharper it is. */
static void note_point(work *w, const double p[3], double turn) {
    const double off = test_distance_to_tagged(w->view, p) / w->cell,
                 most = fmax(0.1, 0.05 / cos(0.5 * turn * degree));
    ++w->sum->points;
    w->sum->missing += off > most;
    if (off > w->sum->farthest) {
        w->sum->farthest = off;
        memcpy(w->sum->where, p, sizeof w->sum->where);
    }
}

/* Points of the seam of two parts round an edge of the mesh. Is there one of a small turn? */
static bool look_round(work *w, const int pair[2], const double a[3], const double b[3]) {
    bool shallow = false;
    for (int n = 0; n < TRIES; ++n) {
        double from[3], p[3], turn;
        for (int k = 0; k < 3; ++k) {
            from[k] = a[k] + (b[k] - a[k]) * (n + 0.5) / TRIES;
            from[k] += n % 3 ? w->cell * (test_random_unit(&w->random) - 0.5) : 0;
            p[k] = from[k];
        }
        if (!find_seam(w->parts, pair, w->cell, p, &turn) || distance(p, from) > w->cell)
            continue;
        shallow = shallow || turn < 35;
        if (turn > 40)
            note_point(w, p, turn);
    }
    return shallow;
}

static void measure_edge(work *w, const side *sides) {
    const qn_mesh_view *view = w->view;
    const int pair[2] = {view->triangle_owners[sides[0].triangle] - 1,
                         view->triangle_owners[sides[1].triangle] - 1};
    double a[3], b[3], m[3], n[3];
    assert_in_range(pair[0], 0, TEST_SEAM_PARTS - 1);
    assert_in_range(pair[1], 0, TEST_SEAM_PARTS - 1);
    place_of(view, sides[0].low, a);
    place_of(view, sides[0].high, b);
    if (pair[0] == pair[1] || distance(a, b) < 1e-3 * w->cell)
        return;
    normal_of(view, sides[0].triangle, m);
    normal_of(view, sides[1].triangle, n);
    const bool sharp = dot(m, n) < cos(35 * degree), shallow = look_round(w, pair, a, b);
    ++w->sum->edges;
    w->sum->flat += !sharp;
    if (!sharp || is_tagged(view, sides))
        return;
    ++w->sum->untagged;
    w->sum->shallow += shallow;
    if (!shallow)
        memcpy(w->sum->where, a, sizeof a);
}

void test_measure_seams(const test_parts *parts, const qn_mesh *mesh, double cell,
                        test_seams *sum) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    work w = {parts, &view, cell, {1}, sum};
    side *sides = sorted_sides(&view);
    for (int64_t n = 0; n + 1 < 3 * view.triangle_count; n += 2)
        measure_edge(&w, sides + n);
    free(sides);
}
