// SPDX-License-Identifier: MIT
/* Random volumes of every sample type, and comparing a mesh from a device with the CPU's. */
#ifndef TEST_PARITY_CASES_H
#define TEST_PARITY_CASES_H

#include <qn/surface.h>
#include "lib/random_volume.h"

extern const qn_scalar test_scalars[8];

typedef struct test_sampled {
    qn_grid grid;
    void *samples;
    double iso;
} test_sampled;

/* The field's samples in another type: integers on a scale of their own, clamped. */
test_sampled test_sample(const test_field *field, qn_scalar scalar, test_random *random);

/* Fail with the name and what differs. */
void test_expect_equal(const char *name, const char *what, const void *found, const void *expected,
                       int64_t count, size_t size);
void test_expect_number(const char *name, const char *what, int64_t found, int64_t expected);
/* All that a mesh holds. */
void test_expect_mesh(const char *name, const qn_mesh *found, const qn_mesh *expected);
void test_expect_report(const char *name, const qn_surface_report *found,
                        const qn_surface_report *expected);

qn_mesh *test_cpu_surface(qn_context *context, const qn_volume *volume,
                          const qn_surface_options *options, qn_surface_report *report);
/* All that a mesh holds, halfedges too. */
uint64_t test_hash_all(const qn_mesh *mesh);

#endif
