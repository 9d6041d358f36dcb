// SPDX-License-Identifier: MIT
/* What all kinds of solids share: making and keeping nodes, ties at zero, crossings found and
 * combined. */
#ifndef QNI_SOLID_NODE_H
#define QNI_SOLID_NODE_H

#include <math.h>

#include "core/context.h"
#include "core/status.h"
#include "solid/solid.h"

/* Trees are walked by recursion; deeper ones are refused when they are built. */
enum { QNI_SOLID_MAX_DEPTH = 200 };
/* Points a node handles at once: scratch stays on the stack, and in the first cache. */
enum { QNI_SOLID_BLOCK = 128 };
/* Crossings of one segment that are told apart. */
enum { QNI_CROSSINGS = 64 };
/* Stands for a value of exactly 0 where the side must be definite. Points on a plane belong to the
 * side that the point moved by (e, e^2, e^3), e > 0, would be on. So two solids that touch in a
 * face leave no gap between them. */
#define QNI_TIE      1e-300
#define QNI_INFINITY ((double)INFINITY)
#define QNI_EPSILON  2.220446049250313e-16

/* fmin() and fmax(), NaN giving way to a number, without the call. */
static inline double qni_min(double a, double b) {
    return b < a || a != a ? b : a;
}
static inline double qni_max(double a, double b) {
    return b > a || a != a ? b : a;
}

/* Of numbers only: one instruction. */
static inline double qni_lesser(double a, double b) {
    return a < b ? a : b;
}
static inline double qni_greater(double a, double b) {
    return a > b ? a : b;
}

/* The least and the largest of three floats that are numbers. */
static inline float qni_least_of(float x, float y, float z) {
    const float less = x < y ? x : y;
    return z < less ? z : less;
}
static inline float qni_most_of(float x, float y, float z) {
    const float more = x < y ? y : x;
    return z > more ? z : more;
}

/* A cleared node with one reference, or NULL. `size` is that of the whole structure, which begins
 * with a qn_solid. */
qn_solid *qni_solid_new(qn_context *context, size_t size, const qni_solid_ops *ops);
void qni_solid_free(qn_solid *solid, size_t size);

bool qni_box_is_finite(const qni_box *box);
qni_box qni_box_everything(void);
/* The box of an empty solid. */
qni_box qni_box_nothing(void);
bool qni_box_is_nothing(const qni_box *box);
static inline qni_box qni_segment_box(const double a[3], const double b[3]) {
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        box.low[k] = a[k] < b[k] ? a[k] : b[k];
        box.high[k] = a[k] < b[k] ? b[k] : a[k];
    }
    return box;
}
bool qni_boxes_meet(const qni_box *a, const qni_box *b);

/* Whether p lies in the solid. */
qn_status qni_solid_contains(const qn_solid *solid, const double p[3], bool *inside_out);

/* Unit length; the fallback, which must have it, where v has no direction. */
void qni_unit(const double v[3], const double fallback[3], double unit[3]);

/* A restrict_to for solids that have nothing to drop. */
qn_status qni_restrict_to_itself(const qn_solid *solid, const qni_box *box, qn_solid **solid_out);

#endif
