// SPDX-License-Identifier: MIT
/* The public solid of a volume: that of its frame, moved to the world. */
#include "solid/primitives.h"
#include "solid/sampled.h"

#include <string.h>

static bool is_identity(const double m[3][4]) {
    for (int row = 0; row < 3; ++row)
        for (int k = 0; k < 4; ++k)
            if (m[row][k] != (row == k))
                return false;
    return true;
}

qn_status qn_solid_from_volume(qn_context *context, const qn_volume *volume, double isovalue,
                               qn_inside inside, const qn_solid_volume_options *options,
                               qn_solid **solid_out, qn_error *error) {
    qn_solid_volume_options defaults;
    qn_solid_volume_options_init(&defaults);
    options = options ? options : &defaults;
    *solid_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_solid_volume_options_init", error);
    if (!volume)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "a solid was asked for without a volume");
    const qni_sampled_settings settings = {.isovalue = isovalue,
                                           .inside_below = inside == QN_INSIDE_BELOW,
                                           .owner = options->owner,
                                           .every_leaf = true};
    qn_solid *own;
    QN_TRY(qni_sampled_create(context, volume, &settings, &own, error));
    const double(*forward)[4] = (const double(*)[4])qni_sampled_frame(own)->to_world;
    if (is_identity(forward)) {
        *solid_out = own;
        return QN_OK;
    }
    double inverse[3][4];
    if (!qni_invert(forward, inverse)) {
        qn_solid_destroy(own);
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the volume's matrix is too nearly singular to be inverted");
    }
    *solid_out = qni_transform_create(context, own, (const double(*)[4])inverse, forward, NULL);
    qn_solid_destroy(own);
    return *solid_out ? QN_OK : qni_fail_memory(error, "a solid");
}
