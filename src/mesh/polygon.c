// SPDX-License-Identifier: MIT
/* Polygons into triangles by ear clipping (Meisters, "Polygons have ears", 1975). */
#include "mesh/polygon.h"

#include <math.h>
#include <stddef.h>

typedef struct flat_point {
    double x, y;
} flat_point;

typedef struct ring {
    flat_point *points;
    int32_t *next, *previous, *reflex; /* reflex: corners that may lie within an ear */
    int32_t reflex_count;
} ring;

/* The Newell normal: its components are the areas of the polygon's shadows on the coordinate
 * planes. */
static void newell_normal(const float *positions, const uint32_t *corners, int64_t count,
                          double normal[3]) {
    normal[0] = normal[1] = normal[2] = 0;
    const float *origin = positions + 3 * (size_t)corners[0];
    for (int64_t i = 0; i < count; ++i) {
        const float *p = positions + 3 * (size_t)corners[i];
        const float *q = positions + 3 * (size_t)corners[i + 1 < count ? i + 1 : 0];
        for (int a = 0; a < 3; ++a) {
            int b = (a + 1) % 3, c = (a + 2) % 3;
            double pb = (double)p[b] - (double)origin[b], qb = (double)q[b] - (double)origin[b];
            double pc = (double)p[c] - (double)origin[c], qc = (double)q[c] - (double)origin[c];
            normal[a] += pb * qc - qb * pc;
        }
    }
}

/* Drop the axis that the polygon faces most, with the winding made counter-clockwise; false without
 * area. */
static bool flatten(const float *positions, const uint32_t *corners, int64_t count,
                    flat_point *points) {
    double normal[3];
    newell_normal(positions, corners, count, normal);
    int axis = 0;
    for (int a = 1; a < 3; ++a)
        if (fabs(normal[a]) > fabs(normal[axis]))
            axis = a;
    if (!(fabs(normal[axis]) > 0) || !isfinite(normal[axis]))
        return false;
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    if (normal[axis] < 0) {
        int swap = x;
        x = y;
        y = swap;
    }
    for (int64_t i = 0; i < count; ++i) {
        const float *p = positions + 3 * (size_t)corners[i];
        points[i] = (flat_point){(double)p[x], (double)p[y]};
    }
    return true;
}

static double turn(flat_point a, flat_point b, flat_point c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool same(flat_point a, flat_point b) {
    return a.x == b.x && a.y == b.y;
}

static double turn_at(const ring *r, int32_t i) {
    return turn(r->points[r->previous[i]], r->points[i], r->points[r->next[i]]);
}

static bool is_ear(const ring *r, int32_t i) {
    flat_point a = r->points[r->previous[i]], b = r->points[i], c = r->points[r->next[i]];
    if (!(turn(a, b, c) > 0))
        return false;
    for (int32_t k = 0; k < r->reflex_count; ++k) {
        flat_point p = r->points[r->reflex[k]];
        if (r->next[r->reflex[k]] < 0 || same(p, a) || same(p, b) || same(p, c))
            continue;
        if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0)
            return false;
    }
    return true;
}

/* What is clipped when nothing is an ear any more: a corner without area if there is one, else any.
 */
static int32_t least_bad(const ring *r, int32_t start) {
    int32_t best = start;
    for (int32_t i = r->next[start]; i != start; i = r->next[i])
        if (fabs(turn_at(r, i)) < fabs(turn_at(r, best)))
            best = i;
    return best;
}

static void set_up(ring *r, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
        r->next[i] = i + 1 < count ? i + 1 : 0;
        r->previous[i] = i ? i - 1 : count - 1;
    }
    r->reflex_count = 0;
    for (int32_t i = 0; i < count; ++i)
        if (!(turn_at(r, i) > 0))
            r->reflex[r->reflex_count++] = i;
}

/* Corners that were clipped, or that are reflex no more, need no looking at: clipping never makes
 * one reflex. */
static void refresh_reflex(ring *r) {
    int32_t kept = 0;
    for (int32_t k = 0; k < r->reflex_count; ++k) {
        int32_t i = r->reflex[k];
        if (r->next[i] >= 0 && !(turn_at(r, i) > 0))
            r->reflex[kept++] = i;
    }
    r->reflex_count = kept;
}

static void unlink_corner(ring *r, int32_t i) {
    r->next[r->previous[i]] = r->next[i];
    r->previous[r->next[i]] = r->previous[i];
    r->next[i] = -1;
}

static void clip(ring *r, const uint32_t *corners, int32_t count, uint32_t *triangles) {
    int32_t at = 0, misses = 0;
    for (int32_t left = count; left > 3;) {
        bool ear = is_ear(r, at);
        if (!ear && ++misses <= left) {
            at = r->next[at];
            continue;
        }
        if (!ear)
            at = least_bad(r, at);
        int32_t before = r->previous[at], behind = r->next[at];
        *triangles++ = corners[before];
        *triangles++ = corners[at];
        *triangles++ = corners[behind];
        unlink_corner(r, at);
        --left;
        misses = 0;
        if (left % 32 == 0)
            refresh_reflex(r);
        at = r->next[behind]; /* every other corner: rounder triangles than a fan */
    }
    *triangles++ = corners[r->previous[at]];
    *triangles++ = corners[at];
    *triangles++ = corners[r->next[at]];
}

void qni_polygon_split(const float *positions, const uint32_t *corners, int64_t count,
                       void *scratch, uint32_t *triangles) {
    ring r;
    r.points = scratch;
    if (count > 3 && count <= QNI_LARGEST_CLIPPED && flatten(positions, corners, count, r.points)) {
        r.next = (int32_t *)(void *)(r.points + count);
        r.previous = r.next + count;
        r.reflex = r.previous + count;
        set_up(&r, (int32_t)count);
        clip(&r, corners, (int32_t)count, triangles);
        return;
    }
    for (int64_t i = 0; i + 2 < count; ++i) {
        *triangles++ = corners[0];
        *triangles++ = corners[i + 1];
        *triangles++ = corners[i + 2];
    }
}
