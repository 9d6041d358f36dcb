// SPDX-License-Identifier: MIT
/* A solid that counts what is asked of the one it wraps, and of what that one is restricted to. */
#ifndef BENCH_CMS_COUNTING_H
#define BENCH_CMS_COUNTING_H

#include "solid/solid.h"

typedef struct counting_tally {
    int64_t values, gradients; /* points */
    int64_t bounds, segments, restrictions;
} counting_tally;

/* For one thread only. The part is retained; NULL when memory is short. */
qn_solid *counting_create(qn_solid *part, counting_tally *tally);

#endif
