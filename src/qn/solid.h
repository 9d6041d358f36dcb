// SPDX-License-Identifier: MIT
/* Solids: sets { p : f(p) < 0 } given by a function, a program or a CSG tree. */
#ifndef QN_SOLID_H
#define QN_SOLID_H

#include <qn/base.h>
#include <qn/mesh.h>
#include <qn/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A solid is immutable and counted by references; any number of threads may evaluate it at once. */
typedef struct qn_solid qn_solid;

/* A solid of the caller's own. All functions may be called from several threads at once; each
 * returns 0, or anything else to stop the work with QN_ERROR_CANCELLED. Points are in world units.
 */
typedef struct qn_solid_callback {
    size_t struct_size;
    void *user;
    /* values[n] = f(points[n]): negative inside. Must be continuous near the surface. */
    int (*values)(void *user, int64_t count, const double (*points)[3], double *values);
    /* Gradients of f (any length; they point out of the solid) and the owner (material) of the
     * surface there; each output may be NULL. The function may be NULL: central differences, owner
     * 0. */
    int (*gradients)(void *user, int64_t count, const double (*points)[3], double (*gradients)[3],
                     int32_t *owners);
    /* range[0] <= f <= range[1] over the box. May be NULL: then `lipschitz` bounds it, and where
     * that is 0 too, nothing is known and the solid is sampled to a minimum depth. */
    int (*bounds)(void *user, const double low[3], const double high[3], double range[2]);
    double lipschitz;       /* |f(p) - f(q)| <= lipschitz |p - q|; 0: not known */
    double low[3], high[3]; /* a box that holds the solid */
} qn_solid_callback;

static inline void qn_solid_callback_init(qn_solid_callback *callback) {
    qn_solid_callback zero;
    char *byte = (char *)&zero;
    for (size_t i = 0; i < sizeof zero; ++i)
        byte[i] = 0;
    *callback = zero;
    callback->struct_size = sizeof *callback;
}

QN_API qn_status qn_solid_from_callback(qn_context *context, const qn_solid_callback *callback,
                                        qn_solid **solid_out, qn_error *error);
QN_API void qn_solid_destroy(qn_solid *solid);

typedef struct qn_solid_volume_options {
    size_t struct_size; /* set by qn_solid_volume_options_init() */
    int32_t owner;      /* of the whole surface */
} qn_solid_volume_options;

static inline void qn_solid_volume_options_init(qn_solid_volume_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* The solid that the trilinear interpolant of a volume bounds at an iso-value, closed at the
 * volume's border as by qn_surface(), in world units. f is the value less the iso-value, or the
 * other way round where inside is above, so it is a distance only where the samples are distances.
 * Crossings of lattice edges are exact; ranges over boxes come from a tree over leaves of 8^3
 * cells.
 *
 * volume   borrowed while the solid lives; sparse ones stay sparse.
 * options  NULL for defaults.
 *
 * QN_ERROR_INVALID_ARGUMENT  no volume, a non-finite iso-value, a matrix that is nearly singular
 * QN_ERROR_OUT_OF_MEMORY, QN_ERROR_CANCELLED */
QN_API qn_status qn_solid_from_volume(qn_context *context, const qn_volume *volume, double isovalue,
                                      qn_inside inside, const qn_solid_volume_options *options,
                                      qn_solid **solid_out, qn_error *error);

/* Primitives. `fragments` is the number of flat facets round a circle, 3 to 16384 (spheres: 1024);
 * 0 makes it round. A facetted sphere or cylinder has its corners on the round one, as in OpenSCAD.
 * A part with no room inside (a radius or an edge of 0) is empty, which is no error; negative or
 * non-finite numbers are QN_ERROR_INVALID_ARGUMENT. */
QN_API qn_status qn_solid_box(qn_context *context, const double low[3], const double high[3],
                              qn_solid **solid_out, qn_error *error);
QN_API qn_status qn_solid_sphere(qn_context *context, double radius, int32_t fragments,
                                 qn_solid **solid_out, qn_error *error);
/* Along z from 0 to `height`; two radii make a cone. */
QN_API qn_status qn_solid_cylinder(qn_context *context, double height, double low_radius,
                                   double high_radius, int32_t fragments, qn_solid **solid_out,
                                   qn_error *error);
/* Round z; tube_radius <= ring_radius. */
QN_API qn_status qn_solid_torus(qn_context *context, double ring_radius, double tube_radius,
                                qn_solid **solid_out, qn_error *error);
/* { p : normal . p < distance |normal| }, without end. */
QN_API qn_status qn_solid_half_space(qn_context *context, const double normal[3], double distance,
                                     qn_solid **solid_out, qn_error *error);

/* A flat shape: closed contours one after the other, inside by the even-odd rule, so that holes are
 * contours too. */
typedef struct qn_outline {
    int64_t contour_count;
    const int64_t *contour_sizes; /* points of each contour */
    const double (*points)[2];
} qn_outline;
/* The outline from z = 0 to `height`. */
QN_API qn_status qn_solid_linear_extrude(qn_context *context, const qn_outline *outline,
                                         double height, qn_solid **solid_out, qn_error *error);
/* The outline turned about the z axis by `angle` degrees, at most 360 and negative the other way
 * round: its x is the distance from the axis, its y the height. All points have x >= 0. `fragments`
 * counts the flat pieces of this angle. */
QN_API qn_status qn_solid_rotate_extrude(qn_context *context, const qn_outline *outline,
                                         double angle, int32_t fragments, qn_solid **solid_out,
                                         qn_error *error);
/* The convex hull of points. QN_ERROR_INVALID_ARGUMENT when they lie in one plane,
 * QN_ERROR_UNSUPPORTED in a build without Qhull. */
QN_API qn_status qn_solid_hull(qn_context *context, int64_t count, const double (*points)[3],
                               qn_solid **solid_out, qn_error *error);

/* Any closed polyhedron; faces are flat polygons of 3 or more points, one after the other, either
 * way round. Inside is where a ray meets an odd number of faces. QN_ERROR_INPUT when some edge
 * belongs to an odd number of faces. */
QN_API qn_status qn_solid_polyhedron(qn_context *context, int64_t point_count,
                                     const double (*points)[3], int64_t face_count,
                                     const int64_t *face_sizes, const int64_t *indices,
                                     qn_solid **solid_out, qn_error *error);

/* ---- polygon models
 * -----------------------------------------------------------------------------------------------
 */

/* What says which points are inside. */
typedef enum qn_mesh_sign {
    QN_MESH_SIGN_AUTO,   /* winding; parity where that is defined and winding is not */
    QN_MESH_SIGN_PARITY, /* inside is behind an odd number of faces; holes are closed by fans */
    QN_MESH_SIGN_WINDING /* inside is where the (generalized) winding number is 1/2 or more */
} qn_mesh_sign;

typedef struct qn_solid_mesh_options {
    size_t struct_size; /* set by qn_solid_mesh_options_init() */
    qn_mesh_sign sign;
    int32_t owner;  /* of faces for which the mesh knows none */
    bool one_owner; /* of all faces */
} qn_solid_mesh_options;

static inline void qn_solid_mesh_options_init(qn_solid_mesh_options *options) {
    qn_solid_mesh_options zero;
    char *byte = (char *)&zero;
    for (size_t i = 0; i < sizeof zero; ++i)
        byte[i] = 0;
    *options = zero;
    options->struct_size = sizeof *options;
}

/* What a polygon model is like. */
typedef struct qn_solid_mesh_report {
    int64_t triangles;         /* quads count twice */
    int64_t dropped_triangles; /* left out: a repeated place, or not finite */
    int64_t joined_vertices;   /* at the place of an earlier one */
    int64_t rim_edges;         /* edges that faces do not run along as often one way as the other */
    int64_t odd_edges;         /* edges of an odd number of triangles */
    int64_t turned_triangles;  /* turned round to agree with their neighbours */
    int64_t holes;             /* rims, as simple loops */
    int64_t cap_triangles;
    qn_mesh_sign used; /* parity or winding */
    bool closed;       /* no caps were needed */
    /* Lines through the model, 32 x 32 along each axis, and those of them on which the surface is
     * not simply where the faces are: faces within the solid, or holes. */
    int64_t lines, disagreeing_lines;
} qn_solid_mesh_report;

/* The solid that a polygon model bounds: crossings straight from its triangles by exact predicates,
 * sharp; owners from the mesh.
 *
 * Vertices at equal places are joined first. A model whose faces cancel at every edge (closed, also
 * of overlapping parts) is inside where its winding number is not 0, so parts that overlap become
 * one, and it never leaks. Where faces do not agree they are turned until they do, if that is
 * possible. What is still open is inside where the generalized winding number is at least 1/2: its
 * holes are closed by smooth sheets. Or, with QN_MESH_SIGN_PARITY, by fans over their rims.
 *
 * mesh        copied; it may be destroyed.
 * options     NULL for defaults.
 * report_out  may be NULL.
 *
 * QN_ERROR_INPUT             no triangle with three different corners
 * QN_ERROR_INVALID_ARGUMENT  an unset struct_size; too many faces (2^28)
 * QN_ERROR_OUT_OF_MEMORY
 *
 * Source: Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized
 * winding numbers", 2013. Departure: rims are capped and the whole number is counted exactly; only
 * what the caps add is a sum of solid angles. */
QN_API qn_status qn_solid_from_mesh(qn_context *context, const qn_mesh *mesh,
                                    const qn_solid_mesh_options *options, qn_solid **solid_out,
                                    qn_solid_mesh_report *report_out, qn_error *error);
/* How many crossings were found over holes of a solid from qn_solid_from_mesh() so far; 0 for
 * others. */
QN_API int64_t qn_solid_get_hole_crossings(const qn_solid *solid);

/* Booleans. The parts are retained, so the caller still destroys its own references, at any time.
 * No parts make an empty solid. Where two parts have the same surface the earlier one gives normal
 * and owner. */
QN_API qn_status qn_solid_union(qn_context *context, int64_t count, qn_solid *const *parts,
                                qn_solid **solid_out, qn_error *error);
QN_API qn_status qn_solid_intersection(qn_context *context, int64_t count, qn_solid *const *parts,
                                       qn_solid **solid_out, qn_error *error);
/* The first part without all the others. */
QN_API qn_status qn_solid_difference(qn_context *context, int64_t count, qn_solid *const *parts,
                                     qn_solid **solid_out, qn_error *error);
QN_API qn_status qn_solid_complement(qn_context *context, qn_solid *part, qn_solid **solid_out,
                                     qn_error *error);

/* matrix[row][column]: moves points of the part to where they come to lie. It must be invertible.
 */
QN_API qn_status qn_solid_transform(qn_context *context, qn_solid *part, const double matrix[3][4],
                                    qn_solid **solid_out, qn_error *error);
/* { p : f(p) < distance }. Grown by that distance where f is a distance (round parts, outside of
 * flat ones along their faces); corners stay sharp, for f is not rounded there. Negative distances
 * shrink. */
QN_API qn_status qn_solid_offset(qn_context *context, qn_solid *part, double distance,
                                 qn_solid **solid_out, qn_error *error);
/* The same solid, all of whose surface belongs to `owner`. */
QN_API qn_status qn_solid_with_owner(qn_context *context, qn_solid *part, int32_t owner,
                                     qn_solid **solid_out, qn_error *error);

typedef struct qn_solid_read_options {
    size_t struct_size; /* set by qn_solid_read_options_init() */
    double low[3],
        high[3]; /* of .vm files, which name no region: all 0 means -1 to 1 along each axis */
    bool smooth_primitives; /* of .csg files: round spheres, cylinders and circles where OpenSCAD
                               has facets */
} qn_solid_read_options;

static inline void qn_solid_read_options_init(qn_solid_read_options *options) {
    qn_solid_read_options zero;
    char *byte = (char *)&zero;
    for (size_t i = 0; i < sizeof zero; ++i)
        byte[i] = 0;
    *options = zero;
    options->struct_size = sizeof *options;
}

/* Read a solid: .vm (expression tapes, one operation a line) or .csg (what `openscad -o MODEL.csg
 * MODEL.scad` writes). options may be NULL. The format is that of the name's ending. QN_ERROR_INPUT
 * the file cannot be read or breaks its format; the message names line and what was expected
 * QN_ERROR_UNSUPPORTED  it uses something that Quoin lacks; the message names it */
QN_API qn_status qn_solid_read(qn_context *context, const char *path,
                               const qn_solid_read_options *options, qn_solid **solid_out,
                               qn_error *error);
/* The same from memory; `name` ends as a file's would and is used in messages. */
QN_API qn_status qn_solid_read_text(qn_context *context, const char *name, const char *bytes,
                                    int64_t size, const qn_solid_read_options *options,
                                    qn_solid **solid_out, qn_error *error);

/* A box that holds the solid; infinite for half-spaces and the like, low = high for an empty solid.
 */
QN_API void qn_solid_get_box(const qn_solid *solid, double low[3], double high[3]);
/* values[n] = f(points[n]), negative inside. */
QN_API qn_status qn_solid_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 double *values, qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
