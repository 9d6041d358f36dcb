// SPDX-License-Identifier: MIT
/* Where a field has its surface and what values it takes where: leaves found by their signs, and a
 * tree of ranges over them, so that boxes are answered for without looking at samples. */
#include "solid/sampled.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "volume/field.h"

#include <stdlib.h>
#include <string.h>

/* Beyond this many leaves only those with surface are kept: others would cost too much memory. */
static const int64_t most_leaves = INT64_C(1) << 21;

/* ---- finding leaves -------------------------------------------------------------------------- */

/* The leaves of one band; filled by one thread. */
typedef struct leaf_list {
    qni_leaf_node *items;
    int64_t count, capacity;
    bool met_nonfinite, failed;
} leaf_list;

static uint64_t spread(uint64_t v) {
    v &= 0x1fffff;
    v = (v | v << 32) & UINT64_C(0x1f00000000ffff);
    v = (v | v << 16) & UINT64_C(0x1f0000ff0000ff);
    v = (v | v << 8) & UINT64_C(0x100f00f00f00f00f);
    v = (v | v << 4) & UINT64_C(0x10c30c30c30c30c3);
    return (v | v << 2) & UINT64_C(0x1249249249249249);
}

static int32_t gather(uint64_t v) {
    v &= UINT64_C(0x1249249249249249);
    v = (v | v >> 2) & UINT64_C(0x10c30c30c30c30c3);
    v = (v | v >> 4) & UINT64_C(0x100f00f00f00f00f);
    v = (v | v >> 8) & UINT64_C(0x1f0000ff0000ff);
    v = (v | v >> 16) & UINT64_C(0x1f00000000ffff);
    return (int32_t)((v | v >> 32) & 0x1fffff);
}

static uint64_t key_of(const int32_t leaf[3]) {
    return spread((uint64_t)leaf[0]) | spread((uint64_t)leaf[1]) << 1 |
           spread((uint64_t)leaf[2]) << 2;
}

static void place_of(uint64_t key, int32_t leaf[3]) {
    for (int k = 0; k < 3; ++k)
        leaf[k] = gather(key >> k);
}

/* The range of f over the leaf's samples; those beyond the field's end do not count. */
static void measure_leaf(const qni_field *field, qni_leaf_node *node) {
    double tile[QNI_TILE][QNI_TILE][QNI_TILE];
    int32_t leaf[3], end[3];
    place_of(node->key, leaf);
    qni_field_load_tile(field, leaf, tile);
    for (int k = 0; k < 3; ++k) {
        const int64_t left = field->samples[k] - (int64_t)leaf[k] * QNI_LEAF;
        end[k] = left < QNI_LEAF_SAMPLES ? (int32_t)left : QNI_LEAF_SAMPLES;
    }
    double low = qni_sampled_sign(field->inside_below, tile[1][1][1]), high = low;
    for (int z = 1; z <= end[2]; ++z)
        for (int y = 1; y <= end[1]; ++y)
            for (int x = 1; x <= end[0]; ++x) {
                const double value = qni_sampled_sign(field->inside_below, tile[z][y][x]);
                low = value < low ? value : low;
                high = value > high ? value : high;
            }
    node->range[0] = low;
    node->range[1] = high;
}

static bool push(qn_context *context, leaf_list *list, const qni_leaf_node *node) {
    if (list->count == list->capacity) {
        const int64_t capacity = list->capacity ? 2 * list->capacity : 64;
        qni_leaf_node *items =
            qni_realloc(context, list->items, list->capacity, capacity, sizeof *items);
        if (!items)
            return false;
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = *node;
    return true;
}

static void list_band(qn_context *context, const qni_field *field, int64_t band, bool every_leaf,
                      qni_scan *scan, leaf_list *list) {
    const int64_t first = qni_field_band_row(field, band);
    qni_field_scan_band(field, band, scan);
    list->met_nonfinite = scan->met_nonfinite;
    if (list->met_nonfinite)
        return;
    for (int32_t row = 0; row < scan->rows; ++row)
        for (int64_t x = 0; x < field->leaves[0]; ++x) {
            const bool mixed = qni_scan_is_mixed(scan, row, x);
            if (!mixed && !every_leaf)
                continue;
            int32_t leaf[3] = {(int32_t)x, 0, 0};
            qni_field_row_leaf(field, first + row, leaf + 1);
            qni_leaf_node node = {key_of(leaf), mixed, 1, {0, 0}};
            measure_leaf(field, &node);
            if (!mixed && !(node.range[0] < node.range[1]))
                continue;
            if (!push(context, list, &node)) {
                list->failed = true;
                return;
            }
        }
}

static qn_status create_scans(qn_context *context, const qni_field *field, int32_t threads,
                              qni_scan *scans, qn_error *error) {
    for (int32_t n = 0; n < threads; ++n) {
        const qn_status status = qni_scan_create(context, field, &scans[n], error);
        if (status == QN_OK)
            continue;
        while (n-- > 0)
            qni_scan_destroy(context, field, &scans[n]);
        return status;
    }
    return QN_OK;
}

static qn_status keep_list(qn_context *context, leaf_list *list, leaf_list *whole,
                           qn_error *error) {
    bool good = !list->failed;
    whole->met_nonfinite = whole->met_nonfinite || list->met_nonfinite;
    for (int64_t n = 0; n < list->count && good; ++n)
        good = push(context, whole, &list->items[n]);
    qni_free(context, list->items, list->capacity, sizeof *list->items);
    return good ? QN_OK : qni_fail_memory(error, "the leaves of a volume");
}

static qn_status list_bands(qn_context *context, const qni_field *field, bool every_leaf,
                            qni_scan *scans, leaf_list *whole, qn_error *error) {
    enum { ROUND = 64 };
    const int32_t threads = qn_context_threads(context);
    const int64_t bands = qni_field_band_count(field);
    for (int64_t first = 0; first < bands; first += ROUND) {
        if (qni_progress(context, "classify", (double)first / (double)bands))
            return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
        leaf_list lists[ROUND];
        memset(lists, 0, sizeof lists);
        const int64_t count = bands - first < ROUND ? bands - first : ROUND;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
        for (int64_t n = 0; n < count; ++n)
            list_band(context, field, first + n, every_leaf, &scans[qni_thread_index()], &lists[n]);
        qn_status status = QN_OK;
        for (int64_t n = 0; n < count; ++n) {
            const qn_status kept = keep_list(context, &lists[n], whole, error);
            status = status == QN_OK ? kept : status;
        }
        QN_TRY(status);
        if (whole->met_nonfinite)
            return QN_OK;
    }
    return QN_OK;
}

/* All leaves that are wanted; once more when samples that are not finite were met, for their
 * distance is known only then. */
static qn_status list_leaves(qn_context *context, qni_field *field, bool every_leaf,
                             leaf_list *whole, qn_error *error) {
    const int32_t threads = qn_context_threads(context);
    if (!field->direct)
        qni_field_measure_nonfinite(context, field);
    qni_scan *scans = qni_alloc_zero(context, threads, sizeof *scans);
    qn_status status = scans ? create_scans(context, field, threads, scans, error)
                             : qni_fail_memory(error, "the leaves of a volume");
    const bool created = status == QN_OK;
    for (int round = 0; round < 2 && status == QN_OK; ++round) {
        status = list_bands(context, field, every_leaf, scans, whole, error);
        if (status != QN_OK || !whole->met_nonfinite)
            break;
        whole->met_nonfinite = false;
        whole->count = 0;
        qni_field_measure_nonfinite(context, field);
    }
    for (int32_t n = 0; created && n < threads; ++n)
        qni_scan_destroy(context, field, &scans[n]);
    qni_free(context, scans, threads, sizeof *scans);
    return status;
}

/* ---- the tree -------------------------------------------------------------------------------- */

static int compare_nodes(const void *a, const void *b) {
    const uint64_t p = ((const qni_leaf_node *)a)->key, q = ((const qni_leaf_node *)b)->key;
    return p < q ? -1 : p > q;
}

static bool add_level(qn_context *context, qni_leaf_tree *tree) {
    const int32_t level = tree->levels;
    const qni_leaf_node *below = tree->nodes[level - 1];
    const int64_t count = tree->counts[level - 1];
    int64_t groups = 0;
    for (int64_t n = 0; n < count; ++n)
        groups += n == 0 || below[n].key >> 3 != below[n - 1].key >> 3;
    qni_leaf_node *nodes = qni_alloc(context, groups, sizeof *nodes);
    if (!nodes)
        return false;
    int64_t at = -1;
    for (int64_t n = 0; n < count; ++n) {
        if (n == 0 || below[n].key >> 3 != below[n - 1].key >> 3) {
            nodes[++at] = below[n];
            nodes[at].key = below[n].key >> 3;
            nodes[at].first = n;
            continue;
        }
        nodes[at].leaves += below[n].leaves;
        nodes[at].range[0] =
            below[n].range[0] < nodes[at].range[0] ? below[n].range[0] : nodes[at].range[0];
        nodes[at].range[1] =
            below[n].range[1] > nodes[at].range[1] ? below[n].range[1] : nodes[at].range[1];
    }
    tree->nodes[level] = nodes;
    tree->counts[level] = groups;
    ++tree->levels;
    return true;
}

static bool keep_mixed(qn_context *context, const leaf_list *list, qni_leaf_tree *tree) {
    for (int64_t n = 0; n < list->count; ++n)
        tree->mixed_count += list->items[n].first;
    tree->mixed_capacity = tree->mixed_count;
    tree->mixed = qni_alloc(context, tree->mixed_capacity, sizeof *tree->mixed);
    if (!tree->mixed)
        return false;
    int64_t at = 0;
    for (int64_t n = 0; n < list->count; ++n)
        if (list->items[n].first)
            place_of(list->items[n].key, tree->mixed[at++]);
    return true;
}

qn_status qni_leaf_tree_build(qn_context *context, struct qni_field *field, bool every_leaf,
                              qni_leaf_tree *tree, qn_error *error) {
    memset(tree, 0, sizeof *tree);
    const double all =
        (double)field->leaves[0] * (double)field->leaves[1] * (double)field->leaves[2];
    tree->complete = every_leaf && all <= (double)most_leaves;
    leaf_list list = {NULL, 0, 0, false, false};
    qn_status status = list_leaves(context, field, tree->complete, &list, error);
    if (status == QN_OK && list.count > 0)
        qsort(list.items, (size_t)list.count, sizeof *list.items, compare_nodes);
    bool good = status != QN_OK || keep_mixed(context, &list, tree);
    if (status == QN_OK && good) {
        tree->nodes[0] =
            qni_realloc(context, list.items, list.capacity, list.count, sizeof *list.items);
        good = tree->nodes[0] != NULL;
    }
    if (!good || status != QN_OK) {
        qni_free(context, list.items, list.capacity, sizeof *list.items);
    } else {
        tree->counts[0] = list.count;
        tree->levels = 1;
        while (good && tree->counts[tree->levels - 1] > 1)
            good = add_level(context, tree);
    }
    if (!good && status == QN_OK)
        status = qni_fail_memory(error, "the leaves of a volume");
    if (status != QN_OK)
        qni_leaf_tree_free(context, tree);
    return status;
}

void qni_leaf_tree_free(qn_context *context, qni_leaf_tree *tree) {
    for (int32_t level = 0; level < tree->levels; ++level)
        qni_free(context, tree->nodes[level], tree->counts[level], sizeof *tree->nodes[level]);
    qni_free(context, tree->mixed, tree->mixed_capacity, sizeof *tree->mixed);
    memset(tree, 0, sizeof *tree);
}

/* ---- asking ---------------------------------------------------------------------------------- */

typedef struct leaf_query {
    const qni_leaf_tree *tree;
    const int32_t *low, *high;
    double range[2];
    int64_t leaves;
} leaf_query;

static void descend(leaf_query *query, int32_t level, int64_t index) {
    const qni_leaf_node *node = &query->tree->nodes[level][index];
    int32_t place[3];
    bool within = true;
    place_of(node->key, place);
    for (int k = 0; k < 3; ++k) {
        const int64_t first = (int64_t)place[k] << level, last = first + (INT64_C(1) << level) - 1;
        if (last < query->low[k] || first > query->high[k])
            return;
        within = within && first >= query->low[k] && last <= query->high[k];
    }
    if (within || level == 0) {
        query->leaves += node->leaves;
        query->range[0] = node->range[0] < query->range[0] ? node->range[0] : query->range[0];
        query->range[1] = node->range[1] > query->range[1] ? node->range[1] : query->range[1];
        return;
    }
    const int64_t end = index + 1 < query->tree->counts[level]
                            ? query->tree->nodes[level][index + 1].first
                            : query->tree->counts[level - 1];
    for (int64_t child = node->first; child < end; ++child)
        descend(query, level - 1, child);
}

bool qni_leaf_tree_range(const qni_leaf_tree *tree, const int32_t low[3], const int32_t high[3],
                         double range[2]) {
    static const double beyond = 1e300; /* nothing known, yet not nothing: surfaces may be there */
    leaf_query query = {tree, low, high, {beyond, -beyond}, 0};
    if (tree->levels > 0 && tree->counts[0] > 0)
        descend(&query, tree->levels - 1, 0);
    if (query.leaves == 0)
        return false;
    const double all =
        (high[0] - low[0] + 1.0) * (high[1] - low[1] + 1.0) * (high[2] - low[2] + 1.0);
    const bool known = tree->complete || (double)query.leaves >= all;
    range[0] = known ? query.range[0] : -beyond;
    range[1] = known ? query.range[1] : beyond;
    return true;
}
