// SPDX-License-Identifier: MIT
/* The buffers of a glTF asset (glTF 2.0 specification, sections 3.6 and 4.4): the chunk of a GLB
 * file, base64 within the JSON, or files beside it. */
#ifndef QNI_MESH_GLTF_BUFFERS_H
#define QNI_MESH_GLTF_BUFFERS_H

#include "mesh/content.h"

#include <jansson.h>

typedef struct qni_gltf_buffer {
    const char *bytes; /* NULL until it is asked for */
    int64_t size;
    qni_content held; /* what is given back at the end: a file, or decoded base64 */
} qni_gltf_buffer;

typedef struct qni_gltf_buffers {
    const qni_content *asset; /* the file that names them; borrowed */
    const json_t *list;       /* "buffers" of its JSON; borrowed */
    const char *chunk;        /* of a GLB file, else NULL */
    int64_t chunk_size;
    qni_gltf_buffer *items;
    int64_t count;
    int64_t loaded; /* bytes read from files beside the asset */
} qni_gltf_buffers;

/* Nothing is read yet. QN_ERROR_OUT_OF_MEMORY. */
qn_status qni_gltf_buffers_start(qni_gltf_buffers *buffers, qn_error *error);
/* Buffer n, read when it is first asked for. QN_ERROR_INPUT: there is none; its URI is no base64
 * and no file in the asset's folder or below; it is shorter than its byteLength. */
qn_status qni_gltf_buffers_get(qni_gltf_buffers *buffers, int64_t n, const qni_gltf_buffer **out,
                               qn_error *error);
void qni_gltf_buffers_free(qni_gltf_buffers *buffers);

#endif
