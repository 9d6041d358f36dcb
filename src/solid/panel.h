// SPDX-License-Identifier: MIT
/* Triangles of a polygon model in a tree of boxes, and what is asked of them: on which side a point
 * lies and what a segment passes through (exactly), what is nearest, what a far point sees. */
#ifndef QNI_SOLID_PANEL_H
#define QNI_SOLID_PANEL_H

#include "solid/node.h"

typedef struct qni_panel {
    float at[3][3]; /* counter-clockwise from outside */
    int32_t owner;
    int32_t number; /* its place in the order given */
} qni_panel;

/* A node of the tree; its first child is the next node. */
typedef struct qni_panel_node {
    float low[3], high[3];
    int32_t second; /* child; 0 in leaves */
    int32_t first, count;
} qni_panel_node;

/* What a node's panels are from afar: a dipole. */
typedef struct qni_moment {
    double dipole[3], centre[3]; /* sum of area times normal; mean by area */
    double area, radius, rim;    /* rim: length of the edges from corner 1 to corner 0 */
} qni_moment;

typedef struct qni_panel_tree {
    qni_panel *panels; /* in the order of the leaves */
    int32_t count, capacity;
    qni_panel_node *nodes;
    int32_t node_count, node_capacity;
    qni_moment *moments; /* [node_count], or NULL */
} qni_panel_tree;

/* A box by floats that holds it, and little more. */
typedef struct qni_float_box {
    float low[4], high[4]; /* the last of each is not used */
} qni_float_box;

static inline qni_float_box qni_rounded_outwards(const qni_box *box) {
    qni_float_box out;
    for (int k = 0; k < 3; ++k) {
        const float low = (float)box->low[k], high = (float)box->high[k];
        out.low[k] = low - (fabsf(low) * 0x1p-23f + 0x1p-149f);
        out.high[k] = high + (fabsf(high) * 0x1p-23f + 0x1p-149f);
    }
    out.low[3] = out.high[3] = 0;
    return out;
}

/* Coordinates the predicates can take: tiny ones become 0, huge ones 1e40. */
static inline double qni_tame(double x) {
    return fabs(x) < 1e-60 ? 0 : x > 1e40 ? 1e40 : x < -1e40 ? -1e40 : x;
}

static inline void qni_panel_corner(const qni_panel *panel, int corner, double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = (double)panel->at[corner][k];
}

/* ---- panel_exact.c: points stand for themselves moved by (e, e^2, e^3), e > 0 without bound
 * small, so that no point lies on a panel and no segment meets an edge or a corner. All signs are
 * exact. */

/* +1 on the side the panel's normal points to, -1 on the other; 0 for a panel without area. */
int qni_panel_side(const qni_panel *panel, const double p[3]);
/* How often more a panel winds round b than round a: -1 when the segment leaves through it along
 * its normal, +1 when it comes in, 0 when it misses. Coordinates are tame. */
int qni_panel_across(const qni_panel *panel, const double a[3], const double b[3]);
/* The same for segments along one axis, in which alone a and b differ. */
int qni_panel_across_axis(const qni_panel *panel, const double a[3], const double b[3], int axis);
/* Does the line through q along the axis pass through the panel? Where it does, its points before
 * and behind have sides 1 and -1, or -1 and 1. */
bool qni_panel_is_on_line(const qni_panel *panel, const double q[3], int axis);
/* The axis in which alone a and b differ; -1 when there are more, 3 when they are equal. */
int qni_segment_axis(const double a[3], const double b[3]);

/* ---- panel_shape.c: in double, rounded */

void qni_panel_normal(const qni_panel *panel, double normal[3]); /* unit; 0 0 0 without area */
/* Squared distance, and the nearest point. */
double qni_panel_nearest(const qni_panel *panel, const double p[3], double nearest[3]);
/* Where the line through a and b meets the panel's plane, within the panel's own extent; 0 to 1. */
double qni_panel_place(const qni_panel *panel, const double a[3], const double b[3]);
/* Can it meet the box? No only where it surely does not. */
bool qni_panel_meets(const qni_panel *panel, const qni_box *box);
/* The solid angle over 4 pi, positive on the inner side (`side` as above, so that it jumps where
 * crossings do), and its gradient, which is added to. */
double qni_panel_angle(const qni_panel *panel, const double p[3], double gradient[3]);
/* The sum over a few of them: those that are `chosen`, or the first ones where that is NULL. */
double qni_panels_angle(const qni_panel *panels, const int32_t *chosen, int32_t count,
                        const double p[3], double gradient[3]);

/* ---- panel_tree.c */

/* Puts the panels in order and makes the nodes (panel_divide.c), for which there is room. */
bool qni_panel_tree_divide(qn_context *context, qni_panel_tree *tree);
/* Builds nodes over the panels that are there; moments too when asked for. False: no memory. */
bool qni_panel_tree_build(qn_context *context, qni_panel_tree *tree, bool with_moments);
void qni_panel_tree_free(qn_context *context, qni_panel_tree *tree);
/* Room for so many panels in all. */
bool qni_panel_tree_reserve(qn_context *context, qni_panel_tree *tree, int64_t count);
bool qni_panel_tree_add(qn_context *context, qni_panel_tree *tree, const qni_panel *panel);

/* Calls `visit` for each panel whose box meets the box; stops and says false when it does. */
typedef bool qni_panel_visit(void *user, int32_t panel);
bool qni_panel_tree_visit(const qni_panel_tree *tree, const qni_box *box, qni_panel_visit *visit,
                          void *user);
/* The same for a segment: of each panel that it meets, and of few more. */
bool qni_panel_tree_visit_segment(const qni_panel_tree *tree, const double a[3], const double b[3],
                                  qni_panel_visit *visit, void *user);
/* The panels that meet the box, in the tree's order; large ones only where they themselves meet it,
 * not just their boxes. False when they are more than `most`. */
bool qni_panel_tree_list(const qni_panel_tree *tree, const qni_box *box, int32_t most,
                         int32_t *numbers, int32_t *count);
/* The panel nearest to p, of equally near ones that of the lowest number; -1 when there is none. A
 * guess (or -1) that is near saves most of the search and changes nothing else. */
int32_t qni_panel_tree_nearest(const qni_panel_tree *tree, const double p[3], int32_t guess,
                               double *square, double nearest[3]);
/* The sum of qni_panel_angle() over the tree, dipoles standing for what is far (after Barill,
 * Dickson, Schmidt, Levin, Jacobson, "Fast winding numbers for soups and clouds", 2018). */
double qni_panel_tree_angle(const qni_panel_tree *tree, const double p[3], double gradient[3]);
/* More than its gradient can be at any point within `reach` of p, where the panels are fans whose
 * spokes cancel: what is left are the edges from corner 1 to corner 0. Infinite where such an edge
 * comes that near. */
double qni_panel_tree_slope_bound(const qni_panel_tree *tree, const double p[3], double reach);
/* Whether a panel's box comes within `reach` of p along every axis. */
bool qni_panel_tree_is_near(const qni_panel_tree *tree, const double p[3], double reach);

#endif
