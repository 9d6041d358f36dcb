// SPDX-License-Identifier: MIT
/* Prisms without ends over any polygon in x and y: several contours, inside by the even-odd rule.
 * The value is the distance to the nearest edge. A box keeps the edges that can be nearest in it,
 * and of the others, for the even-odd rule, those that a ray from the box can meet; edges that
 * every such ray meets are counted once for all. */
#include "solid/polynomial.h"
#include "solid/primitives.h"

#include <string.h>

/* From the lower end to the upper one, so that both polygons at a shared edge compute the same
 * bits. */
typedef struct edge {
    double x0, y0, x1, y1;
} edge;

typedef struct polygon {
    qn_solid base;
    edge *edges; /* `near` edges for distances, then `across` edges for the even-odd rule */
    int64_t near, across;
    bool odd; /* rays begin with this many crossings, modulo 2 */
} polygon;

static int64_t room(const polygon *p) {
    return p->near + p->across;
}

static void destroy(qn_solid *solid) {
    polygon *p = (polygon *)solid;
    qni_free(solid->context, p->edges, room(p), sizeof *p->edges);
    qni_solid_free(solid, sizeof *p);
}

/* The squared distance to an edge, and the offset from its nearest point. */
static inline double square_to(const edge *e, double x, double y, double offset[2]) {
    double dx = e->x1 - e->x0, dy = e->y1 - e->y0, px = x - e->x0, py = y - e->y0;
    double t = (px * dx + py * dy) / (dx * dx + dy * dy);
    t = t > 0 ? t < 1 ? t : 1 : 0;
    offset[0] = px - t * dx;
    offset[1] = py - t * dy;
    return offset[0] * offset[0] + offset[1] * offset[1];
}

/* Whether the ray from (x, y) along +x meets the edge: a point on an edge counts as moved a little
 * along +x, then +y. */
static inline bool meets(const edge *e, double x, double y) {
    return (e->y0 > y) != (e->y1 > y) &&
           x < e->x0 + (y - e->y0) * (e->x1 - e->x0) / (e->y1 - e->y0);
}

static double value_at(const polygon *p, double x, double y) {
    double least = QNI_INFINITY, offset[2];
    bool inside = p->odd;
    for (int64_t n = 0; n < p->near; ++n) {
        double square = square_to(&p->edges[n], x, y, offset);
        least = square < least ? square : least;
    }
    for (int64_t n = p->near; n < room(p); ++n)
        inside ^= meets(&p->edges[n], x, y);
    double distance = sqrt(least);
    distance = distance > 0 ? distance : QNI_TIE;
    return inside ? -distance : distance;
}

static qn_status polygon_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                double *values) {
    for (int64_t n = 0; n < count; ++n)
        values[n] = value_at((const polygon *)solid, points[n][0], points[n][1]);
    return QN_OK;
}

static const edge *nearest(const polygon *p, double x, double y, double offset[2]) {
    const edge *best = &p->edges[0];
    double least = QNI_INFINITY, each[2];
    for (int64_t n = 0; n < p->near; ++n) {
        double square = square_to(&p->edges[n], x, y, each);
        if (square < least) {
            least = square;
            best = &p->edges[n];
            memcpy(offset, each, sizeof each);
        }
    }
    return best;
}

/* Away from the nearest point; on the edge itself across it, to the side that is outside. */
static void gradient_at(const polygon *p, double x, double y, double gradient[3]) {
    double offset[2] = {0, 0}, across[3], fallback[3] = {1, 0, 0};
    const edge *e = nearest(p, x, y, offset);
    double sign = value_at(p, x, y) < 0 ? -1 : 1;
    across[0] = e->y1 - e->y0;
    across[1] = e->x0 - e->x1;
    across[2] = 0;
    qni_unit(across, fallback, fallback);
    double step = 1e-9 * (fabs(x) + fabs(y) + fabs(across[0]) + fabs(across[1]));
    if (value_at(p, x + step * fallback[0], y + step * fallback[1]) < 0) {
        fallback[0] = -fallback[0];
        fallback[1] = -fallback[1];
    }
    double away[3] = {sign * offset[0], sign * offset[1], 0};
    bool on_edge = fabs(offset[0]) + fabs(offset[1]) <= step * 1e-3;
    qni_unit(on_edge ? fallback : away, fallback, gradient);
}

static qn_status polygon_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                   double (*gradients)[3], int32_t *owners) {
    for (int64_t n = 0; gradients && n < count; ++n)
        gradient_at((const polygon *)solid, points[n][0], points[n][1], gradients[n]);
    for (int64_t n = 0; owners && n < count; ++n)
        owners[n] = solid->owner;
    return QN_OK;
}

/* The value in the middle of the box, and how far it can change: distances change by as much as one
 * moves. */
static double middle_of(const polygon *p, const qni_box *box, double centre[2], double *reach_out) {
    double half[2];
    for (int k = 0; k < 2; ++k) {
        centre[k] = 0.5 * (box->low[k] + box->high[k]);
        half[k] = fmax(box->high[k] - centre[k], centre[k] - box->low[k]);
    }
    double value = value_at(p, centre[0], centre[1]),
           reach = sqrt(half[0] * half[0] + half[1] * half[1]);
    double size = fabs(value) + reach + fabs(centre[0]) + fabs(centre[1]);
    *reach_out = reach + 32 * QNI_EPSILON * size + QNI_TIE;
    return value;
}

static qn_status polygon_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    double centre[2], reach, value = middle_of((const polygon *)solid, box, centre, &reach);
    range[0] = value - reach;
    range[1] = value + reach;
    return QN_OK;
}

/* Sorted places on the segment where its line passes an edge; 0 for a segment along z. */
static int places_of(const polygon *p, const double a[3], const double b[3], double *places) {
    double dx = b[0] - a[0], dy = b[1] - a[1];
    int count = 0;
    for (int64_t n = 0; n < p->near; ++n) {
        const edge *e = &p->edges[n];
        /* An end on the line belongs to one side: edges that meet there are passed together or not
         * at all. */
        bool left0 = dx * (e->y0 - a[1]) - dy * (e->x0 - a[0]) >= 0;
        bool left1 = dx * (e->y1 - a[1]) - dy * (e->x1 - a[0]) >= 0;
        double ex = e->x1 - e->x0, ey = e->y1 - e->y0, slant = dx * ey - dy * ex;
        if (left0 == left1 || slant == 0)
            continue;
        double t = ((e->x0 - a[0]) * ey - (e->y0 - a[1]) * ex) / slant;
        if (!(t > -1e-3 && t < 1.001) || count == QNI_CROSSINGS)
            continue;
        int at = count++;
        for (; at > 0 && places[at - 1] > t; --at)
            places[at] = places[at - 1];
        places[at] = t;
    }
    return count;
}

static qn_status polygon_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                   int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const polygon *p = (const polygon *)solid;
    double places[QNI_CROSSINGS + 1];
    bool inside = value_at(p, a[0], a[1]) < 0;
    int count = places_of(p, a, b, places);
    count = qni_match_ends(places, count, inside, value_at(p, b[0], b[1]) < 0);
    while (count > capacity)
        count -= 2;
    for (int i = 0; i < count; ++i, inside = !inside) {
        double dx = b[0] - a[0], dy = b[1] - a[1], offset[2], back[3] = {1, 0, 0};
        const edge *e = nearest(p, a[0] + places[i] * dx, a[1] + places[i] * dy, offset);
        double across[3] = {e->y1 - e->y0, e->x0 - e->x1, 0};
        bool along = across[0] * dx + across[1] * dy > 0;
        if (along != inside) { /* out of the solid: along the segment where it leaves */
            across[0] = -across[0];
            across[1] = -across[1];
        }
        crossings[i] = (qni_crossing){.at = places[i], .owner = solid->owner, .enters = !inside};
        qni_unit(across, back, crossings[i].normal);
    }
    *count_out = count > 0 ? count : 0;
    return QN_OK;
}

typedef enum ray_use { NEVER, SOMETIMES, ALWAYS } ray_use;

/* Whether rays from the box along +x meet the edge. */
static ray_use use_of(const edge *e, const qni_box *box) {
    if (e->y1 <= box->low[1] || e->y0 > box->high[1] || fmax(e->x0, e->x1) <= box->low[0])
        return NEVER;
    bool spans = e->y0 <= box->low[1] && e->y1 > box->high[1];
    double margin = 1e-9 * (fabs(e->x0) + fabs(e->x1) + fabs(box->high[0]));
    return spans && fmin(e->x0, e->x1) > box->high[0] + margin ? ALWAYS : SOMETIMES;
}

static polygon *create(qn_context *context, int64_t near, int64_t across);

static qn_status polygon_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const polygon *p = (const polygon *)solid;
    double centre[2], reach, value = middle_of(p, box, centre, &reach), offset[2];
    /* An edge that is nearest somewhere in the box is at most this far from its middle. */
    double most = (fabs(value) + 2 * reach) * (1 + 1e-12);
    int64_t near = 0, across = 0;
    for (int64_t n = 0; n < p->near; ++n)
        near += square_to(&p->edges[n], centre[0], centre[1], offset) <= most * most;
    for (int64_t n = p->near; n < room(p); ++n)
        across += use_of(&p->edges[n], box) == SOMETIMES;
    *solid_out = NULL;
    if (near == p->near && across == p->across)
        return qni_restrict_to_itself(solid, box, solid_out);
    polygon *smaller = create(solid->context, near, across);
    if (!smaller)
        return QN_ERROR_OUT_OF_MEMORY;
    smaller->base.box = solid->box;
    smaller->base.owner = solid->owner;
    smaller->odd = p->odd;
    int64_t used = 0;
    for (int64_t n = 0; n < p->near; ++n)
        if (square_to(&p->edges[n], centre[0], centre[1], offset) <= most * most)
            smaller->edges[used++] = p->edges[n];
    for (int64_t n = p->near; n < room(p); ++n) {
        ray_use use = use_of(&p->edges[n], box);
        if (use == SOMETIMES)
            smaller->edges[used++] = p->edges[n];
        smaller->odd ^= use == ALWAYS;
    }
    *solid_out = &smaller->base;
    return QN_OK;
}

/* A distance grows by one at most. */
static bool polygon_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    (void)solid, (void)box;
    for (int k = 0; k < 3; ++k) {
        ranges[k][0] = k < 2 ? -1 : 0;
        ranges[k][1] = k < 2 ? 1 : 0;
    }
    return true;
}

static const qni_solid_ops polygon_ops = {
    .destroy = destroy,
    .values = polygon_values,
    .gradients = polygon_gradients,
    .bounds = polygon_bounds,
    .crossings = polygon_crossings,
    .restrict_to = polygon_restrict,
    .slopes = polygon_slopes,
};

static polygon *create(qn_context *context, int64_t near, int64_t across) {
    polygon *p = (polygon *)qni_solid_new(context, sizeof *p, &polygon_ops);
    if (!p)
        return NULL;
    p->near = near;
    p->across = across;
    p->edges = qni_alloc(context, near + across, sizeof *p->edges);
    if (p->edges)
        return p;
    qni_solid_free(&p->base, sizeof *p);
    return NULL;
}

qn_solid *qni_polygon_create(qn_context *context, const qn_outline *outline, int32_t owner) {
    int64_t total = 0;
    for (int64_t c = 0; c < outline->contour_count; ++c)
        total += outline->contour_sizes[c];
    polygon *p = create(context, total, total);
    if (!p)
        return NULL;
    qni_box box = {{QNI_INFINITY, QNI_INFINITY, -QNI_INFINITY},
                   {-QNI_INFINITY, -QNI_INFINITY, QNI_INFINITY}};
    int64_t used = 0, first = 0;
    for (int64_t c = 0; c < outline->contour_count; first += outline->contour_sizes[c++])
        for (int64_t n = 0; n < outline->contour_sizes[c]; ++n) {
            const double *from = outline->points[first + n];
            const double *to = outline->points[first + (n + 1) % outline->contour_sizes[c]];
            for (int k = 0; k < 2; ++k) {
                box.low[k] = fmin(box.low[k], from[k]);
                box.high[k] = fmax(box.high[k], from[k]);
            }
            if (from[0] == to[0] && from[1] == to[1])
                continue;
            bool up = from[1] < to[1] || (from[1] == to[1] && from[0] < to[0]);
            const double *low = up ? from : to, *high = up ? to : from;
            p->edges[used++] = (edge){low[0], low[1], high[0], high[1]};
        }
    p->base.box = box;
    p->base.owner = owner;
    if (used == total) {
        memcpy(p->edges + total, p->edges, (size_t)total * sizeof *p->edges);
        return &p->base;
    }
    /* Points given twice left no edge between them. */
    polygon *exact = used > 0 ? create(context, used, used) : NULL;
    if (exact) {
        memcpy(exact->edges, p->edges, (size_t)used * sizeof *p->edges);
        memcpy(exact->edges + used, p->edges, (size_t)used * sizeof *p->edges);
        exact->base.box = box;
        exact->base.owner = owner;
    }
    destroy(&p->base);
    return exact ? &exact->base : used > 0 ? NULL : qni_empty_create(context);
}
