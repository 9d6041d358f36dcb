// SPDX-License-Identifier: MIT
/* A file's content in memory, unpacked when it is gzip. */
#ifndef QNI_MESH_CONTENT_H
#define QNI_MESH_CONTENT_H

#include <qn/base.h>

typedef struct qni_content {
    qn_context *context;
    const char *path; /* borrowed, for messages */
    char *bytes;
    int64_t size;
    int64_t capacity;
} qni_content;

/* QN_ERROR_INPUT: no such file, a folder, no right to read, a damaged gzip stream; on failure
 * nothing is held. */
qn_status qni_content_load(qn_context *context, const char *path, qni_content *content,
                           qn_error *error);
void qni_content_free(qni_content *content);

#endif
