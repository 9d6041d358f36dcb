// SPDX-License-Identifier: MIT
/* One surface on a device, in the order of its stages. Knows kernels by name only, so that it runs
 * as well where the processor plays the device. */
#ifndef QNI_GPU_DRIVER_H
#define QNI_GPU_DRIVER_H

#include <qn/surface.h>
#include "gpu/device.h"
#include "volume/field.h"

/* What is asked for, and what came out: arrays in device memory, of the pool, valid until its next
 * use. */
typedef struct qni_gpu_job {
    qni_gpu_pool *pool;
    qni_field field; /* measured, as soon as a sample is found not to be finite */
    qni_gpu_args args;
    bool with_normals, with_quads, with_halfedges, with_repair;

    int64_t vertex_count, quad_count; /* of the finished mesh */
    int64_t doubled_count, split_count;
    int64_t fallback_points; /* of repair */
    qni_gpu_totals totals;
} qni_gpu_job;

/* Set the job up for samples that lie in device memory, packed or with rows and planes apart. */
void qni_gpu_job_init(qni_gpu_job *job, qni_gpu_pool *pool, const qni_field *field,
                      const void *device_samples, int64_t row, int64_t plane);
/* Pass 1: what there will be. One synchronisation. */
qn_status qni_gpu_count_surface(qni_gpu_job *job, qn_error *error);
/* Pass 2: the mesh; finished when the device is. */
qn_status qni_gpu_emit_surface(qni_gpu_job *job, qn_error *error);
/* Read what pass 2 counted; after this the device has nothing left to do. */
qn_status qni_gpu_finish_surface(qni_gpu_job *job, qn_error *error);

/* Device memory that the call used beside samples and mesh. */
int64_t qni_gpu_scratch_bytes(const qni_gpu_job *job);
void qni_gpu_fill_report(const qni_gpu_job *job, qn_surface_report *report);

#endif
