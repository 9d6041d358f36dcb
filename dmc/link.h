// SPDX-License-Identifier: MIT
/* Halfedges of a leaf from the grid, without hashing or sorting. */
#ifndef QNI_DMC_LINK_H
#define QNI_DMC_LINK_H

#include "core/cube_hd.h"
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
/* Fill in the quads round the leaf at x. Where the leaf has cells at the lattice's border, edges
 * without a quad get QN_NO_HALFEDGE; elsewhere all crossed edges have quads, and the places of
 * others are not written. */
void qni_quad_ids_note(qni_upper_rows *rows, int32_t x, bool at_border, qni_quad_ids *ids);

/* Two quads across a segment of a face: where they are noted, from the place of the face's cell on,
 * and which of their sides the segment is. */
typedef struct qni_link_segment {
    uint16_t place[2];
    uint8_t side[2];
} qni_link_segment;

/* What the signs alone say of low faces and edges of a cell. */
typedef struct qni_link_tables {
    qni_link_segment face[3][16];     /* by axis, and which of the corners (in the face's order) are
                                         above: of faces with two crossings */
    qni_link_segment corner[3][2][4]; /* of faces with four, by whether corner 1 is above: the
                                         segment that cuts off each corner */
    uint16_t edge_place[QNI_EDGES];
    uint8_t edge_corner[QNI_EDGES][2]; /* which corner of the edge's quad the cell is, by whether
                                          the edge starts above */
    uint8_t first_edge[256];           /* the lowest crossed edge of each case */
    bool reverse;
} qni_link_tables;

/* `reverse`: quads run against their ring where values fall along the edge. */
void qni_link_prepare(bool reverse, qni_link_tables *tables_out);

/* What linking needs to know of the leaf at hand. */
typedef struct qni_link_leaf {
    const double (*tile)[QNI_TILE][QNI_TILE];
    const uint16_t (*signs)[QNI_LEAF_SAMPLES];
    const qni_leaf_masks *masks;
    const qni_link_tables *tables;
    const qni_leaf_extent *extent;
    const qni_dmc_leaf *leaf;
    const qni_multi_cell *multis;
    uint32_t first_vertex;
    bool at_border; /* some of its cells are at the lattice's border */
} qni_link_leaf;

/* Write the twins of all halfedges on the low faces of the leaf's cells, and a halfedge for each of
 * its vertices. Every halfedge lies on one face, so no two leaves write the same. */
void qni_link(const qni_link_leaf *job, const qni_quad_ids *ids, uint32_t *twins,
              uint32_t *vertex_halfedges);
/* The quads round each vertex, 0 where some are missing, of a leaf at the border of a lattice of
 * `cells`; the leaf's first cell is `at`. `valences` starts at its first vertex. Masks and tables
 * are not needed. Also 0 at the ends of doubled edges that are kept. */
void qni_note_valences(const qni_link_leaf *job, const int64_t cells[3], const int64_t at[3],
                       bool keep_doubled, uint8_t *valences);

#endif
