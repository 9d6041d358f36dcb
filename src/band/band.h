// SPDX-License-Identifier: MIT
/* A narrow band in the making: a lattice, a source that knows the field, leaves and tiles. */
#ifndef QNI_BAND_BAND_H
#define QNI_BAND_BAND_H

#include "mesh/check.h"

#include <qn/band.h>

enum { QNI_BAND_LEAF = 8, QNI_BAND_SAMPLES = 512, QNI_BAND_WORDS = 8 };

/* Nothing known that helps to search near a node. */
#define QNI_NO_HINT UINT32_C(0xffffffff)

/* A cube of samples; its corner is a multiple of its size. */
typedef struct qni_band_node {
    int32_t origin[3]; /* its lowest sample */
    uint32_t hint;     /* the source's own: where to begin to search */
} qni_band_node;

typedef enum qni_band_class { QNI_BAND_OUTSIDE, QNI_BAND_INSIDE, QNI_BAND_MIXED } qni_band_class;

/* What the band is of. Both functions are called from any thread and depend on their arguments
 * alone. */
typedef struct qni_band_source {
    const void *user;
    /* Whether the node's samples, `size` along each side, are all outside the band on one side. */
    qn_status (*classify)(const void *user, qni_band_node *node, int32_t size,
                          qni_band_class *class_out);
    /* Values of a leaf, sample x + 8 y + 64 z, and which of them are in the band: bit x + 8 y of
     * word z. */
    qn_status (*fill)(const void *user, const qni_band_node *leaf, float values[QNI_BAND_SAMPLES],
                      uint64_t mask[QNI_BAND_WORDS]);
} qni_band_source;

typedef struct qni_lattice {
    double origin[3], voxel; /* sample (i, j, k) is at origin + voxel (i, j, k) */
    int32_t low[3], high[3]; /* the samples that the band may need, both ends included */
} qni_lattice;

typedef struct qni_band {
    qni_check work; /* context, error and the stage's name, for work in blocks */
    const qni_band_source *source;
    qni_lattice lattice;
    double background;
    int64_t leaf_count, leaf_room;
    qni_band_node *leaves; /* [leaf_room] */
    float *values;         /* [leaf_room][512] */
    uint64_t *masks;       /* [leaf_room][8] */
    int64_t tile_count, tile_room;
    qn_sparse_tile *tiles; /* [tile_room] */
    int64_t visited_nodes, active_count;
} qni_band;

/* The lattice of the options round a box: what lies within `reach` of it. */
qn_status qni_lattice_place(const qn_band_options *options, const double low[3],
                            const double high[3], double reach, qni_lattice *lattice_out,
                            qn_error *error);
qn_status qni_band_check_options(const qn_band_options *options, qn_error *error);

/* Leaves and inner tiles, from the top. */
qn_status qni_band_discover(qni_band *band);
/* Discovery, then the values; leaves that have no sample in the band become tiles, or go. */
qn_status qni_band_run(qni_band *band, const qni_band_source *source, qn_band_report *report);
/* A volume that takes leaves, values and tiles over. */
qn_status qni_band_finish(qni_band *band, const char *space, const char *unit,
                          qn_volume **volume_out);
/* Gives up all that was found; qni_band_run() may follow again. */
void qni_band_clear(qni_band *band);
/* What the public calls differ in: `make` fills the band. */
typedef struct qni_band_maker {
    const char *stage, *space, *unit;
    const void *user;
    qn_status (*make)(qni_band *band, const void *user, const qn_band_options *options,
                      qn_band_report *report);
} qni_band_maker;

/* Options checked, the band made, the volume and the report out of it. */
qn_status qni_band_make_volume(qn_context *context, const qni_band_maker *maker,
                               const qn_band_options *options, qn_volume **volume_out,
                               qn_band_report *report_out, qn_error *error);
/* Room for one more tile. */
qn_status qni_band_add_tile(qni_band *band, const int32_t origin[3], int32_t size);

#endif
