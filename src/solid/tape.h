// SPDX-License-Identifier: MIT
/* Expression tapes: a function of x, y, z as a row of operations, each on the results of earlier
 * ones. */
#ifndef QNI_SOLID_TAPE_H
#define QNI_SOLID_TAPE_H

#include "solid/node.h"

/* Name in .vm files and number of operands. Where two names mean one operation, the first is
 * listed. */
#define QNI_TAPE_MAP(X)                                                                            \
    X(CONST, "const", 0)                                                                           \
    X(VAR_X, "var-x", 0)                                                                           \
    X(VAR_Y, "var-y", 0)                                                                           \
    X(VAR_Z, "var-z", 0)                                                                           \
    X(NEG, "neg", 1)                                                                               \
    X(ABS, "abs", 1)                                                                               \
    X(RECIP, "recip", 1)                                                                           \
    X(SQUARE, "square", 1)                                                                         \
    X(SQRT, "sqrt", 1)                                                                             \
    X(SIN, "sin", 1)                                                                               \
    X(COS, "cos", 1)                                                                               \
    X(TAN, "tan", 1)                                                                               \
    X(ASIN, "asin", 1)                                                                             \
    X(ACOS, "acos", 1)                                                                             \
    X(ATAN, "atan", 1)                                                                             \
    X(EXP, "exp", 1)                                                                               \
    X(LOG, "ln", 1)                                                                                \
    X(ADD, "add", 2)                                                                               \
    X(SUB, "sub", 2)                                                                               \
    X(MUL, "mul", 2)                                                                               \
    X(DIV, "div", 2)                                                                               \
    X(MIN, "min", 2)                                                                               \
    X(MAX, "max", 2)

typedef enum qni_tape_code {
#define QNI_TAPE_ENUM(name, text, operands) QNI_TAPE_##name,
    QNI_TAPE_MAP(QNI_TAPE_ENUM)
#undef QNI_TAPE_ENUM
        QNI_TAPE_CODES
} qni_tape_code;

/* One operation. `left` and `right` are the numbers of earlier operations; the registers say where
 * values lie while the tape runs. A constant's value is in `value`. */
typedef struct qni_tape_op {
    double value;
    int32_t left, right;
    int32_t out_register, left_register, right_register;
    int32_t code;
} qni_tape_op;

typedef struct qni_tape {
    qn_solid base;
    qni_tape_op *ops; /* the last one is the result */
    int64_t count;
    int32_t registers;
} qni_tape;

enum { QNI_TAPE_OPS_OF_A_PRIMITIVE = 8 };

/* How many operands an operation takes, and its name. */
int qni_tape_operands(qni_tape_code code);
const char *qni_tape_name(qni_tape_code code);

/* What min and max give for two numbers: the first on a tie; NaN gives way to a number. */
static inline bool qni_min_takes_right(double left, double right) {
    return right < left || left != left;
}
static inline bool qni_max_takes_right(double left, double right) {
    return right > left || left != left;
}

/* A tape of `count` operations, of which code, value, left and right are set; what the last one
 * does not need is dropped. The operations are copied. NULL when memory is short. */
qni_tape *qni_tape_create(qn_context *context, const qni_tape_op *ops, int64_t count,
                          const qni_box *box);

/* Numbers between two bounds; `nan` when NaN is possible too. */
typedef struct qni_interval {
    double low, high;
    bool nan;
} qni_interval;
qni_interval qni_interval_apply(const qni_tape_op *op, qni_interval left, qni_interval right,
                                const qni_box *box);
/* The same for a value and its derivative along a direction. */
typedef struct qni_slope {
    qni_interval value, slope;
} qni_slope;
qni_slope qni_slope_apply(const qni_tape_op *op, qni_slope left, qni_slope right,
                          const qni_box *box, const double direction[3]);

/* Those of qni_solid_ops that work on tapes. */
qn_status qni_tape_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                          double *values);
qn_status qni_tape_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                             double (*gradients)[3], int32_t *owners);
qn_status qni_tape_bounds(const qn_solid *solid, const qni_box *box, double range[2]);
bool qni_tape_slope(const qn_solid *solid, const double a[3], const double b[3], double range[2]);
bool qni_tape_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]);
qn_status qni_tape_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out);

#endif
