// SPDX-License-Identifier: MIT
/* Interval arithmetic on the operations of tapes. Bounds are rounded outward by a few units in the
 * last place, so that they hold for the exact function and for its values in doubles. */
#include "solid/tape.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* `units` in the last place and a little more; infinities stay. */
static qni_interval widened(double low, double high, bool nan, double units) {
    double slack = units * QNI_EPSILON;
    return (qni_interval){low - (fabs(low) < QNI_INFINITY ? fabs(low) * slack + 5e-324 : 0),
                          high + (fabs(high) < QNI_INFINITY ? fabs(high) * slack + 5e-324 : 0),
                          nan};
}

static qni_interval everything(bool nan) {
    return (qni_interval){-QNI_INFINITY, QNI_INFINITY, nan};
}

static qni_interval exactly(double low, double high, bool nan) {
    return (qni_interval){low, high, nan};
}

static qni_interval add(qni_interval a, qni_interval b) {
    double low = a.low + b.low, high = a.high + b.high;
    /* Infinity less infinity is possible inside, too, not only at the ends. */
    bool nan = a.nan || b.nan || (a.low == -QNI_INFINITY && b.high == QNI_INFINITY) ||
               (a.high == QNI_INFINITY && b.low == -QNI_INFINITY);
    if (low != low || high != high)
        return everything(true);
    return widened(low, high, nan, 1);
}

static qni_interval negated(qni_interval a) {
    return exactly(-a.high, -a.low, a.nan);
}

static bool holds_zero(qni_interval a) {
    return a.low <= 0 && a.high >= 0;
}

static bool unbounded(qni_interval a) {
    return a.low == -QNI_INFINITY || a.high == QNI_INFINITY;
}

/* 0 times infinity is 0 at the ends of an interval: the limit of finite products. */
static double product(double a, double b) {
    return a == 0 || b == 0 ? 0 : a * b;
}

static qni_interval multiplied(qni_interval a, qni_interval b) {
    double p = product(a.low, b.low), q = product(a.low, b.high);
    double r = product(a.high, b.low), s = product(a.high, b.high);
    bool nan = a.nan || b.nan || (holds_zero(a) && unbounded(b)) || (holds_zero(b) && unbounded(a));
    return widened(qni_min(qni_min(p, q), qni_min(r, s)), qni_max(qni_max(p, q), qni_max(r, s)),
                   nan, 1);
}

static qni_interval squared(qni_interval a) {
    double low = a.low * a.low, high = a.high * a.high;
    double most = qni_max(low, high), least = holds_zero(a) ? 0 : qni_min(low, high);
    qni_interval result = widened(least, most, a.nan, 1);
    result.low = qni_max(result.low, 0);
    return result;
}

static qni_interval reciprocal(qni_interval a) {
    if (holds_zero(a)) /* both signs of zero are zero: either infinity is possible */
        return everything(a.nan);
    return widened(1 / a.high, 1 / a.low, a.nan, 1);
}

static qni_interval divided(qni_interval a, qni_interval b) {
    bool nan = a.nan || b.nan || (holds_zero(a) && holds_zero(b)) || (unbounded(a) && unbounded(b));
    if (holds_zero(b))
        return everything(nan);
    if (nan && (unbounded(a) || unbounded(b)))
        return everything(nan);
    double p = a.low / b.low, q = a.low / b.high, r = a.high / b.low, s = a.high / b.high;
    return widened(qni_min(qni_min(p, q), qni_min(r, s)), qni_max(qni_max(p, q), qni_max(r, s)),
                   nan, 1);
}

static qni_interval absolute(qni_interval a) {
    if (a.low >= 0)
        return a;
    if (a.high <= 0)
        return negated(a);
    return exactly(0, qni_max(-a.low, a.high), a.nan);
}

static qni_interval root(qni_interval a) {
    bool nan = a.nan || a.low < 0;
    if (a.high < 0)
        return everything(true);
    qni_interval result = widened(sqrt(qni_max(a.low, 0)), sqrt(a.high), nan, 1);
    result.low = qni_max(result.low, 0);
    return result;
}

/* A function that rises from f(low) to f(high), as the C library gives it. */
static qni_interval rising(double low, double high, bool nan) {
    return widened(low, high, nan, 8);
}

/* cos(x - turn) for x in a: extremes where x - turn is a multiple of pi. */
static qni_interval wave(qni_interval a, double (*function)(double), double turn) {
    bool nan = a.nan || unbounded(a);
    if (unbounded(a) || fabs(a.low) > 1e8 || fabs(a.high) > 1e8 || a.high - a.low >= 2 * pi)
        return exactly(-1, 1, nan);
    double at_low = function(a.low), at_high = function(a.high);
    qni_interval result = widened(qni_min(at_low, at_high), qni_max(at_low, at_high), nan, 8);
    /* Half periods before each end, counted a little apart so that rounding loses no extreme. */
    double first = (a.low - turn) / pi - 1e-7, last = (a.high - turn) / pi + 1e-7;
    for (double k = ceil(first); k <= last; ++k) {
        if (fmod(k, 2) == 0)
            result.high = 1;
        else
            result.low = -1;
    }
    result.low = qni_max(result.low, -1);
    result.high = qni_min(result.high, 1);
    return result;
}

static qni_interval tangent(qni_interval a) {
    bool nan = a.nan || unbounded(a);
    if (nan || fabs(a.low) > 1e8 || fabs(a.high) > 1e8 ||
        floor(a.low / pi + 0.5 - 1e-7) != floor(a.high / pi + 0.5 + 1e-7))
        return everything(nan);
    return rising(tan(a.low), tan(a.high), nan);
}

/* asin, or acos which falls: clamped to where they are defined, NaN beside it. */
static qni_interval arc(qni_interval a, bool falls) {
    bool nan = a.nan || a.low < -1 || a.high > 1;
    double low = qni_min(qni_max(a.low, -1), 1), high = qni_min(qni_max(a.high, -1), 1);
    return falls ? rising(acos(high), acos(low), nan) : rising(asin(low), asin(high), nan);
}

static qni_interval exponential(qni_interval a) {
    qni_interval result = rising(exp(a.low), exp(a.high), a.nan);
    result.low = qni_max(result.low, 0);
    return result;
}

static qni_interval logarithm(qni_interval a) {
    bool nan = a.nan || a.low < 0;
    if (a.high < 0)
        return everything(true);
    return rising(log(qni_max(a.low, 0)), log(a.high), nan);
}

static qni_interval smaller(qni_interval a, qni_interval b) {
    qni_interval result = {qni_min(a.low, b.low), qni_min(a.high, b.high), a.nan && b.nan};
    if (a.nan) /* then b alone is the result */
        result.high = qni_max(result.high, b.high);
    if (b.nan)
        result.high = qni_max(result.high, a.high);
    return result;
}

static qni_interval larger(qni_interval a, qni_interval b) {
    return negated(smaller(negated(a), negated(b)));
}

qni_interval qni_interval_apply(const qni_tape_op *op, qni_interval a, qni_interval b,
                                const qni_box *box) {
    int axis = op->code - QNI_TAPE_VAR_X;
    switch ((qni_tape_code)op->code) {
    case QNI_TAPE_CONST:
        return exactly(op->value, op->value, false);
    case QNI_TAPE_VAR_X:
    case QNI_TAPE_VAR_Y:
    case QNI_TAPE_VAR_Z:
        return exactly(box->low[axis], box->high[axis], false);
    case QNI_TAPE_NEG:
        return negated(a);
    case QNI_TAPE_ABS:
        return absolute(a);
    case QNI_TAPE_RECIP:
        return reciprocal(a);
    case QNI_TAPE_SQUARE:
        return squared(a);
    case QNI_TAPE_SQRT:
        return root(a);
    case QNI_TAPE_SIN:
        return wave(a, sin, 0.5 * pi);
    case QNI_TAPE_COS:
        return wave(a, cos, 0);
    case QNI_TAPE_TAN:
        return tangent(a);
    case QNI_TAPE_ASIN:
        return arc(a, false);
    case QNI_TAPE_ACOS:
        return arc(a, true);
    case QNI_TAPE_ATAN:
        return rising(atan(a.low), atan(a.high), a.nan);
    case QNI_TAPE_EXP:
        return exponential(a);
    case QNI_TAPE_LOG:
        return logarithm(a);
    case QNI_TAPE_ADD:
        return add(a, b);
    case QNI_TAPE_SUB:
        return add(a, negated(b));
    case QNI_TAPE_MUL:
        return op->left == op->right ? squared(a) : multiplied(a, b);
    case QNI_TAPE_DIV:
        return divided(a, b);
    case QNI_TAPE_MIN:
        return smaller(a, b);
    case QNI_TAPE_MAX:
        return larger(a, b);
    case QNI_TAPE_CODES:
        break;
    }
    return everything(true);
}

static qni_interval joined(qni_interval a, qni_interval b) {
    return exactly(qni_min(a.low, b.low), qni_max(a.high, b.high), a.nan || b.nan);
}

static qni_interval scaled(qni_interval a, double factor) {
    return multiplied(a, exactly(factor, factor, false));
}

/* f' of the operations of one operand, from the operand and the result. */
static qni_interval derivative(const qni_tape_op *op, qni_interval a, qni_interval f) {
    const qni_interval one = {1, 1, false};
    switch ((qni_tape_code)op->code) {
    case QNI_TAPE_NEG:
        return exactly(-1, -1, false);
    case QNI_TAPE_ABS:
        return exactly(a.low >= 0 ? 1 : -1, a.high < 0 ? -1 : 1, false);
    case QNI_TAPE_RECIP:
        return negated(squared(f));
    case QNI_TAPE_SQUARE:
        return scaled(a, 2);
    case QNI_TAPE_SQRT:
        return scaled(reciprocal(f), 0.5);
    case QNI_TAPE_SIN:
        return wave(a, cos, 0);
    case QNI_TAPE_COS:
        return negated(wave(a, sin, 0.5 * pi));
    case QNI_TAPE_TAN:
        return add(one, squared(f));
    case QNI_TAPE_ASIN:
        return reciprocal(root(add(one, negated(squared(a)))));
    case QNI_TAPE_ACOS:
        return negated(reciprocal(root(add(one, negated(squared(a))))));
    case QNI_TAPE_ATAN:
        return reciprocal(add(one, squared(a)));
    case QNI_TAPE_EXP:
        return f;
    case QNI_TAPE_LOG:
        return reciprocal(a);
    default:
        return everything(true);
    }
}

/* The slope of min or max: that of the one operand that is taken, or of both where either may be.
 */
static qni_interval chosen(const qni_tape_op *op, qni_slope a, qni_slope b) {
    bool minimum = op->code == QNI_TAPE_MIN;
    if (a.value.nan || b.value.nan)
        return everything(true);
    if (minimum ? a.value.high < b.value.low : a.value.low > b.value.high)
        return a.slope;
    if (minimum ? b.value.high < a.value.low : b.value.low > a.value.high)
        return b.slope;
    return joined(a.slope, b.slope);
}

qni_slope qni_slope_apply(const qni_tape_op *op, qni_slope a, qni_slope b, const qni_box *box,
                          const double direction[3]) {
    qni_slope f = {qni_interval_apply(op, a.value, b.value, box), {0, 0, false}};
    int axis = op->code - QNI_TAPE_VAR_X;
    switch ((qni_tape_code)op->code) {
    case QNI_TAPE_CONST:
        break;
    case QNI_TAPE_VAR_X:
    case QNI_TAPE_VAR_Y:
    case QNI_TAPE_VAR_Z:
        f.slope = exactly(direction[axis], direction[axis], false);
        break;
    case QNI_TAPE_ADD:
        f.slope = add(a.slope, b.slope);
        break;
    case QNI_TAPE_SUB:
        f.slope = add(a.slope, negated(b.slope));
        break;
    case QNI_TAPE_MUL:
        f.slope = add(multiplied(a.value, b.slope), multiplied(a.slope, b.value));
        break;
    case QNI_TAPE_DIV: /* (a' - f b') / b */
        f.slope = divided(add(a.slope, negated(multiplied(f.value, b.slope))), b.value);
        break;
    case QNI_TAPE_MIN:
    case QNI_TAPE_MAX:
        f.slope = chosen(op, a, b);
        break;
    default:
        f.slope = multiplied(derivative(op, a.value, f.value), a.slope);
        break;
    }
    return f;
}
