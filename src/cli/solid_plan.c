// SPDX-License-Identifier: MIT
/* --dry-run of solids: the surface at two small depths, and how it grows from one to the other, say
 * about what the wanted depth takes. So a plan costs little, whatever the depth. */
#include "number.h"
#include "output.h"
#include "solid_job.h"

#include <math.h>

enum { PLAN_DEPTH = 6, DEFAULT_DEPTH = 7 };

/* At one more level a surface has four times the cells, but where it is flat nothing is added; with
 * a tolerance that is a share of the cell, curved parts get about twice the triangles. */
static double growth(double coarse, double fine, double most) {
    return coarse > 0 ? fmin(fmax(fine / coarse, 1), most) : 1;
}

/* What the quantity becomes after some more levels, to two digits. */
static int64_t grown(double coarse, double fine, int levels, double most) {
    const double value = fine * pow(growth(coarse, fine, most), levels);
    const double unit = value > 100 ? pow(10, floor(log10(value)) - 1) : 1;
    return (int64_t)(round(value / unit) * unit);
}

/* The depth that is asked for, or that of a size of cells. */
static int wanted_depth(const solid_job *job) {
    const qn_solid_surface_options *options = &job->surface_options;
    return options->cell > 0 ? qn_depth_of_cell(options->cell, solid_job_longest_side(job))
           : options->depth  ? options->depth
                             : DEFAULT_DEPTH;
}

static int try_depth(solid_job *job, int depth, qn_solid_surface_report *report) {
    qn_solid_surface_options options = job->surface_options;
    qn_mesh *mesh = NULL;
    qn_error error;
    options.cell = ldexp(options.cell, wanted_depth(job) - depth);
    options.depth = options.cell > 0 ? 0 : depth;
    options.base = options.base && options.base < 1 << depth ? options.base : 0;
    const int exit_code = cli_fail(
        job->session,
        qn_solid_surface(job->session->context, job->solid, &options, &mesh, report, &error),
        &error);
    qn_mesh_destroy(mesh);
    return exit_code;
}

static int make_plan(solid_job *job, solid_plan *plan) {
    const int depth = wanted_depth(job);
    const int fine = depth < PLAN_DEPTH ? depth : PLAN_DEPTH, levels = depth - fine;
    qn_solid_surface_report last, before;
    int exit_code = try_depth(job, fine, &last);
    before = last;
    if (!exit_code && levels > 0)
        exit_code = try_depth(job, fine - 1, &before);
    if (exit_code)
        return exit_code;
    if (last.triangles == 0 && levels == 0) {
        cli_say("%s: there is no surface in the box; is it large enough, and --depth?",
                job->session->options->input);
        return CLI_EMPTY;
    }
    const bool adaptive = !job->surface_options.uniform && !(job->surface_options.tolerance > 0);
    const double most = adaptive ? 2.5 : 4;
    plan->exact = levels == 0;
    plan->depth = depth;
    plan->triangles = grown((double)before.triangles, (double)last.triangles, levels, most);
    plan->vertices = grown((double)before.vertices, (double)last.vertices, levels, most);
    plan->mesh_bytes = grown((double)before.output_bytes, (double)last.output_bytes, levels, most);
    plan->scratch_bytes =
        grown((double)before.scratch_bytes, (double)last.scratch_bytes, levels, 4);
    plan->seconds = last.seconds_total *
                    pow(growth((double)before.evaluations, (double)last.evaluations, 4), levels);
    if (plan->exact) {
        plan->triangles = last.triangles;
        plan->vertices = last.vertices;
    }
    plan->file_bytes =
        output_estimate_bytes(job->session->options, plan->vertices, 0, plan->triangles);
    return 0;
}

static void tell(const solid_job *job, const solid_plan *plan) {
    char triangles[NUMBER_TEXT_SIZE], vertices[NUMBER_TEXT_SIZE], mesh[NUMBER_TEXT_SIZE],
        scratch[NUMBER_TEXT_SIZE], file[NUMBER_TEXT_SIZE], time[NUMBER_TEXT_SIZE];
    const char *output = job->session->options->output;
    cli_tell(
        job->session,
        "dry run: depth %d: %s%s triangles, %s vertices, about %s; memory: mesh %s, "
        "scratch %s; %s: about %s; nothing written",
        plan->depth, plan->exact ? "" : "about ", number_format_count(plan->triangles, triangles),
        number_format_count(plan->vertices, vertices), number_format_duration(plan->seconds, time),
        number_format_bytes(plan->mesh_bytes, mesh),
        number_format_bytes(plan->scratch_bytes, scratch), output ? output : "as PLY",
        number_format_bytes(plan->file_bytes, file));
}

static int write_report(const solid_job *job, const solid_plan *plan) {
    const cli_options *options = job->session->options;
    json_t *report = report_start(job->verb);
    json_object_set_new(report, "input", report_path(options->input));
    json_object_set_new(report, "output",
                        options->output ? report_path(options->output) : json_null());
    if (job->input)
        json_object_set(report, "model", job->input);
    json_object_set_new(
        report, "plan",
        json_pack("{s:b, s:i, s:I, s:I, s:I, s:I, s:I, s:o}", "exact", plan->exact, "depth",
                  plan->depth, "triangles", (json_int_t)plan->triangles, "vertices",
                  (json_int_t)plan->vertices, "mesh_bytes", (json_int_t)plan->mesh_bytes,
                  "scratch_bytes", (json_int_t)plan->scratch_bytes, "file_bytes",
                  (json_int_t)plan->file_bytes, "seconds", report_real(plan->seconds)));
    json_object_set_new(report, "memory", report_memory(job->session));
    json_object_set_new(report, "exit_code", json_integer(0));
    return report_write(report, options->report);
}

int solid_job_plan(solid_job *job) {
    solid_plan plan;
    const int exit_code = make_plan(job, &plan);
    if (exit_code)
        return exit_code;
    tell(job, &plan);
    return job->session->options->report ? write_report(job, &plan) : 0;
}
