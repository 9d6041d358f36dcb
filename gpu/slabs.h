// SPDX-License-Identifier: MIT
/* Volumes larger than the device's memory: layers of leaves go through in slabs, twice, and the
 * mesh comes out as if there had been one. */
#ifndef QNI_GPU_SLABS_H
#define QNI_GPU_SLABS_H

#include "gpu/driver.h"
#include "mesh/mesh.h"

/* A slab's planes of samples on the device; the pool keeps them. The volume's rows run along x. */
qn_status qni_gpu_upload_planes(qni_gpu_pool *pool, const qn_grid *grid, int64_t first,
                                int64_t count, void **samples_out, qn_error *error);
/* An empty mesh of the job's size, with its space and unit; and room for valences and colours where
 * the job has them. */
qn_status qni_gpu_alloc_mesh(qn_context *context, qni_gpu_job *job, const qn_grid *grid,
                             qn_mesh **mesh_out, qn_error *error);

void qni_gpu_free_marks(qn_context *context, qni_gpu_job *job);

/* Device memory that may be planned with: what is free, and some left over. */
int64_t qni_gpu_budget(qni_device *device);
/* The samples of a volume and what pass 1 needs for it. */
int64_t qni_gpu_bytes_to_count(const qni_gpu_job *job);

/* `job` has been set up for the whole volume, without samples; its totals and counts come out.
 * `most_layers` bounds the layers of leaves in a slab: fewer where memory asks for it. The pool's
 * memory is given back between attempts. QN_ERROR_OUT_OF_MEMORY when one layer is too much. */
qn_status qni_gpu_surface_in_slabs(qn_context *context, qni_gpu_job *job, int32_t most_layers,
                                   qn_mesh **mesh_out, qn_surface_report *report, qn_error *error);

#endif
