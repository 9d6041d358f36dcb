// SPDX-License-Identifier: MIT
/* Nodes of CSG trees. All of these give NULL when memory is short, and copy or retain what they are given. */
#ifndef QNI_SOLID_PRIMITIVES_H
#define QNI_SOLID_PRIMITIVES_H

#include "solid/node.h"

qn_solid *qni_sphere_create(qn_context *context, const double centre[3], double radius, int32_t owner);
/* What lies within radius + slope z of the z axis, without ends. */
qn_solid *qni_cone_create(qn_context *context, double radius, double slope, int32_t owner);
qn_solid *qni_torus_create(qn_context *context, double ring_radius, double tube_radius, int32_t owner);

/* n . p < d, with n = (plane[0], plane[1], plane[2]) and d = plane[3]. The box holds the intersection. Normals need not
 * be of unit length: they are brought to it. */
qn_solid *qni_polytope_create(qn_context *context, int64_t count, const double (*planes)[4], const qni_box *box,
                              int32_t owner);

/* Nothing at all. */
qn_solid *qni_empty_create(qn_context *context);

/* The parts' union or intersection; `minus[n]`, which may be NULL, puts the complement in the place of part n. On equal
 * values the earlier part is the active one. */
qn_solid *qni_combine_create(qn_context *context, bool intersect, int64_t count, qn_solid *const *parts,
                             const bool *minus);

/* The solid whose points p are those for which `inverse` p lies in `part`: inverse[row][column], 3 x 4. It may be singular
 * (a projection); then `forward` is NULL and the box is that given. */
qn_solid *qni_transform_create(qn_context *context, const qn_solid *part, const double inverse[3][4],
                               const double forward[3][4], const qni_box *box);
/* forward -> inverse; false when the matrix is singular or not finite. */
bool qni_invert(const double forward[3][4], double inverse[3][4]);

/* The same solid with all owners replaced. */
qn_solid *qni_owned_create(qn_context *context, const qn_solid *part, int32_t owner);
/* f - distance. */
qn_solid *qni_offset_create(qn_context *context, const qn_solid *part, double distance);

#endif
