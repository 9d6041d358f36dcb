// SPDX-License-Identifier: MIT
/* Laying the lattice: a cell as near to the one asked for as floats allow, never smaller. */
#include "hermite/lattice.h"
#include "core/status.h"
#include "solid/sampled.h"

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
    double unit = 0;
    QN_TRY(choose_unit(extent / (finest - 3) / 8, largest_magnitude(bounds), &unit, error));
    lattice->cell = 8 * unit;
    lattice->shift = 0;
    lattice->clearance = 0;
    lattice->samples = false;
    lattice->bounds = *bounds;
    lattice->top = 0;
    while (finest >> lattice->top > base)
        ++lattice->top;
    const int32_t root = 1 << lattice->top;
    for (int k = 0; k < 3; ++k) {
        int64_t first = (int64_t)floor((bounds->low[k] / unit - 3) / 8) - 1;
        while ((double)(8 * (first + 1) + 3) * unit > bounds->low[k])
            --first;
        lattice->step[k] = lattice->cell;
        lattice->origin[k] = (double)(8 * first + 3) * unit;
        int64_t count = 2;
        while (qni_lattice_at(lattice, k, (int32_t)count - 1) <= bounds->high[k])
            count += qni_lattice_at(lattice, k, (int32_t)count + 63) <= bounds->high[k] ? 64 : 1;
        lattice->cells[k] = round_up(count, root > 8 ? root : 8);
    }
    return QN_OK;
}

/* A block of cells before the first point, so that blocks are the volume's leaves and all cells at
 * the surface have neighbours. */
qn_status qni_lattice_of_samples(qni_lattice *lattice, const qn_solid *solid, int32_t base,
                                 bool open, qn_error *error) {
    enum { MARGIN = 8, MOST_CELLS = 1 << 24 };
    const qni_sample_frame *frame = qni_sampled_frame(solid);
    int32_t most = 0;
    lattice->shift = MARGIN;
    lattice->samples = true;
    lattice->cell = 0;
    lattice->clearance = 0;
    for (int k = 0; k < 3; ++k) {
        if (frame->count[k] > MOST_CELLS)
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "%d samples along an axis are too many for cms: take dmc",
                            (int)frame->count[k] - 2);
        lattice->origin[k] = frame->origin[k];
        lattice->step[k] = frame->step[k];
        lattice->cell = fmax(lattice->cell, frame->step[k]);
        lattice->bounds.low[k] = open ? qni_sample_plane(frame, k, 1) : (double)-INFINITY;
        lattice->bounds.high[k] =
            open ? qni_sample_plane(frame, k, frame->count[k] - 2) : (double)INFINITY;
        most = frame->count[k] - 1 > most ? frame->count[k] - 1 : most;
        if (!frame->exact && (k == 0 || frame->step[k] / 512 < lattice->clearance))
            lattice->clearance = frame->step[k] / 512;
    }
    int32_t finest = 8;
    while (finest < most)
        finest *= 2;
    lattice->top = 0;
    while (finest >> lattice->top > base)
        ++lattice->top;
    const int32_t root = 1 << lattice->top;
    for (int k = 0; k < 3; ++k)
        lattice->cells[k] = round_up((int64_t)frame->count[k] + MARGIN, root > 8 ? root : 8);
    return QN_OK;
}
