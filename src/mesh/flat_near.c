// SPDX-License-Identifier: MIT
/* What lies near the triangles that are new: only there can anything be met. The mesh's box is cut
 * in cells, a bit each: set where the box of a new triangle comes. */
#include "mesh/flat_parts.h"
#include "core/context.h"

#include <math.h>
#include <string.h>

enum { SIDE = 128 };

typedef struct bit_grid {
    double low[3], scale; /* cells to a unit of length */
    uint64_t *bits;
} bit_grid;

typedef struct cell_range {
    int32_t from[3], to[3];
} cell_range;

static bool is_there(const qni_flat *flat, int64_t t) {
    return flat->corners[3 * t] != QN_NO_HALFEDGE;
}

static void lay(const qni_flat *flat, bit_grid *grid) {
    const float *places = flat->mesh->positions;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double side = 0;
    for (int64_t v = 0; v < flat->vertices; ++v)
        for (int k = 0; k < 3; ++k) {
            const float at = places[3 * v + k];
            low[k] = at < low[k] ? at : low[k];
            high[k] = at > high[k] ? at : high[k];
        }
    for (int k = 0; k < 3; ++k) {
        grid->low[k] = (double)low[k];
        side = fmax(side, (double)high[k] - (double)low[k]);
    }
    grid->scale = side > 0 ? SIDE / side : 0;
}

/* Rounded alike for all, so that what meets has a cell in common. */
static int32_t cell_of(const bit_grid *grid, float at, int k) {
    const double cell = ((double)at - grid->low[k]) * grid->scale;
    return cell > 0 ? cell < SIDE ? (int32_t)cell : SIDE - 1 : 0;
}

static cell_range range_of(const qni_flat *flat, const bit_grid *grid, int64_t t) {
    cell_range range;
    for (int k = 0; k < 3; ++k) {
        float low = INFINITY, high = -INFINITY;
        for (int n = 0; n < 3; ++n) {
            const float at = qni_flat_place(flat, flat->corners[3 * t + n])[k];
            low = at < low ? at : low;
            high = at > high ? at : high;
        }
        range.from[k] = cell_of(grid, low, k);
        range.to[k] = cell_of(grid, high, k);
    }
    return range;
}

/* The bits of a range that lie in one of a row's words. */
static uint64_t bits_in(const cell_range *range, int32_t word) {
    const int32_t from = range->from[0] - 64 * word, to = range->to[0] - 64 * word;
    if (from > 63 || to < 0)
        return 0;
    const uint64_t above = from > 0 ? UINT64_MAX << from : UINT64_MAX;
    return to < 63 ? above & ((UINT64_C(2) << to) - 1) : above;
}

/* Set a range's bits, or ask for any that is set. */
static bool visit(const bit_grid *grid, const cell_range *range, bool set) {
    for (int32_t z = range->from[2]; z <= range->to[2]; ++z)
        for (int32_t y = range->from[1]; y <= range->to[1]; ++y)
            for (int32_t word = 0; word < SIDE / 64; ++word) {
                uint64_t *bits = &grid->bits[(SIDE * z + y) * (SIDE / 64) + word];
                const uint64_t own = bits_in(range, word);
                if (set)
                    *bits |= own;
                else if (*bits & own)
                    return true;
            }
    return false;
}

static int64_t list(const qni_flat *flat, const bit_grid *grid, const uint32_t *numbers,
                    uint32_t *near) {
    int64_t count = 0;
    for (int64_t t = 0; t < flat->triangles; ++t) {
        if (!is_there(flat, t))
            continue;
        const cell_range range = range_of(flat, grid, t);
        if (!flat->changed[t] && !visit(grid, &range, false))
            continue;
        for (int k = 0; near && k < 3; ++k)
            near[3 * count + k] = numbers[flat->corners[3 * t + k]];
        ++count;
    }
    return count;
}

bool qni_flat_near_changed(const qni_flat *flat, const uint32_t *numbers, uint32_t **near_out,
                           int64_t *count_out) {
    const int64_t words = SIDE * SIDE * (SIDE / 64);
    bit_grid grid;
    grid.bits = qni_alloc_zero(flat->context, words, sizeof *grid.bits);
    if (!grid.bits)
        return false;
    lay(flat, &grid);
    for (int64_t t = 0; t < flat->triangles; ++t)
        if (flat->changed[t] && is_there(flat, t)) {
            const cell_range range = range_of(flat, &grid, t);
            visit(&grid, &range, true);
        }
    *count_out = list(flat, &grid, numbers, NULL);
    *near_out = qni_alloc(flat->context, *count_out, 3 * sizeof **near_out);
    if (*near_out)
        list(flat, &grid, numbers, *near_out);
    qni_free(flat->context, grid.bits, words, sizeof *grid.bits);
    return *near_out != NULL;
}
