// SPDX-License-Identifier: MIT
/* Laying the lattice: a cell as near to the one asked for as floats allow, never smaller. */
#include "hermite/lattice.h"
#include "core/status.h"
#include "solid/sampled.h"

#include <qn/surface.h>

#include <math.h>

enum { FLOAT_BITS = 24, LEAST_CELL_BITS = 4, REFERENCE = 7 /* a depth */ };

/* Of a cell of depth 7, between a plane and 0: 1/15, 2/15, 4/15, 8/15 and so on at greater depths.
 * The extent is 124 such cells, so where a solid begins at 0, or lies round it, planes are as far
 * off its sides, middle and quarters, and as far and more off its thirds and fifths. */
#define ANCHOR (8.0 / 15)

static double largest_magnitude(const qni_box *box) {
    double most = 0;
    for (int k = 0; k < 3; ++k)
        most = fmax(most, fmax(fabs(box->low[k]), fabs(box->high[k])));
    return most;
}

static int32_t round_up(int64_t count, int32_t multiple) {
    return (int32_t)((count + multiple - 1) / multiple * multiple);
}

/* Floats must be dense enough for crossings to lie strictly within their edges. */
static qn_status check_cell(double cell, double magnitude, qn_error *error) {
    if (log2(8 * magnitude / cell + 64) > FLOAT_BITS - LEAST_CELL_BITS)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "cells of %g at coordinates up to %g are too fine for float coordinates: "
                        "move the solid nearer to the "
                        "origin, or take a smaller depth",
                        cell, magnitude);
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

/* From the last plane of depth 7 with a layer of its cells before the bounds; where cells are
 * larger, from a root before that. */
static void lay_axis(qni_lattice *lattice, int k, double coarse, int32_t granule) {
    const qni_box *bounds = &lattice->bounds;
    double first = floor(bounds->low[k] / coarse - ANCHOR) - 1;
    if (first + 1 + ANCHOR > bounds->low[k] / coarse)
        --first;
    lattice->step[k] = lattice->cell;
    lattice->origin[k] = (first + ANCHOR) * coarse;
    lattice->shift[k] = 0;
    while (qni_lattice_at(lattice, k, 1) > bounds->low[k])
        lattice->shift[k] += granule;
    int64_t count = 2;
    while (qni_lattice_at(lattice, k, (int32_t)count - 1) <= bounds->high[k])
        count += qni_lattice_at(lattice, k, (int32_t)count + 63) <= bounds->high[k] ? 64 : 1;
    lattice->cells[k] = round_up(count, granule);
}

qn_status qni_lattice_init(qni_lattice *lattice, const qni_box *bounds, double extent,
                           int32_t depth, int32_t base, qn_error *error) {
    QN_TRY(check_box(bounds, error));
    if (!(extent > 0) || !isfinite(extent) || extent < 1e-30)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the box of the solid has no size: give low and high corners");
    const int32_t finest = 1 << depth;
    const double coarse = extent / qn_depth_cells(REFERENCE); /* a cell of that depth */
    lattice->cell = ldexp(coarse, REFERENCE - depth);
    lattice->clearance = 0;
    lattice->samples = false;
    lattice->bounds = *bounds;
    lattice->top = 0;
    QN_TRY(check_cell(lattice->cell, largest_magnitude(bounds), error));
    while (finest >> lattice->top > base)
        ++lattice->top;
    const int32_t root = 1 << lattice->top;
    for (int k = 0; k < 3; ++k)
        lay_axis(lattice, k, coarse, root > 8 ? root : 8);
    return QN_OK;
}

/* A block of cells before the first point, so that blocks are the volume's leaves and all cells at
 * the surface have neighbours. */
qn_status qni_lattice_of_samples(qni_lattice *lattice, const qn_solid *solid, int32_t base,
                                 bool open, qn_error *error) {
    enum { MARGIN = 8, MOST_CELLS = 1 << 24 };
    const qni_sample_frame *frame = qni_sampled_frame(solid);
    int32_t most = 0;
    lattice->samples = true;
    lattice->cell = 0;
    lattice->clearance = 0;
    for (int k = 0; k < 3; ++k) {
        if (frame->count[k] > MOST_CELLS)
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "%d samples along an axis are too many for cms: take dmc",
                            (int)frame->count[k] - 2);
        lattice->shift[k] = MARGIN;
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
