// SPDX-License-Identifier: MIT
/* Running tapes: values of a block of points at once, gradients forward beside them, and bounds. */
#include "solid/tape.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* Points in a block: fewer when the tape needs so many registers that they leave the cache. */
enum { LARGEST_BLOCK = 256, SMALLEST_BLOCK = 16, STACK_DOUBLES = 8192 };

/* Doubles for a tape: on the stack when they fit. */
typedef struct scratch {
    qn_context *context;
    double *doubles;
    int64_t heap_count;
    int64_t block;
    double stack[STACK_DOUBLES];
} scratch;

static bool scratch_open(scratch *room, const qni_tape *tape, int64_t each) {
    room->context = tape->base.context;
    room->block = LARGEST_BLOCK;
    while (room->block > SMALLEST_BLOCK && tape->registers * each * room->block > STACK_DOUBLES)
        room->block /= 2;
    int64_t count = tape->registers * each * room->block;
    room->heap_count = count > STACK_DOUBLES ? count : 0;
    room->doubles =
        room->heap_count ? qni_alloc(room->context, count, sizeof(double)) : room->stack;
    return room->doubles;
}

static void scratch_close(scratch *room) {
    if (room->heap_count)
        qni_free(room->context, room->doubles, room->heap_count, sizeof(double));
}

#define EACH for (int64_t i = 0; i < count; ++i)
#define UNARY(name, expression)                                                                    \
    case QNI_TAPE_##name:                                                                          \
        EACH {                                                                                     \
            double x = a[i];                                                                       \
            out[i] = (expression);                                                                 \
        }                                                                                          \
        break;
#define BINARY(name, expression)                                                                   \
    case QNI_TAPE_##name:                                                                          \
        EACH {                                                                                     \
            double x = a[i], y = b[i];                                                             \
            out[i] = (expression);                                                                 \
        }                                                                                          \
        break;

/* One operation on a block. Elementwise, so that `out` may be one of the operands. */
static void apply(const qni_tape_op *op, int64_t count, const double (*points)[3], const double *a,
                  const double *b, double *out) {
    switch ((qni_tape_code)op->code) {
    case QNI_TAPE_CONST:
        EACH out[i] = op->value;
        break;
    case QNI_TAPE_VAR_X:
    case QNI_TAPE_VAR_Y:
    case QNI_TAPE_VAR_Z:
        EACH out[i] = points[i][op->code - QNI_TAPE_VAR_X];
        break;
        UNARY(NEG, -x)
        UNARY(ABS, fabs(x))
        UNARY(RECIP, 1 / x)
        UNARY(SQUARE, x * x)
        UNARY(SQRT, sqrt(x))
        UNARY(SIN, sin(x))
        UNARY(COS, cos(x))
        UNARY(TAN, tan(x))
        UNARY(ASIN, asin(x))
        UNARY(ACOS, acos(x))
        UNARY(ATAN, atan(x))
        UNARY(EXP, exp(x))
        UNARY(LOG, log(x))
        BINARY(ADD, x + y)
        BINARY(SUB, x - y)
        BINARY(MUL, x * y)
        BINARY(DIV, x / y)
        BINARY(MIN, qni_min_takes_right(x, y) ? y : x)
        BINARY(MAX, qni_max_takes_right(x, y) ? y : x)
    case QNI_TAPE_CODES:
        break;
    }
}

qn_status qni_tape_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                          double *values) {
    const qni_tape *tape = (const qni_tape *)solid;
    scratch room;
    if (!scratch_open(&room, tape, 1))
        return QN_ERROR_OUT_OF_MEMORY;
    for (int64_t first = 0; first < count; first += room.block) {
        int64_t block = count - first < room.block ? count - first : room.block;
        for (int64_t n = 0; n < tape->count; ++n) {
            const qni_tape_op *op = &tape->ops[n];
            apply(op, block, points + first, room.doubles + op->left_register * room.block,
                  room.doubles + op->right_register * room.block,
                  room.doubles + op->out_register * room.block);
        }
        const double *result = room.doubles + tape->ops[tape->count - 1].out_register * room.block;
        for (int64_t i = 0; i < block; ++i) /* NaN counts as outside */
            values[first + i] = result[i] == result[i] ? result[i] : QNI_INFINITY;
    }
    scratch_close(&room);
    return QN_OK;
}

/* Factors df/da and df/db of one operation at a, b with the result f. */
static void factors(const qni_tape_op *op, double a, double b, double f, double *by_a,
                    double *by_b) {
    *by_b = 0;
    switch ((qni_tape_code)op->code) {
    case QNI_TAPE_NEG:
        *by_a = -1;
        break;
    case QNI_TAPE_ABS:
        *by_a = a < 0 ? -1 : 1;
        break;
    case QNI_TAPE_RECIP:
        *by_a = -f * f;
        break;
    case QNI_TAPE_SQUARE:
        *by_a = 2 * a;
        break;
    case QNI_TAPE_SQRT:
        *by_a = 0.5 / f;
        break;
    case QNI_TAPE_SIN:
        *by_a = cos(a);
        break;
    case QNI_TAPE_COS:
        *by_a = -sin(a);
        break;
    case QNI_TAPE_TAN:
        *by_a = 1 + f * f;
        break;
    case QNI_TAPE_ASIN:
        *by_a = 1 / sqrt(1 - a * a);
        break;
    case QNI_TAPE_ACOS:
        *by_a = -1 / sqrt(1 - a * a);
        break;
    case QNI_TAPE_ATAN:
        *by_a = 1 / (1 + a * a);
        break;
    case QNI_TAPE_EXP:
        *by_a = f;
        break;
    case QNI_TAPE_LOG:
        *by_a = 1 / a;
        break;
    case QNI_TAPE_ADD:
        *by_a = 1, *by_b = 1;
        break;
    case QNI_TAPE_SUB:
        *by_a = 1, *by_b = -1;
        break;
    case QNI_TAPE_MUL:
        *by_a = b, *by_b = a;
        break;
    case QNI_TAPE_DIV:
        *by_a = 1 / b, *by_b = -f / b;
        break;
    case QNI_TAPE_MIN:
        *by_b = qni_min_takes_right(a, b), *by_a = 1 - *by_b;
        break;
    case QNI_TAPE_MAX:
        *by_b = qni_max_takes_right(a, b), *by_a = 1 - *by_b;
        break;
    default:
        *by_a = 0;
        break;
    }
}

/* A factor of 0 drops its term, so that an infinite derivative of the branch not taken does no
 * harm. */
static double weigh(double factor, double derivative) {
    return factor == 0 || derivative == 0 ? 0 : factor * derivative;
}

/* Each register holds four rows: value and derivatives by x, y, z. */
static void apply_gradient(const qni_tape_op *op, int64_t block, int64_t count, double *registers) {
    const double *a = registers + op->left_register * 4 * block;
    const double *b = registers + op->right_register * 4 * block;
    double *out = registers + op->out_register * 4 * block;
    if (qni_tape_operands((qni_tape_code)op->code) == 0) {
        for (int k = 0; k < 3; ++k)
            EACH out[(k + 1) * block + i] = op->code == QNI_TAPE_VAR_X + k;
        return;
    }
    EACH {
        double by_a, by_b, a_value = a[i], b_value = b[i], f = 0;
        apply(op, 1, NULL, &a_value, &b_value, &f);
        factors(op, a_value, b_value, f, &by_a, &by_b);
        out[i] = f;
        for (int64_t k = 1; k < 4; ++k)
            out[k * block + i] = weigh(by_a, a[k * block + i]) + weigh(by_b, b[k * block + i]);
    }
}

qn_status qni_tape_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                             double (*gradients)[3], int32_t *owners) {
    const qni_tape *tape = (const qni_tape *)solid;
    for (int64_t n = 0; owners && n < count; ++n)
        owners[n] = solid->owner;
    if (!gradients)
        return QN_OK;
    scratch room;
    if (!scratch_open(&room, tape, 4))
        return QN_ERROR_OUT_OF_MEMORY;
    for (int64_t first = 0; first < count; first += room.block) {
        int64_t block = count - first < room.block ? count - first : room.block;
        for (int64_t n = 0; n < tape->count; ++n) {
            const qni_tape_op *op = &tape->ops[n];
            if (qni_tape_operands((qni_tape_code)op->code) == 0)
                apply(op, block, points + first, NULL, NULL,
                      room.doubles + op->out_register * 4 * room.block);
            apply_gradient(op, room.block, block, room.doubles);
        }
        const double *result =
            room.doubles + tape->ops[tape->count - 1].out_register * 4 * room.block;
        for (int64_t i = 0; i < block; ++i)
            for (int k = 0; k < 3; ++k)
                gradients[first + i][k] = result[(k + 1) * room.block + i];
    }
    scratch_close(&room);
    return QN_OK;
}

/* Registers for bounds: on the stack for common tapes. */
enum { STACK_REGISTERS = 256 };

qn_status qni_tape_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const qni_tape *tape = (const qni_tape *)solid;
    qni_interval stack[STACK_REGISTERS], *registers = stack;
    stack[0] = (qni_interval){0, 0, false};
    if (tape->registers > STACK_REGISTERS)
        registers = qni_alloc_zero(solid->context, tape->registers, sizeof *registers);
    if (!registers)
        return QN_ERROR_OUT_OF_MEMORY;
    for (int64_t n = 0; n < tape->count; ++n) {
        const qni_tape_op *op = &tape->ops[n];
        registers[op->out_register] = qni_interval_apply(op, registers[op->left_register],
                                                         registers[op->right_register], box);
    }
    qni_interval result = registers[tape->ops[tape->count - 1].out_register];
    range[0] = result.low;
    range[1] = result.nan ? QNI_INFINITY : result.high; /* values() makes infinity of NaN */
    if (registers != stack)
        qni_free(solid->context, registers, tape->registers, sizeof *registers);
    return QN_OK;
}

/* Value and derivative along a direction, everywhere in a box. */
static bool run_slope(const qni_tape *tape, const qni_box *box, const double direction[3],
                      double range[2]) {
    qni_slope registers[STACK_REGISTERS];
    if (tape->registers > STACK_REGISTERS)
        return false;
    registers[0] = (qni_slope){{0, 0, false}, {0, 0, false}};
    for (int64_t n = 0; n < tape->count; ++n) {
        const qni_tape_op *op = &tape->ops[n];
        registers[op->out_register] = qni_slope_apply(
            op, registers[op->left_register], registers[op->right_register], box, direction);
    }
    const qni_slope *result = &registers[tape->ops[tape->count - 1].out_register];
    range[0] = result->slope.low;
    range[1] = result->slope.high;
    return !result->value.nan && !result->slope.nan;
}

bool qni_tape_slope(const qn_solid *solid, const double a[3], const double b[3], double range[2]) {
    const qni_box box = qni_segment_box(a, b);
    const double direction[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return run_slope((const qni_tape *)solid, &box, direction, range);
}

bool qni_tape_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    bool known = true;
    for (int k = 0; k < 3; ++k)
        known = known && run_slope((const qni_tape *)solid, box, axes[k], ranges[k]);
    return known;
}
