// SPDX-License-Identifier: MIT
/* Any bytes as .vm files. */
#include "fuzz/fuzz_solid.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_solid_read("x.vm", bytes, size);
}
