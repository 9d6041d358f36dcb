// SPDX-License-Identifier: MIT
/* Dual Marching Cubes on uniform 8^3 leaves: count what each leaf will give, then write it in
 * place. */
#ifndef QNI_DMC_DMC_H
#define QNI_DMC_DMC_H

#include <qn/surface.h>
#include "dmc/frame_hd.h"
#include "dmc/landing.h"
#include "core/pool.h"
#include "mesh/mesh.h"
#include "volume/field.h"

/* A cell with several polygons: where it is, what it adds, which table entry says how its edges
 * belong together. */
typedef struct qni_multi_cell {
    uint16_t cell;         /* x + 8 y + 64 z in its leaf */
    uint16_t extra_before; /* vertices beyond one a cell, of the leaf's multiple cells before it */
    uint16_t entry;        /* of cases_hd.h */
} qni_multi_cell;

/* A leaf with surface. Bases count from the start of its row of leaves. */
typedef struct qni_dmc_leaf {
    uint64_t active[QNI_LEAF];       /* cells with surface, by slice */
    uint16_t before_slice[QNI_LEAF]; /* active cells in lower slices */
    int32_t x;                       /* leaf coordinate in its row */
    uint32_t vertex_base, quad_base, multi_base;
    uint16_t multi_count;
} qni_dmc_leaf;

/* The inner crossed edges of a leaf by axis and slice, and how many of its quads come before: for
 * halfedges. */
typedef struct qni_leaf_quads {
    uint64_t mask[3][QNI_LEAF];
    uint16_t before[3][QNI_LEAF];
} qni_leaf_quads;

/* A face whose two segments belong to one polygon on either side: a doubled edge (repair.h). */
typedef struct qni_doubled_face {
    int32_t cell[3];   /* the cell above it */
    uint8_t axis;      /* normal to it */
    uint8_t first_cut; /* its segments cut off face corners first_cut and first_cut + 2 */
} qni_doubled_face;

/* A cell whose interpolant joins two of its polygons inside (tunnel_hd.h). */
typedef struct qni_tunnel_cell {
    int32_t cell[3];
    uint16_t entry; /* of cases_hd.h */
    uint8_t polygon[2];
    double middle[3]; /* in the tunnel; local */
} qni_tunnel_cell;

/* A polygon at the rim of an open field whose quads form several fans (rim.h). */
typedef struct qni_rim_vertex {
    int32_t cell[3];
    uint16_t entry; /* of cases_hd.h */
    uint8_t polygon, fans;
    uint32_t vertex; /* from the start of its row */
} qni_rim_vertex;

typedef struct qni_dmc_row {
    qni_dmc_leaf *leaves;  /* ascending x */
    qni_leaf_quads *quads; /* of each leaf; only for halfedges and simplification */
    qni_multi_cell *multis;
    qni_doubled_face *doubled;
    qni_tunnel_cell *tunnels;
    qni_rim_vertex *rims;
    uint8_t *valences; /* [vertices]: edges of their polygons; only for simplification */
    int32_t leaf_count, multi_count, doubled_count, tunnel_count, rim_count;
    int64_t vertex_count, quad_count;
    int64_t vertex_base, quad_base; /* in the mesh */
} qni_dmc_row;

/* Counters of what the values decided; summed over rows, so no order matters. */
typedef struct qni_dmc_tally {
    int64_t active_cells, ambiguous_faces, tied_faces, multiple_cells, tunnels;
    int64_t slice_points, degenerate_points, fallback_points, zero_gradients;
} qni_dmc_tally;

typedef struct qni_dmc {
    qn_context *context;
    qni_field field;
    bool with_halfedges, with_repair, with_tunnels, with_valences;
    uint8_t *valences; /* [vertices of the mesh + 1]: quads round each, 0 where they do not close
                          round it (simplify_hd.h); filled by emission when it is to be simplified,
                          else NULL */
    uint8_t *colours;  /* [quads of the mesh + 1], likewise: the axes of their lattice edges, 3 of
                          quads that were split */
    int64_t valence_room, colour_room;
    struct qni_repair *repair; /* planned after counting, when there are doubled edges */
    qni_dmc_row *rows;
    int64_t row_count;
    qni_pool *pools; /* hold the rows' arrays: of each thread one for its valences, and before it
                        one for all others */
    int32_t pool_count;
    int64_t vertex_count, quad_count, leaf_count; /* before repair */
    int64_t doubled_count, tunnel_count;          /* of those to be taken apart, and restored */
    int64_t rim_count;       /* vertices more since several fans met at one, at an open rim */
    int64_t rim_points_left; /* points of those that are left on a lattice edge */
    int64_t held_before;     /* bytes the context held when the work began */
    int64_t scratch_bytes;   /* most bytes held beside that and the mesh */
    qni_dmc_tally tally;
} qni_dmc;

/* Pass 1 (count.c): fill rows. Pass 2 (emit.c): write the mesh. Both are parallel over rows of
 * leaves. */
qn_status qni_dmc_count(qni_dmc *dmc, qn_error *error);
qn_status qni_dmc_emit(qni_dmc *dmc, qn_mesh *mesh, qn_error *error);
void qni_dmc_free_rows(qni_dmc *dmc);
void qni_dmc_free_row_valences(qni_dmc *dmc);
/* Note what is held now, of which `mesh_bytes` are output. */
int64_t qni_dmc_mesh_bytes(const qni_dmc *dmc, bool with_normals);
void qni_dmc_note_memory(qni_dmc *dmc, int64_t mesh_bytes);

/* Simplify and relax the finished mesh as the options ask (improve.c); the report's counts follow.
 * Halfedges that the mesh has are kept right; where they are missing and needed they are made, and
 * given up again unless options->halfedges. Simplification needs none when the rows and valences of
 * emission are still there. */
qn_status qni_dmc_improve(qni_dmc *dmc, qn_mesh *mesh, const qn_surface_options *options,
                          qn_surface_report *report, qn_error *error);

/* One iso-value, both passes. `mesh_out` stays NULL with options->count_only. */
qn_status qni_dmc_surface(qn_context *context, const qn_volume *volume, double isovalue,
                          const qn_surface_options *options, qn_mesh **mesh_out,
                          qn_surface_report *report_out, qn_error *error);

/* ---- the inner loops, built for several instruction sets and chosen at run time (kernel_*.c)
 * ----- */

enum { QNI_LANES = 8 };

/* Vertices of QNI_LANES single-polygon cells at once. */
typedef struct qni_point_batch {
    const double *corner[QNI_LANES]; /* the cells' lowest corners in a tile */
    double cell[3][QNI_LANES];       /* lattice point of the cells' lowest corners */
    double stencil[QNI_STENCIL]
                  [QNI_LANES];    /* out: values at and round the cells' corners, see place_hd.h */
    double local[3][QNI_LANES];   /* out: where the vertex is in its cell */
    double distance[QNI_LANES];   /* out: 2 when no axis line met the surface */
    float position[3][QNI_LANES]; /* out: world */
    float normal[3][QNI_LANES];   /* out: unit length */
    int32_t apart[QNI_LANES]; /* out: no axis line met the surface, or no gradient: look again */
} qni_point_batch;

/* Lattice to world of a field, and the determinant of its linear part. */
void qni_frame_of_field(const qni_field *field, qni_frame *frame_out, double *determinant_out);

typedef void qni_point_kernel(qni_point_batch *batch, const qni_frame *frame);

/* Packing, of vertices [from, end): points that are not marked as gone, to `from` on; numbers of
 * those vertices, from `first` on. A vertex that is gone gets the number of the one that `renumber`
 * names, which comes before it, or with `follow` not set still names it. */
typedef void qni_squeeze_kernel(float *points, const uint8_t *marks, int64_t from, int64_t end);
typedef void qni_number_kernel(const uint8_t *marks, int64_t from, int64_t end, uint32_t first,
                               bool follow, uint32_t *renumber);

typedef struct qni_kernels {
    const char *name;
    qni_point_kernel *point;
    qni_meet_kernel *meet;
    qni_locate_kernel *locate;
    qni_land_kernel *land;
    qni_squeeze_kernel *squeeze;
    qni_number_kernel *number;
} qni_kernels;

/* Those that this processor can run, plain ones first; NULL beyond the last. */
const qni_kernels *qni_kernels_at(int index);
/* The widest of them. The same bits whichever is chosen: each lane is plain IEEE arithmetic. */
const qni_kernels *qni_choose_kernels(void);

/* One cell's stencil, from its lowest corner in a tile. */
void qni_gather_stencil(const double *corner, double stencil[QNI_STENCIL]);

/* Position and normal of one vertex from its cell's stencil and its local place. */
void qni_place_point(const double stencil[QNI_STENCIL], const double cell[3], const double local[3],
                     const qni_frame *frame, float position[3], float normal[3]);
/* Store it; where central differences cancel, the normal comes from the cell itself, and false is
 * returned. */
bool qni_store_vertex(qn_mesh *mesh, int64_t vertex, const float position[3], float normal[3],
                      const double stencil[QNI_STENCIL], const double local[3],
                      const qni_frame *frame);

#endif
