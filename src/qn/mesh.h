// SPDX-License-Identifier: MIT
/* Meshes: vertices with shared indices, quads and triangles; checks, files, pictures. */
#ifndef QN_MESH_H
#define QN_MESH_H

#include <qn/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Plain view of a mesh: arrays it lends. Faces are wound counter-clockwise seen from outside. The
 * face of index f is quad f for f < quad_count, else triangle f - quad_count. */
typedef struct qn_mesh_view {
    int64_t vertex_count;
    int64_t quad_count;
    int64_t triangle_count;
    const float *positions; /* [vertex_count][3], world units */
    const float *normals;   /* [vertex_count][3], unit length, out of the solid; NULL when absent */
    const uint32_t *quads;  /* [quad_count][4]; NULL when there are none */
    const uint32_t *triangles;      /* [triangle_count][3]; NULL when there are none */
    const char *space;              /* name of the world space ("RAS"), or "" */
    const char *unit;               /* unit of length ("mm"), or "" */
    const int32_t *triangle_owners; /* [triangle_count]: the owner (material) each lies on; NULL
                                       when not known */
    int64_t crease_edge_count;
    const uint32_t *crease_edges; /* [crease_edge_count][2]: edges along sharp features; NULL when
                                     there are none */
    const int32_t *quad_owners;   /* [quad_count], as triangle_owners; NULL when not known */
} qn_mesh_view;

typedef struct qn_mesh qn_mesh;

/* Make a mesh by copying a view.
 * QN_ERROR_INVALID_ARGUMENT  a negative count, more than 2^32 - 1 vertices, an index out of range
 */
QN_API qn_status qn_mesh_create(qn_context *context, const qn_mesh_view *view, qn_mesh **mesh_out,
                                qn_error *error);
QN_API void qn_mesh_destroy(qn_mesh *mesh);
/* The arrays stay valid until the mesh is changed or destroyed. */
QN_API qn_mesh_view qn_mesh_get_view(const qn_mesh *mesh);

/* Split every quad into two triangles along the diagonal that makes the smallest angle largest
 * (the MaxMin angle criterion of [DMC21] section 5.3; ties take the diagonal from the quad's first
 * corner), or along the other one where an edge of other faces lies there, so that a manifold stays
 * one. Files without quads (STL, GLB), qn_mesh_check() and qn_mesh_compare() cut them alike. Quads
 * whose diagonals both are edges elsewhere keep the first; a warning is logged with their number.
 */
QN_API qn_status qn_mesh_triangulate(qn_context *context, qn_mesh *mesh, qn_error *error);

/* ---- halfedges ------------------------------------------------------------------------------- */

/* No halfedge: the twin of one on the boundary, the halfedge of a vertex that no face uses. */
#define QN_NO_HALFEDGE UINT32_C(0xffffffff)

/* Neighbourhood of a mesh of quads alone (corners = 4) or of triangles alone (corners = 3).
 * Halfedge h runs along side h % corners of face h / corners, from that corner to the next; so
 * origin, face and next need no memory: origin = quads[h], face = h / corners, next = h + 1, or h +
 * 1 - corners after the last side. */
typedef struct qn_halfedges {
    int32_t corners;
    int64_t count;        /* corners * faces */
    const uint32_t *twin; /* [count]: the halfedge of the other face at this side; QN_NO_HALFEDGE on
                             the boundary */
    const uint32_t *vertex_halfedge; /* [vertex_count]: a halfedge that starts at the vertex: of
                                      * an open fan the one without a twin, from which turning
                                      * (next of twin of previous) meets the whole fan; of a closed
                                      * fan any. Which one it is may change with the version */
} qn_halfedges;

/* The halfedges of a mesh that has them, else count 0. They belong to the mesh, and end with its
 * next change. */
QN_API qn_halfedges qn_mesh_get_halfedges(const qn_mesh *mesh);

/* Find the halfedges of any mesh of quads alone or triangles alone from its indices, in O(n log n).
 * Sides used by two faces in opposite directions are twins; any others are left without.
 * (qn_surface() can give the halfedges with the mesh, in linear time, and pairs the four faces at a
 * doubled edge as the surface does.) QN_ERROR_INVALID_ARGUMENT  quads and triangles mixed; more
 * than 2^32 - 2 halfedges */
QN_API qn_status qn_mesh_build_halfedges(qn_context *context, qn_mesh *mesh, qn_error *error);

/* ---- creases --------------------------------------------------------------------------------- */

/* A copy for drawing, with normals that jump at the mesh's crease edges: round each vertex the
 * faces between two creases share a normal (the mean of the faces', weighted by their angles) and a
 * vertex of their own. So the copy is open along creases; the mesh itself stays as it is. Owners
 * and creases are not copied.
 *
 * QN_ERROR_INVALID_ARGUMENT  the mesh has quads */
QN_API qn_status qn_mesh_split_normals(qn_context *context, const qn_mesh *mesh,
                                       qn_mesh **split_out, qn_error *error);

/* ---- curvature ------------------------------------------------------------------------------- */

/* Mean and Gaussian curvature at every vertex, from how the normals turn between it and the corners
 * of its faces; of the mesh's normals where it has them (more accurate by far on iso-surfaces),
 * else of its faces'.
 *
 * mean_out      [vertex_count], 1 / length: half the sum of the principal curvatures, positive
 * where the surface falls away from its normal on both sides (a sphere of radius r with normals
 * outward: 1 / r). May be NULL. gaussian_out  [vertex_count], 1 / length^2: their product. May be
 * NULL.
 *
 * Both are 0 at vertices without faces, or whose neighbours do not span a plane. The same for every
 * thread count.
 *
 * Source: Goldfeather and Interrante, "A novel cubic-order algorithm for approximating principal
 * direction vectors", 2004. Departure: normals alone are fitted, positions of iso-surfaces being
 * too rough for second derivatives. */
QN_API qn_status qn_mesh_get_curvature(qn_context *context, const qn_mesh *mesh, float *mean_out,
                                       float *gaussian_out, qn_error *error);

/* ---- checks ---------------------------------------------------------------------------------- */

typedef struct qn_mesh_check_options {
    size_t struct_size;
    bool skip_intersections; /* leave out the costliest part */
} qn_mesh_check_options;

static inline void qn_mesh_check_options_init(qn_mesh_check_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* What a mesh is. Edges are undirected pairs of vertex indices; quads count for geometry as the two
 * triangles of their MaxMin split. Vertices that no face uses are counted and otherwise ignored.
 *
 * Polygons.       In a face that names a vertex twice in a row the two corners are taken as one.
 * When fewer than three different corners are left, or a vertex still comes twice, the face is no
 * polygon: it is counted as degenerate and otherwise ignored. Fans.           Faces round a vertex
 * belong to one fan when edges at that vertex join them, also edges of more than two faces: two
 * cubes that share an edge have one non-manifold edge and no non-manifold vertex, two that share a
 * corner have one non-manifold vertex. A mesh with neither is a 2-manifold, with boundary edges or
 * without. Genus.          Of each component alone; one that is pinched, its own fans meeting at a
 * vertex, has none. Geometry.       Faces with a vertex that is not finite are left out of bounds,
 * area, volume, shape and self-intersections. The volume of a mesh that is not closed is measured
 * from the centre of its bounds. Figures of shape are 0 where there is nothing to measure.
 * Intersections.  Pairs of triangles. Without a common vertex index any contact counts, be it of
 * two vertices at one place (join equal positions first to judge a mesh whose patches repeat their
 *                 seams); with one, contact beyond that vertex; with two, an overlap in one plane;
 * the same three vertices always. Triangles without area are left out: they are counted above. */
typedef struct qn_mesh_report {
    int64_t vertex_count, quad_count, triangle_count, edge_count;
    int64_t unused_vertices;
    int64_t boundary_edges;        /* used by one face */
    int64_t nonmanifold_edges;     /* used by more than two faces */
    int64_t orientation_conflicts; /* edges of two faces that both run along them the same way */
    int64_t nonmanifold_vertices;  /* the faces round the vertex form more than one fan */
    int64_t degenerate_faces; /* a repeated vertex index, or exactly no area in float coordinates */
    int64_t duplicate_faces;  /* faces with the same set of vertices as an earlier one */
    int64_t duplicate_positions; /* vertices at exactly the same place as an earlier one */
    int64_t nonfinite_vertices;
    int64_t self_intersections; /* pairs of triangles that meet outside shared vertices and edges;
                                   -1: not tested */
    int64_t components;         /* connected by shared edges */
    int64_t closed_components;
    int64_t euler_characteristic; /* used vertices - edges + faces */
    int64_t genus_sum;            /* over the closed, manifold, oriented components */
    int64_t largest_genus;
    bool closed;         /* no boundary edge */
    bool manifold;       /* no non-manifold edge or vertex */
    bool oriented;       /* no orientation conflict */
    double area;         /* square world units */
    double volume;       /* cubic world units, signed: positive when faces are wound outward */
    double bounds[2][3]; /* smallest and largest coordinates of used vertices */
    /* Shape, as in [DMC21] section 5.3: mean and least of equation (9) over the quads and of
     * equation (8) over the triangles (when there are quads, over the triangles of their MaxMin
     * split as well). */
    double quad_quality_mean, quad_quality_min;
    double triangle_quality_mean, triangle_quality_min;
    double smallest_angle;     /* degrees, over the triangles */
    double irregular_vertices; /* share of inner vertices of valence other than 4 (quads) or 6
                                  (triangles) */
} qn_mesh_report;

/* Measure a mesh. Self-intersections are found with exact predicates on the coordinates as they
 * are. options may be NULL. */
QN_API qn_status qn_mesh_check(qn_context *context, const qn_mesh *mesh,
                               const qn_mesh_check_options *options, qn_mesh_report *report_out,
                               qn_error *error);

/* ---- distances between two meshes ------------------------------------------------------------ */

typedef struct qn_mesh_compare_options {
    size_t struct_size;
    int64_t samples; /* points taken on each mesh, beside its vertices; 0: 100,000 */
} qn_mesh_compare_options;

static inline void qn_mesh_compare_options_init(qn_mesh_compare_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* How far points of one mesh are from the other, in world units; angles in degrees. The largest
 * figures are over all vertices of faces and all samples; means are over the samples, of which each
 * stands for an equal share of the area. */
typedef struct qn_mesh_distance {
    int64_t points;     /* vertices and samples that were measured */
    double max;         /* the one-sided Hausdorff distance, from below */
    double mean, rms;   /* of the distances */
    double farthest[3]; /* where max was found */
    double normal_mean; /* angle between the normals of the sampled and the nearest face */
    double normal_max;
    double normal_beyond_30; /* share of the area where that angle is more than 30 degrees */
} qn_mesh_distance;

typedef struct qn_mesh_comparison {
    qn_mesh_distance a_to_b, b_to_a;
    double max;            /* the Hausdorff distance, from below: the larger of the two */
    double mean, rms;      /* of both together, by area */
    double diagonal;       /* of the box round a: what relative figures are taken by */
    double area_a, area_b; /* square world units */
    double volume_a,
        volume_b; /* signed; of meshes that are not closed, from the middle of a's box */
} qn_mesh_comparison;

/* Measure how far two meshes are apart, one way and the other. Distances are exact (in double) for
 * the points taken: all vertices that faces use, and points spread evenly over the area, the same
 * in every run and for every thread count. Faces without area or with vertices that are not finite
 * are left out; quads count as their two triangles.
 *
 * QN_ERROR_EMPTY             one of the meshes has no face with an area
 * QN_ERROR_INVALID_ARGUMENT  a negative number of samples; coordinates beyond 1e18 */
QN_API qn_status qn_mesh_compare(qn_context *context, const qn_mesh *a, const qn_mesh *b,
                                 const qn_mesh_compare_options *options,
                                 qn_mesh_comparison *comparison_out, qn_error *error);

/* ---- files ----------------------------------------------------------------------------------- */

typedef struct qn_mesh_write_options {
    size_t struct_size;
    char format[8]; /* "" by the file's name; "ply" "obj" "stl" "off" "glb" */
    bool ascii;     /* PLY and STL: text instead of binary */
    bool skip_normals;
    bool split_normals; /* PLY, OBJ, GLB: normals as of qn_mesh_split_normals(), vertices along
                           creases doubled in the file; the other formats have no normals at
                           vertices and are written as ever */
    bool curvature;     /* PLY only: mean and Gaussian curvature of each vertex as of
                           qn_mesh_get_curvature(), the properties mean_curvature and
                           gaussian_curvature; not together with split_normals */
} qn_mesh_write_options;

static inline void qn_mesh_write_options_init(qn_mesh_write_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* Write a mesh: PLY, OBJ, STL, OFF, GLB. The file appears whole or not at all: it is written under
 * a temporary name in the same folder and renamed; what is there and is not a regular file
 * (/dev/stdout, a FIFO) is written directly. STL and GLB hold triangles only: quads are split as by
 * qn_mesh_triangulate(). options may be NULL.
 *
 * Coordinates are written as they are, in every format; text has the fewest digits that read back
 * to the same floats. PLY names space and unit in comments, GLB in asset.extras (glTF itself says
 * metres and y up: scale and turn the mesh before where that matters). Nothing in a file changes
 * from run to run.
 *
 * QN_ERROR_OUTPUT            the folder is missing, the disk is full, no right to write
 * QN_ERROR_INVALID_ARGUMENT  no such format; a mesh too large for the format */
QN_API qn_status qn_mesh_write(qn_context *context, const qn_mesh *mesh, const char *path,
                               const qn_mesh_write_options *options, qn_error *error);

/* Read a mesh: PLY, OBJ, STL, OFF, GLB, glTF (each also as .gz). Polygons of more than four corners
 * are split into triangles, which come after the file's own; faces of fewer than three corners are
 * left out with a warning. The vertices of an STL file are joined where their coordinates are
 * equal, numbered as they first appear; so are those of a glTF file, after its nodes have moved
 * them. The data of a .gltf file is in it as base64, or in files in its folder or below; skins,
 * morph targets and compressed meshes are not looked at or refused by name.
 * Owners: materials of OBJ and glTF files from 1, in OBJ files without any their groups; the first
 * of owner, material_index, material and group that the faces of a PLY file have. Normals are read
 * from PLY and OFF. Coordinates that are not finite are kept: qn_mesh_check() counts them.
 *
 * format   NULL or "": by the file's name and first bytes.
 *
 * QN_ERROR_INPUT             no such file, cut short, damaged; the message names the file and the
 *                            line or byte
 * QN_ERROR_INVALID_ARGUMENT  no such format */
QN_API qn_status qn_mesh_read(qn_context *context, const char *path, const char *format,
                              qn_mesh **mesh_out, qn_error *error);

/* ---- pictures -------------------------------------------------------------------------------- */

typedef struct qn_view_options {
    size_t struct_size;
    int32_t width, height; /* pixels; 0: 800 x 600 */
    double azimuth; /* degrees: where the camera stands, turning about world z from +x towards +y */
    double elevation; /* degrees above the xy plane */
    bool has_angles;  /* false: azimuth 40, elevation 25 */
    double zoom;      /* 0 stands for 1: the whole mesh just fits */
    bool edges;       /* draw the mesh's edges */
    bool flat;        /* shade by face, not by vertex normals */
} qn_view_options;

static inline void qn_view_options_init(qn_view_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
}

/* Draw a shaded picture of a mesh into a PNG file, with a z-buffer of its own: no display, no GPU.
 * The back of faces is drawn in another colour, so that holes and turned faces are seen.
 * QN_ERROR_UNSUPPORTED  built without -Dpng */
QN_API qn_status qn_mesh_write_picture(qn_context *context, const qn_mesh *mesh, const char *path,
                                       const qn_view_options *options, qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
