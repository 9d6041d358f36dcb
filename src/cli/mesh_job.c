// SPDX-License-Identifier: MIT
/* How a run of quoin mesh is told: lines for people, and the JSON report. */
#include "mesh_job.h"
#include "number.h"
#include "output.h"
#include "report.h"

#include <inttypes.h>
#include <math.h>

static int64_t sample_count(const mesh_job *job) {
    const int64_t *size = qn_volume_grid(job->volume)->size;
    return size[0] * size[1] * size[2];
}

void mesh_job_say_empty(const mesh_job *job, double isovalue) {
    const qn_volume_statistics *s = &job->statistics;
    const char *path = job->session->options->input;
    char iso[NUMBER_TEXT_SIZE], low[NUMBER_TEXT_SIZE], high[NUMBER_TEXT_SIZE];
    char better[NUMBER_TEXT_SIZE];
    if (!isfinite(s->minimum)) {
        cli_say("%s: no surface: there is no finite value in this volume", path);
        return;
    }
    number_format_real(s->minimum, low);
    number_format_real(s->maximum, high);
    if (s->minimum == s->maximum || isnan(isovalue))
        cli_say("%s: no surface: all values are %s", path, low);
    else if (s->suggestion_count > 0 && s->suggested != isovalue)
        cli_say("%s: no surface at iso %s: values run from %s to %s; try --iso %s or 'quoin info "
                "%s'",
                path, number_format_real(isovalue, iso), low, high,
                number_format_real(s->suggested, better), path);
    else
        cli_say("%s: no surface at iso %s: values run from %s to %s; see 'quoin info %s'", path,
                number_format_real(isovalue, iso), low, high, path);
}

static void tell_details(const mesh_job *job, int32_t i) {
    const qn_surface_report *s = &job->surfaces[i];
    const mesh_result *result = &job->results[i];
    cli_tell(job->session,
             "  cells with surface %" PRId64 ", ambiguous faces %" PRId64 " (ties %" PRId64
             "), cells with several polygons %" PRId64 ", fallback points %" PRId64
             ", degenerate points %" PRId64 ", doubled edges taken apart %" PRId64
             ", tunnels inside cells %" PRId64 ", restored %" PRId64,
             s->active_cells, s->ambiguous_faces, s->tied_faces, s->multiple_cells,
             s->fallback_points, s->degenerate_points, s->repaired_edges, s->tunnels,
             s->restored_tunnels);
    if (s->simplify_passes > 0)
        cli_tell(job->session,
                 "  simplified in %d passes: %" PRId64 " quads removed by 3-X-3-Y, %" PRId64
                 " by 3-3-3-3; %.3f s",
                 (int)s->simplify_passes, s->merged_quads, s->shrunk_quads, s->seconds_simplify);
    if (job->session->options->relax > 0)
        cli_tell(job->session, "  relaxed: %" PRId64 " vertices moved; %.3f s", s->relaxed_vertices,
                 s->seconds_relax);
    if (s->crossings > 0)
        cli_tell(job->session,
                 "  untangled: %" PRId64 " crossing pairs found, %" PRId64 " left; %" PRId64
                 " vertices moved by %.2f cells at most; %.3f s",
                 s->crossings, s->crossings_left, s->untangled_vertices, s->untangled_farthest,
                 s->seconds_untangle);
    cli_tell(job->session, "  seconds: read %.3f, classify %.3f, emit %.3f, check %.3f, write %.3f",
             job->seconds_read, s->seconds_classify, s->seconds_emit, result->seconds_check,
             result->seconds_write);
}

static void tell_samples(const mesh_job *job, int32_t i) {
    const qn_surface_report *s = &job->surfaces[i];
    if (i == 0 && s->nan_samples + s->infinite_samples > 0)
        cli_tell(job->session,
                 "%s: %" PRId64 " samples are not numbers (taken as outside), %" PRId64
                 " are infinite",
                 job->session->options->input, s->nan_samples, s->infinite_samples);
}

/* "1,234 vertices, 1,232 quads" of what is written. */
static void format_counts(const cli_options *options, const qn_surface_report *s, char *text,
                          size_t size) {
    char vertices[NUMBER_TEXT_SIZE], faces[NUMBER_TEXT_SIZE], format[8] = "ply";
    if (options->output)
        output_format(options, format);
    bool split = options->triangles || output_splits_quads(format);
    snprintf(text, size, "%s vertices, %s %s%s", number_format_count(s->vertices, vertices),
             number_format_count(split ? 2 * s->quads : s->quads, faces),
             split ? "triangles" : "quads",
             split && !options->triangles ? " (the format holds no quads: they were split)" : "");
}

static void tell_check(const mesh_job *job, int32_t i) {
    const mesh_result *result = &job->results[i];
    uint32_t faults = verdict_faults(&result->check);
    char text[VERDICT_TEXT_SIZE];
    if (job->session->options->open)
        faults &= ~(uint32_t)FAULT_OPEN | result->failed;
    verdict_describe(&result->check, faults, text);
    if (result->failed)
        cli_say("%s: check FAILED: %s", result->path, text);
    else if (faults)
        cli_tell(job->session, "%s: check: passed; seen: %s", result->path, text);
    else
        cli_tell(job->session, "%s: check: passed: %smanifold, oriented, no self-intersections",
                 result->path, result->check.closed ? "closed, " : "");
}

void mesh_job_tell_result(const mesh_job *job, int32_t i) {
    const qn_surface_report *s = &job->surfaces[i];
    char iso[NUMBER_TEXT_SIZE], counts[160], size[NUMBER_TEXT_SIZE];
    int64_t bytes = job->results[i].bytes;
    if (job->adaptive) {
        mesh_cms_tell(job, i);
        if (job->results[i].checked)
            tell_check(job, i);
        return;
    }
    tell_samples(job, i);
    format_counts(job->session->options, s, counts, sizeof counts);
    cli_tell(job->session, "%s: iso %s: %s%s%s, %.2f s (%.1f million voxels/s)",
             job->results[i].path, number_format_real(s->isovalue, iso), counts,
             bytes >= 0 ? ", " : "", bytes >= 0 ? number_format_bytes(bytes, size) : "",
             s->seconds_total,
             s->seconds_total > 0 ? 1e-6 * (double)sample_count(job) / s->seconds_total : 0.0);
    if (job->session->options->verbose)
        tell_details(job, i);
    if (job->results[i].checked)
        tell_check(job, i);
}

static int64_t estimate_file(const mesh_job *job, int32_t i) {
    const cli_options *options = job->session->options;
    const qn_surface_report *s = &job->surfaces[i];
    if (job->adaptive)
        return output_estimate_bytes(options, job->adaptive[i].vertices, 0,
                                     job->adaptive[i].triangles);
    return output_estimate_bytes(options, s->vertices, options->triangles ? 0 : s->quads,
                                 options->triangles ? 2 * s->quads : 0);
}

void mesh_job_tell_plan(const mesh_job *job, int32_t i) {
    const qn_surface_report *s = &job->surfaces[i];
    const char *path = job->results[i].path;
    if (job->adaptive) {
        mesh_cms_tell(job, i);
        return;
    }
    char iso[NUMBER_TEXT_SIZE], counts[160], mesh[NUMBER_TEXT_SIZE];
    char scratch[NUMBER_TEXT_SIZE], file[NUMBER_TEXT_SIZE];
    tell_samples(job, i);
    format_counts(job->session->options, s, counts, sizeof counts);
    cli_tell(job->session,
             "dry run: iso %s: %s; memory: mesh %s, scratch %s; %s: about %s; nothing written",
             number_format_real(s->isovalue, iso), counts,
             number_format_bytes(s->output_bytes, mesh),
             number_format_bytes(s->scratch_bytes, scratch), path ? path : "as PLY",
             number_format_bytes(estimate_file(job, i), file));
}

/* ---- the report ------------------------------------------------------------------------------ */

static json_t *report_options(const mesh_job *job) {
    static const char *const device_names[] = {"auto", "cpu", "cuda"};
    static const char *const untangle_names[] = {"off", "on", "all"};
    const cli_options *options = job->session->options;
    return json_pack(
        "{s:o, s:s, s:s, s:s, s:b, s:b, s:s, s:b, s:i, s:b, s:i, s:s, s:b, s:b, s:s, "
        "s:s, s:i, s:b, s:s}",
        "isovalues", report_reals(job->isovalues, job->count), "isovalues_chosen",
        options->isovalue_count > 0 ? "given" : "auto", "inside",
        job->inside == QN_INSIDE_BELOW ? "below" : "above", "inside_chosen",
        options->inside == INSIDE_AUTO ? "auto" : "given", "closed", !options->open, "manifold",
        !options->keep_doubled, "topology", options->exact_topology ? "exact" : "discs", "simplify",
        options->simplify, "simplify_passes", (int)options->simplify_passes, "reproject",
        !options->no_reproject, "relax", (int)options->relax, "faces",
        options->triangles ? "triangles" : "quads", "normals", !options->skip_normals, "ascii",
        options->ascii, "mode", options->cms ? "cms" : "dmc", "device",
        device_names[options->device], "threads", (int)qn_context_threads(job->session->context),
        "dry_run", options->dry_run, "untangle", untangle_names[options->untangle]);
}

static json_t *report_output(const mesh_job *job, int32_t i) {
    const mesh_result *result = &job->results[i];
    char format[8];
    if (!result->path || !(result->written || job->session->options->dry_run))
        return json_null();
    json_t *object = json_object();
    int64_t bytes = result->written ? result->bytes : estimate_file(job, i);
    json_object_set_new(object, "path", report_path(result->path));
    json_object_set_new(object, "format",
                        json_string(output_format(job->session->options, format)));
    json_object_set_new(object, "bytes", bytes >= 0 ? json_integer(bytes) : json_null());
    json_object_set_new(object, "written", json_boolean(result->written));
    return object;
}

static json_t *report_result(const mesh_job *job, int32_t i) {
    const mesh_result *result = &job->results[i];
    json_t *object =
        job->adaptive ? report_solid_surface(&job->adaptive[i]) : report_surface(&job->surfaces[i]);
    json_t *failed = json_array();
    if (job->adaptive)
        json_object_set_new(object, "isovalue", report_real(job->isovalues[i]));
    for (uint32_t fault = 1; fault < FAULT_ALL; fault <<= 1)
        if (result->failed & fault)
            json_array_append_new(failed, json_string(verdict_name(fault)));
    json_object_set_new(object, "seconds_check", report_real(result->seconds_check));
    json_object_set_new(object, "seconds_write", report_real(result->seconds_write));
    json_object_set_new(object, "output", report_output(job, i));
    json_object_set_new(object, "check",
                        result->checked ? report_mesh_check(&result->check) : json_null());
    json_object_set_new(object, "failed", failed);
    return object;
}

static json_t *report_seconds(const mesh_job *job) {
    double classify = 0, emit = 0, check = 0, write = 0;
    for (int32_t i = 0; i < job->count; ++i) {
        classify += job->surfaces[i].seconds_classify;
        emit += job->surfaces[i].seconds_emit;
        check += job->results[i].seconds_check;
        write += job->results[i].seconds_write;
    }
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "read", job->seconds_read,
                     "statistics", job->seconds_statistics, "classify", classify, "emit", emit,
                     "surface", job->seconds_surface, "check", check, "write", write, "total",
                     cli_seconds() - job->session->started);
}

int mesh_job_write_report(const mesh_job *job, int exit_code) {
    const cli_options *options = job->session->options;
    json_t *report = report_start("mesh"), *surfaces = json_array();
    for (int32_t i = 0; i < job->count; ++i)
        json_array_append_new(surfaces, report_result(job, i));
    json_object_set_new(report, "input", report_volume(options->input, job->volume));
    json_object_set_new(report, "statistics",
                        job->has_statistics ? report_statistics(&job->statistics) : json_null());
    json_object_set_new(report, "options", report_options(job));
    json_object_set_new(report, "surfaces", surfaces);
    json_object_set_new(report, "seconds", report_seconds(job));
    json_object_set_new(report, "memory", report_memory(job->session));
    json_object_set_new(report, "exit_code", json_integer(exit_code));
    return report_write(report, options->report);
}
