// SPDX-License-Identifier: MIT
/* Laying the lattice: a cell as near to the one asked for as floats allow, never smaller. */
#include "hermite/lattice.h"
#include "core/status.h"

#include <math.h>

enum { FLOAT_BITS = 24, LEAST_UNIT_BITS = 4, MOST_UNIT_BITS = 14 };

static double largest_magnitude(const qni_box *box) {
    double most = 0;
    for (int k = 0; k < 3; ++k)
        most = fmax(most, fmax(fabs(box->low[k]), fabs(box->high[k])));
    return most;
}

static int32_t round_up(int64_t count, int32_t multiple) {
    return (int32_t)((count + multiple - 1) / multiple * multiple);
}

/* The smallest number of few bits that is at least `least`: times any index of the lattice it is a
 * float. */
static qn_status choose_unit(double least, double magnitude, double *unit_out, qn_error *error) {
    const int index_bits = (int)ceil(log2(magnitude / least + 64));
    int bits = FLOAT_BITS - index_bits;
    if (bits < LEAST_UNIT_BITS)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "cells of %g at coordinates up to %g are too fine for float coordinates: "
                        "move the solid nearer to the "
                        "origin, or take a smaller depth",
                        8 * least, magnitude);
    bits = bits > MOST_UNIT_BITS ? MOST_UNIT_BITS : bits;
    int exponent;
    frexp(least, &exponent);
    *unit_out = ldexp(ceil(ldexp(least, bits - exponent)), exponent - bits);
    return QN_OK;
}

static qn_status check_box(const qni_box *box, qn_error *error) {
    for (int k = 0; k < 3; ++k)
        if (!(box->low[k] <= box->high[k]) || !isfinite(box->low[k]) || !isfinite(box->high[k]))
            return qni_fail(
                error, QN_ERROR_INVALID_ARGUMENT,
                "the box of the solid runs from %g to %g along %c: give a box of finite size",
                box->low[k], box->high[k], "xyz"[k]);
    return QN_OK;
}

qn_status qni_lattice_init(qni_lattice *lattice, const qni_box *bounds, int32_t depth, int32_t base,
                           qn_error *error) {
    QN_TRY(check_box(bounds, error));
    double extent = 0;
    for (int k = 0; k < 3; ++k)
        extent = fmax(extent, bounds->high[k] - bounds->low[k]);
    if (!(extent > 0) || !isfinite(extent) || extent < 1e-30)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the box of the solid has no size: give low and high corners");
    const int32_t finest = 1 << depth;
    QN_TRY(
        choose_unit(extent / (finest - 3) / 8, largest_magnitude(bounds), &lattice->unit, error));
    lattice->cell = 8 * lattice->unit;
    lattice->bounds = *bounds;
    lattice->top = 0;
    while (finest >> lattice->top > base)
        ++lattice->top;
    const int32_t root = 1 << lattice->top;
    for (int k = 0; k < 3; ++k) {
        lattice->first[k] = (int64_t)floor((bounds->low[k] / lattice->unit - 3) / 8) - 1;
        while (qni_lattice_at(lattice, k, 1) > bounds->low[k])
            --lattice->first[k];
        int64_t count = 2;
        while (qni_lattice_at(lattice, k, (int32_t)count - 1) <= bounds->high[k])
            count += qni_lattice_at(lattice, k, (int32_t)count + 63) <= bounds->high[k] ? 64 : 1;
        lattice->cells[k] = round_up(count, root > 8 ? root : 8);
    }
    return QN_OK;
}
