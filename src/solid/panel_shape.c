// SPDX-License-Identifier: MIT
/* One panel in double: its normal, its nearest point, where a line meets it, the solid angle under
 * which it is seen. */
#include "solid/panel.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

static double dot(const double u[3], const double v[3]) {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static void cross(const double u[3], const double v[3], double out[3]) {
    out[0] = u[1] * v[2] - u[2] * v[1];
    out[1] = u[2] * v[0] - u[0] * v[2];
    out[2] = u[0] * v[1] - u[1] * v[0];
}

static void from_to(const double from[3], const double to[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = to[k] - from[k];
}

void qni_panel_normal(const qni_panel *panel, double normal[3]) {
    double a[3], b[3], c[3], ab[3], ac[3];
    const double none[3] = {0, 0, 0};
    qni_panel_corner(panel, 0, a);
    qni_panel_corner(panel, 1, b);
    qni_panel_corner(panel, 2, c);
    from_to(a, b, ab);
    from_to(a, c, ac);
    cross(ab, ac, normal);
    double raw[3] = {normal[0], normal[1], normal[2]};
    qni_unit(raw, none, normal);
}

/* After Ericson, "Real-time collision detection", 2005, section 5.1.5: the region of the plane that
 * the foot lies in says which corner, edge or inside is nearest. */
double qni_panel_nearest(const qni_panel *panel, const double p[3], double nearest[3]) {
    double a[3], b[3], c[3], ab[3], ac[3], ap[3], bp[3], cp[3];
    qni_panel_corner(panel, 0, a);
    qni_panel_corner(panel, 1, b);
    qni_panel_corner(panel, 2, c);
    from_to(a, b, ab);
    from_to(a, c, ac);
    from_to(a, p, ap);
    from_to(b, p, bp);
    from_to(c, p, cp);
    double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp);
    double d5 = dot(ab, cp), d6 = dot(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    double s = 0, t = 0;
    if (d1 <= 0 && d2 <= 0) {
        s = 0, t = 0;
    } else if (d3 >= 0 && d4 <= d3) {
        s = 1, t = 0;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        s = d1 > d3 ? d1 / (d1 - d3) : 0, t = 0;
    } else if (d6 >= 0 && d5 <= d6) {
        s = 0, t = 1;
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        s = 0, t = d2 > d6 ? d2 / (d2 - d6) : 0;
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        double whole = (d4 - d3) + (d5 - d6);
        t = whole > 0 ? (d4 - d3) / whole : 0, s = 1 - t;
    } else {
        double whole = va + vb + vc;
        s = vb / whole, t = vc / whole;
    }
    double offset[3];
    for (int k = 0; k < 3; ++k)
        nearest[k] = a[k] + s * ab[k] + t * ac[k];
    from_to(nearest, p, offset);
    return dot(offset, offset);
}

double qni_panel_place(const qni_panel *panel, const double a[3], const double b[3]) {
    double corner[3][3], ab[3], ac[3], along[3], from[3], normal[3], low = QNI_INFINITY,
                                                                     high = -QNI_INFINITY;
    for (int i = 0; i < 3; ++i)
        qni_panel_corner(panel, i, corner[i]);
    from_to(corner[0], corner[1], ab);
    from_to(corner[0], corner[2], ac);
    from_to(a, b, along);
    from_to(a, corner[0], from);
    cross(ab, ac, normal);
    double slant = dot(normal, along), place = dot(normal, from) / slant;
    double length = dot(along, along);
    for (int i = 0; i < 3; ++i) { /* a panel seen from its edge: rounding must not carry it away */
        from_to(a, corner[i], from);
        double at = dot(from, along) / length;
        low = at < low ? at : low;
        high = at > high ? at : high;
    }
    place = place == place ? place : 0.5 * (low + high);
    place = place < low ? low : place > high ? high : place;
    return place < 0 ? 0 : place > 1 ? 1 : place;
}

/* Does the axis have the panel on one side and the box on the other? Corners are from the middle of
 * the box; rounding, of these too, is less than `slack` for an axis of length 1. */
static bool separates(const double axis[3], const double corners[3][3], const double half[3],
                      double slack) {
    double low = QNI_INFINITY, high = -QNI_INFINITY, reach = 0;
    for (int i = 0; i < 3; ++i) {
        const double at = dot(axis, corners[i]);
        low = at < low ? at : low;
        high = at > high ? at : high;
    }
    for (int k = 0; k < 3; ++k)
        reach += fabs(axis[k]) * (half[k] + slack);
    return low > reach || high < -reach;
}

/* After Akenine-Moller, "Fast 3D triangle-box overlap testing", 2001. */
bool qni_panel_meets(const qni_panel *panel, const qni_box *box) {
    double corners[3][3], half[3], normal[3], edges[3][3], size = 0;
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * (box->low[k] + box->high[k]);
        half[k] = qni_greater(box->high[k] - middle, middle - box->low[k]);
        size = qni_greater(size, fabs(middle) + half[k]);
        for (int i = 0; i < 3; ++i) {
            corners[i][k] = (double)panel->at[i][k] - middle;
            size = qni_greater(size, fabs((double)panel->at[i][k]));
        }
    }
    const double slack = 1e-12 * size;
    for (int i = 0; i < 3; ++i)
        from_to(corners[i], corners[(i + 1) % 3], edges[i]);
    cross(edges[0], edges[1], normal);
    if (separates(normal, (const double(*)[3])corners, half, slack))
        return false;
    for (int n = 0; n < 12; ++n) {
        const double unit[3] = {n % 3 == 0, n % 3 == 1, n % 3 == 2};
        double axis[3];
        cross(unit, n < 9 ? edges[n / 3] : unit, axis);
        if (separates(n < 9 ? axis : unit, (const double(*)[3])corners, half, slack))
            return false;
    }
    return true;
}

/* The part of one edge in the gradient: that of a thread of current [Biot and Savart]. */
static void add_edge(const double r[3], const double s[3], double gradient[3]) {
    double across[3], r_length = sqrt(dot(r, r)), s_length = sqrt(dot(s, s));
    double both = r_length * s_length, below = both * (both + dot(r, s));
    cross(r, s, across);
    if (!(below > 1e-30 * both * both) || !(both > 0))
        return;
    for (int k = 0; k < 3; ++k)
        gradient[k] += across[k] * (r_length + s_length) / below / (4 * pi);
}

/* Van Oosterom and Strackee, "The solid angle of a plane triangle", 1983: half the angle is that of
 * the vector (below, above). Its sign is exact. */
static void half_angle(const qni_panel *panel, const double p[3], double gradient[3],
                       double *below_out, double *above_out) {
    double r[3][3], length[3], corner[3], normal[3];
    for (int i = 0; i < 3; ++i) {
        qni_panel_corner(panel, i, corner);
        from_to(p, corner, r[i]);
        length[i] = sqrt(dot(r[i], r[i]));
    }
    cross(r[1], r[2], normal);
    double above = dot(r[0], normal), size = length[0] * length[1] * length[2];
    *below_out = size + dot(r[0], r[1]) * length[2] + dot(r[1], r[2]) * length[0] +
                 dot(r[2], r[0]) * length[1];
    for (int i = 0; gradient && i < 3; ++i)
        add_edge(r[i], r[(i + 1) % 3], gradient);
    if (fabs(above) <= 1e-14 * size) /* its sign may be rounding's */
        above = -qni_panel_side(panel, p) * qni_greater(fabs(above), 1e-30 * size);
    *above_out = above;
}

double qni_panel_angle(const qni_panel *panel, const double p[3], double gradient[3]) {
    double below, above;
    half_angle(panel, p, gradient, &below, &above);
    return atan2(above, below) / (2 * pi);
}

/* Angles add up as their vectors are multiplied; turns past half a circle are counted. */
double qni_panels_angle(const qni_panel *panels, const int32_t *chosen, int32_t count,
                        const double p[3], double gradient[3]) {
    double x = 1, y = 0;
    int turns = 0;
    for (int32_t n = 0; n < count; ++n) {
        double below, above;
        half_angle(&panels[chosen ? chosen[n] : n], p, gradient, &below, &above);
        double next_x = x * below - y * above, next_y = x * above + y * below;
        if (y >= 0 && above > 0 && next_y < 0)
            ++turns;
        if (y < 0 && above < 0 && next_y >= 0)
            --turns;
        double size = fabs(next_x) + fabs(next_y);
        x = size > 0 ? next_x / size : 1;
        y = size > 0 ? next_y / size : 0;
    }
    return (atan2(y, x) + 2 * pi * turns) / (2 * pi);
}
