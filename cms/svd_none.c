// SPDX-License-Identifier: MIT
/* Built without LAPACKE: surfaces of solids end with a sentence before this is reached. */
#include "cms/cms.h"

bool qni_solve_planes(double *rows, double *heights, int32_t count, int32_t rank,
                      double solution[3]) {
    (void)rows, (void)heights, (void)count, (void)rank;
    for (int k = 0; k < 3; ++k)
        solution[k] = 0;
    return false;
}
