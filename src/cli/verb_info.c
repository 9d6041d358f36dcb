// SPDX-License-Identifier: MIT
/* quoin info: what a file holds. */
#include "info_grids.h"
#include "input.h"
#include "number.h"
#include "report.h"
#include "verbs.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROWS = 16, BAR = 40 };

/* ---- orientation ----------------------------------------------------------------------------- */

/* The world axis that an index axis runs along most, and whether it runs up (+1) or down (-1). */
static int main_axis(const qn_grid *grid, int axis, int *sign_out) {
    int best = 0;
    for (int row = 1; row < 3; ++row)
        if (fabs(grid->index_to_world[row][axis]) > fabs(grid->index_to_world[best][axis]))
            best = row;
    *sign_out = grid->index_to_world[best][axis] < 0 ? -1 : 1;
    return best;
}

static const char *opposite(char letter) {
    static const char pairs[][3] = {"RL", "LR", "AP", "PA", "SI", "IS"};
    for (int i = 0; i < 6; ++i)
        if (pairs[i][0] == letter)
            return &pairs[i][1];
    return NULL;
}

/* "RAS": where i, j and k run to; "+x +y +z" when the space has no such name. */
static const char *orientation(const qn_grid *grid, char text[16]) {
    bool named = strlen(grid->space) == 3 && opposite(grid->space[0]) && opposite(grid->space[1]) &&
                 opposite(grid->space[2]);
    size_t used = 0;
    for (int axis = 0; axis < 3; ++axis) {
        int sign, row = main_axis(grid, axis, &sign);
        if (named)
            text[used++] = sign > 0 ? grid->space[row] : opposite(grid->space[row])[0];
        else
            used += (size_t)snprintf(text + used, 16 - used, "%s%c%c", axis ? " " : "",
                                     sign > 0 ? '+' : '-', 'x' + row);
    }
    text[used] = '\0';
    return text;
}

static double determinant(const double m[4][4]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* ---- samples --------------------------------------------------------------------------------- */

/* The share of finite samples at or above a value, to the exactness of the histogram. */
static double share_above(const qn_volume_statistics *s, double value) {
    double width = (s->maximum - s->minimum) / QN_HISTOGRAM_BINS, above = 0, all = 0;
    for (int bin = 0; bin < QN_HISTOGRAM_BINS; ++bin) {
        double from = s->minimum + width * bin;
        double part = width > 0 ? (from + width - value) / width : 0;
        part = part < 0 ? 0 : part > 1 ? 1 : part;
        above += part * (double)s->histogram[bin];
        all += (double)s->histogram[bin];
    }
    return all > 0 ? above / all : 0;
}

/* Lengths on a logarithmic scale: the background of a scan outweighs all else. */
static void print_histogram(const qn_volume_statistics *s) {
    int64_t rows[ROWS] = {0}, most = 1;
    for (int bin = 0; bin < QN_HISTOGRAM_BINS; ++bin)
        rows[bin * ROWS / QN_HISTOGRAM_BINS] += s->histogram[bin];
    for (int row = 0; row < ROWS; ++row)
        most = rows[row] > most ? rows[row] : most;
    double width = (s->maximum - s->minimum) / ROWS;
    printf("histogram    (from value, bar of logarithmic length, samples)\n");
    for (int row = 0; row < ROWS; ++row) {
        char bar[BAR + 1], count[NUMBER_TEXT_SIZE];
        int length = (int)(BAR * log1p((double)rows[row]) / log1p((double)most));
        memset(bar, '#', (size_t)length);
        bar[length] = '\0';
        printf("  %10.5g  %-*s %s\n", s->minimum + width * row, BAR, bar,
               number_format_count(rows[row], count));
    }
}

static void print_header(cli_session *session, const qn_volume *volume) {
    const qn_grid *grid = qn_volume_grid(volume);
    char axes[16], samples[NUMBER_TEXT_SIZE], bytes[NUMBER_TEXT_SIZE];
    int64_t count = grid->size[0] * grid->size[1]; /* a sparse volume's box has no bound */
    if (__builtin_mul_overflow(count, grid->size[2], &count))
        count = INT64_MAX;
    const bool sparse = qn_volume_sparse_grid(volume) != NULL;
    double mirrored = determinant(grid->index_to_world);
    printf("file         %s\n", session->options->input);
    printf("format       %s\n", qn_volume_format(volume));
    printf("shape        %" PRId64 " x %" PRId64 " x %" PRId64 " = %s samples", grid->size[0],
           grid->size[1], grid->size[2], number_format_count(count, samples));
    printf(sparse ? "\n" : ", %s in memory\n",
           sparse ? "" : number_format_bytes(count * (int64_t)qn_scalar_size(grid->scalar), bytes));
    info_print_sparse(session, volume);
    printf("type         %s%s", qn_scalar_name(grid->scalar), grid->swapped ? ", swapped" : "");
    if (grid->slope != 1 || grid->intercept != 0)
        printf(", value = %.9g * stored + %.9g", grid->slope, grid->intercept);
    printf("\nspacing     ");
    for (int axis = 0; axis < 3; ++axis)
        printf(" %.6g",
               sqrt(pow(grid->index_to_world[0][axis], 2) + pow(grid->index_to_world[1][axis], 2) +
                    pow(grid->index_to_world[2][axis], 2)));
    printf(" %s\n", grid->unit);
    printf("space        %s\n", grid->space[0] ? grid->space : "not named");
    printf("orientation  i, j, k run to %s%s\n", orientation(grid, axes),
           mirrored < 0 ? " (mirrored: the mesh is still wound outward)" : "");
    for (int row = 0; row < 3; ++row)
        printf("%s %12.6g %12.6g %12.6g %12.6g\n", row ? "            " : "matrix      ",
               grid->index_to_world[row][0], grid->index_to_world[row][1],
               grid->index_to_world[row][2], grid->index_to_world[row][3]);
}

static void print_suggestions(const cli_session *session, const qn_volume_statistics *s,
                              const qn_surface_report *surfaces) {
    char iso[NUMBER_TEXT_SIZE], quads[NUMBER_TEXT_SIZE], bytes[NUMBER_TEXT_SIZE];
    printf("iso-values worth a try\n");
    for (int i = 0; i < s->suggestion_count; ++i)
        printf("  %10s  %5.1f %% of the samples above; %s quads, %s of memory%s\n",
               number_format_real(s->suggestions[i], iso), 100 * share_above(s, s->suggestions[i]),
               number_format_count(surfaces[i].quads, quads),
               number_format_bytes(surfaces[i].output_bytes + surfaces[i].scratch_bytes, bytes),
               s->suggestions[i] == s->suggested ? "  <- start here" : "");
    printf("example      quoin mesh %s --iso %s -o mesh.ply\n", session->options->input,
           number_format_real(s->suggested, iso));
}

static void print_values(const qn_volume_statistics *s) {
    char number[NUMBER_TEXT_SIZE];
    printf("range        %.9g to %.9g, mean %.6g\n", s->minimum, s->maximum, s->mean);
    printf("not finite   %s NaN", number_format_count(s->nan_count, number));
    printf(", %s infinite\n", number_format_count(s->infinite_count, number));
    if (s->minimum < s->maximum)
        print_histogram(s);
}

/* ---- volumes --------------------------------------------------------------------------------- */

/* Counts the surfaces at the suggested iso-values, without making them. */
static int count_surfaces(cli_session *session, const qn_volume *volume,
                          const qn_volume_statistics *s, qn_surface_report *surfaces) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = s->suggestions;
    options.isovalue_count = s->suggestion_count;
    options.count_only = true;
    qn_mesh *none[QN_SUGGESTION_COUNT];
    qn_error error;
    return cli_fail(session, qn_surface(session->context, volume, &options, none, surfaces, &error),
                    &error);
}

static json_t *volume_json(cli_session *session, const qn_volume *volume,
                           const qn_volume_statistics *s, const qn_surface_report *surfaces) {
    const qn_grid *grid = qn_volume_grid(volume);
    char axes[16];
    json_t *report = report_start("info"), *list = json_array();
    for (int i = 0; i < s->suggestion_count; ++i)
        json_array_append_new(list,
                              json_pack("{s:f, s:f, s:I, s:I, s:I}", "isovalue", s->suggestions[i],
                                        "share_above", share_above(s, s->suggestions[i]), "quads",
                                        (json_int_t)surfaces[i].quads, "output_bytes",
                                        (json_int_t)surfaces[i].output_bytes, "scratch_bytes",
                                        (json_int_t)surfaces[i].scratch_bytes));
    json_object_set_new(report, "kind", json_string("volume"));
    json_object_set_new(report, "input", report_volume(session->options->input, volume));
    json_t *sparse = info_sparse_json(session, volume);
    if (sparse)
        json_object_set_new(report, "sparse", sparse);
    json_object_set_new(report, "orientation", json_string(orientation(grid, axes)));
    json_object_set_new(report, "statistics", report_statistics(s));
    json_object_set_new(report, "suggestions", list);
    return report;
}

static int inform_volume(cli_session *session, const qn_volume *volume) {
    qn_volume_statistics statistics;
    qn_surface_report surfaces[QN_SUGGESTION_COUNT];
    qn_error error;
    int exit_code = cli_fail(
        session, qn_volume_get_statistics(session->context, volume, &statistics, &error), &error);
    if (!exit_code && statistics.suggestion_count > 0)
        exit_code = count_surfaces(session, volume, &statistics, surfaces);
    progress_erase(&session->progress);
    if (exit_code)
        return exit_code;
    if (session->options->json)
        return report_write(volume_json(session, volume, &statistics, surfaces), "-");
    print_header(session, volume);
    print_values(&statistics);
    if (statistics.suggestion_count > 0)
        print_suggestions(session, &statistics, surfaces);
    return cli_finish_stdout(0);
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static void find_bounds(const qn_mesh_view *view, double bounds[2][3]) {
    for (int axis = 0; axis < 3; ++axis) {
        bounds[0][axis] = (double)INFINITY;
        bounds[1][axis] = -(double)INFINITY;
    }
    for (int64_t vertex = 0; vertex < view->vertex_count; ++vertex)
        for (int axis = 0; axis < 3; ++axis) {
            double x = (double)view->positions[3 * vertex + axis];
            bounds[0][axis] = x < bounds[0][axis] ? x : bounds[0][axis];
            bounds[1][axis] = x > bounds[1][axis] ? x : bounds[1][axis];
        }
}

static int print_mesh_json(const char *path, const qn_mesh_view *view, const double bounds[2][3]) {
    json_t *report = report_start("info");
    json_object_set_new(report, "kind", json_string("mesh"));
    json_object_set_new(report, "input", json_pack("{s:o}", "path", report_path(path)));
    json_object_set_new(report, "vertex_count", json_integer(view->vertex_count));
    json_object_set_new(report, "quad_count", json_integer(view->quad_count));
    json_object_set_new(report, "triangle_count", json_integer(view->triangle_count));
    json_object_set_new(report, "normals", json_boolean(view->normals != NULL));
    json_object_set_new(report, "space", report_path(view->space ? view->space : ""));
    json_object_set_new(report, "unit", report_path(view->unit ? view->unit : ""));
    json_object_set_new(report, "bounds",
                        json_pack("[o,o]", report_reals(bounds[0], 3), report_reals(bounds[1], 3)));
    return report_write(report, "-");
}

static int inform_mesh(cli_session *session, const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    const char *path = session->options->input;
    char number[NUMBER_TEXT_SIZE];
    double bounds[2][3];
    find_bounds(&view, bounds);
    progress_erase(&session->progress);
    if (session->options->json)
        return print_mesh_json(path, &view, (const double(*)[3])bounds);
    printf("file         %s\n", path);
    printf("vertices     %s\n", number_format_count(view.vertex_count, number));
    printf("quads        %s\n", number_format_count(view.quad_count, number));
    printf("triangles    %s\n", number_format_count(view.triangle_count, number));
    printf("normals      %s\n", view.normals ? "yes" : "no");
    printf("space        %s\n", view.space && *view.space ? view.space : "not named");
    for (int axis = 0; axis < 3 && view.vertex_count > 0; ++axis)
        printf("bounds %c     %.9g to %.9g %s\n", 'x' + axis, bounds[0][axis], bounds[1][axis],
               view.unit ? view.unit : "");
    printf("more         quoin check %s\n", path);
    return cli_finish_stdout(0);
}

int verb_info(cli_session *session) {
    qn_volume *volume = NULL;
    qn_mesh *mesh = NULL;
    bool is_mesh = input_is_mesh(session->options), done = false;
    int exit_code = is_mesh ? 0 : info_list_grids(session, &done);
    if (exit_code || done)
        return exit_code;
    exit_code = is_mesh ? input_read_mesh(session, &mesh) : input_read_volume(session, &volume);
    if (!exit_code)
        exit_code = is_mesh ? inform_mesh(session, mesh) : inform_volume(session, volume);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    return exit_code;
}
