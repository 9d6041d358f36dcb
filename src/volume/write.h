// SPDX-License-Identifier: MIT
/* Writers of volumes. */
#ifndef QNI_VOLUME_WRITE_H
#define QNI_VOLUME_WRITE_H

#include <qn/volume.h>

qn_status qni_write_vdb(qn_context *context, const qn_volume *volume, const char *path,
                        qn_error *error);

#endif
