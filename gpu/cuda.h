// SPDX-License-Identifier: MIT
/* The current CUDA device, opened; cuda.cu. No CUDA header is needed here. */
#ifndef QNI_GPU_CUDA_H
#define QNI_GPU_CUDA_H

#include "gpu/device.h"

#ifdef __cplusplus
extern "C" {
#endif

#define QNI_CUDA_TRY(call)                                                                         \
    do {                                                                                           \
        const qn_status qni_cuda_status_ = (call);                                                 \
        if (qni_cuda_status_ != QN_OK)                                                             \
            return qni_cuda_status_;                                                               \
    } while (0)

/* `stream` is a cudaStream_t, NULL for the default one. QN_ERROR_UNSUPPORTED with the reason where
 * there is no device that can be used. */
qn_status qni_cuda_open(void *stream, qni_device **device_out, qn_error *error);
void qni_cuda_close(qni_device *device);
/* Its name and size, in words. */
qn_status qni_cuda_describe(qni_device *device, char text[128], qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
