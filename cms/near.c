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
