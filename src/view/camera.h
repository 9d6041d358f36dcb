// SPDX-License-Identifier: MIT
/* The camera: where it stands so that the whole mesh just fits, and where it sees a point. */
#ifndef QNI_VIEW_CAMERA_H
#define QNI_VIEW_CAMERA_H

#include <math.h>
#include <qn/mesh.h>

/* Samples are counted in steps of 1/256, with y upward, so that coverage is decided in integers. */
enum { QNI_SUBPIXEL = 256, QNI_SAMPLES = 2 /* a pixel's side */ };

/* A mild perspective. In camera coordinates x runs right, y up, z toward the eye. */
typedef struct qni_camera {
    double right[3], up[3], toward[3];
    double centre[3];        /* of the mesh's bounds, in the world */
    double shift_x, shift_y; /* of the eye from the centre, in camera coordinates */
    double distance;         /* of the eye from the centre's plane; larger than any point's z */
    double focal;            /* samples a unit at distance 1 */
    double half_width, half_height; /* samples */
    double extent; /* world units from top to bottom of the picture, at the centre */
} qni_camera;

/* A vertex as it is seen. */
typedef struct qni_seen {
    int32_t x, y; /* steps of 1/QNI_SUBPIXEL sample; x is QNI_UNSEEN for a vertex without a place */
    float inverse; /* the centre's distance from the eye over this one's, along z: straight in the
                      picture */
} qni_seen;

#define QNI_UNSEEN INT32_MIN

typedef struct qni_frame {
    int32_t width, height; /* pixels */
    double azimuth, elevation, zoom;
} qni_frame;

/* used: 1 for each vertex that a face uses and that is finite, else 0: the others are not fitted.
 */
qni_camera qni_camera_fit(const qn_context *context, const qn_mesh_view *view, const uint8_t *used,
                          const qni_frame *frame);
void qni_camera_project(const qn_context *context, const qni_camera *camera,
                        const qn_mesh_view *view, const uint8_t *used, qni_seen *seen);

static inline double qni_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* used: [vertex_count]. */
void qni_find_used(const qn_mesh_view *view, uint8_t *used);

static inline bool qni_is_finite3(const float *p) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

#endif
