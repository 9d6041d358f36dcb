// SPDX-License-Identifier: MIT
/* A flat solid (x, y) turned about the z axis: x becomes the distance from the axis, y the height.
 * With facets, each sector between two of them sees the flat solid through one linear map, so
 * segments stay segments there and crossings are exact; round ones go through the root finder. A
 * part of a turn is for the caller to cut out. */
#include "solid/facets.h"
#include "solid/primitives.h"

#include <string.h>

/* Sector n lies between the directions edges[n] and edges[(n + 1) % count] and looks along
 * middles[n]. */
typedef struct revolved {
    qn_solid base;
    qn_solid *part;
    double (*edges)[2];
    double (
        *middles)[2];   /* over the cosine of half the angle: times a point it gives the part's x */
    int64_t count;      /* 0: round */
    double start, step; /* degrees; sectors begin at start + n step */
    double angle;       /* of all sectors, 360 at most */
    double stretch;     /* 1 / cos(step / 2) */
} revolved;

static const revolved *turn(const qn_solid *solid) {
    return (const revolved *)solid;
}

static void destroy(qn_solid *solid) {
    revolved *r = (revolved *)solid;
    qn_solid_destroy(r->part);
    qni_free(solid->context, r->edges, r->count, sizeof *r->edges);
    qni_free(solid->context, r->middles, r->count, sizeof *r->middles);
    qni_solid_free(solid, sizeof *r);
}

static double cross(const double u[2], const double v[2]) {
    return u[0] * v[1] - u[1] * v[0];
}

static double dot(const double u[2], const double v[2]) {
    return u[0] * v[0] + u[1] * v[1];
}

/* Directions beyond the sectors belong to the nearer one of the first and the last. */
static int64_t sector_of(const revolved *r, const double p[2]) {
    if (p[0] == 0 && p[1] == 0)
        return 0;
    double degrees = fmod(atan2(p[1], p[0]) * (180 / 3.14159265358979323846) - r->start, 360);
    degrees = degrees < 0 ? degrees + 360 : degrees;
    if (degrees >= r->angle)
        return degrees - r->angle > 360 - degrees ? 0 : r->count - 1;
    int64_t n = (int64_t)(degrees / r->step);
    return n < r->count ? n : r->count - 1;
}

static void look(const revolved *r, int64_t sector, const double p[3], double flat[3]) {
    flat[0] = r->count ? dot(r->middles[sector], p) : sqrt(dot(p, p));
    flat[1] = p[2];
    flat[2] = 0;
}

static qn_status revolve_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                double *values) {
    const revolved *r = turn(solid);
    double flat[QNI_SOLID_BLOCK][3];
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        for (int64_t i = 0; i < block; ++i)
            look(r, r->count ? sector_of(r, points[first + i]) : 0, points[first + i], flat[i]);
        QN_TRY(r->part->ops->values(r->part, block, (const double(*)[3])flat, values + first));
    }
    return QN_OK;
}

/* d/dx of the part's x, for the chain rule. */
static void radial(const revolved *r, int64_t sector, const double p[3], double out[2]) {
    double length = sqrt(dot(p, p));
    out[0] = r->count ? r->middles[sector][0] : length > 0 ? p[0] / length : 1;
    out[1] = r->count ? r->middles[sector][1] : length > 0 ? p[1] / length : 0;
}

static qn_status revolve_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                   double (*gradients)[3], int32_t *owners) {
    const revolved *r = turn(solid);
    double flat[QNI_SOLID_BLOCK][3], found[QNI_SOLID_BLOCK][3];
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        for (int64_t i = 0; i < block; ++i)
            look(r, r->count ? sector_of(r, points[first + i]) : 0, points[first + i], flat[i]);
        QN_TRY(r->part->ops->gradients(r->part, block, (const double(*)[3])flat,
                                       gradients ? found : NULL, owners ? owners + first : NULL));
        for (int64_t i = 0; gradients && i < block; ++i) {
            double by[2];
            radial(r, r->count ? sector_of(r, points[first + i]) : 0, points[first + i], by);
            gradients[first + i][0] = found[i][0] * by[0];
            gradients[first + i][1] = found[i][0] * by[1];
            gradients[first + i][2] = found[i][1];
        }
    }
    return QN_OK;
}

/* Whether no point of the box lies beyond the sectors. */
static bool within_sectors(const revolved *r, const qni_box *box) {
    if (r->count == 0 || r->angle >= 360)
        return true;
    double low[2] = {qni_cos_degrees(r->start), qni_sin_degrees(r->start)};
    double high[2] = {qni_cos_degrees(r->start + r->angle), qni_sin_degrees(r->start + r->angle)};
    bool after_low = true, before_high = true;
    for (int n = 0; n < 4; ++n) {
        double corner[2] = {n & 1 ? box->high[0] : box->low[0], n & 2 ? box->high[1] : box->low[1]};
        after_low = after_low && cross(low, corner) > 0;
        before_high = before_high && cross(corner, high) > 0;
    }
    return r->angle <= 180 ? after_low && before_high : after_low || before_high;
}

/* What the box becomes for the part. */
static qni_box flat_box(const revolved *r, const qni_box *box) {
    double nearest = 0, farthest = 0;
    for (int k = 0; k < 2; ++k) {
        double least = box->low[k] > 0 ? box->low[k] : box->high[k] < 0 ? -box->high[k] : 0;
        double most = fmax(fabs(box->low[k]), fabs(box->high[k]));
        nearest += least * least;
        farthest += most * most;
    }
    double low = sqrt(nearest) * (1 - 8 * QNI_EPSILON),
           high = sqrt(farthest) * r->stretch * (1 + 8 * QNI_EPSILON);
    if (!within_sectors(r, box))
        low = -high;
    return (qni_box){{low, box->low[2], 0}, {high, box->high[2], 0}};
}

static qn_status revolve_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    qni_box flat = flat_box(turn(solid), box);
    return turn(solid)->part->ops->bounds(turn(solid)->part, &flat, range);
}

/* Where nothing lies beyond the sectors f is continuous. */
static bool revolve_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const revolved *r = turn(solid);
    const qni_box flat = flat_box(r, box);
    double inner[3][2];
    if (r->angle < 360 || !r->part->ops->slopes || !r->part->ops->slopes(r->part, &flat, inner))
        return false;
    const double most = fmax(fabs(inner[0][0]), fabs(inner[0][1])) * r->stretch;
    for (int k = 0; k < 2; ++k) {
        ranges[k][0] = -most;
        ranges[k][1] = most;
        ranges[2][k] = inner[1][k];
    }
    return true;
}

/* A walk along the segment, sector by sector. */
typedef struct walk {
    const revolved *r;
    const double *a, *b;
    int64_t sector;
    double at; /* where the piece begins */
    qni_crossing *crossings;
    int32_t count, capacity;
    bool inside; /* at the end of what was walked */
} walk;

static void place(const walk *way, double t, double p[3]) {
    for (int k = 0; k < 3; ++k)
        p[k] = t <= 0 ? way->a[k] : t >= 1 ? way->b[k] : way->a[k] + t * (way->b[k] - way->a[k]);
}

static void keep(walk *way, const qni_crossing *crossing) {
    if (way->count == way->capacity) /* no room: the last two go, the signs at the ends stay true */
        way->count -= way->count > 0;
    else
        way->crossings[way->count++] = *crossing;
    way->inside = crossing->enters;
}

/* The normal of a crossing out of the sector's map into the world; straight back where there is
 * none. */
static void turn_normal(const walk *way, qni_crossing *crossing) {
    double out[3], back[3] = {1, 0, 0};
    const double *middle = way->r->middles[way->sector];
    double world[3] = {crossing->normal[0] * middle[0], crossing->normal[0] * middle[1],
                       crossing->normal[1]};
    for (int k = 0; k < 3; ++k)
        out[k] = crossing->enters ? way->a[k] - way->b[k] : way->b[k] - way->a[k];
    qni_unit(out, back, back);
    qni_unit(world, back, crossing->normal);
}

/* The piece from way->at to `end` in one sector. */
static qn_status walk_piece(walk *way, double end) {
    double from[3], to[3], p[3];
    qni_crossing found[QNI_CROSSINGS];
    int32_t count;
    place(way, way->at, p);
    look(way->r, way->sector, p, from);
    place(way, end, p);
    look(way->r, way->sector, p, to);
    const qn_solid *part = way->r->part;
    QN_TRY(part->ops->crossings(part, from, to, QNI_CROSSINGS, found, &count));
    bool inside;
    if (count > 0)
        inside = !found[0].enters;
    else
        QN_TRY(qni_solid_contains(part, from, &inside));
    if (inside != way->inside && way->at > 0) {
        /* Rounding puts the place between two sectors on different sides of the surface: it is the
         * crossing. */
        qni_crossing here = {.at = way->at, .enters = inside};
        double gradient[1][3];
        QN_TRY(part->ops->gradients(part, 1, (const double(*)[3])from, gradient, &here.owner));
        memcpy(here.normal, gradient[0], sizeof here.normal);
        turn_normal(way, &here);
        keep(way, &here);
    }
    way->inside = inside;
    for (int32_t i = 0; i < count; ++i) {
        turn_normal(way, &found[i]);
        found[i].at = way->at + found[i].at * (end - way->at);
        keep(way, &found[i]);
    }
    way->at = end;
    return QN_OK;
}

/* Where the segment leaves the sector over the given border; 1 when rounding hides it. */
static double border_at(const walk *way, int64_t border) {
    const double *edge = way->r->edges[border];
    double along[2] = {way->b[0] - way->a[0], way->b[1] - way->a[1]};
    double t = -cross(edge, way->a) / cross(edge, along);
    return t > way->at && t < 1 ? t : t <= way->at ? way->at : 1;
}

static qn_status facet_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                 int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const revolved *r = turn(solid);
    walk way = {.r = r,
                .a = a,
                .b = b,
                .sector = sector_of(r, a),
                .crossings = crossings,
                .capacity = capacity};
    int64_t last = sector_of(r, b);
    double side = cross(a, b);
    double along[2] = {b[0] - a[0], b[1] - a[1]};
    if (side == 0 && last != way.sector) { /* through the axis */
        double t = -dot(a, along) / dot(along, along);
        QN_TRY(walk_piece(&way, t > 0 && t < 1 ? t : 0));
    } else {
        for (int64_t steps = 0; way.sector != last && steps < r->count; ++steps) {
            int64_t next = (way.sector + (side > 0 ? 1 : r->count - 1)) % r->count;
            double t = border_at(&way, side > 0 ? next : way.sector);
            if (t > way.at)
                QN_TRY(walk_piece(&way, t));
            way.sector = next;
        }
    }
    way.sector = last;
    QN_TRY(walk_piece(&way, 1)); /* of no length, perhaps: then it sets the sign at b right */
    *count_out = way.count;
    return QN_OK;
}

static qn_status revolve_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                   int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    if (turn(solid)->count == 0)
        return qni_find_crossings(solid, a, b, capacity, crossings, count_out);
    return facet_crossings(solid, a, b, capacity, crossings, count_out);
}

static qn_status revolve_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const revolved *r = turn(solid);
    qni_box flat = flat_box(r, box);
    qn_solid *part;
    *solid_out = NULL;
    QN_TRY(r->part->ops->restrict_to(r->part, &flat, &part));
    if (part == r->part) {
        *solid_out = qni_solid_retain(solid);
    } else {
        *solid_out =
            qni_revolve_create(solid->context, part, r->start, r->angle, (int32_t)r->count);
        if (*solid_out)
            (*solid_out)->box = solid->box;
    }
    qn_solid_destroy(part);
    return *solid_out ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static const qni_solid_ops revolve_ops = {
    .destroy = destroy,
    .values = revolve_values,
    .gradients = revolve_gradients,
    .bounds = revolve_bounds,
    .crossings = revolve_crossings,
    .restrict_to = revolve_restrict,
    .slopes = revolve_slopes,
};

static void set_sectors(revolved *r) {
    for (int64_t n = 0; n < r->count; ++n) {
        double begin = r->start + (double)n * r->step,
               middle = r->start + ((double)n + 0.5) * r->step;
        if (n == 0 && r->angle < 360) /* opposite to the middle of all sectors */
            begin = r->start + 0.5 * r->angle + 180;
        r->edges[n][0] = qni_cos_degrees(begin);
        r->edges[n][1] = qni_sin_degrees(begin);
        r->middles[n][0] = qni_cos_degrees(middle) * r->stretch;
        r->middles[n][1] = qni_sin_degrees(middle) * r->stretch;
    }
}

qn_solid *qni_revolve_create(qn_context *context, const qn_solid *part, double start, double angle,
                             int32_t fragments) {
    revolved *r = (revolved *)qni_solid_new(context, sizeof *r, &revolve_ops);
    if (!r)
        return NULL;
    r->count = fragments;
    r->start = start;
    r->angle = angle;
    r->step = fragments ? angle / fragments : 0;
    r->stretch = fragments ? 1 / qni_cos_degrees(0.5 * r->step) : 1;
    r->base.depth = part->depth + 1;
    r->base.weight = part->weight;
    r->part = qni_solid_retain(part);
    r->edges = qni_alloc(context, fragments, sizeof *r->edges);
    r->middles = qni_alloc(context, fragments, sizeof *r->middles);
    if (!r->edges || !r->middles) {
        destroy(&r->base);
        return NULL;
    }
    set_sectors(r);
    double reach = fmax(fabs(part->box.low[0]), fabs(part->box.high[0]));
    if (qni_box_is_nothing(&part->box))
        r->base.box = qni_box_nothing();
    else
        r->base.box =
            (qni_box){{-reach, -reach, part->box.low[1]}, {reach, reach, part->box.high[1]}};
    return &r->base;
}
