// SPDX-License-Identifier: MIT
/* quoin remesh: read a polygon model, good or broken, and make its surface anew: closed,
 * 2-manifold, free of self-intersections, sharp edges kept. */
#include "input.h"
#include "number.h"
#include "output.h"
#include "solid_job.h"
#include "verbs.h"

#include <math.h>

static const char *sign_name(qn_mesh_sign sign) {
    return sign == QN_MESH_SIGN_PARITY ? "parity" : "winding";
}

static json_t *model_report(const qn_solid_mesh_report *model) {
    json_t *object = json_object();
    const struct {
        const char *key;
        int64_t value;
    } rows[] = {
        {"triangles", model->triangles},
        {"dropped_triangles", model->dropped_triangles},
        {"joined_vertices", model->joined_vertices},
        {"rim_edges", model->rim_edges},
        {"odd_edges", model->odd_edges},
        {"turned_triangles", model->turned_triangles},
        {"holes", model->holes},
        {"cap_triangles", model->cap_triangles},
        {"lines", model->lines},
        {"disagreeing_lines", model->disagreeing_lines},
    };
    for (size_t n = 0; n < sizeof rows / sizeof *rows; ++n)
        json_object_set_new(object, rows[n].key, json_integer(rows[n].value));
    json_object_set_new(object, "closed", json_boolean(model->closed));
    json_object_set_new(object, "sign", json_string(sign_name(model->used)));
    return object;
}

static void tell_model(const solid_job *job, const qn_solid_mesh_report *model) {
    char holes[NUMBER_TEXT_SIZE], lines[NUMBER_TEXT_SIZE], all[NUMBER_TEXT_SIZE];
    const char *path = job->session->options->input;
    number_format_count(model->disagreeing_lines, lines);
    number_format_count(model->lines, all);
    if (!model->closed)
        cli_tell(job->session, "%s: not closed, %s holes; inside by %s", path,
                 number_format_count(model->holes, holes), sign_name(model->used));
    else if (model->used == QN_MESH_SIGN_PARITY)
        cli_tell(job->session, "%s: faces disagree which side is out; inside by parity", path);
    if (model->disagreeing_lines)
        cli_tell(job->session,
                 "%s: on %s of %s lines the surface is not simply where the faces are (holes, or "
                 "faces within)",
                 path, lines, all);
}

static int read_model(solid_job *job) {
    const double started = cli_seconds();
    qn_mesh *mesh = NULL;
    int exit_code = input_read_mesh(job->session, &mesh);
    if (exit_code)
        return exit_code;
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    options.sign = job->session->options->sign;
    qn_solid_mesh_report model;
    qn_error error;
    exit_code = cli_fail(
        job->session,
        qn_solid_from_mesh(job->session->context, mesh, &options, &job->solid, &model, &error),
        &error);
    qn_mesh_destroy(mesh);
    job->seconds_read = cli_seconds() - started;
    if (exit_code)
        return exit_code;
    tell_model(job, &model);
    job->input = model_report(&model);
    return 0;
}

/* Cells of a given size: a depth has so many along the longest side of a box, so the box is made
 * that long, round the model. */
static int set_cell(solid_job *job) {
    const cli_options *options = job->session->options;
    qn_solid_surface_options *surface = &job->surface_options;
    const double longest = solid_job_longest_side(job);
    double low[3], high[3];
    qn_solid_get_box(job->solid, low, high);
    if (options->cells == 0 && !(options->voxel > 0) && !job->band.volume)
        return 0;
    const double cell = job->band.volume ? job->band.band.voxel
                        : options->cells ? longest / (double)options->cells
                                         : options->voxel;
    const int32_t depth = qn_depth_of_cell(cell, longest);
    if (depth > QN_MAX_DEPTH) {
        cli_say(
            "--voxel %g: that is more than %.0f cells along the longest side (%g): take a larger "
            "one",
            cell, qn_depth_cells(QN_MAX_DEPTH), longest);
        return CLI_USAGE;
    }
    surface->depth = depth;
    const double grow = 0.5 * (cell * qn_depth_cells(depth) - longest);
    surface->has_box = true;
    for (int axis = 0; axis < 3; ++axis) {
        const bool is_longest = high[axis] - low[axis] >= longest;
        const double margin = is_longest ? grow : 0.01 * cell;
        surface->low[axis] = low[axis] - margin;
        surface->high[axis] = high[axis] + margin;
    }
    return 0;
}

/* --mode dmc, --offset and --shell go by way of the model's distances. */
static int remesh_band(solid_job *job) {
    int exit_code = band_read(job->session, &job->band);
    if (!exit_code && job->session->options->dmc)
        return solid_job_run_dmc(job);
    if (!exit_code)
        exit_code = solid_job_take_band(job);
    if (!exit_code)
        exit_code = set_cell(job);
    return exit_code ? exit_code : solid_job_run(job);
}

int verb_remesh(cli_session *session) {
    solid_job job;
    solid_job_start(&job, session, "remesh");
    int exit_code = output_check(session->options);
    if (!exit_code && band_is_asked_for(session->options))
        exit_code = remesh_band(&job);
    else {
        if (!exit_code)
            exit_code = read_model(&job);
        if (!exit_code)
            exit_code = set_cell(&job);
        if (!exit_code)
            exit_code = solid_job_run(&job);
    }
    solid_job_end(&job);
    return exit_code;
}
