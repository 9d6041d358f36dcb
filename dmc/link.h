// SPDX-License-Identifier: MIT
/* Halfedges of a leaf from the grid, without hashing or sorting. */
#ifndef QNI_DMC_LINK_H
#define QNI_DMC_LINK_H

#include "dmc/dmc.h"
#include "dmc/leaf_hd.h"

enum { QNI_LINK_IDS = QNI_LEAF + 1 };

/* Quads of the edges of a leaf's cells: [axis][z][y][x], of the edge that starts at that point;
 * QN_NO_HALFEDGE where there is no quad. Points at 8 belong to the upper neighbours. */
typedef struct qni_quad_ids {
    uint32_t quad[3][QNI_LINK_IDS][QNI_LINK_IDS][QNI_LINK_IDS];
} qni_quad_ids;

/* The leaf at x and the one after it, in a row and its three upper neighbours, walked in step. */
typedef struct qni_upper_rows {
    const qni_dmc_row
        *row[4]; /* bit 0: one higher in y, bit 1: one higher in z; NULL beyond the lattice */
    int32_t at[4];
} qni_upper_rows;

void qni_upper_rows_init(const qni_dmc *dmc, int64_t row, qni_upper_rows *rows);
/* Fill in the quads round the leaf at x. */
void qni_quad_ids_note(qni_upper_rows *rows, int32_t x, qni_quad_ids *ids);

/* What linking needs to know of the leaf at hand. */
typedef struct qni_link_leaf {
    const double (*tile)[QNI_TILE][QNI_TILE];
    const uint16_t (*signs)[QNI_LEAF_SAMPLES];
    const qni_leaf_extent *extent;
    const qni_dmc_leaf *leaf;
    const qni_multi_cell *multis;
    uint32_t first_vertex;
    bool reverse; /* quads run against their ring where values fall along the edge */
} qni_link_leaf;

/* Write the twins of all halfedges on the low faces of the leaf's cells, and a halfedge for each of
 * its vertices. Every halfedge lies on one face, so no two leaves write the same. */
void qni_link(const qni_link_leaf *job, const qni_quad_ids *ids, uint32_t *twins,
              uint32_t *vertex_halfedges);

#endif
