// SPDX-License-Identifier: MIT
/* The program quoin-vdb as a process beside us: found, started with a file and a socket, written
 * to, read from, ended. Nothing of it outlives qni_vdb_process_end(): no zombie, no descriptor. */
#ifndef QNI_VOLUME_VDB_PROCESS_H
#define QNI_VOLUME_VDB_PROCESS_H

#include "core/context.h"
#include "volume/vdb_face.h"
#include "volume/vdb_wire.h"

typedef struct qni_vdb_process {
    qn_context *context;
    const char *stage; /* "read" or "write", for progress */
    double fraction;   /* of the stage */
    int64_t file_bytes;
    int64_t seconds_allowed; /* of silence; 0: any */
    long child;              /* 0: none */
    int socket;
    qni_vdb_result result; /* once not QNI_VDB_OK nothing is sent or received any more */
    qni_vdb_message *message;
} qni_vdb_process;

/* Start it on a file; to be ended in any case. Its message is the caller's and is filled in when a
 * call fails. Each call returns process->result. */
qni_vdb_result qni_vdb_process_start(qni_vdb_process *process, qn_context *context,
                                     const char *path, bool reading, qni_vdb_message *message);
qni_vdb_result qni_vdb_process_send(qni_vdb_process *process, const void *bytes, size_t size);
qni_vdb_result qni_vdb_process_receive(qni_vdb_process *process, void *bytes, size_t size);
qni_vdb_result qni_vdb_process_fail(qni_vdb_process *process, qni_vdb_result result,
                                    const char *format, ...) __attribute__((format(printf, 3, 4)));
void qni_vdb_process_end(qni_vdb_process *process);

#endif
