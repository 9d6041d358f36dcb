// SPDX-License-Identifier: MIT
/* The rim of an open mesh. Lattice edges on the volume's border have no quads; where they divide
 * the edges of a polygon into several runs, its one vertex would be all that several fans of quads
 * have in common. Such a vertex is split: one for each fan. Polygons without any quad keep their
 * vertex, which no face uses, as in [DMC21], whose counts include them. */
#ifndef QNI_DMC_RIM_H
#define QNI_DMC_RIM_H

#include "core/cube_hd.h"
#include "dmc/dmc.h"

/* The edges of a polygon by the fans that their quads form: those of fan f are edge[first[f]] to
 * edge[first[f + 1] - 1], in the polygon's order. */
typedef struct qni_rim_fans {
    int count;
    uint8_t edge[QNI_EDGES];
    uint8_t first[QNI_EDGES + 1];
} qni_rim_fans;

/* A lattice edge has a quad when there are four cells round it. */
bool qni_edge_is_inner(const qni_field *field, const int32_t point[3], int axis);
/* The lattice point that an edge of a cell starts from. */
void qni_edge_point(const int32_t cell[3], int edge, int32_t point[3]);

void qni_rim_find_fans(const qni_field *field, const int32_t cell[3], int entry, int polygon,
                       qni_rim_fans *fans_out);

/* The vertices of a leaf that several fans share, from the row's vertex `first_vertex` on; how
 * many. `multi` are the leaf's own; `rims` has room for four a cell. */
int64_t qni_rim_count_leaf(const qni_field *field, const uint16_t signs[9][9],
                           const int32_t leaf[3], int64_t first_vertex, const qni_dmc_leaf *own,
                           const qni_multi_cell *multi, qni_rim_vertex *rims);

/* Split the vertices that counting noted in the rows: after emission, before the repair, which
 * reads the quads. Returns how many of the new points are left on a lattice edge. */
int64_t qni_rim_apply(qni_dmc *dmc, const qni_frame *frame, bool reverse, qn_mesh *mesh);

#endif
