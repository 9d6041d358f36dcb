// SPDX-License-Identifier: MIT
/* A field: samples as doubles, an iso-value, and which side is solid. What the reference, the
 * trilinear evaluator and the tested surfacer all start from, so that they can be compared. */
#ifndef TEST_VOLUME_H
#define TEST_VOLUME_H

#include "lib/support.h"

typedef struct test_field {
    int64_t size[3];
    double *values; /* [z][y][x], x fastest; owned */
    double iso;
    qn_inside inside;
    bool open;
    double matrix[4][4];     /* index to world */
    double inverse[3][4];    /* world to index; test_field_prepare() */
    double largest_distance; /* |value - iso| over the finite samples; test_field_prepare() */
    double minimum, maximum; /* of the finite samples; test_field_prepare() */
    char name[64];           /* for messages */
} test_field;

/* A field of zeros with the identity matrix. */
test_field test_field_make(int64_t nx, int64_t ny, int64_t nz);
void test_field_free(test_field *field);
/* To be called when values, iso or matrix have changed. */
void test_field_prepare(test_field *field);
/* A random matrix: turned, sheared, scaled and moved; mirrored half of the time. */
void test_field_random_matrix(test_field *field, test_random *random);

/* Cells of an axis run from first to end - 1: cell i lies between samples i and i + 1. A closed
 * field has one more layer of samples all round, of indices -1 and size. */
static inline int64_t test_field_first_cell(const test_field *field) {
    return field->open ? 0 : -1;
}
static inline int64_t test_field_end_cell(const test_field *field, int axis) {
    return field->open ? field->size[axis] - 1 : field->size[axis];
}

/* Value minus iso-value at a sample, by the rules of <qn/surface.h> for closing and for what is not
 * finite. Of a virtual sample mirrored from 0 it is 0; that it is outside is told by
 * test_field_above(). */
double test_field_distance(const test_field *field, int64_t i, int64_t j, int64_t k);
/* The sample's bit: value >= iso-value. */
bool test_field_above(const test_field *field, int64_t i, int64_t j, int64_t k);

/* The field's samples as a packed volume of f64 borrowed from the field. */
qn_volume *test_field_volume(qn_context *context, const test_field *field);
/* Runs qn_surface() on it; the test fails with the error's sentence when that does. */
qn_mesh *test_field_surface(qn_context *context, const test_field *field,
                            qn_surface_report *report);
/* The same with other options. */
qn_mesh *test_field_surface_with(qn_context *context, const test_field *field,
                                 const qn_surface_options *options, qn_surface_report *report);
/* qn_mesh_check() without the search for intersections. */
qn_mesh_report test_mesh_topology(qn_context *context, const qn_mesh *mesh);
/* The options that the field asks for; they borrow field->iso. */
qn_surface_options test_field_options(const test_field *field);

#endif
