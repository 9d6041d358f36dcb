// SPDX-License-Identifier: MIT
/* A picture of a mesh: fit -> project -> draw -> shade -> occlude -> develop -> write. */
#include "core/context.h"
#include "core/status.h"
#include "view/occlusion.h"
#include "view/picture.h"
#include "view/shade.h"

enum { LARGEST_SIDE = 16384, FACES_A_STEP = 1 << 20, ROWS_A_STEP = 256 };

static const double largest_zoom = 64; /* keeps coordinates within 32 bits */

typedef struct canvas {
    uint8_t *used;
    qni_seen *seen;
    qni_visible visible;
    qni_pixel *pixels;
    float *rough, *open;
    uint8_t *rgb;
    int64_t vertex_count, sample_count, pixel_count;
} canvas;

static qn_status read_options(const qn_view_options *options, qni_frame *frame, qn_error *error) {
    *frame = (qni_frame){800, 600, 40, 25, 1};
    if (!options)
        return QN_OK;
    if (options->width)
        frame->width = options->width;
    if (options->height)
        frame->height = options->height;
    if (options->has_angles) {
        frame->azimuth = options->azimuth;
        frame->elevation = options->elevation;
    }
    if (options->zoom != 0)
        frame->zoom = options->zoom;
    if (frame->width < 1 || frame->height < 1 || frame->width > LARGEST_SIDE ||
        frame->height > LARGEST_SIDE)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a picture of %d x %d pixels: give from 1 to %d a side", frame->width,
                        frame->height, LARGEST_SIDE);
    if (!isfinite(frame->azimuth) || !isfinite(frame->elevation))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "azimuth and elevation must be finite numbers of degrees");
    if (!(frame->zoom > 0 && frame->zoom <= largest_zoom))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "a zoom of %g: give more than 0, at most %g", frame->zoom, largest_zoom);
    return QN_OK;
}

static void free_canvas(qn_context *context, canvas *c) {
    qni_free(context, c->used, c->vertex_count, 1);
    qni_free(context, c->seen, c->vertex_count, sizeof *c->seen);
    qni_free(context, c->visible.inverse, c->sample_count, sizeof *c->visible.inverse);
    qni_free(context, c->visible.piece, c->sample_count, sizeof *c->visible.piece);
    qni_free(context, c->pixels, c->pixel_count, sizeof *c->pixels);
    qni_free(context, c->rough, c->pixel_count, sizeof *c->rough);
    qni_free(context, c->open, c->pixel_count, sizeof *c->open);
    qni_free(context, c->rgb, c->pixel_count, 3);
    *c = (canvas){0};
}

static qn_status alloc_canvas(qn_context *context, int64_t vertex_count, const qni_frame *frame,
                              canvas *c, qn_error *error) {
    *c = (canvas){.vertex_count = vertex_count};
    c->pixel_count = (int64_t)frame->width * frame->height;
    c->sample_count = c->pixel_count * QNI_SAMPLES * QNI_SAMPLES;
    c->visible.width = frame->width * QNI_SAMPLES;
    c->visible.height = frame->height * QNI_SAMPLES;
    c->used = qni_alloc(context, vertex_count, 1);
    c->seen = qni_alloc(context, vertex_count, sizeof *c->seen);
    c->visible.inverse = qni_alloc_zero(context, c->sample_count, sizeof *c->visible.inverse);
    c->visible.piece = qni_alloc(context, c->sample_count, sizeof *c->visible.piece);
    c->pixels = qni_alloc(context, c->pixel_count, sizeof *c->pixels);
    c->rough = qni_alloc(context, c->pixel_count, sizeof *c->rough);
    c->open = qni_alloc(context, c->pixel_count, sizeof *c->open);
    c->rgb = qni_alloc(context, c->pixel_count, 3);
    if (c->used && c->seen && c->visible.inverse && c->visible.piece && c->pixels && c->rough &&
        c->open && c->rgb) {
        for (int64_t i = 0; i < c->sample_count; ++i)
            c->visible.piece[i] = QNI_NO_PIECE;
        return QN_OK;
    }
    free_canvas(context, c);
    return qni_fail(error, QN_ERROR_OUT_OF_MEMORY,
                    "not enough memory for a picture of %d x %d pixels: take a smaller one",
                    frame->width, frame->height);
}

static qn_status cancelled(qn_error *error) {
    return qni_fail(error, QN_ERROR_CANCELLED, "cancelled while drawing");
}

static qn_status draw(qn_context *context, const qn_mesh_view *view, const qni_frame *frame,
                      const qn_view_options *options, canvas *c, qn_error *error) {
    qni_find_used(view, c->used);
    qni_camera camera = qni_camera_fit(context, view, c->used, frame);
    qni_camera_project(context, &camera, view, c->used, c->seen);
    int64_t face_count = view->quad_count + view->triangle_count;
    for (int64_t first = 0; first < face_count; first += FACES_A_STEP) {
        if (qni_progress(context, "draw", 0.6 * (double)first / (double)face_count))
            return cancelled(error);
        int64_t last = first + FACES_A_STEP < face_count ? first + FACES_A_STEP : face_count;
        qni_raster_faces(context, view, c->seen, first, last, &c->visible);
    }
    qni_scene scene = {context,
                       view,
                       &camera,
                       c->seen,
                       &c->visible,
                       options && options->edges,
                       options && options->flat};
    for (int32_t row = 0; row < frame->height; row += ROWS_A_STEP) {
        if (qni_progress(context, "draw", 0.6 + 0.4 * row / frame->height))
            return cancelled(error);
        int32_t last = row + ROWS_A_STEP < frame->height ? row + ROWS_A_STEP : frame->height;
        qni_shade_rows(&scene, row, last, c->pixels);
    }
    qni_find_occlusion(context, &camera, frame->width, frame->height, c->pixels, c->rough, c->open);
    qni_develop(context, frame->width, frame->height, c->pixels, c->open, c->rgb);
    return QN_OK;
}

qn_status qn_mesh_write_picture(qn_context *context, const qn_mesh *mesh, const char *path,
                                const qn_view_options *options, qn_error *error) {
    QNI_CHECK_OPTIONS(options, "qn_view_options_init", error);
    QN_TRY(qni_picture_supported(error));
    qni_frame frame;
    QN_TRY(read_options(options, &frame, error));
    qn_mesh_view view = qn_mesh_get_view(mesh);
    canvas c;
    QN_TRY(alloc_canvas(context, view.vertex_count, &frame, &c, error));
    qn_status status = draw(context, &view, &frame, options, &c, error);
    if (status == QN_OK)
        status = qni_picture_write(context, path, frame.width, frame.height, c.rgb, error);
    free_canvas(context, &c);
    return status;
}
