// SPDX-License-Identifier: MIT
/* Any bytes as glTF, binary or text. */
#include "fuzz/fuzz_mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_mesh_read("gltf", bytes, size);
}
