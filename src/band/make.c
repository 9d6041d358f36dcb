// SPDX-License-Identifier: MIT
/* From options to a volume: what the calls for meshes and for solids share. */
#include "band/band.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

qn_status qni_band_make_volume(qn_context *context, const qni_band_maker *maker,
                               const qn_band_options *options, qn_volume **volume_out,
                               qn_band_report *report_out, qn_error *error) {
    qn_band_options defaults;
    qn_band_options_init(&defaults);
    *volume_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_band_options_init", error);
    options = options ? options : &defaults;
    QN_TRY(qni_band_check_options(options, error));
    const double started = qni_seconds();
    qn_band_report report;
    memset(&report, 0, sizeof report);
    qni_band band = {.work = {.context = context, .error = error, .stage = maker->stage}};
    qn_status status = maker->make(&band, maker->user, options, &report);
    if (status == QN_OK)
        status = qni_band_finish(&band, maker->space, maker->unit, volume_out);
    qni_band_clear(&band);
    QN_TRY(status);
    report.seconds_total = qni_seconds() - started;
    if (report_out)
        *report_out = report;
    return QN_OK;
}
