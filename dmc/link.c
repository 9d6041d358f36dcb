// SPDX-License-Identifier: MIT
/* Halfedges from the grid: the quads of two lattice edges that a face segment joins are twins
 * across that segment. So a face with two segments between the same two polygons, the non-manifold
 * edge of [MDMC21], still has its four halfedges paired rightly, as two separate edges. */
#include "dmc/link.h"
#include "dmc/cell_hd.h"
#include "dmc/doubled_hd.h"
#include "dmc/ring_hd.h"

#include <string.h>

void qni_upper_rows_init(const qni_dmc *dmc, int64_t index, qni_upper_rows *rows) {
    int32_t leaf[2];
    qni_field_row_leaf(&dmc->field, index, leaf);
    for (int n = 0; n < 4; ++n) {
        const int64_t row = qni_field_find_row(&dmc->field, leaf[0] + (n & 1), leaf[1] + (n >> 1));
        rows->row[n] = row < 0 ? NULL : dmc->rows + row;
        rows->at[n] = 0;
    }
}

static int
count_bits(uint64_t bits) { /* without a call where the processor's own is not built in */
    bits -= bits >> 1 & UINT64_C(0x5555555555555555);
    bits = (bits & UINT64_C(0x3333333333333333)) + (bits >> 2 & UINT64_C(0x3333333333333333));
    return (int)(((bits + (bits >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f)) *
                     UINT64_C(0x0101010101010101) >>
                 56);
}

/* The quads of the leaf at hand, which are numbered in the order in which they are met. */
static void note_own(const qni_dmc_row *row, int32_t at, qni_quad_ids *ids) {
    const qni_leaf_quads *quads = row->quads + at;
    uint32_t quad = (uint32_t)(row->quad_base + row->leaves[at].quad_base);
    for (int axis = 0; axis < 3; ++axis)
        for (int z = 0; z < QNI_LEAF; ++z)
            for (uint64_t rest = quads->mask[axis][z]; rest; rest &= rest - 1) {
                const int bit = __builtin_ctzll(rest);
                ids->quad[axis][z][bit >> 3][bit & 7] = quad++;
            }
}

/* The quads of an upper neighbour whose edges start on the points it shares with the leaf at hand;
 * `shift` is 1 along the axes where it is upper: there only its first points count. */
static void note_upper(const qni_dmc_row *row, int32_t at, const int shift[3], qni_quad_ids *ids) {
    const qni_leaf_quads *quads = row->quads + at;
    const uint32_t base = (uint32_t)(row->quad_base + row->leaves[at].quad_base);
    const uint64_t shared =
        (shift[0] ? qni_columns(0, 1) : ~UINT64_C(0)) & (shift[1] ? qni_rows(0, 1) : ~UINT64_C(0));
    for (int axis = 0; axis < 3; ++axis)
        for (int z = 0; z < (shift[2] ? 1 : QNI_LEAF); ++z)
            for (uint64_t rest = quads->mask[axis][z] & shared; rest; rest &= rest - 1) {
                const int bit = __builtin_ctzll(rest);
                const int before = count_bits(quads->mask[axis][z] & ((UINT64_C(1) << bit) - 1));
                ids->quad[axis][shift[2] ? 8 : z][shift[1] ? 8 : bit >> 3][shift[0] ? 8 : bit & 7] =
                    base + quads->before[axis][z] + (uint32_t)before;
            }
}

void qni_quad_ids_note(qni_upper_rows *rows, int32_t x, bool at_border, qni_quad_ids *ids) {
    if (at_border) /* elsewhere every crossed edge has a quad, and others are not asked for */
        memset(ids, 0xff, sizeof *ids);
    for (int n = 0; n < 4; ++n) {
        const qni_dmc_row *row = rows->row[n];
        if (!row)
            continue;
        while (rows->at[n] < row->leaf_count && row->leaves[rows->at[n]].x < x)
            ++rows->at[n];
        for (int32_t at = rows->at[n]; at < row->leaf_count && row->leaves[at].x <= x + 1; ++at) {
            const int shift[3] = {row->leaves[at].x - x, n & 1, n >> 1};
            if (shift[0] | shift[1] | shift[2])
                note_upper(row, at, shift, ids);
            else
                note_own(row, at, ids);
        }
    }
}

/* ---- tables ---------------------------------------------------------------------------------- */

static int place_of(int x, int y, int z) {
    return (z * QNI_LINK_IDS + y) * QNI_LINK_IDS + x;
}

/* An edge of a cell whose start is above or not: where its quad is noted, from the cell's place on;
 * which corner of that quad the cell is. */
static void fill_edge(int edge, int above, bool reverse, qni_link_tables *tables) {
    enum { AXIS = QNI_LINK_IDS * QNI_LINK_IDS * QNI_LINK_IDS };
    const int start = qni_edge_start_corner(edge), forward = (above != 0) != reverse;
    tables->edge_place[edge] =
        (uint16_t)(AXIS * qni_edge_axis(edge) + place_of(start & 1, start >> 1 & 1, start >> 2));
    tables->edge_corner[edge][above] = (uint8_t)qni_quad_corner(qni_ring_place(edge), forward);
}

/* A segment between two edges of a low face whose corners are above as the code's bits say: the
 * places of the two quads and which of their sides it is. */
static qni_link_segment segment_between(int axis, int code, int n, int m, bool reverse,
                                        const qni_link_tables *tables) {
    qni_link_segment segment;
    for (int end = 0; end < 2; ++end) {
        const int in_face = end ? m : n, edge = qni_face_edge(2 * axis, in_face);
        int start = 0; /* which of the face's corners the edge starts from */
        while (qni_face_corner(2 * axis, start) != qni_edge_start_corner(edge))
            ++start;
        const int forward = (code >> start & 1) != reverse;
        segment.place[end] = tables->edge_place[edge];
        segment.side[end] = (uint8_t)qni_quad_side(qni_ring_side(edge, 2 * axis), forward);
    }
    return segment;
}

void qni_link_prepare(bool reverse, qni_link_tables *tables) {
    memset(tables, 0, sizeof *tables);
    tables->reverse = reverse;
    for (int edge = 0; edge < QNI_EDGES; ++edge)
        for (int above = 0; above < 2; ++above)
            fill_edge(edge, above, reverse, tables);
    for (int axis = 0; axis < 3; ++axis)
        for (int code = 1; code < 15; ++code) {
            int crossed[4], count = 0;
            for (int n = 0; n < 4; ++n)
                if ((code >> n & 1) != (code >> ((n + 1) & 3) & 1))
                    crossed[count++] = n;
            if (count == 2)
                tables->face[axis][code] =
                    segment_between(axis, code, crossed[0], crossed[1], reverse, tables);
            for (int cut = 0; cut < 4 && count == 4; ++cut) /* corner n: edges n - 1 and n */
                tables->corner[axis][code >> 1 & 1][cut] =
                    segment_between(axis, code, (cut + 3) & 3, cut, reverse, tables);
        }
    for (int c = 1; c < 255; ++c) {
        int edge = 0;
        while ((c >> qni_edge_start_corner(edge) & 1) ==
               (c >> (qni_edge_start_corner(edge) | 1 << qni_edge_axis(edge)) & 1))
            ++edge;
        tables->first_edge[c] = (uint8_t)edge;
    }
}

/* ---- twins ----------------------------------------------------------------------------------- */

static void pair(const qni_link_segment *segment, const uint32_t *quad, uint32_t *twins) {
    const uint32_t first = quad[segment->place[0]], second = quad[segment->place[1]];
    const uint32_t a = 4 * first + segment->side[0], b = 4 * second + segment->side[1];
    twins[a] = b;
    twins[b] = a;
}

/* Where lattice edges may lack their quads. */
static void pair_at_border(const qni_link_segment *segment, const uint32_t *quad, uint32_t *twins) {
    const uint32_t first = quad[segment->place[0]], second = quad[segment->place[1]];
    const uint32_t a = 4 * first + segment->side[0], b = 4 * second + segment->side[1];
    if (first != QN_NO_HALFEDGE)
        twins[a] = second == QN_NO_HALFEDGE ? second : b;
    if (second != QN_NO_HALFEDGE)
        twins[b] = first == QN_NO_HALFEDGE ? first : a;
}

/* A face with four crossings: the segments cut off two opposite corners, as the face rule says. */
static int first_cut_of_face(const qni_link_leaf *job, int x, int y, int z, int face) {
    double d[4];
    for (int n = 0; n < 4; ++n) {
        const int corner = qni_face_corner(face, n);
        d[n] = job->tile[z + (corner >> 2) + 1][y + (corner >> 1 & 1) + 1][x + (corner & 1) + 1];
    }
    const int first_above = d[0] >= 0 ? 0 : 1;
    const int joined = qni_face_joins_above(qni_face_saddle_sign(
        d[first_above], d[first_above + 2], d[1 - first_above], d[(3 - first_above)]));
    return joined ? 1 - first_above : first_above;
}

/* Corners of the low faces of a slice's cells, in the face's own order. */
static void face_corners(const qni_leaf_masks *masks, int axis, int z, uint64_t corner[4]) {
    const int u = axis == 0 ? 2 : 1;
    corner[0] = masks->corner[0][z];
    corner[1] = masks->corner[u][z];
    corner[2] = axis == 2 ? masks->corner[3][z] : masks->corner[u][z + 1];
    corner[3] = axis == 2 ? masks->corner[2][z] : masks->corner[0][z + 1];
}

static uint64_t faces_of_slice(const qni_leaf_extent *extent, int axis, int z) {
    uint64_t faces = qni_cells_of_slice(extent, z);
    if (extent->at_low[axis])
        faces &= axis == 0 ? qni_columns(1, 8) : axis == 1 ? qni_rows(1, 8) : z > 0 ? faces : 0;
    return faces;
}

static void link_faces(const qni_link_leaf *job, int axis, int z, const uint32_t *quads,
                       uint32_t *twins) {
    uint64_t corner[4];
    face_corners(job->masks, axis, z, corner);
    const uint64_t crossed = (corner[0] | corner[1] | corner[2] | corner[3]) &
                             ~(corner[0] & corner[1] & corner[2] & corner[3]);
    for (uint64_t rest = crossed & faces_of_slice(job->extent, axis, z); rest; rest &= rest - 1) {
        const int bit = __builtin_ctzll(rest), x = bit & 7, y = bit >> 3;
        const int code = (int)(corner[0] >> bit & 1) | (int)(corner[1] >> bit & 1) << 1 |
                         (int)(corner[2] >> bit & 1) << 2 | (int)(corner[3] >> bit & 1) << 3;
        const uint32_t *quad = quads + place_of(x, y, z);
        const bool ambiguous = code == 5 || code == 10;
        const qni_link_segment *segment = &job->tables->face[axis][code];
        if (!ambiguous && !job->at_border) {
            pair(segment, quad, twins);
        } else if (!ambiguous) {
            pair_at_border(segment, quad, twins);
        } else {
            const int cut = first_cut_of_face(job, x, y, z, 2 * axis);
            segment = job->tables->corner[axis][code >> 1 & 1];
            pair_at_border(segment + cut, quad, twins);
            pair_at_border(segment + cut + 2, quad, twins);
        }
    }
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* The halfedge that starts at a cell's vertex in the quad of one of its edges. */
static uint32_t start_at(const qni_link_tables *tables, const uint32_t *quad, int edge,
                         int case_index) {
    const int above = case_index >> qni_edge_start_corner(edge) & 1;
    return 4 * quad[tables->edge_place[edge]] + tables->edge_corner[edge][above];
}

/* At the border: the first one that starts at the polygon's vertex and has no quad across, else the
 * first one. Two edges that follow each other are joined by a segment; the halfedge of one of their
 * quads on it starts at the vertex. */
static uint32_t start_at_border(const qni_link_tables *tables, const uint32_t *quad, int entry,
                                int polygon, int case_index) {
    const unsigned edges = qni_entry_edges(entry, polygon);
    const uint64_t next_code = qni_entry_next_code(entry);
    uint32_t any = QN_NO_HALFEDGE, open = QN_NO_HALFEDGE;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        if (!(edges >> edge & 1))
            continue;
        const int next = (int)(next_code >> (4 * edge) & 15), face = qni_face_of_edges(edge, next);
        for (int end = 0; end < 2; ++end) {
            const int own = end ? next : edge, other = end ? edge : next;
            if (quad[tables->edge_place[own]] == QN_NO_HALFEDGE)
                continue;
            const uint32_t h = start_at(tables, quad, own, case_index);
            const bool above = case_index >> qni_edge_start_corner(own) & 1;
            const int forward = above != tables->reverse;
            if ((int)(h & 3) != qni_quad_side(qni_ring_side(own, face), forward))
                continue;
            any = h < any ? h : any;
            if (quad[tables->edge_place[other]] == QN_NO_HALFEDGE)
                open = h < open ? h : open;
        }
    }
    return open != QN_NO_HALFEDGE ? open : any;
}

/* The entry of a cell with one polygon; where its faces are ambiguous, their choices decide the
 * order of its edges. */
static int entry_of_single(const qni_link_leaf *job, int x, int y, int z, int case_index) {
    if (qni_case_ambiguous_faces(case_index) == 0)
        return qni_case_offset(case_index);
    double d[8];
    for (int n = 0; n < 8; ++n)
        d[n] = job->tile[z + (n >> 2) + 1][y + (n >> 1 & 1) + 1][x + (n & 1) + 1];
    return qni_cell_resolve(d, case_index).entry;
}

static int first_of(unsigned edges) {
    return __builtin_ctz(edges);
}

/* The edges with their ends on different sides. */
static unsigned edges_of_case(int case_index) {
    unsigned edges = 0;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int start = qni_edge_start_corner(edge), end = start | 1 << qni_edge_axis(edge);
        edges |= (unsigned)((case_index >> start ^ case_index >> end) & 1) << edge;
    }
    return edges;
}

/* Quads are numbered by leaf first, so in a cell whose edges end in other leaves too (`at_end`) a
 * polygon's first edge need not have its lowest quad. */
static uint32_t lowest_start(const qni_link_tables *tables, const uint32_t *quad, unsigned edges,
                             int case_index, bool at_end) {
    uint32_t lowest = start_at(tables, quad, first_of(edges), case_index);
    for (unsigned rest = at_end ? edges & (edges - 1) : 0; rest; rest &= rest - 1) {
        const uint32_t h = start_at(tables, quad, first_of(rest), case_index);
        lowest = h < lowest ? h : lowest;
    }
    return lowest;
}

/* The vertices of a cell with several polygons, or at the border; how many. */
static int link_polygons(const qni_link_leaf *job, const uint32_t *quad, int case_index, int entry,
                         bool at_end, uint32_t *halfedge) {
    const int polygons = qni_entry_polygons(entry);
    for (int n = 0; n < polygons; ++n) {
        const unsigned edges = qni_entry_edges(entry, n);
        halfedge[n] = job->at_border ? start_at_border(job->tables, quad, entry, n, case_index)
                                     : lowest_start(job->tables, quad, edges, case_index, at_end);
    }
    return polygons;
}

static void link_vertices(const qni_link_leaf *job, const uint32_t *quads,
                          uint32_t *vertex_halfedges) {
    const qni_link_tables *tables = job->tables;
    const qni_multi_cell *multi = job->multis, *multi_end = multi + job->leaf->multi_count;
    int64_t vertex = job->first_vertex;
    for (int z = 0; z < QNI_LEAF; ++z)
        for (uint64_t rest = job->leaf->active[z]; rest; rest &= rest - 1) {
            const int bit = __builtin_ctzll(rest), x = bit & 7, y = bit >> 3;
            const int case_index = qni_case_of_cell(job->signs, x, y, z);
            const uint32_t *quad = quads + place_of(x, y, z);
            const bool is_multi = multi < multi_end && multi->cell == bit + 64 * z;
            const bool at_end = x == 7 || y == 7 || z == 7;
            if (is_multi || job->at_border) {
                const int entry =
                    is_multi ? multi->entry : entry_of_single(job, x, y, z, case_index);
                vertex +=
                    link_polygons(job, quad, case_index, entry, at_end, vertex_halfedges + vertex);
                multi += is_multi;
                continue;
            }
            const unsigned edges =
                at_end ? edges_of_case(case_index) : 1u << tables->first_edge[case_index];
            vertex_halfedges[vertex++] = lowest_start(tables, quad, edges, case_index, at_end);
        }
}

/* Edges of a cell that are on the lattice's border and so have no quads. */
static unsigned edges_on_border(const int64_t cells[3], const int64_t cell[3]) {
    unsigned edges = 0;
    for (int edge = 0; edge < QNI_EDGES; ++edge)
        for (int a = 0; a < 3; ++a) {
            const int64_t at = cell[a] + qni_edge_side(edge, a);
            const bool outside = a != qni_edge_axis(edge) && (at == 0 || at == cells[a]);
            edges |= (unsigned)outside << edge;
        }
    return edges;
}

void qni_note_valences(const qni_link_leaf *job, const int64_t cells[3], const int64_t at[3],
                       bool keep_doubled, uint8_t *valences) {
    const qni_multi_cell *multi = job->multis, *multi_end = multi + job->leaf->multi_count;
    for (int z = 0; z < QNI_LEAF; ++z)
        for (uint64_t rest = job->leaf->active[z]; rest; rest &= rest - 1) {
            const int bit = __builtin_ctzll(rest), x = bit & 7, y = bit >> 3;
            const int64_t cell[3] = {at[0] + x, at[1] + y, at[2] + z};
            const unsigned missing = edges_on_border(cells, cell);
            const bool is_multi = multi < multi_end && multi->cell == bit + 64 * z;
            const int entry = is_multi ? multi->entry : 0;
            for (int n = 0; n < (is_multi ? qni_entry_polygons(entry) : 1); ++n) {
                const unsigned edges = is_multi
                                           ? qni_entry_edges(entry, n)
                                           : edges_of_case(qni_case_of_cell(job->signs, x, y, z));
                *valences++ =
                    (uint8_t)(edges & missing ? 0 : qni_valence_of_polygon(edges, keep_doubled));
            }
            multi += is_multi;
        }
}

void qni_link(const qni_link_leaf *job, const qni_quad_ids *ids, uint32_t *twins,
              uint32_t *vertex_halfedges) {
    const uint32_t *quads = &ids->quad[0][0][0][0];
    for (int axis = 0; axis < 3; ++axis)
        for (int z = 0; z < QNI_LEAF; ++z)
            link_faces(job, axis, z, quads, twins);
    link_vertices(job, quads, vertex_halfedges);
}
