// SPDX-License-Identifier: MIT
/* All crossings of a segment with a polygon model: from hit to hit with the sign on either side of
 * each, so they alternate and agree with the ends whatever the model is like. */
#include "solid/model.h"

#include <string.h>

enum { MOST_STEPS = 60 };
/* How well crossings over holes are placed, as a part of the segment. */
static const double near_enough = 1e-9;
/* How near to a hit the sign beside it is taken, as a part of the segment. */
static const double beside = 1e-7;

typedef struct sweep {
    const qni_meshed *solid;
    const double *a, *b;
    bool smooth, inside;
    int64_t winding;
    qni_crossing *crossings;
    int32_t capacity, count;
} sweep;

static void point_at(const sweep *way, double t, double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = way->a[k] + t * (way->b[k] - way->a[k]);
}

static double excess(const sweep *way, double t, int64_t winding, double gradient[3]) {
    double point[3];
    point_at(way, t, point);
    return qni_model_excess(way->solid->model, winding, point, gradient);
}

/* What has no room goes in pairs: the last is taken back. */
static void put(sweep *way, double at, const double normal[3], int32_t owner, bool enters) {
    way->inside = enters;
    if (way->count == way->capacity) {
        way->count -= way->count > 0;
        return;
    }
    qni_crossing *crossing = &way->crossings[way->count++];
    *crossing = (qni_crossing){.at = at, .owner = owner, .enters = enters};
    memcpy(crossing->normal, normal, sizeof crossing->normal);
}

/* The whole winding number at t, among hits on caps alone. */
static int64_t winding_at(const sweep *way, double t, const qni_hit *hits, int64_t count) {
    int64_t winding = way->winding;
    for (int64_t n = 0; n < count; ++n)
        winding += hits[n].at <= t ? hits[n].change : 0;
    return winding;
}

/* Where the excess passes 0 between t0 and t1: false position, the end that stays counting half
 * each time (the Illinois rule), and halving now and then, since dipoles make small steps. */
static double find_root(const sweep *way, double t0, double t1, const qni_hit *hits,
                        int64_t count) {
    double f0 = excess(way, t0, winding_at(way, t0, hits, count), NULL);
    double f1 = excess(way, t1, winding_at(way, t1, hits, count), NULL);
    int last = 0;
    for (int step = 0; step < MOST_STEPS && t1 - t0 > near_enough; ++step) {
        double t = step % 4 == 3 || !((f0 < 0) != (f1 < 0)) ? 0.5 * (t0 + t1)
                                                            : t0 + (t1 - t0) * f0 / (f0 - f1);
        double f = excess(way, t, winding_at(way, t, hits, count), NULL);
        if (fabs(f) < 1e-10)
            return t;
        if ((f < 0) == (f0 < 0)) {
            t0 = t, f0 = f;
            f1 *= last == 1 ? 0.5 : 1;
            last = 1;
        } else {
            t1 = t, f1 = f;
            f0 *= last == -1 ? 0.5 : 1;
            last = -1;
        }
    }
    return 0.5 * (t0 + t1);
}

/* Between t0 and t1 no panel is met, but the signs differ: over a hole. */
static void put_smooth(sweep *way, double t0, double t1, const qni_hit *hits, int64_t count,
                       bool enters) {
    double gradient[3] = {0, 0, 0}, normal[3], back[3] = {1, 0, 0}, along[3];
    double at = find_root(way, t0, t1, hits, count);
    excess(way, at, 0, gradient); /* of the angle taken off: it grows out of the solid */
    for (int k = 0; k < 3; ++k)
        along[k] = enters ? way->a[k] - way->b[k] : way->b[k] - way->a[k];
    qni_unit(along, back, back);
    qni_unit(gradient, back, normal);
    double facing = normal[0] * along[0] + normal[1] * along[1] + normal[2] * along[2];
    put(way, at, facing > 0 ? normal : back, way->solid->base.owner, enters);
    qni_model *model = way->solid->model;
    __atomic_add_fetch(&model->hole_crossings, 1, __ATOMIC_RELAXED);
}

/* The part from t0 to t1, on which only the caps among `hits` lie. `last` has the sign at b. */
static void pass_open(sweep *way, double t0, double t1, const qni_hit *hits, int64_t count,
                      const bool *last) {
    double step = qni_lesser(beside, 0.25 * (t1 - t0));
    int64_t after = way->winding;
    for (int64_t n = 0; n < count; ++n)
        after += hits[n].change;
    bool inside = last ? *last : excess(way, t1 - step, after, NULL) >= 0;
    if (inside != way->inside)
        put_smooth(way, t0, t1, hits, count, inside);
    way->winding = after;
}

/* Hits at one place: the one whose way fits gives the normal. */
static void pass_group(sweep *way, const qni_hit *group, int64_t count, double next) {
    int64_t total = 0;
    for (int64_t n = 0; n < count; ++n)
        total += group[n].change;
    way->winding += total;
    double at = group[0].at, step = qni_lesser(beside, 0.25 * (next - at));
    bool inside = way->smooth ? excess(way, at + step, way->winding, NULL) >= 0
                              : qni_whole_is_inside(way->solid->model, way->winding);
    if (inside == way->inside)
        return;
    const qni_hit *best = NULL;
    for (int64_t n = 0; n < count; ++n)
        if (!group[n].cap && (!best || (group[n].change > 0) == (total > 0))) {
            best = &group[n];
            if ((best->change > 0) == (total > 0))
                break;
        }
    double normal[3], along = 0;
    qni_panel_normal(best->panel, normal);
    for (int k = 0; k < 3; ++k)
        along += normal[k] * (way->b[k] - way->a[k]);
    for (int k = 0; k < 3; ++k)
        normal[k] = (along > 0) == inside ? -normal[k] : normal[k];
    put(way, best->at, normal, best->panel->owner, inside);
}

/* How near two places on the segment may come by rounding. */
static double sameness(const qni_meshed *solid, const double a[3], const double b[3]) {
    double size = solid->model->size, length = 0;
    for (int k = 0; k < 3; ++k) {
        size = qni_greater(size, fabs(a[k]) + fabs(b[k]));
        length = qni_greater(length, fabs(b[k] - a[k]));
    }
    return length > 0 ? qni_lesser(32 * QNI_EPSILON * size / length, 1e-6) : 0;
}

static int64_t group_end(const qni_hits *hits, int64_t from, double same) {
    int64_t end = from + 1;
    while (end < hits->count && hits->items[end].at <= hits->items[from].at + same)
        ++end;
    return end;
}

static void walk(sweep *way, const qni_hits *hits, double same, bool last) {
    double before = 0;
    int64_t caps = 0; /* the hits from here to n are of caps alone */
    for (int64_t n = 0; n < hits->count;) {
        if (hits->items[n].cap && way->smooth) {
            ++n;
            continue;
        }
        if (hits->items[n].cap) {
            way->winding += hits->items[n++].change;
            caps = n;
            continue;
        }
        int64_t end = group_end(hits, n, same);
        if (way->smooth)
            pass_open(way, before, hits->items[n].at, hits->items + caps, n - caps, NULL);
        pass_group(way, hits->items + n, end - n, end < hits->count ? hits->items[end].at : 1);
        before = hits->items[end - 1].at;
        caps = n = end;
    }
    if (way->smooth)
        pass_open(way, before, 1, hits->items + caps, hits->count - caps, &last);
}

static bool sign_at(const qni_meshed *solid, const double p[3], int64_t winding, bool smooth) {
    if (!smooth)
        return qni_whole_is_inside(solid->model, winding);
    return qni_model_excess(solid->model, winding, p, NULL) >= 0;
}

int32_t qni_meshed_sweep(const qni_meshed *solid, const double a[3], const double b[3],
                         const qni_hits *hits, int64_t winding, const bool ends[2], bool smooth,
                         int32_t capacity, qni_crossing *crossings) {
    sweep way = {.solid = solid,
                 .a = a,
                 .b = b,
                 .smooth = smooth,
                 .inside = ends[0],
                 .winding = winding,
                 .crossings = crossings,
                 .capacity = capacity};
    walk(&way, hits, sameness(solid, a, b), ends[1]);
    return way.count;
}

qn_status qni_meshed_crossings(const qn_solid *base, const double a[3], const double b[3],
                               int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const qni_meshed *solid = (const qni_meshed *)base;
    *count_out = 0;
    qni_hits hits;
    bool smooth = qni_meshed_is_smooth(solid, a) || qni_meshed_is_smooth(solid, b);
    if (!qni_meshed_hits(solid, a, b, &hits)) {
        qni_hits_free(&hits);
        return QN_ERROR_OUT_OF_MEMORY;
    }
    if (hits.count || smooth) {
        const int64_t winding = qni_meshed_winding(solid, a);
        int64_t end = winding;
        for (int64_t n = 0; n < hits.count; ++n)
            end += hits.items[n].change;
        const bool ends[2] = {sign_at(solid, a, winding, smooth), sign_at(solid, b, end, smooth)};
        *count_out =
            qni_meshed_sweep(solid, a, b, &hits, winding, ends, smooth, capacity, crossings);
    }
    qni_hits_free(&hits);
    return qni_model_status(solid->model);
}
