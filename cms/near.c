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
                      const double normal[3], double reach, qni_tangent *out) {
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
            out->at[k] = a[k] + found[n].at * (b[k] - a[k]);
            out->normal[k] = m[k] / length;
        }
        out->owner = found[n].owner;
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
static bool turns_smoothly(const qn_solid *solid, const qni_tangent *from, const qni_tangent *to,
                           double crease_cosine) {
    enum { HALVINGS = 8 };
    qni_tangent ends[2] = {*from, *to};
    for (int step = 0; step < HALVINGS; ++step) {
        double middle[3], across[3], likeness[2] = {0, 0}, length = 0, all = 0;
        qni_tangent found;
        for (int k = 0; k < 3; ++k) {
            middle[k] = 0.5 * (ends[0].at[k] + ends[1].at[k]);
            across[k] = ends[0].normal[k] + ends[1].normal[k];
            length += (ends[1].at[k] - ends[0].at[k]) * (ends[1].at[k] - ends[0].at[k]);
            all += across[k] * across[k];
        }
        for (int k = 0; k < 3; ++k)
            across[k] /= sqrt(all);
        if (!(length > 0) ||
            !qni_surface_near(solid, middle, across, across, 0.6 * sqrt(length), &found))
            return false;
        for (int n = 0; n < 2; ++n)
            for (int k = 0; k < 3; ++k)
                likeness[n] += found.normal[k] * ends[n].normal[k];
        const int smooth = likeness[0] > likeness[1] ? 0 : 1; /* the crease is not on this side */
        if (likeness[1 - smooth] >= crease_cosine)
            return true;
        ends[smooth] = found;
    }
    return false;
}

bool qni_surface_along(const qn_solid *solid, const qni_cms_settings *settings,
                       const qni_tangent *from, const double target[3], const double direction[3],
                       double reach, qni_tangent *out) {
    qni_tangent to;
    double likeness = 0;
    if (!qni_surface_near(solid, target, direction, from->normal, reach, &to))
        return false;
    for (int k = 0; k < 3; ++k)
        likeness += from->normal[k] * to.normal[k];
    if (to.owner != from->owner && qni_is_crease(settings, likeness, from->owner, to.owner))
        return false;
    if (likeness < settings->crease_cosine &&
        !turns_smoothly(solid, from, &to, settings->crease_cosine))
        return false;
    *out = to;
    return true;
}
