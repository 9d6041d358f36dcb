// SPDX-License-Identifier: MIT
/* Open addressing of leaves of cells (cell_map.h). */
#include "mesh/cell_map.h"

bool qni_cell_map_alloc(qn_context *context, int64_t leaves, qni_cell_map *map) {
    int64_t places = 256;
    while (places < 2 * leaves)
        places *= 2;
    map->context = context;
    map->places = (uint64_t)places - 1;
    map->leaves = qni_alloc_zero(context, places, sizeof *map->leaves);
    map->alone = qn_context_threads(context) == 1;
    return map->leaves != NULL;
}

void qni_cell_map_free(qni_cell_map *map) {
    if (map->leaves)
        qni_free(map->context, map->leaves, (int64_t)map->places + 1, sizeof *map->leaves);
    map->leaves = NULL;
}

static uint64_t place_of(const qni_cell_map *map, uint64_t key) {
    return qni_cell_hash(key) & map->places;
}

qni_cell_leaf *qni_cell_map_claim(const qni_cell_map *map, uint64_t key) {
    for (uint64_t place = place_of(map, key);; place = (place + 1) & map->places) {
        uint64_t there = 0;
        qni_cell_leaf *leaf = map->leaves + place;
        if (__atomic_load_n(&leaf->key, __ATOMIC_RELAXED) == key ||
            __atomic_compare_exchange_n(&leaf->key, &there, key, false, __ATOMIC_RELAXED,
                                        __ATOMIC_RELAXED) ||
            there == key)
            return leaf;
    }
}

qni_cell_leaf *qni_cell_map_find(const qni_cell_map *map, uint64_t key) {
    for (uint64_t place = place_of(map, key);; place = (place + 1) & map->places) {
        qni_cell_leaf *leaf = map->leaves + place;
        if (leaf->key == key)
            return leaf;
        if (leaf->key == 0)
            return NULL;
    }
}
