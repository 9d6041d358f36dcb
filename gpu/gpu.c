// SPDX-License-Identifier: MIT
/* Whether a request goes to the GPU. */
#include "gpu/gpu.h"
#include "gpu/cuda.h"
#include "gpu/host.h"
#include "core/status.h"

#include <stdio.h>
#include <string.h>

/* Below this many samples the way to the GPU and back takes longer than the work. */
enum { LEAST_SAMPLES = 1 << 21 };

static bool is_small(const qn_volume *volume) {
    const int64_t *size = qn_volume_grid(volume)->size;
    const qn_sparse_grid *sparse = qn_volume_sparse_grid(volume);
    if (sparse)
        return sparse->leaf_count * 512 < LEAST_SAMPLES;
    return (double)size[0] * (double)size[1] * (double)size[2] < LEAST_SAMPLES;
}

/* A lattice without a cell has no surface anywhere. */
static bool has_no_cell(const qn_volume *volume, const qn_surface_options *options) {
    const int64_t *size = qn_volume_grid(volume)->size;
    return options->open && !qn_volume_sparse_grid(volume) &&
           (size[0] < 2 || size[1] < 2 || size[2] < 2);
}

static qn_status leave_to_cpu(qn_surface_report *report, const char *why) {
    snprintf(report->device_note, sizeof report->device_note, "%s", why);
    return QN_OK;
}

qn_status qni_gpu_surface(qn_context *context, const qn_volume *volume, double isovalue,
                          const qn_surface_options *options, bool *done_out, qn_mesh **mesh_out,
                          qn_surface_report *report, qn_error *error) {
    const bool must = options->device == QN_DEVICE_CUDA;
    const char *cannot = qni_gpu_cannot(volume, options);
    qni_device *device;
    qn_error own = {QN_OK, ""};
    *done_out = false;
    *mesh_out = NULL;
    if (must && cannot)
        return qni_fail(error, QN_ERROR_UNSUPPORTED,
                        "not built in for CUDA: %s; take --device cpu, or leave it out", cannot);
    if (cannot)
        return leave_to_cpu(report, cannot);
    if (has_no_cell(volume, options))
        return leave_to_cpu(report, "there is no cell");
    if (!must && is_small(volume))
        return leave_to_cpu(report, "a small volume");
    qn_status status = qni_cuda_open(NULL, &device, &own);
    if (status == QN_OK) {
        status = qni_gpu_host_surface(context, device, volume, isovalue, options, 0, mesh_out,
                                      report, &own);
        qni_cuda_close(device);
    }
    *done_out = status == QN_OK;
    if (status == QN_OK)
        return QN_OK;
    /* Left to itself, the processor does what the GPU has not or has too little memory for. */
    if (!must && (status == QN_ERROR_UNSUPPORTED || status == QN_ERROR_OUT_OF_MEMORY)) {
        memset(report, 0, sizeof *report);
        return leave_to_cpu(report, own.message);
    }
    if (error)
        *error = own;
    return status;
}
