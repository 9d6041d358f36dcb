// SPDX-License-Identifier: MIT
/* quoin csg: read a solid, make its surface by Cubical Marching Squares, check, write, report. */
#include "output.h"
#include "solid_job.h"
#include "verbs.h"

static int read_solid(solid_job *job) {
    const cli_options *options = job->session->options;
    const double started = cli_seconds();
    qn_solid_read_options read;
    qn_solid_read_options_init(&read);
    read.smooth_primitives = options->smooth_primitives;
    for (int k = 0; options->solid.has_box && k < 3; ++k) {
        read.low[k] = options->solid.low[k];
        read.high[k] = options->solid.high[k];
    }
    qn_error error;
    const int exit_code = cli_fail(
        job->session,
        qn_solid_read(job->session->context, options->input, &read, &job->solid, &error), &error);
    job->seconds_read = cli_seconds() - started;
    return exit_code;
}

/* --voxel, or --dim along the longest side of the solid's box. */
static void set_cell(solid_job *job) {
    const cli_options *options = job->session->options;
    job->surface_options.cell =
        options->cells ? solid_job_longest_side(job) / (double)options->cells : options->voxel;
}

int verb_csg(cli_session *session) {
    solid_job job;
    solid_job_start(&job, session, "csg");
    int exit_code = output_check(session->options);
    if (!exit_code)
        exit_code = read_solid(&job);
    if (!exit_code && session->options->dmc) {
        exit_code = band_of_solid(session, job.solid, &job.band);
        if (!exit_code)
            exit_code = solid_job_run_dmc(&job);
    } else if (!exit_code) {
        set_cell(&job);
        exit_code = solid_job_run(&job);
    }
    solid_job_end(&job);
    return exit_code;
}
