// SPDX-License-Identifier: MIT
/* What every solid promises, checked at random places: bounds enclose, restriction changes nothing,
 * crossings agree with the signs, gradients with differences. */
#ifndef TEST_SOLID_CLAIMS_H
#define TEST_SOLID_CLAIMS_H

#include "lib/support.h"
#include "solid/solid.h"

typedef struct test_claims {
    double low[3], high[3]; /* where to look */
    int rounds;             /* of each kind of check */
    double slope; /* at least as steep as f gets: how small |f| must be at a crossing; 0: not
                     checked */
    bool all;     /* crossings are exact: none may be missed between samples of the segment */
    double
        difference; /* gradients against central differences: tolerance, relative; 0: not checked */
} test_claims;

/* Fails with a message that names the solid and the seed. */
void test_solid_claims(const char *name, const qn_solid *solid, const test_claims *claims,
                       test_random *random);

#endif
