// SPDX-License-Identifier: MIT
/* The z-buffer. Coverage is decided with integers, so that faces that share an edge leave no gap,
 * and each thread draws its own rows in the order of the faces, so that the result does not depend
 * on threads. */
#include "view/raster.h"
#include "core/parallel.h"
#include "mesh/mesh.h"

typedef struct rows {
    int32_t first, last; /* samples, the last one included */
} rows;

int qni_face_corners(const qn_mesh_view *view, int64_t face, uint32_t corners[4]) {
    bool quad = face < view->quad_count;
    const uint32_t *from =
        quad ? view->quads + 4 * face : view->triangles + 3 * (face - view->quad_count);
    for (int c = 0; c < 3; ++c)
        corners[c] = from[c];
    corners[3] = quad ? from[3] : from[2];
    return quad ? 4 : 3;
}

void qni_piece_corners(const qn_mesh_view *view, int64_t piece, uint32_t corners[3]) {
    uint32_t own[4], pair[6];
    const uint32_t *from = own;
    if (qni_face_corners(view, piece / 2, own) == 4) {
        qni_split_quad(view->positions, own, pair);
        from = pair + 3 * (piece % 2);
    }
    for (int c = 0; c < 3; ++c)
        corners[c] = from[c];
}

/* The first sample whose centre is not below a coordinate, and the last one not above. */
static int32_t first_sample(int32_t coordinate) {
    return (int32_t)(((int64_t)coordinate + QNI_SUBPIXEL / 2 - 1) >> 8);
}

static int32_t last_sample(int32_t coordinate) {
    return (int32_t)(((int64_t)coordinate - QNI_SUBPIXEL / 2) >> 8);
}

static int32_t least(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static int32_t most(int32_t a, int32_t b) {
    return a > b ? a : b;
}

/* The samples that a face may cover, cut to the band; false when there are none. */
typedef struct box {
    int32_t x0, x1, y0, y1;
} box;

static bool box_of(const qni_seen *const s[], int count, const qni_visible *visible, rows band,
                   box *out) {
    int32_t y0 = s[0]->y, y1 = y0, x0 = s[0]->x, x1 = x0;
    for (int c = 1; c < count; ++c) {
        y0 = least(y0, s[c]->y);
        y1 = most(y1, s[c]->y);
        x0 = least(x0, s[c]->x);
        x1 = most(x1, s[c]->x);
    }
    if (x0 == QNI_UNSEEN)
        return false;
    out->y0 = most(first_sample(y0), band.first);
    out->y1 = least(last_sample(y1), band.last);
    out->x0 = most(first_sample(x0), 0);
    out->x1 = least(last_sample(x1), visible->width - 1);
    return out->x0 <= out->x1 && out->y0 <= out->y1;
}

static void draw_piece(const qni_seen *a, const qni_seen *b, const qni_seen *c, int64_t piece,
                       rows band, qni_visible *visible) {
    int64_t area = qni_side(a, b, c->x, c->y);
    if (area == 0)
        return;
    if (area < 0) { /* seen from behind */
        const qni_seen *swap = b;
        b = c;
        c = swap;
        area = -area;
    }
    const qni_seen *const corners[3] = {a, b, c};
    box reach;
    if (!box_of(corners, 3, visible, band, &reach))
        return;
    int64_t x = (int64_t)reach.x0 * QNI_SUBPIXEL + QNI_SUBPIXEL / 2;
    int64_t y = (int64_t)reach.y0 * QNI_SUBPIXEL + QNI_SUBPIXEL / 2;
    int64_t ab = qni_side(a, b, x, y), bc = qni_side(b, c, x, y), ca = qni_side(c, a, x, y);
    int64_t ab_x = ((int64_t)a->y - b->y) * QNI_SUBPIXEL,
            ab_y = ((int64_t)b->x - a->x) * QNI_SUBPIXEL;
    int64_t bc_x = ((int64_t)b->y - c->y) * QNI_SUBPIXEL,
            bc_y = ((int64_t)c->x - b->x) * QNI_SUBPIXEL;
    int64_t ca_x = ((int64_t)c->y - a->y) * QNI_SUBPIXEL,
            ca_y = ((int64_t)a->x - c->x) * QNI_SUBPIXEL;
    double to_b = ((double)b->inverse - (double)a->inverse) / (double)area;
    double to_c = ((double)c->inverse - (double)a->inverse) / (double)area;
    for (int32_t row = reach.y0; row <= reach.y1; ++row, ab += ab_y, bc += bc_y, ca += ca_y) {
        int64_t u = ab, v = bc, w = ca;
        size_t at = (size_t)row * (size_t)visible->width + (size_t)reach.x0;
        for (int32_t column = reach.x0; column <= reach.x1;
             ++column, ++at, u += ab_x, v += bc_x, w += ca_x) {
            if ((u | v | w) < 0)
                continue;
            float inverse = (float)((double)a->inverse + (double)w * to_b + (double)u * to_c);
            if (inverse > visible->inverse[at]) {
                visible->inverse[at] = inverse;
                visible->piece[at] = piece;
            }
        }
    }
}

static void draw_face(const qn_mesh_view *view, const qni_seen *seen, int64_t face, rows band,
                      qni_visible *visible) {
    uint32_t corners[4], pair[6];
    int count = qni_face_corners(view, face, corners);
    const qni_seen *const s[4] = {seen + corners[0], seen + corners[1], seen + corners[2],
                                  seen + corners[3]};
    box reach;
    if (!box_of(s, count, visible, band, &reach))
        return;
    if (count == 3) {
        draw_piece(s[0], s[1], s[2], 2 * face, band, visible);
        return;
    }
    qni_split_quad(view->positions, corners, pair);
    for (int half = 0; half < 2; ++half)
        draw_piece(seen + pair[3 * half], seen + pair[3 * half + 1], seen + pair[3 * half + 2],
                   2 * face + half, band, visible);
}

void qni_raster_faces(const qn_context *context, const qn_mesh_view *view, const qni_seen *seen,
                      int64_t first, int64_t last, qni_visible *visible) {
    int32_t bands = qn_context_threads(context);
#pragma omp parallel for schedule(static, 1) num_threads(bands)
    for (int32_t b = 0; b < bands; ++b) {
        rows band = {(int32_t)((int64_t)visible->height * b / bands),
                     (int32_t)((int64_t)visible->height * (b + 1) / bands) - 1};
        for (int64_t face = first; face < last; ++face)
            draw_face(view, seen, face, band, visible);
    }
}
