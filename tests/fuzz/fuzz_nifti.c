// SPDX-License-Identifier: MIT
/* Any bytes as NIfTI files, versions 1 and 2. */
#include "fuzz_volume.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    strcpy(options.format, "nifti");
    fuzz_volume("x.nii", data, size, &options, false);
    return 0;
}
