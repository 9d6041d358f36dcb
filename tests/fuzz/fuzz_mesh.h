// SPDX-License-Identifier: MIT
/* What the targets of the mesh readers share: bytes go through a file in memory into
 * qn_mesh_read(). */
#ifndef TEST_FUZZ_MESH_H
#define TEST_FUZZ_MESH_H

#include <stddef.h>
#include <stdint.h>

/* Aborts when a mesh that was read names a vertex it lacks, when an error has no sentence, when a
 * failure leaves a mesh, or when memory is not given back. */
int fuzz_mesh_read(const char *format, const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

#endif
