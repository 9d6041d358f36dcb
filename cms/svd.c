// SPDX-License-Identifier: MIT
/* The point that lies on planes as well as can be [CMS05 3.4], by singular value decomposition
 * (LAPACKE, double). */
#include "cms/cms.h"

#include <lapacke.h>
#include <math.h>

enum { WORK = 1024 };

/* V and S of A = U S V^T. Rows of A are columns of A^T, as LAPACK has them: nothing is turned, and
 * what V is there, U is here. */
static bool decompose(double *rows, int32_t count, double singular[3], double v[9]) {
    double unused[1], work[WORK];
    if (count + 16 > WORK) /* of a coarse cell beside very fine ones */
        return LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'A', 'N', 3, count, rows, 3, singular, v, 3, unused,
                              1, work) == 0;
    return LAPACKE_dgesvd_work(LAPACK_COL_MAJOR, 'A', 'N', 3, count, rows, 3, singular, v, 3,
                               unused, 1, work, WORK) == 0;
}

bool qni_solve_planes(double *rows, double *heights, int32_t count, int32_t rank,
                      double solution[3]) {
    double singular[3] = {0, 0, 0}, turned[9];
    const int32_t values = count < 3 ? count : 3;
    double products[3] = {0, 0, 0};
    /* With A = U S V^T the solution of least norm is V S^-1 U^T b = V S^-2 V^T A^T b; only V and S
     * are needed. */
    for (int32_t n = 0; n < count; ++n)
        for (int k = 0; k < 3; ++k)
            products[k] += rows[3 * n + k] * heights[n];
    if (!decompose(rows, count, singular, turned))
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
