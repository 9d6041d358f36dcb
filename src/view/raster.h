// SPDX-License-Identifier: MIT
/* The z-buffer: for each sample of the picture, the piece of a face that is nearest there. */
#ifndef QNI_VIEW_RASTER_H
#define QNI_VIEW_RASTER_H

#include "view/camera.h"

/* A piece is a triangle of the mesh, or one half of a quad: twice the face's index, and 1 more for
 * the second half. */
enum { QNI_NO_PIECE = -1 };

typedef struct qni_visible {
    int32_t width, height; /* samples */
    float *inverse;        /* [height][width], 0 where there is nothing; the bottom row first */
    int64_t *piece;        /* [height][width] */
} qni_visible;

/* The corners of a face: 4 or 3, their number returned. */
int qni_face_corners(const qn_mesh_view *view, int64_t face, uint32_t corners[4]);
/* The corners of a piece. */
void qni_piece_corners(const qn_mesh_view *view, int64_t piece, uint32_t corners[3]);

/* Twice the area of the triangle a, b, (x, y), positive when they run counter-clockwise. */
static inline int64_t qni_side(const qni_seen *a, const qni_seen *b, int64_t x, int64_t y) {
    return ((int64_t)b->x - a->x) * (y - a->y) - ((int64_t)b->y - a->y) * (x - a->x);
}

/* Draw faces [first, last) into the buffer, shared among the threads by bands of rows. */
void qni_raster_faces(const qn_context *context, const qn_mesh_view *view, const qni_seen *seen,
                      int64_t first, int64_t last, qni_visible *visible);

#endif
