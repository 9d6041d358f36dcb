// SPDX-License-Identifier: MIT
/* From a header to a volume: what all readers share, and the readers themselves. */
#ifndef QNI_VOLUME_LOAD_H
#define QNI_VOLUME_LOAD_H

#include "volume/source.h"

#include <qn/volume.h>

typedef enum qni_encoding { QNI_BINARY, QNI_TEXT } qni_encoding;

/* Put the spacing and origin of the options, where given, into a matrix whose columns are the
 * file's axes. Fails when a direction is zero, so that it cannot be scaled. */
qn_status qni_load_overrides(const qni_source *source, const qn_volume_read_options *options,
                             double matrix[4][4], qn_error *error);
/* Bytes of the packed samples; fails when a size is below 1, too large, or the product overflows.
 */
qn_status qni_load_bytes(const qni_source *source, const qn_grid *grid, int64_t *bytes_out,
                         qn_error *error);
/* Read the packed samples that come next in `source` and make the volume. Sizes are checked against
 * what the source can hold before memory is asked for. *more_out, which may be NULL, tells whether
 * bytes follow. */
qn_status qni_load(qni_source *source, qn_grid *grid, qni_encoding encoding, const char *format,
                   bool *more_out, qn_volume **volume_out, qn_error *error);

static inline bool qni_machine_is_big_endian(void) {
    return __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
}

/* A reader: the source stands at its first byte, the options were checked. */
typedef qn_status qni_reader(qni_source *source, const qn_volume_read_options *options,
                             qn_volume **volume_out, qn_error *error);
qni_reader qni_read_nifti;
qni_reader qni_read_nrrd;
qni_reader qni_read_metaimage;
qni_reader qni_read_npy;
qni_reader qni_read_raw;
qni_reader qni_read_inr;
qni_reader qni_read_mitsuba;
qni_reader qni_read_vdb;
qni_reader qni_read_nvdb;

/* A list of a file's grids: the first `capacity` of them, and their number. */
typedef qn_status qni_lister(qni_source *source, qn_grid_info *infos_out, int32_t capacity,
                             int32_t *count_out, qn_error *error);
qni_lister qni_list_vdb;
qni_lister qni_list_nvdb;

/* Which of a file's grids the options mean: by name, else the only one that can be read. The
 * sentence of a failure lists the grids. */
qn_status qni_choose_grid(const qni_source *source, const qn_grid_info *infos, int32_t count,
                          const char *wanted, int32_t *chosen_out, qn_error *error);

/* The arrays of a sparse grid, to be filled by a reader and handed over to a volume. */
typedef struct qni_sparse_arrays {
    qn_context *context;
    int64_t leaf_count, tile_count;
    size_t value_bytes; /* of a leaf */
    int32_t (*origins)[3];
    void *values;
    uint64_t (*masks)[8];
    qn_sparse_tile *tiles;
} qni_sparse_arrays;

qn_status qni_sparse_arrays_create(qn_context *context, qn_scalar scalar, int64_t leaf_count,
                                   int64_t tile_count, qni_sparse_arrays **arrays_out,
                                   qn_error *error);
void qni_sparse_arrays_destroy(qni_sparse_arrays *arrays);
/* Make a volume that owns them; they are given up in any case. */
qn_status qni_sparse_arrays_load(const qni_source *source, qni_sparse_arrays *arrays,
                                 qn_sparse_grid *grid, const char *format,
                                 const qn_volume_read_options *options, qn_volume **volume_out,
                                 qn_error *error);

/* qn_volume_read() of borrowed bytes; `name` stands for the path. */
qn_status qni_volume_read_memory(qn_context *context, const char *name, const void *bytes,
                                 int64_t size, const qn_volume_read_options *options,
                                 qn_volume **volume_out, qn_error *error);

#endif
