// SPDX-License-Identifier: MIT
/* Choosing the diagonals of quads: by the MaxMin angle criterion ([DMC21] section 5.3), except
 * where that would join four triangles at an edge.
 *
 * The chosen diagonals lie in buckets by their lower vertex, where each side of each face and each
 * other diagonal is looked up. What is found there twice is rare, and dealt with one by one. */
#include "mesh/diagonals.h"
#include "core/context.h"
#include "core/sort.h"
#include "core/status.h"
#include "mesh/mesh.h"

#include <string.h>

enum { MANY = 16, NO_ENTRY = -1 }; /* buckets above MANY are searched by halving */

typedef struct pair {
    uint32_t low, high;
} pair;

/* A diagonal of one of the quads in question, and how many edges the cut mesh has along it. */
typedef struct watched {
    pair ends;
    int64_t uses;
} watched;

typedef struct chooser {
    const qn_mesh_view *mesh;
    qni_diagonals *out;
    uint32_t *starts;  /* [vertex_count + 1]: where the bucket of each vertex begins */
    uint32_t *highs;   /* [quad_count]: the upper vertices of the chosen diagonals */
    uint64_t *doubled; /* a bit for each of these, the first where several are equal: another face
                        * has an edge there */
    int64_t doubled_count;
    uint64_t *marked; /* a bit a vertex: lower end of a watched diagonal */
    int64_t *asked;   /* [asked_count]: the quads in question, ascending */
    int64_t asked_count;
    watched *watch; /* [watch_count]: their diagonals, ascending */
    int64_t watch_count;
} chooser;

static int64_t words(int64_t bits) {
    return bits / 64 + 1;
}

static bool bit(const uint64_t *bits, int64_t i) {
    return bits[i / 64] >> (i % 64) & 1;
}

static pair pair_of(uint32_t a, uint32_t b) {
    const pair ends = {a < b ? a : b, a < b ? b : a};
    return ends;
}

static pair diagonal(const chooser *c, int64_t quad, bool along_02) {
    const uint32_t *q = c->mesh->quads + 4 * quad;
    return along_02 ? pair_of(q[0], q[2]) : pair_of(q[1], q[3]);
}

/* Only quads of four vertices have a choice. */
static bool has_choice(const uint32_t q[4]) {
    return q[0] != q[1] && q[0] != q[2] && q[0] != q[3] && q[1] != q[2] && q[1] != q[3] &&
           q[2] != q[3];
}

static void choose_by_angle(chooser *c) {
    const qn_mesh_view *mesh = c->mesh;
    const int64_t count = words(mesh->quad_count);
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(c->out->context))
    for (int64_t word = 0; word < count; ++word) {
        uint64_t bits = 0;
        for (int64_t q = 64 * word; q < 64 * word + 64 && q < mesh->quad_count; ++q)
            if (qni_quad_splits_02(mesh->positions, mesh->quads + 4 * q))
                bits |= UINT64_C(1) << (q % 64);
        c->out->along_02[word] = bits;
    }
}

/* ---- finding the doubled ones ------------------------------------------------------------------
 */

static void fill_buckets(chooser *c) {
    const qn_mesh_view *mesh = c->mesh;
    for (int64_t q = 0; q < mesh->quad_count; ++q)
        if (has_choice(mesh->quads + 4 * q))
            ++c->starts[diagonal(c, q, qni_along_02(c->out, q)).low];
    uint32_t total = 0;
    for (int64_t v = 0; v <= mesh->vertex_count; ++v) {
        total += c->starts[v]; /* now the end, which falls to the start as the bucket fills */
        c->starts[v] = total;
    }
    for (int64_t q = 0; q < mesh->quad_count; ++q)
        if (has_choice(mesh->quads + 4 * q)) {
            const pair ends = diagonal(c, q, qni_along_02(c->out, q));
            c->highs[--c->starts[ends.low]] = ends.high;
        }
}

static int compare_highs(const void *first, const void *second) {
    const uint32_t a = *(const uint32_t *)first, b = *(const uint32_t *)second;
    return (a > b) - (a < b);
}

static bool sort_buckets(chooser *c) {
    for (int64_t v = 0; v < c->mesh->vertex_count; ++v) {
        uint32_t *highs = c->highs + c->starts[v];
        const int64_t count = c->starts[v + 1] - c->starts[v];
        if (count > MANY) {
            if (!qni_sort(c->out->context, highs, count, sizeof *highs, compare_highs))
                return false;
            continue;
        }
        for (int64_t i = 1; i < count; ++i) {
            const uint32_t high = highs[i];
            int64_t at = i;
            for (; at > 0 && highs[at - 1] > high; --at)
                highs[at] = highs[at - 1];
            highs[at] = high;
        }
    }
    return true;
}

/* The first entry of a pair; NO_ENTRY when none of the chosen diagonals lies there. */
static int64_t entry_of(const chooser *c, pair ends) {
    int64_t from = c->starts[ends.low], to = c->starts[ends.low + 1];
    const int64_t end = to;
    while (to - from > MANY) {
        const int64_t middle = from + (to - from) / 2;
        if (c->highs[middle] < ends.high)
            from = middle + 1;
        else
            to = middle;
    }
    while (from < end && c->highs[from] < ends.high)
        ++from;
    return from < end && c->highs[from] == ends.high ? from : NO_ENTRY;
}

static int64_t mark(chooser *c, int64_t entry) {
    const uint64_t one = UINT64_C(1) << (entry % 64);
    return !(__atomic_fetch_or(&c->doubled[entry / 64], one, __ATOMIC_RELAXED) & one);
}

/* Mark the diagonals along a side of a face. */
static int64_t mark_along(chooser *c, uint32_t a, uint32_t b) {
    const int64_t entry = entry_of(c, pair_of(a, b));
    return entry == NO_ENTRY ? 0 : mark(c, entry);
}

/* Mark the diagonals of a bucket that are there twice. */
static int64_t mark_twins(chooser *c, int64_t vertex) {
    int64_t found = 0, first = c->starts[vertex];
    for (int64_t i = first + 1; i < c->starts[vertex + 1]; ++i) {
        if (c->highs[i] == c->highs[first])
            found += mark(c, first);
        else
            first = i;
    }
    return found;
}

static void mark_doubled(chooser *c) {
    const qn_mesh_view *mesh = c->mesh;
    int64_t found = 0;
#pragma omp parallel num_threads(qn_context_threads(c->out->context)) reduction(+ : found)
    {
#pragma omp for schedule(static) nowait
        for (int64_t v = 0; v < mesh->vertex_count; ++v)
            found += mark_twins(c, v);
#pragma omp for schedule(static) nowait
        for (int64_t q = 0; q < mesh->quad_count; ++q)
            for (int side = 0; side < 4; ++side)
                found +=
                    mark_along(c, mesh->quads[4 * q + side], mesh->quads[4 * q + (side + 1) % 4]);
#pragma omp for schedule(static) nowait
        for (int64_t t = 0; t < mesh->triangle_count; ++t)
            for (int side = 0; side < 3; ++side)
                found += mark_along(c, mesh->triangles[3 * t + side],
                                    mesh->triangles[3 * t + (side + 1) % 3]);
    }
    c->doubled_count = found;
}

/* ---- turning them ------------------------------------------------------------------------------
 */

static bool is_doubled(const chooser *c, int64_t quad) {
    if (!has_choice(c->mesh->quads + 4 * quad))
        return false;
    return bit(c->doubled, entry_of(c, diagonal(c, quad, qni_along_02(c->out, quad))));
}

static int compare_watched(const void *first, const void *second) {
    const pair a = ((const watched *)first)->ends, b = ((const watched *)second)->ends;
    if (a.low != b.low)
        return a.low < b.low ? -1 : 1;
    return (a.high > b.high) - (a.high < b.high);
}

static watched *find(const chooser *c, pair ends) {
    if (!bit(c->marked, ends.low))
        return NULL;
    const watched key = {ends, 0};
    int64_t low = 0, high = c->watch_count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        const int order = compare_watched(&c->watch[middle], &key);
        if (order == 0)
            return &c->watch[middle];
        if (order < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return NULL;
}

/* The quads in question, and both diagonals of each, once. */
static bool gather(chooser *c) {
    for (int64_t q = 0; q < c->mesh->quad_count; ++q)
        if (is_doubled(c, q)) {
            c->asked[c->asked_count++] = q;
            c->watch[c->watch_count++].ends = diagonal(c, q, true);
            c->watch[c->watch_count++].ends = diagonal(c, q, false);
        }
    if (!qni_sort(c->out->context, c->watch, c->watch_count, sizeof *c->watch, compare_watched))
        return false;
    int64_t kept = 0;
    for (int64_t i = 0; i < c->watch_count; ++i)
        if (kept == 0 || compare_watched(&c->watch[kept - 1], &c->watch[i]) != 0)
            c->watch[kept++] = c->watch[i];
    c->watch_count = kept;
    for (int64_t i = 0; i < kept; ++i)
        c->marked[c->watch[i].ends.low / 64] |= UINT64_C(1) << (c->watch[i].ends.low % 64);
    return true;
}

/* Sides of faces count as one edge, however many faces share it; each cut makes another. */
static void count_uses(chooser *c) {
    const qn_mesh_view *mesh = c->mesh;
    const int64_t faces = mesh->quad_count + mesh->triangle_count;
    for (int64_t f = 0; f < faces; ++f) {
        const bool quad = f < mesh->quad_count;
        const int corners = quad ? 4 : 3;
        const uint32_t *v =
            quad ? mesh->quads + 4 * f : mesh->triangles + 3 * (f - mesh->quad_count);
        for (int side = 0; side < corners; ++side) {
            watched *edge = find(c, pair_of(v[side], v[(side + 1) % corners]));
            if (edge)
                edge->uses = 1;
        }
    }
    for (int64_t q = 0; q < mesh->quad_count; ++q) {
        watched *cut = find(c, diagonal(c, q, qni_along_02(c->out, q)));
        if (cut && has_choice(mesh->quads + 4 * q))
            ++cut->uses;
    }
}

/* One pass over the quads in question; each turn leaves one edge less doubled, so passes end. */
static int64_t turn(chooser *c) {
    int64_t turned = 0;
    for (int64_t i = 0; i < c->asked_count; ++i) {
        const int64_t q = c->asked[i];
        const bool along_02 = qni_along_02(c->out, q);
        watched *now = find(c, diagonal(c, q, along_02));
        watched *other = find(c, diagonal(c, q, !along_02));
        if (now->uses < 2 || other->uses > 0)
            continue;
        --now->uses;
        ++other->uses;
        c->out->along_02[q / 64] ^= UINT64_C(1) << (q % 64);
        ++turned;
    }
    return turned;
}

static bool resolve(chooser *c) {
    qn_context *context = c->out->context;
    int64_t most = 0;
    for (int64_t q = 0; q < c->mesh->quad_count; ++q)
        most += is_doubled(c, q);
    c->asked = qni_alloc(context, most, sizeof *c->asked);
    c->watch = qni_alloc_zero(context, 2 * most, sizeof *c->watch);
    c->marked = qni_alloc_zero(context, words(c->mesh->vertex_count), sizeof *c->marked);
    const bool good = c->asked && c->watch && c->marked && gather(c);
    if (good) {
        count_uses(c);
        for (int64_t turned = 1; turned;)
            c->out->turned += turned = turn(c);
        for (int64_t i = 0; i < c->asked_count; ++i)
            c->out->shared +=
                find(c, diagonal(c, c->asked[i], qni_along_02(c->out, c->asked[i])))->uses > 1;
    }
    qni_free(context, c->marked, words(c->mesh->vertex_count), sizeof *c->marked);
    qni_free(context, c->watch, 2 * most, sizeof *c->watch);
    qni_free(context, c->asked, most, sizeof *c->asked);
    return good;
}

static bool find_and_resolve(chooser *c) {
    qn_context *context = c->out->context;
    const int64_t vertices = c->mesh->vertex_count, quads = c->mesh->quad_count;
    c->starts = qni_alloc_zero(context, vertices + 1, sizeof *c->starts);
    c->highs = qni_alloc(context, quads, sizeof *c->highs);
    c->doubled = qni_alloc_zero(context, words(quads), sizeof *c->doubled);
    bool good = c->starts && c->highs && c->doubled;
    if (good) {
        fill_buckets(c);
        good = sort_buckets(c);
    }
    if (good) {
        mark_doubled(c);
        good = c->doubled_count == 0 || resolve(c);
    }
    qni_free(context, c->doubled, words(quads), sizeof *c->doubled);
    qni_free(context, c->highs, quads, sizeof *c->highs);
    qni_free(context, c->starts, vertices + 1, sizeof *c->starts);
    return good;
}

qn_status qni_diagonals_choose(qn_context *context, const qn_mesh_view *mesh,
                               qni_diagonals *diagonals, qn_error *error) {
    *diagonals = (qni_diagonals){.context = context, .quad_count = mesh->quad_count};
    if (mesh->quad_count == 0)
        return QN_OK;
    if (mesh->quad_count > UINT32_MAX)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "more than 2^32 - 1 quads cannot be cut into triangles: keep the quads");
    chooser c = {.mesh = mesh, .out = diagonals};
    diagonals->along_02 = qni_alloc(context, words(mesh->quad_count), sizeof *diagonals->along_02);
    if (diagonals->along_02) {
        choose_by_angle(&c);
        if (find_and_resolve(&c)) {
            if (diagonals->turned || diagonals->shared)
                qni_log(context, diagonals->shared ? QN_LOG_WARNING : QN_LOG_DEBUG,
                        "cut into triangles, %lld quads take their other diagonal because the "
                        "first is an edge of other faces; of %lld both are",
                        (long long)diagonals->turned, (long long)diagonals->shared);
            return QN_OK;
        }
    }
    qni_diagonals_free(diagonals);
    return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                    "not enough memory to choose the diagonals of %lld quads",
                    (long long)mesh->quad_count);
}

void qni_diagonals_free(qni_diagonals *diagonals) {
    qni_free(diagonals->context, diagonals->along_02, words(diagonals->quad_count),
             sizeof *diagonals->along_02);
    diagonals->along_02 = NULL;
}
