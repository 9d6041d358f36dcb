// SPDX-License-Identifier: MIT
/* How much device memory a surface takes, and where in it everything lies. */
#ifndef QNI_GPU_ROOM_H
#define QNI_GPU_ROOM_H

#include "gpu/driver.h"

int64_t qni_gpu_leaf_total(const qni_gpu_job *job);
int64_t qni_gpu_scan_tiles_of(int64_t length);

/* Bytes of each buffer: for pass 1, known from the lattice; for pass 2, known from what pass 1
 * counted. */
typedef struct qni_gpu_room {
    int64_t bytes[QNI_GPU_BUFFER_COUNT];
} qni_gpu_room;
qni_gpu_room qni_gpu_room_to_count(const qni_gpu_job *job);
qni_gpu_room qni_gpu_room_to_emit(const qni_gpu_job *job);
int64_t qni_gpu_room_sum(const qni_gpu_room *room);
/* What is enough for either, buffer by buffer. */
void qni_gpu_room_join(qni_gpu_room *room, const qni_gpu_room *other);

/* Take it from the pool and fill in the job's pointers. */
qn_status qni_gpu_reserve_count(qni_gpu_job *job, qn_error *error);
qn_status qni_gpu_reserve_records(qni_gpu_job *job, qn_error *error);
qn_status qni_gpu_reserve_mesh(qni_gpu_job *job, qn_error *error);
qn_status qni_gpu_reserve_repair(qni_gpu_job *job, qn_error *error);

#endif
