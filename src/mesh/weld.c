// SPDX-License-Identifier: MIT
/* Joining vertices at exactly the same place: open addressing, at most half full. */
#include "mesh/weld.h"
#include "core/context.h"

#include <string.h>

typedef struct place {
    uint32_t bits[3];
} place;

static place place_of(const float position[3]) {
    place p;
    memcpy(p.bits, position, sizeof p.bits);
    for (int a = 0; a < 3; ++a)
        if (p.bits[a] == 0x80000000u)
            p.bits[a] = 0;
    return p;
}

static uint64_t hash_of(place p) {
    uint64_t hash = p.bits[0];
    hash = (hash ^ (hash >> 29)) * UINT64_C(0xbf58476d1ce4e5b9) + p.bits[1];
    hash = (hash ^ (hash >> 32)) * UINT64_C(0x94d049bb133111eb) + p.bits[2];
    hash = (hash ^ (hash >> 29)) * UINT64_C(0xbf58476d1ce4e5b9);
    return hash ^ (hash >> 32);
}

/* The slot that holds this place, or the free one where it belongs. */
static uint32_t *find(const qni_weld *weld, place p) {
    const float *positions = weld->builder->positions.items;
    uint64_t mask = (uint64_t)weld->slot_count - 1;
    for (uint64_t at = hash_of(p) & mask;; at = (at + 1) & mask) {
        uint32_t *slot = weld->slots + at;
        if (*slot == 0)
            return slot;
        place other = place_of(positions + 3 * ((size_t)*slot - 1));
        if (memcmp(&other, &p, sizeof p) == 0)
            return slot;
    }
}

static bool grow(qni_weld *weld) {
    qni_weld larger = {weld->builder, NULL, weld->slot_count ? 2 * weld->slot_count : 1024};
    larger.slots = qni_alloc_zero(weld->builder->context, larger.slot_count, sizeof *larger.slots);
    if (!larger.slots)
        return false;
    const float *positions = weld->builder->positions.items;
    for (int64_t i = 0; i < weld->builder->positions.count; ++i)
        *find(&larger, place_of(positions + 3 * i)) = (uint32_t)i + 1;
    qni_weld_free(weld);
    *weld = larger;
    return true;
}

bool qni_weld_vertex(qni_weld *weld, const float position[3], uint32_t *vertex_out) {
    int64_t count = weld->builder->positions.count;
    if (2 * count >= weld->slot_count && !grow(weld))
        return false;
    uint32_t *slot = find(weld, place_of(position));
    if (*slot == 0) {
        if (count >= (int64_t)UINT32_MAX - 1 ||
            !qni_builder_add_vertex(weld->builder, position, NULL))
            return false;
        *slot = (uint32_t)count + 1;
    }
    *vertex_out = *slot - 1;
    return true;
}

void qni_weld_free(qni_weld *weld) {
    qni_free(weld->builder->context, weld->slots, weld->slot_count, sizeof *weld->slots);
    weld->slots = NULL;
    weld->slot_count = 0;
}
