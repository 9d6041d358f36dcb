// SPDX-License-Identifier: MIT
/* Nodes of CSG trees. All of these give NULL when memory is short, and copy or retain what they are
 * given. */
#ifndef QNI_SOLID_PRIMITIVES_H
#define QNI_SOLID_PRIMITIVES_H

#include "solid/node.h"

qn_solid *qni_sphere_create(qn_context *context, const double centre[3], double radius,
                            int32_t owner);
/* What lies within radius + slope z of the z axis, without ends. */
qn_solid *qni_cone_create(qn_context *context, double radius, double slope, int32_t owner);
qn_solid *qni_torus_create(qn_context *context, double ring_radius, double tube_radius,
                           int32_t owner);

/* n . p < d, with n = (plane[0], plane[1], plane[2]) and d = plane[3]. The box holds the
 * intersection (all of it: bounds far away are derived from it). Normals need not be of unit
 * length: they are brought to it. */
qn_solid *qni_polytope_create(qn_context *context, int64_t count, const double (*planes)[4],
                              const qni_box *box, int32_t owner);

/* A prism without ends over the outline. */
qn_solid *qni_polygon_create(qn_context *context, const qn_outline *outline, int32_t owner);
/* `part`, flat in x and y, turned about the z axis: its x is the distance from the axis, its y the
 * height. The facets' corners lie on the circle at start + n angle / fragments degrees; 0 < angle
 * <= 360; each facet spans less than 180 degrees. Beyond the angle the result is of no use: the
 * caller cuts it off. 0 fragments: round. */
qn_solid *qni_revolve_create(qn_context *context, const qn_solid *part, double start, double angle,
                             int32_t fragments);

/* The shadow of a part along z, flat; the part's box must be finite along z. */
qn_solid *qni_shadow_create(qn_context *context, qn_solid *part);

/* A flat part from z = low to high. */
qn_solid *qni_extrude_create(qn_context *context, qn_solid *part, double low, double high);
/* A flat part turned by `angle` degrees, -360 to 360, with OpenSCAD's places of facets; `left` when
 * it lies at x <= 0. */
qn_solid *qni_turn_create(qn_context *context, qn_solid *part, double angle, int32_t fragments,
                          bool left);

/* Nothing at all. */
qn_solid *qni_empty_create(qn_context *context);

/* The parts' union or intersection; `minus[n]`, which may be NULL, puts the complement in the place
 * of part n. On equal values the earlier part is the active one. */
qn_solid *qni_combine_create(qn_context *context, bool intersect, int64_t count,
                             qn_solid *const *parts, const bool *minus);

/* The solid whose points p are those for which `inverse` p lies in `part`: inverse[row][column], 3
 * x 4. It may be singular (a projection); then `forward` is NULL and the box is that given. */
qn_solid *qni_transform_create(qn_context *context, const qn_solid *part,
                               const double inverse[3][4], const double forward[3][4],
                               const qni_box *box);
/* The same for a polytope or a combination, without a node of its own; done_out is false for other
 * kinds. */
qn_solid *qni_polytope_transformed(qn_context *context, const qn_solid *part,
                                   const double inverse[3][4], const double forward[3][4],
                                   bool *done_out);
qn_solid *qni_combine_transformed(qn_context *context, const qn_solid *part,
                                  const double inverse[3][4], const double forward[3][4],
                                  bool *done_out);
qni_box qni_box_image(const double matrix[3][4], const qni_box *box);
/* The planes of a polytope, n . p < d as above, of unit normals; NULL for other kinds of solids. */
typedef struct qni_plane {
    double normal[3], distance;
    double tie; /* the value of a point on the plane: see QNI_TIE */
} qni_plane;
const qni_plane *qni_polytope_planes(const qn_solid *solid, int64_t *count_out);
/* forward -> inverse; false when the matrix is singular or not finite. */
bool qni_invert(const double forward[3][4], double inverse[3][4]);

/* The same solid with all owners replaced. */
qn_solid *qni_owned_create(qn_context *context, const qn_solid *part, int32_t owner);
/* The same solid; `volume`, which it borrows, goes with it. */
qn_solid *qni_keeper_create(qn_context *context, const qn_solid *part, qn_volume *volume);
/* f - distance. */
qn_solid *qni_offset_create(qn_context *context, const qn_solid *part, double distance);

#endif
