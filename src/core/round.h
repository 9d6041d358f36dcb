// SPDX-License-Identifier: MIT
/* Rounding a double to a float that stays rounded. */
#ifndef QNI_CORE_ROUND_H
#define QNI_CORE_ROUND_H

/* (double)(float)value. GCC 12 drops the two conversions where it vectorizes pairs of them (-O3),
 * which breaks what is exact about lattice planes; through memory it cannot. */
static inline double qni_rounded_to_float(double value) {
    float rounded = (float)value;
#ifdef __GNUC__
    __asm__("" : "+m"(rounded));
#endif
    return (double)rounded;
}

#endif
