// SPDX-License-Identifier: MIT
/* The adaptive octree over Hermite blocks; leaves of any level side by side. */
#ifndef QNI_OCTREE_OCTREE_H
#define QNI_OCTREE_OCTREE_H

#include "hermite/hermite.h"

/* A cube of 2^level finest cells, aligned. */
typedef struct qni_cell {
    int32_t low[3]; /* in finest cells */
    int32_t level;
} qni_cell;

/* May this cell be a leaf? Asked from several threads at once, for cells that no leaf holds,
 * largest first; must be a pure function of the cell. */
typedef bool qni_cell_question(void *user, const qni_cell *cell);

typedef struct qni_octree {
    const qni_hermite *hermite;
    uint8_t (
        *levels)[512]; /* of the leaf that holds each finest cell of each block: 64 z + 8 y + x */
    qni_cell *leaves;  /* leaves with a crossed edge: of level 3 and less by blocks, then the larger
                          ones */
    int64_t leaf_count, small_count;
    uint64_t (*starts)[8]; /* for each block: finest cells where a leaf of level 3 or less begins */
    uint16_t (*ranks)[8];  /* for each block: how many of them are in the layers below */
    uint32_t *bases;       /* for each block: number of its first leaf */
} qni_octree;

/* question NULL: uniform, finest cells only. On failure nothing is held. */
qn_status qni_octree_create(const qni_hermite *hermite, qni_cell_question *question, void *user,
                            qni_octree *octree, qn_error *error);
void qni_octree_destroy(qni_octree *octree);
/* Free all but the list of leaves. */
void qni_octree_keep_list(qni_octree *octree);

/* The level of the leaf that holds a finest cell; -1 where no block is. */
static inline int qni_octree_level(const qni_octree *octree, const int32_t point[3]) {
    const int64_t index =
        qni_hermite_find(octree->hermite, point[0] >> 3, point[1] >> 3, point[2] >> 3);
    return index < 0
               ? -1
               : octree->levels[index][64 * (point[2] & 7) + 8 * (point[1] & 7) + (point[0] & 7)];
}
/* The number of a leaf with surface, or -1 when there is none such. */
int64_t qni_octree_find_leaf(const qni_octree *octree, const qni_cell *cell);
/* Is the finest cell at a point in no leaf with surface? The same where its leaf's level is known.
 */
bool qni_octree_is_empty_of(const qni_octree *octree, const int32_t point[3], int level);
static inline bool qni_octree_is_empty(const qni_octree *octree, const int32_t point[3]) {
    return qni_octree_is_empty_of(octree, point, qni_octree_level(octree, point));
}
/* The level of any leaf along a face, on its other side; -1 where there is no block. */
int qni_octree_level_across(const qni_octree *octree, const qni_cell *cell, int face);
/* Is the cell of the same size across a face divided? Only the part along the face is asked: where
 * no block lies there, no surface does. */
bool qni_octree_divided_across(const qni_octree *octree, const qni_cell *cell, int face);
/* The cell of the same size across a face. */
static inline qni_cell qni_cell_across(const qni_cell *cell, int face) {
    qni_cell across = *cell;
    across.low[face >> 1] += (face & 1 ? 1 : -1) * (1 << cell->level);
    return across;
}

/* Number the leaves (leaves.c). */
qn_status qni_octree_number_leaves(qni_octree *octree, const qni_cell *large, int64_t large_count,
                                   qn_error *error);

#endif
