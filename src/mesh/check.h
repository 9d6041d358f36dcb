// SPDX-License-Identifier: MIT
/* What the parts of qn_mesh_check() share: the mesh, flags of its vertices, work in blocks. */
#ifndef QNI_MESH_CHECK_H
#define QNI_MESH_CHECK_H

#include "mesh/diagonals.h"

#include <qn/mesh.h>

enum {
    QNI_VERTEX_USED = 1,      /* a face names it */
    QNI_VERTEX_NONFINITE = 2, /* a coordinate is NaN or infinite */
    QNI_VERTEX_PINCHED = 4    /* its faces form more than one fan */
};

typedef struct qni_check {
    qn_context *context;
    qn_mesh_view mesh;
    uint8_t *vertex_flags;
    qn_mesh_report *report;
    qn_error *error;
    const char *stage; /* what progress calls the work; NULL: "check" */
    qni_diagonals diagonals;
} qni_check;

/* A part of the whole's progress, from 0 to 1. */
typedef struct qni_check_span {
    double from, to;
} qni_check_span;

/* Run `work` over 0 .. count - 1 in blocks of `block_size`, on the context's threads; between its
 * blocks the calling thread reports progress, and all stop when it is told to. What a block writes
 * must not depend on who runs it, or when. */
typedef void qni_block_work(void *job, int64_t block, int64_t begin, int64_t end);
qn_status qni_check_blocks(qni_check *check, int64_t count, int64_t block_size, qni_check_span span,
                           qni_block_work *work, void *job);
int64_t qni_block_count(int64_t count, int64_t block_size);

/* The corners of face f: `*indices` of them, 3 or 4. */
static inline int qni_face_corners(const qn_mesh_view *mesh, int64_t face,
                                   const uint32_t **indices) {
    bool is_quad = face < mesh->quad_count;
    *indices = is_quad ? mesh->quads + 4 * face : mesh->triangles + 3 * (face - mesh->quad_count);
    return is_quad ? 4 : 3;
}

/* True when the face is a polygon: with equal neighbouring corners taken as one, at least three
 * corners are left, all different. Others are counted as degenerate and take no part in the
 * topology. */
bool qni_face_is_polygon(const uint32_t *indices, int corners);
/* True when no coordinate of the face's vertices is NaN or infinite. */
bool qni_face_is_finite(const qni_check *check, const uint32_t *indices, int corners);
/* The one or two triangles of a face. */
int qni_split_face(const qni_check *check, int64_t face, uint32_t triangles[2][3]);

/* The parts. Each fills its own fields of the report. */
qn_status qni_check_vertices(qni_check *check, qni_check_span span);
qn_status qni_check_topology(qni_check *check, qni_check_span span);
qn_status qni_check_shape(qni_check *check, qni_check_span span);
qn_status qni_check_intersections(qni_check *check, qni_check_span span);

#endif
