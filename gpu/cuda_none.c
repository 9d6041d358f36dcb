// SPDX-License-Identifier: MIT
/* Builds without CUDA. */
#include "gpu/cuda.h"
#include "core/status.h"

qn_status qni_cuda_open(void *stream, qni_device **device_out, qn_error *error) {
    (void)stream;
    *device_out = NULL;
    return qni_fail(error, QN_ERROR_UNSUPPORTED,
                    "CUDA is not built in: install the CUDA toolkit (nvcc) and build with "
                    "-Dcuda=enabled, or take --device cpu");
}

void qni_cuda_close(qni_device *device) {
    (void)device;
}

qn_status qni_cuda_describe(qni_device *device, char text[128], qn_error *error) {
    (void)device;
    text[0] = 0;
    return qni_fail(error, QN_ERROR_UNSUPPORTED, "CUDA is not built in");
}
