// SPDX-License-Identifier: MIT
/* Products of vectors. */
#ifndef QNI_CMS_VECTOR_H
#define QNI_CMS_VECTOR_H

static inline double qni_dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void qni_cross3(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

#endif
