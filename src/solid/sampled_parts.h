// SPDX-License-Identifier: MIT
/* What a solid of samples keeps. */
#ifndef QNI_SOLID_SAMPLED_PARTS_H
#define QNI_SOLID_SAMPLED_PARTS_H

#include "solid/sampled.h"
#include "solid/sampled_sharp.h"
#include "volume/field.h"

/* Samples of a part of the field, so that restricted solids need not ask the volume. */
typedef struct sample_block {
    int32_t low[3], size[3];
    double *values; /* f: x fastest; NULL: there is no block */
    /* For each sample, what is known of the cell above it: NULL nothing yet, `no_crease`, or its
     * fit; published by atomic exchange, so that any thread may find it first. NULL without
     * creases. */
    const qni_sharp_fit **fits;
} sample_block;

typedef struct sampled_solid {
    qn_solid base;
    const struct sampled_solid *whole; /* itself, or what this one was restricted from */
    sample_block block;
    /* of the whole one */
    qni_field field;
    qni_sample_frame frame;
    qni_leaf_tree tree;
    bool creases;
    double crease_cosine, distance_share;
    int64_t sharp_crossings; /* changed with atomic operations */
} sampled_solid;

/* Exact at both ends. */
static inline double qni_mix(double a, double b, double t) {
    return (1 - t) * a + t * b;
}

static inline int32_t qni_clamped(int64_t value, int64_t low, int64_t high) {
    return (int32_t)(value < low ? low : value > high ? high : value);
}

/* A place in a cell: which cell, and how far along it, 0 to 1. Places beyond the frame are those
 * nearest to them on its border, which lies outside. */
typedef struct qni_cell_place {
    int32_t cell[3];
    double along[3], width[3];
} qni_cell_place;

/* ---- sampled.c */
void qni_locate_axis(const qni_sample_frame *frame, int k, double position, qni_cell_place *place);
qni_cell_place qni_locate(const sampled_solid *s, const double point[3]);
double qni_sampled_mix(const double c[8], const double t[3]);

/* ---- sampled_block.c */
int64_t qni_block_samples(const sample_block *block);
/* NULL when the point is not in the block, or there is none. */
const double *qni_block_find(const sampled_solid *s, const int32_t point[3]);
/* The points that the box's cells, and the slopes at their corners, need; false when they are too
 * many. */
bool qni_block_lay(const sampled_solid *s, const qni_box *box, sample_block *block);
bool qni_block_holds(const sampled_solid *s, const sample_block *block);
void qni_block_fill(const qni_field *field, sample_block *block);
double qni_sample(const sampled_solid *s, const int32_t point[3]);
/* Corner x + 2 y + 4 z of a cell. */
void qni_sampled_load(const sampled_solid *s, const int32_t cell[3], double corner[8]);

/* ---- sampled_fits.c */
/* For a qni_sample_reader, of a sampled_solid. */
double qni_read_sample(const void *samples, const int32_t point[3]);
double qni_read_plane(const void *samples, int axis, int64_t point);
/* What planes make of the cell when a crease runs through it, else NULL. */
const qni_sharp_fit *qni_sampled_fit(const sampled_solid *s, const int32_t cell[3],
                                     const double corner[8], qni_sharp_fit *room);
void qni_sampled_free_fits(sampled_solid *s);

/* ---- sampled_bounds.c, sampled_crossings.c: qni_solid_ops of this kind */
qn_status qni_sampled_bounds_of(const qn_solid *solid, const qni_box *box, double range[2]);
qn_status qni_sampled_crossings_of(const qn_solid *solid, const double a[3], const double b[3],
                                   int32_t capacity, qni_crossing *crossings, int32_t *count_out);

#endif
