// SPDX-License-Identifier: MIT
/* OpenVDB behind a C face: the grids of a file, their leaves and tiles, and writing one. No C++
 * type and no exception crosses it: every call says with 0 that it did what it should, and else
 * fills in a message. */
#ifndef QNI_VOLUME_VDB_SHIM_H
#define QNI_VOLUME_VDB_SHIM_H

#include <qn/volume.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum qni_vdb_result { QNI_VDB_OK, QNI_VDB_BAD_FILE, QNI_VDB_NO_MEMORY } qni_vdb_result;
typedef struct qni_vdb_message {
    char text[200];
} qni_vdb_message;

typedef struct qni_vdb qni_vdb; /* an open file, and the grid read last */

qni_vdb_result qni_vdb_open(const char *path, qni_vdb **file_out, qni_vdb_message *message);
void qni_vdb_close(qni_vdb *file);
int32_t qni_vdb_grid_count(const qni_vdb *file);

/* What the file says of a grid without reading its tree. */
typedef struct qni_vdb_grid {
    qn_grid_info info;
    qn_scalar scalar; /* of info.readable grids */
    double index_to_world[4][4];
} qni_vdb_grid;
qni_vdb_result qni_vdb_describe(qni_vdb *file, int32_t grid, qni_vdb_grid *grid_out,
                                qni_vdb_message *message);

/* Read a grid's tree and count what it holds. */
typedef struct qni_vdb_counts {
    int64_t leaf_count, tile_count;
    double background;
} qni_vdb_counts;
qni_vdb_result qni_vdb_load(qni_vdb *file, int32_t grid, qni_vdb_counts *counts_out,
                            qni_vdb_message *message);
/* Copy it into arrays of that size, as in qn_sparse_grid, and let the tree go leaf by leaf. */
qni_vdb_result qni_vdb_take(qni_vdb *file, int32_t (*origins)[3], void *values,
                            uint64_t (*masks)[8], qn_sparse_tile *tiles, qni_vdb_message *message);

/* Write leaves (f32) and boxes of one value into a new file. `fill` boxes come first and are
 * inactive; tiles may lie over them. */
qni_vdb_result qni_vdb_write(const char *path, const qn_sparse_grid *grid,
                             const qn_sparse_tile *fill, int64_t fill_count,
                             qni_vdb_message *message);

#ifdef __cplusplus
}
#endif
#endif
