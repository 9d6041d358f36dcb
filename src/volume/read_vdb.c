// SPDX-License-Identifier: MIT
/* OpenVDB files, by way of quoin-vdb: list the grids, read one. */
#include "core/context.h"
#include "core/status.h"
#include "volume/load.h"
#include "volume/sparse.h"
#include "qni_config.h"

#include <string.h>

#if QNI_HAVE_OPENVDB
#include "volume/vdb_client.h"

static qn_status fail(const qni_source *source, const qni_vdb_process *process, qn_error *error) {
    const char *text = process->message->text;
    switch (process->result) {
    case QNI_VDB_CANCELLED:
        return qni_fail(error, QN_ERROR_CANCELLED, "reading was cancelled");
    case QNI_VDB_ABSENT:
        return qni_source_fail_as(source, QN_ERROR_UNSUPPORTED, error, "OpenVDB files: %s", text);
    case QNI_VDB_NO_MEMORY:
        return qni_source_fail_as(source, QN_ERROR_OUT_OF_MEMORY, error, "%s", text);
    case QNI_VDB_STOPPED:
        return qni_source_fail(source, error,
                               "damaged or not an OpenVDB file (the reader stopped: %s)", text);
    default:
        return qni_source_fail(source, error, "OpenVDB cannot read it: %s", text);
    }
}

static qn_status describe_all(const qni_source *source, qni_vdb_process *file, qni_vdb_grid *grids,
                              qn_grid_info *infos, int32_t count, qn_error *error) {
    for (int32_t n = 0; n < count; ++n) {
        if (qni_vdb_client_describe(file, n, grids + n) != QNI_VDB_OK)
            return fail(source, file, error);
        infos[n] = grids[n].info;
    }
    return QN_OK;
}

/* The `count` grids of an open file, in two arrays; to be freed by free_grids(). */
static qn_status list(const qni_source *source, qni_vdb_process *file, qni_vdb_grid **grids_out,
                      qn_grid_info **infos_out, int32_t count, qn_error *error) {
    *grids_out = qni_alloc(source->context, count, sizeof **grids_out);
    *infos_out = qni_alloc(source->context, count, sizeof **infos_out);
    if (!*grids_out || !*infos_out)
        return qni_fail_memory(error, "the list of grids");
    return describe_all(source, file, *grids_out, *infos_out, count, error);
}

static void free_grids(const qni_source *source, qni_vdb_grid *grids, qn_grid_info *infos,
                       int32_t count) {
    qni_free(source->context, grids, count, sizeof *grids);
    qni_free(source->context, infos, count, sizeof *infos);
}

static qn_status load_grid(const qni_source *source, qni_vdb_process *file, int32_t n,
                           const qni_vdb_grid *from, const qn_volume_read_options *options,
                           qn_volume **volume_out, qn_error *error) {
    qni_vdb_counts counts;
    qni_sparse_arrays *arrays;
    qn_sparse_grid grid = {.scalar = from->scalar, .kind = from->info.kind};
    if (qni_vdb_client_load(file, n, &counts) != QNI_VDB_OK)
        return fail(source, file, error);
    QN_TRY(qni_sparse_arrays_create(source->context, grid.scalar, counts.leaf_count,
                                    counts.tile_count, &arrays, error));
    if (qni_vdb_client_take(file, arrays) != QNI_VDB_OK) {
        qni_sparse_arrays_destroy(arrays);
        return fail(source, file, error);
    }
    grid.background = counts.background;
    memcpy(grid.index_to_world, from->index_to_world, sizeof grid.index_to_world);
    memcpy(grid.name, from->info.name, sizeof grid.name);
    return qni_sparse_arrays_load(source, arrays, &grid, "vdb", options, volume_out, error);
}

static qn_status open_file(const qni_source *source, qni_vdb_process *file,
                           qni_vdb_message *message, int32_t *count, qn_error *error) {
    *count = 0;
    if (qni_vdb_client_open(file, source->context, source->path, count, message) == QNI_VDB_OK)
        return QN_OK;
    return fail(source, file, error);
}

qn_status qni_read_vdb(qni_source *source, const qn_volume_read_options *options,
                       qn_volume **volume_out, qn_error *error) {
    qni_vdb_process file;
    qni_vdb_message message;
    qni_vdb_grid *grids = NULL;
    qn_grid_info *infos = NULL;
    int32_t count, chosen = 0;
    qn_status status = open_file(source, &file, &message, &count, error);
    if (status == QN_OK)
        status = list(source, &file, &grids, &infos, count, error);
    if (status == QN_OK)
        status = qni_choose_grid(source, infos, count, options->grid, &chosen, error);
    if (status == QN_OK)
        status = load_grid(source, &file, chosen, grids + chosen, options, volume_out, error);
    free_grids(source, grids, infos, count);
    qni_vdb_process_end(&file);
    return status;
}

qn_status qni_list_vdb(qni_source *source, qn_grid_info *infos_out, int32_t capacity,
                       int32_t *count_out, qn_error *error) {
    qni_vdb_process file;
    qni_vdb_message message;
    qni_vdb_grid *grids = NULL;
    qn_grid_info *infos = NULL;
    int32_t count;
    qn_status status = open_file(source, &file, &message, &count, error);
    if (status == QN_OK)
        status = list(source, &file, &grids, &infos, count, error);
    for (int32_t n = 0; status == QN_OK && n < count && n < capacity; ++n)
        infos_out[n] = infos[n];
    *count_out = status == QN_OK ? count : 0;
    free_grids(source, grids, infos, count);
    qni_vdb_process_end(&file);
    return status;
}

#else

static qn_status fail_absent(const qni_source *source, qn_error *error) {
    return qni_source_fail_as(
        source, QN_ERROR_UNSUPPORTED, error,
        "this build does not read OpenVDB files: install libopenvdb-dev, libboost-dev "
        "and build with -Dopenvdb=enabled");
}

qn_status qni_read_vdb(qni_source *source, const qn_volume_read_options *options,
                       qn_volume **volume_out, qn_error *error) {
    (void)options;
    (void)volume_out;
    return fail_absent(source, error);
}

qn_status qni_list_vdb(qni_source *source, qn_grid_info *infos_out, int32_t capacity,
                       int32_t *count_out, qn_error *error) {
    (void)infos_out;
    (void)capacity;
    *count_out = 0;
    return fail_absent(source, error);
}

#endif
