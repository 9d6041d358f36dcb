// SPDX-License-Identifier: MIT
/* One run of quoin mesh: what it works on and what came out, and how that is told. */
#ifndef CLI_MESH_JOB_H
#define CLI_MESH_JOB_H

#include "session.h"
#include "verdict.h"

typedef struct mesh_result {
    char *path;
    bool checked, written;
    qn_mesh_report check;
    uint32_t failed; /* faults that count and are there */
    int64_t bytes;   /* of the file; -1 when it has no size */
    double seconds_check, seconds_write;
} mesh_result;

typedef struct mesh_job {
    cli_session *session;
    qn_volume *volume;
    bool has_statistics;
    qn_volume_statistics statistics;
    qn_inside inside;
    int32_t count; /* of iso-values; the arrays have this length */
    double *isovalues;
    qn_mesh **meshes;
    qn_surface_report *surfaces;
    qn_solid_surface_report *adaptive; /* of --mode cms, else NULL */
    mesh_result *results;
    double seconds_read, seconds_statistics, seconds_surface;
} mesh_job;

/* Needs the statistics. NaN: there is no iso-value to try at all. */
void mesh_job_say_empty(const mesh_job *job, double isovalue);
void mesh_job_tell_result(const mesh_job *job, int32_t i);
void mesh_job_tell_plan(const mesh_job *job, int32_t i);
/* Returns 0 or an exit code after having said what is wrong. */
int mesh_job_write_report(const mesh_job *job, int exit_code);

/* --mode cms (mesh_cms.c). The first two return 0 or an exit code after having said what is wrong.
 */
int mesh_cms_check_options(const cli_options *options);
int mesh_cms_extract(mesh_job *job);
void mesh_cms_tell(const mesh_job *job, int32_t i);

#endif
