// SPDX-License-Identifier: MIT
/* The shadow of a solid along z, a flat shape: (x, y) belongs to it where the vertical line there
 * meets the solid. No outline is made: a point asks for the crossings of its line and the least
 * value on it, and the normal of a border is that of the solid's rim above or below it. */
#include "solid/primitives.h"

#include <string.h>

enum { SLABS = 8, HEIGHTS = 32, STEPS_INWARD = 5 };
/* How closely the height of the least value is found, of the part's height. */
static const double precision = 1e-7;

typedef struct shadow {
    qn_solid base;
    qn_solid *part;
    double low, high; /* the part lies between these heights */
} shadow;

/* What a vertical line has most of: an interval within the part. */
typedef struct stay {
    double length, middle;
    qni_crossing in, out; /* its lower and its upper end */
} stay;

static const shadow *self(const qn_solid *solid) {
    return (const shadow *)solid;
}

static void destroy(qn_solid *solid) {
    qn_solid_destroy(((shadow *)solid)->part);
    qni_solid_free(solid, sizeof(shadow));
}

/* The longest stay of the line through p in the part; without length where there is none. */
static qn_status longest_stay(const shadow *s, const double p[3], stay *stay_out) {
    const double ends[2][3] = {{p[0], p[1], s->low}, {p[0], p[1], s->high}};
    qni_crossing found[QNI_CROSSINGS];
    int32_t count;
    stay_out->length = 0;
    QN_TRY(s->part->ops->crossings(s->part, ends[0], ends[1], QNI_CROSSINGS, found, &count));
    for (int32_t i = 0; i + 1 < count; ++i) {
        const double length = (found[i + 1].at - found[i].at) * (s->high - s->low);
        if (!found[i].enters || !(length > stay_out->length))
            continue;
        stay_out->length = length;
        stay_out->middle = s->low + 0.5 * (found[i].at + found[i + 1].at) * (s->high - s->low);
        stay_out->in = found[i];
        stay_out->out = found[i + 1];
    }
    return QN_OK;
}

/* ---- values ------------------------------------------------------------------------------------
 */

static qn_status value_at(const shadow *s, const double p[3], double height, double *value_out) {
    const double point[1][3] = {{p[0], p[1], height}};
    return s->part->ops->values(s->part, 1, point, value_out);
}

/* Where the line through p is deepest in the part, or nearest to it, between two heights; by golden
 * sections. */
static qn_status descend(const shadow *s, const double p[3], double low, double high,
                         double *height_out, double *value_out) {
    const double golden = 0.6180339887498949;
    double at[2] = {high - golden * (high - low), low + golden * (high - low)}, value[2];
    for (int n = 0; n < 2; ++n)
        QN_TRY(value_at(s, p, at[n], &value[n]));
    const double enough = precision * (s->high - s->low);
    while (high - low > enough) {
        const int worse = value[0] < value[1]; /* towards it the range shrinks */
        *(worse ? &high : &low) = at[worse];
        at[worse] = at[!worse];
        value[worse] = value[!worse];
        at[!worse] = worse ? high - golden * (high - low) : low + golden * (high - low);
        QN_TRY(value_at(s, p, at[!worse], &value[!worse]));
    }
    const int better = value[1] < value[0];
    *height_out = at[better];
    *value_out = value[better];
    return QN_OK;
}

/* The least value on the line through p and where it is. Its side is that of the crossings. */
static qn_status least_value(const shadow *s, const double p[3], stay *stay_out, double *height_out,
                             double *value_out) {
    QN_TRY(longest_stay(s, p, stay_out));
    if (stay_out->length > 0) {
        const double half = 0.5 * stay_out->length;
        QN_TRY(
            descend(s, p, stay_out->middle - half, stay_out->middle + half, height_out, value_out));
        *value_out = *value_out < 0 ? *value_out : -QNI_TIE;
        return QN_OK;
    }
    double heights[HEIGHTS][3], values[HEIGHTS];
    const double step = (s->high - s->low) / HEIGHTS;
    int least = 0;
    for (int n = 0; n < HEIGHTS; ++n) {
        heights[n][0] = p[0];
        heights[n][1] = p[1];
        heights[n][2] = s->low + (n + 0.5) * step;
    }
    QN_TRY(s->part->ops->values(s->part, HEIGHTS, (const double(*)[3])heights, values));
    for (int n = 1; n < HEIGHTS; ++n)
        least = values[n] < values[least] ? n : least;
    QN_TRY(
        descend(s, p, heights[least][2] - step, heights[least][2] + step, height_out, value_out));
    *value_out = *value_out > 0 ? *value_out : QNI_TIE;
    return QN_OK;
}

static qn_status shadow_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                               double *values) {
    for (int64_t n = 0; n < count; ++n) {
        stay found;
        double height;
        QN_TRY(least_value(self(solid), points[n], &found, &height, &values[n]));
    }
    return QN_OK;
}

/* At the least value f falls on one side of the height and rises on the other: of the mixtures of
 * the two gradients the level one is the shadow's. */
static qn_status shadow_gradient(const shadow *s, const double p[3], double gradient[3],
                                 int32_t *owner) {
    stay found;
    double height, value;
    QN_TRY(least_value(s, p, &found, &height, &value));
    const double apart = 2 * precision * (s->high - s->low);
    const double points[3][3] = {
        {p[0], p[1], height - apart}, {p[0], p[1], height + apart}, {p[0], p[1], height}};
    double g[3][3];
    int32_t owners[3];
    QN_TRY(s->part->ops->gradients(s->part, 3, points, g, owners));
    const double fall = -g[0][2], rise = g[1][2];
    const bool valley = fall > 0 && rise > 0;
    for (int k = 0; k < 2; ++k)
        gradient[k] = valley ? (rise * g[0][k] + fall * g[1][k]) / (rise + fall) : g[2][k];
    gradient[2] = 0;
    *owner = owners[2];
    return QN_OK;
}

static qn_status shadow_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double (*gradients)[3], int32_t *owners) {
    for (int64_t n = 0; n < count; ++n) {
        double gradient[3];
        int32_t owner;
        QN_TRY(shadow_gradient(self(solid), points[n], gradient, &owner));
        if (gradients)
            memcpy(gradients[n], gradient, sizeof gradient);
        if (owners)
            owners[n] = owner;
    }
    return QN_OK;
}

/* A slab from floor to ceiling bounds from below; each thinner one from above. */
static qn_status shadow_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const shadow *s = self(solid);
    qni_box tall = *box;
    tall.low[2] = s->low;
    tall.high[2] = s->high;
    QN_TRY(s->part->ops->bounds(s->part, &tall, range));
    const double thick = (s->high - s->low) / SLABS;
    for (int n = 0; n < SLABS && range[0] < 0; ++n) {
        double slab[2];
        tall.low[2] = s->low + n * thick;
        tall.high[2] = tall.low[2] + thick;
        QN_TRY(s->part->ops->bounds(s->part, &tall, slab));
        range[1] = qni_min(range[1], slab[1]);
    }
    return QN_OK;
}

static bool shadow_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const shadow *s = self(solid);
    qni_box tall = *box;
    tall.low[2] = s->low;
    tall.high[2] = s->high;
    if (!s->part->ops->slopes || !s->part->ops->slopes(s->part, &tall, ranges))
        return false;
    ranges[2][0] = ranges[2][1] = 0;
    return true;
}

/* ---- crossings ---------------------------------------------------------------------------------
 */

/* The level mean of the normals at both ends of a stay: at a rim, where the ends meet, the normal
 * of the rim's shadow. False where the ends face straight up and down, as above a wall. */
static bool normal_of_ends(const stay *s, double normal[3]) {
    const double *down = s->in.normal, *up = s->out.normal;
    double level[3] = {0, 0, 0}, squares = 0;
    for (int k = 0; k < 2; ++k) {
        level[k] = down[k] * up[2] - up[k] * down[2];
        squares += level[k] * level[k];
    }
    memcpy(normal, level, sizeof level);
    return squares > 1e-18 && down[2] <= 0 && up[2] >= 0;
}

/* The normal of the part's wall where the segment, moved to a height, passes it nearest to t. */
static qn_status normal_of_wall(const shadow *s, const double a[3], const double b[3],
                                double height, qni_crossing *crossing) {
    const double from[3] = {a[0], a[1], height}, to[3] = {b[0], b[1], height};
    qni_crossing found[QNI_CROSSINGS];
    int32_t count, nearest = -1;
    QN_TRY(s->part->ops->crossings(s->part, from, to, QNI_CROSSINGS, found, &count));
    for (int32_t i = 0; i < count; ++i)
        if (found[i].enters == crossing->enters &&
            (nearest < 0 ||
             fabs(found[i].at - crossing->at) < fabs(found[nearest].at - crossing->at)))
            nearest = i;
    if (nearest < 0)
        return QN_OK; /* the normal found before stays */
    const double level[3] = {found[nearest].normal[0], found[nearest].normal[1], 0};
    crossing->owner = found[nearest].owner;
    qni_unit(level, crossing->normal, crossing->normal);
    return QN_OK;
}

static qn_status stay_inward(const shadow *s, const double a[3], const double b[3], double t,
                             stay *stay_out) {
    double p[3];
    for (int k = 0; k < 3; ++k)
        p[k] = a[k] + qni_min(qni_max(t, 0), 1) * (b[k] - a[k]);
    return longest_stay(s, p, stay_out);
}

/* A crossing's normal, from the stays a little inside of it: at a rim they shrink to nothing
 * towards the border, at a wall they do not. */
static qn_status mend_normal(const shadow *s, const double a[3], const double b[3],
                             qni_crossing *crossing) {
    double step = crossing->enters ? 1e-9 : -1e-9, normal[3];
    for (int n = 0; n < STEPS_INWARD; ++n, step *= 16) {
        stay near, far;
        QN_TRY(stay_inward(s, a, b, crossing->at + step, &near));
        if (!(near.length > 0))
            continue;
        QN_TRY(stay_inward(s, a, b, crossing->at + 16 * step, &far));
        const bool is_rim = far.length > 2 * near.length && normal_of_ends(&near, normal);
        if (!is_rim)
            return normal_of_wall(s, a, b, near.middle, crossing);
        crossing->owner = near.in.owner;
        qni_unit(normal, crossing->normal, crossing->normal);
        return QN_OK;
    }
    return QN_OK;
}

static qn_status shadow_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                  int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    QN_TRY(qni_find_crossings(solid, a, b, capacity, crossings, count_out));
    for (int32_t i = 0; i < *count_out; ++i)
        QN_TRY(mend_normal(self(solid), a, b, &crossings[i]));
    return QN_OK;
}

static qn_solid *create(qn_context *context, qn_solid *part, double low, double high);

static qn_status shadow_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const shadow *s = self(solid);
    qni_box tall = *box;
    qn_solid *part;
    tall.low[2] = s->low;
    tall.high[2] = s->high;
    *solid_out = NULL;
    QN_TRY(s->part->ops->restrict_to(s->part, &tall, &part));
    *solid_out =
        part == s->part ? qni_solid_retain(solid) : create(solid->context, part, s->low, s->high);
    if (*solid_out && part != s->part)
        (*solid_out)->box = solid->box;
    qn_solid_destroy(part);
    return *solid_out ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static const qni_solid_ops shadow_ops = {
    .destroy = destroy,
    .values = shadow_values,
    .gradients = shadow_gradients,
    .bounds = shadow_bounds,
    .crossings = shadow_crossings,
    .restrict_to = shadow_restrict,
    .slopes = shadow_slopes,
};

static qn_solid *create(qn_context *context, qn_solid *part, double low, double high) {
    shadow *s = (shadow *)qni_solid_new(context, sizeof *s, &shadow_ops);
    if (!s)
        return NULL;
    s->part = qni_solid_retain(part);
    s->low = low;
    s->high = high;
    s->base.depth = part->depth + 1;
    s->base.owner = part->owner;
    s->base.box = part->box;
    s->base.box.low[2] = -QNI_INFINITY;
    s->base.box.high[2] = QNI_INFINITY;
    return &s->base;
}

qn_solid *qni_shadow_create(qn_context *context, qn_solid *part) {
    const double room = 0.01 * (part->box.high[2] - part->box.low[2]);
    return create(context, part, part->box.low[2] - room, part->box.high[2] + room);
}
