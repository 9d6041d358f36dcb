// SPDX-License-Identifier: MIT
/* Which polygons of a cell the trilinear interpolant joins by a tunnel: face/tunnel_hd.h says which
 * regions are joined. The surface has one part less than there are regions, since regions and the
 * parts of surface between them make a tree: two polygons are joined if the same two regions meet
 * there. */
#ifndef QNI_DMC_TUNNEL_HD_H
#define QNI_DMC_TUNNEL_HD_H

#include "dmc/cell_hd.h"
#include "face/tunnel_hd.h"

/* The tunnel of a cell: the two polygons it joins, and a place well inside of it. */
typedef struct qni_tunnel {
    int polygon[2];
    int side;         /* 1: the tunnel is above within */
    double middle[3]; /* the saddle of the widest slice along z, local */
} qni_tunnel;

/* The region of each corner: the lowest corner that the cell's border joins with it. Joined are the
 * ends of an edge without crossing, and the far corners of a face whose segments cut off the other
 * two. */
QN_HD static inline void qni_corner_regions(const double d[8], int entry, int region[8]) {
    const uint64_t next_code = qni_entry_next_code(entry);
    int changed = 1;
    for (int corner = 0; corner < 8; ++corner)
        region[corner] = corner;
    while (changed) {
        changed = 0;
        for (int face = 0; face < QNI_FACES; ++face)
            for (int n = 0; n < 4; ++n) {
                const int here = qni_face_corner(face, n),
                          ahead = qni_face_corner(face, (n + 1) & 3);
                const int across = qni_face_corner(face, (n + 2) & 3);
                const int edge = qni_face_edge(face, n), before = qni_face_edge(face, (n + 3) & 3);
                const int cut = (int)(next_code >> (4 * edge) & 15) == before ||
                                (int)(next_code >> (4 * before) & 15) == edge;
                const int same = (d[here] >= 0) == (d[ahead] >= 0);
                const int other = same                                         ? ahead
                                  : (d[here] >= 0) == (d[across] >= 0) && !cut ? across
                                                                               : here;
                const int lowest = region[here] < region[other] ? region[here] : region[other];
                changed = changed || region[here] != region[other];
                region[here] = region[other] = lowest;
            }
    }
}

/* Look for the tunnel of a cell with several polygons; there is never more than one. */
QN_HD static inline int qni_find_tunnel(const double d[8], int entry, qni_tunnel *tunnel) {
    const int polygons = qni_entry_polygons(entry);
    qni_edge_place stretch[4][2];
    int region[8], label[4] = {-1, -2, -3, -4};
    if (polygons < 2)
        return 0;
    const int joining = qni_joining_edges(d, stretch);
    if (!joining)
        return 0;
    qni_corner_regions(d, entry, region);
    if (!qni_join_regions(d, joining, (const qni_edge_place(*)[2])stretch, region, &tunnel->side,
                          tunnel->middle))
        return 0;
    const uint32_t owner = qni_entry_owner_code(entry);
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int from = qni_edge_start_corner(edge), to = from | 1 << qni_edge_axis(edge);
        if ((d[from] >= 0) == (d[to] >= 0))
            continue;
        const int above = d[from] >= 0 ? from : to, below = d[from] >= 0 ? to : from;
        label[owner >> (2 * edge) & 3] = 8 * region[above] + region[below];
    }
    int pairs = 0;
    for (int m = 0; m < polygons; ++m)
        for (int n = m + 1; n < polygons; ++n)
            if (label[m] == label[n]) {
                tunnel->polygon[0] = m;
                tunnel->polygon[1] = n;
                ++pairs;
            }
    return pairs == 1;
}

#endif
