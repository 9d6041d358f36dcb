// SPDX-License-Identifier: MIT
/* Narrow bands: sparse volumes of distances round the surface of a mesh or a solid. */
#ifndef QN_BAND_H
#define QN_BAND_H

#include <qn/mesh.h>
#include <qn/solid.h>
#include <qn/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qn_band_options {
    size_t struct_size; /* set by qn_band_options_init() */
    double voxel;       /* distance between samples, world units; 0: from dim */
    int32_t dim;        /* voxels along the longest side of the box of the mesh or solid; 0: 128 */
    double half_width;  /* of the band, in voxels to either side of the surface; 0: 3; at least 2 */
    qn_mesh_sign sign;  /* of meshes: what says which points are inside */
    double offset;   /* world units: the surface of all points that far outside; negative: inside */
    double shell;    /* thickness, world units: a wall, half to each side of that surface; 0: none
                      */
    bool has_origin; /* the world place of sample (0, 0, 0); else half a voxel off the low corner */
    double origin[3];
} qn_band_options;

static inline void qn_band_options_init(qn_band_options *options) {
    qn_band_options zero;
    char *byte = (char *)&zero;
    for (size_t i = 0; i < sizeof zero; ++i)
        byte[i] = 0;
    *options = zero;
    options->struct_size = sizeof *options;
}

/* What happened on the way. */
typedef struct qn_band_report {
    double voxel, background; /* world units */
    int64_t leaf_count, tile_count;
    int64_t active_count;      /* samples in the band */
    int64_t visited_nodes;     /* boxes looked at in the search for leaves */
    int64_t triangles;         /* of the mesh, those with an area; quads count twice */
    qn_mesh_sign sign;         /* what was used */
    int64_t lines;             /* lattice lines along x that the mesh was cut with */
    int64_t disagreeing_lines; /* those that end inside: they pass through holes or turned faces */
    int64_t torn_pairs; /* neighbouring samples on two sides of no face: a hole that lines missed */
    int64_t holes;      /* closed by sheets; turned faces and holes are looked for only when */
    int64_t turned_triangles; /* lines disagree */
    double seconds_tree, seconds_lines, seconds_discovery, seconds_values, seconds_total;
} qn_band_report;

/* The signed distance field of a mesh as a narrow band: a sparse level set of 32-bit floats.
 *
 * Samples nearer to the surface than the half width have their exact distance to the nearest
 * triangle (found and rounded once, from double), less `offset`, negative inside; with a shell, the
 * distance to the middle of the wall less half its thickness. The rest is background outside and
 * minus the background, in tiles, inside. Memory and time go with the surface, not with the box.
 *
 * Signs come from the lattice lines along x: faces are counted where lines pass through them, with
 * one rule for edges and corners that cancels exactly wherever faces do, so a closed mesh cannot
 * leak, whatever its triangles are like. Where lines do not all end outside (holes, faces turned
 * round) signs are those of qn_solid_from_mesh(), and so are values over holes.
 *
 * mesh        borrowed for the call.
 * options     NULL for defaults.
 * volume_out  receives a new volume, to be freed with qn_volume_destroy(); NULL on any failure.
 * report_out  may be NULL.
 *
 * The result is the same, bit for bit, for every thread count.
 *
 * QN_ERROR_EMPTY             the mesh has no face with an area
 * QN_ERROR_INVALID_ARGUMENT  a voxel, width, offset or shell out of range; too fine a lattice
 *                            (2^30 samples along an axis, 2^31 lines)
 * QN_ERROR_OUT_OF_MEMORY, QN_ERROR_CANCELLED */
QN_API qn_status qn_volume_from_mesh(qn_context *context, const qn_mesh *mesh,
                                     const qn_band_options *options, qn_volume **volume_out,
                                     qn_band_report *report_out, qn_error *error);

/* The values of a solid's function near its surface, as a sparse volume of 32-bit floats, for
 * surfacers that take volumes and for files.
 *
 * The values are f (less `offset`; with a shell |f - offset| - shell / 2) as the solid gives them,
 * negative inside: a distance only where f is one. They are not cut off at the half width; leaves
 * are those where the solid's bounds, or where it has none its samples, leave room for the surface,
 * with two samples more to each side. Elsewhere is the largest value there is, or minus that
 * inside. For true distances make a mesh with qn_solid_surface() and take qn_volume_from_mesh().
 *
 * Parts thinner than a voxel can be missed. A solid without bounds is sampled everywhere in its
 * box. `sign` is not used. All else is as with qn_volume_from_mesh().
 *
 * QN_ERROR_EMPTY             the solid is empty, or its surface was not met
 * QN_ERROR_INVALID_ARGUMENT  the solid has no end; options as above
 * QN_ERROR_OUT_OF_MEMORY, QN_ERROR_CANCELLED */
QN_API qn_status qn_volume_from_solid(qn_context *context, const qn_solid *solid,
                                      const qn_band_options *options, qn_volume **volume_out,
                                      qn_band_report *report_out, qn_error *error);

#ifdef __cplusplus
}
#endif
#endif
