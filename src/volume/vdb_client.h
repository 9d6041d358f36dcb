// SPDX-License-Identifier: MIT
/* OpenVDB files as the library sees them: the calls of vdb_shim.h, carried to quoin-vdb and back.
 * What comes back is checked before it is believed. */
#ifndef QNI_VOLUME_VDB_CLIENT_H
#define QNI_VOLUME_VDB_CLIENT_H

#include "volume/load.h"
#include "volume/vdb_process.h"

/* Open a file; qni_vdb_process_end() in any case. The message is filled in by what fails here or
 * later. */
qni_vdb_result qni_vdb_client_open(qni_vdb_process *process, qn_context *context, const char *path,
                                   int32_t *grid_count_out, qni_vdb_message *message);
qni_vdb_result qni_vdb_client_describe(qni_vdb_process *process, int32_t grid,
                                       qni_vdb_grid *grid_out);
/* Read a grid's tree and count what it holds; then move it into arrays of these sizes. */
qni_vdb_result qni_vdb_client_load(qni_vdb_process *process, int32_t grid,
                                   qni_vdb_counts *counts_out);
qni_vdb_result qni_vdb_client_take(qni_vdb_process *process, qni_sparse_arrays *arrays);

/* Write leaves (f32) and boxes of one value over what is in an existing file. `fill` boxes come
 * first and are inactive; tiles may lie over them. */
qni_vdb_result qni_vdb_client_write(qn_context *context, const char *path,
                                    const qn_sparse_grid *grid, const qn_sparse_tile *fill,
                                    int64_t fill_count, qni_vdb_message *message);

#endif
