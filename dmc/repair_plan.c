// SPDX-License-Identifier: MIT
/* Finding doubled edges from the cells, and planning which quads are split, before any mesh exists.
 */
#include "dmc/repair.h"
#include "dmc/doubled_hd.h"
#include "dmc/rim.h"
#include "dmc/ring_hd.h"
#include "core/context.h"
#include "core/sort.h"
#include "core/status.h"

#include <string.h>

bool qni_face_is_doubled(const qni_field *field, const int64_t cell[3], int axis, int entry,
                         qni_doubled_face *face) {
    if (cell[axis] == 0 || !qni_one_polygon_has_face(entry, 2 * axis))
        return false;
    int64_t below[3] = {cell[0], cell[1], cell[2]};
    double d[8];
    --below[axis];
    qni_field_load_cell(field, below, d);
    if (!qni_one_polygon_has_face(qni_cell_resolve(d, qni_case_of_values(d)).entry, 2 * axis + 1))
        return false;
    for (int a = 0; a < 3; ++a)
        face->cell[a] = (int32_t)cell[a];
    face->axis = (uint8_t)axis;
    face->first_cut = (uint8_t)qni_face_first_cut(d, 2 * axis + 1);
    return qni_doubled_has_quads(field->cells, face->cell, axis, face->first_cut);
}

/* ---- the plan -------------------------------------------------------------------------------- */

/* What is to be done with a quad: points on one of its sides, or a corner cut off. Sorted by the
 * quad's place in the mesh. */
typedef struct mark {
    int64_t row;
    int32_t point[3];
    uint8_t axis, is_cut;
    uint8_t place; /* ring side of points, ring place of a cut */
    uint8_t cut_edge, cut_side[2];
    int64_t value; /* the first of the points; the tunnel's end */
} mark;

static int compare_numbers(int64_t a, int64_t b) {
    return a < b ? -1 : a > b;
}

/* Row, leaf, axis, then z, y, x: the order in which emission writes quads. */
static int compare_marks(const void *first, const void *second) {
    const mark *a = first, *b = second;
    int order = compare_numbers(a->row, b->row);
    order = order ? order : compare_numbers(a->point[0] / QNI_LEAF, b->point[0] / QNI_LEAF);
    order = order ? order : compare_numbers(a->axis, b->axis);
    for (int axis = 2; axis >= 0; --axis)
        order = order ? order : compare_numbers(a->point[axis], b->point[axis]);
    order = order ? order : compare_numbers(a->is_cut, b->is_cut);
    return order ? order : compare_numbers(a->place, b->place);
}

static int64_t row_of_point(const qni_field *field, const int32_t point[3]) {
    return qni_field_find_row(field, point[1] / QNI_LEAF, point[2] / QNI_LEAF);
}

static int64_t mark_sides(const qni_dmc *dmc, mark *marks) {
    const qni_field *field = &dmc->field;
    int64_t count = 0;
    for (int64_t i = 0; i < dmc->repair->face_count; ++i) {
        const qni_doubled_face *face = dmc->repair->faces + i;
        for (int n = 0; n < 4; ++n) {
            const int edge = qni_doubled_edge(face->axis, face->first_cut, n);
            mark m = {.axis = (uint8_t)qni_edge_axis(edge), .value = 4 * i + 2 * (n / 2)};
            qni_edge_point(face->cell, edge, m.point);
            if (!qni_edge_is_inner(field, m.point, m.axis))
                continue;
            m.row = row_of_point(field, m.point);
            m.place = (uint8_t)qni_ring_side(edge, 2 * face->axis);
            marks[count++] = m;
        }
    }
    return count;
}

static int64_t mark_cuts(const qni_dmc *dmc, mark *marks) {
    int64_t count = 0;
    for (int64_t i = 0; i < 2 * dmc->repair->tunnel_count; ++i) {
        const qni_tunnel_end *end = dmc->repair->ends + i;
        for (int n = 0; n < end->count; ++n) {
            const int edge = end->edge[n], before = n == 0 ? end->count - 1 : n - 1;
            const int next = end->edge[n + 1 < end->count ? n + 1 : 0];
            mark m = {.axis = (uint8_t)qni_edge_axis(edge),
                      .is_cut = 1,
                      .cut_edge = (uint8_t)n,
                      .value = i};
            qni_edge_point(dmc->repair->tunnels[i / 2].cell, edge, m.point);
            m.row = row_of_point(&dmc->field, m.point);
            m.place = (uint8_t)qni_ring_place(edge);
            const bool next_after = qni_ring_side(edge, qni_face_of_edges(edge, next)) == m.place;
            m.cut_side[0] = (uint8_t)(next_after ? before : n);
            m.cut_side[1] = (uint8_t)(next_after ? n : before);
            marks[count++] = m;
        }
    }
    return count;
}

static bool same_edge(const mark *m, const qni_quad_split *split) {
    return m->axis == split->axis && memcmp(m->point, split->point, sizeof m->point) == 0;
}

static void start_split(qni_repair *repair, const mark *m) {
    qni_quad_split *split = repair->splits + repair->split_count++;
    *split = (qni_quad_split){.row = m->row, .axis = m->axis, .quads = 2};
    memcpy(split->point, m->point, sizeof split->point);
    for (int n = 0; n < 4; ++n) {
        split->points[n] = QNI_NO_POINTS;
        split->cut_end[n] = QNI_NOT_CUT;
    }
}

static void list_splits(qni_repair *repair, const mark *marks, int64_t mark_count) {
    for (int64_t n = 0; n < mark_count; ++n) {
        const mark *m = marks + n;
        if (repair->split_count == 0 || !same_edge(m, repair->splits + repair->split_count - 1))
            start_split(repair, m);
        qni_quad_split *split = repair->splits + repair->split_count - 1;
        ++split->quads;
        if (!m->is_cut) {
            split->points[m->place] = m->value;
            continue;
        }
        split->cut_end[m->place] = (int32_t)m->value;
        split->cut_edge[m->place] = m->cut_edge;
        memcpy(split->cut_side[m->place], m->cut_side, sizeof m->cut_side);
        repair->ends[m->value].split[m->cut_edge] = repair->split_count - 1;
    }
    for (int64_t n = 0; n < repair->split_count; ++n) {
        repair->splits[n].first_extra = repair->split_quads;
        repair->split_quads += repair->splits[n].quads - 1;
    }
}

/* The edges of a tunnel's polygon in their order. */
static void list_end(const qni_tunnel_cell *tunnel, int polygon, qni_tunnel_end *end) {
    const unsigned edges = qni_entry_edges(tunnel->entry, polygon);
    const uint64_t next = qni_entry_next_code(tunnel->entry);
    int edge = 0;
    while (!(edges >> edge & 1))
        ++edge;
    for (end->count = 0; end->count == 0 || edge != end->edge[0];
         edge = (int)(next >> (4 * edge) & 15))
        end->edge[end->count++] = (uint8_t)edge;
}

bool qni_tunnel_has_quads(const qni_field *field, const qni_tunnel_cell *tunnel) {
    for (int n = 0; n < 2; ++n) {
        qni_tunnel_end end;
        list_end(tunnel, tunnel->polygon[n], &end);
        for (int k = 0; k < end.count; ++k) {
            int32_t point[3];
            qni_edge_point(tunnel->cell, end.edge[k], point);
            if (!qni_edge_is_inner(field, point, qni_edge_axis(end.edge[k])))
                return false;
        }
    }
    return true;
}

static qn_status gather_tunnels(qni_dmc *dmc, qn_error *error) {
    qni_repair *repair = dmc->repair;
    const int64_t count = repair->tunnel_count = dmc->tunnel_count;
    if (count == 0)
        return QN_OK;
    repair->tunnels = qni_alloc(dmc->context, count, sizeof *repair->tunnels);
    repair->ends = qni_alloc(dmc->context, 2 * count, sizeof *repair->ends);
    repair->tubes = qni_alloc(dmc->context, count, sizeof *repair->tubes);
    if (!repair->tunnels || !repair->ends || !repair->tubes)
        return qni_fail_memory(error, "the tunnels");
    int64_t at = 0;
    for (int64_t r = 0; r < dmc->row_count; ++r) {
        const qni_dmc_row *row = dmc->rows + r;
        if (row->tunnel_count)
            memcpy(repair->tunnels + at, row->tunnels,
                   (size_t)row->tunnel_count * sizeof *row->tunnels);
        at += row->tunnel_count;
    }
    int64_t quads = 0;
    for (int64_t i = 0; i < 2 * count; ++i) {
        qni_tunnel_end *end = repair->ends + i;
        list_end(repair->tunnels + i / 2, repair->tunnels[i / 2].polygon[i % 2], end);
        end->first_point = repair->tunnel_points;
        repair->tunnel_points += 2 * end->count - 1;
        if (i % 2 == 0)
            repair->tubes[i / 2].first_quad = quads;
        quads += end->count;
    }
    repair->extra_quads = quads;
    return QN_OK;
}

static qn_status gather_faces(qni_dmc *dmc, qn_error *error) {
    qni_repair *repair = dmc->repair;
    for (int64_t r = 0; r < dmc->row_count; ++r)
        repair->face_count += dmc->rows[r].doubled_count;
    repair->faces = qni_alloc(dmc->context, repair->face_count, sizeof *repair->faces);
    if (!repair->faces)
        return qni_fail_memory(error, "the doubled edges");
    int64_t at = 0;
    for (int64_t r = 0; r < dmc->row_count; ++r) {
        const qni_dmc_row *row = dmc->rows + r;
        if (row->doubled_count)
            memcpy(repair->faces + at, row->doubled,
                   (size_t)row->doubled_count * sizeof *row->doubled);
        at += row->doubled_count;
    }
    return QN_OK;
}

qn_status qni_repair_plan(qni_dmc *dmc, qn_error *error) {
    dmc->repair = qni_alloc_zero(dmc->context, 1, sizeof *dmc->repair);
    if (!dmc->repair)
        return qni_fail_memory(error, "the doubled edges");
    if (dmc->with_repair)
        QN_TRY(gather_faces(dmc, error));
    QN_TRY(gather_tunnels(dmc, error));
    qni_repair *repair = dmc->repair;
    int64_t capacity = 4 * repair->face_count;
    for (int64_t i = 0; i < 2 * repair->tunnel_count; ++i)
        capacity += repair->ends[i].count;
    mark *marks = qni_alloc(dmc->context, capacity, sizeof *marks);
    repair->splits = qni_alloc(dmc->context, capacity, sizeof *repair->splits);
    repair->split_capacity = capacity;
    if (!marks || !repair->splits) {
        qni_free(dmc->context, marks, capacity, sizeof *marks);
        return qni_fail_memory(error, "the quads to be split");
    }
    int64_t count = mark_sides(dmc, marks);
    count += mark_cuts(dmc, marks + count);
    const bool sorted = qni_sort(dmc->context, marks, count, sizeof *marks, compare_marks);
    if (sorted)
        list_splits(repair, marks, count);
    qni_free(dmc->context, marks, capacity, sizeof *marks);
    if (!sorted)
        return qni_fail_memory(error, "the quads to be split");
    repair->extra_vertices = 4 * repair->face_count + repair->split_count + repair->tunnel_points;
    repair->extra_quads += repair->split_quads;
    return QN_OK;
}

int64_t qni_repair_row_split(const qni_repair *repair, int64_t row) {
    int64_t low = 0, high = repair->split_count;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (repair->splits[middle].row < row)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

void qni_repair_free(qni_dmc *dmc) {
    if (!dmc->repair)
        return;
    qni_repair *repair = dmc->repair;
    qni_free(dmc->context, repair->splits, repair->split_capacity, sizeof *repair->splits);
    qni_free(dmc->context, repair->tunnels, repair->tunnel_count, sizeof *repair->tunnels);
    qni_free(dmc->context, repair->ends, 2 * repair->tunnel_count, sizeof *repair->ends);
    qni_free(dmc->context, repair->tubes, repair->tunnel_count, sizeof *repair->tubes);
    qni_free(dmc->context, repair->faces, repair->face_count, sizeof *repair->faces);
    qni_free(dmc->context, repair, 1, sizeof *repair);
    dmc->repair = NULL;
}
