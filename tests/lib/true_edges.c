// SPDX-License-Identifier: MIT
#include "lib/true_edges.h"

#include <math.h>

static const double turn = 6.283185307179586;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double normalize(double a[3]) {
    const double length = sqrt(dot(a, a));
    for (int k = 0; k < 3; ++k)
        a[k] /= length > 0 ? length : 1;
    return length;
}

static void two_across(const double axis[3], double u[3], double v[3]) {
    const int least = fabs(axis[0]) < 0.6 ? 0 : 1;
    const double other[3] = {least == 0, least == 1, 0};
    cross(axis, other, u);
    normalize(u);
    cross(axis, u, v);
}

/* Distance from a face and the unit normal there. */
static double face_height(const test_face *face, const double point[3], double normal[3]) {
    double d[3] = {point[0] - face->centre[0], point[1] - face->centre[1],
                   point[2] - face->centre[2]};
    const double along = dot(d, face->axis);
    if (face->kind == TEST_FACE_PLANE) {
        memcpy(normal, face->axis, 3 * sizeof *normal);
        return along;
    }
    for (int k = 0; k < 3; ++k)
        normal[k] = d[k] - (face->kind == TEST_FACE_CYLINDER ? along * face->axis[k] : 0);
    return normalize(normal) - face->radius;
}

/* Steps that change the distance from one face and not from the other. */
static bool dual_steps(const double m[3], const double n[3], double steps[2][3]) {
    const double along = dot(m, n), scale = 1 - along * along;
    if (!(scale > 1e-12))
        return false;
    for (int k = 0; k < 3; ++k) {
        steps[0][k] = (m[k] - along * n[k]) / scale;
        steps[1][k] = (n[k] - along * m[k]) / scale;
    }
    return true;
}

/* Angle about the cylinder and height over the sphere's centre. */
static void quartic_at(const test_curve *curve, double t, double *angle, double *height) {
    if (curve->branch) {
        *angle = t;
        *height = curve->branch * sqrt(curve->a + curve->b * cos(t));
        return;
    }
    *height = curve->half_height * sin(t);
    *angle = 2 * asin(fmin(fmax(curve->half_height * cos(t) / sqrt(2 * curve->b), -1), 1));
}

void test_curve_at(const test_curve *curve, double t, double point[3]) {
    double height = 0, angle = t;
    if (curve->kind == TEST_QUARTIC)
        quartic_at(curve, t, &angle, &height);
    for (int k = 0; k < 3; ++k)
        point[k] = curve->kind == TEST_LINE
                       ? curve->origin[k] + t * curve->u[k]
                       : curve->origin[k] +
                             curve->radius * (cos(angle) * curve->u[k] + sin(angle) * curve->v[k]);
    for (int k = 0; k < 3 && curve->kind == TEST_QUARTIC; ++k)
        point[k] += height * curve->faces[0].axis[k];
}

/* ---- curves where two faces meet --------------------------------------------------------------
 */

static int plane_and_plane(const test_face *a, const test_face *b, test_curve *out) {
    double steps[2][3];
    cross(a->axis, b->axis, out->u);
    if (normalize(out->u) < 1e-9 || !dual_steps(a->axis, b->axis, steps))
        return 0;
    out->kind = TEST_LINE;
    const double m = dot(a->axis, a->centre), n = dot(b->axis, b->centre);
    for (int k = 0; k < 3; ++k)
        out->origin[k] = m * steps[0][k] + n * steps[1][k];
    return 1;
}

static int plane_and_sphere(const test_face *plane, const test_face *sphere, test_curve *out) {
    double normal[3];
    const double height = face_height(plane, sphere->centre, normal);
    if (fabs(height) >= sphere->radius)
        return 0;
    out->kind = TEST_CIRCLE;
    out->radius = sqrt(sphere->radius * sphere->radius - height * height);
    for (int k = 0; k < 3; ++k)
        out->origin[k] = sphere->centre[k] - height * normal[k];
    two_across(normal, out->u, out->v);
    return 1;
}

/* Across the axis or along it. */
static int plane_and_cylinder(const test_face *plane, const test_face *cylinder, test_curve *out) {
    double normal[3];
    const double height = face_height(plane, cylinder->centre, normal),
                 along = dot(plane->axis, cylinder->axis);
    if (fabs(along) > 1 - 1e-9) {
        out->kind = TEST_CIRCLE;
        out->radius = cylinder->radius;
        for (int k = 0; k < 3; ++k)
            out->origin[k] = cylinder->centre[k] - height * normal[k];
        two_across(normal, out->u, out->v);
        return 1;
    }
    assert_true(fabs(along) < 1e-9); /* no ellipses here */
    if (fabs(height) >= cylinder->radius)
        return 0;
    double side[3];
    cross(normal, cylinder->axis, side);
    const double half = sqrt(cylinder->radius * cylinder->radius - height * height);
    for (int n = 0; n < 2; ++n) {
        out[n].kind = TEST_LINE;
        for (int k = 0; k < 3; ++k) {
            out[n].u[k] = cylinder->axis[k];
            out[n].origin[k] =
                cylinder->centre[k] - height * normal[k] + (n ? half : -half) * side[k];
        }
    }
    return 2;
}

static int cylinder_and_sphere(const test_face *cylinder, const test_face *sphere,
                               test_curve *out) {
    double normal[3];
    const double r = cylinder->radius, d = face_height(cylinder, sphere->centre, normal) + r,
                 a = sphere->radius * sphere->radius - d * d - r * r, b = 2 * d * r;
    if (a + b <= 0)
        return 0;
    for (int n = 0; n < 2; ++n) {
        out[n].kind = TEST_QUARTIC;
        out[n].faces[0] = *cylinder;
        out[n].faces[1] = *sphere;
        out[n].branch = a < b ? 0 : n ? 1 : -1;
        out[n].radius = r;
        out[n].a = a;
        out[n].b = b;
        out[n].half_height = sqrt(a + b);
        memcpy(out[n].u, normal, sizeof normal);
        cross(cylinder->axis, normal, out[n].v);
        for (int k = 0; k < 3; ++k)
            out[n].origin[k] = sphere->centre[k] - d * normal[k];
    }
    return a < b ? 1 : 2;
}

static int curves_of(const test_face *a, const test_face *b, test_curve out[2]) {
    memset(out, 0, 2 * sizeof *out);
    for (int n = 0; n < 2; ++n) {
        out[n].faces[0] = *a;
        out[n].faces[1] = *b;
    }
    if (a->kind == TEST_FACE_PLANE && b->kind == TEST_FACE_PLANE)
        return plane_and_plane(a, b, out);
    if (a->kind == TEST_FACE_PLANE)
        return b->kind == TEST_FACE_SPHERE ? plane_and_sphere(a, b, out)
                                           : plane_and_cylinder(a, b, out);
    if (b->kind == TEST_FACE_PLANE)
        return curves_of(b, a, out);
    assert_true(a->kind != b->kind);
    return a->kind == TEST_FACE_CYLINDER ? cylinder_and_sphere(a, b, out)
                                         : cylinder_and_sphere(b, a, out);
}

/* ---- stretches that are edges of the solid ------------------------------------------------------
 */

/* The solid's signs in the four corners between the two faces: an edge where one differs from the
 * three others. */
static bool is_edge(const qn_solid *solid, const test_curve *curve, double t) {
    double point[3], m[3], n[3], steps[2][3];
    test_curve_at(curve, t, point);
    if (!isfinite(point[0]))
        return false;
    face_height(&curve->faces[0], point, m);
    face_height(&curve->faces[1], point, n);
    if (!dual_steps(m, n, steps))
        return false;
    int inside = 0;
    for (int c = 0; c < 4; ++c) {
        double at[3], step[3];
        for (int k = 0; k < 3; ++k)
            step[k] = (c & 1 ? 1 : -1) * steps[0][k] + (c & 2 ? 1 : -1) * steps[1][k];
        normalize(step);
        for (int k = 0; k < 3; ++k)
            at[k] = point[k] + 1e-9 * step[k];
        inside += test_solid_value(solid, at) < 0;
    }
    return inside == 1 || inside == 3;
}

static double find_change(const qn_solid *solid, const test_curve *curve, double a, double b) {
    const bool start = is_edge(solid, curve, a);
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (a + b);
        if (is_edge(solid, curve, middle) == start)
            a = middle;
        else
            b = middle;
    }
    return 0.5 * (a + b);
}

static double length_of(const test_edge *edge) {
    double length = 0, last[3], next[3];
    test_curve_at(&edge->curve, edge->low, last);
    for (int n = 1; n <= 256; ++n) {
        test_curve_at(&edge->curve, edge->low + (edge->high - edge->low) * n / 256, next);
        const double d[3] = {next[0] - last[0], next[1] - last[1], next[2] - last[2]};
        const double step = sqrt(dot(d, d));
        length += isfinite(step) ? step : 0;
        memcpy(last, next, sizeof last);
    }
    return length;
}

static void add_edge(test_edges *edges, const test_curve *curve, double low, double high,
                     bool closed) {
    assert_true(edges->count < TEST_MOST_EDGES);
    test_edge *edge = &edges->items[edges->count++];
    edge->curve = *curve;
    edge->low = low;
    edge->high = high;
    edge->closed = closed;
    edge->length = length_of(edge);
}

static void find_stretches(const qn_solid *solid, const test_curve *curve, double reach,
                           test_edges *edges) {
    enum { STEPS = 2048 };
    const bool line = curve->kind == TEST_LINE;
    const double from = line ? -reach : 0, step = (line ? 2 * reach : turn) / STEPS;
    int start = 0; /* circles begin where there is no edge, if there is such a place */
    while (start < STEPS && is_edge(solid, curve, from + start * step))
        ++start;
    if (start == STEPS) {
        add_edge(edges, curve, from, from + STEPS * step, true);
        return;
    }
    bool on = false;
    double low = 0;
    for (int n = 1; n <= STEPS; ++n) {
        const double t = from + (start + n) * step;
        if (is_edge(solid, curve, t) == on)
            continue;
        const double change = find_change(solid, curve, t - step, t);
        if (on)
            add_edge(edges, curve, low, change, false);
        low = change;
        on = !on;
    }
}

void test_find_edges(const qn_solid *solid, int face_count, const test_face *faces, double reach,
                     test_edges *edges) {
    edges->count = 0;
    for (int a = 0; a < face_count; ++a)
        for (int b = a + 1; b < face_count; ++b) {
            test_curve curves[2];
            const int count = curves_of(&faces[a], &faces[b], curves);
            for (int n = 0; n < count; ++n)
                find_stretches(solid, &curves[n], reach, edges);
        }
}

/* ---- how a mesh follows them --------------------------------------------------------------------
 */

static double distance(const double a[3], const double b[3]) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(d, d));
}

/* The curve's t next to a point, and the distance there. */
static double project(const test_curve *curve, const double point[3], double *t) {
    double d[3], foot[3];
    for (int k = 0; k < 3; ++k)
        d[k] = point[k] - curve->origin[k];
    *t = curve->kind == TEST_LINE ? dot(d, curve->u) : atan2(dot(d, curve->v), dot(d, curve->u));
    if (curve->kind == TEST_QUARTIC && curve->branch == 0)
        *t = atan2(dot(d, curve->faces[0].axis), sqrt(2 * curve->b) * sin(0.5 * *t));
    test_curve_at(curve, *t, foot);
    if (curve->kind != TEST_QUARTIC)
        return distance(foot, point);
    double m[3], n[3], steps[2][3], step[3];
    const double g = face_height(&curve->faces[0], point, m),
                 h = face_height(&curve->faces[1], point, n);
    if (!isfinite(foot[0]) || distance(foot, point) > 0.05 || !dual_steps(m, n, steps))
        return HUGE_VAL;
    for (int k = 0; k < 3; ++k)
        step[k] = g * steps[0][k] + h * steps[1][k];
    return sqrt(dot(step, step));
}

/* Distance from an edge, its ends included; t is moved to within a turn above `low`. */
static double edge_distance(const test_edge *edge, const double point[3], double slack, double *t) {
    double off = project(&edge->curve, point, t);
    if (edge->curve.kind != TEST_LINE)
        while (*t < edge->low - slack)
            *t += turn;
    if (edge->closed || (*t >= edge->low - slack && *t <= edge->high + slack))
        return off;
    double end[3];
    off = HUGE_VAL;
    for (int n = 0; n < 2; ++n) {
        test_curve_at(&edge->curve, n ? edge->high : edge->low, end);
        if (distance(end, point) < off) {
            off = distance(end, point);
            *t = n ? edge->high : edge->low;
        }
    }
    return off;
}

typedef struct link {
    double from, to;
    uint32_t ends[2];
} link;

static int compare_links(const void *a, const void *b) {
    const double p = ((const link *)a)->from, q = ((const link *)b)->from;
    return p < q ? -1 : p > q;
}

static void to_doubles(const float *place, double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = (double)place[k];
}

/* The tagged edges that lie along one true edge, in order. */
static int64_t gather_links(const test_edge *edge, const qn_mesh_view *view, double tolerance,
                            double unit, link *links) {
    int64_t count = 0;
    const double slack = tolerance / unit;
    for (int64_t e = 0; e < view->crease_edge_count; ++e) {
        double t[2], point[3];
        bool on = true;
        for (int k = 0; k < 2 && on; ++k) {
            to_doubles(view->positions + 3 * view->crease_edges[2 * e + k], point);
            on = edge_distance(edge, point, slack, &t[k]) <= tolerance;
        }
        if (!on)
            continue;
        const bool wraps = edge->closed && fabs(t[1] - t[0]) > turn / 2;
        const int first = (t[0] > t[1]) != wraps;
        link *l = &links[count++];
        l->from = t[first];
        l->to = wraps ? t[1 - first] + turn : t[1 - first];
        l->ends[0] = view->crease_edges[2 * e + first];
        l->ends[1] = view->crease_edges[2 * e + 1 - first];
    }
    qsort(links, (size_t)count, sizeof *links, compare_links);
    return count;
}

static void note_place(test_sharpness *sum, const test_curve *curve, double t) {
    if (sum->missing == 0 && sum->stray == 0)
        test_curve_at(curve, t, sum->first_gap);
}

/* Gaps of one edge's chain, in t; -1 when nothing is missing. */
static double gaps_of(const test_edge *edge, const link *links, int64_t count, double slack,
                      test_sharpness *sum) {
    double gaps = 0, at = edge->closed && count ? links[0].from : edge->low;
    const double end = edge->closed ? at + turn : edge->high;
    bool broken = count == 0;
    for (int64_t n = 0; n <= count; ++n) {
        const double next = n < count ? links[n].from : end;
        const bool joined =
            n == 0 || (n == count ? !edge->closed : links[n].ends[0] == links[n - 1].ends[1]) ||
            (n == count && links[n - 1].ends[1] == links[0].ends[0]);
        if (next > at + slack || !joined) {
            note_place(sum, &edge->curve, at);
            broken = true;
            gaps += next > at ? next - at : 0;
        }
        if (n < count && links[n].to > at)
            at = links[n].to;
    }
    return broken ? gaps : -1;
}

static void measure_edge(const test_edge *edge, const qn_mesh_view *view, double cell,
                         double tolerance, link *links, test_sharpness *sum) {
    const double unit = edge->length / (edge->high - edge->low);
    const int64_t count = gather_links(edge, view, tolerance, unit, links);
    const double gaps = gaps_of(edge, links, count, 2 * tolerance / unit, sum);
    ++sum->edges;
    sum->whole += gaps < 0;
    sum->missing += gaps > 0 ? gaps * unit / cell : 0;
    for (int n = 0; n < 2 && !edge->closed; ++n) {
        double end[3], point[3];
        bool found = false;
        test_curve_at(&edge->curve, n ? edge->high : edge->low, end);
        for (int64_t e = 0; e < 2 * view->crease_edge_count && !found; ++e) {
            to_doubles(view->positions + 3 * view->crease_edges[e], point);
            found = distance(point, end) <= tolerance;
        }
        ++sum->corners;
        sum->corners_found += found;
    }
}

static void measure_strays(const test_edges *edges, const qn_mesh_view *view, double cell,
                           double tolerance, test_sharpness *sum) {
    for (int64_t e = 0; e < 2 * view->crease_edge_count; ++e) {
        double point[3], least = HUGE_VAL, t;
        to_doubles(view->positions + 3 * view->crease_edges[e], point);
        for (int n = 0; n < edges->count; ++n)
            least = fmin(least, edge_distance(&edges->items[n], point, 0, &t));
        if (least > tolerance && sum->missing == 0 && sum->stray == 0)
            memcpy(sum->first_gap, point, sizeof point);
        sum->stray += least > tolerance;
        sum->farthest = fmax(sum->farthest, least / cell);
    }
    sum->crease_edges += view->crease_edge_count;
}

void test_measure_sharpness(const test_edges *edges, const qn_mesh *mesh, double cell,
                            double tolerance, test_sharpness *sum) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    link *links = test_alloc((size_t)view.crease_edge_count + 1, sizeof *links);
    for (int n = 0; n < edges->count; ++n)
        if (edges->items[n].length > 2 * cell)
            measure_edge(&edges->items[n], &view, cell, tolerance, links, sum);
    measure_strays(edges, &view, cell, tolerance, sum);
    free(links);
}
