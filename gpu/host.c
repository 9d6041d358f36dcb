// SPDX-License-Identifier: MIT
/* A volume goes up, its surface comes down. What a device does not do yet, improvement of the mesh,
 * the processor does to what came down. */
#include "gpu/host.h"
#include "gpu/driver.h"
#include "gpu/simplify.h"
#include "gpu/slabs.h"
#include "gpu/sparse.h"
#include "dmc/dmc.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/mesh.h"
#include "volume/volume.h"

#include <string.h>

const char *qni_gpu_cannot(const qn_volume *volume, const qn_surface_options *options) {
    const qn_grid *grid = qn_volume_grid(volume);
    const bool sparse = qn_volume_sparse_grid(volume) != NULL; /* packed, and without a border */
    if (grid->swapped)
        return "samples in foreign byte order are the processor's";
    if (!sparse && (grid->stride[0] != (int64_t)qn_scalar_size(grid->scalar) ||
                    grid->stride[1] <= 0 || grid->stride[2] <= 0))
        return "samples that do not lie in rows are the processor's";
    if (options->topology != QN_TOPOLOGY_DISCS)
        return "exact topology is the processor's";
    if (options->open && !options->keep_doubled && !sparse)
        return "open surfaces whose rim is repaired are the processor's";
    if (options->count_only)
        return "counting alone is the processor's";
    return NULL;
}

/* ---- down ------------------------------------------------------------------------------------ */

static qn_status download(qni_gpu_job *job, void *to, const void *from, int64_t bytes,
                          qn_error *error) {
    qni_device *device = job->pool->device;
    return bytes > 0 ? device->download(device, to, from, bytes, error) : QN_OK;
}

static qn_status fill_mesh(qni_gpu_job *job, qn_mesh *mesh, qn_error *error) {
    const qni_gpu_args *a = &job->args;
    const int64_t vertices = job->vertex_count, quads = job->quad_count;
    QN_TRY(download(job, mesh->positions, a->positions, 12 * vertices, error));
    if (mesh->normals)
        QN_TRY(download(job, mesh->normals, a->normals, 12 * vertices, error));
    QN_TRY(download(job, mesh->quads, a->quads, 16 * quads, error));
    if (mesh->twins) {
        QN_TRY(download(job, mesh->twins, a->twins, 16 * quads, error));
        QN_TRY(download(job, mesh->vertex_halfedges, a->vertex_halfedges, 4 * vertices, error));
    }
    if (job->host_valences) {
        QN_TRY(download(job, job->host_valences, a->valences, vertices, error));
        QN_TRY(download(job, job->host_colours, a->colours, quads, error));
    }
    return job->pool->device->finish(job->pool->device, error);
}

static int64_t valence_room(const qni_gpu_job *job) {
    return job->vertex_count + 1;
}

static int64_t colour_room(const qni_gpu_job *job) {
    return job->quad_count + 1;
}

static qn_status alloc_marks(qn_context *context, qni_gpu_job *job, qn_error *error) {
    job->host_valences = qni_alloc(context, valence_room(job), 1);
    job->host_colours = qni_alloc(context, colour_room(job), 1);
    return job->host_valences && job->host_colours ? QN_OK : qni_fail_memory(error, "the valences");
}

void qni_gpu_free_marks(qn_context *context, qni_gpu_job *job) {
    qni_free(context, job->host_valences, valence_room(job), 1);
    qni_free(context, job->host_colours, colour_room(job), 1);
    job->host_valences = job->host_colours = NULL;
}

qn_status qni_gpu_alloc_mesh(qn_context *context, qni_gpu_job *job, const qn_grid *grid,
                             qn_mesh **mesh_out, qn_error *error) {
    qn_mesh *mesh;
    QN_TRY(qni_mesh_alloc(context, job->vertex_count, job->quad_count, 0, job->with_normals, &mesh,
                          error));
    memcpy(mesh->space, grid->space, sizeof mesh->space);
    memcpy(mesh->unit, grid->unit, sizeof mesh->unit);
    qn_status status = job->with_halfedges ? qni_mesh_alloc_halfedges(context, mesh, error) : QN_OK;
    if (status == QN_OK && job->with_valences)
        status = alloc_marks(context, job, error);
    if (status == QN_OK)
        *mesh_out = mesh;
    else
        qn_mesh_destroy(mesh);
    return status;
}

static qn_status make_mesh(qn_context *context, qni_gpu_job *job, const qn_grid *grid,
                           qn_mesh **mesh_out, qn_error *error) {
    QN_TRY(qni_gpu_alloc_mesh(context, job, grid, mesh_out, error));
    return fill_mesh(job, *mesh_out, error);
}

/* ---- all of it ------------------------------------------------------------------------------- */

static qn_status bring_up(qni_gpu_job *job, const qn_grid *grid, qn_error *error) {
    void *samples;
    if (job->field.sparse)
        return qni_gpu_upload_blocks(job, error);
    QN_TRY(qni_gpu_upload_planes(job->pool, grid, 0, grid->size[2], &samples, error));
    job->args.field.samples = samples;
    return QN_OK;
}

/* Where the whole mesh is on the device. What is left of halfedges is what is asked for. */
static qn_status simplify(qn_context *context, qni_gpu_job *job, const qn_surface_options *options,
                          qn_surface_report *report, qn_error *error) {
    if (!options->simplify || options->simplify_passes < 0)
        return QN_OK;
    if (qni_progress(context, "simplify", 0.5))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    QN_TRY(qni_gpu_simplify(job, options, report, error));
    job->with_valences = false;
    job->with_halfedges = (options->halfedges && !options->triangles) || options->relax > 0;
    return QN_OK;
}

/* The whole volume at once. */
static qn_status run_whole(qn_context *context, qni_gpu_job *job, const qn_grid *grid,
                           const qn_surface_options *options, qn_mesh **mesh_out,
                           qn_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    QN_TRY(bring_up(job, grid, error));
    if (qni_progress(context, "classify", 0))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    QN_TRY(job->field.sparse ? qni_gpu_count_sparse(context, job, error)
                             : qni_gpu_count_surface(job, error));
    const double counted = qni_seconds();
    if (qni_progress(context, "emit", 0))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    QN_TRY(qni_gpu_emit_surface(job, error));
    QN_TRY(qni_gpu_finish_surface(job, error));
    QN_TRY(simplify(context, job, options, report, error));
    QN_TRY(make_mesh(context, job, grid, mesh_out, error));
    qni_gpu_fill_report(job, report);
    report->device_slabs = 1;
    report->seconds_classify = counted - start;
    report->seconds_emit = qni_seconds() - counted;
    return QN_OK;
}

static void init_job(qni_gpu_job *job, qni_gpu_pool *pool, const qni_field *field,
                     const qn_surface_options *options) {
    const int64_t *size = field->grid->size;
    qni_gpu_job_init(job, pool, field, NULL, size[0], size[0] * size[1]);
    job->with_normals = !options->skip_normals;
    job->with_halfedges =
        (options->halfedges && !options->triangles) || options->simplify || options->relax > 0;
    job->with_repair = !options->keep_doubled;
    job->with_valences = options->simplify;
}

/* Whole where there is room for it, else in slabs: as many layers as fit, or `slab_layers`. Sparse
 * volumes have no slabs. */
static qn_status run(qn_context *context, qni_gpu_pool *pool, const qn_volume *volume,
                     double isovalue, const qn_surface_options *options, int32_t slab_layers,
                     qni_gpu_job *job, qn_mesh **mesh_out, qn_surface_report *report,
                     qn_error *error) {
    const qn_grid *grid = qn_volume_grid(volume);
    qni_field field;
    QN_TRY(qni_field_init(volume, isovalue, options->inside == QN_INSIDE_BELOW, options->open,
                          &field, error));
    init_job(job, pool, &field, options);
    if (field.sparse)
        return run_whole(context, job, grid, options, mesh_out, report, error);
    const int32_t layers = (int32_t)field.leaves[2];
    int32_t most_layers = slab_layers ? slab_layers : layers;
    if (!slab_layers && qni_gpu_bytes_to_count(job) <= qni_gpu_budget(pool->device)) {
        const qn_status status = run_whole(context, job, grid, options, mesh_out, report, error);
        if (status == QN_OK || !pool->is_full || layers < 2)
            return status;
        qni_gpu_pool_free(pool);
        init_job(job, pool, &field, options);
        most_layers = layers / 2;
    }
    return qni_gpu_surface_in_slabs(context, job, most_layers, mesh_out, report, error);
}

qn_status qni_gpu_host_surface(qn_context *context, qni_device *device, const qn_volume *volume,
                               double isovalue, const qn_surface_options *options,
                               int32_t slab_layers, qn_mesh **mesh_out, qn_surface_report *report,
                               qn_error *error) {
    const double start = qni_seconds();
    qni_gpu_pool pool = {.device = device};
    qni_gpu_job job = {.pool = NULL};
    *mesh_out = NULL;
    memset(report, 0, sizeof *report);
    qn_status status =
        run(context, &pool, volume, isovalue, options, slab_layers, &job, mesh_out, report, error);
    qni_gpu_pool_free(&pool);
    if (status == QN_OK) {
        qni_dmc dmc = {.context = context,
                       .field = job.field,
                       .valences = job.host_valences,
                       .colours = job.host_colours,
                       .held_before =
                           qn_context_memory(context).current_bytes - report->output_bytes};
        report->device = QN_DEVICE_CUDA;
        qn_surface_options left = *options;
        left.simplify = options->simplify && job.with_valences; /* else the device has done it */
        status = qni_dmc_improve(&dmc, *mesh_out, &left, report, error);
    }
    qni_gpu_free_marks(context, &job);
    if (status != QN_OK) {
        qn_mesh_destroy(*mesh_out);
        *mesh_out = NULL;
    }
    report->seconds_total = qni_seconds() - start;
    return status;
}
