// SPDX-License-Identifier: MIT
/* Passes over all stored samples of a grid, of any type, stride and byte order, on all threads.
 * Their results are the same for every thread count: counts are integers, sums are added slice
 * after slice. */
#ifndef QNI_VOLUME_SCAN_H
#define QNI_VOLUME_SCAN_H

#include <qn/volume.h>

/* What a range pass finds; stored numbers, before slope and intercept. */
typedef struct qni_range {
    double low, high; /* of the finite samples; infinity and -infinity when there are none */
    double sum;       /* of the finite samples; may overflow to infinity */
    int64_t nan_count, infinite_count;
    bool has_fractions; /* some finite sample is no integer; judged below 2^30 */
} qni_range;

qn_status qni_scan_range(qn_context *context, const qn_grid *grid, qni_range *range_out,
                         qn_error *error);

/* Count samples into `bin_count` bins, at most QNI_LARGEST_BIN_COUNT; those beyond the ends count
 * in the first and last bin, those that are not finite nowhere. exact:  bin b holds the integer low
 * + b. Else bins are equal parts of low to high. */
enum { QNI_LARGEST_BIN_COUNT = 65536 };
typedef struct qni_bins {
    bool exact;
    double low, high;
    int64_t bin_count;
    int64_t *counts; /* of the caller */
} qni_bins;

/* `range` is what the range pass found, or NULL for integer types. */
qn_status qni_scan_bins(qn_context *context, const qn_grid *grid, const qni_range *range,
                        qni_bins *bins, qn_error *error);

#endif
