// SPDX-License-Identifier: MIT
/* Unions: finest cells that are made as one, without the walls between them.
 *
 * A corner can poke through a wall so that no lattice edge tells: the wall's trace is wrong, and
 * both its cells come out badly. The box of the two cells has a loop on its outer walls that knows
 * nothing of the wall between, and a fan from any point in it is an embedded disc as in a cell. So
 * boxes of 2, 4 or 8 finest cells are tried round a cell that came out badly, and the first is
 * taken that comes out better than its cells, has the same topology, and whose triangles explain
 * the crossings that it gives up (departure from [CMS05], which leaves such corners out). */
#include "cms/stages.h"
#include "core/context.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

enum { REACHED = -1, MOST_BOXES = 53, CELLS_AROUND = 27 };

static int compare_places(const int32_t a[3], const int32_t b[3]) {
    for (int k = 2; k >= 0; --k)
        if (a[k] != b[k])
            return a[k] < b[k] ? -1 : 1;
    return 0;
}

/* The first member that is not below a place. */
static int64_t lower_bound(const qni_unions *unions, const int32_t low[3]) {
    int64_t from = 0, to = unions->member_count;
    while (from < to) {
        const int64_t middle = from + (to - from) / 2;
        if (compare_places(unions->members[middle].low, low) < 0)
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

static bool is_claimed(const qni_unions *unions, const int32_t low[3]) {
    const int64_t at = lower_bound(unions, low);
    return at < unions->member_count && compare_places(unions->members[at].low, low) == 0;
}

int64_t qni_find_union(const qni_unions *unions, const int32_t low[3]) {
    if (unions->member_count == 0)
        return -1;
    const int64_t at = lower_bound(unions, low);
    return at < unions->member_count && compare_places(unions->members[at].low, low) == 0
               ? unions->members[at].number
               : -1;
}

static bool claim(qni_stages *stages, const int32_t low[3], int32_t number) {
    qni_unions *unions = &stages->unions;
    if (is_claimed(unions, low))
        return true;
    if (!qni_stages_grow(stages, (void **)&unions->members, &unions->member_capacity,
                         unions->member_count + 1, sizeof *unions->members))
        return false;
    const int64_t at = lower_bound(unions, low);
    memmove(unions->members + at + 1, unions->members + at,
            sizeof *unions->members * (size_t)(unions->member_count - at));
    const qni_union_member member = {{low[0], low[1], low[2]}, number};
    unions->members[at] = member;
    ++unions->member_count;
    return true;
}

void qni_unions_free(qni_stages *stages) {
    qni_unions *unions = &stages->unions;
    qni_free(stages->context, unions->items, unions->capacity, sizeof *unions->items);
    qni_free(stages->context, unions->members, unions->member_capacity, sizeof *unions->members);
    memset(unions, 0, sizeof *unions);
}

/* ---- judging a box
 * ------------------------------------------------------------------------------- */

typedef struct unite_job {
    qni_stages *stages;
    const qni_trouble **troubles; /* of all chunks, by cell */
    int64_t count;
} unite_job;

static int compare_troubles(const void *a, const void *b) {
    return compare_places((*(const qni_trouble *const *)a)->cell,
                          (*(const qni_trouble *const *)b)->cell);
}

static const qni_trouble *find_trouble(const unite_job *job, const int32_t cell[3]) {
    int64_t from = 0, to = job->count;
    while (from < to) {
        const int64_t middle = from + (to - from) / 2;
        if (compare_places(job->troubles[middle]->cell, cell) < 0)
            from = middle + 1;
        else
            to = middle;
    }
    return from < job->count && compare_places(job->troubles[from]->cell, cell) == 0
               ? job->troubles[from]
               : NULL;
}

typedef struct verdict {
    int64_t pieces, loops, bad;
    bool tube;
} verdict;

/* What the cells round one come to, each on its own: boxes that hold it share them. */
typedef struct surroundings {
    int32_t low[3]; /* of the lowest one */
    bool known[CELLS_AROUND];
    verdict verdicts[CELLS_AROUND];
} surroundings;

static qn_status judge_cell(const unite_job *job, surroundings *around, const qni_cell *cell,
                            const verdict **verdict_out) {
    const int place = 9 * (cell->low[2] - around->low[2]) + 3 * (cell->low[1] - around->low[1]) +
                      cell->low[0] - around->low[0];
    const verdict none = {0, 0, 0, false};
    verdict *own = &around->verdicts[place];
    *verdict_out = own;
    if (around->known[place])
        return QN_OK;
    *own = none;
    around->known[place] = true;
    const int64_t leaf = qni_octree_find_leaf(job->stages->octree, cell);
    const qni_trouble *trouble = find_trouble(job, cell->low);
    qni_patch *patch = &job->stages->patches[0];
    bool closed;
    if (leaf < 0)
        return QN_OK;
    QN_TRY(qni_trace_patch(job->stages, patch, leaf, NULL, &closed));
    own->pieces = patch->piece_count;
    own->loops = patch->loop_count;
    own->bad = trouble ? trouble->bad : 0;
    own->tube = trouble && trouble->tube;
    return QN_OK;
}

static qn_status judge_members(const unite_job *job, surroundings *around, const qni_cell_box *box,
                               verdict *sum) {
    const verdict none = {0, 0, 0, false};
    qni_cell cell = {{0, 0, 0}, 0};
    *sum = none;
    for (int32_t n = 0; qni_box_member(box, n, &cell); ++n) {
        const verdict *own;
        QN_TRY(judge_cell(job, around, &cell, &own));
        sum->pieces += own->pieces;
        sum->loops += own->loops;
        sum->bad += own->bad;
        sum->tube = sum->tube || own->tube;
    }
    return QN_OK;
}

/* Crossings of edges strictly inside the box. */
static int64_t inner_crossings(const qni_hermite *hermite, const qni_cell_box *box) {
    int64_t count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        int32_t from[3], to[3], point[3];
        for (int k = 0; k < 3; ++k) {
            from[k] = box->low[k] + (k != axis);
            to[k] = box->low[k] + box->size[k];
        }
        for (point[2] = from[2]; point[2] < to[2]; ++point[2])
            for (point[1] = from[1]; point[1] < to[1]; ++point[1])
                for (point[0] = from[0]; point[0] < to[0]; ++point[0])
                    count += qni_hermite_edge(hermite, point, axis).count;
    }
    return count;
}

/* How much better does the box come out than its cells, if by more than `least`? Its discs must be
 * as many as the cells' discs make when they are joined at the walls between: Euler's number stays.
 */
static qn_status judge_box(const unite_job *job, surroundings *around, const qni_cell_box *box,
                           int64_t least, int64_t *gain, bool *perfect) {
    qni_patch *patch = &job->stages->patches[0];
    qni_cms_tally tally = {0};
    verdict apart;
    bool closed;
    *gain = 0;
    *perfect = false;
    QN_TRY(judge_members(job, around, box, &apart));
    if (apart.tube || apart.bad <= least) /* not even without a flaw would it be the best */
        return QN_OK;
    QN_TRY(qni_trace_patch(job->stages, patch, -1, box, &closed));
    const int64_t inner_segments = (apart.pieces - patch->piece_count) / 2,
                  euler = apart.loops - inner_segments + inner_crossings(job->stages->hermite, box);
    if (!closed || patch->traced_loops != euler || patch->dropped >= apart.bad)
        return QN_OK;
    patch->most_bad = apart.bad - 1;
    QN_TRY(qni_fill_patch(patch, &tally));
    const int64_t bad = qni_patch_flaws(patch);
    if (bad < apart.bad && qni_box_is_explained(patch, box) &&
        (patch->split || !qni_patch_loops_meet(patch))) {
        *gain = apart.bad - bad;
        *perfect = bad == 0;
    }
    return QN_OK;
}

/* ---- choosing a box
 * ------------------------------------------------------------------------------ */

/* May all cells of the box be made as one? A coarse leaf with surface in the way is named. */
static bool is_free(const qni_stages *stages, const qni_cell_box *box, qni_cell *coarse) {
    const qni_octree *octree = stages->octree;
    qni_cell cell = {{0, 0, 0}, 0};
    coarse->level = 0;
    for (int32_t n = 0; qni_box_member(box, n, &cell); ++n) {
        if (is_claimed(&stages->unions, cell.low))
            return false;
        const int level = qni_octree_level(octree, cell.low);
        if (level <= 0 || coarse->level)
            continue;
        const qni_cell leaf = {{cell.low[0] >> level << level, cell.low[1] >> level << level,
                                cell.low[2] >> level << level},
                               level};
        if (qni_octree_find_leaf(octree, &leaf) >= 0)
            *coarse = leaf;
    }
    return coarse->level == 0;
}

static bool lies_across_bounds(const qni_stages *stages, const qni_cell_box *box) {
    const qni_lattice *lattice = &stages->hermite->lattice;
    for (int k = 0; k < 3 && stages->settings.open; ++k)
        if (qni_lattice_at(lattice, k, box->low[k]) < lattice->bounds.low[k] ||
            qni_lattice_at(lattice, k, box->low[k] + box->size[k]) > lattice->bounds.high[k])
            return true;
    return false;
}

/* The box of a cell and the cell beside it that holds its corner; false when that is farther. */
static bool box_to_corner(const qni_stages *stages, const qni_trouble *trouble, qni_cell_box *box) {
    for (int k = 0; k < 3; ++k) {
        const double at = (double)trouble->corner[k];
        double planes[4];
        for (int n = 0; n < 4; ++n)
            planes[n] = qni_lattice_at(&stages->hermite->lattice, k, trouble->cell[k] - 1 + n);
        if (!(at > planes[0] && at < planes[3]))
            return false;
        box->low[k] = trouble->cell[k] - (at < planes[1]);
        box->size[k] = at < planes[1] || at > planes[2] ? 2 : 1;
    }
    return box->size[0] * box->size[1] * box->size[2] > 1;
}

/* The boxes of 2, 4 and 8 cells that hold a cell, the smaller ones first. */
static int add_boxes(const qni_trouble *trouble, bool split, qni_cell_box *boxes) {
    int count = 0;
    for (int cells = 2; cells <= 8; cells *= 2)
        for (int doubled = 1; doubled < 8; ++doubled)
            for (int below = 0; below < 8; ++below) {
                qni_cell_box box = {.split = split};
                int32_t volume = 1;
                for (int k = 0; k < 3; ++k) {
                    box.size[k] = 1 + (doubled >> k & 1);
                    box.low[k] = trouble->cell[k] - (below >> k & 1);
                    volume *= box.size[k];
                }
                if (volume == cells && (below & ~doubled) == 0)
                    boxes[count++] = box;
            }
    return count;
}

/* All boxes that hold a cell; that to the corner before all others; and those whose loop may be
 * cut, after them. */
static int list_boxes(const qni_stages *stages, const qni_trouble *trouble, qni_cell_box *boxes) {
    int count = 0;
    boxes[0].split = false;
    if (trouble->knows_corner && box_to_corner(stages, trouble, &boxes[0]))
        ++count;
    count += add_boxes(trouble, false, boxes + count);
    if (trouble->several)
        count += add_boxes(trouble, true, boxes + count);
    return count;
}

static qn_status unite(qni_stages *stages, const qni_cell_box *box) {
    qni_unions *unions = &stages->unions;
    qni_cell cell = {{0, 0, 0}, 0};
    bool room = qni_stages_grow(stages, (void **)&unions->items, &unions->capacity,
                                unions->count + 1, sizeof *unions->items);
    for (int32_t n = 0; room && qni_box_member(box, n, &cell); ++n) {
        room = claim(stages, cell.low, (int32_t)unions->count);
        qni_chunk *chunk = qni_stages_chunk_at(stages, cell.low);
        if (chunk)
            chunk->make = true;
    }
    if (!room)
        return qni_fail_memory(stages->error, "a surface");
    unions->items[unions->count++] = *box;
    return QN_OK;
}

/* A coarse leaf that holds the corner is divided first: the cell asks again in the next round. */
static qn_status try_boxes(const unite_job *job, const qni_trouble *trouble,
                           qni_veto_list *vetoes) {
    qni_stages *stages = job->stages;
    qni_cell_box boxes[MOST_BOXES], best = {{0, 0, 0}, {0, 0, 0}, false};
    const int count = list_boxes(stages, trouble, boxes);
    surroundings around = {.known = {false}};
    bool perfect = false;
    int64_t most = 0;
    for (int k = 0; k < 3; ++k)
        around.low[k] = trouble->cell[k] - 1;
    for (int n = 0; n < count && !perfect; ++n) {
        qni_cell coarse;
        int64_t gain;
        if (lies_across_bounds(stages, &boxes[n]))
            continue;
        if (!is_free(stages, &boxes[n], &coarse)) {
            if (n == 0 && trouble->knows_corner && coarse.level)
                return qni_stages_add_vetoes(stages, vetoes, &coarse, 1);
            continue;
        }
        QN_TRY(judge_box(job, &around, &boxes[n], most, &gain, &perfect));
        if (gain > most) {
            most = gain;
            best = boxes[n];
        }
        perfect = perfect || (n == 0 && trouble->knows_corner && most > 0);
    }
    return most > 0 ? unite(stages, &best) : QN_OK;
}

/* The empty cells that corners reach into stay theirs. */
static bool claim_reached(qni_stages *stages, const qni_trouble *trouble) {
    qni_cell_box box;
    qni_cell cell = {{0, 0, 0}, 0};
    if (!box_to_corner(stages, trouble, &box))
        return true;
    for (int32_t n = 0; qni_box_member(&box, n, &cell); ++n)
        if (!claim(stages, cell.low, REACHED))
            return false;
    return true;
}

static qn_status try_all(const unite_job *job, qni_veto_list *vetoes) {
    for (int64_t n = 0; n < job->count; ++n)
        if (job->troubles[n]->reaches && !claim_reached(job->stages, job->troubles[n]))
            return qni_fail_memory(job->stages->error, "a surface");
    for (int64_t n = 0; n < job->count; ++n) {
        const qni_trouble *trouble = job->troubles[n];
        if (trouble->bad && !trouble->reaches && !is_claimed(&job->stages->unions, trouble->cell))
            QN_TRY(try_boxes(job, trouble, vetoes));
    }
    return QN_OK;
}

qn_status qni_stages_unite(qni_stages *stages, qni_veto_list *vetoes) {
    unite_job job = {stages, NULL, 0};
    qni_stages_mark_none(stages);
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        job.count += stages->chunks[n].trouble_count;
    const int64_t room = job.count;
    job.troubles = qni_alloc(stages->context, room, sizeof *job.troubles);
    if (!job.troubles)
        return qni_fail_memory(stages->error, "a surface");
    job.count = 0;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t m = 0; m < stages->chunks[n].trouble_count; ++m)
            job.troubles[job.count++] = &stages->chunks[n].troubles[m];
    if (job.count)
        qsort(job.troubles, (size_t)job.count, sizeof *job.troubles, compare_troubles);
    const qn_status status = try_all(&job, vetoes);
    qni_free(stages->context, (void *)job.troubles, room, sizeof *job.troubles);
    return status;
}
