// SPDX-License-Identifier: MIT
/* Convex polytopes: intersections of half-spaces. Cubes, facetted spheres and cylinders, hulls. The
 * value is the largest of the distances to the planes, so edges and corners are sharp, and
 * crossings are exact: one division each. */
#include "solid/primitives.h"

#include <math.h>
#include <string.h>

typedef qni_plane plane;

/* Few planes are asked faster than a smaller solid is made. */
enum { FEW_PLANES = 8 };

typedef struct polytope {
    qn_solid base;
    plane *planes;
    int64_t count;
    /* Balls about one point that lie in the polytope and round it; a radius of 0 within: not known.
     */
    double centre[3], inner, outer;
} polytope;

static void destroy(qn_solid *solid) {
    polytope *p = (polytope *)solid;
    qni_free(solid->context, p->planes, p->count, sizeof *p->planes);
    qni_solid_free(solid, sizeof *p);
}

static inline double plane_value(const plane *s, double x, double y, double z) {
    double value = s->normal[0] * x + s->normal[1] * y + s->normal[2] * z - s->distance;
    return value == 0 ? s->tie : value;
}

static qn_status polytope_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 double *values) {
    const polytope *p = (const polytope *)solid;
    double x[QNI_SOLID_BLOCK], y[QNI_SOLID_BLOCK], z[QNI_SOLID_BLOCK];
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        double *most = values + first;
        for (int64_t i = 0; i < block; ++i) {
            x[i] = points[first + i][0];
            y[i] = points[first + i][1];
            z[i] = points[first + i][2];
            most[i] = -QNI_INFINITY;
        }
        for (int64_t n = 0; n < p->count; ++n)
            for (int64_t i = 0; i < block; ++i) {
                double value = plane_value(&p->planes[n], x[i], y[i], z[i]);
                most[i] = value > most[i] ? value : most[i];
            }
    }
    return QN_OK;
}

/* The first plane that a point is beyond is enough. */
static qn_status polytope_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 bool *inside) {
    const polytope *p = (const polytope *)solid;
    for (int64_t i = 0; i < count; ++i) {
        inside[i] = true;
        for (int64_t n = 0; n < p->count && inside[i]; ++n)
            inside[i] = plane_value(&p->planes[n], points[i][0], points[i][1], points[i][2]) < 0;
    }
    return QN_OK;
}

static qn_status polytope_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                    double (*gradients)[3], int32_t *owners) {
    const polytope *p = (const polytope *)solid;
    for (int64_t i = 0; i < count; ++i) {
        const plane *active = &p->planes[0];
        double most = -QNI_INFINITY;
        for (int64_t n = 0; gradients && n < p->count; ++n) {
            double value = plane_value(&p->planes[n], points[i][0], points[i][1], points[i][2]);
            if (value > most) {
                most = value;
                active = &p->planes[n];
            }
        }
        if (gradients)
            memcpy(gradients[i], active->normal, sizeof active->normal);
        if (owners)
            owners[i] = solid->owner;
    }
    return QN_OK;
}

/* A box as planes are held against it: normals are of unit length. */
typedef struct span {
    double middle[3], half[3], size;
} span;

static span span_of(const qni_box *box) {
    span out = {.size = 0};
    for (int k = 0; k < 3; ++k) {
        out.middle[k] = 0.5 * (box->low[k] + box->high[k]);
        out.half[k] = 0.5 * (box->high[k] - box->low[k]);
        out.size += fabs(out.middle[k]) + out.half[k];
    }
    return out;
}

/* Least and largest value of one plane in the box, with room for rounding. */
static inline void plane_range(const plane *s, const span *box, double range[2]) {
    const double *n = s->normal;
    const double value = n[0] * box->middle[0] + n[1] * box->middle[1] + n[2] * box->middle[2] -
                         s->distance,
                 reach = fabs(n[0]) * box->half[0] + fabs(n[1]) * box->half[1] +
                         fabs(n[2]) * box->half[2] +
                         8 * QNI_EPSILON * (box->size + fabs(s->distance)) + QNI_TIE;
    range[0] = value - reach;
    range[1] = value + reach;
}

static void exact_bounds(const polytope *p, const qni_box *box, double range[2]) {
    const span held = span_of(box);
    range[0] = range[1] = -QNI_INFINITY;
    if (!qni_box_is_finite(box))
        range[1] = QNI_INFINITY;
    for (int64_t n = 0; n < p->count && range[1] < QNI_INFINITY; ++n) {
        double each[2];
        plane_range(&p->planes[n], &held, each);
        range[0] = qni_max(range[0], each[0]);
        range[1] = qni_max(range[1], each[1]);
    }
}

/* Bounds far away without a look at the planes, for trees of many parts. f is convex, -inner at the
 * centre c at most and 0 within `outer` of it, so it grows by inner / outer at least; and by 1 at
 * most, as the normals are of unit length. */
static bool far_bounds(const polytope *p, const qni_box *box, double range[2]) {
    double nearest = 0, farthest = 0;
    if (!(p->inner > 0))
        return false;
    for (int k = 0; k < 3; ++k) {
        double low = box->low[k] - p->centre[k], high = box->high[k] - p->centre[k];
        double least = low > 0 ? low : high < 0 ? -high : 0, most = qni_max(fabs(low), fabs(high));
        nearest += least * least;
        farthest += most * most;
    }
    if (!(nearest > 4 * p->outer * p->outer))
        return false;
    double slack =
        1e-12 * (fabs(p->centre[0]) + fabs(p->centre[1]) + fabs(p->centre[2]) + sqrt(farthest));
    range[0] = p->inner * (sqrt(nearest) / p->outer - 1) * (1 - 1e-12) - slack;
    range[1] = sqrt(farthest) + slack;
    return true;
}

static qn_status polytope_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const polytope *p = (const polytope *)solid;
    if (!far_bounds(p, box, range))
        exact_bounds(p, box, range);
    return QN_OK;
}

static bool polytope_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const polytope *p = (const polytope *)solid;
    (void)box;
    for (int k = 0; k < 3; ++k) {
        ranges[k][0] = QNI_INFINITY;
        ranges[k][1] = -QNI_INFINITY;
        for (int64_t n = 0; n < p->count; ++n) {
            ranges[k][0] = qni_min(ranges[k][0], p->planes[n].normal[k]);
            ranges[k][1] = qni_max(ranges[k][1], p->planes[n].normal[k]);
        }
    }
    return p->count > 0;
}

static void describe(const plane *s, double at, bool enters, int32_t owner,
                     qni_crossing *crossing) {
    *crossing = (qni_crossing){.at = at, .owner = owner, .enters = enters};
    memcpy(crossing->normal, s->normal, sizeof s->normal);
}

/* The segment is clipped by the planes: it enters through the last plane it comes in by and leaves
 * by the first one. */
static qn_status polytope_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                    int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const polytope *p = (const polytope *)solid;
    const plane *way_in = NULL, *way_out = NULL;
    double enter = -1, leave = 2;
    *count_out = 0;
    for (int64_t n = 0; n < p->count; ++n) {
        double at_a = plane_value(&p->planes[n], a[0], a[1], a[2]);
        double at_b = plane_value(&p->planes[n], b[0], b[1], b[2]);
        if (at_a > 0 && at_b > 0)
            return QN_OK;
        if (at_a < 0 && at_b < 0)
            continue;
        double at = at_a / (at_a - at_b);
        if (at_a > 0 && at > enter) {
            enter = at;
            way_in = &p->planes[n];
        } else if (at_a < 0 && at < leave) {
            leave = at;
            way_out = &p->planes[n];
        }
    }
    /* Past an edge or a corner: no way in before the way out. */
    if (way_in && way_out && (enter >= leave || capacity < 2))
        return QN_OK;
    int32_t count = 0;
    if (way_in && count < capacity)
        describe(way_in, enter, true, solid->owner, &crossings[count++]);
    if (way_out && count < capacity)
        describe(way_out, leave, false, solid->owner, &crossings[count++]);
    *count_out = count;
    return QN_OK;
}

static qn_solid *create(qn_context *context, int64_t count, const qni_box *box, int32_t owner,
                        polytope **out);

/* The largest values of all planes in the box, and how many planes can be the active one there: a
 * plane that is below another one all over the box is not. */
static int64_t mark_active(const polytope *p, const qni_box *box, double *highs, double *least) {
    const span held = span_of(box);
    int64_t kept = 0;
    *least = -QNI_INFINITY;
    for (int64_t n = 0; n < p->count; ++n) {
        double each[2];
        plane_range(&p->planes[n], &held, each);
        *least = qni_max(*least, each[0]);
        highs[n] = each[1];
    }
    for (int64_t n = 0; n < p->count; ++n)
        kept += highs[n] >= *least;
    return kept;
}

static qn_status keep_active(const polytope *p, int64_t kept, const double *highs, double least,
                             qn_solid **solid_out) {
    polytope *smaller;
    *solid_out = create(p->base.context, kept, &p->base.box, p->base.owner, &smaller);
    if (!*solid_out)
        return QN_ERROR_OUT_OF_MEMORY;
    memcpy(smaller->centre, p->centre,
           sizeof p->centre); /* they hold for f, which is the same in the box */
    smaller->inner = p->inner;
    smaller->outer = p->outer;
    kept = 0;
    for (int64_t n = 0; n < p->count; ++n)
        if (highs[n] >= least)
            smaller->planes[kept++] = p->planes[n];
    return QN_OK;
}

/* One that is far away is left as it is: most often it is dropped next. */
static qn_status polytope_restrict(const qn_solid *solid, const qni_box *box,
                                   qn_solid **solid_out) {
    const polytope *p = (const polytope *)solid;
    double range[2], least;
    if (p->count <= FEW_PLANES || !qni_box_is_finite(box) || far_bounds(p, box, range))
        return qni_restrict_to_itself(solid, box, solid_out);
    double *highs = qni_alloc(solid->context, p->count, sizeof *highs);
    *solid_out = NULL;
    if (!highs)
        return QN_ERROR_OUT_OF_MEMORY;
    const int64_t kept = mark_active(p, box, highs, &least);
    const qn_status status = kept == p->count ? qni_restrict_to_itself(solid, box, solid_out)
                                              : keep_active(p, kept, highs, least, solid_out);
    qni_free(solid->context, highs, p->count, sizeof *highs);
    return status;
}

static const qni_solid_ops polytope_ops = {
    .destroy = destroy,
    .values = polytope_values,
    .gradients = polytope_gradients,
    .bounds = polytope_bounds,
    .crossings = polytope_crossings,
    .restrict_to = polytope_restrict,
    .slopes = polytope_slopes,
    .inside = polytope_inside,
};

static qn_solid *create(qn_context *context, int64_t count, const qni_box *box, int32_t owner,
                        polytope **out) {
    polytope *p = (polytope *)qni_solid_new(context, sizeof *p, &polytope_ops);
    if (!p)
        return NULL;
    p->count = count;
    p->planes = qni_alloc(context, count, sizeof *p->planes);
    p->base.box = *box;
    p->base.owner = owner;
    p->base.narrows = count > FEW_PLANES;
    if (!p->planes) {
        qni_solid_free(&p->base, sizeof *p);
        return NULL;
    }
    *out = p;
    return &p->base;
}

static void find_balls(polytope *p) {
    double squares = 0, value;
    if (!qni_box_is_finite(&p->base.box))
        return;
    for (int k = 0; k < 3; ++k) {
        double half = 0.5 * (p->base.box.high[k] - p->base.box.low[k]);
        p->centre[k] = p->base.box.low[k] + half;
        squares += half * half;
    }
    polytope_values(&p->base, 1, (const double(*)[3]) & p->centre, &value);
    p->outer = sqrt(squares) * (1 + 1e-12);
    p->inner = value < -1e-6 * p->outer ? -value : 0;
}

/* The side of a point on the plane, moved by (e, e^2, e^3). */
static double tie_of(const double normal[3]) {
    for (int k = 0; k < 3; ++k)
        if (normal[k] != 0)
            return normal[k] < 0 ? -QNI_TIE : QNI_TIE;
    return QNI_TIE;
}

qn_solid *qni_polytope_create(qn_context *context, int64_t count, const double (*planes)[4],
                              const qni_box *box, int32_t owner) {
    polytope *p;
    qn_solid *solid = create(context, count, box, owner, &p);
    if (!solid)
        return NULL;
    for (int64_t n = 0; n < count; ++n) {
        const double *in = planes[n];
        plane *out = &p->planes[n];
        double length = sqrt(in[0] * in[0] + in[1] * in[1] + in[2] * in[2]);
        for (int k = 0; k < 3; ++k)
            out->normal[k] = in[k] / length;
        out->distance = in[3] / length;
        out->tie = tie_of(out->normal);
    }
    find_balls(p);
    return solid;
}

const qni_plane *qni_polytope_planes(const qn_solid *solid, int64_t *count_out) {
    if (solid->ops != &polytope_ops)
        return NULL;
    *count_out = ((const polytope *)solid)->count;
    return ((const polytope *)solid)->planes;
}

qn_solid *qni_polytope_transformed(qn_context *context, const qn_solid *part,
                                   const double inverse[3][4], const double forward[3][4],
                                   bool *done_out) {
    const polytope *p = (const polytope *)part;
    *done_out = part->ops == &polytope_ops;
    if (!*done_out)
        return NULL;
    double(*planes)[4] = qni_alloc(context, p->count, sizeof *planes);
    if (!planes)
        return NULL;
    for (int64_t n = 0; n < p->count; ++n) {
        /* n . (M p + m) < d: the normal is multiplied from the left, m goes to the other side. */
        const double *normal = p->planes[n].normal;
        for (int k = 0; k < 4; ++k)
            planes[n][k] =
                normal[0] * inverse[0][k] + normal[1] * inverse[1][k] + normal[2] * inverse[2][k];
        planes[n][3] = p->planes[n].distance - planes[n][3];
    }
    qni_box box = qni_box_image(forward, &part->box);
    qn_solid *solid =
        qni_polytope_create(context, p->count, (const double(*)[4])planes, &box, part->owner);
    qni_free(context, planes, p->count, sizeof *planes);
    return solid;
}
