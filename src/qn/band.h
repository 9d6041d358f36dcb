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

/* What says which points are inside a mesh. */
typedef enum qn_band_sign {
    QN_BAND_SIGN_AUTO,    /* winding */
    QN_BAND_SIGN_PARITY,  /* inside is behind an odd number of faces, whichever way they are turned
                           */
    QN_BAND_SIGN_WINDING, /* inside is where the winding number is not 0: overlaps are one */
} qn_band_sign;

typedef struct qn_band_options {
    size_t struct_size; /* set by qn_band_options_init() */
    double voxel;       /* distance between samples, world units; 0: from dim */
    int32_t dim;        /* voxels along the longest side of the box of the mesh or solid; 0: 128 */
    double half_width;  /* of the band, in voxels to either side of the surface; 0: 3; at least 2 */
    qn_band_sign sign;  /* of meshes */
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
    qn_band_sign sign;         /* what was used */
    int64_t lines;             /* lattice lines along x that the mesh was cut with */
    int64_t disagreeing_lines; /* those that end inside: they pass through holes or turned faces */
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
 * leak, whatever its triangles are like. A line that does not end outside is counted.
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

#ifdef __cplusplus
}
#endif
#endif
