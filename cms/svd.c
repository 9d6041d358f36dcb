// SPDX-License-Identifier: MIT
/* The point that lies on planes as well as can be [CMS05 3.4], by singular value decomposition
 * (LAPACKE, double). */
#include "cms/cms.h"

#include <lapacke.h>
#include <math.h>

bool qni_solve_planes(double *rows, double *heights, int32_t count, int32_t rank,
                      double solution[3]) {
    double singular[3] = {0, 0, 0}, u_unused[1], turned[9], superb[3];
    const int32_t values = count < 3 ? count : 3;
    double products[3] = {0, 0, 0};
    /* With A = U S V^T the solution of least norm is V S^-1 U^T b = V S^-2 V^T A^T b; only V and S
     * are needed. */
    for (int32_t n = 0; n < count; ++n)
        for (int k = 0; k < 3; ++k)
            products[k] += rows[3 * n + k] * heights[n];
    if (LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', count, 3, rows, 3, singular, u_unused, 1, turned,
                       3, superb) != 0)
        return false;
    for (int k = 0; k < 3; ++k)
        solution[k] = 0;
    rank = rank < values ? rank : values;
    for (int32_t n = 0; n < rank; ++n) {
        if (!(singular[n] > 1e-4 * singular[0]))
            break;
        const double *v = turned + 3 * n;
        const double along = (v[0] * products[0] + v[1] * products[1] + v[2] * products[2]) /
                             (singular[n] * singular[n]);
        for (int k = 0; k < 3; ++k)
            solution[k] += along * v[k];
    }
    return isfinite(solution[0]) && isfinite(solution[1]) && isfinite(solution[2]);
}
