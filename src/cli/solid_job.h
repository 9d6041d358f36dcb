// SPDX-License-Identifier: MIT
/* What csg and remesh share: a solid's surface by Cubical Marching Squares, checked, written, told.
 */
#ifndef CLI_SOLID_JOB_H
#define CLI_SOLID_JOB_H

#include "band_input.h"
#include "report.h"
#include "session.h"

typedef struct solid_job {
    cli_session *session;
    const char *verb;
    qn_solid *solid;
    qn_mesh *mesh;
    qn_solid_surface_options surface_options;
    qn_solid_surface_report surface;
    qn_mesh_report check;
    bool checked;
    uint32_t failed; /* faults that count and are there */
    double seconds_read, seconds_check, seconds_write;
    int64_t bytes;
    band_input band;        /* of --mode dmc, --offset, --shell */
    bool by_dmc;            /* the surface is that of the band, by dual marching cubes */
    qn_surface_report dual; /* then */
    json_t *input;          /* more of the report, or NULL; dropped by solid_job_end() */
} solid_job;

/* What a surface takes, known or estimated. */
typedef struct solid_plan {
    bool exact;
    int depth;
    int64_t triangles, vertices, mesh_bytes, scratch_bytes, file_bytes;
    double seconds;
} solid_plan;

void solid_job_start(solid_job *job, cli_session *session, const char *verb);
/* The longest side of the solid's box, or of the one that is asked for. */
double solid_job_longest_side(const solid_job *job);
/* From job->solid to the file and the report. Returns an exit code after having said what is wrong.
 */
int solid_job_run(solid_job *job);
/* The same from job->band.volume by dual marching cubes. */
int solid_job_run_dmc(solid_job *job);
/* Makes job->solid of job->band.volume. */
int solid_job_take_band(solid_job *job);
/* --dry-run: tell what that would take (solid_plan.c). */
int solid_job_plan(solid_job *job);
void solid_job_end(solid_job *job);

#endif
