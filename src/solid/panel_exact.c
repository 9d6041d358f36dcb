// SPDX-License-Identifier: MIT
/* Sides and crossings of panels with exact signs. Ties are broken by moving every point by the same
 * (e, e^2, e^3), symbolically (after Edelsbrunner and Muecke, "Simulation of simplicity", 1990): so
 * a segment that meets an edge or a corner crosses exactly one of the panels round it that a
 * neighbouring segment would, and a closed model never leaks. */
#include "mesh/predicates.h"
#include "solid/panel.h"

static int component_sign(double from, double to) {
    return (to > from) - (to < from);
}

/* Which side of the line s - e in the plane of u and v the moved point q lies on. */
static int side_of_edge(const double s[3], const double e[3], const double q[3], int u, int v) {
    int sign = qni_turn_of(s, e, s, q, u, v);
    if (sign)
        return sign;
    int by_u = -component_sign(s[v], e[v]), by_v = component_sign(s[u], e[u]);
    int first = u < v ? by_u : by_v, second = u < v ? by_v : by_u;
    return first ? first : second;
}

static void corners_of(const qni_panel *panel, double corner[3][3]) {
    for (int i = 0; i < 3; ++i)
        qni_panel_corner(panel, i, corner[i]);
}

static int side_of_plane(const double (*corner)[3], const double p[3]) {
    int sign = qni_orient3d_of(corner[0], corner[1], corner[2], p);
    for (int k = 0; k < 3 && sign == 0; ++k)
        sign = qni_turn_of(corner[0], corner[1], corner[0], corner[2], (k + 1) % 3, (k + 2) % 3);
    return sign;
}

int qni_panel_side(const qni_panel *panel, const double p[3]) {
    double corner[3][3];
    corners_of(panel, corner);
    return side_of_plane((const double(*)[3])corner, p);
}

static bool spans(const qni_panel *panel, int k, double low, double high) {
    float x = panel->at[0][k], y = panel->at[1][k], z = panel->at[2][k];
    float least = x < y ? x : y, most = x < y ? y : x;
    least = z < least ? z : least;
    most = z > most ? z : most;
    return (double)least <= high && (double)most >= low;
}

/* Within the panel as seen along the axis of which u and v are the next ones? */
static bool turns_round(const double (*corner)[3], const double q[3], int u, int v) {
    const int first = side_of_edge(corner[0], corner[1], q, u, v);
    if (first == 0 || side_of_edge(corner[1], corner[2], q, u, v) != first ||
        side_of_edge(corner[2], corner[0], q, u, v) != first)
        return false;
    return true;
}

bool qni_panel_is_on_line(const qni_panel *panel, const double q[3], int axis) {
    double corner[3][3];
    corners_of(panel, corner);
    return turns_round((const double(*)[3])corner, q, (axis + 1) % 3, (axis + 2) % 3);
}

int qni_panel_across_axis(const qni_panel *panel, const double a[3], const double b[3], int axis) {
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double low = a[axis] < b[axis] ? a[axis] : b[axis],
           high = a[axis] < b[axis] ? b[axis] : a[axis];
    if (!spans(panel, u, a[u], a[u]) || !spans(panel, v, a[v], a[v]) ||
        !spans(panel, axis, low, high))
        return 0;
    double corner[3][3];
    corners_of(panel, corner);
    if (!turns_round((const double(*)[3])corner, a, u, v))
        return 0;
    return (side_of_plane((const double(*)[3])corner, a) -
            side_of_plane((const double(*)[3])corner, b)) /
           2;
}

/* On which side the moved segment a - b passes the edge s - e. */
static int passes_edge(const double a[3], const double b[3], const double s[3], const double e[3]) {
    int sign = qni_orient3d_of(a, b, s, e);
    for (int k = 0; k < 3 && sign == 0; ++k)
        sign = qni_turn_of(e, s, a, b, (k + 1) % 3, (k + 2) % 3);
    return sign;
}

int qni_segment_axis(const double a[3], const double b[3]) {
    int axis = 3;
    for (int k = 0; k < 3; ++k)
        if (a[k] < b[k] || a[k] > b[k])
            axis = axis == 3 ? k : -1;
    return axis;
}

int qni_panel_across(const qni_panel *panel, const double a[3], const double b[3]) {
    for (int k = 0; k < 3; ++k)
        if (!spans(panel, k, a[k] < b[k] ? a[k] : b[k], a[k] < b[k] ? b[k] : a[k]))
            return 0;
    double corner[3][3];
    corners_of(panel, corner);
    int from = side_of_plane((const double(*)[3])corner, a),
        to = side_of_plane((const double(*)[3])corner, b);
    if (from == to)
        return 0;
    int first = passes_edge(a, b, corner[0], corner[1]);
    if (first == 0 || passes_edge(a, b, corner[1], corner[2]) != first ||
        passes_edge(a, b, corner[2], corner[0]) != first)
        return 0;
    return (from - to) / 2;
}
