// SPDX-License-Identifier: MIT
/* The reference: exact decider, segments chained face by face, polygons as sets of edges. */
#include "lib/reference_dmc.h"

#include <math.h>

/* ---- exact comparison ------------------------------------------------------------------------ */

typedef struct exact_product { /* mantissa * 2^exponent */
    unsigned __int128 mantissa;
    int exponent;
} exact_product;

static exact_product multiply(double a, double b) {
    int ea, eb;
    uint64_t ma = (uint64_t)ldexp(frexp(a, &ea), 53), mb = (uint64_t)ldexp(frexp(b, &eb), 53);
    exact_product product = {(unsigned __int128)ma * mb, ea + eb};
    while (product.mantissa && !(product.mantissa >> 127))
        product.mantissa <<= 1, product.exponent -= 1;
    return product;
}

int test_compare_products(double p1, double p2, double n1, double n2) {
    exact_product p = multiply(p1, p2), n = multiply(n1, n2);
    if (p.mantissa == 0 || n.mantissa == 0)
        return (p.mantissa != 0) - (n.mantissa != 0);
    if (p.exponent != n.exponent)
        return p.exponent > n.exponent ? 1 : -1;
    return (p.mantissa > n.mantissa) - (p.mantissa < n.mantissa);
}

/* ---- edges ----------------------------------------------------------------------------------- */

test_edge test_cell_edge(const int64_t cell[3], int local_edge) {
    test_edge edge = {{cell[0], cell[1], cell[2]}, local_edge / 4};
    edge.sample[(edge.axis + 1) % 3] += local_edge & 1;
    edge.sample[(edge.axis + 2) % 3] += local_edge >> 1 & 1;
    return edge;
}

int test_local_edge(const int64_t cell[3], test_edge edge) {
    int s = (edge.axis + 1) % 3, t = (edge.axis + 2) % 3;
    return (int)(4 * edge.axis + (edge.sample[s] - cell[s]) + 2 * (edge.sample[t] - cell[t]));
}

static bool above(const test_field *field, const int64_t s[3]) {
    return test_field_above(field, s[0], s[1], s[2]);
}

bool test_edge_crossed(const test_field *field, test_edge edge) {
    int64_t end[3] = {edge.sample[0], edge.sample[1], edge.sample[2]};
    end[edge.axis] += 1;
    return above(field, edge.sample) != above(field, end);
}

bool test_edge_is_inner(const test_field *field, test_edge edge) {
    for (int a = 0; a < 3; ++a) {
        int64_t first = test_field_first_cell(field), end = test_field_end_cell(field, a);
        int64_t lowest = a == edge.axis ? first : first + 1;
        if (edge.sample[a] < lowest || edge.sample[a] >= end)
            return false;
    }
    return true;
}

/* ---- faces ----------------------------------------------------------------------------------- */

/* Corner c of a face: x + 2 y along its two axes in rising order. */
static void face_corner(test_face face, int corner, int64_t sample[3]) {
    int u = face.axis == 0 ? 1 : 0, v = face.axis == 2 ? 1 : 2;
    memcpy(sample, face.sample, 3 * sizeof *sample);
    sample[u] += corner & 1;
    sample[v] += corner >> 1;
}

test_face_state test_face_decide(const test_field *field, test_face face, bool *tied_out) {
    double size[4];
    bool bit[4];
    for (int c = 0; c < 4; ++c) {
        int64_t s[3];
        face_corner(face, c, s);
        bit[c] = above(field, s);
        size[c] = fabs(test_field_distance(field, s[0], s[1], s[2]));
    }
    if (tied_out)
        *tied_out = false;
    if (bit[0] == bit[1] || bit[0] == bit[2] || bit[0] != bit[3])
        return TEST_FACE_PLAIN;
    int order = test_compare_products(size[0], size[3], size[1], size[2]);
    if (tied_out)
        *tied_out = order == 0;
    if (!bit[0])
        order = -order;
    return order >= 0 ? TEST_FACE_POSITIVE : TEST_FACE_NEGATIVE;
}

static bool same_edge(test_edge a, test_edge b) {
    return a.axis == b.axis && memcmp(a.sample, b.sample, sizeof a.sample) == 0;
}

/* The four edges of a face and, for each, the two corners it joins. */
static const int face_edge_corners[4][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}};

static test_edge face_edge(test_face face, int e) {
    int u = face.axis == 0 ? 1 : 0, v = face.axis == 2 ? 1 : 2;
    test_edge edge = {{0, 0, 0}, e < 2 ? u : v};
    face_corner(face, face_edge_corners[e][0], edge.sample);
    return edge;
}

static int face_edge_index(test_face face, test_edge edge) {
    for (int e = 0; e < 4; ++e)
        if (same_edge(face_edge(face, e), edge))
            return e;
    fail_msg("an edge that is not of the face");
    return -1;
}

/* Four crossings: a segment cuts off one corner. Corners 0 and 3 are cut off when they are not
 * joined. */
static int partner_of_four(const test_field *field, test_face face, int e) {
    int64_t s[3];
    face_corner(face, 0, s);
    bool joined_03 = above(field, s) == (test_face_decide(field, face, NULL) == TEST_FACE_POSITIVE);
    static const int cut_03[4] = {2, 3, 0,
                                  1}; /* round corner 0: edges 0, 2; round corner 3: 1, 3 */
    static const int cut_12[4] = {3, 2, 1,
                                  0}; /* round corner 1: edges 0, 3; round corner 2: 1, 2 */
    return joined_03 ? cut_12[e] : cut_03[e];
}

test_edge test_face_partner(const test_field *field, test_face face, test_edge edge) {
    int e = face_edge_index(face, edge);
    if (test_face_decide(field, face, NULL) != TEST_FACE_PLAIN)
        return face_edge(face, partner_of_four(field, face, e));
    for (int other = 0; other < 4; ++other)
        if (other != e && test_edge_crossed(field, face_edge(face, other)))
            return face_edge(face, other);
    fail_msg("a face with a single crossing");
    return edge;
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* Faces of a cell: 2 axis + (1 at the high end). */
static test_face cell_face(const int64_t cell[3], int f) {
    test_face face = {{cell[0], cell[1], cell[2]}, f / 2};
    face.sample[face.axis] += f & 1;
    return face;
}

/* The two faces of a cell that hold a local edge. */
static void edge_faces(int local_edge, int faces[2]) {
    int axis = local_edge / 4;
    faces[0] = 2 * ((axis + 1) % 3) + (local_edge & 1);
    faces[1] = 2 * ((axis + 2) % 3) + (local_edge >> 1 & 1);
}

/* All edges that segments join to the first one. */
static uint16_t walk_polygon(const test_field *field, const int64_t cell[3], int start) {
    uint16_t polygon = 0;
    int stack[2 * TEST_CELL_EDGES + 1], depth = 0;
    stack[depth++] = start;
    while (depth > 0) {
        int edge = stack[--depth], faces[2];
        if (polygon >> edge & 1)
            continue;
        polygon = (uint16_t)(polygon | 1 << edge);
        edge_faces(edge, faces);
        for (int f = 0; f < 2; ++f)
            stack[depth++] =
                test_local_edge(cell, test_face_partner(field, cell_face(cell, faces[f]),
                                                        test_cell_edge(cell, edge)));
    }
    return polygon;
}

int test_cell_polygons(const test_field *field, const int64_t cell[3], uint16_t polygons[4]) {
    int count = 0;
    uint16_t done = 0;
    for (int e = 0; e < TEST_CELL_EDGES; ++e) {
        if (done >> e & 1 || !test_edge_crossed(field, test_cell_edge(cell, e)))
            continue;
        assert_true(count < 4);
        polygons[count] = walk_polygon(field, cell, e);
        done |= polygons[count++];
    }
    return count;
}

/* ---- the whole field ------------------------------------------------------------------------- */

static bool cell_active(const test_field *field, const int64_t cell[3]) {
    bool first = above(field, cell);
    for (int c = 1; c < 8; ++c)
        if (test_field_above(field, cell[0] + (c & 1), cell[1] + (c >> 1 & 1),
                             cell[2] + (c >> 2)) != first)
            return true;
    return false;
}

static void add_polygon(test_reference *reference, int64_t *capacity, const int64_t cell[3],
                        uint16_t edges) {
    if (reference->polygon_count == *capacity) {
        *capacity = *capacity ? 2 * *capacity : 256;
        reference->polygons =
            realloc(reference->polygons, (size_t)*capacity * sizeof *reference->polygons);
        assert_non_null(reference->polygons);
    }
    test_polygon polygon = {{cell[0], cell[1], cell[2]}, edges};
    reference->polygons[reference->polygon_count++] = polygon;
}

/* An edge is counted with the cell that starts at its sample. (Those at the high ends are not
 * inner.) */
static void count_edges(const test_field *field, const int64_t cell[3], test_reference *reference) {
    for (int a = 0; a < 3; ++a) {
        test_edge edge = test_cell_edge(cell, 4 * a);
        reference->quad_count += test_edge_is_inner(field, edge) && test_edge_crossed(field, edge);
    }
}

/* A face is counted with the cell behind it, at the high ends with its only cell. */
static void count_faces(const test_field *field, const int64_t cell[3], test_reference *reference) {
    for (int f = 0; f < 6; ++f) {
        const int a = f / 2;
        const bool first = cell[a] == test_field_first_cell(field);
        const bool last = cell[a] == test_field_end_cell(field, a) - 1;
        bool tied;
        if ((f & 1 && !last) ||
            test_face_decide(field, cell_face(cell, f), &tied) == TEST_FACE_PLAIN)
            continue;
        reference->ambiguous_faces += 1;
        reference->tied_faces += tied;
        reference->ambiguous_inner_faces += f & 1 ? 0 : !first;
    }
}

static void add_cell(const test_field *field, const int64_t cell[3], test_reference *reference,
                     int64_t *capacity) {
    if (!cell_active(field, cell))
        return;
    uint16_t polygons[4];
    int count = test_cell_polygons(field, cell, polygons);
    for (int p = 0; p < count; ++p)
        add_polygon(reference, capacity, cell, polygons[p]);
    reference->active_cells += 1;
    reference->multiple_cells += count > 1;
    count_edges(field, cell, reference);
    count_faces(field, cell, reference);
}

static void add_leaf(const test_field *field, const int64_t leaf[3], test_reference *reference,
                     int64_t *capacity) {
    const int64_t first = test_field_first_cell(field), before = reference->active_cells;
    for (int c = 0; c < 512; ++c) {
        const int64_t cell[3] = {first + 8 * leaf[0] + (c & 7), first + 8 * leaf[1] + (c >> 3 & 7),
                                 first + 8 * leaf[2] + (c >> 6)};
        if (cell[0] < test_field_end_cell(field, 0) && cell[1] < test_field_end_cell(field, 1) &&
            cell[2] < test_field_end_cell(field, 2))
            add_cell(field, cell, reference, capacity);
    }
    reference->active_leaves += reference->active_cells > before;
}

test_reference test_reference_make(const test_field *field) {
    test_reference reference;
    memset(&reference, 0, sizeof reference);
    int64_t capacity = 0, cells[3];
    reference.cell_count = 1;
    for (int a = 0; a < 3; ++a) {
        cells[a] = test_field_end_cell(field, a) - test_field_first_cell(field);
        reference.cell_count *= cells[a];
    }
    for (int64_t z = 0; z < (cells[2] + 7) / 8; ++z)
        for (int64_t y = 0; y < (cells[1] + 7) / 8; ++y)
            for (int64_t x = 0; x < (cells[0] + 7) / 8; ++x) {
                const int64_t leaf[3] = {x, y, z};
                add_leaf(field, leaf, &reference, &capacity);
            }
    return reference;
}

void test_reference_free(test_reference *reference) {
    free(reference->polygons);
    reference->polygons = NULL;
}
