// SPDX-License-Identifier: MIT
/* quoin convert: a mesh or a volume from one file format into another. */
#include "input.h"
#include "number.h"
#include "output.h"
#include "verbs.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static void tell_result(cli_session *session, const qn_mesh *mesh, int64_t quads_before,
                        int64_t bytes) {
    char vertices[NUMBER_TEXT_SIZE], quads[NUMBER_TEXT_SIZE], triangles[NUMBER_TEXT_SIZE];
    char size[NUMBER_TEXT_SIZE], format[8];
    qn_mesh_view view = qn_mesh_get_view(mesh);
    bool split = quads_before > 0 && output_splits_quads(output_format(session->options, format));
    cli_tell(
        session, "%s: %s vertices, %s quads, %s triangles%s%s%s", session->options->output,
        number_format_count(view.vertex_count, vertices),
        number_format_count(split ? 0 : view.quad_count, quads),
        number_format_count(view.triangle_count + (split ? 2 * view.quad_count : 0), triangles),
        bytes >= 0 ? ", " : "", bytes >= 0 ? number_format_bytes(bytes, size) : "",
        split ? " (the format holds triangles only: quads were split)" : "");
}

static int convert(cli_session *session, qn_mesh *mesh) {
    qn_error error;
    int64_t bytes, quads = qn_mesh_get_view(mesh).quad_count;
    int exit_code = 0;
    if (session->options->triangles)
        exit_code = cli_fail(session, qn_mesh_triangulate(session->context, mesh, &error), &error);
    if (!exit_code)
        exit_code = output_write_mesh(session, mesh, session->options->output, &bytes);
    if (!exit_code)
        tell_result(session, mesh, session->options->triangles ? 0 : quads, bytes);
    return exit_code;
}

static int convert_volume(cli_session *session) {
    const cli_options *options = session->options;
    qn_volume *volume = NULL;
    qn_error error;
    if (!options->output)
        return cli_usage("where to? name the output: quoin convert %s volume.npy", options->input);
    int exit_code = input_read_volume(session, &volume);
    if (!exit_code)
        exit_code = cli_fail(
            session, qn_volume_write(session->context, volume, options->output, &error), &error);
    if (!exit_code) {
        const int64_t *size = qn_volume_grid(volume)->size;
        char bytes[NUMBER_TEXT_SIZE];
        struct stat info;
        const bool known = stat(options->output, &info) == 0 && S_ISREG(info.st_mode);
        cli_tell(session, "%s: a volume of %" PRId64 " x %" PRId64 " x %" PRId64 " samples%s%s",
                 options->output, size[0], size[1], size[2], known ? ", " : "",
                 known ? number_format_bytes(info.st_size, bytes) : "");
    }
    qn_volume_destroy(volume);
    return exit_code;
}

int verb_convert(cli_session *session) {
    char ending[8] = "";
    if (session->options->output)
        input_ending(session->options->output, ending);
    if (input_is_volume(session->options) && !output_is_mesh(ending))
        return convert_volume(session);
    qn_mesh *mesh = NULL;
    int exit_code = output_check(session->options);
    if (!exit_code)
        exit_code = input_read_mesh(session, &mesh);
    if (!exit_code)
        exit_code = convert(session, mesh);
    qn_mesh_destroy(mesh);
    return exit_code;
}
