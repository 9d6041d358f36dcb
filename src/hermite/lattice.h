// SPDX-License-Identifier: MIT
/* The finest lattice of a solid: its planes are floats, exactly, and lie off round numbers. */
#ifndef QNI_HERMITE_LATTICE_H
#define QNI_HERMITE_LATTICE_H

#include "solid/solid.h"

/* Plane i of an axis is at (8 (first + i) + 3) unit. The product is exact and needs at most 24
 * bits, so the float of it is the same number. Three eighths of a cell off 0, planes miss the round
 * coordinates that models are full of. */
typedef struct qni_lattice {
    double unit; /* an eighth of a cell */
    double cell; /* world units */
    int64_t first[3];
    int32_t cells[3]; /* a whole number of roots, and of blocks */
    int32_t top;      /* roots are 2^top finest cells wide */
    qni_box bounds;   /* the solid is cut there; strictly within the lattice */
} qni_lattice;

static inline double qni_lattice_at(const qni_lattice *lattice, int axis, int32_t plane) {
    return (double)(8 * (lattice->first[axis] + plane) + 3) * lattice->unit;
}

/* At most 2^depth cells along the box's longest axis, one layer and more round it included. */
qn_status qni_lattice_init(qni_lattice *lattice, const qni_box *bounds, int32_t depth, int32_t base,
                           qn_error *error);

#endif
