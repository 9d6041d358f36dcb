// SPDX-License-Identifier: MIT
/* Leaves and inner tiles from the top: cubes that the source cannot decide are cut into eight,
 * level by level, all cubes of a level at once. */
#include "band/band.h"
#include "core/context.h"
#include "core/status.h"

#include <string.h>

enum { BLOCK = 64, FEW_ROOTS = 4 };

typedef struct level_job {
    const qni_band_source *source;
    qni_band_node *nodes;
    uint8_t *classes;
    int32_t size;
    qn_status failure; /* any block's */
} level_job;

static void classify_block(void *pointer, int64_t block, int64_t begin, int64_t end) {
    (void)block;
    level_job *job = pointer;
    for (int64_t n = begin; n < end; ++n) {
        qni_band_class class = QNI_BAND_OUTSIDE;
        const qn_status status =
            job->source->classify(job->source->user, &job->nodes[n], job->size, &class);
        job->classes[n] = (uint8_t) class;
        if (status != QN_OK)
            __atomic_store_n(&job->failure, status, __ATOMIC_RELAXED);
    }
}

static int32_t floor_to(int32_t value, int32_t size) {
    return (int32_t)((uint32_t)value & ~((uint32_t)size - 1));
}

/* The size of the coarsest cubes: a few of them cover the lattice's box. */
static int32_t root_size(const qni_lattice *lattice) {
    int32_t size = QNI_BAND_LEAF;
    for (int i = 0; i < 3; ++i)
        while ((int64_t)lattice->high[i] - floor_to(lattice->low[i], size) >=
               FEW_ROOTS * (int64_t)size)
            size *= 2;
    return size;
}

static qn_status list_roots(qni_band *band, int32_t size, qni_band_node **nodes_out,
                            int64_t *count_out) {
    const qni_lattice *lattice = &band->lattice;
    int32_t first[3];
    int64_t counts[3];
    for (int i = 0; i < 3; ++i) {
        first[i] = floor_to(lattice->low[i], size);
        counts[i] = ((int64_t)lattice->high[i] - first[i]) / size + 1;
    }
    const int64_t count = counts[0] * counts[1] * counts[2];
    qni_band_node *nodes = qni_alloc(band->work.context, count, sizeof *nodes);
    if (!nodes)
        return qni_fail_memory(band->work.error, "the search for a narrow band");
    int64_t n = 0;
    for (int32_t z = 0; z < counts[2]; ++z)
        for (int32_t y = 0; y < counts[1]; ++y)
            for (int32_t x = 0; x < counts[0]; ++x)
                nodes[n++] = (qni_band_node){
                    {first[0] + x * size, first[1] + y * size, first[2] + z * size}, QNI_NO_HINT};
    *nodes_out = nodes;
    *count_out = count;
    return QN_OK;
}

qn_status qni_band_add_tile(qni_band *band, const int32_t origin[3], int32_t size) {
    if (band->tile_count == band->tile_room) {
        const int64_t room = band->tile_room ? 2 * band->tile_room : 64;
        qn_sparse_tile *tiles =
            qni_realloc(band->work.context, band->tiles, band->tile_room, room, sizeof *tiles);
        if (!tiles)
            return qni_fail_memory(band->work.error, "the tiles of a narrow band");
        band->tiles = tiles;
        band->tile_room = room;
    }
    qn_sparse_tile *tile = &band->tiles[band->tile_count++];
    memset(tile, 0, sizeof *tile);
    for (int i = 0; i < 3; ++i) {
        tile->origin[i] = origin[i];
        tile->size[i] = size;
    }
    tile->value = -band->background;
    return QN_OK;
}

/* Inner nodes become tiles; the undecided ones stay in `nodes`, and their number is returned. */
static qn_status keep_mixed(qni_band *band, level_job *job, int64_t count, int64_t *kept_out) {
    int64_t kept = 0;
    for (int64_t n = 0; n < count; ++n) {
        if (job->classes[n] == QNI_BAND_INSIDE)
            QN_TRY(qni_band_add_tile(band, job->nodes[n].origin, job->size));
        else if (job->classes[n] == QNI_BAND_MIXED)
            job->nodes[kept++] = job->nodes[n];
    }
    *kept_out = kept;
    return QN_OK;
}

static qn_status classify_level(qni_band *band, level_job *job, int64_t count, double done,
                                int64_t *kept_out) {
    job->classes = qni_alloc(band->work.context, count, 1);
    if (!job->classes)
        return qni_fail_memory(band->work.error, "the search for a narrow band");
    const qni_check_span span = {done, done};
    band->visited_nodes += count;
    qn_status status = qni_check_blocks(&band->work, count, BLOCK, span, classify_block, job);
    if (status == QN_OK && job->failure != QN_OK)
        status = qni_fail(band->work.error, job->failure, "the solid stopped the work");
    if (status == QN_OK)
        status = keep_mixed(band, job, count, kept_out);
    qni_free(band->work.context, job->classes, count, 1);
    return status;
}

/* The eight halves of each node, in the order of their corners. */
static void divide(const qni_band_node *nodes, int64_t count, int32_t half,
                   qni_band_node *children) {
    for (int64_t n = 0; n < count; ++n)
        for (int corner = 0; corner < 8; ++corner) {
            qni_band_node *child = &children[8 * n + corner];
            *child = nodes[n];
            for (int i = 0; i < 3; ++i)
                child->origin[i] += corner >> i & 1 ? half : 0;
        }
}

/* The undecided leaves, as long as memory lasts; `*nodes` and `*room` are those of the list. */
static qn_status descend(qni_band *band, int32_t size, qni_band_node **nodes, int64_t *room,
                         int64_t *kept_out) {
    qn_context *context = band->work.context;
    int64_t kept = 0;
    for (double done = 0;; size /= 2) {
        level_job job = {.source = band->source, .nodes = *nodes, .size = size};
        QN_TRY(classify_level(band, &job, *room, done, &kept));
        done += (1 - done) / 4;
        if (size == QNI_BAND_LEAF)
            break;
        qni_band_node *children = qni_alloc(context, 8 * kept, sizeof *children);
        if (!children)
            return qni_fail_memory(band->work.error, "the search for a narrow band");
        divide(*nodes, kept, size / 2, children);
        qni_free(context, *nodes, *room, sizeof **nodes);
        *nodes = children;
        *room = 8 * kept;
    }
    *kept_out = kept;
    return QN_OK;
}

qn_status qni_band_discover(qni_band *band) {
    const int32_t size = root_size(&band->lattice);
    qni_band_node *nodes = NULL;
    int64_t room = 0, kept = 0;
    QN_TRY(list_roots(band, size, &nodes, &room));
    qn_status status = descend(band, size, &nodes, &room, &kept);
    if (status == QN_OK) {
        band->leaves = qni_alloc(band->work.context, kept, sizeof *band->leaves);
        if (band->leaves)
            memcpy(band->leaves, nodes, (size_t)kept * sizeof *nodes);
        band->leaf_count = band->leaf_room = band->leaves ? kept : 0;
        if (!band->leaves)
            status = qni_fail_memory(band->work.error, "the leaves of a narrow band");
    }
    qni_free(band->work.context, nodes, room, sizeof *nodes);
    return status;
}
