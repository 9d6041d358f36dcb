// SPDX-License-Identifier: MIT
/* Pixels into a PNG file. */
#ifndef QNI_VIEW_PICTURE_H
#define QNI_VIEW_PICTURE_H

#include <qn/base.h>

/* rgb: [height][width][3], the top row first. The file appears whole or not at all.
 * QN_ERROR_UNSUPPORTED  built without libpng
 * QN_ERROR_OUTPUT       the file cannot be written */
qn_status qni_picture_write(qn_context *context, const char *path, int32_t width, int32_t height,
                            const uint8_t *rgb, qn_error *error);
/* QN_ERROR_UNSUPPORTED when pictures are not built in: to be asked before any work is done. */
qn_status qni_picture_supported(qn_error *error);

#endif
