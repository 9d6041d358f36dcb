// SPDX-License-Identifier: MIT
/* Fields given by formulas, sampled on grids of any size, and quantised to any scalar type. */
#ifndef TEST_ANALYTIC_H
#define TEST_ANALYTIC_H

#include "lib/support.h"

typedef struct test_analytic {
    const char *name;
    /* The samples' coordinates are first + span * i / (n - 1). */
    double first, span;
    double (*value)(double x, double y, double z);
    double scale; /* of the values: about their largest near the surface, for integers */
} test_analytic;

/* "gen2" and "iwp" of [DMC21] equations (6) and (5), "sphere", "torus", "gyroid", "metaballs"; NULL
 * for no such name. */
const test_analytic *test_analytic_find(const char *name);
/* All of them, ended by a name of NULL. */
const test_analytic *test_analytic_all(void);

/* n^3 packed samples. Floats hold the value itself; integers hold the value on a scale on which 0
 * is the middle of the type's range (its iso-value, test_analytic_iso()), clamped. */
void *test_analytic_samples(const test_analytic *analytic, int64_t n, qn_scalar scalar);
double test_analytic_iso(qn_scalar scalar);
qn_volume *test_analytic_volume(qn_context *context, const test_analytic *analytic, int64_t n,
                                qn_scalar scalar, void **samples_out);

#endif
