// SPDX-License-Identifier: MIT
/* Any bytes as .csg files. */
#include "fuzz/fuzz_solid.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_solid_read("x.csg", bytes, size);
}
