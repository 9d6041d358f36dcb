// SPDX-License-Identifier: MIT
/* Soft dark in creases and hollows, guessed from the depths round each pixel. */
#ifndef QNI_VIEW_OCCLUSION_H
#define QNI_VIEW_OCCLUSION_H

#include "view/shade.h"

/* open: [height][width], 1 where nothing is near, towards 0 where the surface is closed in.
 * rough: room of the same size. */
void qni_find_occlusion(const qn_context *context, const qni_camera *camera, int32_t width,
                        int32_t height, const qni_pixel *pixels, float *rough, float *open);

#endif
