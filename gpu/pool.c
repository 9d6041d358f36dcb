// SPDX-License-Identifier: MIT
/* Device memory that stays from call to call. */
#include "gpu/device.h"

qn_status qni_gpu_reserve(qni_gpu_pool *pool, qni_gpu_buffer buffer, int64_t bytes, void **out,
                          qn_error *error) {
    *out = NULL;
    if (bytes > pool->bytes[buffer]) {
        if (pool->memory[buffer])
            pool->device->free(pool->device, pool->memory[buffer]);
        pool->memory[buffer] = NULL;
        pool->bytes[buffer] = 0;
        const qn_status status =
            pool->device->alloc(pool->device, bytes, &pool->memory[buffer], error);
        pool->is_full = status == QN_ERROR_OUT_OF_MEMORY;
        if (status != QN_OK)
            return status;
        pool->bytes[buffer] = bytes;
    }
    pool->used[buffer] = bytes;
    *out = pool->memory[buffer];
    return QN_OK;
}

qn_status qni_gpu_reserve_parts(qni_gpu_pool *pool, qni_gpu_buffer buffer, qni_gpu_part *parts,
                                int count, qn_error *error) {
    int64_t bytes = 0;
    void *memory;
    for (int n = 0; n < count; ++n)
        bytes += (parts[n].count * (int64_t)parts[n].size + 255) / 256 * 256;
    const qn_status status = qni_gpu_reserve(pool, buffer, bytes, &memory, error);
    for (int n = 0; n < count && status == QN_OK; ++n) {
        parts[n].memory = memory;
        memory = (char *)memory + (parts[n].count * (int64_t)parts[n].size + 255) / 256 * 256;
    }
    return status;
}

void qni_gpu_pool_free(qni_gpu_pool *pool) {
    for (int n = 0; n < QNI_GPU_BUFFER_COUNT; ++n) {
        if (pool->memory[n])
            pool->device->free(pool->device, pool->memory[n]);
        pool->memory[n] = NULL;
        pool->bytes[n] = pool->used[n] = 0;
    }
}
