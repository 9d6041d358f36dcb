// SPDX-License-Identifier: MIT
/* How much device memory a surface takes, and where in it everything lies. */
#include "gpu/room.h"
#include "core/status.h"

/* Parts of one buffer, each on a boundary of 256 bytes. */
static int64_t part_bytes(int64_t count, size_t size) {
    return (count * (int64_t)size + 255) / 256 * 256;
}

static void *take_part(char **at, int64_t count, size_t size) {
    void *part = *at;
    *at += part_bytes(count, size);
    return part;
}

int64_t qni_gpu_leaf_total(const qni_gpu_job *job) {
    const qni_gpu_field *field = &job->args.field;
    if (qni_gpu_is_sparse(field))
        return field->blocks.key_count;
    return (int64_t)field->leaves[0] * field->leaves[1] * field->layers;
}

int64_t qni_gpu_scan_tiles_of(int64_t length) {
    return (length + QNI_SCAN_TILE) / QNI_SCAN_TILE;
}

/* ---- how much -------------------------------------------------------------------------------- */

static int64_t line_words(const qni_gpu_job *job) {
    return (int64_t)job->args.field.leaves[0] * 8 / 32 + 1;
}

static int64_t sign_planes(const qni_gpu_job *job) {
    const qni_gpu_args *a = &job->args;
    const int64_t left = a->field.points[2] - qni_gpu_sign_plane(a);
    const int64_t planes = (int64_t)8 * a->field.layers + 1;
    return planes < left ? planes : left;
}

qni_gpu_room qni_gpu_room_to_count(const qni_gpu_job *job) {
    const int64_t leaves = qni_gpu_leaf_total(job);
    qni_gpu_room room = {{0}};
    room.bytes[QNI_GPU_BUFFER_TOTALS] = sizeof(qni_gpu_totals);
    room.bytes[QNI_GPU_BUFFER_SIGNS] =
        qni_gpu_is_sparse(&job->args.field)
            ? leaves * QNI_GPU_SIGN_LINES * (int64_t)sizeof *job->args.leaf_signs
            : job->args.field.points[1] * sign_planes(job) * line_words(job) * 4;
    room.bytes[QNI_GPU_BUFFER_LEAVES] =
        2 * part_bytes(leaves + 1, sizeof(uint32_t)) +
        part_bytes(QNI_GPU_CHANNELS * (leaves + 1), sizeof(uint32_t)) +
        part_bytes(QNI_GPU_CHANNELS * qni_gpu_scan_tiles_of(leaves), sizeof(uint64_t));
    return room;
}

static int64_t doubled_to_repair(const qni_gpu_job *job) {
    return job->with_repair ? job->doubled_count : 0;
}

static bool needs_leaf_quads(const qni_gpu_job *job) {
    return job->with_halfedges || doubled_to_repair(job) > 0;
}

static int64_t record_bytes(const qni_gpu_job *job) {
    const qni_gpu_args *a = &job->args;
    const int64_t active = (int64_t)job->totals.active;
    const int64_t multis = (int64_t)job->totals.channels[QNI_GPU_MULTIS];
    return part_bytes(active, sizeof *a->leaves) +
           part_bytes(needs_leaf_quads(job) ? active : 0, sizeof *a->leaf_quads) +
           part_bytes(multis, sizeof *a->multis) +
           part_bytes(job->doubled_count, sizeof *a->doubled) + 256;
}

static int64_t mark_words(const qni_gpu_job *job) {
    return (job->quad_count + 31) / 32;
}

/* Doubled edges give at most four splits each. */
static int64_t most_splits(const qni_gpu_job *job) {
    return 4 * job->doubled_count;
}

static int64_t repair_tiles(const qni_gpu_job *job) {
    const int64_t words = mark_words(job), splits = most_splits(job);
    return qni_gpu_scan_tiles_of(words > splits ? words : splits);
}

static int64_t repair_bytes(const qni_gpu_job *job) {
    const qni_gpu_args *a = &job->args;
    const int64_t words = mark_words(job), splits = most_splits(job);
    return part_bytes(words, sizeof *a->marks) + part_bytes(words + 1, sizeof *a->mark_ranks) +
           part_bytes(splits + 1, sizeof *a->split_sizes) + part_bytes(splits, sizeof *a->splits) +
           part_bytes(repair_tiles(job), sizeof *a->scan_sums);
}

/* A doubled edge adds at most four points and four centres, and eight quads. */
qni_gpu_room qni_gpu_room_to_emit(const qni_gpu_job *job) {
    const int64_t doubled = doubled_to_repair(job);
    const int64_t vertices = job->vertex_count + 8 * doubled, quads = job->quad_count + 8 * doubled;
    qni_gpu_room room = {{0}};
    room.bytes[QNI_GPU_BUFFER_RECORDS] = record_bytes(job);
    room.bytes[QNI_GPU_BUFFER_REPAIR] = doubled ? repair_bytes(job) : 0;
    room.bytes[QNI_GPU_BUFFER_POSITIONS] = 12 * vertices;
    room.bytes[QNI_GPU_BUFFER_NORMALS] = job->with_normals ? 12 * vertices : 0;
    room.bytes[QNI_GPU_BUFFER_QUADS] = 16 * quads;
    room.bytes[QNI_GPU_BUFFER_TWINS] = job->with_halfedges ? 16 * quads : 0;
    room.bytes[QNI_GPU_BUFFER_VERTEX_HALFEDGES] = job->with_halfedges ? 4 * vertices : 0;
    room.bytes[QNI_GPU_BUFFER_VALENCES] = job->with_valences ? (vertices + 8) / 4 * 4 : 0;
    room.bytes[QNI_GPU_BUFFER_COLOURS] = job->with_valences ? (quads + 8) / 4 * 4 : 0;
    return room;
}

int64_t qni_gpu_room_sum(const qni_gpu_room *room) {
    int64_t sum = 0;
    for (int n = 0; n < QNI_GPU_BUFFER_COUNT; ++n)
        sum += room->bytes[n];
    return sum;
}

void qni_gpu_room_join(qni_gpu_room *room, const qni_gpu_room *other) {
    for (int n = 0; n < QNI_GPU_BUFFER_COUNT; ++n)
        room->bytes[n] = room->bytes[n] > other->bytes[n] ? room->bytes[n] : other->bytes[n];
}

/* ---- where ----------------------------------------------------------------------------------- */

/* A buffer as large as the room says; NULL where nothing of it is wanted. */
static qn_status take(qni_gpu_job *job, const qni_gpu_room *room, qni_gpu_buffer buffer, void **out,
                      qn_error *error) {
    *out = NULL;
    return room->bytes[buffer] > 0
               ? qni_gpu_reserve(job->pool, buffer, room->bytes[buffer], out, error)
               : QN_OK;
}

qn_status qni_gpu_reserve_count(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const int64_t leaves = qni_gpu_leaf_total(job);
    const qni_gpu_room room = qni_gpu_room_to_count(job);
    if (leaves >= INT32_MAX)
        return qni_fail(error, QN_ERROR_UNSUPPORTED,
                        "the volume has too many leaves for the GPU path: take --device cpu");
    a->line_words = line_words(job);
    a->sign_planes = sign_planes(job);
    a->scan_tiles = qni_gpu_scan_tiles_of(leaves);
    a->count_stride = leaves + 1;
    void *memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_TOTALS, &memory, error));
    a->totals = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_SIGNS, &memory, error));
    a->signs = memory;
    a->leaf_signs = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_LEAVES, &memory, error));
    char *at = memory;
    a->slot = take_part(&at, leaves + 1, sizeof(uint32_t));
    a->active_leaf = take_part(&at, leaves + 1, sizeof(uint32_t));
    a->counts = take_part(&at, QNI_GPU_CHANNELS * (leaves + 1), sizeof(uint32_t));
    a->scan_sums = take_part(&at, QNI_GPU_CHANNELS * a->scan_tiles, sizeof(uint64_t));
    return QN_OK;
}

qn_status qni_gpu_reserve_records(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const qni_gpu_room room = qni_gpu_room_to_emit(job);
    const int64_t active = (int64_t)job->totals.active;
    void *memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_RECORDS, &memory, error));
    char *at = memory;
    a->leaves = take_part(&at, active, sizeof *a->leaves);
    a->leaf_quads = needs_leaf_quads(job) ? take_part(&at, active, sizeof *a->leaf_quads) : NULL;
    a->multis = take_part(&at, (int64_t)job->totals.channels[QNI_GPU_MULTIS], sizeof *a->multis);
    a->doubled = take_part(&at, job->doubled_count, sizeof *a->doubled);
    return QN_OK;
}

qn_status qni_gpu_reserve_mesh(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const qni_gpu_room room = qni_gpu_room_to_emit(job);
    void *memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_POSITIONS, &memory, error));
    a->positions = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_NORMALS, &memory, error));
    a->normals = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_QUADS, &memory, error));
    a->quads = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_TWINS, &memory, error));
    a->twins = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_VERTEX_HALFEDGES, &memory, error));
    a->vertex_halfedges = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_VALENCES, &memory, error));
    a->valences = memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_COLOURS, &memory, error));
    a->colours = memory;
    return QN_OK;
}

qn_status qni_gpu_reserve_repair(qni_gpu_job *job, qn_error *error) {
    qni_gpu_args *a = &job->args;
    const qni_gpu_room room = qni_gpu_room_to_emit(job);
    const int64_t words = mark_words(job), splits = most_splits(job);
    void *memory;
    QN_TRY(take(job, &room, QNI_GPU_BUFFER_REPAIR, &memory, error));
    char *at = memory;
    a->marks = take_part(&at, words, sizeof *a->marks);
    a->mark_ranks = take_part(&at, words + 1, sizeof *a->mark_ranks);
    a->split_sizes = take_part(&at, splits + 1, sizeof *a->split_sizes);
    a->splits = take_part(&at, splits, sizeof *a->splits);
    a->scan_sums = take_part(&at, repair_tiles(job), sizeof *a->scan_sums);
    a->scan_tiles = repair_tiles(job);
    return QN_OK;
}
