// SPDX-License-Identifier: MIT
/* Making tapes: unused operations are dropped, results share registers, and a box drops the
 * branches of min and max that cannot be active in it. */
#include "solid/tape.h"

#include <string.h>

int qni_tape_operands(qni_tape_code code) {
    static const int8_t operands[] = {
#define ROW(name, text, count) count,
        QNI_TAPE_MAP(ROW)
#undef ROW
    };
    return operands[code];
}

const char *qni_tape_name(qni_tape_code code) {
    static const char *const names[] = {
#define ROW(name, text, count) text,
        QNI_TAPE_MAP(ROW)
#undef ROW
    };
    return names[code];
}

static void destroy(qn_solid *solid) {
    qni_tape *tape = (qni_tape *)solid;
    qni_free(solid->context, tape->ops, tape->count, sizeof *tape->ops);
    qni_solid_free(solid, sizeof *tape);
}

static const qni_solid_ops tape_ops = {
    .destroy = destroy,
    .values = qni_tape_values,
    .gradients = qni_tape_gradients,
    .bounds = qni_tape_bounds,
    .crossings = qni_find_crossings,
    .restrict_to = qni_tape_restrict,
    .slope = qni_tape_slope,
    .slopes = qni_tape_slopes,
};

/* What becomes of an operation: not needed, or needed; and then its place in the new tape. */
enum { UNUSED = -2, NEEDED = -1 };

/* Going back from the last one. `sides`, or NULL: of a min or max that is decided only that side is
 * needed, which gives its result; how many operations are left. */
static int64_t mark_needed(const qni_tape_op *ops, int64_t count, const int8_t *sides,
                           int32_t *place) {
    int64_t needed = 0;
    for (int64_t n = 0; n < count; ++n)
        place[n] = UNUSED;
    place[count - 1] = NEEDED;
    for (int64_t n = count - 1; n >= 0; --n) {
        if (place[n] == UNUSED)
            continue;
        const int side = sides ? sides[n] : 0,
                  operands = qni_tape_operands((qni_tape_code)ops[n].code);
        needed += side == 0;
        if (operands > 0 && side <= 0)
            place[ops[n].left] = NEEDED;
        if (operands > 1 && side >= 0)
            place[ops[n].right] = NEEDED;
    }
    return needed;
}

static void copy_needed(const qni_tape_op *ops, int64_t count, const int8_t *sides, int32_t *place,
                        qni_tape_op *kept) {
    int32_t next = 0;
    for (int64_t n = 0; n < count; ++n) {
        if (place[n] == UNUSED)
            continue;
        const int side = sides ? sides[n] : 0,
                  operands = qni_tape_operands((qni_tape_code)ops[n].code);
        if (side != 0) {
            place[n] = place[side < 0 ? ops[n].left : ops[n].right];
            continue;
        }
        kept[next] = ops[n];
        kept[next].left = operands > 0 ? place[ops[n].left] : 0;
        kept[next].right = operands > 1 ? place[ops[n].right] : kept[next].left;
        place[n] = next++;
    }
}

/* A register is free for the next result as soon as its own is used for the last time. `last[n]` is
 * the operation that uses result n last, `free_list` a stack; both have room for `count`. */
static int32_t assign_registers(qni_tape_op *ops, int64_t count, int32_t *last,
                                int32_t *free_list) {
    int32_t registers = 0, free_count = 0;
    for (int64_t n = 0; n < count; ++n) {
        last[n] = (int32_t)n;
        int operands = qni_tape_operands((qni_tape_code)ops[n].code);
        if (operands > 0)
            last[ops[n].left] = (int32_t)n;
        if (operands > 1)
            last[ops[n].right] = (int32_t)n;
    }
    for (int64_t n = 0; n < count; ++n) {
        int operands = qni_tape_operands((qni_tape_code)ops[n].code);
        int32_t left = ops[n].left, right = ops[n].right;
        ops[n].left_register = operands > 0 ? ops[left].out_register : 0;
        ops[n].right_register = operands > 0 ? ops[right].out_register : 0;
        if (operands > 0 && last[left] == n)
            free_list[free_count++] = ops[left].out_register;
        if (operands > 1 && right != left && last[right] == n)
            free_list[free_count++] = ops[right].out_register;
        ops[n].out_register = free_count > 0 ? free_list[--free_count] : registers++;
    }
    return registers;
}

/* A tape of what is needed; `place` is scratch for twice as many numbers. */
static qni_tape *create(qn_context *context, const qni_tape_op *ops, int64_t count,
                        const int8_t *sides, int32_t *place, const qni_box *box) {
    qni_tape *tape = (qni_tape *)qni_solid_new(context, sizeof *tape, &tape_ops);
    if (!tape)
        return NULL;
    tape->count = mark_needed(ops, count, sides, place);
    tape->ops = qni_alloc(context, tape->count, sizeof *tape->ops);
    tape->base.box = *box;
    tape->base.weight = 1 + (int32_t)(tape->count / QNI_TAPE_OPS_OF_A_PRIMITIVE);
    if (!tape->ops) {
        qni_solid_free(&tape->base, sizeof *tape);
        return NULL;
    }
    copy_needed(ops, count, sides, place, tape->ops);
    tape->registers = assign_registers(tape->ops, tape->count, place, place + count);
    return tape;
}

qni_tape *qni_tape_create(qn_context *context, const qni_tape_op *ops, int64_t count,
                          const qni_box *box) {
    int32_t *place = qni_alloc(context, 2 * count, sizeof *place);
    if (!place)
        return NULL;
    qni_tape *tape = create(context, ops, count, NULL, place, box);
    qni_free(context, place, 2 * count, sizeof *place);
    return tape;
}

/* Which side of a min or max is taken all over the box: -1 left, 1 right, 0 either. */
static int decide(const qni_tape_op *op, qni_interval left, qni_interval right) {
    if (left.nan || right.nan)
        return 0;
    if (op->code == QNI_TAPE_MIN)
        return left.high <= right.low ? -1 : right.high < left.low ? 1 : 0;
    if (op->code == QNI_TAPE_MAX)
        return left.low >= right.high ? -1 : right.low > left.high ? 1 : 0;
    return 0;
}

/* The sides that are taken all over the box; how many are decided. */
static int64_t decide_all(const qni_tape *tape, const qni_box *box, qni_interval *registers,
                          int8_t *sides) {
    int64_t decided = 0;
    for (int64_t n = 0; n < tape->count; ++n) {
        const qni_tape_op *op = &tape->ops[n];
        const qni_interval left = registers[op->left_register],
                           right = registers[op->right_register];
        sides[n] = (int8_t)decide(op, left, right);
        decided += sides[n] != 0;
        registers[op->out_register] = qni_interval_apply(op, left, right, box);
    }
    return decided;
}

qn_status qni_tape_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const qni_tape *tape = (const qni_tape *)solid;
    const size_t each = 2 * sizeof(int32_t) + sizeof(int8_t),
                 size = (size_t)tape->registers * sizeof(qni_interval) + (size_t)tape->count * each;
    char *scratch = qni_alloc(solid->context, (int64_t)size, 1);
    *solid_out = NULL;
    if (!scratch)
        return QN_ERROR_OUT_OF_MEMORY;
    qni_interval *registers = (qni_interval *)(void *)scratch;
    int32_t *place = (int32_t *)(void *)(registers + tape->registers);
    int8_t *sides = (int8_t *)(place + 2 * tape->count);
    memset(registers, 0, (size_t)tape->registers * sizeof *registers);
    if (decide_all(tape, box, registers, sides) == 0) {
        *solid_out = qni_solid_retain(solid);
    } else {
        qni_tape *smaller =
            create(solid->context, tape->ops, tape->count, sides, place, &solid->box);
        *solid_out = smaller ? &smaller->base : NULL;
        if (smaller)
            smaller->base.owner = solid->owner;
    }
    qni_free(solid->context, scratch, (int64_t)size, 1);
    return *solid_out ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}
