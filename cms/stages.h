// SPDX-License-Identifier: MIT
/* What the stages of one surface share: leaves in chunks; first all faces, then all cells, then the
 * mesh. */
#ifndef QNI_CMS_STAGES_H
#define QNI_CMS_STAGES_H

#include "cms/cms.h"

/* Where a leaf's own face segments are, in its chunk. */
typedef struct qni_leaf_faces {
    uint32_t first;
    uint8_t count[6];
} qni_leaf_faces;

/* The work on QNI_CHUNK leaves; offsets come from sums over the chunks before. */
typedef struct qni_chunk {
    qni_segment *segments;
    int64_t segment_count, segment_capacity;
    qni_face_feature *features;
    int64_t feature_count, feature_capacity, feature_base;
    uint32_t (*triangles)[3];
    int32_t *owners; /* as long as triangles */
    int64_t triangle_count, triangle_capacity, owner_capacity, triangle_base;
    float (*apexes)[3];
    int64_t apex_count, apex_capacity, apex_base;
    uint32_t (*creases)[2];
    int64_t crease_count, crease_capacity, crease_base;
    qni_cell *vetoes; /* coarse leaves that must be divided */
    int64_t veto_count, veto_capacity;
    qni_cms_tally tally;
    qn_status status;
} qni_chunk;

typedef struct qni_stages {
    qn_context *context;
    const qni_hermite *hermite;
    const qni_octree *octree;
    qni_cms_settings settings;
    qni_leaf_faces *faces; /* for each leaf */
    qni_chunk *chunks;
    int64_t chunk_count;
    qni_face_feature *features; /* of all chunks */
    int64_t feature_count;
    qni_patch *patches; /* one for each thread */
    qni_face_solution *solutions;
    int32_t threads;
    qn_error *error;
} qni_stages;

/* Solve the faces that the chunk's leaves own; make the triangles of its cells (cells.c). */
void qni_chunk_faces(qni_stages *stages, int64_t chunk);
void qni_chunk_cells(qni_stages *stages, int64_t chunk);

#endif
