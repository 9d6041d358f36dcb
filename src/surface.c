// SPDX-License-Identifier: MIT
/* The facade: checks the options, runs the surfacer, owns progress; contains no numerics. */
#include <qn/surface.h>
#include "core/status.h"

qn_status qn_surface(qn_context *context, const qn_volume *volume,
                     const qn_surface_options *options, qn_mesh **meshes_out,
                     qn_surface_report *reports_out, qn_error *error) {
    (void)context, (void)volume, (void)meshes_out, (void)reports_out;
    QNI_CHECK_OPTIONS(options, "qn_surface_options_init", error);
    return qni_fail(error, QN_ERROR_UNSUPPORTED, "no surfacer is built in yet");
}
