// SPDX-License-Identifier: MIT
/* Splitting the vertices at the rim of an open mesh that several fans share. There are few of them,
 * so each finds its quads by itself, from the signs of their leaves. */
#include "dmc/rim.h"
#include "dmc/cell_hd.h"
#include "dmc/extent.h"
#include "dmc/repair_parts.h"
#include "dmc/vertex_hd.h"
#include "core/bits_hd.h"

bool qni_edge_is_inner(const qni_field *field, const int32_t point[3], int axis) {
    for (int a = 0; a < 3; ++a)
        if (a != axis && (point[a] < 1 || point[a] >= field->cells[a]))
            return false;
    return true;
}

void qni_edge_point(const int32_t cell[3], int edge, int32_t point[3]) {
    const int start = qni_edge_start_corner(edge);
    for (int a = 0; a < 3; ++a)
        point[a] = cell[a] + (start >> a & 1);
}

static int next_edge(uint64_t next_code, int edge) {
    return (int)(next_code >> (4 * edge) & 15);
}

/* Where a run of edges with quads begins; any edge when all have quads, or none. */
static int first_of_run(unsigned edges, unsigned inner, uint64_t next_code) {
    int any = 0;
    for (int edge = QNI_EDGES - 1; edge >= 0; --edge) {
        if (!(edges >> edge & 1))
            continue;
        const int next = next_edge(next_code, edge);
        if (!(inner >> edge & 1) && inner >> next & 1)
            return next;
        any = edge;
    }
    return any;
}

void qni_rim_find_fans(const qni_field *field, const int32_t cell[3], int entry, int polygon,
                       qni_rim_fans *fans) {
    const unsigned edges = qni_entry_edges(entry, polygon);
    const uint64_t next_code = qni_entry_next_code(entry);
    unsigned inner = 0;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        int32_t point[3];
        qni_edge_point(cell, edge, point);
        if (edges >> edge & 1 && qni_edge_is_inner(field, point, qni_edge_axis(edge)))
            inner |= 1u << edge;
    }
    const int start = first_of_run(edges, inner, next_code);
    int edge = start, written = 0;
    bool in_run = false;
    fans->count = 0;
    do {
        const bool has_quad = inner >> edge & 1;
        if (has_quad && !in_run)
            fans->first[fans->count++] = (uint8_t)written;
        if (has_quad)
            fans->edge[written++] = (uint8_t)edge;
        in_run = has_quad;
        edge = next_edge(next_code, edge);
    } while (edge != start);
    fans->first[fans->count] = (uint8_t)written;
}

/* ---- counting -------------------------------------------------------------------------------- */

/* Cells of the slice that touch the lattice's border. */
static uint64_t border_of_slice(const qni_leaf_extent *extent, const bool at_end[3], int z) {
    const int *cells = extent->cells;
    if ((extent->at_low[2] && z == 0) || (at_end[2] && z == cells[2] - 1))
        return ~UINT64_C(0);
    return (extent->at_low[0] ? qni_columns(0, 1) : 0) |
           (at_end[0] ? qni_columns(cells[0] - 1, cells[0]) : 0) |
           (extent->at_low[1] ? qni_rows(0, 1) : 0) |
           (at_end[1] ? qni_rows(cells[1] - 1, cells[1]) : 0);
}

static int entry_of_single(const qni_field *field, const int32_t cell[3], int case_index) {
    if (qni_case_ambiguous_faces(case_index) == 0)
        return qni_case_offset(case_index);
    const int64_t at[3] = {cell[0], cell[1], cell[2]};
    double d[8];
    qni_field_load_cell(field, at, d);
    return qni_cell_resolve(d, case_index).entry;
}

/* The polygons of a cell that several fans share; how many. */
static int note_cell(const qni_field *field, const int32_t cell[3], int entry, int64_t first_vertex,
                     qni_rim_vertex *rims) {
    int count = 0;
    for (int polygon = 0; polygon < qni_entry_polygons(entry); ++polygon) {
        qni_rim_fans fans;
        qni_rim_find_fans(field, cell, entry, polygon, &fans);
        if (fans.count < 2)
            continue;
        qni_rim_vertex *rim = rims + count++;
        for (int a = 0; a < 3; ++a)
            rim->cell[a] = cell[a];
        rim->entry = (uint16_t)entry;
        rim->polygon = (uint8_t)polygon;
        rim->fans = (uint8_t)fans.count;
        rim->vertex = (uint32_t)(first_vertex + polygon);
    }
    return count;
}

int64_t qni_rim_count_leaf(const qni_field *field, const uint16_t signs[9][9],
                           const int32_t leaf[3], int64_t first_vertex, const qni_dmc_leaf *own,
                           const qni_multi_cell *multi, qni_rim_vertex *rims) {
    const qni_multi_cell *multi_end = multi + own->multi_count;
    const qni_leaf_extent extent = qni_leaf_extent_of(field, leaf);
    int64_t vertex = first_vertex, count = 0;
    bool at_end[3], at_border = false;
    for (int a = 0; a < 3; ++a) {
        at_end[a] = leaf[a] == field->leaves[a] - 1;
        at_border = at_border || at_end[a] || extent.at_low[a];
    }
    for (int z = 0; at_border && z < QNI_LEAF; ++z) {
        const uint64_t border = border_of_slice(&extent, at_end, z);
        for (uint64_t rest = own->active[z]; rest; rest &= rest - 1) {
            const int bit = __builtin_ctzll(rest), x = bit & 7, y = bit >> 3;
            const bool is_multi = multi < multi_end && multi->cell == bit + 64 * z;
            if (border >> bit & 1) {
                const int32_t cell[3] = {QNI_LEAF * leaf[0] + x, QNI_LEAF * leaf[1] + y,
                                         QNI_LEAF * leaf[2] + z};
                const int entry =
                    is_multi ? multi->entry
                             : entry_of_single(field, cell, qni_case_of_cell(signs, x, y, z));
                count += note_cell(field, cell, entry, vertex, rims + count);
            }
            vertex += is_multi ? qni_entry_polygons(multi->entry) : 1;
            multi += is_multi;
        }
    }
    return count;
}

/* ---- quads ----------------------------------------------------------------------------------- */

static const qni_dmc_leaf *leaf_at(const qni_dmc_row *row, int32_t x) {
    int32_t low = 0, high = row->leaf_count;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (row->leaves[middle].x < x)
            low = middle + 1;
        else
            high = middle;
    }
    return row->leaves + low;
}

/* The quad of a crossed inner edge: its leaf's first, and those before it in the leaf. */
static int64_t quad_of_edge(const qni_dmc *dmc, const int32_t point[3], int axis) {
    const qni_field *field = &dmc->field;
    const int32_t leaf[3] = {point[0] / QNI_LEAF, point[1] / QNI_LEAF, point[2] / QNI_LEAF};
    const qni_dmc_row *row = dmc->rows + qni_field_find_row(field, leaf[1], leaf[2]);
    const qni_leaf_extent extent = qni_leaf_extent_of(field, leaf);
    double tile[QNI_TILE][QNI_TILE][QNI_TILE];
    uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES];
    qni_leaf_masks masks;
    qni_field_load_tile(field, leaf, tile);
    for (int z = 0; z < QNI_LEAF_SAMPLES; ++z)
        for (int y = 0; y < QNI_LEAF_SAMPLES; ++y) {
            unsigned bits = 0;
            for (int x = 0; x < QNI_LEAF_SAMPLES; ++x)
                bits |= (unsigned)(tile[z + 1][y + 1][x + 1] >= 0) << x;
            signs[z][y] = (uint16_t)bits;
        }
    qni_leaf_masks_init((const uint16_t(*)[9])signs, &masks);
    const int z = point[2] % QNI_LEAF, bit = point[0] % QNI_LEAF + 8 * (point[1] % QNI_LEAF);
    int64_t quad = row->quad_base + leaf_at(row, leaf[0])->quad_base;
    for (int a = 0; a <= axis; ++a)
        for (int s = 0; s < (a < axis ? QNI_LEAF : z); ++s)
            quad += qni_count_bits(qni_quads_of_slice(&masks, &extent, a, s));
    const uint64_t slice = qni_quads_of_slice(&masks, &extent, axis, z);
    return quad + qni_bits_below(slice, bit);
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* One vertex of a fan: half of the way from where the polygon's vertex would be to the middle of
 * the fan's crossings, on the surface; at last where the fan's first lattice edge meets it. Returns
 * whether that was needed. */
static bool place_fan(const qni_repair_job *job, const int32_t cell[3], const qni_rim_fans *fans,
                      int fan, const double d[8], const double middle[3], int64_t vertex) {
    const int64_t cell_64[3] = {cell[0], cell[1], cell[2]};
    const int count = fans->first[fan + 1] - fans->first[fan];
    double first[3], local[3] = {0, 0, 0};
    for (int n = count - 1; n >= 0; --n) {
        qni_edge_crossing(d, fans->edge[fans->first[fan] + n], first);
        for (int a = 0; a < 3; ++a)
            local[a] += first[a] / count;
    }
    for (int a = 0; a < 3; ++a)
        local[a] = 0.5 * (local[a] + middle[a]);
    const bool found = qni_bring_to_surface(d, 0.5, local);
    qni_repair_place(job, cell_64, found ? local : first, vertex);
    return !found;
}

/* Gives the quads of a fan their new vertex, and that a halfedge: the one that starts at it and has
 * no quad across. */
static void move_fan(const qni_repair_job *job, const int32_t cell[3], const qni_rim_fans *fans,
                     int fan, uint32_t from, uint32_t to) {
    qn_mesh *mesh = job->mesh;
    for (int n = fans->first[fan]; n < fans->first[fan + 1]; ++n) {
        int32_t point[3];
        qni_edge_point(cell, fans->edge[n], point);
        const int64_t quad = quad_of_edge(job->dmc, point, qni_edge_axis(fans->edge[n]));
        for (int k = 0; k < 4; ++k) {
            if (mesh->quads[4 * quad + k] != from)
                continue;
            mesh->quads[4 * quad + k] = to;
            if (mesh->twins && mesh->twins[4 * quad + k] == QN_NO_HALFEDGE)
                mesh->vertex_halfedges[to] = (uint32_t)(4 * quad + k);
        }
    }
}

static int64_t split_vertex(const qni_repair_job *job, const qni_rim_vertex *rim, uint32_t vertex,
                            uint32_t first_new) {
    const int64_t cell[3] = {rim->cell[0], rim->cell[1], rim->cell[2]};
    qni_rim_fans fans;
    qni_polygon polygon;
    double d[8];
    int64_t left = 0;
    qni_rim_find_fans(&job->dmc->field, rim->cell, rim->entry, rim->polygon, &fans);
    qni_field_load_cell(&job->dmc->field, cell, d);
    qni_polygon_init(&polygon, d, qni_entry_edges(rim->entry, rim->polygon),
                     qni_entry_next_code(rim->entry));
    for (int fan = 0; fan < fans.count; ++fan) {
        const uint32_t own = fan == 0 ? vertex : first_new + (uint32_t)fan - 1;
        left += place_fan(job, rim->cell, &fans, fan, d, polygon.middle, own);
        move_fan(job, rim->cell, &fans, fan, vertex, own);
    }
    return left;
}

int64_t qni_rim_apply(qni_dmc *dmc, const qni_frame *frame, bool reverse, qn_mesh *mesh) {
    const qni_repair_job job = {dmc, frame, mesh, reverse};
    int64_t next = mesh->vertex_count - dmc->rim_count, left = 0;
    for (int64_t r = 0; r < dmc->row_count; ++r) {
        const qni_dmc_row *row = dmc->rows + r;
        for (int32_t n = 0; n < row->rim_count; ++n) {
            const qni_rim_vertex *rim = row->rims + n;
            left +=
                split_vertex(&job, rim, (uint32_t)(row->vertex_base + rim->vertex), (uint32_t)next);
            next += rim->fans - 1;
        }
    }
    return left;
}
