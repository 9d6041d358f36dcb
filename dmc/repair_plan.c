// SPDX-License-Identifier: MIT
/* Finding doubled edges from the cells, and planning which quads are split, before any mesh exists. */
#include "dmc/repair.h"
#include "dmc/cell_hd.h"
#include "dmc/ring_hd.h"
#include "core/context.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

static int cell_case(const double d[8]) {
    int bits = 0;
    for (int c = 0; c < 8; ++c)
        bits |= (d[c] >= 0) << c;
    return bits;
}

static void load_cell(const qni_field *field, const int64_t at[3], double d[8]) {
    for (int c = 0; c < 8; ++c)
        d[c] = qni_field_value(field, at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2));
}

static bool one_polygon_has_face(int entry, int face) {
    const int first = qni_entry_polygon_of_edge(entry, qni_face_edge(face, 0));
    for (int n = 1; n < 4; ++n)
        if (qni_entry_polygon_of_edge(entry, qni_face_edge(face, n)) != first)
            return false;
    return true;
}

/* An edge has a quad when there are four cells round it. */
static bool is_inner(const qni_field *field, const int32_t point[3], int axis) {
    for (int a = 0; a < 3; ++a)
        if (a != axis && (point[a] < 1 || point[a] >= field->cells[a]))
            return false;
    return true;
}

static void edge_point(const int32_t cell[3], int edge, int32_t point[3]) {
    const int start = qni_edge_start_corner(edge);
    for (int a = 0; a < 3; ++a)
        point[a] = cell[a] + (start >> a & 1);
}

static bool segment_has_quad(const qni_field *field, const qni_doubled_face *face, int segment) {
    for (int n = 0; n < 2; ++n) {
        const int edge = qni_face_edge(2 * face->axis, face->first_cut + 2 * segment + 3 + n);
        int32_t point[3];
        edge_point(face->cell, edge, point);
        if (is_inner(field, point, qni_edge_axis(edge)))
            return true;
    }
    return false;
}

bool qni_face_is_doubled(const qni_field *field, const int64_t cell[3], int axis, int entry, qni_doubled_face *face) {
    if (cell[axis] == 0 || !one_polygon_has_face(entry, 2 * axis))
        return false;
    int64_t below[3] = {cell[0], cell[1], cell[2]};
    double d[8];
    --below[axis];
    load_cell(field, below, d);
    if (!one_polygon_has_face(qni_cell_resolve(d, cell_case(d)).entry, 2 * axis + 1))
        return false;
    /* The face's corners seen from the lower cell are the same in the lattice's orientation. */
    double v[4];
    for (int n = 0; n < 4; ++n)
        v[n] = d[qni_face_corner(2 * axis + 1, n)];
    const int above = v[0] >= 0 ? 0 : 1;
    const int joined =
        qni_face_joins_above(qni_face_saddle_sign(v[above], v[above + 2], v[1 - above], v[3 - above]));
    for (int a = 0; a < 3; ++a)
        face->cell[a] = (int32_t)cell[a];
    face->axis = (uint8_t)axis;
    face->first_cut = (uint8_t)(joined ? 1 - above : above);
    return segment_has_quad(field, face, 0) && segment_has_quad(field, face, 1);
}

/* ---- the plan -------------------------------------------------------------------------------- */

/* One side of a quad at a doubled edge; sorted by the quad's place in the mesh. */
typedef struct side {
    int64_t row;
    int32_t point[3];
    uint8_t axis, ring_side;
    int64_t points;
} side;

static int compare_numbers(int64_t a, int64_t b) {
    return a < b ? -1 : a > b;
}

/* Row, leaf, axis, then z, y, x: the order in which emission writes quads. */
static int compare_sides(const void *first, const void *second) {
    const side *a = first, *b = second;
    int order = compare_numbers(a->row, b->row);
    order = order ? order : compare_numbers(a->point[0] / QNI_LEAF, b->point[0] / QNI_LEAF);
    order = order ? order : compare_numbers(a->axis, b->axis);
    for (int axis = 2; axis >= 0; --axis)
        order = order ? order : compare_numbers(a->point[axis], b->point[axis]);
    return order ? order : compare_numbers(a->ring_side, b->ring_side);
}

static int64_t row_of_point(const qni_field *field, const int32_t point[3]) {
    return point[2] / QNI_LEAF * field->leaves[1] + point[1] / QNI_LEAF;
}

static int64_t list_sides(const qni_dmc *dmc, side *sides) {
    const qni_field *field = &dmc->field;
    int64_t count = 0;
    for (int64_t i = 0; i < dmc->repair->face_count; ++i) {
        const qni_doubled_face *face = dmc->repair->faces + i;
        for (int n = 0; n < 4; ++n) {
            const int edge = qni_face_edge(2 * face->axis, face->first_cut + 3 + n);
            side s = {.axis = (uint8_t)qni_edge_axis(edge), .points = 4 * i + 2 * (n / 2)};
            edge_point(face->cell, edge, s.point);
            if (!is_inner(field, s.point, s.axis))
                continue;
            s.row = row_of_point(field, s.point);
            s.ring_side = (uint8_t)qni_ring_side(edge, 2 * face->axis);
            sides[count++] = s;
        }
    }
    qsort(sides, (size_t)count, sizeof *sides, compare_sides);
    return count;
}

static bool same_edge(const side *s, const qni_quad_split *split) {
    return s->axis == split->axis && memcmp(s->point, split->point, sizeof s->point) == 0;
}

static void list_splits(qni_repair *repair, const side *sides, int64_t side_count) {
    for (int64_t n = 0; n < side_count; ++n) {
        qni_quad_split *split = repair->splits + repair->split_count - 1;
        if (repair->split_count == 0 || !same_edge(sides + n, split)) {
            ++split;
            ++repair->split_count;
            *split = (qni_quad_split){.row = sides[n].row, .axis = sides[n].axis, .quads = 2};
            memcpy(split->point, sides[n].point, sizeof split->point);
            for (int s = 0; s < 4; ++s)
                split->points[s] = QNI_NO_POINTS;
        }
        split->points[sides[n].ring_side] = sides[n].points;
        ++split->quads;
    }
    for (int64_t n = 0; n < repair->split_count; ++n) {
        repair->splits[n].first_extra = repair->extra_quads;
        repair->extra_quads += repair->splits[n].quads - 1;
    }
    repair->extra_vertices = 4 * repair->face_count + repair->split_count;
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
            memcpy(repair->faces + at, row->doubled, (size_t)row->doubled_count * sizeof *row->doubled);
        at += row->doubled_count;
    }
    return QN_OK;
}

qn_status qni_repair_plan(qni_dmc *dmc, qn_error *error) {
    dmc->repair = qni_alloc_zero(dmc->context, 1, sizeof *dmc->repair);
    if (!dmc->repair)
        return qni_fail_memory(error, "the doubled edges");
    QN_TRY(gather_faces(dmc, error));
    const int64_t capacity = 4 * dmc->repair->face_count;
    side *sides = qni_alloc(dmc->context, capacity, sizeof *sides);
    dmc->repair->splits = qni_alloc(dmc->context, capacity, sizeof *dmc->repair->splits);
    if (!sides || !dmc->repair->splits) {
        qni_free(dmc->context, sides, capacity, sizeof *sides);
        return qni_fail_memory(error, "the quads at doubled edges");
    }
    list_splits(dmc->repair, sides, list_sides(dmc, sides));
    qni_free(dmc->context, sides, capacity, sizeof *sides);
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
    qni_free(dmc->context, dmc->repair->splits, 4 * dmc->repair->face_count, sizeof *dmc->repair->splits);
    qni_free(dmc->context, dmc->repair->faces, dmc->repair->face_count, sizeof *dmc->repair->faces);
    qni_free(dmc->context, dmc->repair, 1, sizeof *dmc->repair);
    dmc->repair = NULL;
}
