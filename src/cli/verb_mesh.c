// SPDX-License-Identifier: MIT
/* quoin mesh: read, choose, extract, check, write, report. */
#include "verbs.h"
#include "input.h"
#include "mesh_job.h"
#include "number.h"
#include "output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int fail_memory(void) {
    cli_say("not enough memory");
    return qn_status_exit_code(QN_ERROR_OUT_OF_MEMORY);
}

static int need_statistics(mesh_job *job) {
    if (job->has_statistics)
        return 0;
    double started = cli_seconds();
    qn_error error;
    int exit_code = cli_fail(
        job->session,
        qn_volume_get_statistics(job->session->context, job->volume, &job->statistics, &error),
        &error);
    job->has_statistics = exit_code == 0;
    job->seconds_statistics = cli_seconds() - started;
    return exit_code;
}

static qn_sparse_class kind_of(const mesh_job *job) {
    const qn_sparse_grid *sparse = qn_volume_sparse_grid(job->volume);
    return sparse ? sparse->kind : QN_SPARSE_UNKNOWN;
}

/* A fog has no value that is its surface: say one that may do. */
static int want_isovalue(mesh_job *job) {
    char number[NUMBER_TEXT_SIZE];
    int exit_code = need_statistics(job);
    if (exit_code)
        return exit_code;
    const bool has_one = job->statistics.suggestion_count > 0;
    return cli_usage("%s: a fog volume has no surface of its own: state the density, for example "
                     "--iso %s (see quoin info)",
                     job->session->options->input,
                     has_one ? number_format_real(job->statistics.suggested, number) : "0.5");
}

/* The iso-values of the command line, or the one that the statistics suggest. */
static int choose_isovalues(mesh_job *job) {
    const cli_options *options = job->session->options;
    job->count = options->isovalue_count > 0 ? options->isovalue_count : 1;
    job->isovalues = calloc((size_t)job->count, sizeof *job->isovalues);
    job->meshes = calloc((size_t)job->count, sizeof *job->meshes);
    job->surfaces = calloc((size_t)job->count, sizeof *job->surfaces);
    job->results = calloc((size_t)job->count, sizeof *job->results);
    if (!job->isovalues || !job->meshes || !job->surfaces || !job->results)
        return fail_memory();
    if (options->isovalue_count > 0) {
        memcpy(job->isovalues, options->isovalues, sizeof *job->isovalues * (size_t)job->count);
        return 0;
    }
    if (kind_of(job) == QN_SPARSE_LEVEL_SET)
        return 0;
    if (kind_of(job) == QN_SPARSE_FOG)
        return want_isovalue(job);
    int exit_code = need_statistics(job);
    if (exit_code)
        return exit_code;
    if (job->statistics.suggestion_count == 0) {
        mesh_job_say_empty(job, (double)NAN);
        return CLI_EMPTY;
    }
    char number[NUMBER_TEXT_SIZE];
    job->isovalues[0] = job->statistics.suggested;
    cli_tell(job->session, "iso-value %s chosen by the histogram (--iso takes another one)",
             number_format_real(job->isovalues[0], number));
    return 0;
}

static bool looks_like_distances(const mesh_job *job) {
    const qn_volume_statistics *statistics = &job->statistics;
    return statistics->suggestion_count > 0 && statistics->suggested == 0 &&
           statistics->minimum < 0 && statistics->maximum > 0;
}

/* Only volumes of floating-point samples can be taken for signed distances. */
static int choose_inside(mesh_job *job) {
    const cli_options *options = job->session->options;
    qn_scalar scalar = qn_volume_grid(job->volume)->scalar;
    job->inside = options->inside == INSIDE_BELOW ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
    if (options->inside == INSIDE_AUTO && kind_of(job) == QN_SPARSE_LEVEL_SET) {
        job->inside = QN_INSIDE_BELOW;
    } else if (options->inside == INSIDE_AUTO && kind_of(job) != QN_SPARSE_FOG &&
               (scalar == QN_F32 || scalar == QN_F64)) {
        int exit_code = need_statistics(job);
        if (exit_code)
            return exit_code;
        if (looks_like_distances(job))
            job->inside = QN_INSIDE_BELOW;
    }
    bool below = job->inside == QN_INSIDE_BELOW;
    bool told_inside = options->inside == INSIDE_AUTO;
    bool told_closed = !options->closed_given && !qn_volume_sparse_grid(job->volume);
    if (told_inside || told_closed)
        cli_tell(job->session, "%s%s%s%s",
                 told_inside ? below ? "solid is where the value is below the iso-value, as in "
                                       "signed distances (--inside above turns it round)"
                                     : "solid is where the value is at or above the iso-value "
                                       "(--inside below turns it round)"
                             : "",
                 told_inside && told_closed ? "; " : "",
                 told_closed ? "closed at the volume's border (--closed off leaves it open)" : "",
                 "");
    return 0;
}

static int name_outputs(mesh_job *job) {
    const cli_options *options = job->session->options;
    for (int32_t i = 0; options->output && i < job->count; ++i) {
        job->results[i].path = output_name(options->output, job->isovalues[i]);
        if (!job->results[i].path)
            return fail_memory();
    }
    return 0;
}

static int extract(mesh_job *job) {
    const cli_options *options = job->session->options;
    if (options->cms)
        return mesh_cms_extract(job);
    qn_surface_options surface;
    qn_surface_options_init(&surface);
    surface.isovalues = job->isovalues;
    surface.isovalue_count = job->count;
    surface.inside = job->inside;
    surface.open = options->open;
    surface.keep_doubled = options->keep_doubled;
    surface.device = options->device;
    surface.topology = options->exact_topology ? QN_TOPOLOGY_EXACT : QN_TOPOLOGY_DISCS;
    surface.triangles = options->triangles;
    surface.skip_normals = options->skip_normals;
    surface.simplify = options->simplify;
    surface.simplify_passes = options->simplify_passes;
    surface.no_reproject = options->no_reproject;
    surface.relax = options->relax;
    surface.untangle = options->untangle;
    surface.count_only = options->dry_run;
    double started = cli_seconds();
    qn_error error;
    qn_status status = qn_surface(job->session->context, job->volume, &surface, job->meshes,
                                  job->surfaces, &error);
    job->seconds_surface = cli_seconds() - started;
    return cli_fail(job->session, status, &error);
}

/* The mesh's faults that make this run fail; open surfaces are no fault when asked for. */
static uint32_t faults_that_count(const cli_options *options) {
    if (options->fail_on_given)
        return options->fail_on;
    if (!options->check)
        return 0;
    uint32_t faults = FAULT_ORIENTATION | FAULT_NONFINITE;
    if (!options->open)
        faults |= FAULT_OPEN | (options->keep_doubled ? 0 : FAULT_NONMANIFOLD);
    return faults;
}

static int check_one(mesh_job *job, int32_t i) {
    const cli_options *options = job->session->options;
    mesh_result *result = &job->results[i];
    if (!options->check && !options->report && !options->fail_on_given)
        return 0;
    double started = cli_seconds();
    qn_error error;
    int exit_code = cli_fail(
        job->session,
        qn_mesh_check(job->session->context, job->meshes[i], NULL, &result->check, &error), &error);
    if (exit_code)
        return exit_code;
    result->checked = true;
    result->failed = verdict_faults(&result->check) & faults_that_count(options);
    result->seconds_check = cli_seconds() - started;
    return 0;
}

static int write_one(mesh_job *job, int32_t i) {
    mesh_result *result = &job->results[i];
    double started = cli_seconds();
    int exit_code = output_write_mesh(job->session, job->meshes[i], result->path, &result->bytes);
    result->seconds_write = cli_seconds() - started;
    result->written = exit_code == 0;
    return exit_code;
}

/* Check and write one iso-value's mesh, and let it go. */
static int finish_one(mesh_job *job, int32_t i) {
    int exit_code = check_one(job, i);
    if (!exit_code)
        exit_code = write_one(job, i);
    qn_mesh_destroy(job->meshes[i]);
    job->meshes[i] = NULL;
    if (exit_code)
        return exit_code;
    mesh_job_tell_result(job, i);
    return 0;
}

/* All samples lie on the solid's side: then there is no surface but the volume's own border. */
static int misses_the_data(mesh_job *job, int32_t i, bool *misses_out) {
    const int64_t *size = qn_volume_grid(job->volume)->size;
    int64_t border = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    bool suspect = job->surfaces[i].quads == border && !job->session->options->open &&
                   !qn_volume_sparse_grid(job->volume);
    *misses_out = job->surfaces[i].quads == 0;
    if (job->adaptive) { /* caps are few triangles here: a mesh of caps alone looks like any other
                          */
        suspect = !job->session->options->open;
        *misses_out = job->adaptive[i].triangles == 0;
    }
    if (!suspect && !*misses_out)
        return 0;
    int exit_code = need_statistics(job); /* only now: they cost a pass over the data */
    if (suspect && !exit_code)
        *misses_out = !(job->statistics.minimum < job->isovalues[i] &&
                        job->isovalues[i] <= job->statistics.maximum);
    return exit_code;
}

/* All iso-values. An empty surface or a failed check is remembered; the others are still written.
 */
static int finish_all(mesh_job *job) {
    int worst = 0;
    for (int32_t i = 0; i < job->count; ++i) {
        int exit_code = cli_interrupted(job->session);
        if (exit_code)
            return exit_code;
        bool misses;
        if ((exit_code = misses_the_data(job, i, &misses)))
            return exit_code;
        if (misses) {
            mesh_job_say_empty(job, job->isovalues[i]);
            worst = CLI_EMPTY;
        } else if (job->session->options->dry_run) {
            mesh_job_tell_plan(job, i);
        } else {
            if ((exit_code = finish_one(job, i)))
                return exit_code;
            if (job->results[i].failed && worst == 0)
                worst = CLI_QUALITY;
        }
    }
    return worst;
}

static int run(mesh_job *job) {
    const cli_options *options = job->session->options;
    double started = cli_seconds();
    int exit_code = output_check(options);
    if (!exit_code && options->cms)
        exit_code = mesh_cms_check_options(options);
    if (!exit_code)
        exit_code = input_read_volume(job->session, &job->volume);
    job->seconds_read = cli_seconds() - started;
    if (!exit_code)
        exit_code = choose_isovalues(job);
    if (!exit_code)
        exit_code = choose_inside(job);
    if (!exit_code)
        exit_code = name_outputs(job);
    if (!exit_code)
        exit_code = extract(job);
    if (exit_code)
        return exit_code;
    exit_code = finish_all(job);
    bool worth_a_report = exit_code == 0 || exit_code == CLI_EMPTY || exit_code == CLI_QUALITY;
    if (options->report && worth_a_report) {
        int report_code = mesh_job_write_report(job, exit_code);
        return report_code ? report_code : exit_code;
    }
    return exit_code;
}

static void release(mesh_job *job) {
    for (int32_t i = 0; i < job->count; ++i) {
        if (job->meshes)
            qn_mesh_destroy(job->meshes[i]);
        if (job->results)
            free(job->results[i].path);
    }
    free(job->isovalues);
    free(job->meshes);
    free(job->surfaces);
    free(job->adaptive);
    free(job->results);
    qn_volume_destroy(job->volume);
}

int verb_mesh(cli_session *session) {
    mesh_job job;
    memset(&job, 0, sizeof job);
    job.session = session;
    if (input_is_mesh(session->options))
        return cli_usage(
            "%s: that is a mesh already; 'quoin mesh' wants a volume, 'quoin remesh' a mesh",
            session->options->input);
    int exit_code = run(&job);
    release(&job);
    return exit_code;
}
