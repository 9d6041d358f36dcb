// SPDX-License-Identifier: MIT
/* Thresholds that part a histogram into classes with the least variance inside each.
 * Otsu, A threshold selection method from gray-level histograms, 1979, equations 14 and 15, and
 * section III-C for more than two classes. */
#ifndef QNI_VOLUME_OTSU_H
#define QNI_VOLUME_OTSU_H

#include <stdbool.h>
#include <stdint.h>

enum { QNI_OTSU_BINS = 512 };

/* One and two thresholds of `count` bins (at most QNI_OTSU_BINS). A threshold t parts the bins at
 * their edge t, counted from 0; it lies in the middle of the empty bins there. False when less than
 * two bins are filled. With two filled bins the thresholds are all alike. */
bool qni_otsu(const int64_t *counts, int count, double *one_out, double two_out[2]);

#endif
