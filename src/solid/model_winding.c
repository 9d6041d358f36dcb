// SPDX-License-Identifier: MIT
/* Whole winding numbers, and the panels that a segment passes through. */
#include "solid/model.h"

#include <stdlib.h>
#include <string.h>

typedef struct count_job {
    const qni_panel_tree *tree;
    const double *a, *b;
    int axis;
    int64_t sum;
} count_job;

static int across(const qni_panel *panel, const double a[3], const double b[3], int axis) {
    return axis < 0    ? qni_panel_across(panel, a, b)
           : axis == 3 ? 0
                       : qni_panel_across_axis(panel, a, b, axis);
}

static bool count_one(void *user, int32_t panel) {
    count_job *job = user;
    job->sum += across(&job->tree->panels[panel], job->a, job->b, job->axis);
    return true;
}

/* The change of the whole winding number from a to b. */
static int64_t change(const qni_model *model, const double a[3], const double b[3]) {
    count_job job = {.tree = &model->surface, .a = a, .b = b, .axis = qni_segment_axis(a, b)};
    qni_panel_tree_visit_segment(job.tree, a, b, count_one, &job);
    job.tree = &model->caps;
    qni_panel_tree_visit_segment(job.tree, a, b, count_one, &job);
    return job.sum;
}

static void tame(const double p[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = qni_tame(p[k]);
}

static bool in_box(const qni_box *box, const double p[3]) {
    for (int k = 0; k < 3; ++k)
        if (!(p[k] >= box->low[k] && p[k] <= box->high[k]))
            return false;
    return true;
}

/* From p straight to where nothing is any more: along the axis and way that leave the box first. */
int64_t qni_model_winding(const qni_model *model, const double p[3]) {
    if (!in_box(&model->box, p))
        return 0;
    double from[3], to[3], least = QNI_INFINITY;
    int axis = 0;
    tame(p, from);
    memcpy(to, from, sizeof to);
    for (int k = 0; k < 6; ++k) {
        double away = k < 3 ? model->box.high[k] - p[k] : p[k - 3] - model->box.low[k - 3];
        if (away < least) {
            least = away;
            axis = k;
        }
    }
    int k = axis % 3;
    double margin = 1 + model->size;
    to[k] = axis < 3 ? model->box.high[k] + margin : model->box.low[k] - margin;
    return -change(model, from, to);
}

bool qni_meshed_holds(const qni_meshed *solid, const double p[3]) {
    return solid->local && in_box(&solid->within, p);
}

const qni_meshed *qni_meshed_lister(const qni_meshed *solid, const double a[3], const double b[3]) {
    while (solid &&
           !(solid->listed && qni_meshed_holds(solid, a) && (a == b || qni_meshed_holds(solid, b))))
        solid = solid->larger;
    return solid;
}

bool qni_meshed_is_smooth(const qni_meshed *solid, const double p[3]) {
    return qni_meshed_holds(solid, p) ? solid->smooth : solid->model->caps.count > 0;
}

static int64_t near_change(const qni_meshed *solid, const double a[3], const double b[3]) {
    int axis = qni_segment_axis(a, b);
    int64_t sum = 0;
    if (axis == 3)
        return 0;
    int32_t chosen[QNI_MOST_NEAR];
    const int32_t count = qni_near_crossing(&solid->near, a, b, chosen);
    for (int32_t n = 0; n < count; ++n)
        sum += across(qni_meshed_near_panel(solid, chosen[n]), a, b, axis);
    return sum;
}

/* Straight from the place where it was known last, which is near most often. Where another thread
 * is at that, a ray says the same. */
int64_t qni_meshed_winding(const qni_meshed *solid, const double p[3]) {
    const qni_meshed *lister = qni_meshed_lister(solid, p, p);
    if (!lister)
        return qni_model_winding(solid->model, p);
    qni_meshed *memory = (qni_meshed *)(uintptr_t)lister;
    double to[3];
    tame(p, to);
    if (__atomic_exchange_n(&memory->busy, 1, __ATOMIC_ACQUIRE))
        return qni_model_winding(solid->model, p);
    memory->known_winding += near_change(lister, memory->known_at, to);
    memcpy(memory->known_at, to, sizeof to);
    const int64_t winding = memory->known_winding;
    __atomic_store_n(&memory->busy, 0, __ATOMIC_RELEASE);
    return winding;
}

/* ---- hits -------------------------------------------------------------------------------------
 */

typedef struct hit_job {
    const qni_panel_tree *tree;
    const double *a, *b;
    int axis;
    bool cap;
    qni_hits *hits;
} hit_job;

static bool add_hit(qni_hits *hits, const qni_panel *panel, const double a[3], const double b[3],
                    int axis, bool cap) {
    int32_t change_here = across(panel, a, b, axis);
    if (!change_here)
        return true;
    if (hits->count == hits->capacity) {
        bool grown = hits->items != hits->first;
        qni_hit *items = qni_realloc(hits->context, grown ? hits->items : NULL,
                                     grown ? hits->capacity : 0, 4 * hits->capacity, sizeof *items);
        if (!items)
            return false;
        if (!grown)
            memcpy(items, hits->first, sizeof hits->first);
        hits->items = items;
        hits->capacity *= 4;
    }
    hits->items[hits->count++] = (qni_hit){qni_panel_place(panel, a, b), panel, change_here, cap};
    return true;
}

static bool hit_one(void *user, int32_t panel) {
    hit_job *job = user;
    return add_hit(job->hits, &job->tree->panels[panel], job->a, job->b, job->axis, job->cap);
}

static int compare_hits(const void *a, const void *b) {
    const qni_hit *p = a, *q = b;
    if (p->at < q->at || p->at > q->at)
        return p->at < q->at ? -1 : 1;
    if (p->cap != q->cap)
        return p->cap ? 1 : -1;
    return p->panel->number < q->panel->number ? -1 : p->panel->number > q->panel->number;
}

void qni_hits_sort(qni_hits *hits) {
    if (hits->count > 16) {
        qsort(hits->items, (size_t)hits->count, sizeof *hits->items, compare_hits);
        return;
    }
    for (int64_t n = 1; n < hits->count; ++n) {
        qni_hit item = hits->items[n];
        int64_t at = n;
        for (; at > 0 && compare_hits(&item, &hits->items[at - 1]) < 0; --at)
            hits->items[at] = hits->items[at - 1];
        hits->items[at] = item;
    }
}

void qni_hits_free(qni_hits *hits) {
    if (hits->items != hits->first)
        qni_free(hits->context, hits->items, hits->capacity, sizeof *hits->items);
}

static bool near_hits(const qni_meshed *solid, const hit_job *job) {
    int32_t chosen[QNI_MOST_NEAR];
    const int32_t count = qni_near_crossing(&solid->near, job->a, job->b, chosen);
    for (int32_t n = 0; n < count; ++n)
        if (!add_hit(job->hits, qni_meshed_near_panel(solid, chosen[n]), job->a, job->b, job->axis,
                     chosen[n] >= solid->near.surface_count))
            return false;
    return true;
}

bool qni_meshed_hits(const qni_meshed *solid, const double a[3], const double b[3],
                     qni_hits *hits) {
    double from[3], to[3];
    tame(a, from);
    tame(b, to);
    hits->context = solid->base.context;
    hits->items = hits->first;
    hits->count = 0;
    hits->capacity = (int64_t)(sizeof hits->first / sizeof *hits->first);
    hit_job job = {.tree = &solid->model->surface,
                   .a = from,
                   .b = to,
                   .axis = qni_segment_axis(from, to),
                   .hits = hits};
    if (job.axis == 3)
        return true;
    bool good;
    const qni_meshed *lister = qni_meshed_lister(solid, a, b);
    if (lister) {
        good = near_hits(lister, &job);
    } else {
        good = qni_panel_tree_visit_segment(job.tree, from, to, hit_one, &job);
        job.tree = &solid->model->caps;
        job.cap = true;
        good = good && qni_panel_tree_visit_segment(job.tree, from, to, hit_one, &job);
    }
    qni_hits_sort(hits);
    return good;
}
