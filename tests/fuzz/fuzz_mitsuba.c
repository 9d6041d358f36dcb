// SPDX-License-Identifier: MIT
/* Any bytes as Mitsuba grids. */
#include "fuzz_volume.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    strcpy(options.format, "mitsuba");
    fuzz_volume("x.vol", data, size, &options, false);
    return 0;
}
