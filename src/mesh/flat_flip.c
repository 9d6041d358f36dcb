// SPDX-License-Identifier: MIT
/* Edges within flat regions flipped until Delaunay's rule holds: angles across an edge add up to
 * half a turn at most. */
#include "mesh/flat_parts.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { MOST_SWEEPS = 64 }; /* rounding must not make it run for ever */
static const double margin = 1e-9;

/* Cotangent of the angle at `tip` in the triangle. */
static double cotangent(const qni_flat *flat, uint32_t tip, uint32_t a, uint32_t b) {
    const float *o = qni_flat_place(flat, tip), *p = qni_flat_place(flat, a),
                *q = qni_flat_place(flat, b);
    double u[3], v[3], dot = 0, square = 0;
    for (int k = 0; k < 3; ++k) {
        u[k] = (double)p[k] - (double)o[k];
        v[k] = (double)q[k] - (double)o[k];
        dot += u[k] * v[k];
    }
    for (int k = 0; k < 3; ++k) {
        const double c = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        square += c * c;
    }
    return dot / sqrt(square);
}

/* The side h from a to b, with c on its own triangle's tip and d on its twin's, becomes c - d. */
static bool may_flip(const qni_flat *flat, uint32_t h) {
    const uint32_t twin = flat->twins[h];
    if (flat->corners[3 * (size_t)(h / 3)] == QN_NO_HALFEDGE || twin == QN_NO_HALFEDGE ||
        flat->creased[h])
        return false;
    const uint32_t region = flat->regions[h / 3];
    if (region == QNI_NO_REGION || region != flat->regions[twin / 3] ||
        !flat->planes[region].touched)
        return false;
    const uint32_t a = flat->corners[h], b = flat->corners[qni_flat_next(h)],
                   c = flat->corners[qni_flat_before(h)], d = flat->corners[qni_flat_before(twin)];
    double unused;
    return cotangent(flat, c, a, b) + cotangent(flat, d, a, b) < -margin &&
           qni_flat_is_good(flat, &flat->planes[region], a, d, c, &unused) &&
           qni_flat_is_good(flat, &flat->planes[region], d, b, c, &unused) &&
           !qni_flat_joined(flat, c, d);
}

static void set_side(qni_flat *flat, uint32_t h, uint32_t from, uint32_t twin, bool creased) {
    flat->corners[h] = from;
    flat->twins[h] = twin;
    flat->creased[h] = creased;
    flat->starts[from] = h;
    if (twin != QN_NO_HALFEDGE)
        flat->twins[twin] = h;
}

/* Triangles a b c and b a d become a d c and d b c; h is the side from d to c of the first. */
static void flip(qni_flat *flat, uint32_t h) {
    const uint32_t g = flat->twins[h], h1 = qni_flat_next(h), h2 = qni_flat_before(h),
                   g1 = qni_flat_next(g), g2 = qni_flat_before(g);
    const uint32_t a = flat->corners[h], b = flat->corners[h1], c = flat->corners[h2],
                   d = flat->corners[g2];
    const uint32_t bc = flat->twins[h1], ca = flat->twins[h2], ad = flat->twins[g1],
                   db = flat->twins[g2];
    const bool of_bc = flat->creased[h1], of_ca = flat->creased[h2], of_ad = flat->creased[g1],
               of_db = flat->creased[g2];
    set_side(flat, h, d, g, false);
    set_side(flat, h1, c, ca, of_ca);
    set_side(flat, h2, a, ad, of_ad);
    set_side(flat, g, c, h, false);
    set_side(flat, g1, d, db, of_db);
    set_side(flat, g2, b, bc, of_bc);
    flat->changed[h / 3] = flat->changed[g / 3] = 1;
}

static int64_t sweep(qni_flat *flat, const uint32_t *triangles, int64_t count) {
    int64_t flips = 0;
    for (int64_t n = 0; n < count; ++n)
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t h = 3 * triangles[n] + k;
            if (may_flip(flat, h)) {
                flip(flat, h);
                ++flips;
            }
        }
    return flips;
}

qn_status qni_flat_flip(qni_flat *flat, qn_error *error) {
    uint32_t *list = qni_alloc(flat->context, flat->triangles, sizeof *list);
    int64_t count = 0;
    if (!list)
        return qni_fail_memory(error, "the flat parts");
    for (uint32_t t = 0; t < flat->triangles; ++t)
        if (flat->regions[t] != QNI_NO_REGION && flat->planes[flat->regions[t]].touched)
            list[count++] = t;
    for (int n = 0; n < MOST_SWEEPS && sweep(flat, list, count) > 0; ++n)
        ;
    qni_free(flat->context, list, flat->triangles, sizeof *list);
    return QN_OK;
}
