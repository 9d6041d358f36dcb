// SPDX-License-Identifier: MIT
/* Roots of polynomials on a segment, and crossings made to agree with the signs at its ends. */
#ifndef QNI_SOLID_POLYNOMIAL_H
#define QNI_SOLID_POLYNOMIAL_H

#include "solid/node.h"

/* The places where c[0] + c[1] t + ... + c[degree] t^degree changes sign between low and high,
 * ascending; degree at most 4. */
int qni_polynomial_roots(int degree, const double c[5], double low, double high, double roots[4]);

/* Crossings of a line, ascending, as they were computed, become those of the segment 0 to 1:
 * whatever rounding did near the ends, their number is odd exactly when the ends differ. Crossings
 * beyond the ends are dropped, those that must be there come to the end. The new number is
 * returned; it may be one more than `count` when that was 0. */
int qni_match_ends(double *places, int count, bool inside_at_0, bool inside_at_1);

#endif
