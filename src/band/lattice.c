// SPDX-License-Identifier: MIT
/* The options of a band, and the lattice they ask for. */
#include "band/band.h"
#include "core/status.h"

#include <math.h>

enum { DEFAULT_DIM = 128, LEAST_WIDTH = 2, MOST_WIDTH = 1000 };
static const double largest_index = 1 << 30;

static bool is_bad(double value) {
    return !isfinite(value) || value < 0;
}

qn_status qni_band_check_options(const qn_band_options *options, qn_error *error) {
    if (is_bad(options->voxel) || options->dim < 0)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "voxel %g, dim %d: give a length or a number above 0 (0: the default)",
                        options->voxel, (int)options->dim);
    if (is_bad(options->half_width) ||
        (options->half_width > 0 && options->half_width < LEAST_WIDTH) ||
        options->half_width > MOST_WIDTH)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a band of %g voxels: take from %d to %d, or 0 for 3", options->half_width,
                        LEAST_WIDTH, MOST_WIDTH);
    if (!isfinite(options->offset) || is_bad(options->shell))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "offset %g, shell %g: give finite lengths, the shell's 0 or more",
                        options->offset, options->shell);
    if ((int)options->sign < 0 || options->sign > QN_MESH_SIGN_WINDING)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "there is no sign choice %d",
                        (int)options->sign);
    for (int i = 0; options->has_origin && i < 3; ++i)
        if (!isfinite(options->origin[i]))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "the origin is not finite");
    return QN_OK;
}

qn_status qni_lattice_place(const qn_band_options *options, const double low[3],
                            const double high[3], double reach, qni_lattice *lattice,
                            qn_error *error) {
    double side = 0;
    for (int i = 0; i < 3; ++i)
        side = fmax(side, high[i] - low[i]);
    const int32_t dim = options->dim ? options->dim : DEFAULT_DIM;
    lattice->voxel = options->voxel > 0 ? options->voxel : side / dim;
    if (!(lattice->voxel > 0))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "there is no size to divide by %d: give the voxel", (int)dim);
    for (int i = 0; i < 3; ++i) {
        lattice->origin[i] = options->has_origin ? options->origin[i] : low[i] + lattice->voxel / 2;
        const double first = floor((low[i] - lattice->origin[i] - reach) / lattice->voxel);
        const double last = ceil((high[i] - lattice->origin[i] + reach) / lattice->voxel);
        if (!(fabs(first) < largest_index && fabs(last) < largest_index))
            return qni_fail(
                error, QN_ERROR_INVALID_ARGUMENT,
                "voxels of %g make more than 2^30 samples along an axis: take larger ones",
                lattice->voxel);
        lattice->low[i] = (int32_t)first;
        lattice->high[i] = (int32_t)last;
    }
    return QN_OK;
}
