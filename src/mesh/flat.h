// SPDX-License-Identifier: MIT
/* Flat parts of a mesh of triangles with as few of them as their outlines need. */
#ifndef QNI_MESH_FLAT_H
#define QNI_MESH_FLAT_H

#include "mesh/mesh.h"

typedef struct qni_flat_report {
    int64_t dropped_vertices;
    int64_t kept_regions; /* flat parts left as they were, since made anew they would meet others */
} qni_flat_report;

/* Drop the vertices within flat parts, and those along straight edges between two of them. A part
 * is flat where all its vertices lie within `near` of one plane; parts end at crease edges and
 * where owners change. What is left is triangulated anew, by Delaunay's rule as far as outlines
 * allow; all else stays, in the order it had. Boundary vertices stay.
 *
 * The mesh needs triangles alone, owners, no normals and no halfedges; a closed manifold without
 * self-intersections remains one: what is made anew is held against the whole mesh, exactly.
 * *mesh is replaced; on failure it stays as it was. */
qn_status qni_mesh_merge_flat(qn_context *context, qn_mesh **mesh, double near,
                              qni_flat_report *report_out, qn_error *error);

#endif
