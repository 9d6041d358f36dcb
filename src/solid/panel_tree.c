// SPDX-License-Identifier: MIT
/* The tree of boxes over panels: what is in a box, on a segment, near a point. */
#include "solid/panel.h"

#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { MOST_LEVELS = 64 };
/* Dipoles stand for what is farther away than this times its radius: then the sum over all of a
 * hole's cap is right to about 5e-3. Asked only beyond the root of the field (cap_field.h). */
static const double far_away = 6;

bool qni_panel_tree_reserve(qn_context *context, qni_panel_tree *tree, int64_t count) {
    if (count <= tree->capacity)
        return true;
    if (count > INT32_MAX / 2)
        return false;
    qni_panel *panels = qni_realloc(context, tree->panels, tree->capacity, count, sizeof *panels);
    if (!panels)
        return false;
    tree->panels = panels;
    tree->capacity = (int32_t)count;
    return true;
}

bool qni_panel_tree_add(qn_context *context, qni_panel_tree *tree, const qni_panel *panel) {
    if (tree->count == tree->capacity &&
        !qni_panel_tree_reserve(context, tree, tree->capacity + tree->capacity / 2 + (int64_t)64))
        return false;
    tree->panels[tree->count++] = *panel;
    return true;
}

void qni_panel_tree_free(qn_context *context, qni_panel_tree *tree) {
    qni_free(context, tree->panels, tree->capacity, sizeof *tree->panels);
    qni_free(context, tree->moments, tree->node_capacity, sizeof *tree->moments);
    qni_free(context, tree->nodes, tree->node_capacity, sizeof *tree->nodes);
    memset(tree, 0, sizeof *tree);
}

static double edge_length(const qni_panel *panel) {
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        double d = (double)panel->at[0][k] - (double)panel->at[1][k];
        square += d * d;
    }
    return sqrt(square);
}

static double panel_area(const qni_panel *panel, double vector[3], double centre[3]) {
    double u[3], v[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = (double)panel->at[1][k] - (double)panel->at[0][k];
        v[k] = (double)panel->at[2][k] - (double)panel->at[0][k];
        centre[k] =
            ((double)panel->at[0][k] + (double)panel->at[1][k] + (double)panel->at[2][k]) / 3;
    }
    for (int k = 0; k < 3; ++k)
        vector[k] = 0.5 * (u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
    return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

static void sum_moments(const qni_panel_tree *tree, int32_t index) {
    const qni_panel_node *node = &tree->nodes[index];
    qni_moment *moment = &tree->moments[index];
    memset(moment, 0, sizeof *moment);
    for (int32_t n = node->first; n < node->first + node->count; ++n) {
        double vector[3], centre[3], area = panel_area(&tree->panels[n], vector, centre);
        moment->area += area;
        moment->rim += edge_length(&tree->panels[n]);
        for (int k = 0; k < 3; ++k) {
            moment->dipole[k] += vector[k];
            moment->centre[k] += area * centre[k];
        }
    }
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        double low = (double)node->low[k], high = (double)node->high[k];
        moment->centre[k] =
            moment->area > 0 ? moment->centre[k] / moment->area : 0.5 * (low + high);
        double reach = qni_max(moment->centre[k] - low, high - moment->centre[k]);
        square += reach * reach;
    }
    moment->radius = sqrt(square);
}

/* Leaves have two panels at least, most have more. */
static bool trim_nodes(qn_context *context, qni_panel_tree *tree) {
    qni_panel_node *nodes =
        qni_realloc(context, tree->nodes, tree->node_capacity, tree->node_count, sizeof *nodes);
    if (!nodes)
        return false;
    tree->nodes = nodes;
    tree->node_capacity = tree->node_count;
    return true;
}

bool qni_panel_tree_build(qn_context *context, qni_panel_tree *tree, bool with_moments) {
    if (tree->count == 0)
        return true;
    int64_t most = (int64_t)tree->count < 2 ? 1 : 2 * (int64_t)tree->count;
    qni_free(context, tree->nodes, tree->node_capacity, sizeof *tree->nodes);
    tree->nodes = qni_alloc(context, most, sizeof *tree->nodes);
    tree->node_capacity = tree->nodes ? (int32_t)most : 0;
    if (!tree->nodes || !qni_panel_tree_divide(context, tree) || !trim_nodes(context, tree))
        return false;
    if (!with_moments)
        return true;
    tree->moments = qni_alloc(context, tree->node_capacity, sizeof *tree->moments);
    for (int32_t n = 0; tree->moments && n < tree->node_count; ++n)
        sum_moments(tree, n);
    return tree->moments != NULL;
}

#ifdef __SSE2__

static bool meets(const qni_panel_node *node, const qni_float_box *box) {
    const float *bounds = (const float *)(const void *)node; /* one more is loaded than compared */
    const __m128 low = _mm_cmple_ps(_mm_loadu_ps(bounds), _mm_loadu_ps(box->high)),
                 high = _mm_cmpge_ps(_mm_loadu_ps(bounds + 3), _mm_loadu_ps(box->low));
    return (_mm_movemask_ps(_mm_and_ps(low, high)) & 7) == 7;
}

#else

static bool meets(const qni_panel_node *node, const qni_float_box *box) {
    for (int k = 0; k < 3; ++k)
        if (node->low[k] > box->high[k] || node->high[k] < box->low[k])
            return false;
    return true;
}

#endif

static bool panel_meets(const qni_panel *panel, const qni_box *box) {
    for (int k = 0; k < 3; ++k) {
        const float x = panel->at[0][k], y = panel->at[1][k], z = panel->at[2][k];
        if ((double)qni_least_of(x, y, z) > box->high[k] ||
            (double)qni_most_of(x, y, z) < box->low[k])
            return false;
    }
    return true;
}

/* A segment, to be compared with boxes that meet its own: by the axes across it and an edge of
 * theirs. */
typedef struct segment_job {
    double middle[3], half[3];
    double slack; /* more than what rounding does to products */
} segment_job;

static bool passes_by(const segment_job *segment, const qni_panel_node *node) {
    double off[3], half[3];
    for (int k = 0; k < 3; ++k) {
        const double low = (double)node->low[k], high = (double)node->high[k];
        off[k] = segment->middle[k] - 0.5 * (low + high);
        half[k] = 0.5 * (high - low);
    }
    for (int k = 0; k < 3; ++k) {
        const int l = k == 2 ? 0 : k + 1, m = k == 0 ? 2 : k - 1;
        const double a = segment->half[l], b = segment->half[m];
        if (fabs(off[l] * b - off[m] * a) > half[l] * fabs(b) + half[m] * fabs(a) + segment->slack)
            return true;
    }
    return false;
}

/* Of what meets the box; with a segment, of what that does not pass by. */
static bool walk(const qni_panel_tree *tree, const qni_box *box, const segment_job *segment,
                 qni_panel_visit *visit, void *user) {
    const qni_float_box around = qni_rounded_outwards(box);
    int32_t stack[MOST_LEVELS], height = 0;
    if (tree->count)
        stack[height++] = 0;
    while (height) {
        const int32_t index = stack[--height];
        const qni_panel_node *node = &tree->nodes[index];
        if (!meets(node, &around) || (segment && passes_by(segment, node)))
            continue;
        if (node->second) {
            stack[height++] = node->second;
            stack[height++] = index + 1;
            continue;
        }
        for (int32_t n = node->first; n < node->first + node->count; ++n)
            if (panel_meets(&tree->panels[n], box) && !visit(user, n))
                return false;
    }
    return true;
}

bool qni_panel_tree_visit(const qni_panel_tree *tree, const qni_box *box, qni_panel_visit *visit,
                          void *user) {
    return walk(tree, box, NULL, visit, user);
}

bool qni_panel_tree_visit_segment(const qni_panel_tree *tree, const double a[3], const double b[3],
                                  qni_panel_visit *visit, void *user) {
    const qni_box box = qni_segment_box(a, b);
    segment_job segment = {.slack = 0};
    double size = 0, length = 0;
    for (int k = 0; k < 3 && tree->count; ++k) {
        segment.middle[k] = 0.5 * (a[k] + b[k]);
        segment.half[k] = 0.5 * (b[k] - a[k]);
        length = qni_greater(length, fabs(segment.half[k]));
        size = qni_greater(size, fabs((double)tree->nodes[0].low[k]));
        size = qni_greater(size, fabs((double)tree->nodes[0].high[k]));
        size = qni_greater(size, qni_greater(fabs(a[k]), fabs(b[k])));
    }
    segment.slack = 64 * QNI_EPSILON * length * size;
    return walk(tree, &box, &segment, visit, user);
}

static bool lies_within(const qni_panel_node *node, const qni_box *box) {
    for (int k = 0; k < 3; ++k)
        if ((double)node->low[k] < box->low[k] || (double)node->high[k] > box->high[k])
            return false;
    return true;
}

/* A panel whose box meets a box, but itself does not, is worth finding where it is large. */
static bool misses(const qni_panel *panel, const qni_box *box) {
    double extent = 0, room = 0;
    for (int k = 0; k < 3; ++k) {
        const float x = panel->at[0][k], y = panel->at[1][k], z = panel->at[2][k];
        room = qni_greater(room, box->high[k] - box->low[k]);
        extent = qni_greater(extent, (double)qni_most_of(x, y, z) - (double)qni_least_of(x, y, z));
    }
    return extent > room && !qni_panel_meets(panel, box);
}

bool qni_panel_tree_list(const qni_panel_tree *tree, const qni_box *box, int32_t most,
                         int32_t *numbers, int32_t *count) {
    const qni_float_box around = qni_rounded_outwards(box);
    int32_t stack[MOST_LEVELS], height = 0;
    *count = 0;
    if (tree->count)
        stack[height++] = 0;
    while (height) {
        const int32_t index = stack[--height];
        const qni_panel_node *node = &tree->nodes[index];
        if (!meets(node, &around))
            continue;
        const bool within = lies_within(node, box);
        if (node->second && !within) {
            stack[height++] = node->second;
            stack[height++] = index + 1;
            continue;
        }
        if (within && *count + node->count > most)
            return false;
        for (int32_t n = node->first; n < node->first + node->count; ++n) {
            if (!within && (!panel_meets(&tree->panels[n], box) || misses(&tree->panels[n], box)))
                continue;
            if (*count == most)
                return false;
            numbers[(*count)++] = n;
        }
    }
    return true;
}

static double square_to_node(const qni_panel_node *node, const double p[3]) {
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        double below = (double)node->low[k] - p[k], above = p[k] - (double)node->high[k];
        double away = below > 0 ? below : above > 0 ? above : 0;
        square += away * away;
    }
    return square;
}

typedef struct pending {
    int32_t node;
    double square;
} pending;

int32_t qni_panel_tree_nearest(const qni_panel_tree *tree, const double p[3], int32_t guess,
                               double *square, double nearest[3]) {
    pending stack[MOST_LEVELS];
    int32_t height = 0, best = -1;
    *square = QNI_INFINITY;
    if (guess >= 0 && guess < tree->count) {
        best = guess;
        *square = qni_panel_nearest(&tree->panels[guess], p, nearest);
    }
    if (tree->count)
        stack[height++] = (pending){0, square_to_node(&tree->nodes[0], p)};
    while (height) {
        pending here = stack[--height];
        const qni_panel_node *node = &tree->nodes[here.node];
        if (here.square > *square)
            continue;
        if (node->second) {
            pending left = {here.node + 1, square_to_node(node + 1, p)};
            pending right = {node->second, square_to_node(&tree->nodes[node->second], p)};
            bool swap = left.square > right.square;
            stack[height++] = swap ? left : right;
            stack[height++] = swap ? right : left;
            continue;
        }
        for (int32_t n = node->first; n < node->first + node->count; ++n) {
            double at[3], each = qni_panel_nearest(&tree->panels[n], p, at);
            bool tie = best >= 0 && !(each < *square) && !(each > *square) &&
                       tree->panels[n].number < tree->panels[best].number;
            if (each < *square || tie) {
                *square = each;
                best = n;
                memcpy(nearest, at, sizeof at);
            }
        }
    }
    return best;
}

static double far_angle(const qni_moment *moment, const double away[3], double distance,
                        double gradient[3]) {
    const double turn = 4 * 3.14159265358979323846;
    double cube = distance * distance * distance;
    double strength =
        moment->dipole[0] * away[0] + moment->dipole[1] * away[1] + moment->dipole[2] * away[2];
    for (int k = 0; gradient && k < 3; ++k)
        gradient[k] +=
            (3 * strength * away[k] / (distance * distance) - moment->dipole[k]) / cube / turn;
    return strength / cube / turn;
}

double qni_panel_tree_angle(const qni_panel_tree *tree, const double p[3], double gradient[3]) {
    int32_t stack[MOST_LEVELS], height = 0;
    double total = 0;
    if (tree->count)
        stack[height++] = 0;
    while (height) {
        int32_t index = stack[--height];
        const qni_panel_node *node = &tree->nodes[index];
        const qni_moment *moment = &tree->moments[index];
        double away[3], square = 0;
        for (int k = 0; k < 3; ++k) {
            away[k] = moment->centre[k] - p[k];
            square += away[k] * away[k];
        }
        if (square > far_away * far_away * moment->radius * moment->radius) {
            total += far_angle(moment, away, sqrt(square), gradient);
        } else if (node->second) {
            stack[height++] = node->second;
            stack[height++] = index + 1;
        } else {
            total += qni_panels_angle(tree->panels + node->first, NULL, node->count, p, gradient);
        }
    }
    return total;
}

static double distance_to_edge(const qni_panel *panel, const double p[3]) {
    double along[3], from[3], length = 0, foot = 0, square = 0;
    for (int k = 0; k < 3; ++k) {
        along[k] = (double)panel->at[0][k] - (double)panel->at[1][k];
        from[k] = p[k] - (double)panel->at[1][k];
        length += along[k] * along[k];
        foot += along[k] * from[k];
    }
    double t = length > 0 ? foot / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    for (int k = 0; k < 3; ++k)
        square += (from[k] - t * along[k]) * (from[k] - t * along[k]);
    return sqrt(square);
}

/* A thread of current of length L at distance d makes no more than L / (4 pi d^2). */
double qni_panel_tree_slope_bound(const qni_panel_tree *tree, const double p[3], double reach) {
    int32_t stack[MOST_LEVELS], height = 0;
    double total = 0;
    if (tree->count)
        stack[height++] = 0;
    while (height) {
        int32_t index = stack[--height];
        const qni_panel_node *node = &tree->nodes[index];
        const qni_moment *moment = &tree->moments[index];
        double square = 0;
        for (int k = 0; k < 3; ++k)
            square += (moment->centre[k] - p[k]) * (moment->centre[k] - p[k]);
        double least = sqrt(square) - moment->radius - reach;
        if (least > moment->radius) {
            total += moment->rim / (least * least);
        } else if (node->second) {
            stack[height++] = node->second;
            stack[height++] = index + 1;
        } else {
            for (int32_t n = node->first; n < node->first + node->count; ++n) {
                least = distance_to_edge(&tree->panels[n], p) - reach;
                if (!(least > 0))
                    return QNI_INFINITY;
                total += edge_length(&tree->panels[n]) / (least * least);
            }
        }
    }
    return total / (4 * 3.14159265358979323846);
}

static bool stop(void *user, int32_t panel) {
    (void)user;
    (void)panel;
    return false;
}

bool qni_panel_tree_is_near(const qni_panel_tree *tree, const double p[3], double reach) {
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        box.low[k] = p[k] - reach;
        box.high[k] = p[k] + reach;
    }
    return !qni_panel_tree_visit(tree, &box, stop, NULL);
}
