// SPDX-License-Identifier: MIT
/* Fewer and better quads: 3-X-3-Y and 3-3-3-3 removed from a quad mesh with halfedges ([DMC21]
 * section 4). */
#ifndef QNI_DMC_SIMPLIFY_H
#define QNI_DMC_SIMPLIFY_H

#include "mesh/mesh.h"

/* Puts a point that lies near the surface onto it, or returns false and leaves it as it was.
 * `normal` is the surface's there, unit length, about right. Called from any worker. */
typedef bool (*qni_onto_surface)(const void *user, const float normal[3], float position[3]);

typedef struct qni_simplify_options {
    const uint8_t *colours; /* [quads]: quads of lower colour go first; NULL: */
    /* the colour of a quad, asked for those that may go; NULL as well: they go by scattered number
     * alone */
    uint8_t (*colour)(const void *user, const qn_mesh *mesh, int64_t quad);
    const void *colour_user;
    uint8_t *valences; /* [vertices + 1]: quads round each vertex, 0 where they do not close round
                          it or form several fans; used up. NULL: measured */
    int32_t passes;    /* at most so many; 0: until nothing is left to do */
    bool paper; /* [DMC21] section 4.1 for 3-X-3-Y, to compare: one pass, one look at the colours */
    qni_onto_surface project; /* NULL: new vertices stay at the middle of the two they replace, as
                                 in the paper */
    const void *project_user;
} qni_simplify_options;

typedef struct qni_simplify_report {
    int64_t merged_quads; /* removed by 3-X-3-Y; each took one vertex along */
    int64_t shrunk_quads; /* removed by 3-3-3-3, four at a time; as many vertices */
    int64_t unprojected; /* new vertices that took the place of the one they keep, the surface being
                            out of reach */
    int32_t passes;
    int64_t scratch_bytes; /* most memory held beside the mesh and the options' arrays */
    double seconds;
} qni_simplify_report;

/* The mesh must have quads alone, and halfedges, which stay right. Order is kept: what is left
 * stands in the order it had. The Euler characteristic, components and orientation stay, and what
 * was a 2-manifold remains one. Same bytes for any number of threads. On failure the mesh is
 * unchanged, or simplified but not packed and fit only to be destroyed.
 *
 * Source: [DMC21] section 4. Departures: rounds of independent removals until none is left (the
 * paper: one pass); conditions that keep the surface a manifold; halfedges patched in place; new
 * vertices put back onto the surface. */
qn_status qni_simplify(qn_context *context, qn_mesh *mesh, const qni_simplify_options *options,
                       qni_simplify_report *report_out, qn_error *error);

/* Drop vertices and quads whose mark is 255, in place; the rest keeps its order (compact.c). Both
 * arrays of marks have one byte more than there are vertices and quads, and are used up. */
qn_status qni_compact_mesh(qn_context *context, qn_mesh *mesh, uint8_t *vertex_marks,
                           uint8_t *quad_marks, qn_error *error);

#endif
