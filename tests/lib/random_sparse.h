// SPDX-License-Identifier: MIT
/* Random sparse volumes, and the dense grid of the same values. */
#ifndef TEST_RANDOM_SPARSE_H
#define TEST_RANDOM_SPARSE_H

#include "lib/random_volume.h"

typedef struct test_sparse {
    qn_sparse_grid grid; /* its arrays are owned */
    double iso;
    int64_t low[3], high[3]; /* blocks of 8^3 samples with leaves or tiles: first, end */
} test_sparse;

/* Some leaves of samples of a kind (rounded to the type), some tiles of several sizes, the rest
 * background; all in random order, at places of either sign, with or without active masks. */
test_sparse test_random_sparse(test_random *random, test_kind kind, qn_scalar scalar,
                               int64_t largest_blocks);
void test_sparse_free(test_sparse *sparse);

/* The value at a sample, found by looking at every leaf and tile. */
double test_sparse_value(const test_sparse *sparse, int64_t i, int64_t j, int64_t k);

/* The dense grid of all samples from one block below the box to one above it, with the sample after
 * that; its samples are to be freed. */
qn_grid test_sparse_dense(const test_sparse *sparse);

#endif
