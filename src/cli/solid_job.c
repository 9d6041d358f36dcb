// SPDX-License-Identifier: MIT
/* A solid's surface by Cubical Marching Squares, checked, written, told. */
#include "solid_job.h"
#include "number.h"
#include "output.h"
#include "verdict.h"

#include <math.h>
#include <string.h>

void solid_job_start(solid_job *job, cli_session *session, const char *verb) {
    memset(job, 0, sizeof *job);
    job->session = session;
    job->verb = verb;
    job->surface_options = session->options->solid;
    job->surface_options.open = session->options->open;
}

double solid_job_longest_side(const solid_job *job) {
    const qn_solid_surface_options *asked = &job->surface_options;
    double low[3], high[3], longest = 0;
    qn_solid_get_box(job->solid, low, high);
    for (int k = 0; k < 3; ++k)
        longest = fmax(longest, asked->has_box ? asked->high[k] - asked->low[k] : high[k] - low[k]);
    return longest;
}

void solid_job_end(solid_job *job) {
    json_decref(job->input);
    qn_mesh_destroy(job->mesh);
    qn_solid_destroy(job->solid);
    band_free(&job->band);
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
    if (job->band.report)
        json_object_set(report, "band", job->band.report);
    json_object_set_new(report, "surface",
                        job->by_dmc ? report_surface(&job->dual)
                                    : report_solid_surface(&job->surface));
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
    char faces[NUMBER_TEXT_SIZE], vertices[NUMBER_TEXT_SIZE], text[VERDICT_TEXT_SIZE];
    const cli_options *options = job->session->options;
    const qn_mesh_view view = qn_mesh_get_view(job->mesh);
    const double seconds = job->by_dmc ? job->dual.seconds_total : job->surface.seconds_total;
    cli_tell(job->session, "%s: %s %s, %s vertices in %.2f s%s%s",
             options->output ? options->output : options->input,
             number_format_count(view.quad_count + view.triangle_count, faces),
             view.quad_count ? "quads" : "triangles",
             number_format_count(view.vertex_count, vertices), job->band.seconds_band + seconds,
             job->failed ? "; FAILED: " : "",
             job->failed ? verdict_describe(&job->check, job->failed, text) : "");
}

/* What follows the surface. */
static int finish(solid_job *job) {
    const cli_options *options = job->session->options;
    int exit_code = check_mesh(job);
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

int solid_job_run(solid_job *job) {
    if (job->session->options->dry_run)
        return solid_job_plan(job);
    const int exit_code = make_surface(job);
    return exit_code ? exit_code : finish(job);
}

static int make_dual_surface(solid_job *job) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.inside = QN_INSIDE_BELOW;
    options.triangles = job->session->options->triangles;
    options.untangle = job->session->options->untangle;
    qn_error error;
    const int exit_code = cli_fail(job->session,
                                   qn_surface(job->session->context, job->band.volume, &options,
                                              &job->mesh, &job->dual, &error),
                                   &error);
    if (exit_code || job->dual.quads > 0)
        return exit_code;
    cli_say("%s: there is no surface: is --offset or --shell right, and the voxel small enough?",
            job->session->options->input);
    return CLI_EMPTY;
}

int solid_job_run_dmc(solid_job *job) {
    job->by_dmc = true;
    job->seconds_read = job->band.seconds_read;
    const int exit_code = make_dual_surface(job);
    return exit_code ? exit_code : finish(job);
}

int solid_job_take_band(solid_job *job) {
    qn_error error;
    job->seconds_read = job->band.seconds_read;
    return cli_fail(job->session,
                    qn_solid_from_volume(job->session->context, job->band.volume, 0,
                                         QN_INSIDE_BELOW, NULL, &job->solid, &error),
                    &error);
}
