// SPDX-License-Identifier: MIT
/* What the driver asks of a device: memory, copies, launches, all in one order. The GPU answers
 * through cuda.cu; in the tests the processor does, running the same kernel bodies. */
#ifndef QNI_GPU_DEVICE_H
#define QNI_GPU_DEVICE_H

#include <qn/base.h>
#include "gpu/kernels_hd.h"

typedef struct qni_device qni_device;
struct qni_device {
    void *self;
    /* Memory of the device; QN_ERROR_OUT_OF_MEMORY with a sentence when there is none left. */
    qn_status (*alloc)(qni_device *device, int64_t bytes, void **out, qn_error *error);
    void (*free)(qni_device *device, void *memory);
    int64_t (*free_bytes)(qni_device *device);
    /* Copies are ordered with launches; what is downloaded is there after finish(). */
    qn_status (*upload)(qni_device *device, void *to, const void *from, int64_t bytes,
                        qn_error *error);
    /* `rows` rows of `row_bytes` from every `stride` bytes of host memory, packed. */
    qn_status (*upload_rows)(qni_device *device, void *to, const void *from, int64_t row_bytes,
                             int64_t stride, int64_t rows, qn_error *error);
    qn_status (*download)(qni_device *device, void *to, const void *from, int64_t bytes,
                          qn_error *error);
    qn_status (*fill)(qni_device *device, void *memory, int byte, int64_t bytes, qn_error *error);
    /* At most `blocks` blocks share the kernel's items. */
    qn_status (*launch)(qni_device *device, qni_gpu_kernel kernel, const qni_gpu_args *args,
                        int64_t blocks, qn_error *error);
    /* For measuring: a copy within the device; two marks in the order of the work, and the time
     * between them once the device has finished. */
    qn_status (*copy)(qni_device *device, void *to, const void *from, int64_t bytes,
                      qn_error *error);
    qn_status (*mark)(qni_device *device, int index, qn_error *error);
    qn_status (*elapsed)(qni_device *device, double *milliseconds, qn_error *error);
    /* Wait for all that was asked for, and hear of its errors. */
    qn_status (*finish)(qni_device *device, qn_error *error);
};

/* Device memory that stays from call to call: a buffer grows when a call needs more. */
typedef enum qni_gpu_buffer {
    QNI_GPU_BUFFER_SAMPLES,
    QNI_GPU_BUFFER_BLOCKS, /* rows and runs of a sparse volume */
    QNI_GPU_BUFFER_TOTALS,
    QNI_GPU_BUFFER_KEYS, /* of its leaves that can hold surface */
    QNI_GPU_BUFFER_SIGNS,
    QNI_GPU_BUFFER_LEAVES,  /* slots, active leaves, counts, scan sums */
    QNI_GPU_BUFFER_RECORDS, /* of active leaves, multiple cells, doubled edges */
    QNI_GPU_BUFFER_REPAIR,
    QNI_GPU_BUFFER_SIMPLIFY, /* marks and places */
    QNI_GPU_BUFFER_POSITIONS,
    QNI_GPU_BUFFER_NORMALS,
    QNI_GPU_BUFFER_QUADS,
    QNI_GPU_BUFFER_TWINS,
    QNI_GPU_BUFFER_VERTEX_HALFEDGES,
    QNI_GPU_BUFFER_VALENCES,
    QNI_GPU_BUFFER_COLOURS,
    QNI_GPU_BUFFER_PACKED, /* the simplified mesh */
    QNI_GPU_BUFFER_COUNT
} qni_gpu_buffer;

typedef struct qni_gpu_pool {
    qni_device *device;
    void *memory[QNI_GPU_BUFFER_COUNT];
    int64_t bytes[QNI_GPU_BUFFER_COUNT];
    int64_t used[QNI_GPU_BUFFER_COUNT]; /* of them by the call at hand */
    bool is_full;                       /* the device had no more */
} qni_gpu_pool;

qn_status qni_gpu_reserve(qni_gpu_pool *pool, qni_gpu_buffer buffer, int64_t bytes, void **out,
                          qn_error *error);
/* The same in parts, each on a boundary of 256 bytes; `memory` of each comes out. */
typedef struct qni_gpu_part {
    int64_t count;
    size_t size;
    void *memory;
} qni_gpu_part;
qn_status qni_gpu_reserve_parts(qni_gpu_pool *pool, qni_gpu_buffer buffer, qni_gpu_part *parts,
                                int count, qn_error *error);
void qni_gpu_pool_free(qni_gpu_pool *pool);

#endif
