// SPDX-License-Identifier: MIT
/* The surface near a guess: features of curved surfaces are met again with tangents taken close to
 * them. */
#include "cms/cms.h"

#include <math.h>
#include <string.h>

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

/* Values alone, in one batch: a fraction of what tangents cost that are taken again and again. */
bool qni_flat_pieces_meet(const qn_solid *solid, const double point[3], int32_t count,
                          const double (*from)[3], double tolerance) {
    enum { MOST = 16 };
    static const double shares[2] = {0.9, 0.99};
    double points[1 + 2 * MOST][3], values[1 + 2 * MOST], gradient[3], slope = 0;
    if (count > MOST)
        return false;
    memcpy(points[0], point, sizeof points[0]);
    for (int32_t n = 0; n < 2 * count; ++n)
        for (int k = 0; k < 3; ++k)
            points[1 + n][k] = from[n / 2][k] + shares[n % 2] * (point[k] - from[n / 2][k]);
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
