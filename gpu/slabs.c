// SPDX-License-Identifier: MIT
/* Slabs: pass 1 over all of them gives the sizes, pass 2 makes one part of the mesh after another
 * and brings it to its place. Each slab is a volume of its own with more layers of leaves on either
 * side, enough for all that its own part needs: a vertex looks one cell around, a halfedge and a
 * split quad three. Only the numbers are moved at the end. */
#include "gpu/slabs.h"
#include "gpu/room.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

/* A slab's part of the volume, and what pass 1 found in it and in the layers beside. */
typedef struct slab {
    int32_t own[2];
    int64_t first_plane, planes; /* of samples */
    qni_gpu_totals totals;
} slab;

/* Sums over slabs before the one at hand, or over all. */
typedef struct sums {
    int64_t vertices, quads, doubled, splits, split_quads;
} sums;

typedef struct slabs {
    qn_context *context;
    qni_gpu_job *job; /* of the whole volume */
    slab *list;
    int32_t count, layers;
    sums all;
    int64_t scratch_bytes;
} slabs;

/* ---- the plan -------------------------------------------------------------------------------- */

static int64_t clamp(int64_t n, int64_t low, int64_t high) {
    return n < low ? low : n > high ? high : n;
}

/* Samples that any of the slab's layers, or those beside, look at: the cells below the lowest, and
 * one point more for gradients. */
static void set_planes(const qni_gpu_job *job, slab *s) {
    const qni_field *field = &job->field;
    const int64_t low = s->own[0] - qni_gpu_layers_below(job), high = s->own[1] + 1,
                  size = field->grid->size[2];
    const int64_t first = clamp(8 * low - 2 - field->border, 0, size - 1);
    const int64_t end = clamp(8 * high + 2 - field->border, first + 1, size);
    s->first_plane = first;
    s->planes = end - first;
}

static qni_gpu_job cut(const slabs *all, const slab *s, void *samples) {
    qni_gpu_job part = *all->job;
    qni_gpu_job_cut(&part, s->own, s->first_plane);
    part.args.field.samples = samples;
    return part;
}

static int64_t plane_bytes(const qn_grid *grid) {
    return grid->size[0] * grid->size[1] * (int64_t)qn_scalar_size(grid->scalar);
}

int64_t qni_gpu_bytes_to_count(const qni_gpu_job *job) {
    const qni_gpu_room room = qni_gpu_room_to_count(job);
    const qn_grid *grid = job->field.grid;
    return plane_bytes(grid) * grid->size[2] + qni_gpu_room_sum(&room);
}

int64_t qni_gpu_budget(qni_device *device) {
    const int64_t bytes = device->free_bytes(device);
    return bytes - bytes / 16;
}

static qni_gpu_room room_of(const slab *s, const qni_gpu_job *part) {
    qni_gpu_room room = qni_gpu_room_to_count(part);
    room.bytes[QNI_GPU_BUFFER_SAMPLES] = plane_bytes(part->field.grid) * s->planes;
    return room;
}

/* The most layers that leave a quarter of the memory for the mesh; at least one. */
static int32_t layers_that_fit(const slabs *all, int32_t most, int64_t budget) {
    for (int32_t layers = most; layers > 1; --layers) {
        slab s = {.own = {2, 2 + layers}};
        set_planes(all->job, &s);
        const qni_gpu_job part = cut(all, &s, NULL);
        const qni_gpu_room room = room_of(&s, &part);
        if (qni_gpu_leaf_total(&part) < INT32_MAX && qni_gpu_room_sum(&room) <= budget / 4 * 3)
            return layers;
    }
    return 1;
}

static qn_status make_list(slabs *all, int32_t layers, qn_error *error) {
    const int32_t end = (int32_t)all->job->field.leaves[2];
    all->layers = layers;
    all->count = (end + layers - 1) / layers;
    all->list = qni_alloc_zero(all->context, all->count, sizeof *all->list);
    if (!all->list)
        return qni_fail_memory(error, "the list of slabs");
    for (int32_t n = 0; n < all->count; ++n) {
        slab *s = all->list + n;
        s->own[0] = n * layers;
        s->own[1] = end - s->own[0] < layers ? end : s->own[0] + layers;
        set_planes(all->job, s);
    }
    return QN_OK;
}

/* ---- up -------------------------------------------------------------------------------------- */

qn_status qni_gpu_upload_planes(qni_gpu_pool *pool, const qn_grid *grid, int64_t first,
                                int64_t count, void **samples, qn_error *error) {
    qni_device *device = pool->device;
    const int64_t row = grid->size[0] * (int64_t)qn_scalar_size(grid->scalar),
                  plane = row * grid->size[1];
    const char *from = (const char *)grid->samples + first * grid->stride[2];
    QN_TRY(qni_gpu_reserve(pool, QNI_GPU_BUFFER_SAMPLES, plane * count, samples, error));
    if (grid->stride[1] == row && grid->stride[2] == plane)
        return device->upload(device, *samples, from, plane * count, error);
    for (int64_t k = 0; k < count; ++k)
        QN_TRY(device->upload_rows(device, (char *)*samples + k * plane, from + k * grid->stride[2],
                                   row, grid->stride[1], grid->size[1], error));
    return QN_OK;
}

static qn_status bring_up(slabs *all, const slab *s, qni_gpu_job *part, qn_error *error) {
    void *samples;
    QN_TRY(qni_gpu_upload_planes(all->job->pool, all->job->field.grid, s->first_plane, s->planes,
                                 &samples, error));
    *part = cut(all, s, samples);
    return QN_OK;
}

static qn_status look_up(const slabs *all, const char *stage, int32_t n, qn_error *error) {
    if (qni_progress(all->context, stage, (double)n / all->count))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    return QN_OK;
}

/* ---- pass 1 ---------------------------------------------------------------------------------- */

/* Each plane of samples belongs to the slab that has its lattice points; the last takes the rest.
 */
static qn_status measure(slabs *all, qn_error *error) {
    const qni_field *field = &all->job->field;
    uint64_t nan_count = 0, infinite_count = 0, largest_bits = 0;
    for (int32_t n = 0; n < all->count; ++n) {
        const slab *s = all->list + n;
        const int64_t size = field->grid->size[2];
        const int64_t first = clamp((int64_t)8 * s->own[0] - field->border, 0, size);
        const int64_t end =
            n + 1 < all->count ? clamp((int64_t)8 * s->own[1] - field->border, 0, size) : size;
        qni_gpu_job part;
        QN_TRY(look_up(all, "classify", n, error));
        QN_TRY(bring_up(all, s, &part, error));
        part.args.measured_from = first;
        part.args.measured_planes = end - first;
        QN_TRY(qni_gpu_measure_slab(&part, error));
        nan_count += part.totals.nan_count;
        infinite_count += part.totals.infinite_count;
        if (part.totals.largest_bits > largest_bits) /* they sort as the numbers do */
            largest_bits = part.totals.largest_bits;
    }
    all->job->totals.nan_count = nan_count;
    all->job->totals.infinite_count = infinite_count;
    all->job->totals.largest_bits = largest_bits;
    qni_gpu_apply_measure(all->job);
    return QN_OK;
}

static void add_sizes(sums *to, const qni_gpu_totals *t) {
    to->vertices += (int64_t)(t->own[1][QNI_GPU_VERTICES] - t->own[0][QNI_GPU_VERTICES]);
    to->quads += (int64_t)(t->own[1][QNI_GPU_QUADS] - t->own[0][QNI_GPU_QUADS]);
    to->doubled += (int64_t)(t->own[1][QNI_GPU_DOUBLED] - t->own[0][QNI_GPU_DOUBLED]);
    to->splits += (int64_t)(t->own_splits[1] - t->own_splits[0]);
    to->split_quads += (int64_t)(t->own_split_quads[1] - t->own_split_quads[0]);
}

/* Counts of one slab; *room grows to what it needs in either pass. */
static qn_status count_slab(slabs *all, slab *s, qni_gpu_room *room, bool *odd, qn_error *error) {
    qni_gpu_job part;
    QN_TRY(bring_up(all, s, &part, error));
    QN_TRY(qni_gpu_count_slab(&part, error));
    *odd = part.totals.nonfinite && part.field.nonfinite_distance == 0;
    if (*odd)
        return QN_OK;
    qni_gpu_room own = room_of(s, &part), later = qni_gpu_room_to_emit(&part);
    qni_gpu_room_join(&own, &later);
    qni_gpu_room_join(room, &own);
    QN_TRY(qni_gpu_count_splits(&part, error));
    s->totals = part.totals;
    return QN_OK;
}

static qn_status count_all(slabs *all, qni_gpu_room *room, qn_error *error) {
    for (int32_t n = 0; n < all->count; ++n) {
        bool odd;
        QN_TRY(look_up(all, "classify", n, error));
        QN_TRY(count_slab(all, all->list + n, room, &odd, error));
        if (!odd)
            continue;
        QN_TRY(measure(all, error));
        n = -1; /* from the beginning, with what is now known */
    }
    memset(&all->all, 0, sizeof all->all);
    for (int32_t n = 0; n < all->count; ++n)
        add_sizes(&all->all, &all->list[n].totals);
    const sums *sum = &all->all;
    const int64_t doubled = all->job->with_repair ? sum->doubled : 0;
    if (sum->vertices + 8 * doubled > UINT32_MAX || sum->quads + 8 * doubled > UINT32_MAX)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "the surface has more than 2^32 - 1 vertices: cut the volume in parts");
    return QN_OK;
}

/* ---- pass 2 ---------------------------------------------------------------------------------- */

/* The own parts of a slab's arrays, and where they begin in the mesh. */
typedef struct own_parts {
    qni_gpu_range vertices[3], quads[2];
    int64_t vertex_at[3], quad_at[2];
} own_parts;

static qni_gpu_range range(int64_t base, const uint64_t first, const uint64_t end, int64_t each) {
    const qni_gpu_range made = {base + each * (int64_t)first, each * (int64_t)(end - first)};
    return made;
}

static own_parts find_parts(const slabs *all, const qni_gpu_totals *t, const sums *before) {
    const int64_t plain = (int64_t)t->channels[QNI_GPU_VERTICES],
                  plain_quads = (int64_t)t->channels[QNI_GPU_QUADS],
                  doubled = (int64_t)t->channels[QNI_GPU_DOUBLED];
    const int each = all->job->with_repair ? 4 : 0;
    const int64_t points_at = all->all.vertices, centres_at = points_at + each * all->all.doubled;
    const own_parts parts = {
        {range(0, t->own[0][QNI_GPU_VERTICES], t->own[1][QNI_GPU_VERTICES], 1),
         range(plain, t->own[0][QNI_GPU_DOUBLED], t->own[1][QNI_GPU_DOUBLED], each),
         range(plain + each * doubled, t->own_splits[0], t->own_splits[1], 1)},
        {range(0, t->own[0][QNI_GPU_QUADS], t->own[1][QNI_GPU_QUADS], 1),
         range(plain_quads, t->own_split_quads[0], t->own_split_quads[1], 1)},
        {before->vertices, points_at + each * before->doubled, centres_at + before->splits},
        {before->quads, all->all.quads + before->split_quads}};
    return parts;
}

static qn_status fetch(qni_gpu_job *part, void *to, const void *from, int64_t at,
                       const qni_gpu_range *which, int64_t bytes, qn_error *error) {
    qni_device *device = part->pool->device;
    if (!to || which->count == 0)
        return QN_OK;
    return device->download(device, (char *)to + at * bytes,
                            (const char *)from + which->first * bytes, which->count * bytes, error);
}

static qn_status bring_down(qni_gpu_job *part, const own_parts *own, qn_mesh *mesh,
                            qn_error *error) {
    const qni_gpu_args *a = &part->args;
    for (int n = 0; n < 3; ++n) {
        const qni_gpu_range *of = own->vertices + n;
        const int64_t at = own->vertex_at[n];
        QN_TRY(fetch(part, mesh->positions, a->positions, at, of, 12, error));
        QN_TRY(fetch(part, mesh->normals, a->normals, at, of, 12, error));
        QN_TRY(fetch(part, mesh->vertex_halfedges, a->vertex_halfedges, at, of, 4, error));
        QN_TRY(fetch(part, part->host_valences, a->valences, at, of, 1, error));
    }
    for (int n = 0; n < 2; ++n) {
        QN_TRY(fetch(part, mesh->quads, a->quads, own->quad_at[n], own->quads + n, 16, error));
        QN_TRY(fetch(part, mesh->twins, a->twins, own->quad_at[n], own->quads + n, 16, error));
        QN_TRY(
            fetch(part, part->host_colours, a->colours, own->quad_at[n], own->quads + n, 1, error));
    }
    return QN_OK;
}

static void add_report(slabs *all, const slab *s, const qni_gpu_totals *t) {
    qni_gpu_totals *sum = &all->job->totals;
    sum->active += s->totals.own_active[1] - s->totals.own_active[0];
    sum->left_on_face += t->left_on_face;
    for (int c = 0; c < QNI_GPU_CHANNELS; ++c)
        sum->channels[c] += s->totals.own[1][c] - s->totals.own[0][c];
    for (int stripe = 0; stripe < QNI_GPU_STRIPES; ++stripe)
        for (int kind = 0; kind < QNI_GPU_TALLIES; ++kind)
            sum->tally[stripe][kind] += t->tally[stripe][kind];
}

static qn_status emit_slab(slabs *all, const slab *s, const sums *before, qn_mesh *mesh,
                           qn_error *error) {
    const own_parts own = find_parts(all, &s->totals, before);
    const qni_gpu_shifts shifts = {(uint32_t)(own.vertex_at[0] - own.vertices[0].first),
                                   (uint32_t)(own.vertex_at[1] - own.vertices[1].first),
                                   (uint32_t)(own.vertex_at[2] - own.vertices[2].first),
                                   (uint32_t)(own.quad_at[0] - own.quads[0].first),
                                   (uint32_t)(own.quad_at[1] - own.quads[1].first)};
    qni_gpu_job part;
    memset(all->job->pool->used, 0, sizeof all->job->pool->used);
    QN_TRY(bring_up(all, s, &part, error));
    QN_TRY(qni_gpu_count_slab(&part, error));
    if (part.totals.active == 0)
        return QN_OK;
    QN_TRY(qni_gpu_emit_surface(&part, error));
    QN_TRY(qni_gpu_renumber_slab(&part, &shifts, own.vertices, own.quads, error));
    QN_TRY(bring_down(&part, &own, mesh, error));
    QN_TRY(qni_gpu_finish_surface(&part, error));
    add_report(all, s, &part.totals);
    const int64_t scratch = qni_gpu_scratch_bytes(&part);
    all->scratch_bytes = scratch > all->scratch_bytes ? scratch : all->scratch_bytes;
    return QN_OK;
}

static void set_counts(slabs *all) {
    qni_gpu_job *job = all->job;
    job->doubled_count = all->all.doubled;
    job->split_count = all->all.splits;
    job->vertex_count = all->all.vertices + all->all.splits;
    if (all->all.splits)
        job->vertex_count += 4 * all->all.doubled;
    job->quad_count = all->all.quads + all->all.split_quads;
    memset(job->totals.channels, 0, sizeof job->totals.channels);
    memset(job->totals.tally, 0, sizeof job->totals.tally);
    job->totals.active = job->totals.left_on_face = 0;
}

static qn_status emit_all(slabs *all, qn_mesh *mesh, qn_error *error) {
    sums before = {0};
    for (int32_t n = 0; n < all->count; ++n) {
        QN_TRY(look_up(all, "emit", n, error));
        QN_TRY(emit_slab(all, all->list + n, &before, mesh, error));
        add_sizes(&before, &all->list[n].totals);
    }
    all->job->fallback_points = (int64_t)all->job->totals.left_on_face;
    return QN_OK;
}

/* ---- all of it ------------------------------------------------------------------------------- */

static qn_status both_passes(slabs *all, int64_t budget, int64_t *need, qn_mesh **mesh_out,
                             qn_surface_report *report, qn_error *error) {
    const double start = qni_seconds();
    qni_gpu_room room = {{0}};
    QN_TRY(count_all(all, &room, error));
    *need = qni_gpu_room_sum(&room);
    if (*need > budget)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                        "the GPU has %lld bytes left, %d layers of 8 planes need %lld: take "
                        "--device cpu",
                        (long long)budget, (int)all->layers, (long long)*need);
    set_counts(all);
    report->seconds_classify = qni_seconds() - start;
    QN_TRY(qni_gpu_alloc_mesh(all->context, all->job, all->job->field.grid, mesh_out, error));
    QN_TRY(emit_all(all, *mesh_out, error));
    qni_gpu_fill_report(all->job, report);
    report->scratch_bytes = all->scratch_bytes;
    report->device_slabs = all->count;
    report->seconds_emit = qni_seconds() - start - report->seconds_classify;
    return QN_OK;
}

/* With slabs of so many layers; *need > budget or a full pool says that these are too many. */
static qn_status attempt(slabs *all, int32_t layers, int64_t budget, int64_t *need,
                         qn_mesh **mesh_out, qn_surface_report *report, qn_error *error) {
    *need = 0;
    QN_TRY(make_list(all, layers, error));
    const qn_status status = both_passes(all, budget, need, mesh_out, report, error);
    qni_free(all->context, all->list, all->count, sizeof *all->list);
    if (status != QN_OK) {
        qn_mesh_destroy(*mesh_out);
        *mesh_out = NULL;
        qni_gpu_free_marks(all->context, all->job);
        qni_gpu_pool_free(all->job->pool);
    }
    return status;
}

qn_status qni_gpu_surface_in_slabs(qn_context *context, qni_gpu_job *job, int32_t most_layers,
                                   qn_mesh **mesh_out, qn_surface_report *report, qn_error *error) {
    slabs all = {.context = context, .job = job};
    const int64_t budget = qni_gpu_budget(job->pool->device);
    int32_t layers = layers_that_fit(&all, most_layers, budget);
    for (;;) {
        int64_t need;
        job->pool->is_full = false;
        const qn_status status = attempt(&all, layers, budget, &need, mesh_out, report, error);
        if (status == QN_OK || layers == 1 || !(job->pool->is_full || need > budget))
            return status;
        const int64_t fewer =
            need > budget ? (int64_t)((double)layers * (double)budget / (double)need) : layers / 2;
        layers = (int32_t)clamp(fewer, 1, layers - 1);
    }
}
