// SPDX-License-Identifier: MIT
/* The stages of one surface: signs -> leaves -> count | records -> vertices and quads. The bar is
 * the one synchronisation, where the host learns how much memory the mesh needs. */
#include "gpu/driver.h"
#include "dmc/dmc.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* Parts of one buffer, each on a boundary of 256 bytes. */
static int64_t part_bytes(int64_t count, size_t size) {
    return (count * (int64_t)size + 255) / 256 * 256;
}

static void *take_part(char **at, int64_t count, size_t size) {
    void *part = *at;
    *at += part_bytes(count, size);
    return part;
}

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
    memset(pool->used, 0, sizeof pool->used);
}

/* ---- pass 1 ---------------------------------------------------------------------------------- */

static int64_t leaf_total(const qni_gpu_job *job) {
    const qni_gpu_field *field = &job->args.field;
    return (int64_t)field->leaves[0] * field->leaves[1] * field->layers;
}

static int64_t scan_tiles_of(int64_t length) {
    return (length + QNI_SCAN_TILE) / QNI_SCAN_TILE;
}

static qn_status reserve_pass_1(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t leaves = leaf_total(job);
    if (leaves >= INT32_MAX)
        return qni_fail(error, QN_ERROR_UNSUPPORTED,
                        "the volume has too many leaves for the GPU path: take --device cpu");
    a->line_words = (int64_t)a->field.leaves[0] * 8 / 32 + 1;
    const int64_t planes_left = a->field.points[2] - qni_gpu_sign_plane(a);
    const int64_t planes = (int64_t)8 * a->field.layers + 1;
    a->sign_planes = planes < planes_left ? planes : planes_left;
    a->scan_tiles = scan_tiles_of(leaves);
    a->count_stride = leaves + 1;
    void *memory;
    QN_TRY(
        qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_TOTALS, sizeof(qni_gpu_totals), &memory, error));
    a->totals = memory;
    QN_TRY(qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_SIGNS,
                           qni_gpu_sign_lines(a) * a->line_words * 4, &memory, error));
    a->signs = memory;
    QN_TRY(qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_LEAVES,
                           2 * part_bytes(leaves + 1, sizeof(uint32_t)) +
                               part_bytes(QNI_GPU_CHANNELS * (leaves + 1), sizeof(uint32_t)) +
                               part_bytes(QNI_GPU_CHANNELS * a->scan_tiles, sizeof(uint64_t)),
                           &memory, error));
    char *at = memory;
    a->slot = take_part(&at, leaves + 1, sizeof(uint32_t));
    a->active_leaf = take_part(&at, leaves + 1, sizeof(uint32_t));
    a->counts = take_part(&at, QNI_GPU_CHANNELS * (leaves + 1), sizeof(uint32_t));
    a->scan_sums = take_part(&at, QNI_GPU_CHANNELS * a->scan_tiles, sizeof(uint64_t));
    return QN_OK;
}

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
    QN_TRY(launch(job, QNI_GPU_KERNEL_scan_sums, channels * scan_tiles_of(most), error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_scan_tops, channels, error));
    return launch(job, QNI_GPU_KERNEL_scan_places, placed * scan_tiles_of(most), error);
}

static qn_status read_totals(qni_gpu_job *job, qn_error *error) {
    qni_device *device = job->pool->device;
    QN_TRY(device->download(device, &job->totals, job->args.totals, sizeof job->totals, error));
    return device->finish(device, error);
}

static qn_status count_once(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_device *device = job->pool->device;
    const int64_t leaves = leaf_total(job);
    memset(&job->totals, 0, sizeof job->totals);
    job->totals.leaves = (uint64_t)leaves;
    QN_TRY(device->upload(device, a->totals, &job->totals, sizeof job->totals, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_signs, qni_gpu_sign_lines(a), error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_find_leaves, leaves / QNI_LEAVES_THREADS + 1, error));
    QN_TRY(scan(job, a->slot, 0, 1, 1, &a->totals->leaves, leaves, &a->totals->active, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_list_leaves, leaves / QNI_LEAVES_THREADS + 1, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_count, leaves, error));
    QN_TRY(scan(job, a->counts, a->count_stride, QNI_GPU_CHANNELS, QNI_GPU_PLACED,
                &a->totals->active, leaves, a->totals->channels, error));
    return read_totals(job, error);
}

/* The rule for non-finite samples needs the largest distance of the finite ones, as
 * qni_field_measure_nonfinite(). */
static qn_status measure(qni_gpu_job *job, qn_error *error) {
    const qni_gpu_args *a = &job->args;
    QN_TRY(launch(job, QNI_GPU_KERNEL_measure, a->field.size[1] * a->measured_planes, error));
    return read_totals(job, error);
}

static void apply_measure(qni_gpu_job *job) {
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

qn_status qni_gpu_count_surface(qni_gpu_job *job, qn_error *error) {
    job->args.with_doubled = 1; /* they are reported even where they are kept */
    job->args.with_halfedges = job->with_halfedges;
    memset(&job->totals, 0, sizeof job->totals);
    if (leaf_total(job) == 0)
        return QN_OK;
    QN_TRY(reserve_pass_1(job, error));
    QN_TRY(count_once(job, error));
    if (job->totals.nonfinite && job->field.nonfinite_distance == 0) {
        QN_TRY(measure(job, error));
        apply_measure(job);
        QN_TRY(count_once(job, error));
    }
    QN_TRY(check_totals(job, error));
    job->vertex_count = (int64_t)job->totals.channels[QNI_GPU_VERTICES];
    job->quad_count = (int64_t)job->totals.channels[QNI_GPU_QUADS];
    job->doubled_count = (int64_t)job->totals.channels[QNI_GPU_DOUBLED];
    return QN_OK;
}

/* ---- pass 2 ---------------------------------------------------------------------------------- */

static qn_status reserve_records(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t active = (int64_t)job->totals.active;
    const int64_t multis = (int64_t)job->totals.channels[QNI_GPU_MULTIS];
    const bool with_quads = job->with_halfedges || (job->with_repair && job->doubled_count);
    void *memory;
    QN_TRY(qni_gpu_reserve(job->pool, QNI_GPU_BUFFER_RECORDS,
                           part_bytes(active, sizeof *a->leaves) +
                               part_bytes(with_quads ? active : 0, sizeof *a->leaf_quads) +
                               part_bytes(multis, sizeof *a->multis) +
                               part_bytes(job->doubled_count, sizeof *a->doubled) + 256,
                           &memory, error));
    char *at = memory;
    a->leaves = take_part(&at, active, sizeof *a->leaves);
    a->leaf_quads = with_quads ? take_part(&at, active, sizeof *a->leaf_quads) : NULL;
    a->multis = take_part(&at, multis, sizeof *a->multis);
    a->doubled = take_part(&at, job->doubled_count, sizeof *a->doubled);
    return QN_OK;
}

static qn_status reserve_array(qni_gpu_job *job, qni_gpu_buffer buffer, bool wanted, int64_t count,
                               int64_t bytes, void **out, qn_error *error) {
    *out = NULL;
    return wanted && count > 0 ? qni_gpu_reserve(job->pool, buffer, count * bytes, out, error)
                               : QN_OK;
}

static qn_status reserve_mesh(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t doubled = job->with_repair ? job->doubled_count : 0;
    const int64_t vertices = job->vertex_count + 8 * doubled, quads = job->quad_count + 8 * doubled;
    void *memory;
    QN_TRY(reserve_array(job, QNI_GPU_BUFFER_POSITIONS, true, vertices, 12, &memory, error));
    a->positions = memory;
    QN_TRY(reserve_array(job, QNI_GPU_BUFFER_NORMALS, job->with_normals, vertices, 12, &memory,
                         error));
    a->normals = memory;
    QN_TRY(reserve_array(job, QNI_GPU_BUFFER_QUADS, true, quads, 16, &memory, error));
    a->quads = memory;
    QN_TRY(
        reserve_array(job, QNI_GPU_BUFFER_TWINS, job->with_halfedges, quads, 16, &memory, error));
    a->twins = memory;
    QN_TRY(reserve_array(job, QNI_GPU_BUFFER_VERTEX_HALFEDGES, job->with_halfedges, vertices, 4,
                         &memory, error));
    a->vertex_halfedges = memory;
    return QN_OK;
}

/* Doubled edges give at most four splits each. */
static qn_status reserve_repair(qni_gpu_job *job, int64_t words, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t splits = 4 * job->doubled_count;
    const int64_t tiles = scan_tiles_of(words > splits ? words : splits);
    void *memory;
    QN_TRY(qni_gpu_reserve(
        job->pool, QNI_GPU_BUFFER_REPAIR,
        part_bytes(words, sizeof *a->marks) + part_bytes(words + 1, sizeof *a->mark_ranks) +
            part_bytes(splits + 1, sizeof *a->split_sizes) + part_bytes(splits, sizeof *a->splits) +
            part_bytes(tiles, sizeof *a->scan_sums),
        &memory, error));
    char *at = memory;
    a->marks = take_part(&at, words, sizeof *a->marks);
    a->mark_ranks = take_part(&at, words + 1, sizeof *a->mark_ranks);
    a->split_sizes = take_part(&at, splits + 1, sizeof *a->split_sizes);
    a->splits = take_part(&at, splits, sizeof *a->splits);
    a->scan_sums = take_part(&at, tiles, sizeof *a->scan_sums);
    a->scan_tiles = tiles;
    a->doubled_count = job->doubled_count;
    a->plain_vertices = (uint32_t)job->vertex_count;
    a->plain_quads = (uint32_t)job->quad_count;
    return QN_OK;
}

static qn_status repair(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    qni_device *device = job->pool->device;
    const int64_t words = (job->quad_count + 31) / 32, most = 4 * job->doubled_count;
    const int64_t face_blocks = qni_gpu_blocks_for(job->doubled_count),
                  split_blocks = qni_gpu_blocks_for(most);
    QN_TRY(reserve_repair(job, words, error));
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
    QN_TRY(launch(job, QNI_GPU_KERNEL_note_splits, split_blocks, error));
    QN_TRY(scan(job, a->split_sizes, 0, 1, 1, &a->totals->splits, most, &a->totals->split_quads,
                error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_place_faces, face_blocks, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_split_quads, split_blocks, error));
    return job->with_halfedges ? launch(job, QNI_GPU_KERNEL_link_splits, split_blocks, error)
                               : QN_OK;
}

qn_status qni_gpu_emit_surface(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t active = (int64_t)job->totals.active;
    if (active == 0)
        return QN_OK;
    a->first_slot = 0;
    a->end_slot = active;
    a->first_linked = 0;
    a->end_linked = active;
    a->own_quads = (uint32_t)job->quad_count;
    QN_TRY(reserve_records(job, error));
    QN_TRY(reserve_mesh(job, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_record, active, error));
    QN_TRY(launch(job, QNI_GPU_KERNEL_emit, active, error));
    if (job->with_halfedges)
        QN_TRY(launch(job, QNI_GPU_KERNEL_link, active, error));
    return job->with_repair && job->doubled_count ? repair(job, error) : QN_OK;
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

/* ---- what it came to ------------------------------------------------------------------------- */

int64_t qni_gpu_scratch_bytes(const qni_gpu_job *job) {
    int64_t bytes = 0;
    for (int n = QNI_GPU_BUFFER_TOTALS; n <= QNI_GPU_BUFFER_REPAIR; ++n)
        bytes += job->pool->used[n];
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
    report->cells = cells[0] * cells[1] * cells[2];
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
