// SPDX-License-Identifier: MIT
/* Values of the leaves, and the volume made of them. */
#include "band/band.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <string.h>

enum { BLOCK = 4 };

typedef struct fill_job {
    qni_band *band;
    qn_status failure;
} fill_job;

static void fill_block(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    fill_job *job = pointer;
    qni_band *band = job->band;
    for (int64_t n = begin; n < end; ++n) {
        const qn_status status = band->source->fill(band->source->user, &band->leaves[n],
                                                    band->values + QNI_BAND_SAMPLES * n,
                                                    band->masks + QNI_BAND_WORDS * n);
        if (status != QN_OK)
            __atomic_store_n(&job->failure, status, __ATOMIC_RELAXED);
    }
}

static int64_t count_active(const uint64_t mask[QNI_BAND_WORDS]) {
    int64_t count = 0;
    for (int z = 0; z < QNI_BAND_WORDS; ++z)
        count += __builtin_popcountll(mask[z]);
    return count;
}

/* Leaves without a sample in the band hold one value; the others move up. */
static qn_status drop_plain_leaves(qni_band *band) {
    int64_t kept = 0;
    for (int64_t n = 0; n < band->leaf_count; ++n) {
        const int64_t active = count_active(band->masks + QNI_BAND_WORDS * n);
        band->active_count += active;
        if (active == 0) {
            if (band->values[QNI_BAND_SAMPLES * n] < 0)
                QN_TRY(qni_band_add_tile(band, band->leaves[n].origin, QNI_BAND_LEAF));
            continue;
        }
        if (kept < n) {
            band->leaves[kept] = band->leaves[n];
            memcpy(band->values + QNI_BAND_SAMPLES * kept, band->values + QNI_BAND_SAMPLES * n,
                   QNI_BAND_SAMPLES * sizeof *band->values);
            memcpy(band->masks + QNI_BAND_WORDS * kept, band->masks + QNI_BAND_WORDS * n,
                   QNI_BAND_WORDS * sizeof *band->masks);
        }
        ++kept;
    }
    band->leaf_count = kept;
    return QN_OK;
}

static qn_status fill_leaves(qni_band *band) {
    qn_context *context = band->work.context;
    const int64_t count = band->leaf_room;
    band->values = qni_alloc(context, count, QNI_BAND_SAMPLES * sizeof *band->values);
    band->masks = qni_alloc(context, count, QNI_BAND_WORDS * sizeof *band->masks);
    if (!band->values || !band->masks)
        return qni_fail_memory(band->work.error, "the values of a narrow band");
    const qni_check_span whole = {0, 1};
    fill_job job = {band, QN_OK};
    QN_TRY(qni_check_blocks(&band->work, count, BLOCK, whole, fill_block, &job));
    if (job.failure != QN_OK)
        return qni_fail(band->work.error, job.failure, "the solid stopped the work");
    return drop_plain_leaves(band);
}

qn_status qni_band_run(qni_band *band, const qni_band_source *source, qn_band_report *report) {
    const double started = qni_seconds();
    band->source = source;
    QN_TRY(qni_band_discover(band));
    const double discovered = qni_seconds();
    QN_TRY(fill_leaves(band));
    report->seconds_discovery = discovered - started;
    report->seconds_values = qni_seconds() - discovered;
    report->voxel = band->lattice.voxel;
    report->background = band->background;
    report->leaf_count = band->leaf_count;
    report->tile_count = band->tile_count;
    report->active_count = band->active_count;
    report->visited_nodes = band->visited_nodes;
    return QN_OK;
}

void qni_band_clear(qni_band *band) {
    qn_context *context = band->work.context;
    qni_free(context, band->tiles, band->tile_room, sizeof *band->tiles);
    qni_free(context, band->masks, band->leaf_room, QNI_BAND_WORDS * sizeof *band->masks);
    qni_free(context, band->values, band->leaf_room, QNI_BAND_SAMPLES * sizeof *band->values);
    qni_free(context, band->leaves, band->leaf_room, sizeof *band->leaves);
    band->tiles = NULL;
    band->masks = NULL;
    band->values = NULL;
    band->leaves = NULL;
    band->leaf_count = band->leaf_room = band->tile_count = band->tile_room = 0;
    band->visited_nodes = band->active_count = 0;
}

/* ---- the volume --------------------------------------------------------------------------------
 */

/* What a volume made here owns. */
typedef struct owned_arrays {
    qn_context *context;
    int64_t leaf_room, leaf_count, tile_room;
    int32_t (*origins)[3];
    float *values;
    uint64_t *masks;
    qn_sparse_tile *tiles;
} owned_arrays;

static void release_arrays(void *user, const void *samples) {
    (void)samples;
    owned_arrays *arrays = user;
    qn_context *context = arrays->context;
    qni_free(context, arrays->tiles, arrays->tile_room, sizeof *arrays->tiles);
    qni_free(context, arrays->masks, arrays->leaf_room, QNI_BAND_WORDS * sizeof *arrays->masks);
    qni_free(context, arrays->values, arrays->leaf_room, QNI_BAND_SAMPLES * sizeof *arrays->values);
    qni_free(context, arrays->origins, arrays->leaf_count, sizeof *arrays->origins);
    qni_free(context, arrays, 1, sizeof *arrays);
}

static void describe(const qni_band *band, const owned_arrays *arrays, const char *space,
                     const char *unit, qn_sparse_grid *grid) {
    memset(grid, 0, sizeof *grid);
    grid->scalar = QN_F32;
    grid->leaf_count = band->leaf_count;
    grid->origins = (const int32_t(*)[3])arrays->origins;
    grid->values = arrays->values;
    grid->masks = (const uint64_t(*)[8])arrays->masks;
    grid->tile_count = band->tile_count;
    grid->tiles = arrays->tiles;
    grid->background = band->background;
    grid->kind = QN_SPARSE_LEVEL_SET;
    for (int i = 0; i < 3; ++i) {
        grid->index_to_world[i][i] = band->lattice.voxel;
        grid->index_to_world[i][3] = band->lattice.origin[i];
    }
    grid->index_to_world[3][3] = 1;
    strncpy(grid->space, space, sizeof grid->space - 1);
    strncpy(grid->unit, unit, sizeof grid->unit - 1);
    strcpy(grid->name, "surface");
}

qn_status qni_band_finish(qni_band *band, const char *space, const char *unit,
                          qn_volume **volume_out) {
    qn_context *context = band->work.context;
    owned_arrays *arrays = qni_alloc_zero(context, 1, sizeof *arrays);
    int32_t(*origins)[3] = qni_alloc(context, band->leaf_count, sizeof *origins);
    if (!arrays || !origins) {
        qni_free(context, origins, band->leaf_count, sizeof *origins);
        qni_free(context, arrays, 1, sizeof *arrays);
        return qni_fail_memory(band->work.error, "a narrow band");
    }
    for (int64_t n = 0; n < band->leaf_count; ++n)
        memcpy(origins[n], band->leaves[n].origin, sizeof origins[n]);
    *arrays = (owned_arrays){context, band->leaf_room, band->leaf_count, band->tile_room,
                             origins, band->values,    band->masks,      band->tiles};
    qn_sparse_grid grid;
    describe(band, arrays, space, unit, &grid);
    const qn_status status = qn_volume_create_sparse(context, &grid, release_arrays, arrays,
                                                     volume_out, band->work.error);
    if (status != QN_OK) {
        qni_free(context, origins, band->leaf_count, sizeof *origins);
        qni_free(context, arrays, 1, sizeof *arrays);
        return status;
    }
    band->values = NULL; /* the volume's now */
    band->masks = NULL;
    band->tiles = NULL;
    return QN_OK;
}
