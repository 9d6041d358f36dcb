// SPDX-License-Identifier: MIT
/* The camera: an exact fit of the mesh's vertices into the frame, in one pass over them. */
#include "view/camera.h"
#include "core/parallel.h"

static const double half_angle = 13 * 3.14159265358979323846 / 180; /* of the shorter side */
static const double margin = 0.93; /* of the picture that the mesh may take */
static const double radians = 3.14159265358979323846 / 180;

static void find_axes(qni_camera *camera, double azimuth, double elevation) {
    double ca = cos(azimuth * radians), sa = sin(azimuth * radians);
    double ce = cos(elevation * radians), se = sin(elevation * radians);
    double right[3] = {-sa, ca, 0}, up[3] = {-se * ca, -se * sa, ce},
           toward[3] = {ce * ca, ce * sa, se};
    for (int a = 0; a < 3; ++a) {
        camera->right[a] = right[a];
        camera->up[a] = up[a];
        camera->toward[a] = toward[a];
    }
}

void qni_find_used(const qn_mesh_view *view, uint8_t *used) {
    for (int64_t i = 0; i < view->vertex_count; ++i)
        used[i] = 0;
    for (int64_t i = 0; i < 4 * view->quad_count; ++i)
        used[view->quads[i]] = 1;
    for (int64_t i = 0; i < 3 * view->triangle_count; ++i)
        used[view->triangles[i]] = 1;
    for (int64_t i = 0; i < view->vertex_count; ++i)
        used[i] = used[i] && qni_is_finite3(view->positions + 3 * i);
}

static void find_centre(const qn_context *context, const qn_mesh_view *view, const uint8_t *used,
                        double centre[3]) {
    for (int a = 0; a < 3; ++a) {
        float low = INFINITY, high = -INFINITY;
        /* Least and largest do not depend on the order they are taken in. */
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))                 \
    reduction(min                                                                                  \
              : low) reduction(max                                                                 \
                               : high)
        for (int64_t i = 0; i < view->vertex_count; ++i) {
            float value = view->positions[3 * i + a];
            if (used[i]) {
                low = value < low ? value : low;
                high = value > high ? value : high;
            }
        }
        centre[a] = low <= high ? 0.5 * ((double)low + (double)high) : 0;
    }
    (void)context;
}

static void relative(const qni_camera *camera, const float *position, double out[3]) {
    double q[3];
    for (int a = 0; a < 3; ++a)
        q[a] = (double)position[a] - camera->centre[a];
    out[0] = qni_dot(camera->right, q);
    out[1] = qni_dot(camera->up, q);
    out[2] = qni_dot(camera->toward, q);
}

/* A point (x, y, z) is within the frame when |x - shift| <= t (distance - z), likewise for y: so
 * only the largest of x + t z, -x + t z, y + t z, -y + t z count. */
qni_camera qni_camera_fit(const qn_context *context, const qn_mesh_view *view, const uint8_t *used,
                          const qni_frame *frame) {
    qni_camera camera = {0};
    find_axes(&camera, frame->azimuth, frame->elevation);
    find_centre(context, view, used, camera.centre);
    double shorter = frame->width < frame->height ? frame->width : frame->height;
    double tx = margin * tan(half_angle) * frame->width / shorter;
    double ty = margin * tan(half_angle) * frame->height / shorter;
    const double nothing = -HUGE_VAL;
    double x_high = nothing, x_low = nothing, y_high = nothing, y_low = nothing;
    double z_high = nothing, z_low = -nothing;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))                 \
    reduction(max                                                                                  \
              : x_high, x_low, y_high, y_low, z_high) reduction(min                                \
                                                                : z_low)
    for (int64_t i = 0; i < view->vertex_count; ++i) {
        const float *position = view->positions + 3 * i;
        double p[3];
        if (!used[i])
            continue;
        relative(&camera, position, p);
        x_high = fmax(x_high, p[0] + tx * p[2]);
        x_low = fmax(x_low, -p[0] + tx * p[2]);
        y_high = fmax(y_high, p[1] + ty * p[2]);
        y_low = fmax(y_low, -p[1] + ty * p[2]);
        z_high = fmax(z_high, p[2]);
        z_low = fmin(z_low, p[2]);
    }
    if (!(z_low <= z_high)) /* nothing to see */
        x_high = x_low = y_high = y_low = z_high = z_low = 0;
    camera.shift_x = 0.5 * (x_high - x_low);
    camera.shift_y = 0.5 * (y_high - y_low);
    camera.distance = fmax(0.5 * (x_high + x_low) / tx, 0.5 * (y_high + y_low) / ty);
    /* The eye stays before the nearest point, for meshes that are flat or a single point as well.
     */
    double least = z_high + 0.01 * (z_high - z_low) + 1e-30;
    camera.distance = fmax(camera.distance, least);
    camera.half_width = 0.5 * QNI_SAMPLES * frame->width;
    camera.half_height = 0.5 * QNI_SAMPLES * frame->height;
    camera.focal = frame->zoom * 0.5 * QNI_SAMPLES * shorter / tan(half_angle);
    camera.extent = 2 * camera.half_height / camera.focal * camera.distance;
    return camera;
}

void qni_camera_project(const qn_context *context, const qni_camera *camera,
                        const qn_mesh_view *view, const uint8_t *used, qni_seen *seen) {
    (void)context;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int64_t i = 0; i < view->vertex_count; ++i) {
        const float *position = view->positions + 3 * i;
        if (!used[i]) {
            seen[i] = (qni_seen){QNI_UNSEEN, 0, 0};
            continue;
        }
        double p[3];
        relative(camera, position, p);
        double inverse = 1 / (camera->distance - p[2]);
        double x = camera->half_width + camera->focal * (p[0] - camera->shift_x) * inverse;
        double y = camera->half_height + camera->focal * (p[1] - camera->shift_y) * inverse;
        seen[i] = (qni_seen){(int32_t)lrint(x * QNI_SUBPIXEL), (int32_t)lrint(y * QNI_SUBPIXEL),
                             (float)(camera->distance * inverse)};
    }
}
