// SPDX-License-Identifier: MIT
/* After Greengard, Rokhlin, "A fast algorithm for particle simulations", 1987: a child takes over
 * its parent's polynomial and adds those panels that have become far. Values at Chebyshev points
 * stand for the polynomial. Panels are far when their edges, where alone the angle is not analytic,
 * keep 3 half sides from the cell's middle: degree 4 is then right to about 1e-4 a panel. */
#include "solid/cap_field.h"

#include <string.h>

enum { POINTS = 5, POINTS_IN_CELL = POINTS * POINTS * POINTS, FEW = 12, MOST_LEVELS = 12 };
static const double far_away = 3; /* in half sides */

static const double chebyshev[POINTS] = {-0.95105651629515357, -0.58778525229247313, 0,
                                         0.58778525229247313, 0.95105651629515357};

struct qni_cap_cell {
    qni_cap_cell *children[8]; /* set once, by atomic exchange */
    double middle[3], half;
    double distant[POINTS_IN_CELL]; /* of far panels, at the Chebyshev points, x fastest */
    int32_t level;
    int32_t near_count;
    int32_t near[]; /* panels */
};

static size_t size_of_cell(int32_t near_count) {
    return sizeof(qni_cap_cell) + (size_t)near_count * sizeof(int32_t);
}

/* 1 over the product of what the others are away. */
static const double scales[POINTS] = {0.988854381999832, -2.5888543819998322, 3.2000000000000002,
                                      -2.5888543819998322, 0.988854381999832};

/* Lagrange's polynomials at t, from the products of what lies before and behind. */
static void weights_at(double t, double weights[POINTS]) {
    double away[POINTS], behind = 1;
    for (int i = 0; i < POINTS; ++i) {
        away[i] = t - chebyshev[i];
        weights[i] = behind * scales[i];
        behind *= away[i];
    }
    double before = 1;
    for (int i = POINTS - 1; i >= 0; --i) {
        weights[i] *= before;
        before *= away[i];
    }
}

/* Their derivatives: one factor left out after the other. */
static void slopes_at(double t, double slopes[POINTS]) {
    for (int i = 0; i < POINTS; ++i) {
        double product = scales[i], slope = 0;
        for (int j = 0; j < POINTS; ++j) {
            if (j == i)
                continue;
            slope = slope * (t - chebyshev[j]) + product;
            product *= t - chebyshev[j];
        }
        slopes[i] = slope;
    }
}

static void add_slope(const qni_cap_cell *cell, const double at[3], const double w[3][POINTS],
                      double gradient[3]) {
    double s[3][POINTS], slope[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k)
        slopes_at(at[k], s[k]);
    const double *value = cell->distant;
    for (int z = 0; z < POINTS; ++z)
        for (int y = 0; y < POINTS; ++y, value += POINTS) {
            double row = 0, row_slope = 0;
            for (int x = 0; x < POINTS; ++x) {
                row += w[0][x] * value[x];
                row_slope += s[0][x] * value[x];
            }
            slope[0] += w[2][z] * w[1][y] * row_slope;
            slope[1] += w[2][z] * s[1][y] * row;
            slope[2] += s[2][z] * w[1][y] * row;
        }
    for (int k = 0; k < 3; ++k)
        gradient[k] += slope[k] / cell->half;
}

static double distant_angle(const qni_cap_cell *cell, const double p[3], double gradient[3]) {
    double at[3], w[3][POINTS], total = 0;
    for (int k = 0; k < 3; ++k) {
        at[k] = (p[k] - cell->middle[k]) / cell->half;
        weights_at(at[k], w[k]);
    }
    const double *value = cell->distant;
    for (int z = 0; z < POINTS; ++z)
        for (int y = 0; y < POINTS; ++y, value += POINTS) {
            double row = 0;
            for (int x = 0; x < POINTS; ++x)
                row += w[0][x] * value[x];
            total += w[2][z] * w[1][y] * row;
        }
    if (gradient)
        add_slope(cell, at, (const double(*)[POINTS])w, gradient);
    return total;
}

static void point_of(const qni_cap_cell *cell, int n, double point[3]) {
    const int at[3] = {n % POINTS, n / POINTS % POINTS, n / (POINTS * POINTS)};
    for (int k = 0; k < 3; ++k)
        point[k] = cell->middle[k] + cell->half * chebyshev[at[k]];
}

static bool is_far(const qni_cap_field *field, const qni_cap_cell *cell, int32_t panel) {
    double nearest[3], reach = far_away * cell->half;
    return qni_panel_nearest(&field->caps->panels[panel], cell->middle, nearest) > reach * reach;
}

static void add_distant(const qni_cap_field *field, qni_cap_cell *cell, int32_t panel) {
    for (int n = 0; n < POINTS_IN_CELL; ++n) {
        double point[3];
        point_of(cell, n, point);
        cell->distant[n] += qni_panel_angle(&field->caps->panels[panel], point, NULL);
    }
}

/* Of the panels near the parent (all, without one), which are near; the others go into the
 * polynomial. */
static qni_cap_cell *make_cell(const qni_cap_field *field, const double middle[3], double half,
                               const qni_cap_cell *parent) {
    int32_t count = parent ? parent->near_count : field->caps->count, near_count = 0;
    qni_cap_cell measure = {.half = half};
    memcpy(measure.middle, middle, sizeof measure.middle);
    for (int32_t n = 0; n < count; ++n)
        near_count += !is_far(field, &measure, parent ? parent->near[n] : n);
    qni_cap_cell *cell = qni_alloc_zero(field->context, 1, (int64_t)size_of_cell(near_count));
    if (!cell)
        return NULL;
    memcpy(cell->middle, middle, sizeof cell->middle);
    cell->half = half;
    cell->level = parent ? parent->level + 1 : 0;
    for (int n = 0; n < POINTS_IN_CELL && parent; ++n) {
        double point[3];
        point_of(cell, n, point);
        cell->distant[n] = distant_angle(parent, point, NULL);
    }
    for (int32_t n = 0; n < count; ++n) {
        int32_t panel = parent ? parent->near[n] : n;
        if (is_far(field, cell, panel))
            add_distant(field, cell, panel);
        else
            cell->near[cell->near_count++] = panel;
    }
    return cell;
}

static void free_cell(qn_context *context, qni_cap_cell *cell) {
    if (!cell)
        return;
    for (int n = 0; n < 8; ++n)
        free_cell(context, cell->children[n]);
    qni_free(context, cell, 1, (int64_t)size_of_cell(cell->near_count));
}

bool qni_cap_field_start(qn_context *context, const qni_panel_tree *caps, const qni_box *box,
                         qni_cap_field *field) {
    *field = (qni_cap_field){.context = context, .caps = caps};
    if (caps->count == 0)
        return true;
    double middle[3], half = 0;
    for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (box->low[k] + box->high[k]);
        half = fmax(half, 0.625 * (box->high[k] - box->low[k]));
    }
    bool room = true;
    for (int n = 0; n < QNI_CAP_ROOTS && room; ++n, half *= 4) {
        field->roots[n] = make_cell(field, middle, half, NULL);
        room = field->roots[n] != NULL;
    }
    return room;
}

void qni_cap_field_free(qni_cap_field *field) {
    for (int n = 0; n < QNI_CAP_ROOTS; ++n) {
        if (field->roots[n])
            free_cell(field->context, field->roots[n]);
        field->roots[n] = NULL;
    }
}

/* Whoever is first sets it; all would set the same. */
static qni_cap_cell *child_of(qni_cap_field *field, qni_cap_cell *cell, int child) {
    qni_cap_cell *there = __atomic_load_n(&cell->children[child], __ATOMIC_ACQUIRE);
    if (there)
        return there;
    double middle[3], half = 0.5 * cell->half;
    for (int k = 0; k < 3; ++k)
        middle[k] = cell->middle[k] + (child >> k & 1 ? half : -half);
    qni_cap_cell *made = make_cell(field, middle, half, cell);
    if (!made) {
        __atomic_store_n(&field->failed, 1, __ATOMIC_RELAXED);
        return NULL;
    }
    if (__atomic_compare_exchange_n(&cell->children[child], &there, made, false, __ATOMIC_ACQ_REL,
                                    __ATOMIC_ACQUIRE))
        return made;
    free_cell(field->context, made);
    return there;
}

static bool holds(const qni_cap_cell *cell, const double p[3]) {
    for (int k = 0; k < 3; ++k)
        if (!(fabs(p[k] - cell->middle[k]) <= cell->half))
            return false;
    return true;
}

double qni_cap_field_angle(qni_cap_field *field, const double p[3], double gradient[3]) {
    qni_cap_cell *cell = NULL;
    for (int n = 0; n < QNI_CAP_ROOTS && !cell; ++n)
        if (field->roots[n] && holds(field->roots[n], p))
            cell = field->roots[n];
    if (!cell)
        return qni_panel_tree_angle(field->caps, p, gradient);
    while (cell && cell->near_count > FEW && cell->level < MOST_LEVELS)
        cell = child_of(field, cell,
                        (p[0] >= cell->middle[0]) | (p[1] >= cell->middle[1]) << 1 |
                            (p[2] >= cell->middle[2]) << 2);
    return cell ? distant_angle(cell, p, gradient) + qni_panels_angle(field->caps->panels,
                                                                      cell->near, cell->near_count,
                                                                      p, gradient)
                : 0;
}
