// SPDX-License-Identifier: MIT
/* quoin view: a shaded picture of a mesh. */
#include "input.h"
#include "verbs.h"

#include <string.h>
#include <strings.h>

static int check_output(const cli_options *options) {
    if (!options->output)
        return cli_usage("where to? name the picture: quoin view %s -o picture.png",
                         options->input);
    size_t length = strlen(options->output);
    bool is_png = length > 4 && strcasecmp(options->output + length - 4, ".png") == 0;
    if (!is_png && strcmp(options->output, "-") != 0)
        return cli_usage("%s: pictures are PNG files: end the name in .png", options->output);
    return 0;
}

static void fill_view(const cli_options *options, qn_view_options *view) {
    qn_view_options_init(view);
    view->width = options->width;
    view->height = options->height;
    view->has_angles = options->has_azimuth || options->has_elevation;
    view->azimuth = options->has_azimuth ? options->azimuth : 40;
    view->elevation = options->has_elevation ? options->elevation : 25;
    view->zoom = options->zoom;
    view->edges = options->edges;
    view->flat = options->flat;
}

int verb_view(cli_session *session) {
    const cli_options *options = session->options;
    qn_mesh *mesh = NULL;
    int exit_code = check_output(options);
    if (!exit_code)
        exit_code = input_read_mesh(session, &mesh);
    if (!exit_code) {
        qn_view_options view;
        qn_error error;
        fill_view(options, &view);
        const char *path = strcmp(options->output, "-") == 0 ? "/dev/stdout" : options->output;
        exit_code = cli_fail(
            session, qn_mesh_write_picture(session->context, mesh, path, &view, &error), &error);
    }
    if (!exit_code)
        cli_tell(session, "%s: %d x %d pixels", options->output,
                 options->width ? (int)options->width : 800,
                 options->height ? (int)options->height : 600);
    qn_mesh_destroy(mesh);
    return exit_code;
}
