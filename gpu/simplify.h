// SPDX-License-Identifier: MIT
/* Simplification of a finished mesh on the device. */
#ifndef QNI_GPU_SIMPLIFY_H
#define QNI_GPU_SIMPLIFY_H

#include "gpu/driver.h"

/* After qni_gpu_finish_surface() of a job with valences. The job's arrays and counts are those of
 * the simplified mesh afterwards; `report` gets what was removed. As qni_simplify() of
 * dmc/simplify.h with passes >= 0, to the byte. Synchronises a few times a pass. */
qn_status qni_gpu_simplify(qni_gpu_job *job, const qn_surface_options *options,
                           qn_surface_report *report, qn_error *error);

#endif
