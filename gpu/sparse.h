// SPDX-License-Identifier: MIT
/* A sparse volume goes up as it is: a pool of leaves and rows of runs, never dense. */
#ifndef QNI_GPU_SPARSE_H
#define QNI_GPU_SPARSE_H

#include "gpu/driver.h"

/* Leaves and runs into device memory, and into the job's field. */
qn_status qni_gpu_upload_blocks(qni_gpu_job *job, qn_error *error);
/* The lattice leaves that can hold surface, from the runs alone: those that touch a leaf, or values
 * on both sides of the iso-value. */
qn_status qni_gpu_upload_keys(qn_context *context, qni_gpu_job *job, qn_error *error);
/* Pass 1. Samples that are not finite are counted by the processor, since they are rare; where
 * there are any, it begins again. */
qn_status qni_gpu_count_sparse(qn_context *context, qni_gpu_job *job, qn_error *error);

#endif
