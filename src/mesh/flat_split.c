// SPDX-License-Identifier: MIT
/* Small polygons of flat regions into triangles, by exact signs. */
#include "mesh/flat_parts.h"
#include "mesh/predicates.h"

#include <math.h>
#include <string.h>

enum { LEAST_HEIGHTS = 4 };

static int turn(const qni_flat *flat, const qni_plane *plane, uint32_t a, uint32_t b, uint32_t c) {
    return qni_orient2d(qni_flat_place(flat, a), qni_flat_place(flat, b), qni_flat_place(flat, c),
                        plane->x, plane->y);
}

bool qni_flat_is_good(const qni_flat *flat, const qni_plane *plane, uint32_t a, uint32_t b,
                      uint32_t c, double *worst) {
    const float *p[3] = {qni_flat_place(flat, a), qni_flat_place(flat, b), qni_flat_place(flat, c)};
    double side[3][3], squares[3], cross[3], longest = 0;
    if (turn(flat, plane, a, b, c) <= 0)
        return false;
    for (int n = 0; n < 3; ++n) {
        squares[n] = 0;
        for (int k = 0; k < 3; ++k) {
            side[n][k] = (double)p[(n + 1) % 3][k] - (double)p[n][k];
            squares[n] += side[n][k] * side[n][k];
        }
        longest = fmax(longest, squares[n]);
    }
    double area = 0;
    for (int k = 0; k < 3; ++k) {
        cross[k] = side[0][(k + 1) % 3] * side[1][(k + 2) % 3] -
                   side[0][(k + 2) % 3] * side[1][(k + 1) % 3];
        area += cross[k] * cross[k];
    }
    area = sqrt(area);
    if (!(area > LEAST_HEIGHTS * flat->near * sqrt(longest)))
        return false;
    *worst = -1;
    for (int n = 0; n < 3; ++n) {
        const int m = (n + 2) % 3;
        const double along =
            -(side[n][0] * side[m][0] + side[n][1] * side[m][1] + side[n][2] * side[m][2]);
        *worst = fmax(*worst, along / sqrt(squares[n] * squares[m]));
    }
    return true;
}

/* Is a corner so near the segment between two others that with it they make no good triangle? */
static bool is_near_segment(const qni_flat *flat, uint32_t vertex, uint32_t from, uint32_t to) {
    const float *p = qni_flat_place(flat, vertex), *a = qni_flat_place(flat, from),
                *b = qni_flat_place(flat, to);
    double way[3], off[3], along = 0, length = 0, square = 0;
    for (int k = 0; k < 3; ++k) {
        way[k] = (double)b[k] - (double)a[k];
        off[k] = (double)p[k] - (double)a[k];
        along += way[k] * off[k];
        length += way[k] * way[k];
        square += off[k] * off[k];
    }
    const double most = LEAST_HEIGHTS * flat->near;
    return along > 0 && along < length && square - along * along / length <= most * most;
}

/* Does a corner of the polygon lie in a triangle of three others, or on its sides; so near the new
 * one, from t[0] to t[2], that it would be left without a triangle? */
static bool holds_corner(const qni_flat *flat, const qni_plane *plane, const uint32_t *polygon,
                         int count, const uint32_t t[3]) {
    for (int n = 0; n < count; ++n) {
        const uint32_t v = polygon[n];
        if (v == t[0] || v == t[1] || v == t[2])
            continue;
        if (is_near_segment(flat, v, t[0], t[2]) ||
            (turn(flat, plane, t[0], t[1], v) >= 0 && turn(flat, plane, t[1], t[2], v) >= 0 &&
             turn(flat, plane, t[2], t[0], v) >= 0))
            return true;
    }
    return false;
}

static int best_ear(const qni_flat *flat, const qni_plane *plane, const uint32_t *polygon,
                    int count) {
    int best = -1;
    double least = 2;
    for (int n = 0; n < count; ++n) {
        const uint32_t t[3] = {polygon[(n + count - 1) % count], polygon[n],
                               polygon[(n + 1) % count]};
        double worst;
        if (!qni_flat_is_good(flat, plane, t[0], t[1], t[2], &worst) || worst >= least ||
            holds_corner(flat, plane, polygon, count, t) ||
            (count > 3 && qni_flat_joined(flat, t[0], t[2])))
            continue;
        best = n;
        least = worst;
    }
    return best;
}

bool qni_flat_split(const qni_flat *flat, const qni_plane *plane, const uint32_t *polygon,
                    int count, uint32_t (*triangles)[3]) {
    uint32_t rest[QNI_FLAT_MOST];
    memcpy(rest, polygon, (size_t)count * sizeof *rest);
    for (int made = 0; count >= 3; ++made, --count) {
        const int ear = best_ear(flat, plane, rest, count);
        if (ear < 0)
            return false;
        triangles[made][0] = rest[(ear + count - 1) % count];
        triangles[made][1] = rest[ear];
        triangles[made][2] = rest[(ear + 1) % count];
        memmove(rest + ear, rest + ear + 1, (size_t)(count - ear - 1) * sizeof *rest);
    }
    return true;
}
