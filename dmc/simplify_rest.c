// SPDX-License-Identifier: MIT
/* The rounds after the first merges: suspects are looked at by gathering the quads round their
 * corners; of those that may go a largest set is taken in the order of their turns; what that may
 * have opened becomes suspect. All looks of a round come before all changes. [DMC21] section 4. */
#include "dmc/simplify_parts.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/sort.h"
#include "core/status.h"

#include <string.h>

/* ---- looking at all suspects ----------------------------------------------------------------- */

static inline int compare_turns(const void *first, const void *second) {
    const qni_candidate *a = first, *b = second;
    return a->turn < b->turn ? -1 : a->turn > b->turn;
}

static void close_up(qni_numbers *suspects, const int64_t *start, const int64_t *others,
                     int32_t threads) {
    suspects->count = 0;
    for (int32_t t = 0; t < threads; ++t) {
        if (others[t] > 0) /* there may be no array yet */
            memmove(suspects->items + suspects->count, suspects->items + start[t],
                    (size_t)others[t] * sizeof *suspects->items);
        suspects->count += others[t];
    }
}

/* All that may go, in the order of their turns. */
static bool look_at_suspects(qni_simplifier *job, bool rings, qni_candidates *all) {
    const int64_t count = job->suspects.count;
    const int32_t threads = job->threads;
    qni_candidates *found = qni_alloc_zero(job->context, threads, sizeof *found);
    int64_t *start = qni_alloc(job->context, 2 * (int64_t)threads, sizeof *start);
    bool good = found && start;
    if (good) {
        int64_t *others = start + threads;
#pragma omp parallel for schedule(static, 1) num_threads(threads)
        for (int32_t t = 0; t < threads; ++t) {
            start[t] = count * t / threads;
            others[t] = qni_simplify_look(job, job->suspects.items + start[t],
                                          count * (t + 1) / threads - start[t], rings, found + t);
        }
        close_up(&job->suspects, start, others, threads);
    }
    for (int32_t t = 0; found && t < threads; ++t) {
        good = good && !found[t].failed;
        for (int64_t n = 0; good && n < found[t].count; ++n)
            good = qni_candidates_add(job->context, all, found[t].items + n);
        qni_simplify_note_memory(job);
        qni_candidates_free(job->context, found + t);
    }
    qni_free(job->context, start, 2 * (int64_t)threads, sizeof *start);
    qni_free(job->context, found, threads, sizeof *found);
    return good &&
           qni_sort(job->context, all->items, all->count, sizeof *all->items, compare_turns);
}

/* ---- what becomes suspect -------------------------------------------------------------------- */

static inline int compare_numbers(const void *first, const void *second) {
    const uint32_t a = *(const uint32_t *)first, b = *(const uint32_t *)second;
    return a < b ? -1 : a > b;
}

/* Both lists in one, ascending, each number once. `more` is sorted here. */
static bool add_suspects(qni_simplifier *job, qni_numbers *more) {
    qni_numbers all = {0};
    const qni_numbers *old = &job->suspects;
    if (more->count == 0)
        return true;
    if (!qni_sort(job->context, more->items, more->count, sizeof *more->items, compare_numbers) ||
        !qni_numbers_reserve(job->context, &all, old->count + more->count))
        return false;
    for (int64_t n = 0, m = 0; n < old->count || m < more->count;) {
        const bool from_old =
            m == more->count || (n < old->count && old->items[n] <= more->items[m]);
        const uint32_t next = from_old ? old->items[n++] : more->items[m++];
        if (all.count == 0 || all.items[all.count - 1] != next)
            all.items[all.count++] = next;
    }
    qni_numbers_free(job->context, &job->suspects);
    job->suspects = all;
    return true;
}

static bool list_round(const qni_simplifier *job, uint32_t vertex, uint32_t known,
                       qni_numbers *list) {
    uint32_t round[QNI_VALENCE_LARGEST], corner[4];
    const int count = qni_quads_round_with(&job->around, vertex, known, round);
    if (!qni_numbers_reserve(job->context, list, count))
        return false;
    for (int n = 0; n < count; ++n)
        if (qni_kind_now(&job->around, round[n], corner) != QNI_QUAD_STAYS)
            list->items[list->count++] = round[n];
    return true;
}

/* A merged vertex has come up to valence 4: rings that have it as an outer corner may shrink now.
 * The middle of such a ring is a quad round a neighbour of valence 3. */
static bool list_middles(const qni_simplifier *job, uint32_t vertex, qni_numbers *list) {
    uint32_t round[QNI_VALENCE_LARGEST], corner[4];
    const int count = qni_quads_round(&job->around, vertex, round);
    for (int n = 0; n < count; ++n) {
        qni_corners_now(&job->around, round[n], corner);
        for (int k = 0; k < 4; ++k)
            if (qni_valence_now(&job->around, corner[k]) == 3 &&
                !list_round(job, corner[k], QNI_UNPAIRED, list))
                return false;
    }
    return true;
}

/* Whether a quad round a corner of valence 3 may go beside the one whose corners these are: it
 * shares one of the neighbouring corners, and that is 3 too, or at least 5. */
static bool may_matter(const qni_around *around, const uint32_t corner[4], int k) {
    const int before = qni_valence_now(around, corner[(k + 3) & 3]),
              after = qni_valence_now(around, corner[(k + 1) & 3]);
    return before == 3 || before >= 5 || after == 3 || after >= 5;
}

/* `shrunk`: the vertices are the corners of these quads, four each, which are suspect already.
 * `merged`: vertices that came up to valence 4. */
static qn_status suspect_round(qni_simplifier *job, const qni_numbers *vertices,
                               const qni_numbers *shrunk, const qni_numbers *merged,
                               qn_error *error) {
    enum { AHEAD = 6 };
    qni_numbers more = {0};
    bool good = true;
    for (int64_t n = 0; n < merged->count && good; ++n)
        good = list_middles(job, merged->items[n], &more);
    for (int64_t n = 0; n < vertices->count && good; ++n) {
        const uint32_t vertex = vertices->items[n];
        if (n + AHEAD < vertices->count &&
            qni_valence_now(&job->around, vertices->items[n + AHEAD]) <= 4)
            qni_expect_vertex(&job->around, vertices->items[n + AHEAD]);
        if (qni_valence_now(&job->around, vertex) == 3 &&
            (!shrunk || may_matter(&job->around, vertices->items + n / 4 * 4, n & 3)))
            good = list_round(job, vertex, shrunk ? shrunk->items[n / 4] : QNI_UNPAIRED, &more);
    }
    good = good && add_suspects(job, &more);
    qni_numbers_free(job->context, &more);
    return good ? QN_OK : qni_fail_memory(error, "the list of quads to remove");
}

qn_status qni_simplify_suspect_round(qni_simplifier *job, const qni_numbers *vertices,
                                     qn_error *error) {
    const qni_numbers none = {0};
    return suspect_round(job, vertices, NULL, &none, error);
}

/* ---- carrying out ---------------------------------------------------------------------------- */

static void join_circles(const qni_around *around, uint32_t a, uint32_t b) {
    uint32_t *circle = around->circle;
    const uint32_t pair[2] = {a, b};
    for (int n = 0; n < 2; ++n)
        if (!(around->valence[pair[n]] & QNI_VALENCE_MERGED))
            circle[pair[n]] = pair[n];
    const uint32_t next = circle[a];
    circle[a] = circle[b];
    circle[b] = next;
}

/* Several at once: none of a round's is a corner of another one's but as X or Y, which stay. */
static void place_merged(qni_simplifier *job, qni_placing *placing) {
    if (placing->count == 0)
        return;
    qni_simplify_start_placing(job, placing);
    job->report.unprojected += qni_simplify_end_placing(job, placing);
    placing->count = 0;
}

/* False when one before it took a corner. Changed vertices are listed, the place is left to do. */
static bool merge(qni_simplifier *job, const qni_candidate *item, qni_numbers *changed,
                  qni_placing *placing) {
    const qni_around *around = &job->around;
    const uint32_t a = item->corner[0], x = item->corner[1], b = item->corner[2],
                   y = item->corner[3];
    if (qni_valence_now(around, a) != 3 || qni_valence_now(around, b) != 3)
        return false;
    join_circles(around, a, b);
    around->valence[a] = 4 | QNI_VALENCE_MERGED | QNI_VALENCE_APART;
    around->valence[b] = QNI_VALENCE_GONE;
    around->colour[item->quad] = QNI_QUAD_GONE;
    --around->valence[x];
    --around->valence[y];
    if (job->mesh->twins)
        qni_close_merge(job->mesh->twins, job->mesh->vertex_halfedges, 4 * item->quad + item->first,
                        a, x, y);
    placing->merged[placing->count++] = (qni_merged){a, b, x, y};
    ++job->report.merged_quads;
    changed->items[changed->count++] = x;
    changed->items[changed->count++] = y;
    job->kept.items[job->kept.count++] = a;
    return true;
}

/* False when one before it took an outer corner. */
static bool shrink(qni_simplifier *job, const qni_candidate *item, qni_numbers *changed) {
    const qni_around *around = &job->around;
    uint32_t *corner = job->mesh->quads + 4 * (size_t)item->quad;
    for (int k = 0; k < 4; ++k)
        if (qni_valence_now(around, item->corner[k]) != item->valence[k])
            return false;
    for (int k = 0; k < 4; ++k) {
        const uint32_t inner = qni_vertex_now(around, corner[k]);
        around->circle[inner] = inner;
        around->valence[inner] = QNI_VALENCE_GONE;
        around->colour[item->ring[k]] = QNI_QUAD_GONE;
        around->valence[item->corner[k]] =
            (uint8_t)((around->valence[item->corner[k]] - 1) | QNI_VALENCE_APART);
        corner[k] = item->corner[k];
    }
    if (job->mesh->twins)
        qni_close_ring(job->mesh->twins, job->mesh->vertex_halfedges, item->quad, item->corner);
    job->report.shrunk_quads += 4;
    memcpy(changed->items + changed->count, item->corner, sizeof item->corner);
    changed->count += 4;
    return true;
}

/* Take in turn; those that must wait stay suspect, and so does a quad that took its ring's place.
 */
static qn_status carry_out(qni_simplifier *job, const qni_candidates *all, bool rings,
                           qn_error *error) {
    qni_numbers changed = {0}, more = {0}, shrunk = {0}, merged = {0};
    qni_placing placing;
    qn_status status = QN_OK;
    placing.count = 0;
    const int64_t kept_before = job->kept.count;
    const bool good = qni_numbers_reserve(job->context, &changed, 4 * all->count) &&
                      qni_numbers_reserve(job->context, &more, all->count) &&
                      qni_numbers_reserve(job->context, &shrunk, rings ? all->count : 0) &&
                      qni_numbers_reserve(job->context, &job->kept, rings ? 0 : all->count);
    if (!good)
        status = qni_fail_memory(error, "the list of quads to remove");
    for (int64_t n = 0; n < all->count && status == QN_OK; ++n) {
        const qni_candidate *item = all->items + n;
        const bool taken =
            rings ? shrink(job, item, &changed) : merge(job, item, &changed, &placing);
        if (placing.count == QNI_LANDINGS)
            place_merged(job, &placing);
        if (!taken || rings)
            more.items[more.count++] = item->quad;
        if (taken && rings)
            shrunk.items[shrunk.count++] = item->quad;
        for (int k = 0; taken && rings && !job->mesh->twins && k < 4 && status == QN_OK; ++k)
            status = qni_around_note(&job->around, item->corner[k], item->quad, error);
    }
    place_merged(job, &placing);
    if (job->kept.count > kept_before)
        merged = (qni_numbers){.items = job->kept.items + kept_before,
                               .count = job->kept.count - kept_before};
    if (status == QN_OK && !add_suspects(job, &more))
        status = qni_fail_memory(error, "the list of quads to remove");
    if (status == QN_OK)
        status = suspect_round(job, &changed, rings ? &shrunk : NULL, &merged, error);
    qni_simplify_note_memory(job);
    qni_numbers_free(job->context, &changed);
    qni_numbers_free(job->context, &more);
    qni_numbers_free(job->context, &shrunk);
    return status;
}

qn_status qni_simplify_round(qni_simplifier *job, bool rings, qn_error *error) {
    qni_candidates all = {0};
    if (qni_progress(job->context, "simplify", rings ? 0.75 : 0.5))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    if (rings && !add_suspects(job, &job->rings))
        return qni_fail_memory(error, "the list of quads to remove");
    job->rings.count = rings ? 0 : job->rings.count;
    qn_status status = look_at_suspects(job, rings, &all)
                           ? QN_OK
                           : qni_fail_memory(error, "the list of quads to remove");
    if (status == QN_OK)
        status = carry_out(job, &all, rings, error);
    qni_candidates_free(job->context, &all);
    return status;
}

/* ---- as the paper does it -------------------------------------------------------------------- */

/* Per corner of valence 3: the lowest colour of the quads of the pattern there, and how many have
 * it; in the room for circles, which holds nothing yet for such corners. */
static void note_colours(const qni_around *around, const qni_candidates *all, bool alone) {
    for (int64_t n = 0; n < 2 * all->count; ++n)
        around->circle[all->items[n / 2].corner[n & 1 ? 2 : 0]] = QNI_UNPAIRED;
    for (int64_t n = 0; n < 2 * all->count; ++n) {
        const qni_candidate *item = all->items + n / 2;
        const uint32_t own = alone ? 8 : 8 * (uint32_t)(item->turn >> 32) + 8;
        uint32_t *noted = around->circle + item->corner[n & 1 ? 2 : 0];
        if (*noted == QNI_UNPAIRED || own < (*noted & ~UINT32_C(7)))
            *noted = own + 1;
        else if (own == (*noted & ~UINT32_C(7)))
            ++*noted;
    }
}

/* Only those go that have no neighbour of the pattern with a colour as low; or, `alone`, none. */
static void drop_neighbours(const qni_around *around, qni_candidates *all, bool alone) {
    int64_t go = 0;
    note_colours(around, all, alone);
    for (int64_t n = 0; n < all->count; ++n) {
        const qni_candidate item = all->items[n];
        const uint32_t own = alone ? 8 : 8 * (uint32_t)(item.turn >> 32) + 8;
        if (around->circle[item.corner[0]] == own + 1 && around->circle[item.corner[2]] == own + 1)
            all->items[go++] = item;
    }
    all->count = go;
}

static bool suspect_all(qni_simplifier *job) {
    job->suspects.count = 0;
    if (!qni_numbers_reserve(job->context, &job->suspects, job->mesh->quad_count))
        return false;
    for (int64_t q = 0; q < job->mesh->quad_count; ++q)
        job->suspects.items[q] = (uint32_t)q;
    job->suspects.count = job->mesh->quad_count;
    return true;
}

qn_status qni_simplify_as_paper(qni_simplifier *job, qn_error *error) {
    qn_status status = QN_OK;
    for (int step = 0; step < 2 && status == QN_OK; ++step) {
        qni_candidates all = {0};
        if (!suspect_all(job) || !look_at_suspects(job, false, &all))
            status = qni_fail_memory(error, "the list of quads to remove");
        if (status == QN_OK) {
            drop_neighbours(&job->around, &all, step == 1);
            status = carry_out(job, &all, false, error);
        }
        qni_candidates_free(job->context, &all);
    }
    if (status == QN_OK && !suspect_all(job))
        status = qni_fail_memory(error, "the list of quads to remove");
    return status == QN_OK ? qni_simplify_round(job, true, error) : status;
}
