// SPDX-License-Identifier: MIT
/* Halfedges from the grid: the quads of two lattice edges that a face segment joins are twins
 * across that segment. So a face with two segments between the same two polygons, the non-manifold
 * edge of [MDMC21], still has its four halfedges paired rightly, as two separate edges. */
#include "dmc/link.h"
#include "dmc/cell_hd.h"
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

/* The quads of one leaf whose edges start on the points it shares with the leaf at hand; `shift` is
 * 1 along the axes where it is the upper neighbour: there only its first points count. */
static void note_leaf(const qni_dmc_row *row, int32_t at, const int shift[3], qni_quad_ids *ids) {
    const qni_dmc_leaf *leaf = row->leaves + at;
    const qni_leaf_quads *quads = row->quads + at;
    const uint32_t base = (uint32_t)(row->quad_base + leaf->quad_base);
    const uint64_t shared =
        (shift[0] ? qni_columns(0, 1) : ~UINT64_C(0)) & (shift[1] ? qni_rows(0, 1) : ~UINT64_C(0));
    for (int axis = 0; axis < 3; ++axis)
        for (int z = 0; z < (shift[2] ? 1 : QNI_LEAF); ++z)
            for (uint64_t rest = quads->mask[axis][z] & shared; rest; rest &= rest - 1) {
                const int bit = __builtin_ctzll(rest);
                const int before =
                    __builtin_popcountll(quads->mask[axis][z] & ((UINT64_C(1) << bit) - 1));
                ids->quad[axis][shift[2] ? 8 : z][shift[1] ? 8 : bit >> 3][shift[0] ? 8 : bit & 7] =
                    base + quads->before[axis][z] + (uint32_t)before;
            }
}

void qni_quad_ids_note(qni_upper_rows *rows, int32_t x, qni_quad_ids *ids) {
    memset(ids, 0xff, sizeof *ids);
    for (int n = 0; n < 4; ++n) {
        const qni_dmc_row *row = rows->row[n];
        if (!row)
            continue;
        while (rows->at[n] < row->leaf_count && row->leaves[rows->at[n]].x < x)
            ++rows->at[n];
        for (int32_t at = rows->at[n]; at < row->leaf_count && row->leaves[at].x <= x + 1; ++at) {
            const int shift[3] = {row->leaves[at].x - x, n & 1, n >> 1};
            note_leaf(row, at, shift, ids);
        }
    }
}

/* One cell of the leaf. */
typedef struct cell {
    int x, y, z, case_index;
    uint32_t quad[QNI_EDGES]; /* of its crossed edges, or QN_NO_HALFEDGE */
    bool forward[QNI_EDGES];
} cell;

static void look_up_cell(const qni_link_leaf *job, const qni_quad_ids *ids, int x, int y, int z,
                         cell *c) {
    c->x = x;
    c->y = y;
    c->z = z;
    c->case_index = qni_case_of_cell(job->signs, x, y, z);
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int start = qni_edge_start_corner(edge), axis = qni_edge_axis(edge);
        const bool above = c->case_index >> start & 1;
        const bool crossed = above != (c->case_index >> (start | 1 << axis) & 1);
        c->forward[edge] = above != job->reverse;
        c->quad[edge] =
            crossed ? ids->quad[axis][z + (start >> 2)][y + (start >> 1 & 1)][x + (start & 1)]
                    : QN_NO_HALFEDGE;
    }
}

static uint32_t halfedge_on(const cell *c, int edge, int face) {
    return 4 * c->quad[edge] + (uint32_t)qni_quad_side(qni_ring_side(edge, face), c->forward[edge]);
}

static void pair(const cell *c, int face, int edge_a, int edge_b, uint32_t *twins) {
    const bool has_a = c->quad[edge_a] != QN_NO_HALFEDGE, has_b = c->quad[edge_b] != QN_NO_HALFEDGE;
    const uint32_t a = has_a ? halfedge_on(c, edge_a, face) : QN_NO_HALFEDGE;
    const uint32_t b = has_b ? halfedge_on(c, edge_b, face) : QN_NO_HALFEDGE;
    if (has_a)
        twins[a] = b;
    if (has_b)
        twins[b] = a;
}

/* A face with four crossings: the segments cut off its lower corners or its upper ones, as the face
 * rule says. */
static void pair_ambiguous(const qni_link_leaf *job, const cell *c, int face, uint32_t *twins) {
    double d[4];
    for (int n = 0; n < 4; ++n) {
        const int corner = qni_face_corner(face, n);
        d[n] = job->tile[c->z + (corner >> 2) + 1][c->y + (corner >> 1 & 1) + 1]
                        [c->x + (corner & 1) + 1];
    }
    const int first_above = d[0] >= 0 ? 0 : 1;
    const int joined = qni_face_joins_above(qni_face_saddle_sign(
        d[first_above], d[first_above + 2], d[1 - first_above], d[(3 - first_above)]));
    const int first_cut = joined ? 1 - first_above : first_above;
    for (int n = first_cut; n < 4; n += 2) /* corner n lies between face edges n - 1 and n */
        pair(c, face, qni_face_edge(face, (n + 3) & 3), qni_face_edge(face, n), twins);
}

static void link_low_face(const qni_link_leaf *job, const cell *c, int face, uint32_t *twins) {
    int crossed[4], count = 0;
    for (int n = 0; n < 4; ++n) {
        const int a = qni_face_corner(face, n), b = qni_face_corner(face, (n + 1) & 3);
        if ((c->case_index >> a & 1) != (c->case_index >> b & 1))
            crossed[count++] = qni_face_edge(face, n);
    }
    if (count == 2)
        pair(c, face, crossed[0], crossed[1], twins);
    else if (count == 4)
        pair_ambiguous(job, c, face, twins);
}

/* The halfedge a vertex gets: the lowest that starts there and has no quad across it, else the
 * lowest that starts there. */
static void link_vertex(const cell *c, unsigned edges, uint64_t next_code, uint32_t *halfedge) {
    uint32_t lowest = QN_NO_HALFEDGE, lowest_open = QN_NO_HALFEDGE;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        if (!(edges >> edge & 1))
            continue;
        const int next = (int)(next_code >> (4 * edge) & 15), face = qni_face_of_edges(edge, next);
        for (int end = 0; end < 2; ++end) {
            const int own = end ? next : edge, other = end ? edge : next;
            if (c->quad[own] == QN_NO_HALFEDGE)
                continue;
            const uint32_t h = halfedge_on(c, own, face);
            const int corner = qni_quad_corner(qni_ring_place(own), c->forward[own]);
            if ((int)(h & 3) != corner) /* it ends here */
                continue;
            lowest = h < lowest ? h : lowest;
            if (c->quad[other] == QN_NO_HALFEDGE)
                lowest_open = h < lowest_open ? h : lowest_open;
        }
    }
    *halfedge = lowest_open != QN_NO_HALFEDGE ? lowest_open : lowest;
}

/* The entry of a cell with one polygon; where its faces are ambiguous, their choices decide the
 * order of its edges. */
static int entry_of_single(const qni_link_leaf *job, const cell *c) {
    if (qni_case_ambiguous_faces(c->case_index) == 0)
        return qni_case_offset(c->case_index);
    double d[8];
    for (int n = 0; n < 8; ++n)
        d[n] = job->tile[c->z + (n >> 2) + 1][c->y + (n >> 1 & 1) + 1][c->x + (n & 1) + 1];
    return qni_cell_resolve(d, c->case_index).entry;
}

void qni_link(const qni_link_leaf *job, const qni_quad_ids *ids, uint32_t *twins,
              uint32_t *vertex_halfedges) {
    const qni_multi_cell *multi = job->multis, *multi_end = multi + job->leaf->multi_count;
    uint32_t vertex = job->first_vertex;
    for (int z = 0; z < QNI_LEAF; ++z)
        for (uint64_t rest = job->leaf->active[z]; rest; rest &= rest - 1) {
            const int bit = __builtin_ctzll(rest);
            cell c;
            look_up_cell(job, ids, bit & 7, bit >> 3, z, &c);
            const int at[3] = {c.x, c.y, c.z};
            for (int axis = 0; axis < 3; ++axis)
                if (at[axis] > 0 || !job->extent->at_low[axis])
                    link_low_face(job, &c, 2 * axis, twins);
            const bool is_multi = multi < multi_end && multi->cell == bit + 64 * z;
            const int entry = is_multi ? multi++->entry : entry_of_single(job, &c);
            for (int n = 0; n < qni_entry_polygons(entry); ++n, ++vertex)
                link_vertex(&c, qni_entry_edges(entry, n), qni_entry_next_code(entry),
                            vertex_halfedges + vertex);
        }
}
