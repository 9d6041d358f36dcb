// SPDX-License-Identifier: MIT
/* The stages of one surface: signs -> leaves -> count | records -> vertices and quads. The bar is
 * the one synchronisation, where the host learns how much memory the mesh needs. */
#include "gpu/driver.h"
#include "gpu/room.h"
#include "dmc/dmc.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

static qn_status launch(qni_gpu_job *job, qni_gpu_kernel kernel, int64_t blocks, qn_error *error) {
    qni_device *device = job->pool->device;
    return blocks > 0 ? device->launch(device, kernel, &job->args, blocks, error) : QN_OK;
}

/* ---- the job --------------------------------------------------------------------------------- */

static void set_field(qni_gpu_job *job) {
    const qni_field *from = &job->field;
    const qn_grid *grid = from->grid;
    qni_gpu_field *field = &job->args.field;
    for (int a = 0; a < 3; ++a) {
        field->size[a] = grid->size[a];
        field->points[a] = from->samples[a];
        field->leaves[a] = (int32_t)from->leaves[a];
    }
    field->scalar = (int32_t)grid->scalar;
    field->border = from->border;
    field->scaled = grid->slope != 1 || grid->intercept != 0;
    field->inside_below = from->inside_below;
    field->inverted = from->inverted;
    field->constant = from->constant;
    field->whole_threshold = from->threshold.whole;
    field->real_threshold =
        grid->scalar == QN_F32 ? (double)from->threshold.f32 : from->threshold.f64;
    field->isovalue = from->isovalue;
    field->slope = grid->slope;
    field->intercept = grid->intercept;
    field->nonfinite_distance = from->nonfinite_distance;
}

void qni_gpu_job_init(qni_gpu_job *job, qni_gpu_pool *pool, const qni_field *field,
                      const void *device_samples, int64_t row, int64_t plane) {
    double determinant;
    memset(job, 0, sizeof *job);
    job->pool = pool;
    job->field = *field;
    set_field(job);
    job->args.field.samples = device_samples;
    job->args.field.row = row;
    job->args.field.plane = plane;
    job->args.field.layers = (int32_t)field->leaves[2];
    job->args.measured_planes = field->grid->size[2];
    qni_frame_of_field(field, &job->args.frame, &determinant);
    job->args.reverse = field->inside_below != (determinant < 0);
    job->args.own_vertices[1] = job->args.own_doubled[1] = UINT32_MAX;
    memset(pool->used, 0, sizeof pool->used);
}

int32_t qni_gpu_layers_below(const qni_gpu_job *job) {
    return job->with_repair ? 2 : 1;
}

void qni_gpu_job_cut(qni_gpu_job *job, const int32_t own[2], int64_t first_plane) {
    qni_gpu_args *a = &job->args;
    const int32_t layers = a->field.leaves[2];
    const int32_t below = own[0] - qni_gpu_layers_below(job), first = below > 0 ? below : 0;
    const int32_t end = own[1] < layers ? own[1] + 1 : layers;
    job->is_slab = true;
    a->own_layers[0] = own[0];
    a->own_layers[1] = own[1];
    a->field.first_layer = first;
    a->field.layers = end - first;
    a->field.first_plane = first_plane;
}

/* ---- pass 1 ---------------------------------------------------------------------------------- */

/* `most` is a bound on the length, which the device knows. */
static qn_status scan(qni_gpu_job *job, uint32_t *data, int64_t stride, int64_t channels,
                      int64_t placed, const uint64_t *length, int64_t most, uint64_t *totals,
                      qn_error *error) {
    qni_gpu_args *a = &job->args;
    a->scan_data = data;
    a->scan_stride = stride;
    a->scan_channels = channels;
    a->scan_placed = placed;
    a->scan_length = length;
    a->scan_totals = totals;
    QN_TRY(launch(job, QNI_GPU_KERNEL_scan_sums, channels * qni_gpu_scan_tiles_of(most), error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_scan_tops, channels, error));
    return launch(job, QNI_GPU_KERNEL_scan_places, placed * qni_gpu_scan_tiles_of(most), error);
}

qn_status qni_gpu_scan(qni_gpu_job *job, uint32_t *data, const uint64_t *length, int64_t most,
                       uint64_t *total, qn_error *error) {
    return scan(job, data, 0, 1, 1, length, most, total, error);
}

static qn_status read_totals(qni_gpu_job *job, qn_error *error) {
    qni_device *device = job->pool->device;
    QN_TRY(device->download(device, &job->totals, job->args.totals, sizeof job->totals, error));
    return device->finish(device, error);
}

static qn_status find_leaves(qni_gpu_job *job, int64_t leaves, qn_error *error) {
    if (qni_gpu_is_sparse(&job->args.field))
        return launch(job, QNI_GPU_KERNEL_sparse_signs, leaves, error);
    QN_TRY(launch(job, QNI_GPU_KERNEL_signs, qni_gpu_sign_lines(&job->args), error));
    return launch(job, QNI_GPU_KERNEL_find_leaves, leaves / QNI_LEAVES_THREADS + 1, error);
}

static qn_status count_once(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_device *device = job->pool->device;
    const int64_t leaves = qni_gpu_leaf_total(job);
    memset(&job->totals, 0, sizeof job->totals);
    job->totals.leaves = (uint64_t)leaves;
    QN_TRY(device->upload(device, a->totals, &job->totals, sizeof job->totals, error));
    QN_TRY(find_leaves(job, leaves, error));
    QN_TRY(scan(job, a->slot, 0, 1, 1, &a->totals->leaves, leaves, &a->totals->active, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_list_leaves, leaves / QNI_LEAVES_THREADS + 1, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_count, leaves, error));
    QN_TRY(scan(job, a->counts, a->count_stride, QNI_GPU_CHANNELS,
                job->is_slab ? QNI_GPU_CHANNELS : QNI_GPU_PLACED, &a->totals->active, leaves,
                a->totals->channels, error));
    if (job->is_slab)
        QN_TRY(launch(job, QNI_GPU_KERNEL_note_own, 1, error));
    return read_totals(job, error);
}

/* The rule for non-finite samples needs the largest distance of the finite ones, as
 * qni_field_measure_nonfinite(). */
static qn_status measure(qni_gpu_job *job, qn_error *error) {
    const qni_gpu_args *a = &job->args;
    QN_TRY(launch(job, QNI_GPU_KERNEL_measure, a->field.size[1] * a->measured_planes, error));
    return read_totals(job, error);
}

void qni_gpu_apply_measure(qni_gpu_job *job) {
    double largest;
    memcpy(&largest, &job->totals.largest_bits, sizeof largest);
    qni_field_set_nonfinite(&job->field, (int64_t)job->totals.nan_count,
                            (int64_t)job->totals.infinite_count, largest);
    set_field(job);
}

static qn_status check_totals(const qni_gpu_job *job, qn_error *error) {
    const uint64_t *channels = job->totals.channels;
    const uint64_t doubled = job->with_repair ? channels[QNI_GPU_DOUBLED] : 0;
    /* A doubled edge adds at most four points and four centres, and eight quads. */
    if (channels[QNI_GPU_VERTICES] + 8 * doubled > UINT32_MAX ||
        channels[QNI_GPU_QUADS] + 8 * doubled > UINT32_MAX)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "the surface has more than 2^32 - 1 vertices: cut the volume in parts");
    return QN_OK;
}

static qn_status start_counting(qni_gpu_job *job, qn_error *error) {
    job->args.with_doubled = 1; /* they are reported even where they are kept */
    job->args.keep_doubled = !job->with_repair;
    job->args.with_halfedges = job->with_halfedges;
    return qni_gpu_reserve_count(job, error);
}

static void take_counts(qni_gpu_job *job) {
    qni_gpu_args *a = &job->args;
    job->vertex_count = (int64_t)job->totals.channels[QNI_GPU_VERTICES];
    job->quad_count = (int64_t)job->totals.channels[QNI_GPU_QUADS];
    job->doubled_count = (int64_t)job->totals.channels[QNI_GPU_DOUBLED];
    a->plain_vertices = (uint32_t)job->vertex_count;
    a->plain_quads = (uint32_t)job->quad_count;
    a->doubled_count = job->doubled_count;
}

qn_status qni_gpu_count_surface(qni_gpu_job *job, qn_error *error) {
    memset(&job->totals, 0, sizeof job->totals);
    if (qni_gpu_leaf_total(job) == 0)
        return QN_OK;
    QN_TRY(start_counting(job, error));
    QN_TRY(count_once(job, error));
    if (job->totals.nonfinite && job->field.nonfinite_distance == 0) {
        if (qni_gpu_is_sparse(&job->args.field))
            return QN_OK; /* the host measures these, and counts again */
        QN_TRY(measure(job, error));
        qni_gpu_apply_measure(job);
        QN_TRY(count_once(job, error));
    }
    QN_TRY(check_totals(job, error));
    take_counts(job);
    return QN_OK;
}

/* ---- pass 2 ---------------------------------------------------------------------------------- */

/* Which quads are split, and the places of what that adds. */
static qn_status number_splits(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_device *device = job->pool->device;
    const int64_t words = (job->quad_count + 31) / 32, most = 4 * job->doubled_count;
    const int64_t face_blocks = qni_gpu_blocks_for(job->doubled_count);
    QN_TRY(qni_gpu_reserve_repair(job, error));
    job->totals.mark_words = (uint64_t)words;
    QN_TRY(device->upload(device, &a->totals->mark_words, &job->totals.mark_words,
                          sizeof job->totals.mark_words, error));
    QN_TRY(device->fill(device, a->marks, 0, words * (int64_t)sizeof *a->marks, error));
    QN_TRY(device->fill(device, a->splits, 0xff, most * (int64_t)sizeof *a->splits, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_mark_quads, face_blocks, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_count_marks, qni_gpu_blocks_for(words), error));
    QN_TRY(scan(job, a->mark_ranks, 0, 1, 1, &a->totals->mark_words, words, &a->totals->splits,
                error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_list_splits, face_blocks, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_note_splits, qni_gpu_blocks_for(most), error));
    QN_TRY(scan(job, a->split_sizes, 0, 1, 1, &a->totals->splits, most, &a->totals->split_quads,
                error));
    return job->is_slab ? launch(job, QNI_GPU_KERNEL_note_own_splits, 1, error) : QN_OK;
}

/* Of the vertices that repair made or touched. */
static qn_status count_valences(qni_gpu_job *job, int64_t blocks, qn_error *error) {
    qni_device *device = job->pool->device;
    uint8_t *made = job->args.valences + job->args.plain_vertices;
    QN_TRY(device->fill(device, made, QNI_VALENCE_APART, 8 * job->doubled_count, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_split_apart, blocks, error));
    return launch(job, QNI_GPU_KERNEL_split_valences, blocks, error);
}

static qn_status repair(qni_gpu_job *job, qn_error *error) {
    const int64_t face_blocks = qni_gpu_blocks_for(job->doubled_count),
                  split_blocks = qni_gpu_blocks_for(4 * job->doubled_count);
    QN_TRY(number_splits(job, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_place_faces, face_blocks, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_split_quads, split_blocks, error));
    if (job->with_halfedges)
        QN_TRY(launch(job, QNI_GPU_KERNEL_link_splits, split_blocks, error));
    return job->with_valences ? count_valences(job, split_blocks, error) : QN_OK;
}

static bool repairs(const qni_gpu_job *job) {
    return job->with_repair && job->doubled_count > 0;
}

/* Repair looks at neighbours on all sides; without it a slab writes its own part only. */
static void set_ranges(qni_gpu_job *job) {
    qni_gpu_args *a = &job->args;
    const bool all = !job->is_slab || repairs(job);
    a->first_slot = all ? 0 : (int64_t)job->totals.own_active[0];
    a->end_slot = a->end_linked = (int64_t)(all ? job->totals.active : job->totals.own_active[1]);
    a->first_linked = 0;
    for (int end = 0; job->is_slab && end < 2; ++end) {
        a->own_vertices[end] = (uint32_t)job->totals.own[end][QNI_GPU_VERTICES];
        a->own_doubled[end] = (uint32_t)job->totals.own[end][QNI_GPU_DOUBLED];
    }
}

qn_status qni_gpu_emit_surface(qni_gpu_job *job, qn_error *error) {
    qni_device *device = job->pool->device;
    const qni_gpu_args *a = &job->args;
    const int64_t active = (int64_t)job->totals.active;
    if (active == 0)
        return QN_OK;
    set_ranges(job);
    QN_TRY(qni_gpu_reserve_records(job, error));
    QN_TRY(qni_gpu_reserve_mesh(job, error));
    if (job->with_valences) /* whole words are added to: none shall be unknown */
        QN_TRY(
            device->fill(device, a->valences, 0, job->pool->used[QNI_GPU_BUFFER_VALENCES], error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_record, active, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_emit, a->end_slot - a->first_slot, error));
    if (job->with_halfedges)
        QN_TRY(launch(job, QNI_GPU_KERNEL_link, a->end_linked - a->first_linked, error));
    return repairs(job) ? repair(job, error) : QN_OK;
}

qn_status qni_gpu_finish_surface(qni_gpu_job *job, qn_error *error) {
    if (job->totals.active == 0)
        return QN_OK;
    QN_TRY(read_totals(job, error));
    job->split_count = (int64_t)job->totals.splits;
    if (job->split_count)
        job->vertex_count += 4 * job->doubled_count + job->split_count;
    job->quad_count += (int64_t)job->totals.split_quads;
    job->fallback_points = (int64_t)job->totals.left_on_face;
    return QN_OK;
}

/* ---- slabs ----------------------------------------------------------------------------------- */

qn_status qni_gpu_count_slab(qni_gpu_job *job, qn_error *error) {
    QN_TRY(start_counting(job, error));
    QN_TRY(count_once(job, error));
    QN_TRY(check_totals(job, error));
    take_counts(job);
    return QN_OK;
}

qn_status qni_gpu_count_splits(qni_gpu_job *job, qn_error *error) {
    if (!repairs(job))
        return QN_OK;
    QN_TRY(qni_gpu_reserve_records(job, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_record, (int64_t)job->totals.active, error));
    QN_TRY(number_splits(job, error));
    return read_totals(job, error);
}

qn_status qni_gpu_measure_slab(qni_gpu_job *job, qn_error *error) {
    qni_device *device = job->pool->device;
    QN_TRY(start_counting(job, error));
    memset(&job->totals, 0, sizeof job->totals);
    QN_TRY(device->upload(device, job->args.totals, &job->totals, sizeof job->totals, error));
    return measure(job, error);
}

/* Number `count` entries from `first` on. */
static qn_status renumber(qni_gpu_job *job, qni_gpu_kernel kernel, int64_t first, int64_t count,
                          qn_error *error) {
    job->args.range_first = first;
    job->args.range_count = count;
    return launch(job, kernel, qni_gpu_blocks_for(count), error);
}

qn_status qni_gpu_renumber_slab(qni_gpu_job *job, const qni_gpu_shifts *shifts,
                                const qni_gpu_range vertices[3], const qni_gpu_range quads[2],
                                qn_error *error) {
    job->args.shifts = *shifts;
    for (int n = 0; n < 2; ++n)
        QN_TRY(renumber(job, QNI_GPU_KERNEL_renumber_quads, quads[n].first, quads[n].count, error));
    for (int n = 0; n < 3 && job->with_halfedges; ++n)
        QN_TRY(renumber(job, QNI_GPU_KERNEL_renumber_halfedges, vertices[n].first,
                        vertices[n].count, error));
    return QN_OK;
}

/* ---- what it came to ------------------------------------------------------------------------- */

int64_t qni_gpu_scratch_bytes(const qni_gpu_job *job) {
    const int64_t *used = job->pool->used;
    int64_t bytes = used[QNI_GPU_BUFFER_VALENCES] + used[QNI_GPU_BUFFER_COLOURS];
    for (int n = QNI_GPU_BUFFER_TOTALS; n <= QNI_GPU_BUFFER_SIMPLIFY; ++n)
        bytes += used[n];
    const bool packed = used[QNI_GPU_BUFFER_PACKED] > 0; /* then the mesh before it is no output */
    for (int n = QNI_GPU_BUFFER_POSITIONS; packed && n <= QNI_GPU_BUFFER_VERTEX_HALFEDGES; ++n)
        bytes += used[n];
    return bytes;
}

static int64_t tally(const qni_gpu_job *job, int kind) {
    uint64_t sum = 0;
    for (int n = 0; n < QNI_GPU_STRIPES; ++n)
        sum += job->totals.tally[n][kind];
    return (int64_t)sum;
}

void qni_gpu_fill_report(const qni_gpu_job *job, qn_surface_report *report) {
    const uint64_t *channels = job->totals.channels;
    const int64_t *cells = job->field.cells;
    report->isovalue = job->field.isovalue;
    if (__builtin_mul_overflow(cells[0], cells[1], &report->cells) ||
        __builtin_mul_overflow(report->cells, cells[2], &report->cells))
        report->cells = INT64_MAX; /* as sparse lattices can have */
    report->active_leaves = (int64_t)job->totals.active;
    report->active_cells = (int64_t)channels[QNI_GPU_CELLS];
    report->ambiguous_faces = (int64_t)channels[QNI_GPU_AMBIGUOUS];
    report->multiple_cells = (int64_t)channels[QNI_GPU_MULTIS];
    report->tied_faces = (int64_t)channels[QNI_GPU_TIED];
    report->vertices = job->vertex_count;
    report->quads = job->quad_count;
    report->doubled_edges = job->doubled_count;
    report->repaired_edges = job->with_repair ? job->doubled_count : 0;
    report->slice_points = tally(job, QNI_GPU_BY_SLICE);
    report->degenerate_points = tally(job, QNI_GPU_DEGENERATE);
    report->fallback_points = tally(job, QNI_GPU_BY_FALLBACK) + job->fallback_points;
    report->zero_gradients = tally(job, QNI_GPU_NO_GRADIENT);
    report->nan_samples = job->field.nan_count;
    report->infinite_samples = job->field.infinite_count;
    report->scratch_bytes = qni_gpu_scratch_bytes(job);
    report->output_bytes =
        job->vertex_count * (12 + (job->with_normals ? 12 : 0) + (job->with_halfedges ? 4 : 0)) +
        job->quad_count * (16 + (job->with_halfedges ? 16 : 0));
}
