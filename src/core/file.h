// SPDX-License-Identifier: MIT
/* Files that appear whole or not at all: written under a temporary name in the same folder, then
 * renamed. */
#ifndef QNI_CORE_FILE_H
#define QNI_CORE_FILE_H

#include <limits.h>
#include <qn/base.h>

/* A file being written. Writing never fails at once: the first failure is kept, later bytes are
 * dropped, and commit says what happened. So a writer is straight-line code that ends in one
 * commit.
 *
 * What is there already and is not a regular file (/dev/stdout, a FIFO, a terminal) cannot be
 * renamed over: it is opened and written directly, and then a failure can leave a part behind. A
 * symbolic link stays a link: the file it names is replaced. */
typedef struct qni_output {
    qn_context *context; /* NULL: no buffer, no progress */
    const char *path;    /* as the caller named it, for messages; borrowed */
    int descriptor;
    bool direct; /* written in place, nothing to rename */
    bool cancelled;
    int failure; /* the first errno, 0 when all is well */
    char *buffer;
    size_t used;
    int64_t bytes; /* handed over so far */
    char target[PATH_MAX];
    char temporary[PATH_MAX];
} qni_output;

enum { QNI_OUTPUT_BUFFER = 1 << 20 };

/* QN_ERROR_OUTPUT with what is wrong and what to do: no such folder, a folder itself, no right to
 * write. */
qn_status qni_output_open(qni_output *output, qn_context *context, const char *path,
                          qn_error *error);
void qni_output_write(qni_output *output, const void *bytes, size_t size);
/* Room for `size` bytes (at most QNI_OUTPUT_BUFFER, context not NULL); tell with
 * qni_output_advance() how many were used. Never NULL. */
char *qni_output_reserve(qni_output *output, size_t size);
void qni_output_advance(qni_output *output, size_t size);
/* True when writing on is of no use: something failed, or progress asks to stop. Calling thread
 * only. */
bool qni_output_stopped(qni_output *output, double fraction);
/* Give the file its name; on failure nothing is left and what was there before stays as it was. */
qn_status qni_output_commit(qni_output *output, qn_error *error);
/* Drop the file. To be called instead of commit. */
void qni_output_abandon(qni_output *output);

#endif
