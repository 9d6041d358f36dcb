// SPDX-License-Identifier: MIT
/* Crossings from values and bounds alone: pieces between whose ends the sign changes, then a
 * bracketing root finder (Chandrupatla 1997: inverse quadratic steps where they are safe, else
 * halving). */
#include "solid/node.h"

#include <math.h>
#include <string.h>

enum { PIECES = 32, MOST_STEPS = 120 };
static const double tolerance = 1e-14;

typedef struct walk {
    const qn_solid *solid;
    const double *a, *b;
} walk;

static void place(const walk *way, double t, double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = t <= 0   ? way->a[k]
                   : t >= 1 ? way->b[k]
                            : way->a[k] + t * (way->b[k] - way->a[k]);
}

static qn_status value_at(const walk *way, double t, double *value_out) {
    double point[1][3];
    place(way, t, point[0]);
    return way->solid->ops->values(way->solid, 1, (const double(*)[3])point, value_out);
}

/* Signs only matter; NaN and infinities would spoil the steps. */
static double tame(double value) {
    if (!(value < 1e300))
        return 1e300;
    return value < -1e300 ? -1e300 : value;
}

/* Chandrupatla's method between t0 and t1, where the signs differ. */
static qn_status bracket(const walk *way, double t0, double v0, double t1, double v1,
                         double *root_out) {
    double a = t1, fa = tame(v1), b = t0, fb = tame(v0), c = t0, fc = fb, step = 0.5;
    for (int i = 0; i < MOST_STEPS; ++i) {
        double t = a + step * (b - a), value;
        QN_TRY(value_at(way, t, &value));
        value = tame(value);
        if ((value < 0) == (fa < 0)) {
            c = a, fc = fa;
        } else {
            c = b, fc = fb;
            b = a, fb = fa;
        }
        a = t, fa = value;
        double width = fabs(b - a);
        if (fa == 0 || width <= tolerance)
            break;
        double least = 0.5 * tolerance / width;
        double xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
        step = 0.5;
        if (phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)
            step = fa / (fb - fa) * fc / (fb - fc) +
                   (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb);
        step = step < least ? least : step > 1 - least ? 1 - least : step == step ? step : 0.5;
    }
    *root_out = fabs(fa) < fabs(fb) ? a : b;
    return QN_OK;
}

/* The one change of sign: first to its piece by halving, so that a solid and its restriction to a
 * box, whose bounds may be narrower, walk the same way and find the same bits. */
static qn_status single(const walk *way, const double ends[2], double *root_out) {
    int low = 0, high = PIECES;
    double v0 = ends[0], v1 = ends[1];
    while (high - low > 1) {
        int middle = (low + high) / 2;
        double value;
        QN_TRY(value_at(way, (double)middle / PIECES, &value));
        bool left = (value < 0) != (v0 < 0);
        *(left ? &high : &low) = middle;
        *(left ? &v1 : &v0) = value;
    }
    return bracket(way, (double)low / PIECES, v0, (double)high / PIECES, v1, root_out);
}

static bool points_back(const double gradient[3], const double along[3]) {
    return gradient[0] * along[0] + gradient[1] * along[1] + gradient[2] * along[2] < 0;
}

/* Where faces lie in each other, the branch that is taken at a tie may be active on neither side:
 * the one that is active a little way off tells which way is out. */
static qn_status ask_beside(const walk *way, double t, const double along[3], bool enters,
                            double gradient[3], int32_t *owner) {
    static const double steps[4] = {1e-9, -1e-9, 1e-6, -1e-6};
    for (int n = 0; n < 4; ++n) {
        double point[1][3], other[1][3];
        int32_t other_owner;
        place(way, t + (enters ? -steps[n] : steps[n]), point[0]);
        QN_TRY(way->solid->ops->gradients(way->solid, 1, (const double(*)[3])point, other,
                                          &other_owner));
        if (points_back(other[0], along))
            continue;
        memcpy(gradient, other[0], sizeof other[0]);
        *owner = other_owner;
        break;
    }
    return QN_OK;
}

static qn_status describe(const walk *way, double t, bool enters, qni_crossing *crossing) {
    double point[1][3], gradient[1][3], along[3], back[3] = {1, 0, 0};
    for (int k = 0; k < 3; ++k)
        along[k] = enters ? way->a[k] - way->b[k] : way->b[k] - way->a[k];
    qni_unit(along, back, back);
    place(way, t, point[0]);
    QN_TRY(way->solid->ops->gradients(way->solid, 1, (const double(*)[3])point, gradient,
                                      &crossing->owner));
    if (points_back(gradient[0], along))
        QN_TRY(ask_beside(way, t, along, enters, gradient[0], &crossing->owner));
    qni_unit(gradient[0], back, crossing->normal); /* no gradient: straight out along the segment */
    crossing->at = t;
    crossing->enters = enters;
    return QN_OK;
}

/* Whether one sign at each end says everything: nothing is known between them, or f rises or falls
 * throughout. */
static qn_status ends_say_all(const walk *way, bool *result_out) {
    double range[2];
    qni_box box = qni_segment_box(way->a, way->b);
    QN_TRY(way->solid->ops->bounds(way->solid, &box, range));
    *result_out = range[0] > 0 || range[1] < 0 || (isinf(range[0]) && isinf(range[1]));
    if (!*result_out && way->solid->ops->slope &&
        way->solid->ops->slope(way->solid, way->a, way->b, range))
        *result_out = range[0] > 0 || range[1] < 0;
    return QN_OK;
}

qn_status qni_find_single(const qn_solid *solid, const double a[3], const double b[3],
                          const double values[2], qni_crossing *crossing) {
    walk way = {.solid = solid, .a = a, .b = b};
    double root;
    QN_TRY(single(&way, values, &root));
    return describe(&way, root, values[1] < 0, crossing);
}

/* All changes of sign between pieces. One batch of values costs less than the bounds that would say
 * which pieces need none, and where these rule the surface out signs do not change. */
static qn_status several(const walk *way, const double ends[2], int32_t capacity,
                         qni_crossing *crossings, int32_t *count_out) {
    double points[PIECES - 1][3], values[PIECES + 1], roots[PIECES];
    for (int i = 1; i < PIECES; ++i)
        place(way, (double)i / PIECES, points[i - 1]);
    QN_TRY(way->solid->ops->values(way->solid, PIECES - 1, (const double(*)[3])points, values + 1));
    values[0] = ends[0];
    values[PIECES] = ends[1];
    int32_t found = 0;
    for (int i = 0; i < PIECES; ++i)
        if ((values[i] < 0) != (values[i + 1] < 0))
            QN_TRY(bracket(way, (double)i / PIECES, values[i], (double)(i + 1) / PIECES,
                           values[i + 1], &roots[found++]));
    /* What has no room goes in pairs, so that the signs at the ends stay true. */
    int32_t kept = found;
    while (kept > capacity)
        kept -= 2;
    for (int32_t i = 0; i < kept; ++i)
        QN_TRY(describe(way, roots[i], (ends[0] < 0) == (i % 2 != 0), &crossings[i]));
    *count_out = kept > 0 ? kept : 0;
    return QN_OK;
}

static qn_status find_between(walk *way, int32_t capacity, qni_crossing *crossings,
                              int32_t *count_out) {
    bool simple;
    QN_TRY(ends_say_all(way, &simple));
    double ends[2][3], values[2];
    for (int k = 0; k < 3; ++k)
        ends[0][k] = way->a[k], ends[1][k] = way->b[k];
    QN_TRY(way->solid->ops->values(way->solid, 2, (const double(*)[3])ends, values));
    if (!simple)
        return several(way, values, capacity, crossings, count_out);
    if ((values[0] < 0) == (values[1] < 0) || capacity < 1)
        return QN_OK;
    QN_TRY(qni_find_single(way->solid, way->a, way->b, values, &crossings[0]));
    *count_out = 1;
    return QN_OK;
}

qn_status qni_find_crossings(const qn_solid *solid, const double a[3], const double b[3],
                             int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    qn_solid *near; /* many questions follow: what is of no concern here is dropped first */
    const qni_box box = qni_segment_box(a, b);
    *count_out = 0;
    QN_TRY(solid->ops->restrict_to(solid, &box, &near));
    walk way = {.solid = near, .a = a, .b = b};
    const qn_status status = find_between(&way, capacity, crossings, count_out);
    qn_solid_destroy(near);
    return status;
}
