// SPDX-License-Identifier: MIT
/* Any bytes as NumPy arrays. */
#include "fuzz_volume.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    strcpy(options.format, "npy");
    fuzz_volume("x.npy", data, size, &options, false);
    return 0;
}
