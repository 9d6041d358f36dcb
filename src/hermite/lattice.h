// SPDX-License-Identifier: MIT
/* The finest lattice of a solid: its planes are floats, exactly. Of a solid made of samples they
 * are the planes of the samples, else they lie off round numbers. */
#ifndef QNI_HERMITE_LATTICE_H
#define QNI_HERMITE_LATTICE_H

#include "core/round.h"
#include "solid/solid.h"

/* Plane i of an axis is at the float next to origin + step (i - shift).
 *
 * Where planes may be chosen, the solid's longest side is 31/32 2^depth cells, and the planes of a
 * depth are among those of the next one: coarse cells lie in the same place at every depth. They
 * miss the round coordinates that models are full of. */
typedef struct qni_lattice {
    double origin[3], step[3];
    int32_t shift[3];
    double cell;      /* the largest step */
    double clearance; /* crossings keep this far from lattice points */
    int32_t cells[3]; /* a whole number of roots, and of blocks */
    int32_t top;      /* roots are 2^top finest cells wide */
    bool samples;     /* planes are those of samples: along its edges the solid's f is linear */
    qni_box bounds;   /* the solid is cut there; strictly within the lattice */
} qni_lattice;

static inline double qni_lattice_at(const qni_lattice *lattice, int axis, int32_t plane) {
    return qni_rounded_to_float(lattice->origin[axis] +
                                lattice->step[axis] * (double)(plane - lattice->shift[axis]));
}

/* Cells of extent / (31/32 2^depth), one layer and more of them round the bounds: from depth 7 on
 * no more than 2^depth along an axis in all, when the bounds are little longer than the extent. */
qn_status qni_lattice_init(qni_lattice *lattice, const qni_box *bounds, double extent,
                           int32_t depth, int32_t base, qn_error *error);
/* The lattice of the samples of a solid made from a volume, in its frame, a block of cells and more
 * round it; `open`: cut at the outermost samples. */
qn_status qni_lattice_of_samples(qni_lattice *lattice, const qn_solid *solid, int32_t base,
                                 bool open, qn_error *error);

#endif
