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

/* A quad that may go. */
typedef struct candidate {
    uint64_t turn;
    uint32_t quad;
    uint32_t corner[4]; /* a, x, b, y of a merge; the outer corners of a ring */
    uint32_t ring[4];
    uint32_t beyond; /* on the other side of a ring, if guessed; or QNI_UNPAIRED */
    bool guessed;
    uint8_t valence[4]; /* of the outer corners, when it was looked at */
    uint8_t first;      /* which of the quad's corners a is */
} candidate;

typedef struct candidates {
    candidate *items;
    int64_t count, capacity;
    bool failed;
} candidates;

static bool add_candidate(qn_context *context, candidates *list, const candidate *item) {
    if (list->count == list->capacity) {
        const int64_t capacity = list->capacity ? 2 * list->capacity : 256;
        void *grown =
            qni_realloc(context, list->items, list->capacity, capacity, sizeof *list->items);
        if (!grown)
            return false;
        list->items = grown;
        list->capacity = capacity;
    }
    list->items[list->count++] = *item;
    return true;
}

static void free_candidates(qn_context *context, candidates *list) {
    qni_free(context, list->items, list->capacity, sizeof *list->items);
    memset(list, 0, sizeof *list);
}

/* ---- looking at one quad --------------------------------------------------------------------- */

static int kind_of(const qni_around *around, uint32_t quad, uint32_t corner[4]) {
    uint32_t four = 0;
    qni_corners_now(around, quad, corner);
    for (int k = 0; k < 4; ++k)
        four |= (uint32_t)qni_valence_now(around, corner[k]) << (8 * k);
    return qni_kind_of_valences(four);
}

/* The corners of the two other quads round a corner of valence 3. */
static bool other_two(const qni_around *around, uint32_t vertex, uint32_t quad, uint32_t found[2],
                      uint32_t corner[2][4]) {
    uint32_t round[QNI_VALENCE_LARGEST];
    int others = 0;
    if (qni_quads_round(around, vertex, round) != 3)
        return false;
    for (int n = 0; n < 3; ++n)
        if (round[n] != quad && others < 2) {
            found[others] = round[n];
            qni_corners_now(around, round[n], corner[others++]);
        }
    return others == 2;
}

static uint32_t third_neighbour(const qni_around *around, uint32_t vertex, uint32_t quad) {
    uint32_t found[2], corner[2][4];
    return other_two(around, vertex, quad, found, corner)
               ? qni_shared_corner(corner[0], corner[1], vertex)
               : QNI_UNPAIRED;
}

static bool look_at_merge(const qni_around *around, int kind, const uint32_t corner[4],
                          candidate *item) {
    uint32_t k = (uint32_t)(kind - QNI_QUAD_MERGES_02);
    if (corner[k] > corner[k ^ 2])
        k ^= 2;
    item->first = (uint8_t)k;
    for (uint32_t n = 0; n < 4; ++n)
        item->corner[n] = corner[(k + n) & 3];
    const uint32_t a = item->corner[0], b = item->corner[2];
    return qni_may_merge(a, b, item->corner[1], item->corner[3],
                         third_neighbour(around, a, item->quad),
                         third_neighbour(around, b, item->quad));
}

/* The corner of a quad that is none of three others. */
static uint32_t fourth_corner(const uint32_t corner[4], uint32_t a, uint32_t b, uint32_t c) {
    for (int k = 0; k < 4; ++k)
        if (corner[k] != a && corner[k] != b && corner[k] != c)
            return corner[k];
    return QNI_UNPAIRED;
}

/* The outer corners that two quads of the ring show have a valence of 4: most rings fail here. */
static bool may_be_large(const qni_around *around, const uint32_t corner[4], int k,
                         const uint32_t before[4], const uint32_t after[4]) {
    const uint32_t own = corner[k], outer = qni_shared_corner(before, after, own);
    const uint32_t all[3] = {outer, fourth_corner(after, own, outer, corner[(k + 1) & 3]),
                             fourth_corner(before, own, outer, corner[(k + 3) & 3])};
    for (int n = 0; n < 3; ++n)
        if (all[n] == QNI_UNPAIRED || qni_valence_now(around, all[n]) < 4)
            return false;
    return true;
}

/* Without halfedges the grid can tell at once which quads the ring has, as long as corners are
 * those that were emitted: quads with two neighbouring corners each make it sure, since no more
 * than three quads meet at a corner. False when they do not. */
static bool guess_ring(const qni_around *around, const uint32_t corner[4], candidate *item,
                       uint32_t ring_corner[4][4]) {
    uint32_t found[4], of[4][4];
    if (!around->index || around->colour[item->quad] >= QNI_COLOURS ||
        !qni_leaf_index_ring(around->index, item->quad, around->colour[item->quad], found,
                             &item->beyond))
        return false;
    for (int n = 0; n < 4; ++n) {
        if (around->colour[found[n]] == QNI_QUAD_GONE)
            return false;
        qni_corners_now(around, found[n], of[n]);
    }
    for (int k = 0; k < 4; ++k) {
        int n = 0;
        while (n < 4 &&
               !(qni_has_corner(of[n], corner[k]) && qni_has_corner(of[n], corner[(k + 1) & 3])))
            ++n;
        if (n == 4)
            return false;
        item->ring[k] = found[n];
        memcpy(ring_corner[k], of[n], sizeof of[n]);
    }
    return true;
}

static bool ask_for_ring(const qni_around *around, const uint32_t corner[4], candidate *item,
                         uint32_t ring_corner[4][4]) {
    for (int k = 0; k < 4; k += 2) {
        uint32_t found[2], of[2][4];
        if (!other_two(around, corner[k], item->quad, found, of))
            return false;
        const int after = qni_has_corner(of[1], corner[k + 1]);
        if (after == qni_has_corner(of[0], corner[k + 1]) ||
            !may_be_large(around, corner, k, of[1 - after], of[after]))
            return false;
        item->ring[k] = found[after];
        item->ring[(k + 3) & 3] = found[1 - after];
        memcpy(ring_corner[k], of[after], sizeof of[0]);
        memcpy(ring_corner[(k + 3) & 3], of[1 - after], sizeof of[0]);
    }
    return true;
}

/* The quads of the ring, by the side of the quad in its middle, and its outer corners. */
static bool find_ring(const qni_around *around, const uint32_t corner[4], candidate *item) {
    uint32_t ring_corner[4][4];
    item->guessed = guess_ring(around, corner, item, ring_corner);
    if (!item->guessed && !ask_for_ring(around, corner, item, ring_corner))
        return false;
    for (int k = 0; k < 4; ++k)
        item->corner[k] = qni_shared_corner(ring_corner[(k + 3) & 3], ring_corner[k], corner[k]);
    return true;
}

/* Whether another quad joins the outer corners. Where all of them are as they were emitted, it can
 * only be that of a lattice edge common to their cells. */
static bool has_rival_quad(const qni_around *around, const candidate *item) {
    uint32_t round[QNI_VALENCE_LARGEST], other[4];
    uint8_t marks = 0;
    for (int k = 0; k < 4; ++k)
        marks |= around->valence[item->corner[k]];
    int count = item->beyond != QNI_UNPAIRED;
    round[0] = item->beyond;
    if (!item->guessed || marks & (QNI_VALENCE_MERGED | QNI_VALENCE_APART))
        count = qni_quads_round(around, item->corner[0], round);
    for (int n = 0; n < count; ++n) {
        if (around->colour[round[n]] == QNI_QUAD_GONE) /* its corners may be gone, too */
            continue;
        qni_corners_now(around, round[n], other);
        if (qni_joins_all(other, item->corner))
            return true;
    }
    return false;
}

static bool look_at_ring(const qni_around *around, const uint32_t corner[4], candidate *item) {
    int valence[4];
    if (!find_ring(around, corner, item))
        return false;
    for (int k = 0; k < 4; ++k) {
        valence[k] = item->corner[k] == QNI_UNPAIRED ? 0 : qni_valence_now(around, item->corner[k]);
        item->valence[k] = (uint8_t)valence[k];
    }
    if (!qni_may_shrink(corner, item->corner, valence))
        return false;
    return !has_rival_quad(around, item);
}

/* Ask for what tells the quads round a vertex. */
static void expect_vertex(const qni_around *around, uint32_t vertex) {
    if (around->index)
        qni_leaf_index_prefetch(around->index, vertex);
    else
        __builtin_prefetch(around->mesh->vertex_halfedges + vertex);
}

/* ---- looking at all suspects ----------------------------------------------------------------- */

static int compare_turns(const void *first, const void *second) {
    const candidate *a = first, *b = second;
    return a->turn < b->turn ? -1 : a->turn > b->turn;
}

/* What is listed lies scattered: it is asked for some items ahead. */
static void expect(const qni_around *around, bool rings, const uint32_t *suspects, int64_t n,
                   int64_t count) {
    enum { FAR = 16, NEAR = 8 };
    const qn_mesh *mesh = around->mesh;
    if (n + FAR < count) {
        __builtin_prefetch(mesh->quads + 4 * (size_t)suspects[n + FAR]);
        if (mesh->twins)
            __builtin_prefetch(mesh->twins + 4 * (size_t)suspects[n + FAR]);
    }
    if (!rings || n + NEAR >= count)
        return;
    const size_t quad = suspects[n + NEAR];
    for (size_t k = 0; mesh->twins && k < 4; ++k)
        expect_vertex(around, mesh->quads[4 * quad + k]);
    if (!mesh->twins)
        expect_vertex(around, mesh->quads[4 * quad + 2]);
}

/* Of a stretch of suspects those that may go; those of the other pattern stay suspect, and are put
 * to the stretch's start. */
static int64_t look_at_stretch(const qni_simplifier *job, uint32_t *suspects, int64_t count,
                               bool rings, candidates *found) {
    const qni_around *around = &job->around;
    int64_t others = 0;
    for (int64_t n = 0; n < count && !found->failed; ++n) {
        uint32_t corner[4];
        candidate item = {.quad = suspects[n]};
        const uint8_t colour = around->colour[item.quad];
        expect(around, rings, suspects, n, count);
        if (colour == QNI_QUAD_GONE)
            continue;
        const int kind = kind_of(around, item.quad, corner);
        if (kind != QNI_QUAD_STAYS && qni_is_merge(kind) == rings) {
            suspects[others++] = item.quad;
            continue;
        }
        if (kind == QNI_QUAD_STAYS || !(rings ? look_at_ring(around, corner, &item)
                                              : look_at_merge(around, kind, corner, &item)))
            continue;
        item.turn = qni_turn_of(colour, item.quad);
        found->failed = !add_candidate(job->context, found, &item);
    }
    return others;
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
static bool look_at_suspects(qni_simplifier *job, bool rings, candidates *all) {
    const int64_t count = job->suspects.count;
    const int32_t threads = job->threads;
    candidates *found = qni_alloc_zero(job->context, threads, sizeof *found);
    int64_t *start = qni_alloc(job->context, 2 * (int64_t)threads, sizeof *start);
    bool good = found && start;
    if (good) {
        int64_t *others = start + threads;
#pragma omp parallel for schedule(static, 1) num_threads(threads)
        for (int32_t t = 0; t < threads; ++t) {
            start[t] = count * t / threads;
            others[t] = look_at_stretch(job, job->suspects.items + start[t],
                                        count * (t + 1) / threads - start[t], rings, found + t);
        }
        close_up(&job->suspects, start, others, threads);
    }
    for (int32_t t = 0; found && t < threads; ++t) {
        good = good && !found[t].failed;
        for (int64_t n = 0; good && n < found[t].count; ++n)
            good = add_candidate(job->context, all, found[t].items + n);
        qni_simplify_note_memory(job);
        free_candidates(job->context, found + t);
    }
    qni_free(job->context, start, 2 * (int64_t)threads, sizeof *start);
    qni_free(job->context, found, threads, sizeof *found);
    return good &&
           qni_sort(job->context, all->items, all->count, sizeof *all->items, compare_turns);
}

/* ---- what becomes suspect -------------------------------------------------------------------- */

static int compare_numbers(const void *first, const void *second) {
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

static bool list_round(const qni_simplifier *job, uint32_t vertex, qni_numbers *list) {
    uint32_t round[QNI_VALENCE_LARGEST], corner[4];
    const int count = qni_quads_round(&job->around, vertex, round);
    if (!qni_numbers_reserve(job->context, list, count))
        return false;
    for (int n = 0; n < count; ++n)
        if (kind_of(&job->around, round[n], corner) != QNI_QUAD_STAYS)
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
            if (qni_valence_now(&job->around, corner[k]) == 3 && !list_round(job, corner[k], list))
                return false;
    }
    return true;
}

static qn_status suspect_round(qni_simplifier *job, const qni_numbers *vertices, bool middles,
                               qn_error *error) {
    enum { AHEAD = 6 };
    qni_numbers more = {0};
    bool good = true;
    for (int64_t n = 0; n < vertices->count && good; ++n) {
        const uint32_t vertex = vertices->items[n];
        if (n + AHEAD < vertices->count &&
            qni_valence_now(&job->around, vertices->items[n + AHEAD]) <= 4)
            expect_vertex(&job->around, vertices->items[n + AHEAD]);
        const int valence = job->around.valence[vertex] == QNI_VALENCE_GONE
                                ? 0
                                : qni_valence_now(&job->around, vertex);
        if (valence == 3)
            good = list_round(job, vertex, &more);
        else if (valence == 4 && middles)
            good = list_middles(job, vertex, &more);
    }
    good = good && add_suspects(job, &more);
    qni_numbers_free(job->context, &more);
    return good ? QN_OK : qni_fail_memory(error, "the list of quads to remove");
}

qn_status qni_simplify_suspect_round(qni_simplifier *job, const qni_numbers *vertices,
                                     qn_error *error) {
    return suspect_round(job, vertices, false, error);
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

/* False when one before it took a corner. Changed vertices are listed. */
static bool merge(qni_simplifier *job, const candidate *item, qni_numbers *changed) {
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
    const uint32_t touched[3] = {a, x, y};
    qni_placing placing = {.merged = {{a, b, x, y}}, .count = 1};
    qni_simplify_start_placing(job, &placing);
    job->report.unprojected += qni_simplify_end_placing(job, &placing);
    ++job->report.merged_quads;
    memcpy(changed->items + changed->count, touched, sizeof touched);
    changed->count += 3;
    job->kept.items[job->kept.count++] = a;
    return true;
}

/* False when one before it took an outer corner. */
static bool shrink(qni_simplifier *job, const candidate *item, qni_numbers *changed) {
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
static qn_status carry_out(qni_simplifier *job, const candidates *all, bool rings,
                           qn_error *error) {
    qni_numbers changed = {0}, more = {0};
    qn_status status = QN_OK;
    const bool good = qni_numbers_reserve(job->context, &changed, 4 * all->count) &&
                      qni_numbers_reserve(job->context, &more, all->count) &&
                      qni_numbers_reserve(job->context, &job->kept, rings ? 0 : all->count);
    if (!good)
        status = qni_fail_memory(error, "the list of quads to remove");
    for (int64_t n = 0; n < all->count && status == QN_OK; ++n) {
        const candidate *item = all->items + n;
        const bool taken = rings ? shrink(job, item, &changed) : merge(job, item, &changed);
        if (!taken || rings)
            more.items[more.count++] = item->quad;
        for (int k = 0; taken && rings && !job->mesh->twins && k < 4 && status == QN_OK; ++k)
            status = qni_around_note(&job->around, item->corner[k], item->quad, error);
    }
    if (status == QN_OK && !add_suspects(job, &more))
        status = qni_fail_memory(error, "the list of quads to remove");
    if (status == QN_OK)
        status = suspect_round(job, &changed, !rings, error);
    qni_simplify_note_memory(job);
    qni_numbers_free(job->context, &changed);
    qni_numbers_free(job->context, &more);
    return status;
}

qn_status qni_simplify_round(qni_simplifier *job, bool rings, qn_error *error) {
    candidates all = {0};
    if (qni_progress(job->context, "simplify", rings ? 0.75 : 0.5))
        return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
    qn_status status = look_at_suspects(job, rings, &all)
                           ? QN_OK
                           : qni_fail_memory(error, "the list of quads to remove");
    if (status == QN_OK)
        status = carry_out(job, &all, rings, error);
    free_candidates(job->context, &all);
    return status;
}

/* ---- as the paper does it -------------------------------------------------------------------- */

/* Per corner of valence 3: the lowest colour of the quads of the pattern there, and how many have
 * it; in the room for circles, which holds nothing yet for such corners. */
static void note_colours(const qni_around *around, const candidates *all, bool alone) {
    for (int64_t n = 0; n < 2 * all->count; ++n)
        around->circle[all->items[n / 2].corner[n & 1 ? 2 : 0]] = QNI_UNPAIRED;
    for (int64_t n = 0; n < 2 * all->count; ++n) {
        const candidate *item = all->items + n / 2;
        const uint32_t own = alone ? 8 : 8 * (uint32_t)(item->turn >> 32) + 8;
        uint32_t *noted = around->circle + item->corner[n & 1 ? 2 : 0];
        if (*noted == QNI_UNPAIRED || own < (*noted & ~UINT32_C(7)))
            *noted = own + 1;
        else if (own == (*noted & ~UINT32_C(7)))
            ++*noted;
    }
}

/* Only those go that have no neighbour of the pattern with a colour as low; or, `alone`, none. */
static void drop_neighbours(const qni_around *around, candidates *all, bool alone) {
    int64_t go = 0;
    note_colours(around, all, alone);
    for (int64_t n = 0; n < all->count; ++n) {
        const candidate item = all->items[n];
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
        candidates all = {0};
        if (!suspect_all(job) || !look_at_suspects(job, false, &all))
            status = qni_fail_memory(error, "the list of quads to remove");
        if (status == QN_OK) {
            drop_neighbours(&job->around, &all, step == 1);
            status = carry_out(job, &all, false, error);
        }
        free_candidates(job->context, &all);
    }
    if (status == QN_OK && !suspect_all(job))
        status = qni_fail_memory(error, "the list of quads to remove");
    return status == QN_OK ? qni_simplify_round(job, true, error) : status;
}
