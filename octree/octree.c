// SPDX-License-Identifier: MIT
/* Which cells are leaves, from the top: over groups of blocks level by level, then within each
 * block. */
#include "octree/octree.h"
#include "core/context.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

/* A cell above the blocks that holds one at least. */
typedef struct big_cell {
    int32_t place[3]; /* in cells of its level */
    int32_t parent;   /* in the list of the next level */
    int32_t covered;  /* the level of the leaf that holds it, 0 when there is none yet */
} big_cell;

typedef struct build_job {
    qni_octree *octree;
    qni_cell_question *question;
    void *user;
    qn_error *error;
    big_cell *cells[32]; /* by level from 3, where cells are blocks */
    int64_t counts[32];
    qni_cell *large; /* leaves above level 3 */
    int64_t large_count;
} build_job;

/* ---- within a block
 * ------------------------------------------------------------------------------ */

static void set_cube(uint8_t *levels, const int at[3], int size, int level) {
    for (int z = 0; z < size; ++z)
        for (int y = 0; y < size; ++y)
            memset(levels + 64 * (at[2] + z) + 8 * (at[1] + y) + at[0], level, (size_t)size);
}

static void divide_in_block(const build_job *job, int64_t index, const int at[3], int level,
                            int most) {
    const int32_t *place = job->octree->hermite->blocks[index].place;
    const qni_cell cell = {{8 * place[0] + at[0], 8 * place[1] + at[1], 8 * place[2] + at[2]},
                           level};
    if (level == 0 || (level <= most && job->question(job->user, &cell))) {
        set_cube(job->octree->levels[index], at, 1 << level, level);
        return;
    }
    const int half = 1 << (level - 1);
    for (int n = 0; n < 8; ++n) {
        const int child[3] = {at[0] + (n & 1) * half, at[1] + (n >> 1 & 1) * half,
                              at[2] + (n >> 2) * half};
        divide_in_block(job, index, child, level - 1, most);
    }
}

static qn_status divide_blocks(const build_job *job, int most) {
    const qni_hermite *hermite = job->octree->hermite;
    const int32_t threads = qn_context_threads(hermite->context);
    const int64_t round = 64 * (int64_t)threads;
    for (int64_t first = 0; first < hermite->block_count; first += round) {
        if (qni_progress(hermite->context, "octree", (double)first / (double)hermite->block_count))
            return qni_fail(job->error, QN_ERROR_CANCELLED, "the octree was cancelled");
        const int64_t last =
            hermite->block_count - first < round ? hermite->block_count : first + round;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
        for (int64_t i = first; i < last; ++i) {
            const int32_t covered = job->cells[3] ? job->cells[3][i].covered : 0;
            const int origin[3] = {0, 0, 0};
            if (covered)
                memset(job->octree->levels[i], covered, sizeof job->octree->levels[i]);
            else
                divide_in_block(job, i, origin, 3, most);
        }
    }
    return QN_OK;
}

/* ---- above the blocks
 * ---------------------------------------------------------------------------- */

typedef struct sort_key {
    int32_t place[3];
    int32_t child;
} sort_key;

static int compare_keys(const void *a, const void *b) {
    const sort_key *p = a, *q = b;
    for (int k = 2; k >= 0; --k)
        if (p->place[k] != q->place[k])
            return p->place[k] < q->place[k] ? -1 : 1;
    return p->child - q->child;
}

/* The list of the next level, from that of this one. */
static bool list_parents(build_job *job, int level) {
    qn_context *context = job->octree->hermite->context;
    const int64_t count = job->counts[level];
    sort_key *keys = qni_alloc(context, count, sizeof *keys);
    big_cell *parents = qni_alloc(context, count, sizeof *parents);
    job->cells[level + 1] = parents;
    job->counts[level + 1] = count;
    if (!keys || !parents) {
        qni_free(context, keys, count, sizeof *keys);
        return false;
    }
    for (int64_t n = 0; n < count; ++n) {
        for (int k = 0; k < 3; ++k)
            keys[n].place[k] = job->cells[level][n].place[k] >> 1;
        keys[n].child = (int32_t)n;
    }
    qsort(keys, (size_t)count, sizeof *keys, compare_keys);
    int64_t groups = 0;
    for (int64_t n = 0; n < count; ++n) {
        if (n == 0 || memcmp(keys[n].place, keys[n - 1].place, sizeof keys[n].place) != 0) {
            const big_cell parent = {{keys[n].place[0], keys[n].place[1], keys[n].place[2]}, -1, 0};
            parents[groups++] = parent;
        }
        job->cells[level][keys[n].child].parent = (int32_t)groups - 1;
    }
    qni_free(context, keys, count, sizeof *keys);
    big_cell *fitted = qni_realloc(context, parents, count, groups, sizeof *fitted);
    if (!fitted)
        return false;
    job->cells[level + 1] = fitted;
    job->counts[level + 1] = groups;
    return true;
}

/* Ask the cells of a level that no leaf above holds. */
static qn_status ask_level(build_job *job, int level, bool topmost) {
    big_cell *cells = job->cells[level];
    const qni_hermite *hermite = job->octree->hermite;
    const int32_t threads = qn_context_threads(hermite->context);
    if (qni_progress(hermite->context, "octree", 0))
        return qni_fail(job->error, QN_ERROR_CANCELLED, "the octree was cancelled");
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (int64_t n = 0; n < job->counts[level]; ++n) {
        cells[n].covered = topmost ? 0 : job->cells[level + 1][cells[n].parent].covered;
        const qni_cell cell = {
            {cells[n].place[0] << level, cells[n].place[1] << level, cells[n].place[2] << level},
            level};
        if (level > 3 && !cells[n].covered && job->question(job->user, &cell))
            cells[n].covered = level;
    }
    return QN_OK;
}

static qn_status keep_large(build_job *job, int top) {
    for (int pass = 0; pass < 2; ++pass) {
        int64_t count = 0;
        for (int level = 4; level <= top; ++level)
            for (int64_t n = 0; n < job->counts[level]; ++n) {
                const big_cell *big = &job->cells[level][n];
                const qni_cell cell = {
                    {big->place[0] << level, big->place[1] << level, big->place[2] << level},
                    level};
                if (big->covered != level)
                    continue;
                if (pass == 1)
                    job->large[count] = cell;
                ++count;
            }
        if (pass == 0)
            job->large = qni_alloc(job->octree->hermite->context, count, sizeof *job->large);
        if (!job->large)
            return qni_fail_memory(job->error, "the octree");
        job->large_count = count;
    }
    return QN_OK;
}

static qn_status divide_large(build_job *job, int top) {
    const qni_hermite *hermite = job->octree->hermite;
    job->counts[3] = hermite->block_count;
    job->cells[3] = qni_alloc_zero(hermite->context, hermite->block_count, sizeof *job->cells[3]);
    bool room = job->cells[3] != NULL;
    for (int64_t i = 0; room && i < hermite->block_count; ++i)
        memcpy(job->cells[3][i].place, hermite->blocks[i].place, sizeof job->cells[3][i].place);
    for (int level = 3; level < top && room; ++level)
        room = list_parents(job, level);
    if (!room)
        return qni_fail_memory(job->error, "the octree");
    for (int level = top; level >= 3; --level)
        QN_TRY(ask_level(job, level, level == top));
    return keep_large(job, top);
}

static qn_status build(build_job *job) {
    qni_octree *octree = job->octree;
    const qni_hermite *hermite = octree->hermite;
    octree->levels = qni_alloc_zero(hermite->context, hermite->block_count, sizeof *octree->levels);
    octree->starts = qni_alloc_zero(hermite->context, hermite->block_count, sizeof *octree->starts);
    octree->ranks = qni_alloc_zero(hermite->context, hermite->block_count, sizeof *octree->ranks);
    octree->bases = qni_alloc_zero(hermite->context, hermite->block_count, sizeof *octree->bases);
    if (!octree->levels || !octree->starts || !octree->ranks || !octree->bases)
        return qni_fail_memory(job->error, "the octree");
    const int top = hermite->lattice.top;
    if (job->question && top > 3)
        QN_TRY(divide_large(job, top));
    if (job->question && top > 0)
        QN_TRY(divide_blocks(job, top < 3 ? top : 3));
    return qni_octree_number_leaves(octree, job->large, job->large_count, job->error);
}

qn_status qni_octree_create(const qni_hermite *hermite, qni_cell_question *question, void *user,
                            qni_octree *octree, qn_error *error) {
    const qni_octree empty = {.hermite = hermite};
    *octree = empty;
    build_job job = {.octree = octree, .question = question, .user = user, .error = error};
    const qn_status status = build(&job);
    for (int level = 3; level < 32; ++level)
        qni_free(hermite->context, job.cells[level], job.counts[level], sizeof *job.cells[level]);
    qni_free(hermite->context, job.large, job.large_count, sizeof *job.large);
    if (status != QN_OK)
        qni_octree_destroy(octree);
    return status;
}

void qni_octree_keep_list(qni_octree *octree) {
    qn_context *context = octree->hermite->context;
    const int64_t blocks = octree->hermite->block_count;
    qni_free(context, octree->levels, blocks, sizeof *octree->levels);
    qni_free(context, octree->starts, blocks, sizeof *octree->starts);
    qni_free(context, octree->ranks, blocks, sizeof *octree->ranks);
    qni_free(context, octree->bases, blocks, sizeof *octree->bases);
    octree->levels = NULL;
    octree->starts = NULL;
    octree->ranks = NULL;
    octree->bases = NULL;
}

void qni_octree_destroy(qni_octree *octree) {
    qni_octree_keep_list(octree);
    qni_free(octree->hermite->context, octree->leaves, octree->leaf_count, sizeof *octree->leaves);
    octree->leaves = NULL;
}
