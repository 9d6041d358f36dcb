// SPDX-License-Identifier: MIT
/* A second, slow and plain dual marching cubes, written from the definition alone [DMC21 section
 * 3]: which polygons a cell has, which lattice edges carry a quad. It gives topology, no positions.
 */
#ifndef TEST_REFERENCE_DMC_H
#define TEST_REFERENCE_DMC_H

#include "lib/test_volume.h"

/* An edge of the lattice: from a sample one step along an axis. */
typedef struct test_edge {
    int64_t sample[3];
    int axis;
} test_edge;

/* Edges of a cell: local edge 4 axis + s + 2 t, where s and t tell whether the edge lies at the
 * high end of axis + 1 and axis + 2 (cyclic). */
enum { TEST_CELL_EDGES = 12 };
test_edge test_cell_edge(const int64_t cell[3], int local_edge);
int test_local_edge(const int64_t cell[3], test_edge edge);
bool test_edge_crossed(const test_field *field, test_edge edge);
/* True when the four cells round the edge exist. */
bool test_edge_is_inner(const test_field *field, test_edge edge);

/* A face of the lattice: the unit square from a sample along the two axes other than `axis`. */
typedef struct test_face {
    int64_t sample[3];
    int axis;
} test_face;

typedef enum test_face_state {
    TEST_FACE_PLAIN,    /* no crossing, or two */
    TEST_FACE_POSITIVE, /* four crossings, the corners above are joined */
    TEST_FACE_NEGATIVE  /* four crossings, the corners below are joined */
} test_face_state;

/* The asymptotic decider in exact arithmetic; *tied_out (or NULL) when both pairings are equally
 * right. */
test_face_state test_face_decide(const test_field *field, test_face face, bool *tied_out);
/* The other end of the face's segment that starts at a crossed edge of the face. */
test_edge test_face_partner(const test_field *field, test_face face, test_edge edge);

/* The sign of p1 p2 - n1 n2 for numbers that are not negative; exact. */
int test_compare_products(double p1, double p2, double n1, double n2);

/* The polygons of a cell as sets of local edges, at most four. */
int test_cell_polygons(const test_field *field, const int64_t cell[3], uint16_t polygons[4]);

typedef struct test_polygon {
    int64_t cell[3];
    uint16_t edges;
} test_polygon;

/* Everything the surfacer must find. Polygons come in the documented order of cells: leaf, then
 * cell in the leaf; the order within a cell means nothing. */
typedef struct test_reference {
    test_polygon *polygons;
    int64_t polygon_count;
    int64_t quad_count; /* inner crossed edges */
    int64_t cell_count, active_cells, active_leaves, multiple_cells;
    int64_t ambiguous_faces, tied_faces; /* each lattice face counted once */
    int64_t ambiguous_inner_faces;       /* those with a cell on both sides */
} test_reference;

test_reference test_reference_make(const test_field *field);
void test_reference_free(test_reference *reference);

#endif
