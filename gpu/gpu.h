// SPDX-License-Identifier: MIT
/* The one face of gpu/ for the rest of the library: a surface of a volume in the processor's
 * memory, made on a device where that can be. Works in builds without CUDA, too. */
#ifndef QNI_GPU_GPU_H
#define QNI_GPU_GPU_H

#include <qn/surface.h>

/* As qni_dmc_surface(), on the current CUDA device. With QN_DEVICE_AUTO a request that the GPU
 * cannot or need not do comes back with *done_out false and QN_OK, and report->device_note says
 * why; with QN_DEVICE_CUDA it is an error: QN_ERROR_UNSUPPORTED, or QN_ERROR_OUT_OF_MEMORY where
 * the device has too little. */
qn_status qni_gpu_surface(qn_context *context, const qn_volume *volume, double isovalue,
                          const qn_surface_options *options, bool *done_out, qn_mesh **mesh_out,
                          qn_surface_report *report, qn_error *error);

#endif
