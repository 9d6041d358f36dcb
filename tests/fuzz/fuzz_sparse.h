// SPDX-License-Identifier: MIT
/* What the fuzz targets of OpenVDB and NanoVDB files share: any bytes must end in a volume, whose
 * surface can then be counted, or in one sentence; no memory may be left behind. */
#ifndef TESTS_FUZZ_FUZZ_SPARSE_H
#define TESTS_FUZZ_FUZZ_SPARSE_H

#include <qn/surface.h>
#include <qn/volume.h>

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void fuzz_check(int holds) {
    if (!holds)
        abort();
}

/* Large tiles can have a surface of many millions of quads: it is counted for small volumes. */
static inline void fuzz_use(qn_context *context, const qn_volume *volume) {
    qn_volume_statistics statistics;
    qn_sparse_info info;
    qn_surface_options options;
    qn_error error;
    fuzz_check(qn_volume_get_statistics(context, volume, &statistics, NULL) == QN_OK);
    fuzz_check(qn_volume_sparse_info(context, volume, &info, NULL) == QN_OK);
    qn_surface_options_init(&options);
    options.count_only = true;
    for (int a = 0; a < 3; ++a)
        if (info.high[a] - info.low[a] > 4096)
            return;
    fuzz_check(qn_surface(context, volume, &options, NULL, NULL, &error) == QN_OK);
}

static inline qn_context *fuzz_context(void) {
    qn_context_options options;
    qn_context *context;
    qn_context_options_init(&options);
    options.threads = 1;
    fuzz_check(qn_context_create(&options, &context, NULL) == QN_OK);
    return context;
}

/* What reading ended with; ends the context. */
static inline void fuzz_finish(qn_context *context, qn_status status, qn_volume *volume,
                               const qn_error *error) {
    if (status == QN_OK)
        fuzz_use(context, volume);
    else
        fuzz_check(volume == NULL && error->status == status && error->message[0]);
    qn_volume_destroy(volume);
    fuzz_check(qn_context_memory(context).current_bytes == 0);
    qn_context_destroy(context);
}

#endif
