// SPDX-License-Identifier: MIT
/* Grids of OpenVDB and NanoVDB files as lines and as JSON. */
#include "info_grids.h"
#include "input.h"
#include "number.h"
#include "report.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { MOST_GRIDS = 256 };

static const char *kind_name(qn_sparse_class kind) {
    return kind == QN_SPARSE_LEVEL_SET ? "level set" : kind == QN_SPARSE_FOG ? "fog" : "unknown";
}

void info_print_sparse(cli_session *session, const qn_volume *volume) {
    const qn_sparse_grid *grid = qn_volume_sparse_grid(volume);
    char leaves[NUMBER_TEXT_SIZE], tiles[NUMBER_TEXT_SIZE], active[NUMBER_TEXT_SIZE];
    char bytes[NUMBER_TEXT_SIZE], filled[NUMBER_TEXT_SIZE];
    qn_sparse_info info;
    if (!grid || qn_volume_sparse_info(session->context, volume, &info, NULL) != QN_OK)
        return;
    printf("grid         %s, %s\n", grid->name[0] ? grid->name : "without a name",
           kind_name(grid->kind));
    printf("box          %" PRId64 " %" PRId64 " %" PRId64 " to %" PRId64 " %" PRId64 " %" PRId64
           " (of leaves and tiles)\n",
           info.low[0], info.low[1], info.low[2], info.high[0], info.high[1], info.high[2]);
    printf(
        "sparse       %s leaves of 8^3 samples (%s), %s tiles, background %.9g\n",
        number_format_count(info.leaf_count, leaves),
        number_format_bytes(info.leaf_count * 512 * (int64_t)qn_scalar_size(grid->scalar), bytes),
        number_format_count(info.tile_count, tiles), grid->background);
    printf("active       %s samples\n", number_format_count(info.active_count, active));
    if (info.filled_blocks)
        printf("filled       %s blocks of 8^3 inside the band, which no leaf or tile holds\n",
               number_format_count(info.filled_blocks, filled));
}

json_t *info_sparse_json(cli_session *session, const qn_volume *volume) {
    const qn_sparse_grid *grid = qn_volume_sparse_grid(volume);
    qn_sparse_info info;
    if (!grid || qn_volume_sparse_info(session->context, volume, &info, NULL) != QN_OK)
        return NULL;
    json_t *object = json_object();
    json_object_set_new(object, "name", report_path(grid->name));
    json_object_set_new(object, "class", json_string(kind_name(grid->kind)));
    json_object_set_new(object, "type", json_string(qn_scalar_name(grid->scalar)));
    json_object_set_new(object, "low",
                        json_pack("[I,I,I]", (json_int_t)info.low[0], (json_int_t)info.low[1],
                                  (json_int_t)info.low[2]));
    json_object_set_new(object, "high",
                        json_pack("[I,I,I]", (json_int_t)info.high[0], (json_int_t)info.high[1],
                                  (json_int_t)info.high[2]));
    json_object_set_new(object, "leaf_count", json_integer(info.leaf_count));
    json_object_set_new(object, "tile_count", json_integer(info.tile_count));
    json_object_set_new(object, "active_count", json_integer(info.active_count));
    json_object_set_new(object, "filled_blocks", json_integer(info.filled_blocks));
    json_object_set_new(object, "background", report_real(grid->background));
    return object;
}

/* ---- the list -------------------------------------------------------------------------------- */

/* What a grid holds, read for this; NULL for one that cannot be read, after having said why. */
static json_t *describe(cli_session *session, const qn_grid_info *info, bool print) {
    qn_volume_read_options read = session->options->read;
    qn_volume *volume;
    qn_error error;
    memcpy(read.format, session->options->from, sizeof read.format);
    memcpy(read.grid, info->name, sizeof read.grid);
    if (print)
        printf("grid         %s: %s%s, %s", info->name, info->type,
               info->half ? " saved as half" : "", kind_name(info->kind));
    if (!info->readable) {
        if (print)
            printf("; %s\n", info->frustum ? "its frustum map is not read" : "not read");
        return NULL;
    }
    if (qn_volume_read(session->context, session->options->input, &read, &volume, &error) !=
        QN_OK) {
        if (print)
            printf("; %s\n", error.message);
        return NULL;
    }
    json_t *object = info_sparse_json(session, volume);
    if (print) {
        const int64_t *size = qn_volume_grid(volume)->size;
        printf(", %" PRId64 " x %" PRId64 " x %" PRId64 ", %" JSON_INTEGER_FORMAT
               " leaves, %" JSON_INTEGER_FORMAT " tiles, background %.9g\n",
               size[0], size[1], size[2], json_integer_value(json_object_get(object, "leaf_count")),
               json_integer_value(json_object_get(object, "tile_count")),
               qn_volume_sparse_grid(volume)->background);
    }
    qn_volume_destroy(volume);
    return object;
}

static int print_all(cli_session *session, const qn_grid_info *infos, int32_t count) {
    const bool json = session->options->json;
    json_t *list = json_array();
    progress_erase(&session->progress);
    if (!json)
        printf("file         %s\n", session->options->input);
    for (int32_t n = 0; n < count; ++n) {
        json_t *object = describe(session, infos + n, !json);
        if (!object)
            object = json_object();
        json_object_set_new(object, "name", report_path(infos[n].name));
        json_object_set_new(object, "stored_type", report_path(infos[n].type));
        json_object_set_new(object, "readable", json_boolean(infos[n].readable));
        json_array_append_new(list, object);
    }
    if (json) {
        json_t *report = report_start("info");
        json_object_set_new(report, "kind", json_string("grids"));
        json_object_set_new(report, "input",
                            json_pack("{s:o}", "path", report_path(session->options->input)));
        json_object_set_new(report, "grids", list);
        return report_write(report, "-");
    }
    json_decref(list);
    printf("more         quoin info %s --grid NAME\n", session->options->input);
    return cli_finish_stdout(0);
}

int info_list_grids(cli_session *session, bool *done_out) {
    const cli_options *options = session->options;
    qn_grid_info infos[MOST_GRIDS];
    int32_t count = 0, readable = 0;
    qn_error error;
    char ending[8];
    input_ending(options->input, ending);
    const char *format = options->from[0] ? options->from : ending;
    *done_out = false;
    if ((strcmp(format, "vdb") != 0 && strcmp(format, "nvdb") != 0) || options->read.grid[0] ||
        strcmp(options->input, "-") == 0)
        return 0;
    const int exit_code = cli_fail(
        session,
        qn_volume_list_grids(session->context, options->input, infos, MOST_GRIDS, &count, &error),
        &error);
    count = count < MOST_GRIDS ? count : MOST_GRIDS;
    for (int32_t n = 0; n < count; ++n)
        readable += infos[n].readable;
    if (exit_code || (count == 1 && readable == 1) || count == 0)
        return exit_code;
    *done_out = true;
    return print_all(session, infos, count);
}
