// SPDX-License-Identifier: MIT
/* The facade: a volume goes in, meshes come out. */
#ifndef QN_SURFACE_H
#define QN_SURFACE_H

#include <qn/base.h>
#include <qn/mesh.h>
#include <qn/solid.h>
#include <qn/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Within one cell the interpolant can join two of the cell's polygons by a tunnel. */
typedef enum qn_topology {
    QN_TOPOLOGY_DISCS, /* [DMC21]: every polygon is a disc of its own */
    QN_TOPOLOGY_EXACT  /* tunnels are restored: a closed mesh has the topology of the trilinear
                          surface */
} qn_topology;

/* Faces of a dual mesh can cross each other where its cells are too coarse for the surface: several
 * sheets in a cell, samples at the iso-value, edges taken apart. */
typedef enum qn_untangle {
    QN_UNTANGLE_OFF, /* every vertex stays where it was put, on the interpolant */
    QN_UNTANGLE_ON,  /* finds all crossings: looks where they are not proved to be impossible */
    QN_UNTANGLE_ALL  /* finds the same among all faces, to hold the proofs against; slower */
} qn_untangle;

/* Where to work. The result has the same bytes on either. */
typedef enum qn_device {
    QN_DEVICE_AUTO, /* the GPU where there is one, it can do what is asked, and the volume is large
                       enough to be worth the way; else the processor */
    QN_DEVICE_CPU,
    QN_DEVICE_CUDA /* the current CUDA device, which is the first unless chosen, or an error */
} qn_device;

typedef struct qn_surface_options {
    size_t struct_size;
    const double *isovalues; /* [isovalue_count]; borrowed for the call */
    int32_t isovalue_count;  /* 0: the single iso-value 0 */
    qn_inside inside;
    bool open;      /* leave the surface open where it leaves the volume; default: closed there */
    bool triangles; /* split the quads (MaxMin angle) */
    bool skip_normals;
    bool count_only;   /* dry run: fill the reports, make no mesh */
    bool keep_doubled; /* leave doubled edges as [DMC21] makes them; default: take them apart */
    bool halfedges;    /* give the mesh its halfedges (not together with `triangles`) */
    /* Fewer irregular vertices ([DMC21] section 4): quads of valences 3-X-3-Y (X, Y >= 5) and
     * 3-3-3-3 are removed. The mesh keeps its components, its Euler characteristic and its
     * orientation, and stays a manifold where it was one. */
    bool simplify;
    int32_t simplify_passes; /* 0: until nothing is left to remove; n: at most n passes; -1: the
                                paper's own single pass */
    bool no_reproject; /* leave the vertices made by simplification at the middle of the two they
                        * replace, as in the paper; default: they are put back onto the surface */
    int32_t relax; /* sweeps of tangential relaxation: vertices slide on the surface, each in its
                    * own cell, towards squarer quads (equation (9)); 3 to 5 do most of it. After
                    * simplification. */
    qn_topology topology; /* an open surface's tunnels at its rim are left out */
    qn_device device;
    qn_untangle untangle; /* vertices near crossing faces are drawn towards the middle of their
                           * neighbours, by some tenths of a cell, until no two triangles cross:
                           * those of the cut that files and checks make of the quads. After all
                           * else; faces and counts stay */
} qn_surface_options;

static inline void qn_surface_options_init(qn_surface_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* What happened on the way, for one iso-value. */
typedef struct qn_surface_report {
    double isovalue;
    int64_t cells;           /* cells of the lattice, the virtual border layer included */
    int64_t active_leaves;   /* 8^3 leaves with surface */
    int64_t active_cells;    /* cells with surface */
    int64_t ambiguous_faces; /* lattice faces with two ways to pair their four crossings */
    int64_t multiple_cells;  /* cells with two to four polygons */
    int64_t
        tied_faces; /* ambiguous faces where both pairings are equally right; the rule decides */
    int64_t vertices, quads;   /* of the mesh, repair included */
    int64_t slice_points;      /* vertices found on a slice through the cell (no axis line met the
                                  surface) */
    int64_t degenerate_points; /* polygons shrunk to a point, where samples equal the iso-value */
    int64_t
        fallback_points; /* vertices put on a face arc of their polygon since no slice would do */
    int64_t zero_gradients; /* normals taken from the polygon since the gradient vanishes there */
    int64_t nan_samples, infinite_samples;
    int64_t doubled_edges;  /* pairs of mesh edges with the same two ends, the non-manifold edges of
                               [MDMC21] */
    int64_t repaired_edges; /* those of them that were taken apart */
    int64_t tunnels; /* cells where the interpolant joins two polygons by a tunnel; looked for with
                        QN_TOPOLOGY_EXACT */
    int64_t restored_tunnels; /* those of them that the mesh has */
    int64_t output_bytes;     /* memory of the mesh, room left by simplification included */
    int64_t scratch_bytes;    /* most memory held beside it, by any stage */
    double seconds_classify, seconds_emit, seconds_total;
    /* With options->simplify and options->relax; `vertices` and `quads` are then those of the
     * finished mesh. */
    int64_t merged_quads;       /* removed by 3-X-3-Y */
    int64_t shrunk_quads;       /* removed by 3-3-3-3 */
    int64_t unprojected_points; /* merged vertices that took an old one's place, the surface being
                                   out of reach from the middle */
    int64_t relaxed_vertices;   /* vertices that relaxation moved */
    int32_t simplify_passes;
    double seconds_simplify, seconds_relax;
    int64_t split_rim_vertices; /* vertices more at an open border, so that none joins several fans
                                   of quads; not with options->keep_doubled */
    qn_device device;           /* where the work was done: QN_DEVICE_CPU or QN_DEVICE_CUDA */
    char device_note[120];      /* why QN_DEVICE_AUTO took the processor, or empty */
    int32_t device_slabs; /* parts in which the volume went through a GPU: 1 where its memory held
                             all; 0 on the processor */
    /* With options->untangle. */
    int64_t crossings;          /* pairs of triangles found to cross */
    int64_t crossings_left;     /* pairs that are left, of those that were found */
    int64_t untangled_vertices; /* vertices that were moved for it, off the surface */
    double untangled_farthest;  /* the largest of these moves, in cells */
    double seconds_untangle;
} qn_surface_report;

/* Extract the surfaces { p : volume(p) = iso } of the trilinear interpolant as consistently
 * oriented quad meshes, by dual marching cubes; closed at the volume's border unless options->open.
 *
 * volume      borrowed for the call.
 * options     NULL for defaults.
 * meshes_out  [isovalue_count], receives new meshes, each to be freed with qn_mesh_destroy(); all
 * NULL on any failure and with count_only. An iso-value without surface gives an empty mesh, not an
 * error. reports_out [isovalue_count], or NULL.
 *
 * Closing: one virtual layer of samples lies outside the volume's border and carries each border
 * sample's value mirrored at the iso-value to the outside, so caps stand half a voxel beyond the
 * outermost samples: a voxel is taken as the box round its sample. With open, boundary edges lie
 * within the outermost cells.
 *
 * Non-finite samples: NaN is outside; +infinity is above, -infinity below the iso-value; for the
 * place of the surface next to them their distance to the iso-value is taken as the largest among
 * the finite samples. All are counted in the report.
 *
 * The result is the same, bit for bit, for every thread count.
 *
 * QN_ERROR_INVALID_ARGUMENT   a non-finite iso-value, an unset struct_size, simplify_passes below
 * -1, a negative relax QN_ERROR_OUT_OF_MEMORY      the allocator returned NULL; or more than 2^32 -
 * 1 vertices QN_ERROR_CANCELLED          the progress callback asked to stop
 * QN_ERROR_UNSUPPORTED        QN_DEVICE_CUDA without CUDA, a device, or for what it does not do
 *
 * Source: Grosso and Zint, "A parallel dual marching cubes approach to quad only surface
 * reconstruction", 2021, section 3 [DMC21]. Departures (no hash tables, vertices found without
 * sampling, one face rule): docs/architecture.md. */
QN_API qn_status qn_surface(qn_context *context, const qn_volume *volume,
                            const qn_surface_options *options, qn_mesh **meshes_out,
                            qn_surface_report *reports_out, qn_error *error);

/* ---- solids: adaptive Cubical Marching Squares -------------------------------------------------
 */

enum { QN_MIN_DEPTH = 3, QN_MAX_DEPTH = 12 };

/* Volumes only: have the data sharp edges? Solids always have. */
typedef enum qn_creases {
    QN_CREASES_OFF, /* densities, scans: whatever bends, bends smoothly */
    QN_CREASES_ON, /* distances: where normals differ by more than the crease angle there is an edge
                    */
    QN_CREASES_AUTO /* on where nine tenths of the surface have slopes of unit length, as distances
                       have
                   */
} qn_creases;

typedef struct qn_solid_surface_options {
    size_t struct_size;
    int32_t depth;    /* 2^depth finest cells along the longest axis, of which the solid, or its box
                         when given, measures 31/32: see qn_depth_cells(); 0: 7 */
    int32_t base;     /* coarsest cells along the longest axis, a power of two; 0: 8 */
    double tolerance; /* how far coarse triangles may be from the fine samples, world units; 0: 1/20
                         finest cell */
    double crease;    /* normals that differ by more make a sharp feature, degrees; 0: 30 */
    bool has_box;     /* cut the solid at low .. high; else at the box that holds it */
    double low[3], high[3];
    bool no_features; /* plain marching cubes with consistent faces */
    bool uniform;     /* finest cells only */
    bool open; /* no caps where the box cuts the solid: the surface ends at the last lattice plane
                  in the box; of a volume, at its outermost samples */
    qn_creases creases;
    bool keep_flat; /* leave flat parts and straight edges divided as the octree is, not merged */
    double cell;    /* size of the finest cells, world units, in place of a depth; 0: by depth */
} qn_solid_surface_options;

static inline void qn_solid_surface_options_init(qn_solid_surface_options *options) {
    qn_solid_surface_options zero;
    char *byte = (char *)&zero;
    for (size_t i = 0; i < sizeof zero; ++i)
        byte[i] = 0;
    *options = zero;
    options->struct_size = sizeof *options;
}

/* How many finest cells the longest side of a solid measures, or of its box when that is given. One
 * depth's cells are halves of the last one's in the same places, so coarse leaves stay where they
 * are at every depth. */
static inline double qn_depth_cells(int32_t depth) {
    return 31.0 / 32 * (double)((int64_t)1 << depth);
}

/* The depth that cells of a size need along a length: the least one of so many cells, from
 * QN_MIN_DEPTH on; more than QN_MAX_DEPTH where none has so many. */
static inline int32_t qn_depth_of_cell(double cell, double length) {
    int32_t depth = QN_MIN_DEPTH;
    while (depth <= QN_MAX_DEPTH && cell * qn_depth_cells(depth) < length)
        ++depth;
    return depth;
}

/* What happened on the way. */
typedef struct qn_solid_surface_report {
    double finest_cell;     /* its edge, world units */
    int64_t blocks;         /* 8^3 Hermite blocks that were sampled */
    int64_t evaluations;    /* values asked of the solid for lattice points */
    int64_t crossings;      /* of finest edges with the surface */
    int64_t multiple_edges; /* finest edges crossed more than once */
    int64_t mended_edges;   /* edges whose crossings did not fit the signs at their ends, or lay too
                               close for floats */
    int64_t leaves;         /* leaves with surface */
    int64_t leaves_by_level[16]; /* finest first */
    int64_t segments;            /* of leaf faces; each used once forward and once reversed */
    int64_t ambiguous_faces;     /* leaf faces with more than one way to pair their crossings */
    int64_t face_features,
        dropped_face_features; /* sharp points on faces; those that escaped or crossed others */
    int64_t loops, smooth_loops, crease_loops, corner_loops, flat_loops;
    int64_t divided_leaves;  /* leaves that were divided again since finer neighbours made them come
                                out badly */
    int64_t escaped_corners; /* corners that lay outside their finest cell and were moved in */
    int64_t reaching_corners; /* corners set in the empty cell beside their own */
    int64_t multiple_cells;   /* cells with two loops or more */
    int64_t moved_loops; /* loops made anew, without their features, since they met another in their
                            cell */
    int64_t nested_cells;     /* cells where that took the last resort, nested boxes */
    int64_t unresolved_cells; /* cells where no way without a crossing was found: 0 unless there is
                                 a flaw */
    int64_t vertices, triangles, crease_edges;
    int64_t output_bytes, scratch_bytes;
    double seconds_sampling, seconds_octree, seconds_cms, seconds_total;
    bool creases;          /* of a volume: sharp edges were looked for */
    double distance_share; /* of a volume: of its surface, what has slopes of unit length; looked at
                            * with QN_CREASES_ON and _AUTO */
    int64_t sharp_crossings; /* of a volume: crossings found from planes on either side of a crease
                              * instead of between samples */
    int64_t tubes;           /* cells where two loops are one tube (internal ambiguity) */
    int64_t nested_tubes;    /* those of them that took the last resort, nested boxes */
    int64_t lost_tubes; /* tubes for which no way without a crossing was found: left as two discs */
    bool rounded; /* a volume whose matrix is oblique, or whose coordinates are large for its cells:
                   * vertices were rounded to floats again when they were moved to the world */
    int64_t united_cells;  /* boxes of 2 to 8 finest cells made as one, since a corner or crease
                            * pokes through a wall between them where no lattice edge tells */
    int64_t split_loops;   /* loops cut in parts, since they hold several corners or creases */
    int64_t flat_vertices; /* dropped within flat parts and along straight edges between them */
    int64_t skipped_steps; /* finest cells where creases seem to run out and that were not looked at
                              closely, being many: facets as small as cells */
    int64_t kept_regions; /* flat parts left divided, since merged ones would meet other surfaces */
} qn_solid_surface_report;

/* Extract the surface of a solid by adaptive Cubical Marching Squares: triangles wound
 * counter-clockwise seen from outside, closed, sharp edges kept; the owner of each triangle and the
 * edges along creases are tagged.
 *
 * solid       borrowed for the call.
 * options     NULL for defaults.
 * mesh_out    receives a new mesh, to be freed with qn_mesh_destroy(); NULL on any failure. A box
 * without surface gives an empty mesh, not an error. report_out  may be NULL.
 *
 * Lattice planes lie where floats lie, so that what is decided holds for the coordinates as
 * written. A NaN value is outside. Parts thinner than a finest cell that no lattice edge meets can
 * be missed. The result is the same, bit for bit, for every thread count.
 *
 * QN_ERROR_INVALID_ARGUMENT  depth, base or box out of range; a lattice too fine for float
 * coordinates at its place QN_ERROR_OUT_OF_MEMORY     the allocator returned NULL; or more vertices
 * than 30 bits can name QN_ERROR_CANCELLED         the progress callback, or the solid's, asked to
 * stop QN_ERROR_UNSUPPORTED       built without -Dlapacke
 *
 * Source: Ho, Wu, Chen, Chuang, Ouhyoung, "Cubical marching squares", 2005 [CMS05]. Departures:
 * cms/README.md. */
QN_API qn_status qn_solid_surface(qn_context *context, const qn_solid *solid,
                                  const qn_solid_surface_options *options, qn_mesh **mesh_out,
                                  qn_solid_surface_report *report_out, qn_error *error);

/* The same for the trilinear interpolant of a volume at an iso-value: finest cells are those
 * between its samples, coarse ones where it is flat within options->tolerance. Closed half a voxel
 * beyond the outermost samples unless options->open. The faces of finest cells are settled by the
 * asymptotic decider and their insides by the interpolant's own tunnels, so that `uniform` with
 * `no_features` is a topologically correct marching cubes.
 *
 * options  as for solids; depth and box must be left at 0. Sharp edges only with options->creases.
 *
 * All that is promised of the mesh holds for the coordinates as written where the volume's matrix
 * sends axes to axes; else report->rounded is set: the mesh was made in the volume's own axes and
 * then moved, and what is nearer than float rounding can come to touch.
 *
 * Non-finite samples, threads and errors as for qn_surface() and qn_solid_surface(). Source:
 * [CMS05]; the decider and tunnels: [DMC21] section 3 and 5. */
QN_API qn_status qn_surface_adaptive(qn_context *context, const qn_volume *volume, double isovalue,
                                     qn_inside inside, const qn_solid_surface_options *options,
                                     qn_mesh **mesh_out, qn_solid_surface_report *report_out,
                                     qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
