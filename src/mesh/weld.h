// SPDX-License-Identifier: MIT
/* Joining vertices at exactly the same place while they are read. */
#ifndef QNI_MESH_WELD_H
#define QNI_MESH_WELD_H

#include "mesh/builder.h"

/* A hash table of the builder's vertices, by their coordinates. */
typedef struct qni_weld {
    qni_builder *builder;
    uint32_t *slots;    /* vertex + 1, 0 for a free one */
    int64_t slot_count; /* a power of two */
} qni_weld;

/* The vertex at this place, made when there is none yet: numbers follow first appearance. 0 and -0
 * are the same place; a place that is not finite is told by its bits. False when memory ran out. */
bool qni_weld_vertex(qni_weld *weld, const float position[3], uint32_t *vertex_out);
void qni_weld_free(qni_weld *weld);

#endif
