// SPDX-License-Identifier: MIT
/* The first merges, nearly all there are: one pass over the quads finds those that may go by the
 * valences of their corners, as emission gave them; then they are taken colour by colour. Within
 * one colour none hinders another (simplify_hd.h), so a look at the two corners of valence 3
 * decides, and no neighbours need to be known. Once all are known, the new vertices are put in
 * place in the order of the mesh: X and Y have more than 3 quads and are never merged here, so each
 * sees its corners as they were emitted. [DMC21] section 4.1. */
#include "dmc/project.h"
#include "dmc/simplify_parts.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

enum { BLOCK = 1024, PAGE = 1024 }; /* quads; numbers, 4 KiB of them */

/* A quad that may go, with all that is needed of it: it is not looked at again. */
typedef struct first_merge {
    qni_merged corner;
    uint32_t quad;
    uint8_t side; /* which of the quad's starts at a */
    uint8_t colour;
    bool taken;
} first_merge;

/* What one thread finds in its part of the quads, in their order. */
typedef struct part {
    first_merge *merges;
    int64_t merge_count, merge_capacity;
    qni_numbers suspects;
    qni_numbers dropped; /* vertices that came down to 3 */
    int64_t merged, unprojected;
    bool failed;
} part;

/* ---- places ---------------------------------------------------------------------------------- */

static inline void gather_point(const float *points, uint32_t vertex, int lane,
                                float to[3][QNI_LANDINGS]) {
    const float *from = points + 3 * (size_t)vertex;
    to[0][lane] = from[0];
    to[1][lane] = from[1];
    to[2][lane] = from[2];
}

static inline void scatter_point(float from[3][QNI_LANDINGS], int lane, uint32_t vertex,
                                 float *points) {
    float *to = points + 3 * (size_t)vertex;
    to[0] = from[0][lane];
    to[1] = from[1][lane];
    to[2] = from[2][lane];
}

static void gather_corners(const qn_mesh *mesh, const qni_placing *placing,
                           qni_meetings *meetings) {
    const int count = placing->count;
    if (!mesh->normals)
        memset(meetings->normal, 0, sizeof meetings->normal);
    for (int n = 0; n < (count + QNI_LANES - 1) / QNI_LANES * QNI_LANES; ++n) {
        const qni_merged *own = placing->merged + (n < count ? n : 0);
        const uint32_t corner[4] = {own->a, own->b, own->x, own->y};
        for (int k = 0; k < 4; ++k) {
            gather_point(mesh->positions, corner[k], n, meetings->position[k]);
            if (mesh->normals)
                gather_point(mesh->normals, corner[k], n, meetings->normal[k]);
        }
    }
}

void qni_simplify_start_placing(const qni_simplifier *job, qni_placing *placing) {
    const qni_projector *projector = job->options->projector;
    qni_meetings meetings;
    placing->landings.count = placing->count;
    gather_corners(job->mesh, placing, &meetings);
    job->kernels->meet(&meetings, projector != NULL, &placing->landings);
    if (projector)
        qni_project_start(projector, &placing->landings, &placing->approach);
}

int64_t qni_simplify_end_placing(const qni_simplifier *job, qni_placing *placing) {
    const qni_projector *projector = job->options->projector;
    const qn_mesh *mesh = job->mesh;
    qni_landings *landings = &placing->landings;
    int64_t unprojected = 0;
    if (projector)
        qni_project_end(projector, &placing->approach, landings);
    for (int n = 0; n < placing->count; ++n) {
        const uint32_t kept = placing->merged[n].a;
        if (!projector || landings->landed[n]) /* else the kept one is on the surface */
            scatter_point(landings->position, n, kept, mesh->positions);
        else
            ++unprojected;
        if (mesh->normals)
            scatter_point(landings->normal, n, kept, mesh->normals);
    }
    return unprojected;
}

/* ---- finding --------------------------------------------------------------------------------- */

/* The room for circles, of which there are none yet: for each vertex whether its valence is 3. */
static uint8_t *threes_of(const qni_simplifier *job) {
    return (uint8_t *)job->around.circle;
}

static void note_threes(const qni_simplifier *job) {
    const int64_t count = job->mesh->vertex_count;
    const int32_t threads = job->threads;
    const uint8_t *restrict valence = job->around.valence;
    uint8_t *restrict three = threes_of(job);
    (void)threads;
#pragma omp parallel for simd schedule(static) num_threads(threads)
    for (int64_t v = 0; v < count; ++v)
        three[v] = (valence[v] & QNI_VALENCE_MASK) == 3;
}

/* The quads of a block with two opposite corners of valence 3, which all that may go have; without
 * branches, so that the processor can run ahead. It does not look beyond a page by itself. */
static int64_t find_diagonals(const uint32_t *corner, const uint8_t *three, int64_t count,
                              uint32_t *found) {
    int64_t some = 0;
    for (int64_t n = 0; n < count; ++n, corner += 4) {
        __builtin_prefetch(corner + PAGE);
        found[some] = (uint32_t)n;
        some += (three[corner[0]] & three[corner[2]]) | (three[corner[1]] & three[corner[3]]);
    }
    return some;
}

/* What the valences say of a quad; more than merges and rings where that is not sure. */
static int kind_of(const uint32_t *corner, const uint8_t *valence) {
    const uint32_t four = valence[corner[0]] | (uint32_t)valence[corner[1]] << 8 |
                          (uint32_t)valence[corner[2]] << 16 | (uint32_t)valence[corner[3]] << 24;
    return qni_kind_of_valences(four & UINT32_C(0x3f3f3f3f)) | !qni_are_plain(four) << 2;
}

static bool reserve_merges(qn_context *context, part *own, int64_t more) {
    const int64_t wanted = own->merge_count + more;
    if (wanted <= own->merge_capacity)
        return true;
    const int64_t capacity = wanted < 2 * own->merge_capacity ? 2 * own->merge_capacity : wanted;
    void *grown =
        qni_realloc(context, own->merges, own->merge_capacity, capacity, sizeof *own->merges);
    if (!grown)
        return false;
    own->merges = grown;
    own->merge_capacity = capacity;
    return true;
}

/* The quad's corners from `side` on: a comes first, and is the lower one. */
static first_merge merge_of(const uint32_t *corner, uint32_t quad, int kind, uint8_t colour) {
    size_t side = kind == QNI_QUAD_MERGES_13;
    side ^= corner[side] > corner[side ^ 2] ? 2 : 0;
    return (first_merge){
        {corner[side], corner[side ^ 2], corner[(side + 1) & 3], corner[(side + 3) & 3]},
        quad,
        (uint8_t)side,
        colour,
        false};
}

/* Leave those that may go by all of their corners, with their kinds; without branches here too. */
static int64_t keep_kinds(const uint32_t *corners, const uint8_t *valence, int64_t count,
                          uint32_t *found, uint8_t *kinds) {
    int64_t some = 0;
    for (int64_t n = 0; n < count; ++n) {
        const uint32_t quad = found[n];
        const int kind = kind_of(corners + 4 * (size_t)quad, valence);
        found[some] = quad;
        kinds[some] = (uint8_t)kind;
        some += (kind & 3) != QNI_QUAD_STAYS;
    }
    return some;
}

static bool find_in_block(const qni_simplifier *job, int64_t from, int64_t end, part *own) {
    uint32_t found[BLOCK + 1];
    uint8_t kinds[BLOCK + 1];
    const uint32_t *corners = job->mesh->quads + 4 * from;
    int64_t some = find_diagonals(corners, threes_of(job), end - from, found);
    some = keep_kinds(corners, job->around.valence, some, found, kinds);
    if (!qni_numbers_reserve(job->context, &own->suspects, some) ||
        !reserve_merges(job->context, own, some))
        return false;
    for (int64_t n = 0; n < some; ++n) {
        const uint32_t quad = (uint32_t)from + found[n];
        if (qni_is_merge(kinds[n]))
            own->merges[own->merge_count++] =
                merge_of(corners + 4 * (size_t)found[n], quad, kinds[n], job->around.colour[quad]);
        else
            own->suspects.items[own->suspects.count++] = quad;
    }
    return true;
}

static void find(const qni_simplifier *job, int32_t t, part *own) {
    const int64_t blocks = (job->mesh->quad_count + BLOCK - 1) / BLOCK;
    for (int64_t b = blocks * t / job->threads; b < blocks * (t + 1) / job->threads; ++b) {
        const int64_t end = (b + 1) * BLOCK;
        if (!find_in_block(job, b * BLOCK,
                           end < job->mesh->quad_count ? end : job->mesh->quad_count, own)) {
            own->failed = true;
            return;
        }
    }
}

/* ---- taking ---------------------------------------------------------------------------------- */

/* Those of one colour go that have no corner of valence 3 in common with one that was taken. */
static void take(const qni_simplifier *job, uint8_t colour, part *own) {
    uint8_t *valence = job->around.valence;
    for (int64_t n = 0; n < own->merge_count; ++n) {
        first_merge *merge = own->merges + n;
        const uint32_t a = merge->corner.a, b = merge->corner.b;
        if (merge->colour != colour || valence[a] != 3 || valence[b] != 3)
            continue;
        valence[a] = 4 | QNI_VALENCE_MERGED;
        valence[b] = QNI_VALENCE_GONE;
        job->around.colour[merge->quad] = QNI_QUAD_GONE;
        merge->taken = true;
        ++own->merged;
    }
}

/* ---- carrying out ---------------------------------------------------------------------------- */

/* One quad less round X or Y; several threads may say so at once. */
static void drop_valence(const qni_simplifier *job, uint32_t vertex, part *own) {
    uint8_t *valence = job->around.valence + vertex;
    const uint8_t old =
        job->threads > 1 ? __atomic_fetch_sub(valence, (uint8_t)1, __ATOMIC_RELAXED) : (*valence)--;
    if (old != 4)
        return;
    if (qni_numbers_reserve(job->context, &own->dropped, 1))
        own->dropped.items[own->dropped.count++] = vertex;
    else
        own->failed = true;
}

/* Always inline: gcc drops calls of functions that do no more than ask for memory. */
QN_HD_INLINE void expect_corners(const qn_mesh *mesh, const qni_merged *merged) {
    const uint32_t corner[4] = {merged->a, merged->b, merged->x, merged->y};
    for (int k = 0; k < 4; ++k) {
        __builtin_prefetch(mesh->positions + 3 * (size_t)corner[k]);
        if (mesh->normals)
            __builtin_prefetch(mesh->normals + 3 * (size_t)corner[k]);
    }
}

QN_HD_INLINE void expect_halfedges(const qn_mesh *mesh, const first_merge *merge) {
    __builtin_prefetch(mesh->twins + 4 * (size_t)merge->quad);
    __builtin_prefetch(mesh->vertex_halfedges + merge->corner.x);
    __builtin_prefetch(mesh->vertex_halfedges + merge->corner.y);
}

/* The next of those that were taken, from `*at` on; as many as are put in place together, fewer at
 * the end. */
static int list_taken(const qni_simplifier *job, const part *own, int64_t *at,
                      const first_merge **list) {
    int count = 0;
    for (; count < QNI_LANDINGS && *at < own->merge_count; ++*at) {
        const first_merge *merge = own->merges + *at;
        if (!merge->taken)
            continue;
        list[count++] = merge;
        if (job->mesh->twins)
            expect_halfedges(job->mesh, merge);
    }
    return count;
}

/* All but the vertex' place. */
static void merge(const qni_simplifier *job, const first_merge *merge, part *own) {
    const qn_mesh *mesh = job->mesh;
    const qni_merged *corner = &merge->corner;
    job->around.circle[corner->a] = corner->b;
    job->around.circle[corner->b] = corner->a;
    drop_valence(job, corner->x, own);
    drop_valence(job, corner->y, own);
    if (mesh->twins)
        qni_close_merge(mesh->twins, mesh->vertex_halfedges, 4 * merge->quad + merge->side,
                        corner->a, corner->x, corner->y);
    expect_corners(mesh, corner);
}

/* Memory is far: while some vertices are put in place, what the next need is on its way. */
static void carry_out(const qni_simplifier *job, part *own) {
    enum { STEPS = 4 }; /* listed, corners asked for, samples asked for, put in place */
    const first_merge *list[STEPS][QNI_LANDINGS];
    qni_placing placing[STEPS];
    int64_t at = 0;
    for (int n = 0; n < STEPS; ++n)
        placing[n].count = 0;
    for (unsigned n = 0, rest = STEPS; rest > 0; ++n) {
        const unsigned first = n % STEPS, second = (n + 3) % STEPS, third = (n + 2) % STEPS;
        placing[first].count = list_taken(job, own, &at, list[first]);
        for (int m = 0; m < placing[second].count; ++m) {
            merge(job, list[second][m], own);
            placing[second].merged[m] = list[second][m]->corner;
        }
        if (placing[third].count > 0)
            qni_simplify_start_placing(job, placing + third);
        if (placing[(n + 1) % STEPS].count > 0)
            own->unprojected += qni_simplify_end_placing(job, placing + (n + 1) % STEPS);
        rest = placing[first].count > 0 ? STEPS : rest - 1;
    }
}

/* ---- all of it ------------------------------------------------------------------------------- */

static void free_parts(const qni_simplifier *job, part *parts) {
    for (int32_t t = 0; t < job->threads; ++t) {
        qni_free(job->context, parts[t].merges, parts[t].merge_capacity, sizeof *parts[t].merges);
        qni_numbers_free(job->context, &parts[t].suspects);
        qni_numbers_free(job->context, &parts[t].dropped);
    }
    qni_free(job->context, parts, job->threads, sizeof *parts);
}

static bool any_failed(const qni_simplifier *job, const part *parts) {
    bool failed = false;
    for (int32_t t = 0; t < job->threads; ++t)
        failed = failed || parts[t].failed;
    return failed;
}

/* What the threads found, in the order of the quads. */
static qn_status gather(qni_simplifier *job, const part *parts, qn_error *error) {
    for (int32_t t = 0; t < job->threads; ++t) {
        const qni_numbers *found = &parts[t].suspects;
        if (!qni_numbers_reserve(job->context, &job->suspects, found->count))
            return qni_fail_memory(error, "the list of quads to remove");
        if (found->count > 0)
            memcpy(job->suspects.items + job->suspects.count, found->items,
                   (size_t)found->count * sizeof *found->items);
        job->suspects.count += found->count;
        job->report.merged_quads += parts[t].merged;
        job->report.unprojected += parts[t].unprojected;
    }
    for (int32_t t = 0; t < job->threads; ++t)
        QN_TRY(qni_simplify_suspect_round(job, &parts[t].dropped, error));
    return QN_OK;
}

qn_status qni_simplify_first(qni_simplifier *job, qn_error *error) {
    const int32_t threads = job->threads;
    part *parts = qni_alloc_zero(job->context, threads, sizeof *parts);
    if (!parts)
        return qni_fail_memory(error, "the worker threads");
    note_threes(job);
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int32_t t = 0; t < threads; ++t)
        find(job, t, parts + t);
    const bool failed = any_failed(job, parts);
    for (int colour = 0; colour < QNI_COLOURS && !failed; ++colour) {
#pragma omp parallel for schedule(static, 1) num_threads(threads)
        for (int32_t t = 0; t < threads; ++t)
            take(job, (uint8_t)colour, parts + t);
    }
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int32_t t = 0; t < threads; ++t)
        if (!failed)
            carry_out(job, parts + t);
    qni_simplify_note_memory(job);
    const qn_status status = any_failed(job, parts)
                                 ? qni_fail_memory(error, "the list of quads to remove")
                                 : gather(job, parts, error);
    free_parts(job, parts);
    return status;
}
