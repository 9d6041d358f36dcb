// SPDX-License-Identifier: MIT
/* Fewer and better quads: 3-X-3-Y and 3-3-3-3 removed from a quad mesh ([DMC21] section 4). */
#ifndef QNI_DMC_SIMPLIFY_H
#define QNI_DMC_SIMPLIFY_H

#include "mesh/mesh.h"

struct qni_leaf_index;
struct qni_projector;

typedef struct qni_simplify_options {
    /* From emission, or both NULL: measured by the halfedges, and no colours. As simplify_hd.h says
     * what they mean; both are used up. */
    uint8_t *valences;                  /* [vertices + 1] */
    uint8_t *colours;                   /* [quads + 1]: quads of lower colour go first */
    const struct qni_leaf_index *index; /* for meshes without halfedges */
    int32_t passes;                     /* at most so many; 0: until nothing is left to do */
    bool paper; /* [DMC21] section 4.1 for 3-X-3-Y, to compare: one pass, one look at the colours */
    const struct qni_projector *projector; /* NULL: new vertices stay at the middle of the two they
                                              replace, as in the paper */
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

/* The mesh must have quads alone. Halfedges stay right where it has them; it must have some unless
 * the options hold an index of its leaves. Order is kept: what is left stands in the order it had.
 * The Euler characteristic, components and orientation stay, and what was a 2-manifold remains one.
 * Same bytes for any number of threads, with halfedges and without. On failure the mesh is fit only
 * to be destroyed.
 *
 * Source: [DMC21] section 4. Departures: rounds of independent removals until none is left (the
 * paper: one pass); conditions that keep the surface a manifold; halfedges patched in place, or not
 * needed; new vertices between X and Y too, and back on the surface. */
qn_status qni_simplify(qn_context *context, qn_mesh *mesh, const qni_simplify_options *options,
                       qni_simplify_report *report_out, qn_error *error);

/* Drop vertices and quads whose mark is 255, in place; the rest keeps its order (compact.c). Where
 * a dropped vertex was merged into another one, `renumber` of it names that one; that array is used
 * up. */
qn_status qni_compact_mesh(qn_context *context, qn_mesh *mesh, const uint8_t *vertex_marks,
                           const uint8_t *quad_marks, uint32_t *renumber, qn_error *error);

#endif
