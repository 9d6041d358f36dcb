// SPDX-License-Identifier: MIT
/* Lattice places of vertices, and hashed tables of bits: what falls together in one makes the
 * search for crossings wider, never narrower. */
#ifndef QNI_MESH_UNTANGLE_TABLE_H
#define QNI_MESH_UNTANGLE_TABLE_H

#include "core/context.h"

#include <math.h>

/* A vertex in lattice coordinates; what is not a place on any lattice is put at 0. */
static inline void qni_local_place(const double to_lattice[3][4], const float *position,
                                   double local[3]) {
    for (int a = 0; a < 3; ++a) {
        const double *row = to_lattice[a];
        const double at = (row[0] * (double)position[0] + row[1] * (double)position[1]) +
                          (row[2] * (double)position[2] + row[3]);
        local[a] = fabs(at) < 0x1p29 ? at : 0;
    }
}

/* Rounds such a coordinate down, or one that was divided. */
static inline int32_t qni_local_floor(double local) {
    return (int32_t)((int64_t)(local + 0x1p30) - (INT64_C(1) << 30));
}

static inline uint64_t qni_mix_place(const int64_t at[3]) {
    uint64_t h = (uint64_t)at[0] * UINT64_C(0x9e3779b97f4a7c15) ^
                 (uint64_t)at[1] * UINT64_C(0xc2b2ae3d27d4eb4f) ^
                 (uint64_t)at[2] * UINT64_C(0x165667b19e3779f9);
    h = (h ^ h >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return h ^ h >> 32;
}

/* A power of two of bits, with one bit for each key at random or by place. */
typedef struct qni_bit_table {
    uint64_t mask; /* of bit numbers */
    uint64_t *words;
} qni_bit_table;

static inline bool qni_table_alloc(qn_context *context, int64_t wanted, qni_bit_table *table) {
    int64_t bits = 1 << 16;
    while (bits < wanted && bits < INT64_C(1) << 40)
        bits *= 2;
    table->mask = (uint64_t)bits - 1;
    table->words = qni_alloc_zero(context, bits / 64, sizeof *table->words);
    return table->words != NULL;
}

static inline void qni_table_free(qn_context *context, qni_bit_table *table) {
    if (table->words)
        qni_free(context, table->words, (int64_t)(table->mask + 1) / 64, sizeof *table->words);
}

static inline bool qni_table_has(const qni_bit_table *table, uint64_t key) {
    key &= table->mask;
    return table->words[key / 64] >> (key % 64) & 1;
}

/* Whether it was there before. */
static inline bool qni_table_put(qni_bit_table *table, uint64_t key) {
    key &= table->mask;
    const uint64_t bit = UINT64_C(1) << (key % 64);
    return __atomic_fetch_or(&table->words[key / 64], bit, __ATOMIC_RELAXED) & bit;
}

#endif
