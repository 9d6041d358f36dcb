// SPDX-License-Identifier: MIT
/* From the tree of a .csg file to a solid, with OpenSCAD's meaning of each module. */
#ifndef QNI_SOLID_CSG_BUILD_H
#define QNI_SOLID_CSG_BUILD_H

#include "solid/csg_tree.h"
#include "solid/hull.h"
#include "solid/primitives.h"

typedef struct qni_csg_builder {
    qn_context *context;
    const qni_text *text;
    qn_error *error;
    bool smooth;   /* round spheres, cylinders and circles */
    int32_t owner; /* of the last leaf made: leaves are numbered from 1 in the order of the file */
} qni_csg_builder;

/* 3 or 2 for solids and flat shapes, 0 for what is neither (an empty group). */
int qni_csg_dimension(const qni_csg_call *call);
/* The solid of one call, in its own coordinates; a flat shape is a prism without ends. */
qn_status qni_csg_build(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out);
/* The union of the children of this dimension; others are left out with a warning, as OpenSCAD
 * does. */
qn_status qni_csg_children(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                           qn_solid **solid_out);

/* Primitives; *known_out is false when the call is none of them. */
qn_status qni_csg_primitive(qni_csg_builder *build, const qni_csg_call *call, bool *known_out,
                            qn_solid **solid_out);
qn_status qni_csg_polyhedron(qni_csg_builder *build, const qni_csg_call *call,
                             qn_solid **solid_out);
qn_status qni_csg_polyhedron_corners(qni_csg_builder *build, const qni_csg_call *call,
                                     qni_points *points);
qn_status qni_csg_linear_extrude(qni_csg_builder *build, const qni_csg_call *call,
                                 qn_solid **solid_out);
qn_status qni_csg_rotate_extrude(qni_csg_builder *build, const qni_csg_call *call,
                                 qn_solid **solid_out);
qn_status qni_csg_hull(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out);
/* Of convex parts only: their sum is the hull of the sums of their corners. */
qn_status qni_csg_minkowski(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out);

/* A polygon model or a level set from another file. */
qn_status qni_csg_import(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out);

/* Add points whose hull is that of the call's solid, moved by the matrix. */
qn_status qni_csg_points(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                         const double matrix[3][4], qni_points *points);
/* Corners of a primitive, in its own coordinates. */
qn_status qni_csg_corners(qni_csg_builder *build, const qni_csg_call *call, qni_points *points);

/* Arguments. A missing one has the default (NaN: it must be there); one that is not a finite number
 * (or a bool) is an error. */
qn_status qni_csg_number(qni_csg_builder *build, const qni_csg_call *call, const char *name,
                         double otherwise, double *value_out);
qn_status qni_csg_flag(qni_csg_builder *build, const qni_csg_call *call, const char *name,
                       bool *value_out);
/* A vector of `count` numbers, or one number for all of them. */
qn_status qni_csg_numbers(qni_csg_builder *build, const qni_csg_call *call, const char *name,
                          int count, double *values_out);
/* OpenSCAD's number of facets of a circle, from $fn, $fa and $fs. */
qn_status qni_csg_fragments(qni_csg_builder *build, const qni_csg_call *call, double radius,
                            int32_t *count_out);
/* The matrix of a multmatrix: all of it, or what it does in the plane. */
qn_status qni_csg_matrix(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                         double matrix[3][4]);

/* "'FILE', line L, column C, CALL: ..." */
qn_status qni_csg_fail(const qni_csg_builder *build, const qni_csg_call *call, qn_status status,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));
/* QN_OK, or the sentence for memory when the solid is NULL. */
qn_status qni_csg_give(const qni_csg_builder *build, qn_solid *solid, qn_solid **solid_out);

#endif
