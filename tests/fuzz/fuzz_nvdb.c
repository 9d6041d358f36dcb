// SPDX-License-Identifier: MIT
/* Any bytes as NanoVDB files. A flipped bit in packed data is mostly found by the codec: the corpus
 * holds a plain one, too. */
#include "fuzz_sparse.h"
#include "volume/load.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    qn_volume_read_options options;
    qn_volume *volume;
    qn_error error = {QN_OK, ""};
    qn_context *context = fuzz_context();
    qn_volume_read_options_init(&options);
    strcpy(options.format, "nvdb");
    const qn_status status =
        qni_volume_read_memory(context, "x.nvdb", data, (int64_t)size, &options, &volume, &error);
    fuzz_finish(context, status, volume, &error);
    return 0;
}
