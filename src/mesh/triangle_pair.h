// SPDX-License-Identifier: MIT
/* Whether two triangles of a mesh meet where they should not, decided exactly. */
#ifndef QNI_MESH_TRIANGLE_PAIR_H
#define QNI_MESH_TRIANGLE_PAIR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* True when the closed triangles a and b share a point outside the vertices and edges that they
 * share by index: any point for strangers, a point beyond the vertex for neighbours at a vertex, an
 * overlap in one plane for neighbours at an edge; always for the same three vertices. Vertices with
 * different indices at the same place are strangers. Both triangles must have an area and finite
 * coordinates. */
bool qni_triangles_meet(const float *positions, const uint32_t a[3], const uint32_t b[3]);

#endif
