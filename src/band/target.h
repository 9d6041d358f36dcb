// SPDX-License-Identifier: MIT
/* What a band is of: the field itself, or the surface at an offset, or a wall round that. */
#ifndef QNI_BAND_TARGET_H
#define QNI_BAND_TARGET_H

#include <qn/band.h>

#include <math.h>

typedef struct qni_band_target {
    double offset;
    double half_shell; /* negative: no shell */
} qni_band_target;

static inline qni_band_target qni_band_target_of(const qn_band_options *options) {
    const qni_band_target target = {options->offset, options->shell > 0 ? options->shell / 2 : -1};
    return target;
}

static inline double qni_band_value(const qni_band_target *target, double field) {
    const double shifted = field - target->offset;
    return target->half_shell < 0 ? shifted : fabs(shifted) - target->half_shell;
}

/* The range of what the band is of where the field runs from `low` to `high`. */
static inline void qni_band_range(const qni_band_target *target, double low, double high,
                                  double range[2]) {
    low -= target->offset;
    high -= target->offset;
    range[0] = low;
    range[1] = high;
    if (target->half_shell < 0)
        return;
    const bool straddles = low <= 0 && high >= 0;
    range[0] = (straddles ? 0 : fmin(fabs(low), fabs(high))) - target->half_shell;
    range[1] = fmax(fabs(low), fabs(high)) - target->half_shell;
}

#endif
