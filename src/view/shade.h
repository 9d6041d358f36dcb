// SPDX-License-Identifier: MIT
/* Shading: the light that each pixel sends to the eye, from the pieces of its four samples. */
#ifndef QNI_VIEW_SHADE_H
#define QNI_VIEW_SHADE_H

#include "view/raster.h"

/* Light is linear here (not yet sRGB). What falls from everywhere is kept apart, for creases get
 * less of it. */
typedef struct qni_pixel {
    float direct[3], ambient[3];
    float normal[3]; /* in camera coordinates, of the nearest sample */
    float inverse;   /* of the nearest sample; 0: background */
    float covered;   /* share of the samples that see the mesh */
} qni_pixel;

typedef struct qni_scene {
    const qn_context *context;
    const qn_mesh_view *view;
    const qni_camera *camera;
    const qni_seen *seen;
    const qni_visible *visible;
    bool edges;
    bool flat;
} qni_scene;

/* pixels: [height][width], the bottom row first, for rows [first, last). */
void qni_shade_rows(const qni_scene *scene, int32_t first, int32_t last, qni_pixel *pixels);
/* Add the occlusion (1: open, 0: closed in), the background and the sRGB curve; the top row comes
 * first. */
void qni_develop(const qn_context *context, int32_t width, int32_t height, const qni_pixel *pixels,
                 const float *open, uint8_t *rgb);

#endif
