// SPDX-License-Identifier: MIT
/* OpenVDB behind a C face, inside the program quoin-vdb: the grids of a file, their leaves and
 * tiles, and writing one. No C++ type and no exception crosses it: every call says with 0 that it
 * did what it should, and else fills in a message. */
#ifndef QNI_VOLUME_VDB_SHIM_H
#define QNI_VOLUME_VDB_SHIM_H

#include "volume/vdb_face.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qni_vdb qni_vdb; /* an open file, and the grid read last */

qni_vdb_result qni_vdb_open(const char *path, qni_vdb **file_out, qni_vdb_message *message);
void qni_vdb_close(qni_vdb *file);
int32_t qni_vdb_grid_count(const qni_vdb *file);

qni_vdb_result qni_vdb_describe(qni_vdb *file, int32_t grid, qni_vdb_grid *grid_out,
                                qni_vdb_message *message);

/* Read a grid's tree and count what it holds. */
qni_vdb_result qni_vdb_load(qni_vdb *file, int32_t grid, qni_vdb_counts *counts_out,
                            qni_vdb_message *message);

/* Takes what a tree holds, piece by piece; false: the other side is gone. Values are as in
 * qn_sparse_grid; `value_bytes` is the size of one. */
typedef struct qni_vdb_sink {
    bool (*leaf)(void *user, const int32_t origin[3], const uint64_t mask[8], const void *values,
                 size_t value_bytes);
    bool (*tile)(void *user, const qn_sparse_tile *tile);
    void *user;
} qni_vdb_sink;
/* Hand it over, and let the tree go leaf by leaf. */
qni_vdb_result qni_vdb_take(qni_vdb *file, const qni_vdb_sink *sink, qni_vdb_message *message);

/* Make a grid of `head` (name, kind, background, matrix; counts and arrays are not looked at), put
 * boxes of one value and then leaves of f32 into it, write it into a file. A later box or leaf lies
 * over an earlier one; a leaf without a mask is active. */
qni_vdb_result qni_vdb_begin(const qn_sparse_grid *head, qni_vdb **file_out,
                             qni_vdb_message *message);
qni_vdb_result qni_vdb_put_tile(qni_vdb *file, const qn_sparse_tile *tile,
                                qni_vdb_message *message);
qni_vdb_result qni_vdb_put_leaf(qni_vdb *file, const int32_t origin[3], const uint64_t *mask,
                                const float *values, qni_vdb_message *message);
qni_vdb_result qni_vdb_finish(qni_vdb *file, const char *path, qni_vdb_message *message);

#ifdef __cplusplus
}
#endif
#endif
