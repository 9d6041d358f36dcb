// SPDX-License-Identifier: MIT
/* Vertices that go: those with one flat region all round, and those on a straight edge between two.
 * The hole is split without them; its sides keep their neighbours. */
#include "mesh/flat_parts.h"

#include <math.h>
#include <string.h>

enum { MOST_PASSES = 12 };
static const double least_sine = 0.05; /* of the angle of two regions: their line is well known */

/* The triangles round a vertex: side `out[n]` runs from it to ring[n], and the triangle of it goes
 * on to ring[n + 1]. */
typedef struct fan {
    uint32_t out[QNI_FLAT_MOST], ring[QNI_FLAT_MOST];
    int count;
} fan;

static uint32_t region_of(const qni_flat *flat, uint32_t side) {
    return flat->regions[side / 3];
}

/* False where it is open, too large, or not all flat. */
static bool gather(const qni_flat *flat, uint32_t vertex, fan *f) {
    const uint32_t start = flat->starts[vertex];
    uint32_t h = start;
    f->count = 0;
    if (start == QN_NO_HALFEDGE)
        return false;
    do {
        if (f->count == QNI_FLAT_MOST || region_of(flat, h) == QNI_NO_REGION)
            return false;
        f->out[f->count] = h;
        f->ring[f->count++] = flat->corners[qni_flat_next(h)];
        h = flat->twins[qni_flat_before(h)];
        if (h == QN_NO_HALFEDGE)
            return false;
    } while (h != start);
    return f->count >= 3;
}

/* The places round the fan where one region ends; how many, 3 for more. */
static int find_ends(const qni_flat *flat, const fan *f, int ends[2]) {
    int count = 0;
    for (int n = 0; n < f->count; ++n)
        if (region_of(flat, f->out[n]) != region_of(flat, f->out[(n + f->count - 1) % f->count])) {
            if (count == 2)
                return 3;
            ends[count++] = n;
        }
    return count;
}

/* What is written where the fan was. */
typedef struct filling {
    uint32_t triangles[2 * QNI_FLAT_MOST][3];
    uint32_t regions[2 * QNI_FLAT_MOST];
    int count;
} filling;

/* The part of the fan from ring[from] to ring[from + sides]. */
static bool fill(const qni_flat *flat, const fan *f, int from, int sides, filling *all) {
    uint32_t polygon[QNI_FLAT_MOST];
    const int corners = sides == f->count ? sides : sides + 1;
    const uint32_t region = region_of(flat, f->out[from]);
    const qni_plane *plane = &flat->planes[region];
    if (corners < 3 || corners > QNI_FLAT_MOST || plane->barred)
        return false;
    for (int n = 0; n < corners; ++n)
        polygon[n] = f->ring[(from + n) % f->count];
    if (!qni_flat_split(flat, plane, polygon, corners, all->triangles + all->count))
        return false;
    for (int n = 0; n < corners - 2; ++n)
        all->regions[all->count++] = region;
    return true;
}

static bool fill_within(const qni_flat *flat, const fan *f, filling *all) {
    for (int n = 0; n < f->count; ++n)
        if (flat->creased[f->out[n]])
            return false;
    return fill(flat, f, 0, f->count, all);
}

/* Two planes meet in a line, so all that lies on both is straight; but it may run back. */
static bool runs_on(const qni_flat *flat, uint32_t vertex, const fan *f, const int ends[2]) {
    const double *m = flat->planes[region_of(flat, f->out[ends[0]])].normal,
                 *n = flat->planes[region_of(flat, f->out[ends[1]])].normal;
    const float *v = qni_flat_place(flat, vertex), *a = qni_flat_place(flat, f->ring[ends[0]]),
                *b = qni_flat_place(flat, f->ring[ends[1]]);
    double sine = 0, along = 0;
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        sine += (m[p] * n[q] - m[q] * n[p]) * (m[p] * n[q] - m[q] * n[p]);
        along += ((double)a[k] - (double)v[k]) * ((double)b[k] - (double)v[k]);
    }
    return sine > least_sine * least_sine && along < 0;
}

static bool fill_along(const qni_flat *flat, uint32_t vertex, const fan *f, const int ends[2],
                       filling *all) {
    const int first = ends[1] - ends[0];
    if (flat->creased[f->out[ends[0]]] != flat->creased[f->out[ends[1]]] ||
        !runs_on(flat, vertex, f, ends) ||
        qni_flat_joined(flat, f->ring[ends[0]], f->ring[ends[1]]))
        return false;
    for (int n = 0; n < f->count; ++n)
        if (n != ends[0] && n != ends[1] && flat->creased[f->out[n]])
            return false;
    return fill(flat, f, ends[0], first, all) && fill(flat, f, ends[1], f->count - first, all);
}

/* ---- writing --------------------------------------------------------------------------------- */

/* A side of the hole, or between two new triangles: who waits for its other half. */
typedef struct open_side {
    uint32_t from, to; /* of the half that is wanted */
    uint32_t twin;
    bool creased;
} open_side;

typedef struct seam {
    open_side sides[5 * QNI_FLAT_MOST];
    int count;
} seam;

static void pair(qni_flat *flat, seam *open, uint32_t h, uint32_t from, uint32_t to, bool creased) {
    for (int n = 0; n < open->count; ++n) {
        open_side *side = &open->sides[n];
        if (side->from != from || side->to != to)
            continue;
        flat->twins[h] = side->twin;
        if (side->twin != QN_NO_HALFEDGE)
            flat->twins[side->twin] = h;
        flat->creased[h] = side->creased;
        *side = open->sides[--open->count];
        return;
    }
    const open_side wanted = {to, from, h, creased};
    flat->creased[h] = creased;
    open->sides[open->count++] = wanted;
}

/* `line`: the ends of the edge that takes the place of two, or NULL; and whether it is a crease. */
static void write_filling(qni_flat *flat, uint32_t vertex, const fan *f, const filling *all,
                          const uint32_t *line, bool creased) {
    seam open;
    open.count = 0;
    for (int n = 0; n < f->count; ++n) {
        const uint32_t rim = qni_flat_next(f->out[n]);
        const open_side side = {f->ring[n], f->ring[(n + 1) % f->count], flat->twins[rim],
                                flat->creased[rim]};
        open.sides[open.count++] = side;
    }
    for (int n = 0; n < f->count; ++n) {
        const uint32_t t = f->out[n] / 3;
        if (n >= all->count) {
            flat->corners[3 * (size_t)t] = QN_NO_HALFEDGE;
            flat->regions[t] = QNI_NO_REGION;
            continue;
        }
        flat->regions[t] = all->regions[n];
        flat->changed[t] = 1;
        flat->planes[all->regions[n]].touched = true;
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t a = all->triangles[n][k], b = all->triangles[n][(k + 1) % 3];
            flat->corners[3 * t + k] = a;
            flat->starts[a] = 3 * t + k;
            pair(flat, &open, 3 * t + k, a, b,
                 creased && ((a == line[0] && b == line[1]) || (a == line[1] && b == line[0])));
        }
    }
    flat->starts[vertex] = QN_NO_HALFEDGE;
    ++flat->dropped;
}

/* ---- all of it ------------------------------------------------------------------------------- */

static bool drop(qni_flat *flat, uint32_t vertex) {
    fan f;
    filling all;
    int ends[2];
    all.count = 0;
    if (!gather(flat, vertex, &f))
        return false;
    const int count = find_ends(flat, &f, ends);
    if (count == 0 && fill_within(flat, &f, &all)) {
        write_filling(flat, vertex, &f, &all, NULL, false);
        return true;
    }
    if (count == 2 && fill_along(flat, vertex, &f, ends, &all)) {
        const uint32_t line[2] = {f.ring[ends[0]], f.ring[ends[1]]};
        write_filling(flat, vertex, &f, &all, line, flat->creased[f.out[ends[0]]]);
        return true;
    }
    return false;
}

void qni_flat_drop(qni_flat *flat) {
    int64_t before = -1;
    for (int pass = 0; pass < MOST_PASSES && flat->dropped > before; ++pass) {
        before = flat->dropped;
        for (uint32_t v = 0; v < flat->vertices; ++v)
            drop(flat, v);
    }
}
