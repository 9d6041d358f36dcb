// SPDX-License-Identifier: MIT
/* The first merges, nearly all there are: one pass over the quads finds those that may go by the
 * valences of their corners, as emission gave them; then they are taken colour by colour. Within
 * one colour none hinders another (simplify_hd.h), so a look at the two corners of valence 3
 * decides, and no neighbours need to be known. Once all are known, the new vertices are put in
 * place in the order of the mesh: X and Y have more than 3 quads and are never merged here, so each
 * sees its corners as they were emitted. [DMC21] section 4.1. */
#include "dmc/marks.h"
#include "dmc/project.h"
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

/* What the valences say of a quad; more than merges and rings where that is not sure. */
static int kind_of(const uint32_t *corner, const uint8_t *valence) {
    const uint32_t four = valence[corner[0]] | (uint32_t)valence[corner[1]] << 8 |
                          (uint32_t)valence[corner[2]] << 16 | (uint32_t)valence[corner[3]] << 24;
    return qni_kind_of_valences(four & UINT32_C(0x3f3f3f3f)) | !qni_are_plain(four) << 2;
}

static bool find_in_block(const qni_simplifier *job, int64_t from, int64_t end, part *own) {
    uint32_t found[BLOCK + 1];
    const uint32_t *corners = job->mesh->quads + 4 * from;
    const uint8_t *valence = job->around.valence;
    const int64_t some = find_diagonals(corners, valence, end - from, found);
    if (!qni_numbers_reserve(job->context, &own->suspects, some))
        return false;
    for (int list = 0; list < LISTS; ++list)
        if (!qni_numbers_reserve(job->context, own->merges + list, some))
            return false;
    for (int64_t n = 0; n < some; ++n) {
        const int64_t quad = from + found[n];
        const int kind = kind_of(corners + 4 * (size_t)found[n], valence);
        qni_numbers *list = qni_is_merge(kind) ? own->merges + 2 * job->around.colour[quad] +
                                                     (kind == QNI_QUAD_MERGES_13)
                                               : &own->suspects;
        list->items[list->count] = (uint32_t)quad;
        list->count += (kind & 3) != QNI_QUAD_STAYS;
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

/* Those go that have no corner of valence 3 in common with one that was taken. */
static void take(const qni_simplifier *job, const qni_numbers *list, size_t odd, part *own) {
    uint8_t *valence = job->around.valence;
    for (int64_t n = 0; n < list->count; ++n) {
        const uint32_t *v = job->mesh->quads + 4 * (size_t)list->items[n];
        const uint32_t one = v[odd], other = v[odd + 2];
        if (n + AHEAD < list->count)
            __builtin_prefetch(job->mesh->quads + 4 * (size_t)list->items[n + AHEAD]);
        if (valence[one] != 3 || valence[other] != 3)
            continue;
        valence[one < other ? one : other] = 4 | QNI_VALENCE_MERGED;
        valence[one < other ? other : one] = QNI_VALENCE_GONE;
        job->around.colour[list->items[n]] = QNI_QUAD_GONE;
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

static bool is_gone(const qni_simplifier *job, uint32_t vertex) {
    return __atomic_load_n(job->around.valence + vertex, __ATOMIC_RELAXED) == QNI_VALENCE_GONE;
}

/* Some of the quads that were taken, from `*at` on. */
static int list_taken(const qni_simplifier *job, int64_t *at, int64_t end, uint32_t *quads) {
    int count = 0;
    for (; count <= QNI_LANDINGS - 8 && *at < end; *at += 8)
        for (uint64_t gone = qni_gone_among(job->around.colour, *at, end); gone; gone &= gone - 1) {
            quads[count] = (uint32_t)*at + (uint32_t)qni_first_gone(gone);
            __builtin_prefetch(job->mesh->quads + 4 * (size_t)quads[count]);
            if (job->mesh->twins)
                __builtin_prefetch(job->mesh->twins + 4 * (size_t)quads[count]);
            ++count;
        }
    return count;
}

static void expect_corners(const qn_mesh *mesh, const uint32_t corner[4]) {
    for (int k = 0; k < 4; ++k) {
        __builtin_prefetch(mesh->positions + 3 * (size_t)corner[k]);
        if (mesh->normals)
            __builtin_prefetch(mesh->normals + 3 * (size_t)corner[k]);
    }
}

/* All but the vertex' place. */
static void merge(const qni_simplifier *job, uint32_t quad, qni_merged *merged, part *own) {
    const qn_mesh *mesh = job->mesh;
    const uint32_t *v = mesh->quads + 4 * (size_t)quad;
    size_t k = !is_gone(job, v[0]) && !is_gone(job, v[2]);
    if (v[k] > v[k ^ 2])
        k ^= 2;
    const uint32_t a = v[k], b = v[k ^ 2], x = v[(k + 1) & 3], y = v[(k + 3) & 3];
    job->around.circle[a] = b;
    job->around.circle[b] = a;
    drop_valence(job, x, own);
    drop_valence(job, y, own);
    if (mesh->twins)
        qni_close_merge(mesh->twins, mesh->vertex_halfedges, 4 * quad + (uint32_t)k, a, x, y);
    *merged = (qni_merged){a, b, x, y};
    expect_corners(mesh, v);
}

/* Memory is far: while some vertices are put in place, what the next need is on its way. */
static void carry_out(const qni_simplifier *job, int32_t t, part *own) {
    enum { STEPS = 4 }; /* listed, corners asked for, samples asked for, put in place */
    uint32_t quads[STEPS][QNI_LANDINGS];
    qni_placing placing[STEPS];
    const int64_t count = job->mesh->quad_count, end = count * (t + 1) / job->threads;
    int64_t at = count * t / job->threads;
    for (int n = 0; n < STEPS; ++n)
        placing[n].count = 0;
    for (unsigned n = 0, rest = STEPS; rest > 0; ++n) {
        const unsigned list = n % STEPS, corners = (n + 3) % STEPS, start = (n + 2) % STEPS;
        placing[list].count = list_taken(job, &at, end, quads[list]);
        for (int m = 0; m < placing[corners].count; ++m)
            merge(job, quads[corners][m], placing[corners].merged + m, own);
        if (placing[start].count > 0)
            qni_simplify_start_placing(job, placing + start);
        if (placing[(n + 1) % STEPS].count > 0)
            own->unprojected += qni_simplify_end_placing(job, placing + (n + 1) % STEPS);
        rest = placing[list].count > 0 ? STEPS : rest - 1;
    }
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
    const bool failed = any_failed(job, parts);
    for (int colour = 0; colour < QNI_COLOURS && !failed; ++colour) {
#pragma omp parallel for schedule(static, 1) num_threads(threads)
        for (int32_t t = 0; t < threads; ++t)
            for (size_t odd = 0; odd < 2; ++odd)
                take(job, parts[t].merges + 2 * (size_t)colour + odd, odd, parts + t);
    }
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int32_t t = 0; t < threads; ++t)
        if (!failed)
            carry_out(job, t, parts + t);
    qni_simplify_note_memory(job);
    const qn_status status = any_failed(job, parts)
                                 ? qni_fail_memory(error, "the list of quads to remove")
                                 : gather(job, parts, error);
    free_parts(job, parts);
    return status;
}
