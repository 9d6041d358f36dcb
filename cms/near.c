// SPDX-License-Identifier: MIT
/* The surface near a guess: features of curved surfaces are met again with tangents taken close to
 * them. */
#include "cms/cms.h"
#include "cms/vector.h"

#include <math.h>
#include <string.h>

/* Parts of the way to where flat pieces meet. */
static const double ways[2] = {0.9, 0.99};

bool qni_surface_near(const qn_solid *solid, const double point[3], const double direction[3],
                      const double normal[3], double reach, double at_out[3],
                      double normal_out[3]) {
    qni_crossing found[8];
    int32_t count = 0;
    double a[3], b[3], best = 2;
    for (int k = 0; k < 3; ++k) {
        a[k] = point[k] - reach * direction[k];
        b[k] = point[k] + reach * direction[k];
    }
    if (solid->ops->crossings(solid, a, b, 8, found, &count) != QN_OK)
        return false;
    for (int32_t n = 0; n < count && n < 8; ++n) {
        const double *m = found[n].normal;
        const double length = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
        const double along =
            (m[0] * normal[0] + m[1] * normal[1] + m[2] * normal[2]) / (length > 0 ? length : 1);
        if (!(along > 0.8) || !(fabs(found[n].at - 0.5) < best))
            continue;
        best = fabs(found[n].at - 0.5);
        for (int k = 0; k < 3; ++k) {
            at_out[k] = a[k] + found[n].at * (b[k] - a[k]);
            normal_out[k] = m[k] / length;
        }
    }
    return best < 2;
}

bool qni_is_on_surface(const qn_solid *solid, const double point[3], double tolerance) {
    double value, gradient[3], distance;
    int32_t owner;
    if (solid->ops->distance && solid->ops->distance(solid, point, tolerance, &distance))
        return distance <= tolerance;
    if (qni_solid_first_order(solid, point, &value, gradient, &owner) != QN_OK)
        return false;
    return value == 0 || fabs(value) <= tolerance * sqrt(qni_dot3(gradient, gradient));
}

/* One after the other, where distances are known: most that do not meet show it at once. */
static bool pieces_are_flat(const qn_solid *solid, const double point[3], int32_t count,
                            const double (*from)[3], double tolerance, bool *flat) {
    double distance;
    *flat = true;
    for (int32_t n = -1; n < 2 * count && *flat; ++n) {
        double at[3];
        for (int k = 0; k < 3; ++k)
            at[k] = n < 0 ? point[k] : from[n / 2][k] + ways[n % 2] * (point[k] - from[n / 2][k]);
        if (!solid->ops->distance(solid, at, tolerance, &distance))
            return false;
        *flat = distance <= tolerance;
    }
    return true;
}

/* Values alone, in one batch: a fraction of what tangents cost that are taken again and again. */
bool qni_flat_pieces_meet(const qn_solid *solid, const double point[3], int32_t count,
                          const double (*from)[3], double tolerance) {
    enum { MOST = 16 };
    double points[1 + 2 * MOST][3], values[1 + 2 * MOST], gradient[3], slope = 0;
    bool flat;
    if (count > MOST)
        return false;
    if (solid->ops->distance && pieces_are_flat(solid, point, count, from, tolerance, &flat))
        return flat;
    memcpy(points[0], point, sizeof points[0]);
    for (int32_t n = 0; n < 2 * count; ++n)
        for (int k = 0; k < 3; ++k)
            points[1 + n][k] = from[n / 2][k] + ways[n % 2] * (point[k] - from[n / 2][k]);
    if (solid->ops->values(solid, 1 + 2 * count, (const double(*)[3])points, values) != QN_OK ||
        solid->ops->gradients(solid, 1, (const double(*)[3])points, (double(*)[3])gradient, NULL) !=
            QN_OK)
        return false;
    for (int k = 0; k < 3; ++k)
        slope += gradient[k] * gradient[k];
    for (int32_t n = 0; n < 1 + 2 * count; ++n)
        if (!(fabs(values[n]) <= tolerance * sqrt(slope)))
            return false;
    return isfinite(slope);
}

/* Does the surface turn little by little from one tangent to another? Where the way is halved again
 * and again, what a crease turns stays in one half. */
static bool turns_smoothly(const qn_solid *solid, const double at[2][3], const double normal[2][3],
                           double crease_cosine) {
    enum { HALVINGS = 8 };
    double ends[2][3], normals[2][3];
    memcpy(ends, at, sizeof ends);
    memcpy(normals, normal, sizeof normals);
    for (int step = 0; step < HALVINGS; ++step) {
        double middle[3], across[3], found[3], turned[3], likeness[2] = {0, 0}, length = 0, all = 0;
        for (int k = 0; k < 3; ++k) {
            middle[k] = 0.5 * (ends[0][k] + ends[1][k]);
            across[k] = normals[0][k] + normals[1][k];
            length += (ends[1][k] - ends[0][k]) * (ends[1][k] - ends[0][k]);
            all += across[k] * across[k];
        }
        for (int k = 0; k < 3; ++k)
            across[k] /= sqrt(all);
        if (!(length > 0) ||
            !qni_surface_near(solid, middle, across, across, 0.6 * sqrt(length), found, turned))
            return false;
        for (int n = 0; n < 2; ++n)
            for (int k = 0; k < 3; ++k)
                likeness[n] += turned[k] * normals[n][k];
        const int smooth = likeness[0] > likeness[1] ? 0 : 1; /* the crease is not on this side */
        if (likeness[1 - smooth] >= crease_cosine)
            return true;
        memcpy(ends[smooth], found, sizeof found);
        memcpy(normals[smooth], turned, sizeof turned);
    }
    return false;
}

bool qni_surface_along(const qn_solid *solid, const double at[3], const double normal[3],
                       const double target[3], const double direction[3], double reach,
                       double crease_cosine, double at_out[3], double normal_out[3]) {
    double ends[2][3], normals[2][3], likeness = 0;
    if (!qni_surface_near(solid, target, direction, normal, reach, ends[1], normals[1]))
        return false;
    memcpy(ends[0], at, sizeof ends[0]);
    memcpy(normals[0], normal, sizeof normals[0]);
    for (int k = 0; k < 3; ++k)
        likeness += normals[0][k] * normals[1][k];
    if (likeness < crease_cosine && !turns_smoothly(solid, (const double(*)[3])ends,
                                                    (const double(*)[3])normals, crease_cosine))
        return false;
    memcpy(at_out, ends[1], sizeof ends[1]);
    memcpy(normal_out, normals[1], sizeof normals[1]);
    return true;
}
