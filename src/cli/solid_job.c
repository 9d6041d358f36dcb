// SPDX-License-Identifier: MIT
/* A solid's surface by Cubical Marching Squares, checked, written, told. */
#include "solid_job.h"
#include "number.h"
#include "output.h"
#include "verdict.h"

#include <string.h>

void solid_job_start(solid_job *job, cli_session *session, const char *verb) {
    memset(job, 0, sizeof *job);
    job->session = session;
    job->verb = verb;
    job->surface_options = session->options->solid;
    job->surface_options.open = session->options->open;
}

void solid_job_end(solid_job *job) {
    json_decref(job->input);
    qn_mesh_destroy(job->mesh);
    qn_solid_destroy(job->solid);
}

static int make_surface(solid_job *job) {
    const cli_options *options = job->session->options;
    qn_error error;
    int exit_code =
        cli_fail(job->session,
                 qn_solid_surface(job->session->context, job->solid, &job->surface_options,
                                  &job->mesh, &job->surface, &error),
                 &error);
    if (!exit_code && job->surface.triangles == 0) {
        cli_say("%s: there is no surface in the box; is it large enough, and --depth?",
                options->input);
        exit_code = CLI_EMPTY;
    }
    return exit_code;
}

static int check_mesh(solid_job *job) {
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

static int write_report(const solid_job *job, int exit_code) {
    const cli_options *options = job->session->options;
    json_t *report = report_start(job->verb);
    json_object_set_new(report, "input", report_path(options->input));
    json_object_set_new(report, "output",
                        options->output ? report_path(options->output) : json_null());
    if (job->input)
        json_object_set(report, "model", job->input);
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

static void tell_result(const solid_job *job) {
    char triangles[NUMBER_TEXT_SIZE], vertices[NUMBER_TEXT_SIZE], text[VERDICT_TEXT_SIZE];
    const cli_options *options = job->session->options;
    cli_tell(job->session, "%s: %s triangles, %s vertices in %.2f s%s%s",
             options->output ? options->output : options->input,
             number_format_count(job->surface.triangles, triangles),
             number_format_count(job->surface.vertices, vertices), job->surface.seconds_total,
             job->failed ? "; FAILED: " : "",
             job->failed ? verdict_describe(&job->check, job->failed, text) : "");
}

int solid_job_run(solid_job *job) {
    const cli_options *options = job->session->options;
    if (options->dry_run)
        return solid_job_plan(job);
    int exit_code = make_surface(job);
    if (!exit_code)
        exit_code = check_mesh(job);
    if (exit_code)
        return exit_code;
    const double started = cli_seconds();
    exit_code = output_write_mesh(job->session, job->mesh, options->output, &job->bytes);
    job->seconds_write = cli_seconds() - started;
    if (exit_code)
        return exit_code;
    tell_result(job);
    exit_code = job->failed ? CLI_QUALITY : 0;
    const int report_code = options->report ? write_report(job, exit_code) : 0;
    return report_code ? report_code : exit_code;
}
