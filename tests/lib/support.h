// SPDX-License-Identifier: MIT
/* What every property and golden test needs: a seed that is printed, short or long counts, random
 * numbers, the data folder, a hash, a context. */
#ifndef TEST_SUPPORT_H
#define TEST_SUPPORT_H

#include <qn/qn.h>

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

/* splitmix64: small, seeded by any number, the same everywhere. */
typedef struct test_random {
    uint64_t state;
} test_random;

uint64_t test_random_bits(test_random *random);
double test_random_unit(test_random *random);                              /* [0, 1) */
double test_random_gaussian(test_random *random);                          /* mean 0, deviation 1 */
int64_t test_random_range(test_random *random, int64_t low, int64_t high); /* both ends included */

/* The seed from QUOIN_SEED, else a fixed one; printed so that a failure can be replayed. */
uint64_t test_seed(void);
/* True when QUOIN_LONG asks for the full counts. */
bool test_is_long(void);
int64_t test_count(int64_t short_count, int64_t long_count);

/* The path of a file of the data folder: QUOIN_DATA, else ../shared/data beside the sources. False,
 * and "skipped: ..." is printed, when the file is not there. */
bool test_data_path(const char *name, char *path, size_t capacity);

/* FNV-1a, 64 bit. Start with TEST_HASH_START. */
#define TEST_HASH_START UINT64_C(0xcbf29ce484222325)
uint64_t test_hash(uint64_t hash, const void *bytes, size_t count);
/* Of positions, normals, quads and triangles, and of their counts. */
uint64_t test_hash_mesh(const qn_mesh *mesh);

/* A context of so many threads; fails the test when it cannot be made. */
qn_context *test_context(int32_t threads);
/* Ends the context and fails the test when it still holds memory. */
void test_context_end(qn_context *context);
/* malloc that fails the test instead of returning NULL. */
void *test_alloc(size_t count, size_t size);

#endif
