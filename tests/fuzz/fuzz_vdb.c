// SPDX-License-Identifier: MIT
/* Any bytes as OpenVDB files. OpenVDB opens files by name: the bytes become one in memory. */
#define _GNU_SOURCE
#include "fuzz_sparse.h"

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    qn_volume_read_options options;
    qn_volume *volume;
    qn_error error = {QN_OK, ""};
    char path[64];
    const int descriptor = memfd_create("x.vdb", MFD_CLOEXEC);
    fuzz_check(descriptor >= 0 && write(descriptor, data, size) == (ssize_t)size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    qn_context *context = fuzz_context();
    qn_volume_read_options_init(&options);
    strcpy(options.format, "vdb");
    qn_status status = qn_volume_read(context, path, &options, &volume, &error);
    if (status == QN_ERROR_INVALID_ARGUMENT) { /* several grids */
        strcpy(options.grid, "ball");
        status = qn_volume_read(context, path, &options, &volume, &error);
    }
    fuzz_finish(context, status, volume, &error);
    close(descriptor);
    return 0;
}
