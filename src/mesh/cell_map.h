// SPDX-License-Identifier: MIT
/* Sets of lattice cells, a bit each, in leaves of 8^3 cells that are found by hashing: cells near
 * each other lie together. Several threads may add at once; the result does not depend on them. */
#ifndef QNI_MESH_CELL_MAP_H
#define QNI_MESH_CELL_MAP_H

#include "core/context.h"

typedef struct qni_cell {
    int32_t at[3];
} qni_cell;

/* What is known of a cell; the sets that a map holds. */
typedef enum qni_cell_set {
    QNI_CELL_USED,
    QNI_CELL_SHARED,
    QNI_CELL_MARKED,
    QNI_CELL_SETS
} qni_cell_set;

typedef struct qni_cell_leaf {
    uint64_t key; /* of its place; 0: not used */
    uint64_t sets[QNI_CELL_SETS][8];
} qni_cell_leaf;

typedef struct qni_cell_map {
    qn_context *context;
    uint64_t places; /* less one; a power of two */
    qni_cell_leaf *leaves;
    bool alone; /* one thread: nothing is shared */
} qni_cell_map;

/* Room for so many leaves. */
bool qni_cell_map_alloc(qn_context *context, int64_t leaves, qni_cell_map *map);
void qni_cell_map_free(qni_cell_map *map);

static inline uint64_t qni_cell_key(const qni_cell *cell) {
    const uint64_t mask = (1 << 21) - 1; /* farther ones would be taken for others */
    return ((uint64_t)(cell->at[0] >> 3) & mask) | ((uint64_t)(cell->at[1] >> 3) & mask) << 21 |
           ((uint64_t)(cell->at[2] >> 3) & mask) << 42 | UINT64_C(1) << 63;
}

/* Spreads keys of neighbours over the last 32 bits. */
static inline uint64_t qni_cell_hash(uint64_t key) {
    key *= UINT64_C(0x9e3779b97f4a7c15);
    return key ^ key >> 32;
}

/* The leaf of a key, made where there is none; or NULL where there is none. */
qni_cell_leaf *qni_cell_map_claim(const qni_cell_map *map, uint64_t key);
qni_cell_leaf *qni_cell_map_find(const qni_cell_map *map, uint64_t key);

static inline uint64_t qni_cell_bit(const qni_cell *cell, int *word) {
    *word = cell->at[2] & 7;
    return UINT64_C(1) << ((cell->at[0] & 7) + 8 * (cell->at[1] & 7));
}

static inline bool qni_cell_has(const qni_cell_leaf *leaf, qni_cell_set set, const qni_cell *cell) {
    int word;
    const uint64_t bit = qni_cell_bit(cell, &word);
    return leaf->sets[set][word] & bit;
}

/* Whether it was there before. */
static inline bool qni_cell_add(const qni_cell_map *map, qni_cell_leaf *leaf, qni_cell_set set,
                                const qni_cell *cell) {
    int word;
    const uint64_t bit = qni_cell_bit(cell, &word);
    uint64_t *to = leaf->sets[set] + word;
    const uint64_t before = map->alone ? *to : __atomic_fetch_or(to, bit, __ATOMIC_RELAXED);
    if (map->alone)
        *to |= bit;
    return before & bit;
}

#endif
