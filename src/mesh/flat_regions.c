// SPDX-License-Identifier: MIT
/* Flat regions of a mesh: grown over neighbours from a triangle whose plane is well known, with the
 * plane fitted anew to all that was found until no more is. */
#include "mesh/flat_parts.h"
#include "mesh/predicates.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { MOST_FITS = 16, LEAST_POWER = 6, CLASSES = 40 };

typedef struct growth {
    qni_flat *flat;
    uint32_t *found; /* [triangles]: the region's, then room */
    int64_t count;
    uint32_t region;
    qni_plane plane;
} growth;

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void aim_plane(qni_plane *plane, const double normal[3], double length,
                      const double through[3]) {
    int k = 0;
    for (int a = 0; a < 3; ++a) {
        plane->normal[a] = normal[a] / length;
        k = fabs(normal[a]) > fabs(normal[k]) ? a : k;
    }
    plane->height = dot3(plane->normal, through);
    plane->x = normal[k] > 0 ? (k + 1) % 3 : (k + 2) % 3;
    plane->y = normal[k] > 0 ? (k + 2) % 3 : (k + 1) % 3;
}

/* The normal of a triangle, as long as twice its area is large; its least height. */
static double normal_of(const qni_flat *flat, uint32_t t, double normal[3]) {
    const uint32_t *c = flat->corners + 3 * (size_t)t;
    double side[3][3], longest = 0;
    for (int n = 0; n < 3; ++n) {
        const float *p = qni_flat_place(flat, c[n]), *q = qni_flat_place(flat, c[(n + 1) % 3]);
        for (int k = 0; k < 3; ++k)
            side[n][k] = (double)q[k] - (double)p[k];
        longest = fmax(longest, dot3(side[n], side[n]));
    }
    for (int k = 0; k < 3; ++k)
        normal[k] = side[0][(k + 1) % 3] * side[1][(k + 2) % 3] -
                    side[0][(k + 2) % 3] * side[1][(k + 1) % 3];
    return longest > 0 ? sqrt(dot3(normal, normal) / longest) : 0;
}

static void plane_of_triangle(const qni_flat *flat, uint32_t t, qni_plane *plane) {
    const float *p = qni_flat_place(flat, flat->corners[3 * (size_t)t]);
    const double through[3] = {(double)p[0], (double)p[1], (double)p[2]};
    double normal[3];
    normal_of(flat, t, normal);
    memset(plane, 0, sizeof *plane);
    aim_plane(plane, normal, sqrt(dot3(normal, normal)), through);
}

static double height_over(const qni_flat *flat, const qni_plane *plane, uint32_t vertex) {
    const float *p = qni_flat_place(flat, vertex);
    const double at[3] = {(double)p[0], (double)p[1], (double)p[2]};
    return dot3(plane->normal, at) - plane->height;
}

static bool belongs(const growth *g, uint32_t t) {
    const qni_flat *flat = g->flat;
    const uint32_t *c = flat->corners + 3 * (size_t)t;
    for (int n = 0; n < 3; ++n)
        if (!(fabs(height_over(flat, &g->plane, c[n])) <= flat->near))
            return false;
    return qni_orient2d(qni_flat_place(flat, c[0]), qni_flat_place(flat, c[1]),
                        qni_flat_place(flat, c[2]), g->plane.x, g->plane.y) > 0;
}

/* From all that was found to the neighbours in the plane. */
static void spread(growth *g) {
    qni_flat *flat = g->flat;
    const int32_t *owners = flat->mesh->triangle_owners;
    for (int64_t n = 0; n < g->count; ++n)
        for (uint32_t h = 3 * g->found[n]; h < 3 * g->found[n] + 3; ++h) {
            const uint32_t twin = flat->twins[h], t = twin / 3;
            if (twin == QN_NO_HALFEDGE || flat->creased[h] || flat->regions[t] != QNI_NO_REGION ||
                owners[t] != owners[g->found[n]] || !belongs(g, t))
                continue;
            flat->regions[t] = g->region;
            g->found[g->count++] = t;
        }
}

/* Least squares along the axis that the plane faces most: a x + b y + c, about the first corner. */
static bool fit_plane(const growth *g, qni_plane *plane) {
    const qni_flat *flat = g->flat;
    const int x = g->plane.x, y = g->plane.y, z = 3 - x - y;
    const float *o = qni_flat_place(flat, flat->corners[3 * (size_t)g->found[0]]);
    double sums[9] = {0}; /* 1, u, v, uu, uv, vv, w, uw, vw */
    for (int64_t n = 0; n < g->count; ++n)
        for (int k = 0; k < 3; ++k) {
            const float *p =
                qni_flat_place(flat, flat->corners[3 * (size_t)g->found[n] + (size_t)k]);
            const double u = (double)p[x] - (double)o[x], v = (double)p[y] - (double)o[y],
                         w = (double)p[z] - (double)o[z];
            const double terms[9] = {1, u, v, u * u, u * v, v * v, w, u * w, v * w};
            for (int i = 0; i < 9; ++i)
                sums[i] += terms[i];
        }
    const double one = sums[0], mu = sums[1] / one, mv = sums[2] / one, mw = sums[6] / one;
    const double uu = sums[3] - one * mu * mu, uv = sums[4] - one * mu * mv,
                 vv = sums[5] - one * mv * mv, uw = sums[7] - one * mu * mw,
                 vw = sums[8] - one * mv * mw;
    const double whole = uu * vv - uv * uv;
    if (!(whole > 1e-12 * (uu + vv) * (uu + vv)))
        return false;
    const double a = (uw * vv - vw * uv) / whole, b = (vw * uu - uw * uv) / whole;
    const double sign = g->plane.normal[z] > 0 ? 1 : -1;
    double normal[3], through[3];
    normal[x] = -a * sign;
    normal[y] = -b * sign;
    normal[z] = sign;
    through[x] = (double)o[x] + mu;
    through[y] = (double)o[y] + mv;
    through[z] = (double)o[z] + mw;
    memset(plane, 0, sizeof *plane);
    aim_plane(plane, normal, sqrt(dot3(normal, normal)), through);
    return true;
}

static bool all_belong(const growth *g) {
    for (int64_t n = 0; n < g->count; ++n)
        if (!belongs(g, g->found[n]))
            return false;
    return true;
}

static void grow(growth *g, uint32_t seed) {
    g->found[0] = seed;
    g->count = 1;
    g->flat->regions[seed] = g->region;
    int64_t before = 0;
    for (int fit = 0; fit < MOST_FITS && g->count > before; ++fit) {
        const qni_plane last = g->plane;
        if (fit > 0 && (!fit_plane(g, &g->plane) || !all_belong(g))) {
            g->plane = last;
            return;
        }
        before = g->count;
        spread(g);
    }
}

static bool add_plane(qni_flat *flat, const qni_plane *plane) {
    if (flat->plane_count == flat->plane_room) {
        const int64_t room = flat->plane_room ? 2 * flat->plane_room : 64;
        void *grown =
            qni_realloc(flat->context, flat->planes, flat->plane_room, room, sizeof *flat->planes);
        if (!grown)
            return false;
        flat->planes = grown;
        flat->plane_room = room;
    }
    flat->planes[flat->plane_count++] = *plane;
    return true;
}

/* The triangles whose planes do not hang on how their corners were rounded, the best known first:
 * by their least heights in powers of two. How many. */
static int64_t order_seeds(const qni_flat *flat, uint8_t *class, uint32_t *seeds) {
    int64_t start[CLASSES + 1] = {0};
    for (uint32_t t = 0; t < flat->triangles; ++t) {
        double normal[3];
        const double heights = normal_of(flat, t, normal) / flat->near;
        const int power = heights > 1 ? ilogb(heights) : 0;
        class[t] =
            (uint8_t)(power < LEAST_POWER              ? CLASSES
                      : power >= LEAST_POWER + CLASSES ? 0
                                                       : CLASSES - 1 - (power - LEAST_POWER));
        if (class[t] < CLASSES)
            ++start[class[t] + 1];
    }
    for (int n = 0; n < CLASSES; ++n)
        start[n + 1] += start[n];
    const int64_t count = start[CLASSES];
    for (uint32_t t = 0; t < flat->triangles; ++t)
        if (class[t] < CLASSES)
            seeds[start[class[t]]++] = t;
    return count;
}

/* Regions of one triangle are none. */
static bool grow_all(growth *g, const uint32_t *seeds, int64_t count) {
    qni_flat *flat = g->flat;
    for (int64_t s = 0; s < count; ++s) {
        if (flat->regions[seeds[s]] != QNI_NO_REGION)
            continue;
        g->region = (uint32_t)flat->plane_count;
        plane_of_triangle(flat, seeds[s], &g->plane);
        grow(g, seeds[s]);
        g->plane.owner = flat->mesh->triangle_owners[seeds[s]];
        if (g->count == 1)
            flat->regions[seeds[s]] = QNI_NO_REGION;
        else if (!add_plane(flat, &g->plane))
            return false;
    }
    return true;
}

qn_status qni_flat_find_regions(qni_flat *flat, qn_error *error) {
    const int64_t count = flat->triangles;
    growth g = {.flat = flat};
    g.found = qni_alloc(flat->context, count, sizeof *g.found);
    uint32_t *seeds = qni_alloc(flat->context, count, sizeof *seeds);
    uint8_t *class = qni_alloc(flat->context, count, sizeof *class);
    memset(flat->regions, 0xff, (size_t)count * sizeof *flat->regions);
    const bool good =
        g.found && seeds && class && grow_all(&g, seeds, order_seeds(flat, class, seeds));
    qni_free(flat->context, class, count, sizeof *class);
    qni_free(flat->context, seeds, count, sizeof *seeds);
    qni_free(flat->context, g.found, count, sizeof *g.found);
    return good ? QN_OK : qni_fail_memory(error, "the flat parts");
}
