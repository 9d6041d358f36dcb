// SPDX-License-Identifier: MIT
/* The solid angle of caps, fast anywhere: cells of an octree that are made when they are first
 * asked for. In a cell what is far is a polynomial, what is near is summed exactly. The answer is a
 * function of the caps and the place alone, whoever asked before. */
#ifndef QNI_SOLID_CAP_FIELD_H
#define QNI_SOLID_CAP_FIELD_H

#include "solid/panel.h"

typedef struct qni_cap_cell qni_cap_cell;

enum { QNI_CAP_ROOTS = 2 };

typedef struct qni_cap_field {
    qn_context *context;
    const qni_panel_tree *caps;
    qni_cap_cell *roots[QNI_CAP_ROOTS]; /* about the box; about what is looked at round it */
    int32_t failed; /* memory ran out in some thread: what was answered since is worth nothing */
} qni_cap_field;

/* The roots; true also without caps. False: no memory; end it all the same. Caps are borrowed. */
bool qni_cap_field_start(qn_context *context, const qni_panel_tree *caps, const qni_box *box,
                         qni_cap_field *field);
void qni_cap_field_free(qni_cap_field *field);

/* The sum of qni_panel_angle() over the caps, to about 1e-3; it jumps where they are crossed,
 * exactly as qni_panel_across() says. The gradient is added to. Any number of threads may ask. */
double qni_cap_field_angle(qni_cap_field *field, const double p[3], double gradient[3]);

static inline bool qni_cap_field_failed(const qni_cap_field *field) {
    return __atomic_load_n(&field->failed, __ATOMIC_RELAXED) != 0;
}

#endif
