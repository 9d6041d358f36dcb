// SPDX-License-Identifier: MIT
/* Random sparse volumes: blocks are dealt out in a small box, each one a leaf, part of a tile or
 * background. */
#include "lib/random_sparse.h"

#include <math.h>

enum { LEAF_SAMPLES = 512 };

static void store(void *samples, qn_scalar scalar, int64_t at, double value) {
    switch (scalar) {
#define STORE(name, type, text)                                                                    \
    case QN_##name:                                                                                \
        ((type *)samples)[at] = (type)value;                                                       \
        break;
        QN_SCALAR_MAP(STORE)
#undef STORE
    case QN_SCALAR_COUNT:
        break;
    }
}

static double load(const void *samples, qn_scalar scalar, int64_t at) {
    switch (scalar) {
#define LOAD(name, type, text)                                                                     \
    case QN_##name:                                                                                \
        return (double)((const type *)samples)[at];
        QN_SCALAR_MAP(LOAD)
#undef LOAD
    case QN_SCALAR_COUNT:
        break;
    }
    return 0;
}

/* A sample that the type can hold: integers as they are, else 10 times as large, from 40 up. */
static double sample_of(test_random *random, test_kind kind, qn_scalar scalar) {
    const double value = test_random_sample(random, kind);
    if (scalar == QN_F64)
        return value;
    if (scalar == QN_F32)
        return (double)(float)value;
    return 40 + floor(fmax(-39, fmin(60, 10 * value)));
}

typedef struct dealing {
    test_random *random;
    test_sparse *sparse;
    int32_t (*origins)[3];
    qn_sparse_tile *tiles;
    char *values;
    uint64_t (*masks)[8];
    bool *taken;
    int64_t blocks[3];
    test_kind kind;
} dealing;

static bool *taken_at(const dealing *d, const int64_t at[3]) {
    return d->taken + (at[2] * d->blocks[1] + at[1]) * d->blocks[0] + at[0];
}

/* A tile from a free block on, as large as chance wants and the others let it be. */
static void deal_tile(dealing *d, const int64_t at[3]) {
    int64_t size[3] = {1, 1, 1};
    for (int a = 0; a < 3; ++a)
        while (at[a] + size[a] < d->blocks[a] && test_random_range(d->random, 0, 1)) {
            ++size[a];
            bool is_free = true;
            for (int64_t n = 0; n < size[0] * size[1] * size[2]; ++n) {
                const int64_t block[3] = {at[0] + n % size[0], at[1] + n / size[0] % size[1],
                                          at[2] + n / size[0] / size[1]};
                is_free = is_free && !*taken_at(d, block);
            }
            if (!is_free) {
                --size[a];
                break;
            }
        }
    qn_sparse_grid *grid = &d->sparse->grid;
    qn_sparse_tile *tile = d->tiles + grid->tile_count++;
    for (int64_t n = 0; n < size[0] * size[1] * size[2]; ++n) {
        const int64_t block[3] = {at[0] + n % size[0], at[1] + n / size[0] % size[1],
                                  at[2] + n / size[0] / size[1]};
        *taken_at(d, block) = true;
    }
    for (int a = 0; a < 3; ++a) {
        tile->origin[a] = (int32_t)(8 * (at[a] + d->sparse->low[a]));
        tile->size[a] = (int32_t)(8 * size[a]);
    }
    tile->value = sample_of(d->random, d->kind, grid->scalar);
    tile->active = test_random_bits(d->random) & 1;
}

static void deal_leaf(dealing *d, const int64_t at[3]) {
    qn_sparse_grid *grid = &d->sparse->grid;
    const int64_t leaf = grid->leaf_count++;
    *taken_at(d, at) = true;
    for (int a = 0; a < 3; ++a)
        d->origins[leaf][a] = (int32_t)(8 * (at[a] + d->sparse->low[a]));
    for (int64_t n = 0; n < LEAF_SAMPLES; ++n) {
        double value = sample_of(d->random, d->kind, grid->scalar);
        if (d->kind == TEST_CHECKERBOARD)
            value = ((n ^ n >> 3 ^ n >> 6) & 1 ? 1 : -1) +
                    (grid->scalar == QN_F32 || grid->scalar == QN_F64 ? 0 : 40);
        store(d->values, grid->scalar, leaf * LEAF_SAMPLES + n, value);
    }
    for (int w = 0; w < 8; ++w)
        d->masks[leaf][w] = test_random_bits(d->random);
}

static void swap_leaves(dealing *d, int64_t a, int64_t b) {
    const size_t bytes = LEAF_SAMPLES * qn_scalar_size(d->sparse->grid.scalar);
    char *first = d->values + (size_t)a * bytes, *second = d->values + (size_t)b * bytes;
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t origin = d->origins[a][axis];
        d->origins[a][axis] = d->origins[b][axis];
        d->origins[b][axis] = origin;
    }
    for (size_t n = 0; n < bytes; ++n) {
        const char byte = first[n];
        first[n] = second[n];
        second[n] = byte;
    }
}

test_sparse test_random_sparse(test_random *random, test_kind kind, qn_scalar scalar,
                               int64_t largest_blocks) {
    test_sparse sparse;
    memset(&sparse, 0, sizeof sparse);
    dealing d = {.random = random, .sparse = &sparse, .kind = kind};
    int64_t count = 1;
    for (int a = 0; a < 3; ++a) {
        d.blocks[a] = test_random_range(random, 1, largest_blocks);
        sparse.low[a] = test_random_range(random, -5, 3);
        count *= d.blocks[a];
    }
    sparse.grid.scalar = scalar;
    d.origins = test_alloc((size_t)count, sizeof *d.origins);
    d.tiles = test_alloc((size_t)count, sizeof *d.tiles);
    d.values = test_alloc((size_t)count * LEAF_SAMPLES, qn_scalar_size(scalar));
    d.masks = test_alloc((size_t)count, sizeof *d.masks);
    d.taken = test_alloc((size_t)count, sizeof *d.taken);
    memset(d.taken, 0, (size_t)count * sizeof *d.taken);
    const int64_t leaf_share = test_random_range(random, 5, 90);
    for (int64_t n = 0; n < count; ++n) {
        const int64_t at[3] = {n % d.blocks[0], n / d.blocks[0] % d.blocks[1],
                               n / d.blocks[0] / d.blocks[1]};
        const int64_t chance = test_random_range(random, 0, 99);
        if (*taken_at(&d, at))
            continue;
        if (chance < leaf_share)
            deal_leaf(&d, at);
        else if (chance < leaf_share + 30)
            deal_tile(&d, at);
    }
    for (int64_t n = sparse.grid.leaf_count; n > 1; --n)
        swap_leaves(&d, n - 1, test_random_range(random, 0, n - 1));
    sparse.grid.background = sample_of(random, kind, scalar);
    sparse.iso = scalar == QN_F32 || scalar == QN_F64 ? 0 : 40;
    if (kind == TEST_THOUSAND && scalar == QN_F32)
        sparse.iso = 1000;
    if (kind == TEST_BINARY)
        sparse.iso += 0.5;
    sparse.grid.origins = (const int32_t(*)[3])d.origins;
    sparse.grid.values = d.values;
    sparse.grid.masks = test_random_bits(random) & 1 ? (const uint64_t(*)[8])d.masks : NULL;
    if (!sparse.grid.masks)
        free(d.masks);
    sparse.grid.tiles = d.tiles;
    free(d.taken);
    for (int a = 0; a < 3; ++a)
        sparse.high[a] = sparse.low[a] + 1;
    bool first = true; /* the box of what was dealt, not of what might have been */
    for (int64_t n = 0; n < sparse.grid.leaf_count + sparse.grid.tile_count; ++n) {
        const int64_t t = n - sparse.grid.leaf_count;
        for (int a = 0; a < 3; ++a) {
            const int64_t low = (t < 0 ? d.origins[n][a] : d.tiles[t].origin[a]) / 8;
            const int64_t end = low + (t < 0 ? 1 : d.tiles[t].size[a] / 8);
            sparse.low[a] = first || low < sparse.low[a] ? low : sparse.low[a];
            sparse.high[a] = first || end > sparse.high[a] ? end : sparse.high[a];
        }
        first = false;
    }
    return sparse;
}

void test_sparse_free(test_sparse *sparse) {
    free((void *)(uintptr_t)sparse->grid.origins);
    free((void *)(uintptr_t)sparse->grid.values);
    free((void *)(uintptr_t)sparse->grid.masks);
    free((void *)(uintptr_t)sparse->grid.tiles);
}

double test_sparse_value(const test_sparse *sparse, int64_t i, int64_t j, int64_t k) {
    const qn_sparse_grid *grid = &sparse->grid;
    const int64_t at[3] = {i, j, k};
    for (int64_t n = 0; n < grid->leaf_count; ++n) {
        int64_t place = 0;
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            const int64_t within = at[a] - grid->origins[n][a];
            inside = inside && within >= 0 && within < 8;
            place += within * (1 << (3 * a));
        }
        if (inside)
            return load(grid->values, grid->scalar, n * LEAF_SAMPLES + place);
    }
    for (int64_t n = 0; n < grid->tile_count; ++n) {
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            const int64_t within = at[a] - grid->tiles[n].origin[a];
            inside = inside && within >= 0 && within < grid->tiles[n].size[a];
        }
        if (inside)
            return grid->tiles[n].value;
    }
    return grid->background;
}

qn_grid test_sparse_dense(const test_sparse *sparse) {
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.scalar = sparse->grid.scalar;
    int64_t first[3], count = 1;
    for (int a = 0; a < 3; ++a) {
        first[a] = 8 * (sparse->low[a] - 1);
        grid.size[a] = 8 * (sparse->high[a] - sparse->low[a] + 2) + 1;
        count *= grid.size[a];
    }
    void *samples = test_alloc((size_t)count, qn_scalar_size(grid.scalar));
    for (int64_t n = 0; n < count; ++n)
        store(samples, grid.scalar, n,
              test_sparse_value(sparse, first[0] + n % grid.size[0],
                                first[1] + n / grid.size[0] % grid.size[1],
                                first[2] + n / grid.size[0] / grid.size[1]));
    grid.samples = samples;
    memcpy(grid.index_to_world, sparse->grid.index_to_world, sizeof grid.index_to_world);
    for (int r = 0; r < 4; ++r) {
        if (sparse->grid.index_to_world[3][3] == 0)
            grid.index_to_world[r][r] = 1;
        for (int a = 0; r < 3 && a < 3; ++a)
            grid.index_to_world[r][3] += grid.index_to_world[r][a] * (double)first[a];
    }
    return grid;
}
