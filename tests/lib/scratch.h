// SPDX-License-Identifier: MIT
/* A folder of a test's own, made in the temporary folder and removed at the end. */
#ifndef TEST_SCRATCH_H
#define TEST_SCRATCH_H

#include <stddef.h>

typedef struct test_scratch {
    char folder[256];
} test_scratch;

void test_scratch_make(test_scratch *scratch);
/* The path of a file in it, in one of a few buffers that are used in turn. */
const char *test_scratch_path(const test_scratch *scratch, const char *name);
/* How many files lie there; temporary ones are counted too. */
int test_scratch_count(const test_scratch *scratch);
void test_scratch_remove(test_scratch *scratch);

/* Write and read whole files, failing the test when that cannot be done. */
void test_put_file(const char *path, const void *bytes, size_t size);
/* To be freed with free(); a zero byte stands behind the last one. */
char *test_get_file(const char *path, size_t *size_out);

#endif
