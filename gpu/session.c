// SPDX-License-Identifier: MIT
/* Surfaces of samples that lie on the device, left there. */
#include "gpu/session.h"
#include "gpu/cuda.h"
#include "gpu/driver.h"
#include "gpu/host.h"
#include "gpu/simplify.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

struct qn_cuda {
    qn_context *context;
    qni_gpu_pool pool;
};

static const char *cannot(const qn_volume *volume, const qn_surface_options *options) {
    const qn_grid *grid = qn_volume_grid(volume);
    const int64_t size = (int64_t)qn_scalar_size(grid->scalar);
    if (options->relax > 0)
        return "relaxation is the processor's";
    if (options->untangle != QN_UNTANGLE_OFF)
        return "untangling is the processor's";
    if (options->simplify && options->simplify_passes < 0)
        return "simplification in a single pass, as in the paper, is the processor's";
    if (options->triangles)
        return "triangles are the processor's";
    if (grid->stride[1] % size != 0 || grid->stride[2] % size != 0)
        return "rows do not begin on whole samples";
    return qni_gpu_cannot(volume, options);
}

static qn_status run(qni_gpu_pool *pool, const qn_volume *volume, double isovalue,
                     const qn_surface_options *options, qni_gpu_job *job, qn_surface_report *report,
                     qn_error *error) {
    const qn_grid *grid = qn_volume_grid(volume);
    const int64_t size = (int64_t)qn_scalar_size(grid->scalar);
    const char *why = cannot(volume, options);
    qni_field field;
    if (why)
        return qni_fail(error, QN_ERROR_UNSUPPORTED, "not built in for CUDA: %s", why);
    QN_TRY(qni_field_init(volume, isovalue, options->inside == QN_INSIDE_BELOW, options->open,
                          &field, error));
    qni_gpu_job_init(job, pool, &field, grid->samples, grid->stride[1] / size,
                     grid->stride[2] / size);
    job->with_normals = !options->skip_normals;
    job->with_halfedges = options->halfedges || options->simplify;
    job->with_valences = options->simplify;
    job->with_repair = !options->keep_doubled;
    QN_TRY(qni_gpu_count_surface(job, error));
    QN_TRY(qni_gpu_emit_surface(job, error));
    QN_TRY(qni_gpu_finish_surface(job, error));
    if (!options->simplify)
        return QN_OK;
    QN_TRY(qni_gpu_simplify(job, options, report, error));
    job->with_halfedges = options->halfedges;
    return QN_OK;
}

qn_status qni_gpu_resident_surface(qn_context *context, qni_gpu_pool *pool, const qn_grid *grid,
                                   double isovalue, const qn_surface_options *options,
                                   qn_cuda_mesh *mesh, qn_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    qn_surface_options defaults;
    qn_volume *volume;
    qni_gpu_job job;
    qn_surface_options_init(&defaults);
    options = options ? options : &defaults;
    memset(mesh, 0, sizeof *mesh);
    QNI_CHECK_OPTIONS(options, "qn_surface_options_init", error);
    /* A volume checks the grid and fills in its defaults; it never looks at the samples. */
    QN_TRY(qn_volume_create(context, grid, NULL, NULL, &volume, error));
    qn_surface_report own;
    report = report ? report : &own;
    memset(report, 0, sizeof *report);
    const qn_status status = run(pool, volume, isovalue, options, &job, report, error);
    if (status == QN_OK) {
        const qni_gpu_args *a = &job.args;
        const bool halves = job.with_halfedges;
        const qn_cuda_mesh made = {job.vertex_count,
                                   job.quad_count,
                                   a->positions,
                                   a->normals,
                                   a->quads,
                                   halves ? a->twins : NULL,
                                   halves ? a->vertex_halfedges : NULL};
        *mesh = made;
        qni_gpu_fill_report(&job, report);
        report->device = QN_DEVICE_CUDA;
        report->device_slabs = 1;
        report->seconds_total = qni_seconds() - start;
    }
    qn_volume_destroy(volume);
    return status;
}

/* ---- the public face ------------------------------------------------------------------------- */

qn_status qn_cuda_create(qn_context *context, void *stream, qn_cuda **cuda_out, qn_error *error) {
    *cuda_out = NULL;
    qni_device *device;
    QN_TRY(qni_cuda_open(stream, &device, error));
    qn_cuda *cuda = qni_alloc_zero(context, 1, sizeof *cuda);
    if (!cuda) {
        qni_cuda_close(device);
        return qni_fail_memory(error, "the GPU's memory");
    }
    cuda->context = context;
    cuda->pool.device = device;
    *cuda_out = cuda;
    return QN_OK;
}

void qn_cuda_destroy(qn_cuda *cuda) {
    if (!cuda)
        return;
    qni_gpu_pool_free(&cuda->pool);
    qni_cuda_close(cuda->pool.device);
    qni_free(cuda->context, cuda, 1, sizeof *cuda);
}

qn_status qn_cuda_surface(qn_cuda *cuda, const qn_grid *grid, double isovalue,
                          const qn_surface_options *options, qn_cuda_mesh *mesh_out,
                          qn_surface_report *report, qn_error *error) {
    return qni_gpu_resident_surface(cuda->context, &cuda->pool, grid, isovalue, options, mesh_out,
                                    report, error);
}
