// SPDX-License-Identifier: MIT
/* <qn/cuda.h> on any device. */
#ifndef QNI_GPU_SESSION_H
#define QNI_GPU_SESSION_H

#include <qn/cuda.h>
#include "gpu/device.h"

qn_status qni_gpu_resident_surface(qn_context *context, qni_gpu_pool *pool, const qn_grid *grid,
                                   double isovalue, const qn_surface_options *options,
                                   qn_cuda_mesh *mesh_out, qn_surface_report *report,
                                   qn_error *error);

#endif
