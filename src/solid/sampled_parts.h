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
static inline double mix(double a, double b, double t) {
    return (1 - t) * a + t * b;
}

#endif
