// SPDX-License-Identifier: MIT
/* Hermite blocks: signs and crossings on the finest lattice, only where the surface is. */
#ifndef QNI_HERMITE_HERMITE_H
#define QNI_HERMITE_HERMITE_H

#include "core/bits_hd.h"
#include "hermite/lattice.h"
#include "hermite/region.h"

enum {
    QNI_BLOCK = 8, /* cells along an edge of a block */
    QNI_BLOCK_CORNERS = 9 * 9 * 9,
    QNI_BLOCK_EDGES =
        3 * 512, /* an edge belongs to the block of its lower end: 512 axis + 64 z + 8 y + x */
    QNI_EDGE_CAPACITY = 16 /* crossings of one finest edge that are kept */
};

/* Where a finest edge meets the surface. */
typedef struct qni_hermite_crossing {
    double at;        /* world coordinate along the edge's axis */
    double normal[3]; /* unit length, out of the solid */
    float
        place[3]; /* as it is written: strictly between the edge's ends, ascending along the edge */
    int32_t owner;
    uint8_t axis;
    bool enters; /* towards larger coordinates one comes into the solid */
} qni_hermite_crossing;

typedef struct qni_hermite_block {
    int32_t place[3];     /* in blocks */
    bool multiple;        /* some edge is crossed more than once */
    bool straddles;       /* some of its cells lie across the bounds */
    uint64_t inside[12];  /* 729 signs: 81 z + 9 y + x */
    uint64_t crossed[24]; /* edges with crossings */
    uint16_t rank[24];    /* crossed edges in lower words */
    int32_t crossing_count, edge_count;
    uint16_t *starts;                /* [edge_count + 1] into crossings */
    qni_hermite_crossing *crossings; /* in the whole's, once that is settled */
    int64_t base;                    /* number of the first crossing in the whole */
} qni_hermite_block;

/* Where a block is found: its place lies here, too, since most look-ups go no further. */
typedef struct qni_block_slot {
    int32_t place[3];
    int32_t number; /* the block's, + 1; 0: free */
} qni_block_slot;

typedef struct qni_hermite {
    qn_context *context;
    const qn_solid *solid;
    qni_lattice lattice;
    qni_hermite_block *blocks; /* ascending z, y, x */
    int64_t block_count, block_capacity;
    qni_block_slot *table;           /* open addressing */
    int64_t table_size;              /* a power of two */
    qni_hermite_crossing *crossings; /* of all blocks, in their order */
    int64_t crossing_count;
    int64_t evaluations, multiple_edges, mended_edges;
} qni_hermite;

/* Crossings of one finest edge. */
typedef struct qni_edge_crossings {
    const qni_hermite_crossing *items;
    int64_t first; /* the number of items[0] in the whole */
    int32_t count;
} qni_edge_crossings;

/* Find, sample and number the blocks. On failure nothing is held. */
qn_status qni_hermite_create(qn_context *context, const qn_solid *solid, const qni_lattice *lattice,
                             qni_hermite *hermite, qn_error *error);
void qni_hermite_destroy(qni_hermite *hermite);
/* Of a whole: they are not asked for any more. */
void qni_hermite_drop_crossings(qni_hermite *hermite);

/* All three turn the upper half of the sum, of which small tables, too, take the lowest bits. */
static inline uint64_t qni_hash_place(int32_t x, int32_t y, int32_t z) {
    const uint64_t sum = (uint64_t)(uint32_t)x * UINT64_C(0x9e3779b97f4a7c15) +
                         (uint64_t)(uint32_t)y * UINT64_C(0xc2b2ae3d27d4eb4f) +
                         (uint64_t)(uint32_t)z * UINT64_C(0x165667b19e3779f9);
    return sum >> 32;
}

/* The index of the block at a place (in blocks), or -1. */
static inline int64_t qni_hermite_find(const qni_hermite *hermite, int32_t x, int32_t y,
                                       int32_t z) {
    if (!hermite->table)
        return -1;
    const uint64_t mask = (uint64_t)hermite->table_size - 1;
    for (uint64_t slot = qni_hash_place(x, y, z) & mask;; slot = (slot + 1) & mask) {
        const qni_block_slot *entry = &hermite->table[slot];
        if (!entry->number)
            return -1;
        if (entry->place[0] == x && entry->place[1] == y && entry->place[2] == z)
            return entry->number - 1;
    }
}

/* The block last looked at: what is asked next lies in it most often. */
typedef struct qni_last_block {
    int32_t place[3];
    const qni_hermite_block *block; /* NULL: none there */
} qni_last_block;
#define QNI_NO_LAST_BLOCK                                                                          \
    { {INT32_MAX, 0, 0}, NULL }

static inline const qni_hermite_block *
qni_hermite_block_at(const qni_hermite *hermite, const int32_t point[3], qni_last_block *last) {
    const int32_t x = point[0] >> 3, y = point[1] >> 3, z = point[2] >> 3;
    if (x != last->place[0] || y != last->place[1] || z != last->place[2]) {
        const int64_t index = qni_hermite_find(hermite, x, y, z);
        const qni_last_block found = {{x, y, z}, index < 0 ? NULL : &hermite->blocks[index]};
        *last = found;
    }
    return last->block;
}

/* The crossings of the finest edge that starts at a lattice point. */
qni_edge_crossings qni_hermite_edge(const qni_hermite *hermite, const int32_t point[3], int axis);
/* Which of up to 8 finest edges of one block are crossed that start at a point and follow each
 * other along an axis: a bit each. */
unsigned qni_hermite_run(const qni_hermite *hermite, const int32_t point[3], int axis,
                         int32_t count, qni_last_block *last);
qni_edge_crossings qni_hermite_edge_near(const qni_hermite *hermite, const int32_t point[3],
                                         int axis, qni_last_block *last);
/* Is any of the twelve edges of a cell crossed, over the finest lattice? A cell of 2^level finest
 * ones, aligned. */
bool qni_hermite_has_crossed_edge(const qni_hermite *hermite, const int32_t low[3], int32_t level);
/* The sign at a lattice point: inside, outside, or -1 where no block is. */
int qni_hermite_sign(const qni_hermite *hermite, const int32_t point[3]);
/* f at the corners (x + 2 y + 4 z) of a finest cell, which tell all of a trilinear f; false on
 * lattices of other solids. */
bool qni_hermite_cell_values(const qni_hermite *hermite, const int32_t cell[3], double corner[8]);

/* ---- between the files of this folder -----------------------------------------------------------
 */

typedef struct qni_sampling {
    qni_hermite *hermite;
    qni_region *region; /* of this thread */
    int64_t evaluations, multiple_edges, mended_edges;
} qni_sampling;

/* Sample one block: signs, then crossings of its edges (edges.c). */
qn_status qni_sample_block(qni_sampling *sampling, qni_hermite_block *block);
/* Places of blocks that may hold surface, by the solid's bounds (discover.c). */
qn_status qni_discover(qni_hermite *hermite, qn_error *error);
/* Enter a block that is not there yet; false when memory ran out. */
bool qni_hermite_enter(qni_hermite *hermite, const int32_t place[3]);

static inline void qni_crossing_position(const qni_hermite_crossing *crossing, double position[3]) {
    for (int k = 0; k < 3; ++k)
        position[k] = (double)crossing->place[k];
    position[crossing->axis] = crossing->at;
}

static inline bool qni_bit(const uint64_t *words, int index) {
    return words[index >> 6] >> (index & 63) & 1;
}

#endif
