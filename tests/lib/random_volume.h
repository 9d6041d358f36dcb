// SPDX-License-Identifier: MIT
/* Random fields of the kinds on which surfacers are known to fail. */
#ifndef TEST_RANDOM_VOLUME_H
#define TEST_RANDOM_VOLUME_H

#include "lib/test_volume.h"

typedef enum test_kind {
    TEST_GAUSSIAN,
    TEST_HEAVY_TAILED,   /* fifth powers: neighbours differ by orders of magnitude */
    TEST_SMALL_INTEGERS, /* -2..2 round the iso-value: samples on it, tied faces */
    TEST_CHECKERBOARD,   /* every face ambiguous */
    TEST_SMOOTHED_NOISE, /* what scans look like */
    TEST_BINARY,         /* labels 0 and 1, iso-value one half: every ambiguous face tied */
    TEST_THOUSAND,       /* 1000 +- 1 in floats: cancellation when the iso-value is taken off */
    TEST_SYMMETRIC,      /* +-1 and +-2: ties that are not at zero */
    TEST_NEAR_TIES,      /* +-1 less a few units in the last place: products that round alike */
    TEST_SPARSE,         /* a few specks in nothing: leaves without neighbours */
    TEST_KIND_COUNT
} test_kind;

const char *test_kind_name(test_kind kind);
/* One sample's distance from the iso-value for the kinds without memory of neighbours. */
double test_random_sample(test_random *random, test_kind kind);
/* Fills the values and sets the iso-value and the name. */
void test_random_fill(test_field *field, test_random *random, test_kind kind);
/* A field of random size (2 to largest), side, border rule and, half of the time, matrix; prepared.
 */
test_field test_random_field(test_random *random, test_kind kind, int64_t largest);

#endif
