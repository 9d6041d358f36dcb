// SPDX-License-Identifier: MIT
/* Where crossings can be (untangle.h): all else is proved to have none.
 *
 * Quads that share a vertex do not cross if it is sound (untangle_fans.c). Of those that share
 * none, one round a lattice edge, with a corner inside each of the four cells, lies inside the
 * block of these cells. If no other vertex is in them, another quad of that kind has a block beside
 * it, or a vertex in one of its cells, which is one of its own. (Ju and Udeshi 2006 prove the same
 * by the octahedra round the edges, for quads that are cut inside them.)
 *
 * A quad is suspect if a corner is not sound, or it is not of that kind. Any other can cross a
 * suspect one only from a cell that the suspect one's box meets. */
#include "core/status.h"
#include "mesh/cell_map.h"
#include "mesh/untangle.h"
#include "mesh/untangle_table.h"

#include <math.h>
#include <string.h>

enum { WORD = 64, MOST_CELLS = 16 };

/* In lattice cells: far more than rounding moves a vertex, far less than matters. */
static const double margin = 1e-6;

typedef struct search {
    qn_context *context;
    const qn_mesh_view *mesh;
    const double (*to_lattice)[4];
    qni_cell *cell_of;   /* [vertex_count] */
    qni_vertex_set lone; /* well inside their cells, and alone there */
    qni_cell_map cells;  /* with vertices: used; with several: shared; met by suspects: marked */
    qni_suspects *out;
} search;

/* All of a word's vertices belong to one thread. */
#define EACH_VERTEX_OF(word)                                                                       \
    for (int64_t v = WORD * (word); v < WORD * (word) + WORD && v < count; ++v)

/* ---- cells ----------------------------------------------------------------------------------- */

static void local_of(const search *s, int64_t vertex, double local[3]) {
    qni_local_place(s->to_lattice, s->mesh->positions + 3 * vertex, local);
}

/* The vertex' cell. False unless it lies well inside. */
static bool cell_of(const search *s, int64_t vertex, qni_cell *own) {
    double local[3];
    int well = 1;
    local_of(s, vertex, local);
    for (int a = 0; a < 3; ++a) {
        own->at[a] = qni_local_floor(local[a]);
        const double part = local[a] - own->at[a];
        well &= (part > margin) & (part < 1 - margin);
    }
    return well;
}

/* Vertices that follow each other are mostly in one leaf. */
typedef struct last_leaf {
    uint64_t key;
    qni_cell_leaf *leaf;
} last_leaf;

static inline qni_cell_leaf *leaf_of(const search *s, const qni_cell *cell, last_leaf *last) {
    const uint64_t key = qni_cell_key(cell);
    if (key != last->key)
        *last = (last_leaf){key, qni_cell_map_find(&s->cells, key)};
    return last->leaf;
}

/* Keys that were seen lately, by their last bits. */
enum { SEEN = 4096, BLOCK = 512 };
typedef struct seen_keys {
    uint64_t key[SEEN];
} seen_keys;

static bool is_new(seen_keys *seen, uint64_t key) {
    uint64_t *place = &seen->key[qni_cell_hash(key) % SEEN];
    const bool new = *place != key;
    *place = key;
    return new;
}

/* All vertices' cells, and how many leaves they can lie in: few of those are counted again. The
 * blocks of words are the same for any number of threads. */
static int64_t find_cells(const search *s) {
    const int64_t count = s->mesh->vertex_count, words = count / WORD + 1;
    int64_t leaves = 0;
#pragma omp parallel for schedule(static) reduction(+ : leaves)                                    \
    num_threads(qn_context_threads(s->context))
    for (int64_t block = 0; block < (words + BLOCK - 1) / BLOCK; ++block) {
        seen_keys seen = {{0}};
        for (int64_t word = BLOCK * block; word < BLOCK * (block + 1) && word < words; ++word)
            EACH_VERTEX_OF(word) {
                qni_cell *own = &s->cell_of[v];
                if (cell_of(s, v, own))
                    s->lone.bits[word] |= UINT64_C(1) << (v % WORD);
                leaves += is_new(&seen, qni_cell_key(own));
            }
    }
    return leaves;
}

static void enter_cells(const search *s) {
    const int64_t count = s->mesh->vertex_count;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(s->context))
    for (int64_t word = 0; word <= count / WORD; ++word) {
        last_leaf last = {0, NULL};
        EACH_VERTEX_OF(word) {
            const qni_cell *own = &s->cell_of[v];
            const uint64_t key = qni_cell_key(own);
            if (key != last.key)
                last = (last_leaf){key, qni_cell_map_claim(&s->cells, key)};
            if (qni_cell_add(&s->cells, last.leaf, QNI_CELL_USED, own))
                qni_cell_add(&s->cells, last.leaf, QNI_CELL_SHARED, own);
        }
    }
}

/* Those of `from` whose cell is in the set, or with `without` those whose cell is not. */
static void pick_by_cell(const search *s, const qni_vertex_set *from, qni_cell_set set,
                         bool without, const qni_vertex_set *to) {
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(s->context))
    for (int64_t word = 0; word <= from->count / WORD; ++word) {
        last_leaf last = {0, NULL};
        uint64_t bits = 0;
        for (uint64_t left = from->bits[word]; left; left &= left - 1) {
            const qni_cell *own = &s->cell_of[WORD * word + __builtin_ctzll(left)];
            if (qni_cell_has(leaf_of(s, own, &last), set, own) != without)
                bits |= left & -left;
        }
        to->bits[word] = bits;
    }
}

/* Whether the quad's corners have the four cells round a lattice edge for themselves. */
static bool has_its_cells(const search *s, const uint32_t *quad) {
    const int32_t *at[4];
    int32_t steps = 0;
    for (int k = 0; k < 4; ++k) {
        at[k] = s->cell_of[quad[k]].at;
        if (!qni_in_set(&s->lone, quad[k]))
            return false;
    }
    for (int a = 0; a < 3; ++a) {
        const int32_t first = at[1][a] - at[0][a], second = at[2][a] - at[1][a];
        if (at[3][a] - at[0][a] != second || first > 1 || first < -1 || second > 1 || second < -1)
            return false;
        steps += (first != 0) + 4 * (second != 0) + 16 * (first != 0 && second != 0);
    }
    return steps == 1 + 4; /* one along one axis, then one along another */
}

static bool is_suspect(const search *s, const uint32_t *quad) {
    for (int k = 0; k < 4; ++k)
        if (!qni_in_set(&s->out->sound, quad[k]))
            return true;
    return !has_its_cells(s, quad);
}

static void find_suspects(const search *s) {
    const int64_t count = s->mesh->quad_count;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(s->context))
    for (int64_t word = 0; word <= count / WORD; ++word)
        for (int64_t q = WORD * word; q < WORD * word + WORD && q < count; ++q)
            s->out->quads.bits[word] |= (uint64_t)is_suspect(s, s->mesh->quads + 4 * q)
                                        << (q % WORD);
}

/* ---- what is near suspects ------------------------------------------------------------------- */

/* The cells that a quad's box meets, and the slab between two planes across it. */
typedef struct extent {
    int32_t low[3], high[3];
    double direction[3], from, to;
} extent;

static extent extent_of(const search *s, const uint32_t *quad) {
    double p[4][3];
    extent e = {.from = INFINITY, .to = -INFINITY};
    for (int k = 0; k < 4; ++k)
        local_of(s, quad[k], p[k]);
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, d = (a + 2) % 3;
        e.direction[a] =
            (p[2][b] - p[0][b]) * (p[3][d] - p[1][d]) - (p[2][d] - p[0][d]) * (p[3][b] - p[1][b]);
        e.low[a] = qni_local_floor(fmin(fmin(p[0][a], p[1][a]), fmin(p[2][a], p[3][a])) - margin);
        e.high[a] = qni_local_floor(fmax(fmax(p[0][a], p[1][a]), fmax(p[2][a], p[3][a])) + margin);
    }
    for (int k = 0; k < 4; ++k) {
        const double along =
            e.direction[0] * p[k][0] + e.direction[1] * p[k][1] + e.direction[2] * p[k][2];
        e.from = along < e.from ? along : e.from;
        e.to = along > e.to ? along : e.to;
    }
    return e;
}

static bool meets_slab(const extent *e, const int32_t at[3]) {
    double middle = 0, half = margin;
    for (int a = 0; a < 3; ++a) {
        middle += e->direction[a] * (at[a] + 0.5);
        half += fabs(e->direction[a]) * (0.5 + margin);
    }
    return middle + half >= e->from && middle - half <= e->to;
}

/* Quads that are not suspect have a corner in each of their cells, alone. At one that they share
 * with this quad no two cross, since all of theirs are sound: its cell needs no mark. */
static bool is_own(const search *s, const uint32_t *quad, const qni_cell *cell) {
    for (int k = 0; k < 4; ++k)
        if (memcmp(s->cell_of[quad[k]].at, cell->at, sizeof cell->at) == 0)
            return qni_in_set(&s->lone, quad[k]);
    return false;
}

/* Quads of a lattice meet a few cells; others are not worth it. */
static bool is_large(const extent *e) {
    bool large = false;
    for (int a = 0; a < 3; ++a)
        large = large || e->high[a] - e->low[a] > MOST_CELLS;
    return large;
}

static void mark_near(const search *s, const uint32_t *quad, last_leaf *last) {
    const extent e = extent_of(s, quad);
    qni_cell cell;
    if (is_large(&e)) {
        __atomic_store_n(&s->out->too_large, true, __ATOMIC_RELAXED);
        return;
    }
    for (cell.at[2] = e.low[2]; cell.at[2] <= e.high[2]; ++cell.at[2])
        for (cell.at[1] = e.low[1]; cell.at[1] <= e.high[1]; ++cell.at[1])
            for (cell.at[0] = e.low[0]; cell.at[0] <= e.high[0]; ++cell.at[0]) {
                qni_cell_leaf *leaf = leaf_of(s, &cell, last);
                if (leaf && qni_cell_has(leaf, QNI_CELL_USED, &cell) && !is_own(s, quad, &cell) &&
                    meets_slab(&e, cell.at))
                    qni_cell_add(&s->cells, leaf, QNI_CELL_MARKED, &cell);
            }
}

static void find_near(const search *s) {
    const qni_vertex_set *quads = &s->out->quads;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(s->context))
    for (int64_t word = 0; word <= quads->count / WORD; ++word) {
        last_leaf last = {0, NULL};
        for (uint64_t left = quads->bits[word]; left; left &= left - 1)
            mark_near(s, s->mesh->quads + 4 * (WORD * word + __builtin_ctzll(left)), &last);
    }
    pick_by_cell(s, &s->lone, QNI_CELL_MARKED, false, &s->out->near);
}

/* ---- all of it ------------------------------------------------------------------------------- */

/* A cell's edge, about, in world units. */
static double unit_of(const double m[3][4]) {
    const double volume = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                          m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                          m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    return 1 / cbrt(fabs(volume));
}

static qn_status look_at_cells(search *s, qn_error *error) {
    const int64_t count = s->mesh->vertex_count;
    s->cell_of = qni_alloc(s->context, count, sizeof *s->cell_of);
    if (!s->cell_of || qni_vertex_set_alloc(s->context, count, &s->lone, error) != QN_OK ||
        !qni_cell_map_alloc(s->context, find_cells(s), &s->cells))
        return qni_fail_memory(error, "the search for crossings");
    enter_cells(s);
    pick_by_cell(s, &s->lone, QNI_CELL_SHARED, true, &s->lone);
    find_suspects(s);
    s->out->count = qni_vertex_set_count(&s->out->quads);
    if (s->out->count > 0)
        find_near(s);
    return QN_OK;
}

static qn_status alloc_sets(const search *s, qn_error *error) {
    const int64_t count = s->mesh->vertex_count;
    memset(s->out, 0, sizeof *s->out);
    QN_TRY(qni_vertex_set_alloc(s->context, s->mesh->quad_count, &s->out->quads, error));
    QN_TRY(qni_vertex_set_alloc(s->context, count, &s->out->near, error));
    return qni_vertex_set_alloc(s->context, count, &s->out->sound, error);
}

void qni_suspects_free(qn_context *context, qni_suspects *suspects) {
    qni_vertex_set_free(context, &suspects->quads);
    qni_vertex_set_free(context, &suspects->near);
    qni_vertex_set_free(context, &suspects->sound);
}

qn_status qni_untangle_suspects(qn_context *context, const qn_mesh_view *mesh,
                                const double to_lattice[3][4], qni_suspects *suspects,
                                qn_error *error) {
    search s = {.context = context, .mesh = mesh, .to_lattice = to_lattice, .out = suspects};
    qn_status status = alloc_sets(&s, error);
    if (status == QN_OK)
        status = qni_untangle_sound(context, mesh, unit_of(to_lattice), &suspects->sound, error);
    if (status == QN_OK)
        status = look_at_cells(&s, error);
    qni_cell_map_free(&s.cells);
    qni_vertex_set_free(context, &s.lone);
    qni_free(context, s.cell_of, mesh->vertex_count, sizeof *s.cell_of);
    if (status != QN_OK)
        qni_suspects_free(context, suspects);
    return status;
}
