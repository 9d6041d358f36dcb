// SPDX-License-Identifier: MIT
/* The 15 cases of marching cubes [Lorensen and Cline 1987, figure 3], from the signs at a cell's
 * corners: equal up to the 24 turns of the cube and to changing all signs. */
#ifndef BENCH_CMS_CASES_H
#define BENCH_CMS_CASES_H

enum { CASES = 15 };
/* signs: bit c is set when corner c = x + 2 y + 4 z is inside. */
int marching_cubes_case(int signs);

#endif
