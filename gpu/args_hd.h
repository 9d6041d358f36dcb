// SPDX-License-Identifier: MIT
/* What every kernel of one call is given, by value. Pointers are memory of the device. Numbers of
 * leaves, vertices and quads come from exclusive scans of integers, so they do not depend on the
 * order in which blocks run.
 *
 * A slab holds its own layers of leaves and some on either side (slabs.c). All in it is numbered
 * as if it were the whole volume; at the end its own part is renumbered. */
#ifndef QNI_GPU_ARGS_HD_H
#define QNI_GPU_ARGS_HD_H

#include "dmc/frame_hd.h"
#include "gpu/field_hd.h"

/* What is counted in each leaf with surface. The first ones are turned into places by a scan, of
 * the others only the sums are wanted. */
enum {
    QNI_GPU_VERTICES,
    QNI_GPU_QUADS,
    QNI_GPU_MULTIS,  /* cells with several polygons */
    QNI_GPU_DOUBLED, /* doubled edges */
    QNI_GPU_PLACED,
    QNI_GPU_CELLS = QNI_GPU_PLACED,
    QNI_GPU_AMBIGUOUS,
    QNI_GPU_TIED,
    QNI_GPU_CHANNELS
};

/* How vertices were found; counted in stripes, so that adders do not wait for each other. */
enum {
    QNI_GPU_BY_SLICE,
    QNI_GPU_DEGENERATE,
    QNI_GPU_BY_FALLBACK,
    QNI_GPU_NO_GRADIENT,
    QNI_GPU_TALLIES,
    QNI_GPU_STRIPES = 32
};

/* Numbers the device finds out, and the host reads in one piece. */
typedef struct qni_gpu_totals {
    uint64_t leaves;                     /* of the slab; set by the host */
    uint64_t active;                     /* of them with surface */
    uint64_t channels[QNI_GPU_CHANNELS]; /* sums over the active leaves */
    uint64_t mark_words;                 /* words of quad marks; set by the host */
    uint64_t splits;                     /* quads to be split */
    uint64_t split_quads;                /* quads they add */
    /* Simplification: quads that nothing is decided of, that went, points out of reach; how many
     * vertices and quads there are (set by the host), and are left. */
    uint64_t open, merged, shrunk, unprojected, lengths[2], packed[2];
    uint64_t left_on_face; /* points of doubled edges that stay on their face */
    /* Where the own part of a slab begins and ends among all that the slab holds. */
    uint64_t own_active[2], own[2][QNI_GPU_CHANNELS], own_splits[2], own_split_quads[2];
    uint64_t tally[QNI_GPU_STRIPES][QNI_GPU_TALLIES];
    uint64_t nonfinite; /* a sample that is not finite was met */
    uint64_t nan_count, infinite_count;
    uint64_t largest_bits; /* of |value - iso| over finite samples, as a double */
} qni_gpu_totals;

/* A leaf with surface: cells by slice, and how many come before each slice. */
typedef struct qni_gpu_leaf {
    uint64_t active[8];
    uint16_t before[8];
} qni_gpu_leaf;

/* Its quads by axis and slice; only where halfedges or repair need them. */
typedef struct qni_gpu_quads {
    uint64_t mask[3][8];
    uint16_t before[3][8];
} qni_gpu_quads;

/* A cell with several polygons, as qni_multi_cell. */
typedef struct qni_gpu_multi {
    uint16_t cell, extra_before, entry;
} qni_gpu_multi;

/* A doubled edge, as qni_doubled_face. */
typedef struct qni_gpu_doubled {
    int32_t cell[3];
    uint8_t axis, first_cut;
} qni_gpu_doubled;

/* A quad to be split at doubled edges; qni_quad_split without tunnels. */
typedef struct qni_gpu_split {
    uint32_t quad;
    uint32_t corners[4];
    uint32_t twins[4];
    int32_t point[3];
    int32_t points[4]; /* by ring side: first of its two points, or -1 */
    uint8_t axis, quads, forward, turn;
} qni_gpu_split;

/* From numbers in a slab to numbers in the mesh: what is added, modulo 2^32. */
typedef struct qni_gpu_shifts {
    uint32_t vertices, points, centres; /* of the plain mesh; of doubled edges; of split quads */
    uint32_t quads, extra_quads;
} qni_gpu_shifts;

typedef struct qni_gpu_args {
    qni_gpu_field field;
    qni_frame frame;
    qni_gpu_totals *totals;

    uint32_t *signs; /* bit x of lattice line (y, z) from word ((z - z0) points_y + y) line_words */
    int64_t line_words;
    uint16_t *leaf_signs; /* sparse: [key][line of 81] in its place */
    int64_t sign_planes;  /* lattice planes with signs, from 8 first_layer on */

    int64_t measured_from,
        measured_planes; /* planes of samples to be searched for non-finite ones */

    uint32_t *slot;        /* [leaves + 1] flags, then the leaf's place among the active ones */
    uint32_t *active_leaf; /* [active] which leaf */
    uint32_t *counts;      /* [channel][count_stride]: counts, then places, of active leaves */
    int64_t count_stride;
    qni_gpu_leaf *leaves;
    qni_gpu_quads *leaf_quads;
    qni_gpu_multi *multis;
    qni_gpu_doubled *doubled;

    /* The scan at hand: channels of length *scan_length + 1, the last taking the sum. */
    uint32_t *scan_data;
    int64_t scan_stride, scan_channels, scan_placed;
    const uint64_t *scan_length;
    uint64_t *scan_sums; /* [channel][scan_tiles] */
    int64_t scan_tiles;
    uint64_t *scan_totals;

    int32_t own_layers[2];            /* first and end: the others belong to the slabs beside */
    int64_t first_slot, end_slot;     /* active leaves whose vertices and quads are written */
    int64_t first_linked, end_linked; /* active leaves whose low faces join quads */
    uint32_t own_vertices[2], own_doubled[2]; /* what is counted: first and end */
    float *positions, *normals;               /* normals may be NULL */
    uint32_t *quads, *twins, *vertex_halfedges;
    /* For simplification (dmc/simplify_hd.h), or NULL: a byte a vertex and a quad. Sums are made in
     * whole words, so there is room for these. */
    uint8_t *valences, *colours;

    /* Repair: the plain mesh has so many; what is new comes after. */
    uint32_t plain_vertices, plain_quads;
    int64_t doubled_count;
    uint32_t *marks;       /* a bit a quad that is to be split */
    uint32_t *mark_ranks;  /* [words + 1] splits before each word */
    uint32_t *split_sizes; /* [splits + 1] quads each adds, then those before it */
    qni_gpu_split *splits;

    /* Renumbering: entries from `range_first` on, so many. */
    qni_gpu_shifts shifts;
    int64_t range_first, range_count;

    /* Simplification. A byte of marks a vertex and a quad; places in the packed mesh. */
    uint8_t *vertex_marks, *quad_marks;
    uint32_t *vertex_places, *quad_places;
    float *packed_positions, *packed_normals;
    uint32_t *packed_quads, *packed_twins, *packed_vertex_halfedges;
    double lattice[3][4], world[3][4]; /* world to lattice and back */
    int32_t reproject, colour, rings, middles;

    int32_t with_doubled, keep_doubled, reverse, with_halfedges;
} qni_gpu_args;

#endif
