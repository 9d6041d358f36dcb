// SPDX-License-Identifier: MIT
/* What the fuzz targets of the volume readers share: any bytes must end in a volume or in one
 * sentence, with no memory left behind. Bytes in memory stand for every data file their header
 * names. */
#ifndef TESTS_FUZZ_FUZZ_VOLUME_H
#define TESTS_FUZZ_FUZZ_VOLUME_H

#include <qn/volume.h>
#include "volume/load.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void fuzz_check(int holds) {
    if (!holds)
        abort();
}

/* All samples are touched; `statistics` does more with them, at the price of fewer runs a second.
 */
static inline void fuzz_use(qn_context *context, const qn_volume *volume, bool statistics) {
    const qn_grid *grid = qn_volume_grid(volume);
    const unsigned char *bytes = grid->samples;
    volatile unsigned char sum = 0;
    for (int64_t at = 0; at < grid->stride[2] * grid->size[2]; ++at)
        sum = (unsigned char)(sum + bytes[at]);
    qn_volume_statistics found;
    fuzz_check(!statistics || qn_volume_get_statistics(context, volume, &found, NULL) == QN_OK);
}

static inline void fuzz_volume(const char *name, const uint8_t *data, size_t size,
                               const qn_volume_read_options *options, bool statistics) {
    qn_context_options context_options;
    qn_context_options_init(&context_options);
    context_options.threads = 1;
    qn_context *context;
    qn_volume *volume;
    qn_error error = {QN_OK, ""};
    fuzz_check(qn_context_create(&context_options, &context, NULL) == QN_OK);
    qn_status status =
        qni_volume_read_memory(context, name, data, (int64_t)size, options, &volume, &error);
    if (status == QN_OK)
        fuzz_use(context, volume, statistics);
    else
        fuzz_check(volume == NULL && error.status == status && error.message[0]);
    qn_volume_destroy(volume);
    fuzz_check(qn_context_memory(context).current_bytes == 0);
    qn_context_destroy(context);
}

#endif
