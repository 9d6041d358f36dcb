// SPDX-License-Identifier: MIT
/* Any bytes as GLB. */
#include "fuzz/fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_mesh_read("glb", bytes, size);
}
