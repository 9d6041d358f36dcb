// SPDX-License-Identifier: MIT
/* Dividing panels among the boxes of a tree: halves by the middle panel along the longest side. */
#include "solid/panel.h"

#include <string.h>

enum { LEAF = 4 };

/* What a panel is to the tree that is made: its box, its number, and its place so far. */
typedef struct seed {
    float low[3], high[3];
    int32_t number, panel;
} seed;

static void plant(const qni_panel_tree *tree, seed *seeds) {
    for (int32_t n = 0; n < tree->count; ++n) {
        const qni_panel *panel = &tree->panels[n];
        for (int k = 0; k < 3; ++k) {
            const float x = panel->at[0][k], y = panel->at[1][k], z = panel->at[2][k];
            seeds[n].low[k] = qni_least_of(x, y, z);
            seeds[n].high[k] = qni_most_of(x, y, z);
        }
        seeds[n].number = panel->number;
        seeds[n].panel = n;
    }
}

static bool before(const seed *a, const seed *b, int axis) {
    const float x = a->low[axis] * 0.5f + a->high[axis] * 0.5f,
                y = b->low[axis] * 0.5f + b->high[axis] * 0.5f;
    return x < y || (!(y < x) && a->number < b->number);
}

/* Hoare's selection: the seeds before `place` come before the one at it. No two compare equal. */
static void split_at(seed *seeds, int64_t first, int64_t last, int64_t place, int axis) {
    while (first < last) {
        const seed pivot = seeds[first + (last - first) / 2];
        int64_t i = first, j = last;
        while (i <= j) {
            while (before(&seeds[i], &pivot, axis))
                ++i;
            while (before(&pivot, &seeds[j], axis))
                --j;
            if (i > j)
                break;
            const seed swap = seeds[i];
            seeds[i++] = seeds[j];
            seeds[j--] = swap;
        }
        if (place <= j)
            last = j;
        else if (place >= i)
            first = i;
        else
            return;
    }
}

/* The axis along which they reach farthest. */
static int longest_axis(const seed *seeds, int32_t count) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int32_t n = 0; n < count; ++n)
        for (int k = 0; k < 3; ++k) {
            low[k] = seeds[n].low[k] < low[k] ? seeds[n].low[k] : low[k];
            high[k] = seeds[n].high[k] > high[k] ? seeds[n].high[k] : high[k];
        }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (high[k] - low[k] > high[axis] - low[axis])
            axis = k;
    return axis;
}

static int32_t build(qni_panel_tree *tree, seed *seeds, int32_t first, int32_t count) {
    const int32_t index = tree->node_count++;
    qni_panel_node *node = &tree->nodes[index];
    node->first = first;
    node->count = count;
    node->second = 0;
    if (count <= LEAF)
        return index;
    const int32_t half = count / 2;
    split_at(seeds, first, first + (int64_t)count - 1, first + half,
             longest_axis(seeds + first, count));
    build(tree, seeds, first, half);
    node->second = build(tree, seeds, first + half, count - half);
    return index;
}

/* Panels in the order of their seeds, round by round of those that change places. */
static void set_order(qni_panel_tree *tree, seed *seeds) {
    for (int32_t n = 0; n < tree->count; ++n) {
        if (seeds[n].panel == n)
            continue;
        const qni_panel first = tree->panels[n];
        int32_t to = n;
        for (int32_t from = seeds[n].panel; from != n; from = seeds[to].panel) {
            tree->panels[to] = tree->panels[from];
            seeds[to].panel = to;
            to = from;
        }
        tree->panels[to] = first;
        seeds[to].panel = to;
    }
}

static void measure_leaf(const qni_panel_tree *tree, qni_panel_node *node) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int32_t n = node->first; n < node->first + node->count; ++n)
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) {
                const float at = tree->panels[n].at[i][k];
                low[k] = at < low[k] ? at : low[k];
                high[k] = at > high[k] ? at : high[k];
            }
    memcpy(node->low, low, sizeof low);
    memcpy(node->high, high, sizeof high);
}

/* Children come after their parents. */
static void measure(qni_panel_tree *tree) {
    for (int32_t n = tree->node_count - 1; n >= 0; --n) {
        qni_panel_node *node = &tree->nodes[n];
        if (!node->second) {
            measure_leaf(tree, node);
            continue;
        }
        const qni_panel_node *a = node + 1, *b = &tree->nodes[node->second];
        for (int k = 0; k < 3; ++k) {
            node->low[k] = a->low[k] < b->low[k] ? a->low[k] : b->low[k];
            node->high[k] = a->high[k] > b->high[k] ? a->high[k] : b->high[k];
        }
    }
}

bool qni_panel_tree_divide(qn_context *context, qni_panel_tree *tree) {
    seed *seeds = qni_alloc(context, tree->count, sizeof *seeds);
    if (!seeds)
        return false;
    plant(tree, seeds);
    tree->node_count = 0;
    build(tree, seeds, 0, tree->count);
    set_order(tree, seeds);
    measure(tree);
    qni_free(context, seeds, tree->count, sizeof *seeds);
    return true;
}
