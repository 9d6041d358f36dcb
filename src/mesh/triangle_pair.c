// SPDX-License-Identifier: MIT
/* Two triangles meet or not: signs of determinants only, no point is ever computed.
 *
 * Triangles in different planes meet in a segment, each end of which lies on an edge of one and in
 * the other; so it is enough to try the edges of each against the other. In one plane two convex
 * shapes are apart when, and only when, one lies strictly outside an edge of the other. That is
 * tried, too, before exact signs of volumes are worked out for triangles nearly in one plane, as
 * those of flat parts are: apart in a projection is apart in space, and costs less to tell. */
#include "mesh/triangle_pair.h"
#include "mesh/predicates.h"

#include <math.h>

typedef struct triangle {
    const float *p[3];
} triangle;

/* The coordinates of a plane in which the triangle keeps its area, and its sense there. */
typedef struct projection {
    int x, y, sense;
} projection;

static projection projection_of(const triangle *t) {
    projection best = {0, 1, 0};
    for (int axis = 0; axis < 3 && best.sense == 0; ++axis) {
        best.x = (axis + 1) % 3;
        best.y = (axis + 2) % 3;
        best.sense = qni_orient2d(t->p[0], t->p[1], t->p[2], best.x, best.y);
    }
    return best;
}

static int sense_in(const projection *plane, const float *a, const float *b, const float *c) {
    return qni_orient2d(a, b, c, plane->x, plane->y);
}

/* The one in which the triangle is about largest. */
static projection broadest_of(const triangle *t) {
    projection best = {0, 1, 0};
    double most = -1;
    for (int axis = 0; axis < 3; ++axis) {
        const int x = (axis + 1) % 3, y = (axis + 2) % 3;
        const double a = (double)t->p[1][x] - (double)t->p[0][x],
                     b = (double)t->p[1][y] - (double)t->p[0][y],
                     c = (double)t->p[2][x] - (double)t->p[0][x],
                     d = (double)t->p[2][y] - (double)t->p[0][y], area = fabs(a * d - b * c);
        if (area > most) {
            most = area;
            best.x = x;
            best.y = y;
        }
    }
    best.sense = qni_orient2d(t->p[0], t->p[1], t->p[2], best.x, best.y);
    return best;
}

/* Does an edge of a have all of b strictly outside in the projection, but for the corners they
 * share, which come first in both and lie on that edge? */
static bool edge_clears(const projection *plane, int sense, const triangle *a, const triangle *b,
                        int shared) {
    for (int i = 0; i < 3 && sense != 0; ++i) {
        const int j = (i + 1) % 3;
        int k = shared;
        if ((shared == 1 && i == 1) || (shared == 2 && i != 0))
            continue;
        while (k < 3 && sense_in(plane, a->p[i], a->p[j], b->p[k]) * sense < 0)
            ++k;
        if (k == 3)
            return true;
    }
    return false;
}

/* Triangles that no volume's sign tells apart at once. */
static bool are_apart_in_projection(const triangle *a, const triangle *b, int shared) {
    const projection plane = broadest_of(a);
    return edge_clears(&plane, plane.sense, a, b, shared) ||
           edge_clears(&plane, sense_in(&plane, b->p[0], b->p[1], b->p[2]), b, a, shared);
}

/* Sides of b's own corners as seen from the plane of a; false when the triangles are found to be
 * apart on the way. */
static bool sides_or_apart(const triangle *a, const triangle *b, int shared, int sides[3]) {
    bool clear = true;
    for (int k = shared; k < 3; ++k) {
        sides[k] = qni_orient3d_quick(a->p[0], a->p[1], a->p[2], b->p[k]);
        clear = clear && sides[k] != 0;
    }
    if (!clear && are_apart_in_projection(a, b, shared))
        return false;
    for (int k = shared; k < 3 && !clear; ++k)
        if (sides[k] == 0)
            sides[k] = qni_orient3d(a->p[0], a->p[1], a->p[2], b->p[k]);
    return true;
}

static void sides_of(const triangle *a, const triangle *b, int sides[3]) {
    for (int i = 0; i < 3; ++i)
        sides[i] = qni_orient3d(a->p[0], a->p[1], a->p[2], b->p[i]);
}

static bool all_on_one_side(const int sides[3]) {
    return (sides[0] > 0 && sides[1] > 0 && sides[2] > 0) ||
           (sides[0] < 0 && sides[1] < 0 && sides[2] < 0);
}

/* Segment pq against triangle t, the ends not both in its plane and not both on one side of it. */
static bool segment_pierces(const float *p, const float *q, const triangle *t) {
    int first = qni_orient3d(p, q, t->p[0], t->p[1]);
    int second = qni_orient3d(p, q, t->p[1], t->p[2]);
    if (first * second < 0)
        return false;
    int third = qni_orient3d(p, q, t->p[2], t->p[0]);
    return first * third >= 0 && second * third >= 0;
}

static bool can_pierce(int p_side, int q_side) {
    return p_side * q_side <= 0 && (p_side != 0 || q_side != 0);
}

static bool any_edge_pierces(const triangle *a, const int a_sides[3], const triangle *b) {
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3;
        if (can_pierce(a_sides[i], a_sides[j]) && segment_pierces(a->p[i], a->p[j], b))
            return true;
    }
    return false;
}

/* True when an edge of a has all of b strictly outside. */
static bool edge_parts(const projection *plane, int a_sense, const triangle *a, const triangle *b) {
    for (int i = 0; i < 3; ++i) {
        int outside = 0;
        for (int k = 0; k < 3; ++k)
            outside += sense_in(plane, a->p[i], a->p[(i + 1) % 3], b->p[k]) * a_sense < 0;
        if (outside == 3)
            return true;
    }
    return false;
}

static bool strangers_meet(const triangle *a, const triangle *b) {
    int a_sides[3], b_sides[3];
    if (!sides_or_apart(a, b, 0, b_sides) || all_on_one_side(b_sides))
        return false;
    if (b_sides[0] == 0 && b_sides[1] == 0 && b_sides[2] == 0) {
        projection plane = projection_of(a);
        int b_sense = sense_in(&plane, b->p[0], b->p[1], b->p[2]);
        return !edge_parts(&plane, plane.sense, a, b) && !edge_parts(&plane, b_sense, b, a);
    }
    sides_of(b, a, a_sides);
    return !all_on_one_side(a_sides) &&
           (any_edge_pierces(b, b_sides, a) || any_edge_pierces(a, a_sides, b));
}

/* In the plane of wedge (s; a, b): does the ray from s through p run in the closed wedge? */
static bool in_wedge(const projection *plane, const triangle *wedge, const float *p) {
    const float *s = wedge->p[0];
    int sense = sense_in(plane, s, wedge->p[1], wedge->p[2]);
    return sense * sense_in(plane, s, wedge->p[1], p) >= 0 &&
           sense * sense_in(plane, s, p, wedge->p[2]) >= 0;
}

/* Corner 0 is shared. What the triangles have in common is convex and holds that corner; if there
 * is more of it, its far end lies on the edge opposite the corner, of one or the other. */
static bool neighbors_at_vertex_meet(const triangle *a, const triangle *b) {
    int b_sides[3];
    if (!sides_or_apart(a, b, 1, b_sides) || b_sides[1] * b_sides[2] > 0)
        return false;
    if (b_sides[1] == 0 && b_sides[2] == 0) {
        projection plane = projection_of(a);
        return in_wedge(&plane, a, b->p[1]) || in_wedge(&plane, a, b->p[2]) ||
               in_wedge(&plane, b, a->p[1]) || in_wedge(&plane, b, a->p[2]);
    }
    int a_first = qni_orient3d(b->p[0], b->p[1], b->p[2], a->p[1]);
    int a_second = qni_orient3d(b->p[0], b->p[1], b->p[2], a->p[2]);
    if (a_first * a_second > 0)
        return false;
    return segment_pierces(a->p[1], a->p[2], b) || segment_pierces(b->p[1], b->p[2], a);
}

/* Corners 0 and 1 are shared: the other two overlap when they are in one plane and on one side. */
static bool neighbors_at_edge_meet(const triangle *a, const triangle *b) {
    int b_sides[3];
    if (!sides_or_apart(a, b, 2, b_sides) || b_sides[2] != 0)
        return false;
    projection plane = projection_of(a);
    return sense_in(&plane, a->p[0], a->p[1], b->p[2]) == plane.sense;
}

/* Bring the shared vertices to the front of both, in the same order; how many there are. */
static int align(const uint32_t a[3], const uint32_t b[3], int a_order[3], int b_order[3]) {
    int shared = 0;
    bool b_taken[3] = {false, false, false};
    int a_left = 2, b_left = 2;
    for (int i = 0; i < 3; ++i) {
        int same = -1;
        for (int j = 0; j < 3; ++j)
            if (a[i] == b[j])
                same = j;
        if (same < 0) {
            a_order[a_left--] = i;
            continue;
        }
        a_order[shared] = i;
        b_order[shared++] = same;
        b_taken[same] = true;
    }
    for (int j = 0; j < 3; ++j)
        if (!b_taken[j])
            b_order[b_left--] = j;
    return shared;
}

bool qni_triangles_meet(const float *positions, const uint32_t a[3], const uint32_t b[3]) {
    int a_order[3], b_order[3];
    int shared = align(a, b, a_order, b_order);
    triangle s, t;
    for (int i = 0; i < 3; ++i) {
        s.p[i] = positions + 3 * (size_t)a[a_order[i]];
        t.p[i] = positions + 3 * (size_t)b[b_order[i]];
    }
    switch (shared) {
    case 0:
        return strangers_meet(&s, &t);
    case 1:
        return neighbors_at_vertex_meet(&s, &t);
    case 2:
        return neighbors_at_edge_meet(&s, &t);
    default:
        return true;
    }
}
