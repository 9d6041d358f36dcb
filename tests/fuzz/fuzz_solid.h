// SPDX-License-Identifier: MIT
/* What the targets of the solid readers share. */
#ifndef FUZZ_SOLID_H
#define FUZZ_SOLID_H

#include <stddef.h>
#include <stdint.h>

/* Read the bytes as a file of this name; what is read is asked everything once. Aborts on a broken
 * promise. */
int fuzz_solid_read(const char *name, const uint8_t *bytes, size_t size);

#endif
