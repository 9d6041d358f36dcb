// SPDX-License-Identifier: MIT
/* Looking at suspects: whether a quad may go, by the quads round its corners. Nothing is changed.
 * [DMC21] section 4. */
#include "dmc/simplify_parts.h"
#include "core/context.h"

#include <string.h>

/* ---- candidates ------------------------------------------------------------------------------ */

bool qni_candidates_add(qn_context *context, qni_candidates *list, const qni_candidate *item) {
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

void qni_candidates_free(qn_context *context, qni_candidates *list) {
    qni_free(context, list->items, list->capacity, sizeof *list->items);
    memset(list, 0, sizeof *list);
}

/* ---- looking at one quad --------------------------------------------------------------------- */

int qni_kind_now(const qni_around *around, uint32_t quad, uint32_t corner[4]) {
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
                          qni_candidate *item) {
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
 * those that were emitted. */
typedef struct ring_guess {
    uint32_t ring[4], beyond;
    bool made;
} ring_guess;

static void make_guess(const qni_around *around, uint32_t quad, ring_guess *guess) {
    const uint8_t colour = around->colour[quad];
    guess->made = around->index && colour < QNI_COLOURS &&
                  qni_leaf_index_ring(around->index, quad, colour, guess->ring, &guess->beyond);
    for (int n = 0; guess->made && n < 4; ++n)
        __builtin_prefetch(around->mesh->quads + 4 * (size_t)guess->ring[n]);
}

/* Which of the quad's corners another one has, one bit each; without branches. */
static unsigned corners_of(const uint32_t other[4], const uint32_t corner[4]) {
    unsigned bits = 0;
    for (int k = 0; k < 4; ++k)
        bits |= (unsigned)((other[0] == corner[k]) | (other[1] == corner[k]) |
                           (other[2] == corner[k]) | (other[3] == corner[k]))
                << k;
    return bits;
}

/* Quads with two neighbouring corners each make it sure, since no more than three quads meet at a
 * corner. False when they do not. */
static bool try_guess(const qni_around *around, const uint32_t corner[4], const ring_guess *guess,
                      qni_candidate *item, uint32_t ring_corner[4][4]) {
    enum { NONE = 4 };
    static const uint8_t side_of_bits[16] = {NONE, NONE, NONE, 0,    NONE, NONE, 1,    NONE,
                                             NONE, 3,    NONE, NONE, 2,    NONE, NONE, NONE};
    unsigned sides = 0;
    if (!guess->made)
        return false;
    item->beyond = guess->beyond;
    for (int n = 0; n < 4; ++n) {
        const uint32_t quad = guess->ring[n];
        uint32_t own[4];
        if (around->colour[quad] == QNI_QUAD_GONE)
            return false;
        qni_corners_now(around, quad, own);
        const unsigned side = side_of_bits[corners_of(own, corner)];
        if (side == NONE)
            return false;
        sides |= 1u << side;
        item->ring[side] = quad;
        memcpy(ring_corner[side], own, sizeof own);
    }
    return sides == 15;
}

static bool ask_for_ring(const qni_around *around, const uint32_t corner[4], qni_candidate *item,
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

/* A ring's quad runs along its side against the quad in the middle: from the side's second corner
 * to the first, then outside from the first to the second. */
static void find_outer_corners(const uint32_t corner[4], const uint32_t ring_corner[4][4],
                               uint32_t outer[4]) {
    uint32_t first[4], second[4];
    for (int k = 0; k < 4; ++k) {
        const uint32_t *own = ring_corner[k];
        const int at =
            (own[1] == corner[k]) + 2 * (own[2] == corner[k]) + 3 * (own[3] == corner[k]);
        first[k] = own[(at + 1) & 3];
        second[(k + 1) & 3] = own[(at + 2) & 3];
    }
    for (int k = 0; k < 4; ++k)
        outer[k] = first[k] == second[k] ? first[k] : QNI_UNPAIRED;
}

/* The quads of the ring, by the side of the quad in its middle, and its outer corners. */
static bool find_ring(const qni_around *around, const uint32_t corner[4], const ring_guess *guess,
                      qni_candidate *item) {
    uint32_t ring_corner[4][4];
    item->guessed = try_guess(around, corner, guess, item, ring_corner);
    if (!item->guessed && !ask_for_ring(around, corner, item, ring_corner))
        return false;
    find_outer_corners(corner, ring_corner, item->corner);
    return true;
}

/* Whether another quad joins the outer corners. Where all of them are as they were emitted, it can
 * only be that of a lattice edge common to their cells. */
static bool has_rival_quad(const qni_around *around, const qni_candidate *item) {
    uint32_t round[QNI_VALENCE_LARGEST], other[4], least = item->corner[0];
    uint8_t marks = 0;
    for (int k = 0; k < 4; ++k) {
        marks |= around->valence[item->corner[k]];
        if (around->valence[item->corner[k]] < around->valence[least])
            least = item->corner[k]; /* one with marks costs more to look round than any without */
    }
    int count = item->beyond != QNI_UNPAIRED;
    round[0] = item->beyond;
    if (!item->guessed || marks & (QNI_VALENCE_MERGED | QNI_VALENCE_APART))
        count = qni_quads_round(around, least, round);
    for (int n = 0; n < count; ++n) {
        if (around->colour[round[n]] == QNI_QUAD_GONE) /* its corners may be gone, too */
            continue;
        qni_corners_now(around, round[n], other);
        if (qni_joins_all(other, item->corner))
            return true;
    }
    return false;
}

static bool look_at_ring(const qni_around *around, const uint32_t corner[4],
                         const ring_guess *guess, qni_candidate *item) {
    int valence[4];
    if (!find_ring(around, corner, guess, item))
        return false;
    for (int k = 0; k < 4; ++k) {
        valence[k] = item->corner[k] == QNI_UNPAIRED ? 0 : qni_valence_now(around, item->corner[k]);
        item->valence[k] = (uint8_t)valence[k];
    }
    if (!qni_may_shrink(corner, item->corner, valence))
        return false;
    return !has_rival_quad(around, item);
}

/* ---- looking at a stretch -------------------------------------------------------------------- */

/* Ask for what tells the quads round a vertex. */
void qni_expect_vertex(const qni_around *around, uint32_t vertex) {
    if (around->index)
        qni_leaf_index_prefetch(around->index, vertex);
    else
        __builtin_prefetch(around->mesh->vertex_halfedges + vertex);
}

enum { FAR = 16, NEAR = 8, NEXT = 4 };

/* What is listed lies scattered: it is asked for some items ahead. */
static void expect(const qni_around *around, bool rings, const uint32_t *suspects, int64_t n,
                   int64_t count) {
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
        qni_expect_vertex(around, mesh->quads[4 * quad + k]);
    if (!mesh->twins)
        qni_expect_vertex(around, mesh->quads[4 * quad + 2]);
}

/* What a ring will be looked for in: the quads across the sides, or those that the grid tells. */
static void expect_ring(const qni_around *around, uint32_t quad, ring_guess *guess) {
    const qn_mesh *mesh = around->mesh;
    make_guess(around, quad, guess);
    for (size_t k = 0; mesh->twins && k < 4; ++k) {
        const size_t across = mesh->twins[4 * (size_t)quad + k];
        __builtin_prefetch(mesh->quads + across);
        __builtin_prefetch(mesh->twins + across);
    }
}

/* Whether a suspect may go by this round's pattern; `*other` tells whether it might by the other.
 */
static bool look_at_suspect(const qni_around *around, bool rings, const ring_guess *guess,
                            qni_candidate *item, bool *other) {
    uint32_t corner[4];
    const uint8_t colour = around->colour[item->quad];
    const int kind =
        colour == QNI_QUAD_GONE ? QNI_QUAD_STAYS : qni_kind_now(around, item->quad, corner);
    *other = kind != QNI_QUAD_STAYS && qni_is_merge(kind) == rings;
    item->turn = qni_turn_of(colour, item->quad);
    return kind != QNI_QUAD_STAYS && !*other &&
           (rings ? look_at_ring(around, corner, guess, item)
                  : look_at_merge(around, kind, corner, item));
}

int64_t qni_simplify_look(const qni_simplifier *job, uint32_t *suspects, int64_t count, bool rings,
                          qni_candidates *found) {
    const qni_around *around = &job->around;
    ring_guess guess[NEXT] = {0};
    int64_t others = 0;
    for (int64_t n = 0; rings && n < NEXT && n < count; ++n)
        expect_ring(around, suspects[n], guess + n);
    for (int64_t n = 0; n < count && !found->failed; ++n) {
        qni_candidate item = {.quad = suspects[n]};
        bool other;
        expect(around, rings, suspects, n, count);
        const bool goes = look_at_suspect(around, rings, guess + n % NEXT, &item, &other);
        if (goes)
            found->failed = !qni_candidates_add(job->context, found, &item);
        if (other)
            suspects[others++] = item.quad;
        if (rings && n + NEXT < count)
            expect_ring(around, suspects[n + NEXT], guess + n % NEXT);
    }
    return others;
}
