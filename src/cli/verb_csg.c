// SPDX-License-Identifier: MIT
/* quoin csg: read a solid, make its surface by Cubical Marching Squares, check, write, report. */
#include "number.h"
#include "output.h"
#include "report.h"
#include "verbs.h"
#include "verdict.h"

#include <string.h>

typedef struct csg_job {
    cli_session *session;
    qn_solid *solid;
    qn_mesh *mesh;
    qn_solid_surface_report surface;
    qn_mesh_report check;
    bool checked;
    uint32_t failed; /* faults that count and are there */
    double seconds_read, seconds_check, seconds_write;
    int64_t bytes;
} csg_job;

static int read_solid(csg_job *job) {
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

static int make_surface(csg_job *job) {
    const cli_options *options = job->session->options;
    qn_solid_surface_options surface = options->solid;
    surface.open = options->open;
    qn_error error;
    int exit_code = cli_fail(job->session,
                             qn_solid_surface(job->session->context, job->solid, &surface,
                                              &job->mesh, &job->surface, &error),
                             &error);
    if (!exit_code && job->surface.triangles == 0) {
        cli_say("%s: there is no surface in the box; is it large enough, and --depth?",
                options->input);
        exit_code = CLI_EMPTY;
    }
    return exit_code;
}

static int check_mesh(csg_job *job) {
    const cli_options *options = job->session->options;
    if (!options->check && !options->report && !options->fail_on_given)
        return 0;
    const double started = cli_seconds();
    qn_error error;
    const int exit_code = cli_fail(
        job->session, qn_mesh_check(job->session->context, job->mesh, NULL, &job->check, &error),
        &error);
    job->checked = exit_code == 0;
    job->seconds_check = cli_seconds() - started;
    const uint32_t counted = options->fail_on_given ? options->fail_on
                             : options->check
                                 ? VERDICT_DEFAULT & ~(options->open ? (uint32_t)FAULT_OPEN : 0u)
                                 : 0;
    job->failed = job->checked ? verdict_faults(&job->check) & counted : 0;
    return exit_code;
}

static int write_report(const csg_job *job, int exit_code) {
    const cli_options *options = job->session->options;
    json_t *report = report_start("csg");
    json_object_set_new(report, "input", report_path(options->input));
    json_object_set_new(report, "output",
                        options->output ? report_path(options->output) : json_null());
    json_object_set_new(report, "surface", report_solid_surface(&job->surface));
    json_object_set_new(report, "check",
                        job->checked ? report_mesh_check(&job->check) : json_null());
    json_object_set_new(report, "seconds_read", report_real(job->seconds_read));
    json_object_set_new(report, "seconds_check", report_real(job->seconds_check));
    json_object_set_new(report, "seconds_write", report_real(job->seconds_write));
    json_object_set_new(report, "memory", report_memory(job->session));
    json_object_set_new(report, "exit_code", json_integer(exit_code));
    return report_write(report, options->report);
}

static void tell_result(const csg_job *job) {
    char triangles[NUMBER_TEXT_SIZE], vertices[NUMBER_TEXT_SIZE], text[VERDICT_TEXT_SIZE];
    const cli_options *options = job->session->options;
    cli_tell(job->session, "%s: %s triangles, %s vertices in %.2f s%s%s",
             options->output ? options->output : options->input,
             number_format_count(job->surface.triangles, triangles),
             number_format_count(job->surface.vertices, vertices), job->surface.seconds_total,
             job->failed ? "; FAILED: " : "",
             job->failed ? verdict_describe(&job->check, job->failed, text) : "");
}

static int run(csg_job *job) {
    const cli_options *options = job->session->options;
    int exit_code = output_check(options);
    if (!exit_code)
        exit_code = read_solid(job);
    if (!exit_code)
        exit_code = make_surface(job);
    if (!exit_code)
        exit_code = check_mesh(job);
    if (exit_code)
        return exit_code;
    const double started = cli_seconds();
    if (!options->dry_run)
        exit_code = output_write_mesh(job->session, job->mesh, options->output, &job->bytes);
    job->seconds_write = cli_seconds() - started;
    if (exit_code)
        return exit_code;
    tell_result(job);
    exit_code = job->failed ? CLI_QUALITY : 0;
    const int report_code = options->report ? write_report(job, exit_code) : 0;
    return report_code ? report_code : exit_code;
}

int verb_csg(cli_session *session) {
    csg_job job;
    memset(&job, 0, sizeof job);
    job.session = session;
    const int exit_code = run(&job);
    qn_mesh_destroy(job.mesh);
    qn_solid_destroy(job.solid);
    return exit_code;
}
