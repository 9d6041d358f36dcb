// SPDX-License-Identifier: MIT
/* Judging boxes of finest cells. What is found depends on the box alone, not on what is united
 * already: so several threads may look ahead, and what they find is right whenever it is wanted. */
#include "cms/boxes.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

int qni_compare_places(const int32_t a[3], const int32_t b[3]) {
    for (int k = 2; k >= 0; --k)
        if (a[k] != b[k])
            return a[k] < b[k] ? -1 : 1;
    return 0;
}

/* ---- what is remembered
 * -------------------------------------------------------------------------- */

/* What is known of a box: nothing yet. */
static qni_box_gain start_gain(const qni_cell_box *box) {
    qni_box_gain gain = {
        .low = {box->low[0], box->low[1], box->low[2]}, .split = box->split, .used = true};
    for (int k = 0; k < 3; ++k)
        gain.doubled |= (uint8_t)((box->size[k] - 1) << k);
    return gain;
}

static bool is_same(const qni_box_gain *a, const qni_box_gain *b) {
    return memcmp(a->low, b->low, sizeof a->low) == 0 && a->doubled == b->doubled &&
           a->split == b->split;
}

/* Where a box is, or would be put. */
static int64_t place_of(const qni_box_table *table, const qni_box_gain *box) {
    uint64_t hash = box->split;
    for (int k = 0; k < 3; ++k)
        hash = (hash ^ ((uint64_t)(uint32_t)box->low[k] << 1 | (box->doubled >> k & 1))) *
               0x9e3779b97f4a7c15u;
    int64_t at = (int64_t)(hash >> 20) & (table->capacity - 1);
    while (table->items[at].used && !is_same(&table->items[at], box))
        at = (at + 1) & (table->capacity - 1);
    return at;
}

static const qni_box_gain *find(const qni_box_table *table, const qni_box_gain *box) {
    if (table->count == 0)
        return NULL;
    const qni_box_gain *item = &table->items[place_of(table, box)];
    return item->used ? item : NULL;
}

static void put(qni_box_table *table, const qni_box_gain *item) {
    qni_box_gain *place = &table->items[place_of(table, item)];
    table->count += !place->used;
    *place = *item;
}

static bool remember(qn_context *context, qni_box_table *table, const qni_box_gain *item) {
    if (2 * table->count >= table->capacity) {
        qni_box_table larger = {.capacity = table->capacity ? 2 * table->capacity : 64};
        larger.items = qni_alloc_zero(context, larger.capacity, sizeof *larger.items);
        if (!larger.items)
            return false;
        for (int64_t n = 0; n < table->capacity; ++n)
            if (table->items[n].used)
                put(&larger, &table->items[n]);
        qni_free(context, table->items, table->capacity, sizeof *table->items);
        *table = larger;
    }
    put(table, item);
    return true;
}

bool qni_box_judge_join(qni_box_judge *judge) {
    qn_context *context = judge->stages->context;
    for (int32_t thread = 0; thread < judge->stages->threads; ++thread) {
        qni_box_table *fresh = &judge->fresh[thread];
        for (int64_t n = 0; fresh->count && n < fresh->capacity; ++n)
            if (fresh->items[n].used && !remember(context, &judge->known, &fresh->items[n]))
                return false;
        if (fresh->count)
            memset(fresh->items, 0, sizeof *fresh->items * (size_t)fresh->capacity);
        fresh->count = 0;
    }
    return true;
}

/* ---- troubles
 * ------------------------------------------------------------------------------------ */

static int compare_troubles(const void *a, const void *b) {
    return qni_compare_places((*(const qni_trouble *const *)a)->cell,
                              (*(const qni_trouble *const *)b)->cell);
}

static const qni_trouble *find_trouble(const qni_box_judge *judge, const int32_t cell[3]) {
    int64_t from = 0, to = judge->count;
    while (from < to) {
        const int64_t middle = from + (to - from) / 2;
        if (qni_compare_places(judge->troubles[middle]->cell, cell) < 0)
            from = middle + 1;
        else
            to = middle;
    }
    return from < judge->count && qni_compare_places(judge->troubles[from]->cell, cell) == 0
               ? judge->troubles[from]
               : NULL;
}

bool qni_box_judge_start(qni_stages *stages, qni_box_judge *judge) {
    const qni_box_judge empty = {.stages = stages};
    *judge = empty;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        judge->count += stages->chunks[n].trouble_count;
    judge->troubles = qni_alloc(stages->context, judge->count, sizeof *judge->troubles);
    judge->fresh = qni_alloc_zero(stages->context, stages->threads, sizeof *judge->fresh);
    if (!judge->troubles || !judge->fresh)
        return false;
    int64_t count = 0;
    for (int64_t n = 0; n < stages->chunk_count; ++n)
        for (int64_t m = 0; m < stages->chunks[n].trouble_count; ++m)
            judge->troubles[count++] = &stages->chunks[n].troubles[m];
    if (count)
        qsort(judge->troubles, (size_t)count, sizeof *judge->troubles, compare_troubles);
    return true;
}

void qni_box_judge_end(qni_box_judge *judge) {
    qn_context *context = judge->stages->context;
    for (int32_t n = 0; judge->fresh && n < judge->stages->threads; ++n)
        qni_free(context, judge->fresh[n].items, judge->fresh[n].capacity, sizeof(qni_box_gain));
    qni_free(context, judge->fresh, judge->stages->threads, sizeof *judge->fresh);
    qni_free(context, judge->known.items, judge->known.capacity, sizeof(qni_box_gain));
    qni_free(context, (void *)judge->troubles, judge->count, sizeof *judge->troubles);
}

/* ---- judging a box
 * ------------------------------------------------------------------------------- */

static qn_status judge_cell(const qni_box_judge *judge, qni_surroundings *around,
                            const qni_cell *cell, const qni_cell_verdict **verdict_out) {
    const int place = 9 * (cell->low[2] - around->low[2]) + 3 * (cell->low[1] - around->low[1]) +
                      cell->low[0] - around->low[0];
    const qni_cell_verdict none = {0, 0, 0, false};
    qni_cell_verdict *own = &around->verdicts[place];
    *verdict_out = own;
    if (around->known[place])
        return QN_OK;
    *own = none;
    around->known[place] = true;
    const int64_t leaf = qni_octree_find_leaf(judge->stages->octree, cell);
    const qni_trouble *trouble = find_trouble(judge, cell->low);
    qni_patch *patch = &judge->stages->patches[qni_thread_index()];
    bool closed;
    if (leaf < 0)
        return QN_OK;
    QN_TRY(qni_trace_patch(judge->stages, patch, leaf, NULL, &closed));
    own->pieces = patch->piece_count;
    own->loops = patch->loop_count;
    own->bad = trouble ? trouble->bad : 0;
    own->tube = trouble && trouble->tube;
    return QN_OK;
}

static qn_status judge_members(const qni_box_judge *judge, qni_surroundings *around,
                               const qni_cell_box *box, qni_cell_verdict *sum) {
    const qni_cell_verdict none = {0, 0, 0, false};
    qni_cell cell = {{0, 0, 0}, 0};
    *sum = none;
    for (int32_t n = 0; qni_box_member(box, n, &cell); ++n) {
        const qni_cell_verdict *own;
        QN_TRY(judge_cell(judge, around, &cell, &own));
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

/* The box as one: how much better than its cells, which were judged before. Its discs must be as
 * many as the cells' discs make when they are joined at the walls between: Euler's number stays. */
static qn_status judge_whole(const qni_box_judge *judge, const qni_cell_verdict *apart,
                             const qni_cell_box *box, qni_patch *patch, qni_box_gain *out) {
    qni_cms_tally tally = {0};
    bool closed;
    QN_TRY(qni_trace_patch(judge->stages, patch, -1, box, &closed));
    const int64_t inner_segments = (apart->pieces - patch->piece_count) / 2,
                  euler =
                      apart->loops - inner_segments + inner_crossings(judge->stages->hermite, box);
    if (!closed || patch->traced_loops != euler || patch->dropped >= apart->bad)
        return QN_OK;
    patch->most_bad = apart->bad - 1;
    QN_TRY(qni_fill_patch(patch, &tally));
    const int64_t bad = qni_patch_flaws(patch);
    if (bad < apart->bad && qni_box_is_explained(patch, box) &&
        (patch->split || !qni_patch_loops_meet(patch))) {
        out->gain = (int32_t)(apart->bad - bad);
        out->perfect = bad == 0;
    }
    return QN_OK;
}

qn_status qni_judge_box(const qni_box_judge *judge, qni_surroundings *around,
                        const qni_cell_box *box, int64_t least, int64_t *gain, bool *perfect) {
    const int32_t thread = qni_thread_index();
    qni_patch *patch = &judge->stages->patches[thread];
    qni_cell_verdict apart;
    *gain = 0;
    *perfect = false;
    qn_status status = judge_members(judge, around, box, &apart);
    if (status == QN_OK && !apart.tube && apart.bad > least) { /* else never the best */
        qni_box_gain found = start_gain(box);
        const qni_box_gain *known = find(&judge->known, &found);
        known = known ? known : find(&judge->fresh[thread], &found);
        if (known) {
            found = *known;
        } else {
            status = judge_whole(judge, &apart, box, patch, &found);
            if (status == QN_OK && !remember(judge->stages->context, &judge->fresh[thread], &found))
                status = QN_ERROR_OUT_OF_MEMORY;
        }
        *gain = found.gain;
        *perfect = found.perfect;
    }
    return status;
}
