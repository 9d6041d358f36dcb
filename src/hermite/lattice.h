// SPDX-License-Identifier: MIT
/* The finest lattice of a solid: its planes are floats, exactly. Of a solid made of samples they
 * are the planes of the samples, else they lie off round numbers. */
#ifndef QNI_HERMITE_LATTICE_H
#define QNI_HERMITE_LATTICE_H

#include "core/round.h"
#include "solid/solid.h"

/* Plane i of an axis is at the float next to origin + step (i - shift).
 *
 * Where planes may be chosen, that is (8 n + 3) unit: exact in float, and three eighths of a cell
 * off 0, so that planes miss the round coordinates that models are full of. */
typedef struct qni_lattice {
    double origin[3], step[3];
    int32_t shift;
    double cell;      /* the largest step */
    double clearance; /* crossings keep this far from lattice points */
    int32_t cells[3]; /* a whole number of roots, and of blocks */
    int32_t top;      /* roots are 2^top finest cells wide */
    bool samples;     /* planes are those of samples: along its edges the solid's f is linear */
    qni_box bounds;   /* the solid is cut there; strictly within the lattice */
} qni_lattice;

static inline double qni_lattice_at(const qni_lattice *lattice, int axis, int32_t plane) {
    return qni_rounded_to_float(lattice->origin[axis] +
                                lattice->step[axis] * (double)(plane - lattice->shift));
}

/* At most 2^depth cells along the box's longest axis, one layer and more round it included. */
qn_status qni_lattice_init(qni_lattice *lattice, const qni_box *bounds, int32_t depth, int32_t base,
                           qn_error *error);
/* The lattice of the samples of a solid made from a volume, in its frame, a block of cells and more
 * round it; `open`: cut at the outermost samples. */
qn_status qni_lattice_of_samples(qni_lattice *lattice, const qn_solid *solid, int32_t base,
                                 bool open, qn_error *error);

#endif
