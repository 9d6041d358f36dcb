// SPDX-License-Identifier: MIT
/* Matching a mesh with the reference: cells of vertices, edges of quads, polygons, segments. */
#include "lib/reference_match.h"

typedef struct matcher {
    const test_field *field;
    const test_reference *reference;
    qn_mesh_view mesh;
    test_match match;
    uint16_t *seen;     /* [vertex] local edges round which a quad of the vertex lies */
    int64_t *edge_quad; /* [sample, axis] 1 + the quad of a lattice edge; 0: none */
    bool mirrored;
} matcher;

static const test_polygon *polygon_of(const matcher *m, uint32_t vertex) {
    return &m->reference->polygons[vertex]; /* same cell, perhaps another polygon of it */
}

static int64_t edge_slot(const test_field *field, test_edge edge) {
    const int64_t *n = field->size; /* samples -1 .. n */
    return 3 * ((edge.sample[0] + 1) +
                (n[0] + 2) * ((edge.sample[1] + 1) + (n[1] + 2) * (edge.sample[2] + 1))) +
           edge.axis;
}

static double determinant(const double m[4][4]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* The four cells round an edge, counter-clockwise when its axis points at the viewer. */
static void cells_round(test_edge edge, int64_t cells[4][3]) {
    static const int back[4][2] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
    for (int k = 0; k < 4; ++k) {
        memcpy(cells[k], edge.sample, sizeof cells[k]);
        cells[k][(edge.axis + 1) % 3] -= back[k][0];
        cells[k][(edge.axis + 2) % 3] -= back[k][1];
    }
}

/* The edge that four cells may share: the axis on which they agree, the largest index on the
 * others. */
static bool shared_edge(const matcher *m, const uint32_t quad[4], test_edge *edge) {
    int axes = 0;
    memcpy(edge->sample, polygon_of(m, quad[0])->cell, sizeof edge->sample);
    for (int a = 0; a < 3; ++a) {
        bool agree = true;
        for (int k = 1; k < 4; ++k) {
            int64_t other = polygon_of(m, quad[k])->cell[a];
            agree &= other == polygon_of(m, quad[0])->cell[a];
            if (other > edge->sample[a])
                edge->sample[a] = other;
        }
        if (agree)
            edge->axis = a, axes += 1;
    }
    return axes == 1;
}

/* True when the quad goes round the edge the way that shows its front from outside of the solid. */
static bool winds_round(const matcher *m, const uint32_t quad[4], test_edge edge) {
    int64_t cells[4][3];
    cells_round(edge, cells);
    bool above = test_field_above(m->field, edge.sample[0], edge.sample[1], edge.sample[2]);
    bool inside_first = above == (m->field->inside == QN_INSIDE_ABOVE);
    bool forward = inside_first != m->mirrored;
    for (int turn = 0; turn < 4; ++turn) {
        int equal = 0;
        for (int k = 0; k < 4; ++k)
            equal += memcmp(polygon_of(m, quad[k])->cell, cells[(turn + (forward ? k : 4 - k)) % 4],
                            sizeof cells[0]) == 0;
        if (equal == 4)
            return true;
    }
    return false;
}

static void match_quad(matcher *m, int64_t q) {
    const uint32_t *quad = m->mesh.quads + 4 * q;
    test_edge edge;
    for (int k = 0; k < 4; ++k)
        if (quad[k] >= m->mesh.vertex_count)
            fail_msg("%s: quad %lld has vertex %u of %lld", m->field->name, (long long)q, quad[k],
                     (long long)m->mesh.vertex_count);
    if (!shared_edge(m, quad, &edge) || !test_edge_is_inner(m->field, edge) ||
        !test_edge_crossed(m->field, edge) || !winds_round(m, quad, edge))
        fail_msg(
            "%s: quad %lld (%u %u %u %u) does not wind outward round a crossed edge; its first "
            "cell is %lld %lld %lld",
            m->field->name, (long long)q, quad[0], quad[1], quad[2], quad[3],
            (long long)polygon_of(m, quad[0])->cell[0], (long long)polygon_of(m, quad[0])->cell[1],
            (long long)polygon_of(m, quad[0])->cell[2]);
    int64_t *slot = &m->edge_quad[edge_slot(m->field, edge)];
    if (*slot)
        fail_msg("%s: quads %lld and %lld lie round the same edge", m->field->name,
                 (long long)(*slot - 1), (long long)q);
    *slot = q + 1;
    m->match.quad_edge[q] = edge;
    for (int k = 0; k < 4; ++k) {
        int local = test_local_edge(polygon_of(m, quad[k])->cell, edge);
        m->seen[quad[k]] = (uint16_t)(m->seen[quad[k]] | 1 << local);
    }
}

static bool same_cell(const test_polygon *a, const test_polygon *b) {
    return memcmp(a->cell, b->cell, sizeof a->cell) == 0;
}

static uint16_t inner_edges(const test_field *field, const test_polygon *polygon) {
    uint16_t inner = 0;
    for (int e = 0; e < TEST_CELL_EDGES; ++e)
        if (polygon->edges >> e & 1 && test_edge_is_inner(field, test_cell_edge(polygon->cell, e)))
            inner = (uint16_t)(inner | 1 << e);
    return inner;
}

/* Gives each vertex of a cell its polygon: the one whose inner edges are those of the vertex's
 * quads. */
static void match_cell(matcher *m, int64_t first, int64_t end) {
    bool taken[4] = {false, false, false, false};
    for (int64_t v = first; v < end; ++v) {
        int64_t p = first;
        while (p < end && (taken[p - first] ||
                           inner_edges(m->field, &m->reference->polygons[p]) != m->seen[v]))
            ++p;
        if (p == end)
            fail_msg(
                "%s: vertex %lld of cell %lld %lld %lld joins edges %03x, which are no polygon "
                "of it",
                m->field->name, (long long)v, (long long)m->reference->polygons[v].cell[0],
                (long long)m->reference->polygons[v].cell[1],
                (long long)m->reference->polygons[v].cell[2], m->seen[v]);
        taken[p - first] = true;
        m->match.vertex_polygon[v] = p;
    }
}

/* The face between two cells that lie side by side. */
static test_face face_between(const test_polygon *a, const test_polygon *b) {
    test_face face = {{0, 0, 0}, 0};
    for (int axis = 0; axis < 3; ++axis) {
        face.sample[axis] = a->cell[axis] > b->cell[axis] ? a->cell[axis] : b->cell[axis];
        if (a->cell[axis] != b->cell[axis])
            face.axis = axis;
    }
    return face;
}

/* Side k of a quad is one end of a face segment; the quad at the other end must run along it
 * backward. */
static void match_side(matcher *m, int64_t q, int k) {
    uint32_t from = m->mesh.quads[4 * q + k], to = m->mesh.quads[4 * q + (k + 1) % 4];
    test_face face = face_between(polygon_of(m, from), polygon_of(m, to));
    test_edge other = test_face_partner(m->field, face, m->match.quad_edge[q]);
    int64_t twin = m->edge_quad[edge_slot(m->field, other)] - 1;
    if (twin < 0)
        return; /* the border of an open mesh; that inner edges have quads is known by now */
    const uint32_t *quad = m->mesh.quads + 4 * twin;
    int found = 0;
    for (int i = 0; i < 4; ++i)
        found += quad[i] == to && quad[(i + 1) % 4] == from;
    if (found != 1)
        fail_msg("%s: quad %lld side %d (%u to %u) has no twin in quad %lld", m->field->name,
                 (long long)q, k, from, to, (long long)twin);
    m->match.segments += twin > q;
}

test_match test_match_mesh(const test_field *field, const test_reference *reference,
                           const qn_mesh *mesh) {
    matcher m;
    memset(&m, 0, sizeof m);
    m.field = field, m.reference = reference, m.mesh = qn_mesh_get_view(mesh);
    m.mirrored = determinant(field->matrix) < 0;
    if (m.mesh.vertex_count != reference->polygon_count ||
        m.mesh.quad_count != reference->quad_count)
        fail_msg("%s: %lld vertices and %lld quads, the reference has %lld and %lld", field->name,
                 (long long)m.mesh.vertex_count, (long long)m.mesh.quad_count,
                 (long long)reference->polygon_count, (long long)reference->quad_count);
    const int64_t vertices = m.mesh.vertex_count, *n = field->size;
    m.match.vertex_polygon = test_alloc((size_t)vertices, sizeof *m.match.vertex_polygon);
    m.match.quad_edge = test_alloc((size_t)m.mesh.quad_count, sizeof *m.match.quad_edge);
    m.seen = test_alloc((size_t)vertices, sizeof *m.seen);
    m.edge_quad =
        test_alloc((size_t)(3 * (n[0] + 2) * (n[1] + 2) * (n[2] + 2)), sizeof *m.edge_quad);
    for (int64_t q = 0; q < m.mesh.quad_count; ++q)
        match_quad(&m, q);
    for (int64_t first = 0, end; first < vertices; first = end) {
        for (end = first + 1;
             end < vertices && same_cell(&reference->polygons[first], &reference->polygons[end]);)
            ++end;
        match_cell(&m, first, end);
    }
    for (int64_t q = 0; q < m.mesh.quad_count; ++q)
        for (int k = 0; k < 4; ++k)
            match_side(&m, q, k);
    free(m.seen);
    free(m.edge_quad);
    return m.match;
}

static void expect(const char *name, const char *what, int64_t found, int64_t expected) {
    if (found != expected)
        fail_msg("%s: the report says %lld %s, the reference %lld", name, (long long)found, what,
                 (long long)expected);
}

void test_match_report(const test_field *field, const test_reference *reference,
                       const qn_surface_report *report) {
    expect(field->name, "cells", report->cells, reference->cell_count);
    expect(field->name, "active leaves", report->active_leaves, reference->active_leaves);
    expect(field->name, "active cells", report->active_cells, reference->active_cells);
    expect(field->name, "cells with several polygons", report->multiple_cells,
           reference->multiple_cells);
    expect(field->name, "ambiguous faces", report->ambiguous_faces, reference->ambiguous_faces);
    expect(field->name, "tied faces", report->tied_faces, reference->tied_faces);
    expect(field->name, "vertices", report->vertices, reference->polygon_count);
    expect(field->name, "quads", report->quads, reference->quad_count);
}

void test_match_free(test_match *match) {
    free(match->vertex_polygon);
    free(match->quad_edge);
    match->vertex_polygon = NULL, match->quad_edge = NULL;
}
