// SPDX-License-Identifier: MIT
/* Pairs of triangles that meet where they should not: each row of eight triangles walks down the
 * tree of boxes for the others, so that every pair is tried once. */
#include "mesh/box_tree.h"
#include "mesh/triangle_pair.h"
#include "core/context.h"
#include "core/status.h"

#include <math.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { BLOCK = 16 }; /* rows; few, so that a cancel is heard soon */

typedef struct box {
    float low[3], high[3];
} box;

typedef struct pair_job {
    qni_check *check;
    const qni_box_tree *tree;
    int64_t *found;        /* a block */
    const uint8_t *wanted; /* a vertex: its share (box_tree.h); or NULL for all */
    uint8_t *wanted_rows;  /* a row: its wanted triangles, bit k for slot k; NULL for all */
    uint8_t *marks;        /* a vertex, or NULL */
} pair_job;

/* Which of the row's boxes touch the box; bit k for slot k. */
#ifdef __SSE2__
static inline unsigned touching_four(const qni_box_row *row, const box *b, int from) {
    __m128 hits = _mm_castsi128_ps(_mm_set1_epi32(-1));
    for (int i = 0; i < 3; ++i) {
        hits = _mm_and_ps(hits,
                          _mm_cmple_ps(_mm_loadu_ps(row->low[i] + from), _mm_set1_ps(b->high[i])));
        hits = _mm_and_ps(hits,
                          _mm_cmpge_ps(_mm_loadu_ps(row->high[i] + from), _mm_set1_ps(b->low[i])));
    }
    return (unsigned)_mm_movemask_ps(hits) << from;
}

static inline unsigned touching(const qni_box_row *row, const box *b) {
    return touching_four(row, b, 0) | touching_four(row, b, 4);
}
#else
static inline unsigned touching(const qni_box_row *row, const box *b) {
    int32_t hits[QNI_BOX_WIDTH];
    for (int k = 0; k < QNI_BOX_WIDTH; ++k)
        hits[k] = (row->low[0][k] <= b->high[0]) & (row->high[0][k] >= b->low[0]) &
                  (row->low[1][k] <= b->high[1]) & (row->high[1][k] >= b->low[1]) &
                  (row->low[2][k] <= b->high[2]) & (row->high[2][k] >= b->low[2]);
    unsigned mask = 0;
    for (int k = 0; k < QNI_BOX_WIDTH; ++k)
        mask |= (unsigned)hits[k] << k;
    return mask;
}
#endif

static box box_of_slot(const qni_box_row *row, int slot) {
    box b;
    for (int i = 0; i < 3; ++i) {
        b.low[i] = row->low[i][slot];
        b.high[i] = row->high[i][slot];
    }
    return b;
}

/* Round a row of level 0, as the level above has it; a single row has none above. */
static box box_of_row(const qni_box_tree *tree, int64_t row) {
    const box all = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    return tree->levels == 1
               ? all
               : box_of_slot(&tree->rows[1][row / QNI_BOX_WIDTH], (int)(row % QNI_BOX_WIDTH));
}

static bool has_wanted(const pair_job *job, const uint32_t t[3]) {
    const int shares = job->wanted[t[0]] + job->wanted[t[1]] + job->wanted[t[2]];
    return (shares & QNI_WANTED_MASK) >= QNI_WANTED;
}

/* Without branches: most pairs share something, and what is hard to foresee. */
static bool share_sound(const pair_job *job, const uint32_t a[3], const uint32_t b[3]) {
    unsigned share = 0;
    for (int i = 0; i < 3; ++i)
        share |= ((a[i] == b[0]) | (a[i] == b[1]) | (a[i] == b[2])) * job->wanted[a[i]];
    return share & QNI_SOUND;
}

static bool meet(const pair_job *job, int64_t i, int64_t j) {
    const uint32_t *a = job->tree->triangles[i], *b = job->tree->triangles[j];
    if (job->wanted && share_sound(job, a, b))
        return false;
    if (!qni_triangles_meet(job->check->mesh.positions, a, b))
        return false;
    for (int k = 0; job->marks && k < 3; ++k) {
        __atomic_store_n(&job->marks[a[k]], 1, __ATOMIC_RELAXED);
        __atomic_store_n(&job->marks[b[k]], 1, __ATOMIC_RELAXED);
    }
    return true;
}

/* Pairs of a triangle of row a and another one of row b; a later one, where they are one row. */
static int64_t meet_rows(const pair_job *job, int64_t a, int64_t b) {
    const qni_box_tree *tree = job->tree;
    const qni_box_row *row_a = &tree->rows[0][a], *row_b = &tree->rows[0][b];
    const uint8_t *wanted = job->wanted_rows;
    const box whole_b = box_of_row(tree, b);
    int64_t found = 0;
    for (unsigned left = touching(row_a, &whole_b); left; left &= left - 1) {
        int i = __builtin_ctz(left);
        box mine = box_of_slot(row_a, i);
        unsigned mask = touching(row_b, &mine);
        if (a == b)
            mask &= 0xfeu << i;
        if (wanted && !(wanted[a] >> i & 1))
            mask &= wanted[b];
        for (; mask; mask &= mask - 1)
            found += meet(job, QNI_BOX_WIDTH * a + i, QNI_BOX_WIDTH * b + __builtin_ctz(mask));
    }
    return found;
}

typedef struct step {
    int level;
    int64_t row;
} step;

/* Every pair of rows is tried once, from its first row; where not all are wanted, from its first
 * wanted one. */
static int64_t meet_other_rows(const pair_job *job, int64_t a) {
    const qni_box_tree *tree = job->tree;
    const uint8_t *wanted = job->wanted_rows;
    step stack[QNI_BOX_LEVELS * QNI_BOX_WIDTH];
    const box mine = box_of_row(tree, a);
    int depth = 0;
    int64_t found = 0;
    stack[depth++] = (step){tree->levels - 1, 0};
    while (depth > 0) {
        step s = stack[--depth];
        if (s.level == 0) {
            if (s.row >= a || (wanted && !wanted[s.row]))
                found += meet_rows(job, a, s.row);
            continue;
        }
        for (unsigned mask = touching(&tree->rows[s.level][s.row], &mine); mask; mask &= mask - 1) {
            int64_t child = QNI_BOX_WIDTH * s.row + __builtin_ctz(mask);
            int64_t end = (child + 1) << (3 * (s.level - 1)); /* of its rows on level 0 */
            if (end > a || wanted)
                stack[depth++] = (step){s.level - 1, child};
        }
    }
    return found;
}

static void meet_block(void *pointer, int64_t block, int64_t begin, int64_t end) {
    pair_job *job = pointer;
    int64_t found = 0;
    for (int64_t row = begin; row < end; ++row)
        if (!job->wanted_rows || job->wanted_rows[row])
            found += meet_other_rows(job, row);
    job->found[block] = found;
}

static void want_rows(const pair_job *job) {
    const qni_box_tree *tree = job->tree;
    for (int64_t row = 0; row < tree->row_count[0]; ++row) {
        int64_t end = QNI_BOX_WIDTH * (row + 1);
        end = end < tree->triangle_count ? end : tree->triangle_count;
        job->wanted_rows[row] = 0;
        for (int64_t t = QNI_BOX_WIDTH * row; t < end; ++t)
            job->wanted_rows[row] |=
                (uint8_t)(has_wanted(job, tree->triangles[t]) << (t % QNI_BOX_WIDTH));
    }
}

qn_status qni_count_crossings(qni_check *check, const qni_box_tree *tree, qni_check_span span,
                              const uint8_t *wanted, uint8_t *marks, int64_t *count_out) {
    const int64_t rows = tree->row_count[0], blocks = qni_block_count(rows, BLOCK);
    pair_job job = {.check = check, .tree = tree, .wanted = wanted, .marks = marks};
    qn_status status = QN_OK;
    int64_t total = 0;
    job.found = qni_alloc_zero(check->context, blocks, sizeof *job.found);
    job.wanted_rows = wanted ? qni_alloc(check->context, rows, 1) : NULL;
    if (!job.found || (wanted && !job.wanted_rows))
        status = qni_fail_memory(check->error, "the search for self-intersections");
    if (status == QN_OK && wanted)
        want_rows(&job);
    if (status == QN_OK)
        status = qni_check_blocks(check, rows, BLOCK, span, meet_block, &job);
    for (int64_t b = 0; status == QN_OK && b < blocks; ++b)
        total += job.found[b];
    *count_out = total;
    qni_free(check->context, job.wanted_rows, rows, 1);
    qni_free(check->context, job.found, blocks, sizeof *job.found);
    return status;
}

qn_status qni_check_intersections(qni_check *check, qni_check_span span) {
    double middle = span.from + 0.2 * (span.to - span.from);
    const qni_check_span building = {span.from, middle}, pairing = {middle, span.to};
    qni_box_tree tree;
    QN_TRY(qni_box_tree_create(check, building, &tree));
    qn_status status =
        qni_count_crossings(check, &tree, pairing, NULL, NULL, &check->report->self_intersections);
    qni_box_tree_destroy(check, &tree);
    return status;
}
