// SPDX-License-Identifier: MIT
/* Simplification: first merges in three kernels, a colour each; then rounds of looking, deciding
 * and carrying out, until nothing is left to do; then the mesh is packed. */
#include "gpu/simplify.h"
#include "core/parallel.h"
#include "core/status.h"
#include "dmc/project.h"
#include "gpu/room.h"

#include <string.h>

static qn_status over(qni_gpu_job *job, qni_gpu_kernel kernel, int64_t count, qn_error *error) {
    qni_device *device = job->pool->device;
    const int64_t blocks = qni_gpu_blocks_for(count);
    return blocks > 0 ? device->launch(device, kernel, &job->args, blocks, error) : QN_OK;
}

static qn_status over_quads(qni_gpu_job *job, qni_gpu_kernel kernel, qn_error *error) {
    return over(job, kernel, job->quad_count, error);
}

static qn_status read_totals(qni_gpu_job *job, qn_error *error) {
    qni_device *device = job->pool->device;
    QN_TRY(device->download(device, &job->totals, job->args.totals, sizeof job->totals, error));
    return device->finish(device, error);
}

/* ---- room ------------------------------------------------------------------------------------ */

static qn_status reserve(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_device *device = job->pool->device;
    const int64_t vertices = job->vertex_count, quads = job->quad_count;
    const int64_t tiles = qni_gpu_scan_tiles_of(vertices > quads ? vertices : quads);
    qni_gpu_part parts[] = {{vertices, 1, NULL},
                            {quads, 1, NULL},
                            {vertices + 1, sizeof(uint32_t), NULL},
                            {quads + 1, sizeof(uint32_t), NULL},
                            {tiles, sizeof(uint64_t), NULL}};
    QN_TRY(qni_gpu_reserve_parts(job->pool, QNI_GPU_BUFFER_SIMPLIFY, parts, 5, error));
    a->vertex_marks = parts[0].memory;
    a->quad_marks = parts[1].memory;
    a->vertex_places = parts[2].memory;
    a->quad_places = parts[3].memory;
    a->scan_sums = parts[4].memory;
    a->scan_tiles = tiles;
    return device->fill(device, a->vertex_marks, 0, vertices, error);
}

static qn_status set_up(qni_gpu_job *job, const qn_surface_options *options, qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_device *device = job->pool->device;
    qni_projector projector;
    qni_projector_init(&job->field, &projector);
    memcpy(a->lattice, projector.lattice, sizeof a->lattice);
    memcpy(a->world, job->field.world, sizeof a->world);
    a->reproject = !options->no_reproject;
    a->plain_vertices = (uint32_t)job->vertex_count;
    a->plain_quads = (uint32_t)job->quad_count;
    job->totals.lengths[0] = (uint64_t)job->vertex_count;
    job->totals.lengths[1] = (uint64_t)job->quad_count;
    QN_TRY(device->upload(device, a->totals, &job->totals, sizeof job->totals, error));
    return reserve(job, error);
}

/* ---- removing -------------------------------------------------------------------------------- */

static qn_status spread(qni_gpu_job *job, bool middles, qn_error *error) {
    job->args.middles = middles;
    return over(job, QNI_GPU_KERNEL_spread, job->vertex_count, error);
}

static qn_status merge_first(qni_gpu_job *job, qn_error *error) {
    QN_TRY(over_quads(job, QNI_GPU_KERNEL_find_first, error));
    for (int colour = 0; colour < QNI_COLOURS; ++colour) {
        job->args.colour = colour;
        QN_TRY(over_quads(job, QNI_GPU_KERNEL_merge_first, error));
    }
    return spread(job, false, error);
}

/* Most chains of who waits for whom are short: some kernels are started before the host asks. */
static qn_status run_round(qni_gpu_job *job, bool rings, qn_error *error) {
    enum { DECIDE_TOGETHER = 4 };
    job->args.rings = rings;
    QN_TRY(over_quads(job, QNI_GPU_KERNEL_look, error));
    do {
        for (int n = 0; n < DECIDE_TOGETHER; ++n)
            QN_TRY(over_quads(job, QNI_GPU_KERNEL_decide, error));
        QN_TRY(read_totals(job, error));
    } while (job->totals.open > 0);
    QN_TRY(over_quads(job, QNI_GPU_KERNEL_carry_out, error));
    return spread(job, !rings, error);
}

static qn_status run_passes(qni_gpu_job *job, int32_t most, int32_t *passes, qn_error *error) {
    uint64_t before, after;
    QN_TRY(merge_first(job, error));
    do {
        before = *passes ? job->totals.merged + job->totals.shrunk : 0;
        QN_TRY(run_round(job, false, error));
        QN_TRY(run_round(job, true, error));
        QN_TRY(read_totals(job, error));
        after = job->totals.merged + job->totals.shrunk;
        ++*passes;
    } while (after > before && *passes != most);
    return QN_OK;
}

/* ---- packing --------------------------------------------------------------------------------- */

static qn_status reserve_packed(qni_gpu_job *job, int64_t vertices, int64_t quads,
                                qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_gpu_part parts[] = {{3 * vertices, sizeof(float), NULL},
                            {a->normals ? 3 * vertices : 0, sizeof(float), NULL},
                            {4 * quads, sizeof(uint32_t), NULL},
                            {4 * quads, sizeof(uint32_t), NULL},
                            {vertices, sizeof(uint32_t), NULL}};
    QN_TRY(qni_gpu_reserve_parts(job->pool, QNI_GPU_BUFFER_PACKED, parts, 5, error));
    a->packed_positions = parts[0].memory;
    a->packed_normals = parts[1].memory;
    a->packed_quads = parts[2].memory;
    a->packed_twins = parts[3].memory;
    a->packed_vertex_halfedges = parts[4].memory;
    return QN_OK;
}

static qn_status pack(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t removed = (int64_t)(job->totals.merged + job->totals.shrunk);
    const int64_t vertices = job->vertex_count - removed, quads = job->quad_count - removed;
    QN_TRY(reserve_packed(job, vertices, quads, error));
    QN_TRY(over(job, QNI_GPU_KERNEL_count_vertices, job->vertex_count, error));
    QN_TRY(qni_gpu_scan(job, a->vertex_places, &a->totals->lengths[0], job->vertex_count,
                        &a->totals->packed[0], error));
    QN_TRY(over_quads(job, QNI_GPU_KERNEL_count_quads, error));
    QN_TRY(qni_gpu_scan(job, a->quad_places, &a->totals->lengths[1], job->quad_count,
                        &a->totals->packed[1], error));
    QN_TRY(over(job, QNI_GPU_KERNEL_pack_vertices, job->vertex_count, error));
    QN_TRY(over_quads(job, QNI_GPU_KERNEL_pack_quads, error));
    QN_TRY(read_totals(job, error));
    if (job->totals.packed[0] != (uint64_t)vertices || job->totals.packed[1] != (uint64_t)quads)
        return qni_fail(error, QN_ERROR_INTERNAL, "simplification lost count on the GPU");
    job->vertex_count = vertices;
    job->quad_count = quads;
    a->positions = a->packed_positions;
    a->normals = a->normals ? a->packed_normals : NULL;
    a->quads = a->packed_quads;
    a->twins = a->packed_twins;
    a->vertex_halfedges = a->packed_vertex_halfedges;
    return QN_OK;
}

qn_status qni_gpu_simplify(qni_gpu_job *job, const qn_surface_options *options,
                           qn_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    int32_t passes = 0;
    if (job->quad_count == 0)
        return QN_OK;
    QN_TRY(set_up(job, options, error));
    QN_TRY(run_passes(job, options->simplify_passes, &passes, error));
    QN_TRY(pack(job, error));
    report->merged_quads = (int64_t)job->totals.merged;
    report->shrunk_quads = (int64_t)job->totals.shrunk;
    report->unprojected_points = (int64_t)job->totals.unprojected;
    report->simplify_passes = passes;
    report->seconds_simplify = qni_seconds() - start;
    return QN_OK;
}
