// SPDX-License-Identifier: MIT
/* JSON: stable keys, schema 1. Real numbers read back the same; NaN and infinity are null. */
#ifndef CLI_REPORT_H
#define CLI_REPORT_H

#include "session.h"
#include <jansson.h>

enum { REPORT_SCHEMA = 1 };

/* All return new references. */
json_t *report_start(const char *verb); /* {"quoin": version, "schema": 1, "verb": verb} */
json_t *report_real(double value);      /* null when it is not finite */
json_t *report_reals(const double *values, int count);
json_t *report_path(const char *path); /* what is not UTF-8 becomes "?" */
json_t *report_volume(const char *path, const qn_volume *volume);
json_t *report_statistics(const qn_volume_statistics *statistics);
json_t *report_surface(const qn_surface_report *surface);
json_t *report_solid_surface(const qn_solid_surface_report *surface);
json_t *report_mesh_check(const qn_mesh_report *check);
json_t *report_memory(const cli_session *session);

/* Writes (whole or not at all) to a file, or stdout for "-", and drops the reference.
 * Returns 0 or an exit code after having said what is wrong. */
int report_write(json_t *report, const char *path);

#endif
