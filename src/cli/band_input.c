// SPDX-License-Identifier: MIT
/* Narrow bands of what a file holds. */
#include "band_input.h"
#include "input.h"
#include "number.h"

#include <string.h>

bool band_is_asked_for(const cli_options *options) {
    return options->dmc || options->band_offset != 0 || options->shell > 0;
}

static qn_band_options band_options(const cli_options *options) {
    qn_band_options band;
    qn_band_options_init(&band);
    band.voxel = options->voxel;
    band.dim = (int32_t)(options->cells         ? options->cells
                         : options->solid.depth ? (int64_t)1 << options->solid.depth
                                                : 0);
    band.half_width = options->band_width;
    band.sign = options->sign;
    band.offset = options->band_offset;
    band.shell = options->shell;
    band.has_origin = options->read.has_origin;
    memcpy(band.origin, options->read.origin, sizeof band.origin);
    return band;
}

static json_t *band_report(const qn_band_report *band, bool of_mesh) {
    const struct {
        const char *key;
        int64_t value;
    } rows[] = {
        {"leaf_count", band->leaf_count},
        {"tile_count", band->tile_count},
        {"active_count", band->active_count},
        {"visited_nodes", band->visited_nodes},
        {"triangles", band->triangles},
        {"lines", band->lines},
        {"disagreeing_lines", band->disagreeing_lines},
        {"torn_pairs", band->torn_pairs},
        {"holes", band->holes},
        {"turned_triangles", band->turned_triangles},
    };
    json_t *object = json_object();
    json_object_set_new(object, "voxel", report_real(band->voxel));
    json_object_set_new(object, "background", report_real(band->background));
    for (size_t n = 0; n < sizeof rows / sizeof *rows; ++n)
        json_object_set_new(object, rows[n].key, json_integer(rows[n].value));
    const char *sign = band->sign == QN_MESH_SIGN_PARITY ? "parity" : "winding";
    json_object_set_new(object, "sign", of_mesh ? json_string(sign) : json_null());
    json_object_set_new(object, "seconds_tree", report_real(band->seconds_tree));
    json_object_set_new(object, "seconds_lines", report_real(band->seconds_lines));
    json_object_set_new(object, "seconds_discovery", report_real(band->seconds_discovery));
    json_object_set_new(object, "seconds_values", report_real(band->seconds_values));
    json_object_set_new(object, "seconds_total", report_real(band->seconds_total));
    return object;
}

static void tell_holes(cli_session *session, const qn_band_report *band) {
    char lines[NUMBER_TEXT_SIZE], holes[NUMBER_TEXT_SIZE], turned[NUMBER_TEXT_SIZE];
    if (band->disagreeing_lines == 0 && band->torn_pairs == 0)
        return;
    cli_tell(session,
             "%s: not closed (%s lattice lines end inside): %s holes closed by sheets, %s "
             "faces turned",
             session->options->input, number_format_count(band->disagreeing_lines, lines),
             number_format_count(band->holes, holes),
             number_format_count(band->turned_triangles, turned));
}

static int band_of_mesh(cli_session *session, band_input *input) {
    const qn_band_options options = band_options(session->options);
    const double started = cli_seconds();
    qn_mesh *mesh = NULL;
    qn_error error;
    int exit_code = input_read_mesh(session, &mesh);
    const double read = cli_seconds();
    input->seconds_read = read - started;
    if (!exit_code)
        exit_code = cli_fail(session,
                             qn_volume_from_mesh(session->context, mesh, &options, &input->volume,
                                                 &input->band, &error),
                             &error);
    qn_mesh_destroy(mesh);
    input->seconds_band = cli_seconds() - read;
    if (exit_code)
        return exit_code;
    tell_holes(session, &input->band);
    input->report = band_report(&input->band, true);
    return 0;
}

int band_of_solid(cli_session *session, const qn_solid *solid, band_input *input) {
    const qn_band_options options = band_options(session->options);
    const double started = cli_seconds();
    qn_error error;
    const int exit_code = cli_fail(session,
                                   qn_volume_from_solid(session->context, solid, &options,
                                                        &input->volume, &input->band, &error),
                                   &error);
    input->seconds_band = cli_seconds() - started;
    input->report = exit_code ? NULL : band_report(&input->band, false);
    return exit_code;
}

static bool is_solid_file(const cli_options *options) {
    char ending[8];
    input_ending(options->input, ending);
    return strcmp(ending, "csg") == 0 || strcmp(ending, "vm") == 0;
}

static int band_of_solid_file(cli_session *session, band_input *input) {
    const double started = cli_seconds();
    qn_solid *solid = NULL;
    qn_solid_read_options read;
    qn_solid_read_options_init(&read);
    qn_error error;
    int exit_code = cli_fail(
        session, qn_solid_read(session->context, session->options->input, &read, &solid, &error),
        &error);
    input->seconds_read = cli_seconds() - started;
    if (!exit_code)
        exit_code = band_of_solid(session, solid, input);
    qn_solid_destroy(solid);
    return exit_code;
}

int band_read(cli_session *session, band_input *input) {
    memset(input, 0, sizeof *input);
    return is_solid_file(session->options) ? band_of_solid_file(session, input)
                                           : band_of_mesh(session, input);
}

void band_free(band_input *input) {
    json_decref(input->report);
    qn_volume_destroy(input->volume);
    memset(input, 0, sizeof *input);
}
