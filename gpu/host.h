// SPDX-License-Identifier: MIT
/* Surfaces of volumes in the processor's memory on any device: what gpu.h does, once a device is
 * open. */
#ifndef QNI_GPU_HOST_H
#define QNI_GPU_HOST_H

#include "gpu/device.h"
#include <qn/surface.h>

/* NULL when the device can do what is asked, else why not. */
const char *qni_gpu_cannot(const qn_volume *volume, const qn_surface_options *options);

/* `slab_layers`: layers of leaves in a slab at most; 0: the whole volume, or what memory allows. */
qn_status qni_gpu_host_surface(qn_context *context, qni_device *device, const qn_volume *volume,
                               double isovalue, const qn_surface_options *options,
                               int32_t slab_layers, qn_mesh **mesh_out, qn_surface_report *report,
                               qn_error *error);

#endif
