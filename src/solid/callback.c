// SPDX-License-Identifier: MIT
/* Solids given by a caller's functions, with stand-ins for those that are missing. */
#include "solid/node.h"

#include <math.h>

typedef struct callback_solid {
    qn_solid base;
    qn_solid_callback callback;
    double step; /* of central differences, relative to the size of the box */
} callback_solid;

static const qn_solid_callback *calls(const qn_solid *solid) {
    return &((const callback_solid *)solid)->callback;
}

static void destroy(qn_solid *solid) {
    qni_solid_free(solid, sizeof(callback_solid));
}

/* NaN counts as outside. */
static void settle(int64_t count, double *values) {
    for (int64_t n = 0; n < count; ++n)
        values[n] = values[n] == values[n] ? values[n] : QNI_INFINITY;
}

static qn_status callback_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 double *values) {
    if (count == 0)
        return QN_OK;
    if (calls(solid)->values(calls(solid)->user, count, points, values))
        return QN_ERROR_CANCELLED;
    settle(count, values);
    return QN_OK;
}

/* Central differences of one block, all six neighbours of each point in one call. */
static qn_status differences(const callback_solid *solid, int64_t count, const double (*points)[3],
                             double (*gradients)[3]) {
    enum { BLOCK = 32 };
    double near[BLOCK * 6][3], values[BLOCK * 6];
    for (int64_t first = 0; first < count; first += BLOCK) {
        int64_t block = count - first < BLOCK ? count - first : BLOCK;
        for (int64_t i = 0; i < block * 6; ++i) {
            for (int k = 0; k < 3; ++k)
                near[i][k] = points[first + i / 6][k];
            near[i][i % 6 / 2] += i % 2 ? solid->step : -solid->step;
        }
        QN_TRY(callback_values(&solid->base, block * 6, (const double(*)[3])near, values));
        for (int64_t i = 0; i < block; ++i)
            for (int k = 0; k < 3; ++k)
                gradients[first + i][k] =
                    (values[i * 6 + 2 * k + 1] - values[i * 6 + 2 * k]) / (2 * solid->step);
    }
    return QN_OK;
}

static qn_status callback_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                    double (*gradients)[3], int32_t *owners) {
    if (count == 0)
        return QN_OK;
    if (calls(solid)->gradients)
        return calls(solid)->gradients(calls(solid)->user, count, points, gradients, owners)
                   ? QN_ERROR_CANCELLED
                   : QN_OK;
    for (int64_t n = 0; owners && n < count; ++n)
        owners[n] = 0;
    return gradients ? differences((const callback_solid *)solid, count, points, gradients) : QN_OK;
}

static qn_status callback_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const qn_solid_callback *callback = calls(solid);
    range[0] = -QNI_INFINITY;
    range[1] = QNI_INFINITY;
    if (callback->bounds) {
        if (callback->bounds(callback->user, box->low, box->high, range))
            return QN_ERROR_CANCELLED;
        if (!(range[0] <= range[1])) { /* NaN, or the wrong way round: nothing is known */
            range[0] = -QNI_INFINITY;
            range[1] = QNI_INFINITY;
        }
        return QN_OK;
    }
    if (!(callback->lipschitz > 0))
        return QN_OK;
    double centre[1][3], squares = 0, value;
    for (int k = 0; k < 3; ++k) {
        centre[0][k] = 0.5 * (box->low[k] + box->high[k]);
        double half = fmax(box->high[k] - centre[0][k], centre[0][k] - box->low[k]);
        squares += half * half;
    }
    QN_TRY(callback_values(solid, 1, (const double(*)[3])centre, &value));
    if (!isfinite(value))
        return QN_OK;
    double reach = callback->lipschitz * sqrt(squares);
    double slack = 8 * QNI_EPSILON * (reach + fabs(value)); /* of the arithmetic here */
    range[0] = value - reach - slack;
    range[1] = value + reach + slack;
    return QN_OK;
}

static bool callback_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const double lipschitz = calls(solid)->lipschitz;
    (void)box;
    for (int k = 0; k < 3; ++k) {
        ranges[k][0] = -lipschitz;
        ranges[k][1] = lipschitz;
    }
    return lipschitz > 0;
}

static const qni_solid_ops callback_ops = {
    .destroy = destroy,
    .values = callback_values,
    .gradients = callback_gradients,
    .bounds = callback_bounds,
    .crossings = qni_find_crossings,
    .restrict_to = qni_restrict_to_itself,
    .slopes = callback_slopes,
};

static qn_status check(const qn_solid_callback *callback, qn_error *error) {
    if (!callback)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a solid was asked for without its callback");
    QNI_CHECK_OPTIONS(callback, "qn_solid_callback_init", error);
    if (!callback->values)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the callback has no function `values`: it is the one that must be there");
    if (!(callback->lipschitz >= 0) || isinf(callback->lipschitz))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "lipschitz is %g: give a number, or 0 when no bound is known",
                        callback->lipschitz);
    for (int k = 0; k < 3; ++k)
        if (!isfinite(callback->low[k]) || !isfinite(callback->high[k]) ||
            !(callback->low[k] < callback->high[k]))
            return qni_fail(
                error, QN_ERROR_INVALID_ARGUMENT,
                "the callback's box runs from %g to %g along axis %d: low must be below high, "
                "and both finite",
                callback->low[k], callback->high[k], k);
    return QN_OK;
}

qn_status qn_solid_from_callback(qn_context *context, const qn_solid_callback *callback,
                                 qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(check(callback, error));
    callback_solid *solid = (callback_solid *)qni_solid_new(context, sizeof *solid, &callback_ops);
    if (!solid)
        return qni_fail_memory(error, "a solid");
    solid->callback = *callback;
    double size = 0;
    for (int k = 0; k < 3; ++k) {
        solid->base.box.low[k] = callback->low[k];
        solid->base.box.high[k] = callback->high[k];
        size = fmax(size, callback->high[k] - callback->low[k]);
    }
    /* The cube root of the machine's precision: where truncation and rounding weigh alike. */
    solid->step = 6e-6 * size;
    *solid_out = &solid->base;
    return QN_OK;
}
