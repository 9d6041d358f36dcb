// SPDX-License-Identifier: MIT
/* Simplification in rounds: of the quads that may go, those that go before all they touch are taken
 * at once, then the rest is looked at again. Every step reads what the step before left and writes
 * only what its own quad owns, so neither threads nor their number show in the result. [DMC21]
 * section 4. */
#include "dmc/simplify.h"
#include "dmc/simplify_hd.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* Kinds are read eight at a time, beyond the last quad's too. */
enum { BLOCK_BITS = 9, KINDS_BEYOND = 8, BLOCK = 1 << BLOCK_BITS, LANES = 16 };

typedef struct job {
    qn_context *context;
    qn_mesh *mesh;
    const qni_simplify_options *options;
    qni_links links;
    int32_t threads;
    int64_t blocks;
    int64_t *before;  /* [blocks + 1]: list entries before each block */
    uint8_t *touched; /* [blocks]: quads in the block are to be looked at */
    uint8_t *colours; /* [quads]: asked for, where there is a colour; else NULL */
    uint32_t *list;   /* [capacity]: quads that may go, ascending */
    uint8_t *taken;   /* [capacity]: those of this round */
    int64_t count, capacity;
    qni_simplify_report report;
} job;

/* ---- ahead of the work ----------------------------------------------------------------------- */

/* What is listed lies scattered in the arrays: it is asked for some items ahead, its surroundings,
 * which are found through it, a few items ahead. */
enum { AHEAD_FAR = 16, AHEAD_NEAR = 8 };

static void expect_quad(const qni_links *links, uint32_t quad) {
    __builtin_prefetch(links->twin + 4 * (size_t)quad);
    __builtin_prefetch(links->origin + 4 * (size_t)quad);
}

static void expect_round(const qni_links *links, uint32_t quad) {
    for (uint32_t k = 0; k < 4; ++k) {
        const uint32_t twin = links->twin[4 * (size_t)quad + k];
        if (twin == QNI_UNPAIRED)
            continue;
        __builtin_prefetch(links->twin + twin);
        __builtin_prefetch(links->origin + twin);
    }
}

static void expect_corners(const qn_mesh *mesh, uint32_t quad) {
    for (int k = 0; k < 4; ++k) {
        const size_t vertex = mesh->quads[4 * (size_t)quad + k];
        __builtin_prefetch(mesh->positions + 3 * vertex);
        __builtin_prefetch(mesh->vertex_halfedges + vertex);
        if (mesh->normals)
            __builtin_prefetch(mesh->normals + 3 * vertex);
    }
}

/* Item n of a list is at hand. */
static void expect(const job *j, const uint32_t *list, int64_t n, int64_t count, bool corners) {
    if (n + AHEAD_FAR < count)
        expect_quad(&j->links, list[n + AHEAD_FAR]);
    if (n + AHEAD_NEAR < count) {
        expect_round(&j->links, list[n + AHEAD_NEAR]);
        if (corners)
            expect_corners(j->mesh, list[n + AHEAD_NEAR]);
    }
}

/* ---- valences -------------------------------------------------------------------------------- */

/* Sides at a vertex, by its own halfedge; its valence is noted. */
static uint32_t measure_fan(const qni_links *links, int64_t v) {
    const uint32_t start = links->vertex_halfedge[v];
    int closed = 0;
    const uint32_t size = start == QN_NO_HALFEDGE ? 0 : qni_fan_size(links->twin, start, &closed);
    links->valence[v] = (uint8_t)(closed && size < QNI_VALENCE_GONE ? size : QNI_VALENCE_FIXED);
    return size;
}

/* The same for LANES vertices side by side, so that their loads overlap and no branch has to guess
 * a valence. Fans that are open or do not close within 6 steps are measured one by one. */
static int64_t measure_fans_beside(const qni_links *links, int64_t first) {
    const uint32_t *start = links->vertex_halfedge + first, *twin = links->twin;
    uint32_t at[LANES], size[LANES], apart[LANES];
    int64_t sides = 0;
    for (int l = 0; l < LANES; ++l) {
        apart[l] = start[l] == QN_NO_HALFEDGE;
        at[l] = apart[l] ? 0 : start[l];
        size[l] = 0;
    }
    for (uint32_t n = 1; n <= 6; ++n)
        for (int l = 0; l < LANES; ++l) {
            const uint32_t next = qni_next_round(twin, at[l]), open = next == QN_NO_HALFEDGE;
            apart[l] |= open;
            at[l] = next & (open - 1); /* 0 where it is open: any will do */
            size[l] |= n & (uint32_t) - ((size[l] == 0) & (next == start[l]));
        }
    for (int l = 0; l < LANES; ++l) {
        links->valence[first + l] = (uint8_t)size[l];
        sides += apart[l] | (size[l] == 0) ? measure_fan(links, first + l) : size[l];
    }
    return sides;
}

static int64_t measure_fans(const job *j) {
    const int64_t count = j->mesh->vertex_count, groups = count / LANES;
    int64_t sides = 0;
#pragma omp parallel for schedule(static) num_threads(j->threads) reduction(+ : sides)
    for (int64_t g = 0; g < groups; ++g)
        sides += measure_fans_beside(&j->links, g * LANES);
    for (int64_t v = groups * LANES; v < count; ++v)
        sides += measure_fan(&j->links, v);
    return sides;
}

/* Vertices where several fans meet stay as they are: mark what each vertex' own fan holds; other
 * sides show the rest. */
static qn_status fix_shared_vertices(job *j, qn_error *error) {
    const qni_links *links = &j->links;
    const int64_t sides = 4 * j->mesh->quad_count;
    uint8_t *held = qni_alloc_zero(j->context, sides, 1);
    if (!held)
        return qni_fail_memory(error, "the marks of halfedges");
    for (int64_t v = 0; v < j->mesh->vertex_count; ++v) {
        const uint32_t start = links->vertex_halfedge[v];
        if (start == QN_NO_HALFEDGE)
            continue;
        uint32_t h = start;
        do {
            held[h] = 1;
            h = qni_next_round(links->twin, h);
        } while (h != start && h != QN_NO_HALFEDGE);
    }
    for (int64_t h = 0; h < sides; ++h)
        if (!held[h])
            links->valence[links->origin[h]] = QNI_VALENCE_FIXED;
    qni_free(j->context, held, sides, 1);
    return QN_OK;
}

/* ---- the list -------------------------------------------------------------------------------- */

static bool belongs(int kind, bool rings) {
    return rings ? kind == QNI_QUAD_SHRINKS : qni_is_merge(kind);
}

/* Of eight quads those that are not known to stay: their kinds by the valences alone. The others
 * are listed. */
static int64_t sift_word(const job *j, int64_t first, uint64_t live, uint32_t *list,
                         int64_t count) {
    for (; live; live &= ~(UINT64_C(255) << (__builtin_ctzll(live) & 56))) {
        const int64_t q = first + (__builtin_ctzll(live) >> 3);
        const uint32_t *v = j->links.origin + 4 * q;
        const uint8_t *valence = j->links.valence;
        const int kind =
            qni_kind_of_valences(valence[v[0]], valence[v[1]], valence[v[2]], valence[v[3]]);
        j->links.kind[q] = QNI_QUAD_STAYS;
        list[count] = (uint32_t)q;
        count += kind != QNI_QUAD_STAYS;
    }
    return count;
}

static uint64_t kinds_at(const job *j, int64_t first) {
    uint64_t word;
    memcpy(&word, j->links.kind + first, sizeof word);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    word = __builtin_bswap64(word);
#endif
    return qni_live_kinds(word);
}

static int64_t end_of_block(const job *j, int64_t block) {
    const int64_t end = (block + 1) * BLOCK, quads = j->mesh->quad_count;
    return end < quads ? end : quads;
}

/* Kinds of the quads of one block that are not known to stay; how many belong to the pattern. */
static int64_t find_kinds_of_block(const job *j, int64_t block, bool rings) {
    uint32_t list[BLOCK + 1];
    int64_t count = 0, found = 0, others = 0;
    for (int64_t q = block * BLOCK; q < end_of_block(j, block); q += 8)
        count = sift_word(j, q, kinds_at(j, q), list, count);
    for (int64_t n = 0; n < count; ++n) {
        const uint32_t q = list[n];
        if (n + AHEAD_NEAR < count)
            expect_round(&j->links, list[n + AHEAD_NEAR]);
        const int kind = qni_kind_of_quad(&j->links, q);
        j->links.kind[q] = (uint8_t)kind;
        if (j->colours && kind != QNI_QUAD_STAYS)
            j->colours[q] = j->options->colour(j->options->colour_user, j->mesh, q);
        found += belongs(kind, rings);
        others += kind != QNI_QUAD_STAYS;
    }
    j->touched[block] = others != 0;
    return found;
}

/* The same for all blocks; before[] becomes the sums. */
static void find_kinds(job *j, bool rings) {
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t b = 0; b < j->blocks; ++b) {
        j->before[b] = 0;
        if (j->touched[b])
            j->before[b] = find_kinds_of_block(j, b, rings);
    }
    int64_t sum = 0;
    for (int64_t b = 0; b <= j->blocks; ++b) {
        const int64_t found = b < j->blocks ? j->before[b] : 0;
        j->before[b] = sum;
        sum += found;
    }
}

static qn_status reserve_list(job *j, int64_t count, qn_error *error) {
    if (count <= j->capacity)
        return QN_OK;
    qni_free(j->context, j->list, j->capacity, sizeof *j->list);
    qni_free(j->context, j->taken, j->capacity, sizeof *j->taken);
    j->list = qni_alloc(j->context, count, sizeof *j->list);
    j->taken = qni_alloc(j->context, count, sizeof *j->taken);
    j->capacity = count;
    return j->list && j->taken ? QN_OK : qni_fail_memory(error, "the list of quads to remove");
}

static qn_status list_candidates(job *j, bool rings, qn_error *error) {
    find_kinds(j, rings);
    j->count = j->before[j->blocks];
    QN_TRY(reserve_list(j, j->count, error));
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t b = 0; b < j->blocks; ++b) {
        uint32_t *next = j->list + j->before[b];
        if (j->before[b] == j->before[b + 1])
            continue;
        for (int64_t q = b * BLOCK; q < end_of_block(j, b); q += 8)
            for (uint64_t live = kinds_at(j, q); live;
                 live &= ~(UINT64_C(255) << (__builtin_ctzll(live) & 56))) {
                const int64_t at = q + (__builtin_ctzll(live) >> 3);
                if (belongs(j->links.kind[at], rings))
                    *next++ = (uint32_t)at;
            }
    }
    return QN_OK;
}

/* ---- deciding -------------------------------------------------------------------------------- */

/* One look at all that is still open; how many remain so. */
static int64_t decide_open(job *j, bool rings) {
    int64_t open = 0;
#pragma omp parallel for schedule(static) num_threads(j->threads) reduction(+ : open)
    for (int64_t n = 0; n < j->count; ++n) {
        uint8_t *kind = j->links.kind + j->list[n];
        if (n + AHEAD_FAR < j->count)
            __builtin_prefetch(j->links.twin + 4 * (size_t)j->list[n + AHEAD_FAR]);
        if (*kind & (QNI_TAKEN | QNI_LEFT))
            continue;
        const int decision = rings ? qni_decide_shrink(&j->links, j->list[n])
                                   : qni_decide_merge(&j->links, j->list[n]);
        if (decision)
            __atomic_store_n(kind, (uint8_t)(*kind | decision), __ATOMIC_RELAXED);
        else
            ++open;
    }
    return open;
}

/* A largest set of operations that do not hinder each other: nothing can be added to it. */
static qn_status decide(job *j, bool rings, qn_error *error) {
    for (int64_t open = j->count; open > 0;) {
        if (qni_progress(j->context, "simplify", 1 - (double)open / (double)j->count))
            return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
        open = decide_open(j, rings);
    }
    return QN_OK;
}

/* [DMC21] section 4.1, steps 2 and 5: one look each. First those go that have no neighbour of the
 * pattern with a colour as low; then, of those that still have the pattern, the ones that share no
 * corner of valence 3 with another. */
static void decide_as_paper(job *j, bool alone) {
    const qni_links *links = &j->links;
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t n = 0; n < j->count; ++n) {
        const uint32_t quad = j->list[n];
        bool goes = true;
        for (uint32_t k = 0; k < 4; ++k) {
            const uint32_t other = links->twin[4 * quad + k] >> 2;
            const bool lower =
                alone || !links->colour || links->colour[other] <= links->colour[quad];
            goes = goes && !(lower && qni_is_merge(qni_kind_now(links, other) & QNI_KIND_MASK));
        }
        __atomic_store_n(links->kind + quad,
                         (uint8_t)(links->kind[quad] | (goes ? QNI_TAKEN : QNI_LEFT)),
                         __ATOMIC_RELAXED);
    }
}

/* ---- carrying out ---------------------------------------------------------------------------- */

static void place_merged(const job *j, uint32_t kept, uint32_t gone, int64_t *unprojected) {
    float *p = j->mesh->positions + 3 * (int64_t)kept;
    const float *q = j->mesh->positions + 3 * (int64_t)gone;
    const float at_kept[3] = {p[0], p[1], p[2]};
    float normal[3] = {0, 0, 0};
    for (int a = 0; a < 3; ++a)
        p[a] = 0.5f * p[a] + 0.5f * q[a];
    if (j->mesh->normals) {
        float *n = j->mesh->normals + 3 * (int64_t)kept;
        const float *m = j->mesh->normals + 3 * (int64_t)gone;
        const float sum[3] = {n[0] + m[0], n[1] + m[1], n[2] + m[2]};
        const float squares = (sum[0] * sum[0] + sum[1] * sum[1]) + sum[2] * sum[2];
        if (squares > 1e-6f) { /* else they are opposite, and the kept one is as good as any */
            const float scale = 1 / sqrtf(squares);
            for (int a = 0; a < 3; ++a)
                n[a] = sum[a] * scale;
        }
        memcpy(normal, n, sizeof normal);
    }
    if (j->options->project && !j->options->project(j->options->project_user, normal, p)) {
        memcpy(p, at_kept, sizeof at_kept); /* that one is on the surface */
        ++*unprojected;
    }
}

/* Quads round a vertex may have become ones that can go. Several may set the same mark here at
 * once. */
static void mark_pending(const job *j, uint32_t quad) {
    __atomic_store_n(j->links.kind + quad, (uint8_t)QNI_PENDING, __ATOMIC_RELAXED);
    __atomic_store_n(j->touched + (quad >> BLOCK_BITS), (uint8_t)1, __ATOMIC_RELAXED);
}

static void mark_pending_round(const job *j, uint32_t start) {
    uint32_t h = start;
    do {
        if (qni_kind_now(&j->links, h >> 2) == QNI_QUAD_STAYS)
            mark_pending(j, h >> 2);
        h = qni_next_round(j->links.twin, h);
    } while (h != start);
}

static bool is_taken(const job *j, int64_t n) {
    return j->links.kind[j->list[n]] & QNI_TAKEN;
}

/* A merged vertex has come up to valence 4: rings that have it as an outer corner may shrink now.
 * The middle of such a ring lies across from it at a neighbour of valence 3. */
static void mark_middles(const job *j, uint32_t start) {
    const qni_links *links = &j->links;
    uint32_t h = start;
    do {
        const uint32_t ahead = qni_next_side(h);
        if (links->valence[links->origin[ahead]] == 3) {
            const uint32_t middle = links->twin[ahead] >> 2;
            if (qni_kind_now(links, middle) == QNI_QUAD_STAYS &&
                qni_kind_of_quad(links, middle) == QNI_QUAD_SHRINKS)
                mark_pending(j, middle);
        }
        h = qni_next_round(links->twin, h);
    } while (h != start);
}

/* What the changes round one quad that was taken may have opened: quads round vertices that have
 * come down to valence 3, and rings round vertices that have come up. */
static void mark_neighbours(const job *j, uint32_t quad, bool rings) {
    const qni_links *links = &j->links;
    const uint32_t first = (links->kind[quad] & QNI_KIND_MASK) - QNI_QUAD_MERGES_02;
    for (uint32_t k = rings ? 0 : first; k < 4; k += rings ? 1 : 2) {
        const uint32_t start = rings ? 4 * quad + k : links->twin[4 * quad + k];
        if (links->valence[links->origin[start]] == 3)
            mark_pending_round(j, start);
    }
    if (!rings)
        mark_middles(j, links->twin[4 * quad + first + 1]);
}

/* Strike off what is done, and say what must be looked at again. */
static void settle(job *j, bool rings) {
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t n = 0; n < j->count; ++n) {
        expect(j, j->list, n, j->count, false);
        if (is_taken(j, n))
            mark_neighbours(j, j->list[n], rings);
    }
#pragma omp parallel for schedule(static) num_threads(j->threads)
    for (int64_t n = 0; n < j->count; ++n) {
        uint8_t *kind = j->links.kind + j->list[n];
        if (*kind & QNI_TAKEN && !rings)
            *kind = QNI_QUAD_GONE;
        else
            mark_pending(j, j->list[n]);
    }
}

static void carry_out_merges(job *j) {
    int64_t merged = 0, unprojected = 0;
#pragma omp parallel for schedule(static) num_threads(j->threads) reduction(+ : merged, unprojected)
    for (int64_t n = 0; n < j->count; ++n) {
        expect(j, j->list, n, j->count, true);
        if (is_taken(j, n)) {
            uint32_t gone;
            const uint32_t kept = qni_merge(&j->links, j->list[n], &gone);
            place_merged(j, kept, gone, &unprojected);
            ++merged;
        }
    }
    j->report.merged_quads += merged;
    j->report.unprojected += unprojected;
}

static void carry_out_shrinks(job *j) {
    int64_t shrunk = 0;
#pragma omp parallel for schedule(static) num_threads(j->threads) reduction(+ : shrunk)
    for (int64_t n = 0; n < j->count; ++n)
        if (is_taken(j, n)) {
            qni_shrink(&j->links, j->list[n]);
            shrunk += 4;
        }
    j->report.shrunk_quads += shrunk;
}

/* ---- all of it ------------------------------------------------------------------------------- */

static void carry_out(job *j, bool rings) {
    if (rings)
        carry_out_shrinks(j);
    else
        carry_out_merges(j);
    settle(j, rings);
}

static qn_status remove_pattern(job *j, bool rings, qn_error *error) {
    QN_TRY(list_candidates(j, rings, error));
    QN_TRY(decide(j, rings, error));
    carry_out(j, rings);
    return QN_OK;
}

static qn_status run_passes(job *j, qn_error *error) {
    int64_t before;
    do {
        before = j->report.merged_quads + j->report.shrunk_quads;
        QN_TRY(remove_pattern(j, false, error));
        QN_TRY(remove_pattern(j, true, error));
        ++j->report.passes;
    } while (j->report.merged_quads + j->report.shrunk_quads > before &&
             j->report.passes != j->options->passes);
    return QN_OK;
}

static qn_status run_as_paper(job *j, qn_error *error) {
    for (int step = 0; step < 2; ++step) {
        QN_TRY(list_candidates(j, false, error));
        decide_as_paper(j, step == 1);
        carry_out(j, false);
    }
    j->report.passes = 1;
    return remove_pattern(j, true, error);
}

static qn_status run(job *j, qn_error *error) {
    memset(j->links.kind, QNI_PENDING, (size_t)j->mesh->quad_count);
    memset(j->touched, 1, (size_t)j->blocks);
    memset(j->links.kind + j->mesh->quad_count, QNI_QUAD_GONE, KINDS_BEYOND);
    if (!j->options->valences && measure_fans(j) != 4 * j->mesh->quad_count)
        QN_TRY(fix_shared_vertices(j, error));
    if (j->options->paper)
        QN_TRY(run_as_paper(j, error));
    else
        QN_TRY(run_passes(j, error));
    return qni_compact_mesh(j->context, j->mesh, j->links.valence, j->links.kind, error);
}

qn_status qni_simplify(qn_context *context, qn_mesh *mesh, const qni_simplify_options *options,
                       qni_simplify_report *report_out, qn_error *error) {
    const double start = qni_seconds();
    const int64_t vertices = mesh->vertex_count, quads = mesh->quad_count;
    const int64_t held_before = qn_context_memory(context).current_bytes;
    job j = {.context = context,
             .mesh = mesh,
             .options = options,
             .threads = qn_context_threads(context)};
    memset(report_out, 0, sizeof *report_out);
    if (quads == 0)
        return QN_OK;
    if (mesh->triangle_count || !mesh->twins)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "only meshes of quads with halfedges can be simplified");
    j.blocks = (quads + BLOCK - 1) / BLOCK;
    j.before = qni_alloc(context, j.blocks + 1, sizeof *j.before);
    j.touched = qni_alloc(context, j.blocks, 1);
    uint8_t *valence = options->valences ? options->valences : qni_alloc(context, vertices + 1, 1),
            *kind = qni_alloc(context, quads + KINDS_BEYOND, 1);
    const bool asks = !options->colours && options->colour;
    j.colours = asks ? qni_alloc(context, quads, 1) : NULL;
    const qni_links links = {mesh->quads, mesh->twins, mesh->vertex_halfedges,
                             valence,     kind,        asks ? j.colours : options->colours};
    j.links = links;
    const bool good = j.before && j.touched && valence && kind && (j.colours || !asks);
    const qn_status status =
        good ? run(&j, error) : qni_fail_memory(error, "the marks of vertices and quads");
    j.report.scratch_bytes = qn_context_memory(context).current_bytes - held_before;
    qni_free(context, j.before, j.blocks + 1, sizeof *j.before);
    if (!options->valences)
        qni_free(context, valence, vertices + 1, 1);
    qni_free(context, kind, quads + KINDS_BEYOND, 1);
    qni_free(context, j.touched, j.blocks, 1);
    qni_free(context, j.colours, quads, 1);
    qni_free(context, j.list, j.capacity, sizeof *j.list);
    qni_free(context, j.taken, j.capacity, sizeof *j.taken);
    j.report.seconds = qni_seconds() - start;
    *report_out = j.report;
    return status;
}
