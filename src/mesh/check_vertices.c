// SPDX-License-Identifier: MIT
/* Vertices of a mesh: which are used, which are not finite, which lie where another lies, their
 * box. */
#include "mesh/check.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { FACE_BLOCK = 65536, VERTEX_BLOCK = 65536 };
static const uint32_t empty_slot = UINT32_MAX;

typedef struct vertex_block {
    int64_t unused, nonfinite, duplicates;
    double low[3], high[3];
} vertex_block;

typedef struct vertex_job {
    qni_check *check;
    vertex_block *blocks;
    uint32_t *slots; /* a hash table: vertices by their place */
    uint64_t slot_mask;
} vertex_job;

static void mark_used(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    qni_check *check = ((vertex_job *)pointer)->check;
    for (int64_t face = begin; face < end; ++face) {
        const uint32_t *indices;
        int corners = qni_face_corners(&check->mesh, face, &indices);
        if (!qni_face_is_polygon(indices, corners))
            continue;
        for (int i = 0; i < corners; ++i) /* every writer stores the same value */
            __atomic_store_n(&check->vertex_flags[indices[i]], QNI_VERTEX_USED, __ATOMIC_RELAXED);
    }
}

static void grow_box(vertex_block *result, const float p[3]) {
    for (int i = 0; i < 3; ++i) {
        result->low[i] = fmin(result->low[i], (double)p[i]);
        result->high[i] = fmax(result->high[i], (double)p[i]);
    }
}

static void look_at_vertices(void *pointer, int64_t block, int64_t begin, int64_t end) {
    vertex_job *job = pointer;
    qni_check *check = job->check;
    vertex_block result = {
        0, 0, 0, {HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (int64_t v = begin; v < end; ++v) {
        const float *p = check->mesh.positions + 3 * v;
        bool used = check->vertex_flags[v] & QNI_VERTEX_USED;
        bool finite = isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
        if (!finite)
            check->vertex_flags[v] |= QNI_VERTEX_NONFINITE;
        result.unused += !used;
        result.nonfinite += used && !finite;
        if (used && finite)
            grow_box(&result, p);
    }
    job->blocks[block] = result;
}

/* Bits of a place, -0 taken as 0, well mixed. */
static uint64_t hash_place(const float p[3]) {
    uint32_t bits[3];
    const float q[3] = {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f};
    memcpy(bits, q, sizeof bits);
    uint64_t hash = (((uint64_t)bits[1] << 32) | bits[0]) * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (hash >> 32) ^ bits[2]) * 0xd6e8feb86659fd93u;
    hash = (hash ^ (hash >> 32)) * 0xd6e8feb86659fd93u;
    return hash ^ (hash >> 32);
}

static bool same_place(const float *p, const float *q) {
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

/* True when the place was new. Which of several vertices at a place comes first depends on the
 * threads; how many come later does not. */
static bool enter_place(vertex_job *job, uint32_t vertex) {
    const float *positions = job->check->mesh.positions;
    const float *p = positions + 3 * (size_t)vertex;
    uint64_t slot = hash_place(p) & job->slot_mask;
    for (;; slot = (slot + 1) & job->slot_mask) {
        uint32_t found = empty_slot;
        if (__atomic_compare_exchange_n(&job->slots[slot], &found, vertex, false, __ATOMIC_RELAXED,
                                        __ATOMIC_RELAXED))
            return true;
        if (same_place(p, positions + 3 * (size_t)found))
            return false;
    }
}

static void enter_places(void *pointer, int64_t block, int64_t begin, int64_t end) {
    vertex_job *job = pointer;
    int64_t duplicates = 0;
    for (int64_t v = begin; v < end; ++v)
        if (job->check->vertex_flags[v] == QNI_VERTEX_USED)
            duplicates += !enter_place(job, (uint32_t)v);
    job->blocks[block].duplicates = duplicates;
}

static qn_status count_duplicates(vertex_job *job, qni_check_span span) {
    qni_check *check = job->check;
    int64_t slots = 16; /* at most half of the table is taken */
    while (slots < 2 * check->mesh.vertex_count)
        slots *= 2;
    job->slot_mask = (uint64_t)slots - 1;
    job->slots = qni_alloc(check->context, slots, sizeof *job->slots);
    if (!job->slots)
        return qni_fail_memory(check->error, "the search for duplicate positions");
    memset(job->slots, 0xff, (size_t)slots * sizeof *job->slots);
    qn_status status =
        qni_check_blocks(check, check->mesh.vertex_count, VERTEX_BLOCK, span, enter_places, job);
    qni_free(check->context, job->slots, slots, sizeof *job->slots);
    return status;
}

static void add_up(const vertex_block *blocks, int64_t count, qn_mesh_report *report) {
    double box[2][3] = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (int64_t b = 0; b < count; ++b) {
        report->unused_vertices += blocks[b].unused;
        report->nonfinite_vertices += blocks[b].nonfinite;
        report->duplicate_positions += blocks[b].duplicates;
        for (int i = 0; i < 3; ++i) {
            box[0][i] = fmin(box[0][i], blocks[b].low[i]);
            box[1][i] = fmax(box[1][i], blocks[b].high[i]);
        }
    }
    if (box[0][0] <= box[1][0])
        memcpy(report->bounds, box, sizeof box);
}

static qn_status run(vertex_job *job, qni_check_span span) {
    qni_check *check = job->check;
    double part = (span.to - span.from) / 4;
    const qni_check_span marks = {span.from, span.from + part};
    const qni_check_span looks = {marks.to, marks.to + part}, places = {looks.to, span.to};
    int64_t faces = check->mesh.quad_count + check->mesh.triangle_count;
    QN_TRY(qni_check_blocks(check, faces, FACE_BLOCK, marks, mark_used, job));
    QN_TRY(qni_check_blocks(check, check->mesh.vertex_count, VERTEX_BLOCK, looks, look_at_vertices,
                            job));
    return count_duplicates(job, places);
}

qn_status qni_check_vertices(qni_check *check, qni_check_span span) {
    int64_t count = qni_block_count(check->mesh.vertex_count, VERTEX_BLOCK);
    vertex_job job = {check, qni_alloc_zero(check->context, count, sizeof(vertex_block)), NULL, 0};
    if (!job.blocks)
        return qni_fail_memory(check->error, "a mesh check");
    qn_status status = run(&job, span);
    if (status == QN_OK)
        add_up(job.blocks, count, check->report);
    qni_free(check->context, job.blocks, count, sizeof(vertex_block));
    return status;
}
