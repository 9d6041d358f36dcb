// SPDX-License-Identifier: MIT
/* From a file's grids to a sparse volume: which grid is meant, the arrays that readers fill in. */
#include "core/context.h"
#include "core/status.h"
#include "volume/load.h"
#include "volume/sparse.h"
#include "volume/volume.h"

#include <stdio.h>
#include <string.h>

/* ---- which grid ------------------------------------------------------------------------------ */

/* "name (type)" of each grid, as far as there is room. */
static const char *list_grids(const qn_grid_info *infos, int32_t count, char text[256]) {
    size_t used = 0;
    text[0] = 0;
    for (int32_t n = 0; n < count; ++n) {
        const int more = snprintf(text + used, 256 - used, "%s%.63s (%.31s)", n ? ", " : "",
                                  infos[n].name, infos[n].type);
        if (more < 0 || used + (size_t)more >= 250) {
            snprintf(text + used, 256 - used, " ...");
            break;
        }
        used += (size_t)more;
    }
    return text;
}

static qn_status fail_unreadable(const qni_source *source, const qn_grid_info *info,
                                 qn_error *error) {
    if (info->frustum)
        return qni_source_fail(source, error,
                               "grid '%s' has a frustum map, whose voxels are not alike; resample "
                               "it onto a linear transform first",
                               info->name);
    if (strncmp(info->type, "vec", 3) == 0)
        return qni_source_fail(source, error,
                               "grid '%s' holds vectors (%s); a surface needs a scalar grid",
                               info->name, info->type);
    if (strncmp(info->type, "ptdata", 6) == 0 || strncmp(info->type, "ptidx", 5) == 0)
        return qni_source_fail(source, error,
                               "grid '%s' holds points (%s); make a level set of them first",
                               info->name, info->type);
    return qni_source_fail(source, error,
                           "grid '%s' is of type %s, which is not read; float, double, int32, "
                           "int64, bool and mask grids are",
                           info->name, info->type);
}

qn_status qni_choose_grid(const qni_source *source, const qn_grid_info *infos, int32_t count,
                          const char *wanted, int32_t *chosen_out, qn_error *error) {
    char text[256];
    int32_t readable = 0, chosen = 0;
    if (count == 0)
        return qni_source_fail(source, error, "holds no grid");
    if (wanted[0]) {
        for (int32_t n = 0; n < count; ++n)
            if (strcmp(infos[n].name, wanted) == 0) {
                *chosen_out = n;
                return infos[n].readable ? QN_OK : fail_unreadable(source, infos + n, error);
            }
        return qni_source_fail_as(source, QN_ERROR_INVALID_ARGUMENT, error,
                                  "has no grid '%s'; it has: %s", wanted,
                                  list_grids(infos, count, text));
    }
    for (int32_t n = count - 1; n >= 0; --n)
        if (infos[n].readable) {
            ++readable;
            chosen = n;
        }
    if (readable == 0 && count == 1)
        return fail_unreadable(source, infos, error);
    if (readable == 0)
        return qni_source_fail(source, error, "has no scalar grid; it has: %s",
                               list_grids(infos, count, text));
    if (readable > 1)
        return qni_source_fail_as(source, QN_ERROR_INVALID_ARGUMENT, error,
                                  "has several grids; choose one by --grid NAME: %s",
                                  list_grids(infos, count, text));
    *chosen_out = chosen;
    return QN_OK;
}

/* ---- arrays ---------------------------------------------------------------------------------- */

qn_status qni_sparse_arrays_create(qn_context *context, qn_scalar scalar, int64_t leaf_count,
                                   int64_t tile_count, qni_sparse_arrays **arrays_out,
                                   qn_error *error) {
    qni_sparse_arrays *arrays = qni_alloc_zero(context, 1, sizeof *arrays);
    *arrays_out = NULL;
    if (!arrays)
        return qni_fail_memory(error, "the leaves of a sparse volume");
    arrays->context = context;
    arrays->leaf_count = leaf_count;
    arrays->tile_count = tile_count;
    arrays->value_bytes = QNI_BLOCK_SAMPLES * qn_scalar_size(scalar);
    arrays->origins = qni_alloc(context, leaf_count, sizeof *arrays->origins);
    arrays->values = qni_alloc(context, leaf_count, arrays->value_bytes);
    arrays->masks = qni_alloc(context, leaf_count, sizeof *arrays->masks);
    arrays->tiles = qni_alloc(context, tile_count, sizeof *arrays->tiles);
    if (!arrays->origins || !arrays->values || !arrays->masks || !arrays->tiles) {
        qni_sparse_arrays_destroy(arrays);
        return qni_fail_memory(error, "the leaves of a sparse volume");
    }
    *arrays_out = arrays;
    return QN_OK;
}

void qni_sparse_arrays_destroy(qni_sparse_arrays *arrays) {
    if (!arrays)
        return;
    qn_context *context = arrays->context;
    qni_free(context, arrays->origins, arrays->leaf_count, sizeof *arrays->origins);
    qni_free(context, arrays->values, arrays->leaf_count, arrays->value_bytes);
    qni_free(context, arrays->masks, arrays->leaf_count, sizeof *arrays->masks);
    qni_free(context, arrays->tiles, arrays->tile_count, sizeof *arrays->tiles);
    qni_free(context, arrays, 1, sizeof *arrays);
}

static void release_arrays(void *user, const void *values) {
    (void)values;
    qni_sparse_arrays_destroy(user);
}

qn_status qni_sparse_arrays_load(const qni_source *source, qni_sparse_arrays *arrays,
                                 qn_sparse_grid *grid, const char *format,
                                 const qn_volume_read_options *options, qn_volume **volume_out,
                                 qn_error *error) {
    grid->leaf_count = arrays->leaf_count;
    grid->tile_count = arrays->tile_count;
    grid->origins = (const int32_t(*)[3])arrays->origins;
    grid->values = arrays->values;
    grid->masks = (const uint64_t(*)[8])arrays->masks;
    grid->tiles = arrays->tiles;
    qn_error reason;
    qn_status status = qni_load_overrides(source, options, grid->index_to_world, error);
    if (status == QN_OK) {
        status = qn_volume_create_sparse(arrays->context, grid, release_arrays, arrays, volume_out,
                                         &reason);
        if (status == QN_ERROR_INVALID_ARGUMENT) /* it is the file that says so */
            status = qni_source_fail(source, error, "%s", reason.message);
        else if (status != QN_OK && error)
            *error = reason;
    }
    if (status != QN_OK) {
        qni_sparse_arrays_destroy(arrays);
        return status;
    }
    strncpy((*volume_out)->format, format, sizeof(*volume_out)->format - 1);
    return QN_OK;
}
