// SPDX-License-Identifier: MIT
/* The first merges, nearly all there are: one pass over the quads finds those that may go by the
 * valences of their corners, as emission gave them; then they are taken colour by colour. Within
 * one colour none hinders another (simplify_hd.h), so a look at the two corners of valence 3
 * decides, and no neighbours need to be known. [DMC21] section 4.1. */
#include "dmc/project_hd.h"
#include "dmc/simplify_parts.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

enum { BLOCK = 1024, LISTS = 2 * QNI_COLOURS, AHEAD = 12 };

/* What one thread finds in its part of the quads. */
typedef struct part {
    qni_numbers merges[LISTS]; /* 2 colour + 1 where corners 1 and 3 have valence 3 */
    qni_numbers suspects;
    qni_numbers dropped; /* vertices that came down to 3 */
    int64_t merged, unprojected;
    bool failed;
} part;

/* ---- places ---------------------------------------------------------------------------------- */

static void start_landing(const qn_mesh *mesh, const qni_merged *merged, bool move,
                          qni_landing *landing) {
    qni_middle_of_pair(mesh->positions, mesh->normals, merged->a, merged->b, landing->position,
                       landing->normal);
    if (move)
        qni_move_between(mesh->positions, mesh->normals, merged->x, merged->y, landing->position,
                         landing->normal);
    landing->landed = false;
}

int64_t qni_simplify_place(const qni_simplifier *job, const qni_merged *merged, int64_t count) {
    const qn_mesh *mesh = job->mesh;
    const qni_simplify_options *options = job->options;
    qni_landing landing[QNI_PLACED_TOGETHER];
    int64_t unprojected = 0;
    for (int64_t n = 0; n < count; ++n)
        start_landing(mesh, merged + n, options->project != NULL, landing + n);
    if (options->project)
        options->project(options->project_user, landing, (int)count);
    for (int64_t n = 0; n < count; ++n) {
        const size_t at = 3 * (size_t)merged[n].a;
        if (landing[n].landed || !options->project) /* else the kept one is on the surface */
            memcpy(mesh->positions + at, landing[n].position, sizeof landing[n].position);
        else
            ++unprojected;
        if (mesh->normals)
            memcpy(mesh->normals + at, landing[n].normal, sizeof landing[n].normal);
    }
    return unprojected;
}

/* ---- finding --------------------------------------------------------------------------------- */

/* The quads of a block with two opposite corners of valence 3, which all that may go have; without
 * branches, so that the processor can run ahead. */
static int64_t find_diagonals(const uint32_t *corner, const uint8_t *valence, int64_t count,
                              uint32_t *found) {
    int64_t some = 0;
    for (int64_t n = 0; n < count; ++n, corner += 4) {
        const unsigned even = (valence[corner[0]] ^ 3u) | (valence[corner[2]] ^ 3u);
        const unsigned odd = (valence[corner[1]] ^ 3u) | (valence[corner[3]] ^ 3u);
        found[some] = (uint32_t)n;
        some += !(even & QNI_VALENCE_MASK) | !(odd & QNI_VALENCE_MASK);
    }
    return some;
}

/* What the valences say of the quads found; those of which they say anything stay. */
static int64_t find_kinds(const uint32_t *corners, const uint8_t *valence, int64_t count,
                          uint32_t *found, uint8_t *kind) {
    int64_t some = 0;
    for (int64_t n = 0; n < count; ++n) {
        const uint32_t quad = found[n], *corner = corners + 4 * (size_t)quad;
        const uint32_t four = valence[corner[0]] | (uint32_t)valence[corner[1]] << 8 |
                              (uint32_t)valence[corner[2]] << 16 |
                              (uint32_t)valence[corner[3]] << 24;
        const int own = qni_kind_of_valences(four & UINT32_C(0x3f3f3f3f));
        found[some] = quad;
        kind[some] = (uint8_t)(own | !qni_are_plain(four) << 2);
        some += own != QNI_QUAD_STAYS;
    }
    return some;
}

static bool find_in_block(const qni_simplifier *job, int64_t from, int64_t end, part *own) {
    uint32_t found[BLOCK + 1];
    uint8_t kind[BLOCK + 1];
    const uint32_t *corners = job->mesh->quads + 4 * from;
    const uint8_t *valence = job->around.valence;
    const int64_t some = find_kinds(
        corners, valence, find_diagonals(corners, valence, end - from, found), found, kind);
    if (!qni_numbers_reserve(job->context, &own->suspects, some))
        return false;
    for (int list = 0; list < LISTS; ++list)
        if (!qni_numbers_reserve(job->context, own->merges + list, some))
            return false;
    for (int64_t n = 0; n < some; ++n) {
        const int64_t quad = from + found[n];
        const int as = kind[n];
        qni_numbers *list = qni_is_merge(as) ? own->merges + 2 * job->around.colour[quad] +
                                                   (as == QNI_QUAD_MERGES_13)
                                             : &own->suspects;
        list->items[list->count++] = (uint32_t)quad;
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

/* ---- merging --------------------------------------------------------------------------------- */

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

/* Take a quad unless a neighbour has taken one of its corners of valence 3. */
static bool merge(const qni_simplifier *job, uint32_t quad, size_t odd, qni_merged *merged,
                  part *own) {
    const qni_around *around = &job->around;
    const uint32_t *v = job->mesh->quads + 4 * (size_t)quad;
    size_t k = odd;
    if (around->valence[v[k]] != 3 || around->valence[v[k ^ 2]] != 3)
        return false;
    if (v[k] > v[k ^ 2])
        k ^= 2;
    const uint32_t a = v[k], b = v[k ^ 2], x = v[(k + 1) & 3], y = v[(k + 3) & 3];
    around->valence[a] = 4 | QNI_VALENCE_MERGED;
    around->valence[b] = QNI_VALENCE_GONE;
    around->circle[a] = b;
    around->circle[b] = a;
    around->colour[quad] = QNI_QUAD_GONE;
    drop_valence(job, x, own);
    drop_valence(job, y, own);
    if (job->mesh->twins)
        qni_close_merge(job->mesh->twins, job->mesh->vertex_halfedges, 4 * quad + (uint32_t)k, a, x,
                        y);
    *merged = (qni_merged){a, b, x, y};
    return true;
}

static void expect_places(const qn_mesh *mesh, const qni_merged *merged) {
    const uint32_t vertex[4] = {merged->a, merged->b, merged->x, merged->y};
    for (int n = 0; n < 4; ++n)
        __builtin_prefetch(mesh->positions + 3 * (size_t)vertex[n], 1);
    for (int n = 0; mesh->normals && n < 2; ++n)
        __builtin_prefetch(mesh->normals + 3 * (size_t)vertex[n], 1);
}

static void merge_list(const qni_simplifier *job, const qni_numbers *list, size_t odd, part *own) {
    qni_merged merged[QNI_PLACED_TOGETHER];
    int64_t count = 0;
    for (int64_t n = 0; n < list->count; ++n) {
        if (n + AHEAD < list->count)
            __builtin_prefetch(job->mesh->quads + 4 * (size_t)list->items[n + AHEAD]);
        if (!merge(job, list->items[n], odd, merged + count, own))
            continue;
        expect_places(job->mesh, merged + count);
        ++own->merged;
        if (++count < QNI_PLACED_TOGETHER)
            continue;
        own->unprojected += qni_simplify_place(job, merged, count);
        count = 0;
    }
    own->unprojected += qni_simplify_place(job, merged, count);
}

/* ---- all of it ------------------------------------------------------------------------------- */

static void free_parts(const qni_simplifier *job, part *parts) {
    for (int32_t t = 0; t < job->threads; ++t) {
        for (int list = 0; list < LISTS; ++list)
            qni_numbers_free(job->context, parts[t].merges + list);
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
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int32_t t = 0; t < threads; ++t)
        find(job, t, parts + t);
    bool failed = any_failed(job, parts);
    for (int colour = 0; colour < QNI_COLOURS && !failed; ++colour) {
#pragma omp parallel for schedule(static, 1) num_threads(threads)
        for (int32_t t = 0; t < threads; ++t)
            for (size_t odd = 0; odd < 2; ++odd)
                merge_list(job, parts[t].merges + 2 * (size_t)colour + odd, odd, parts + t);
        failed = any_failed(job, parts);
    }
    qni_simplify_note_memory(job);
    const qn_status status =
        failed ? qni_fail_memory(error, "the list of quads to remove") : gather(job, parts, error);
    free_parts(job, parts);
    return status;
}
