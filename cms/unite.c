// SPDX-License-Identifier: MIT
/* Unions: finest cells that are made as one, without the walls between them.
 *
 * A corner can poke through a wall so that no lattice edge tells: the wall's trace is wrong, and
 * both its cells come out badly. The box of the two cells has a loop on its outer walls that knows
 * nothing of the wall between, and a fan from any point in it is an embedded disc as in a cell. So
 * boxes of 2, 4 or 8 finest cells are tried round a cell that came out badly, and the first is
 * taken that comes out better than its cells, has the same topology, and whose triangles explain
 * the crossings that it gives up (departure from [CMS05], which leaves such corners out). */
#include "cms/boxes.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

enum { REACHED = -1, MOST_BOXES = 53, AHEAD = 64 };

/* The first member that is not below a place. */
static int64_t lower_bound(const qni_unions *unions, const int32_t low[3]) {
    int64_t from = 0, to = unions->member_count;
    while (from < to) {
        const int64_t middle = from + (to - from) / 2;
        if (qni_compare_places(unions->members[middle].low, low) < 0)
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

static bool is_claimed(const qni_unions *unions, const int32_t low[3]) {
    const int64_t at = lower_bound(unions, low);
    return at < unions->member_count && qni_compare_places(unions->members[at].low, low) == 0;
}

int64_t qni_find_union(const qni_unions *unions, const int32_t low[3]) {
    if (unions->member_count == 0)
        return -1;
    const int64_t at = lower_bound(unions, low);
    return at < unions->member_count && qni_compare_places(unions->members[at].low, low) == 0
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

/* The best of the boxes that hold a cell; `gain` is 0 when none is any good. */
static qn_status choose(const qni_box_judge *judge, const qni_trouble *trouble, qni_cell_box *best,
                        int64_t *most) {
    qni_stages *stages = judge->stages;
    qni_cell_box boxes[MOST_BOXES];
    const int count = list_boxes(stages, trouble, boxes);
    qni_surroundings around = {.known = {false}};
    bool perfect = false;
    *most = 0;
    for (int k = 0; k < 3; ++k)
        around.low[k] = trouble->cell[k] - 1;
    for (int n = 0; n < count && !perfect; ++n) {
        qni_cell coarse;
        int64_t gain;
        if (lies_across_bounds(stages, &boxes[n]))
            continue;
        if (!is_free(stages, &boxes[n], &coarse)) {
            if (n == 0 && trouble->knows_corner && coarse.level)
                return QN_OK; /* the leaf with the corner should have been divided */
            continue;
        }
        QN_TRY(qni_judge_box(judge, &around, &boxes[n], *most, &gain, &perfect));
        if (gain > *most) {
            *most = gain;
            *best = boxes[n];
        }
        perfect = perfect || (n == 0 && trouble->knows_corner && *most > 0);
    }
    return QN_OK;
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

static bool is_to_be_tried(const qni_stages *stages, const qni_trouble *trouble) {
    return trouble->bad && !trouble->reaches && !is_claimed(&stages->unions, trouble->cell);
}

/* Coarse leaves that hold a cell's corner are divided first: the cell asks again in the next round,
 * and all that would be united now would have to be united anew. */
static qn_status find_coarse(const qni_box_judge *judge, qni_veto_list *vetoes) {
    qni_stages *stages = judge->stages;
    for (int64_t n = 0; n < judge->count; ++n) {
        qni_cell_box box;
        qni_cell coarse;
        const qni_trouble *trouble = judge->troubles[n];
        if (is_to_be_tried(stages, trouble) && trouble->knows_corner &&
            box_to_corner(stages, trouble, &box) && !lies_across_bounds(stages, &box) &&
            !is_free(stages, &box, &coarse) && coarse.level)
            QN_TRY(qni_stages_add_vetoes(stages, vetoes, &coarse, 1));
    }
    return QN_OK;
}

/* Several threads try the boxes of the next cells, as if none of these came to be united before
 * another: most will not. */
static qn_status look_ahead(qni_box_judge *judge, int64_t first, int64_t last) {
    int32_t failed = 0;
#pragma omp parallel for schedule(dynamic, 8) num_threads(judge->stages->threads)
    for (int64_t n = first; n < last; ++n) {
        qni_cell_box box;
        int64_t gain;
        if (is_to_be_tried(judge->stages, judge->troubles[n]) &&
            choose(judge, judge->troubles[n], &box, &gain) != QN_OK)
            __atomic_store_n(&failed, 1, __ATOMIC_RELAXED);
    }
    return failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}

static qn_status unite_some(qni_box_judge *judge, int64_t first, int64_t last) {
    for (int64_t n = first; n < last; ++n) {
        const qni_trouble *trouble = judge->troubles[n];
        qni_cell_box best = {{0, 0, 0}, {0, 0, 0}, false};
        int64_t gain = 0;
        if (is_to_be_tried(judge->stages, trouble))
            QN_TRY(choose(judge, trouble, &best, &gain));
        if (gain > 0)
            QN_TRY(unite(judge->stages, &best));
    }
    return QN_OK;
}

static qn_status try_all(qni_box_judge *judge) {
    qni_stages *stages = judge->stages;
    const int64_t step = (int64_t)AHEAD * stages->threads;
    for (int64_t first = 0; first < judge->count; first += step) {
        const int64_t last = judge->count - first < step ? judge->count : first + step;
        if (qni_progress(stages->context, "cms", 0.85))
            return qni_fail(stages->error, QN_ERROR_CANCELLED, "the surface was cancelled");
        if (stages->threads > 1)
            QN_TRY(look_ahead(judge, first, last));
        if (!qni_box_judge_join(judge))
            return qni_fail_memory(stages->error, "a surface");
        QN_TRY(unite_some(judge, first, last));
    }
    return QN_OK;
}

static qn_status claim_all_reached(const qni_box_judge *judge) {
    for (int64_t n = 0; n < judge->count; ++n)
        if (judge->troubles[n]->reaches && !claim_reached(judge->stages, judge->troubles[n]))
            return qni_fail_memory(judge->stages->error, "a surface");
    return QN_OK;
}

qn_status qni_stages_unite(qni_stages *stages, qni_veto_list *vetoes) {
    qni_box_judge judge;
    qni_stages_mark_none(stages);
    qn_status status =
        qni_box_judge_start(stages, &judge) ? QN_OK : qni_fail_memory(stages->error, "a surface");
    if (status == QN_OK)
        status = claim_all_reached(&judge);
    if (status == QN_OK && vetoes)
        status = find_coarse(&judge, vetoes);
    if (status == QN_OK && !(vetoes && vetoes->added))
        status = try_all(&judge);
    qni_box_judge_end(&judge);
    return status;
}
