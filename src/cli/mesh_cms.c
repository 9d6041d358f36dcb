// SPDX-License-Identifier: MIT
/* quoin mesh --mode cms: the adaptive surfacer on a volume. */
#include "mesh_job.h"
#include "number.h"
#include "report.h"

#include <inttypes.h>
#include <stdlib.h>

/* Options that only dmc knows; said by name, so that none is dropped in silence. */
int mesh_cms_check_options(const cli_options *options) {
    const struct {
        bool given;
        const char *name;
    } rows[] = {
        {options->simplify, "--simplify"},         {options->relax > 0, "--relax"},
        {options->no_reproject, "--no-reproject"}, {options->keep_doubled, "--manifold off"},
        {options->untangle_given, "--untangle"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof *rows; ++n)
        if (rows[n].given)
            return cli_usage("%s belongs to --mode dmc; leave it out, or take that mode",
                             rows[n].name);
    if (options->device == QN_DEVICE_CUDA) {
        cli_say("not built in for CUDA: --mode cms is the processor's; take --device cpu, or leave "
                "it out");
        return qn_status_exit_code(QN_ERROR_UNSUPPORTED);
    }
    return 0;
}

int mesh_cms_extract(mesh_job *job) {
    const cli_options *options = job->session->options;
    qn_solid_surface_options surface = options->solid;
    surface.open = options->open;
    if (!options->creases_given && job->inside == QN_INSIDE_BELOW)
        surface.creases = QN_CREASES_AUTO;
    job->adaptive = calloc((size_t)job->count, sizeof *job->adaptive);
    if (!job->adaptive) {
        cli_say("not enough memory");
        return qn_status_exit_code(QN_ERROR_OUT_OF_MEMORY);
    }
    const double started = cli_seconds();
    for (int32_t i = 0; i < job->count; ++i) {
        qn_error error;
        const qn_status status =
            qn_surface_adaptive(job->session->context, job->volume, job->isovalues[i], job->inside,
                                &surface, &job->meshes[i], &job->adaptive[i], &error);
        if (status != QN_OK)
            return cli_fail(job->session, status, &error);
    }
    job->seconds_surface = cli_seconds() - started;
    return 0;
}

void mesh_cms_tell(const mesh_job *job, int32_t i) {
    const qn_solid_surface_report *s = &job->adaptive[i];
    const mesh_result *result = &job->results[i];
    char iso[NUMBER_TEXT_SIZE], triangles[NUMBER_TEXT_SIZE], vertices[NUMBER_TEXT_SIZE];
    cli_tell(job->session, "%s: iso %s: %s vertices, %s triangles, %.2f s%s",
             result->path ? result->path : "dry run", number_format_real(job->isovalues[i], iso),
             number_format_count(s->vertices, vertices),
             number_format_count(s->triangles, triangles), s->seconds_total,
             result->path ? "" : "; nothing written");
    if (s->rounded)
        cli_tell(job->session,
                 "  the volume's axes are oblique, or its coordinates large: vertices "
                 "were rounded once more when they were moved there");
    if (s->creases)
        cli_tell(
            job->session,
            "  the samples are distances: sharp edges were looked for (--creases off leaves them)");
    if (!job->session->options->verbose)
        return;
    cli_tell(job->session,
             "  leaves %" PRId64 " (finest %" PRId64 "), ambiguous faces %" PRId64
             ", cells with several loops %" PRId64 ", moved loops %" PRId64
             ", nested cells %" PRId64 ", divided leaves %" PRId64 ", crease edges %" PRId64,
             s->leaves, s->leaves_by_level[0], s->ambiguous_faces, s->multiple_cells,
             s->moved_loops, s->nested_cells, s->divided_leaves, s->crease_edges);
    cli_tell(job->session,
             "  seconds: read %.3f, sampling %.3f, octree %.3f, cms %.3f, check %.3f, write %.3f",
             job->seconds_read, s->seconds_sampling, s->seconds_octree, s->seconds_cms,
             result->seconds_check, result->seconds_write);
}
