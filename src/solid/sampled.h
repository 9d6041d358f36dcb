// SPDX-License-Identifier: MIT
/* The solid that a volume's trilinear interpolant bounds, in coordinates of its own: its frame. */
#ifndef QNI_SOLID_SAMPLED_H
#define QNI_SOLID_SAMPLED_H

#include <qn/volume.h>
#include "core/round.h"
#include "solid/solid.h"

/* Where the samples lie. Point i of axis k is at qni_sample_plane(frame, k, i): a float, exactly,
 * so that what lies on a plane can be written. Points are those of a closed field: number 0 and the
 * last one are the virtual layer outside.
 *
 * Matrices that send axes to axes are taken up by origin and step, and to_world is a signed
 * permutation, which moves floats without rounding. Others keep only the steps here. */
typedef struct qni_sample_frame {
    double origin[3], step[3]; /* step > 0 */
    double per_step[3];        /* cells to a unit of length, about */
    int32_t count[3];          /* points */
    double to_world[3][4];
    bool exact;  /* to_world moves floats to floats */
    bool turned; /* to_world mirrors */
} qni_sample_frame;

static inline double qni_sample_plane(const qni_sample_frame *frame, int axis, int64_t point) {
    return qni_rounded_to_float(frame->origin[axis] + frame->step[axis] * (double)point);
}

/* The frame of a field: its points and its matrix from there to the world. */
void qni_sample_frame_init(qni_sample_frame *frame, const double world[3][4],
                           const int64_t points[3]);

typedef struct qni_sampled_settings {
    double isovalue;
    bool inside_below;
    int32_t owner;
    bool every_leaf;      /* bounds know values, not only signs, away from the surface */
    bool creases;         /* f is a distance: creases are brought back (sampled_sharp.h) */
    double least_share;   /* unless less than this share of it looks like a distance */
    double crease_cosine; /* normals that differ by more make one */
} qni_sampled_settings;

/* In the frame's coordinates. The volume is borrowed while the solid lives. */
qn_status qni_sampled_create(qn_context *context, const qn_volume *volume,
                             const qni_sampled_settings *settings, qn_solid **solid_out,
                             qn_error *error);

/* Of a solid of this kind, whole or restricted; NULL for others. */
const qni_sample_frame *qni_sampled_frame(const qn_solid *solid);
/* Leaves (8^3 cells of the frame's points from point 0 on) in which signs differ. */
const int32_t (*qni_sampled_mixed_leaves(const qn_solid *solid, int64_t *count_out))[3];
/* How much of the surface, of lattice edges along x that cross it, has slopes of unit length, as
 * distances have; looked at where creases are wanted. */
double qni_sampled_distance_share(const qn_solid *solid);
bool qni_sampled_has_creases(const qn_solid *solid);
/* Crossings of lattice edges that planes gave, so far. */
int64_t qni_sampled_sharp_crossings(const qn_solid *solid);
/* f at the eight corners of a cell; corner x + 2 y + 4 z. False beyond the frame. */
bool qni_sampled_corners(const qn_solid *solid, const int64_t cell[3], double corner[8]);

/* ---- leaves and their ranges (sampled_leaves.c) ------------------------------------------------
 */

struct qni_field;

typedef struct qni_leaf_node {
    uint64_t key;  /* Morton code of its leaves, less 3 bits a level */
    int64_t first; /* child, in the level below */
    int64_t leaves;
    double range[2]; /* of f over all samples of its leaves */
} qni_leaf_node;

enum { QNI_LEAF_LEVELS = 22 };

typedef struct qni_leaf_tree {
    qni_leaf_node *nodes[QNI_LEAF_LEVELS];
    int64_t counts[QNI_LEAF_LEVELS];
    int32_t levels;
    bool complete; /* leaves that are not here hold one value */
    int32_t (*mixed)[3];
    int64_t mixed_count, mixed_capacity;
} qni_leaf_tree;

/* f of a field's value: negative inside; a sample at the iso-value is above. */
static inline double qni_sampled_sign(bool inside_below, double value) {
    return inside_below ? value : value == 0 ? -1e-300 : -value;
}

/* Measures the field's non-finite samples where that is needed. */
qn_status qni_leaf_tree_build(qn_context *context, struct qni_field *field, bool every_leaf,
                              qni_leaf_tree *tree, qn_error *error);
void qni_leaf_tree_free(qn_context *context, qni_leaf_tree *tree);
/* The range over leaves low to high, both included; false when none of them is in the tree. */
bool qni_leaf_tree_range(const qni_leaf_tree *tree, const int32_t low[3], const int32_t high[3],
                         double range[2]);

#endif
