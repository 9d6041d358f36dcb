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
    bool taken;
} first_merge;

/* What one thread finds in its part of the quads, in their order. */
typedef struct part {
    first_merge *merges;
    int64_t merge_count, merge_capacity;
    qni_numbers of_colour[QNI_COLOURS]; /* which merges have it */
    qni_numbers rings;                  /* quads that may shrink */
    qni_numbers suspects;               /* others that may go, but want a closer look */
    qni_numbers dropped;                /* vertices that came down to 3 */
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

/* One lane's; those beyond the last are filled like the first, as kernels work on several. */
static void gather_corners(const qn_mesh *mesh, const qni_placing *placing, int lane,
                           qni_meetings *meetings) {
    const qni_merged *own = placing->merged + (lane < placing->count ? lane : 0);
    const uint32_t corner[4] = {own->a, own->b, own->x, own->y};
    for (int k = 0; k < 4; ++k) {
        gather_point(mesh->positions, corner[k], lane, meetings->position[k]);
        if (mesh->normals)
            gather_point(mesh->normals, corner[k], lane, meetings->normal[k]);
    }
}

static int lanes_of(const qni_placing *placing) {
    return (placing->count + QNI_LANES - 1) / QNI_LANES * QNI_LANES;
}

static void start_placing(const qni_simplifier *job, const qni_meetings *meetings,
                          qni_placing *placing) {
    const qni_projector *projector = job->options->projector;
    placing->landings.count = placing->count;
    job->kernels->meet(meetings, projector != NULL, &placing->landings);
    if (projector)
        qni_project_start(projector, &placing->landings, &placing->approach);
}

void qni_simplify_start_placing(const qni_simplifier *job, qni_placing *placing) {
    qni_meetings meetings;
    if (!job->mesh->normals)
        memset(meetings.normal, 0, sizeof meetings.normal);
    for (int n = 0; n < lanes_of(placing); ++n)
        gather_corners(job->mesh, placing, n, &meetings);
    start_placing(job, &meetings, placing);
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

/* What a vertex can be in a quad that may go. */
enum { CLASS_THREE = 1, CLASS_LARGE = 2, CLASS_APART = 4 };

/* The room for circles, of which there are none yet: each vertex' class. */
static uint8_t *classes_of(const qni_simplifier *job) {
    return (uint8_t *)job->around.circle;
}

static void note_classes(const qni_simplifier *job) {
    const int64_t count = job->mesh->vertex_count;
    const int32_t threads = job->threads;
    const uint8_t *restrict valence = job->around.valence;
    uint8_t *restrict class = classes_of(job);
    (void)threads;
#pragma omp parallel for simd schedule(static) num_threads(threads)
    for (int64_t v = 0; v < count; ++v) {
        const uint8_t own = valence[v] & QNI_VALENCE_MASK;
        class[v] = (uint8_t)((own == 3 ? CLASS_THREE : 0) | (own >= 5 ? CLASS_LARGE : 0) |
                             (valence[v] > QNI_VALENCE_MASK ? CLASS_APART : 0));
    }
}

/* The quads of a block that may go by qni_kind_of_valences(); without branches, so that the
 * processor can run ahead. Of the classes that two opposite corners have in common, threes are 1
 * and large ones 2, so their product with those of the other two corners is 4 when all are large.
 * It does not look beyond a page by itself. */
static int64_t find_kinds(const uint32_t *corner, const uint8_t *class, int64_t count,
                          uint32_t *found) {
    int64_t some = 0;
    for (int64_t n = 0; n < count; ++n, corner += 4) {
        __builtin_prefetch(corner + PAGE);
        const unsigned even = class[corner[0]] & class[corner[2]],
                       odd = class[corner[1]] & class[corner[3]];
        found[some] = (uint32_t)n;
        some += (even * odd & 3) != 0;
    }
    return some;
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
static first_merge merge_of(const uint32_t *corner, uint32_t quad, size_t side) {
    side ^= corner[side] > corner[side ^ 2] ? 2 : 0;
    return (first_merge){
        {corner[side], corner[side ^ 2], corner[(side + 1) & 3], corner[(side + 3) & 3]},
        quad,
        (uint8_t)side,
        false};
}

/* A quad that find_kinds() found. Classes stay what they were, so no other thread's finding
 * changes.
 */
static void list(const qni_simplifier *job, const uint32_t *corner, uint32_t quad, part *own) {
    const uint8_t *class = classes_of(job), colour = job->around.colour[quad];
    const unsigned even = class[corner[0]] & class[corner[2]],
                   odd = class[corner[1]] & class[corner[3]],
                   all = class[corner[0]] | class[corner[1]] | class[corner[2]] | class[corner[3]];
    if (even & odd & CLASS_THREE) {
        own->rings.items[own->rings.count++] = quad;
    } else if (all & CLASS_APART || colour >= QNI_COLOURS) {
        own->suspects.items[own->suspects.count++] = quad;
    } else {
        qni_numbers *of_colour = own->of_colour + colour;
        of_colour->items[of_colour->count++] = (uint32_t)own->merge_count;
        own->merges[own->merge_count++] = merge_of(corner, quad, !(even & CLASS_THREE));
    }
}

static bool reserve_all(const qni_simplifier *job, int64_t more, part *own) {
    bool good = qni_numbers_reserve(job->context, &own->suspects, more) &&
                qni_numbers_reserve(job->context, &own->rings, more) &&
                reserve_merges(job->context, own, more);
    for (int colour = 0; colour < QNI_COLOURS; ++colour)
        good = good && qni_numbers_reserve(job->context, own->of_colour + colour, more);
    return good;
}

static bool find_in_block(const qni_simplifier *job, int64_t from, int64_t end, part *own) {
    uint32_t found[BLOCK + 1];
    const uint32_t *corners = job->mesh->quads + 4 * from;
    const int64_t some = find_kinds(corners, classes_of(job), end - from, found);
    if (!reserve_all(job, some, own))
        return false;
    for (int64_t n = 0; n < some; ++n)
        list(job, corners + 4 * (size_t)found[n], (uint32_t)from + found[n], own);
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

/* Those of one colour go that have no corner of valence 3 in common with one that was taken;
 * without branches, since which do is hard to foresee. */
static void take(const qni_simplifier *job, int colour, part *own) {
    uint8_t unused, *valence = job->around.valence;
    for (int64_t n = 0; n < own->of_colour[colour].count; ++n) {
        first_merge *merge = own->merges + own->of_colour[colour].items[n];
        uint8_t *a = valence + merge->corner.a, *b = valence + merge->corner.b;
        merge->taken = (*a == 3) & (*b == 3);
        *(merge->taken ? a : &unused) = 4 | QNI_VALENCE_MERGED;
        *(merge->taken ? b : &unused) = QNI_VALENCE_GONE;
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

/* The halfedges across the quad's sides, which will be paired with each other. */
QN_HD_INLINE void expect_across(const qn_mesh *mesh, const first_merge *merge) {
    __builtin_prefetch(mesh->vertex_halfedges + merge->corner.a, 1);
    for (size_t k = 0; k < 4; ++k)
        __builtin_prefetch(mesh->twins + mesh->twins[4 * (size_t)merge->quad + k], 1);
}

/* The next that was taken, from `*at` on; NULL at the end. */
static const first_merge *next_taken(const qni_simplifier *job, const part *own, int64_t *at) {
    while (*at < own->merge_count && !own->merges[*at].taken)
        ++*at;
    if (*at == own->merge_count)
        return NULL;
    if (job->mesh->twins)
        expect_halfedges(job->mesh, own->merges + *at);
    return own->merges + (*at)++;
}

/* All but the vertex' place. */
static void merge(const qni_simplifier *job, const first_merge *merge, part *own) {
    const qn_mesh *mesh = job->mesh;
    const qni_merged *corner = &merge->corner;
    ++own->merged;
    job->around.colour[merge->quad] = QNI_QUAD_GONE;
    job->around.circle[corner->a] = corner->b;
    job->around.circle[corner->b] = corner->a;
    drop_valence(job, corner->x, own);
    drop_valence(job, corner->y, own);
    if (mesh->twins)
        qni_close_merge(mesh->twins, mesh->vertex_halfedges, 4 * merge->quad + merge->side,
                        corner->a, corner->x, corner->y);
    expect_corners(mesh, corner);
}

/* Some that are put in place together. */
typedef struct batch {
    const first_merge *list[QNI_LANDINGS];
    qni_placing placing;
} batch;

/* Memory is far: while some vertices are put in place, what the next need is on its way. It is
 * asked for little by little between other work, as not much can be on its way at once. */
enum { LISTED, ACROSS, CORNERS, SAMPLES, LAST, STEPS };

static void advance(const qni_simplifier *job, part *own, batch *const of[STEPS], int64_t *at) {
    qni_meetings meetings;
    batch *listed = of[LISTED];
    listed->placing.count = 0;
    if (!job->mesh->normals)
        memset(meetings.normal, 0, sizeof meetings.normal);
    for (int n = 0; n < QNI_LANDINGS; ++n) {
        const first_merge *next = next_taken(job, own, at);
        if (next)
            listed->list[listed->placing.count++] = next;
        if (n < of[ACROSS]->placing.count && job->mesh->twins)
            expect_across(job->mesh, of[ACROSS]->list[n]);
        if (n < of[CORNERS]->placing.count) {
            of[CORNERS]->placing.merged[n] = of[CORNERS]->list[n]->corner;
            merge(job, of[CORNERS]->list[n], own);
        }
        if (n < lanes_of(&of[SAMPLES]->placing))
            gather_corners(job->mesh, &of[SAMPLES]->placing, n, &meetings);
    }
    if (of[SAMPLES]->placing.count > 0)
        start_placing(job, &meetings, &of[SAMPLES]->placing);
    if (of[LAST]->placing.count > 0)
        own->unprojected += qni_simplify_end_placing(job, &of[LAST]->placing);
}

static void carry_out(const qni_simplifier *job, part *own) {
    batch batches[STEPS];
    int64_t at = 0;
    for (int n = 0; n < STEPS; ++n)
        batches[n].placing.count = 0;
    for (unsigned n = 0, rest = STEPS; rest > 0; ++n) {
        batch *const of[STEPS] = {[LISTED] = batches + n % STEPS,
                                  [ACROSS] = batches + (n + 4) % STEPS,
                                  [CORNERS] = batches + (n + 3) % STEPS,
                                  [SAMPLES] = batches + (n + 2) % STEPS,
                                  [LAST] = batches + (n + 1) % STEPS};
        advance(job, own, of, &at);
        rest = of[LISTED]->placing.count > 0 ? STEPS : rest - 1;
    }
}

/* ---- all of it ------------------------------------------------------------------------------- */

static void free_parts(const qni_simplifier *job, part *parts) {
    for (int32_t t = 0; t < job->threads; ++t) {
        qni_free(job->context, parts[t].merges, parts[t].merge_capacity, sizeof *parts[t].merges);
        for (int colour = 0; colour < QNI_COLOURS; ++colour)
            qni_numbers_free(job->context, parts[t].of_colour + colour);
        qni_numbers_free(job->context, &parts[t].rings);
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

static bool append(const qni_simplifier *job, const qni_numbers *from, qni_numbers *to) {
    if (!qni_numbers_reserve(job->context, to, from->count))
        return false;
    if (from->count > 0)
        memcpy(to->items + to->count, from->items, (size_t)from->count * sizeof *from->items);
    to->count += from->count;
    return true;
}

/* What the threads found, in the order of the quads. */
static qn_status gather(qni_simplifier *job, const part *parts, qn_error *error) {
    for (int32_t t = 0; t < job->threads; ++t) {
        if (!append(job, &parts[t].suspects, &job->suspects) ||
            !append(job, &parts[t].rings, &job->rings))
            return qni_fail_memory(error, "the list of quads to remove");
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
    note_classes(job);
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int32_t t = 0; t < threads; ++t)
        find(job, t, parts + t);
    const bool failed = any_failed(job, parts);
    for (int colour = 0; colour < QNI_COLOURS && !failed; ++colour) {
#pragma omp parallel for schedule(static, 1) num_threads(threads)
        for (int32_t t = 0; t < threads; ++t)
            take(job, colour, parts + t);
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
