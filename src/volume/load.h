// SPDX-License-Identifier: MIT
/* From a header to a volume: what all readers share, and the readers themselves. */
#ifndef QNI_VOLUME_LOAD_H
#define QNI_VOLUME_LOAD_H

#include "volume/source.h"

#include <qn/volume.h>

typedef enum qni_encoding { QNI_BINARY, QNI_TEXT } qni_encoding;

/* Put the spacing and origin of the options, where given, into a matrix whose columns are the
 * file's axes. Fails when a direction is zero, so that it cannot be scaled. */
qn_status qni_load_overrides(const qni_source *source, const qn_volume_read_options *options,
                             double matrix[4][4], qn_error *error);
/* Bytes of the packed samples; fails when a size is below 1, too large, or the product overflows.
 */
qn_status qni_load_bytes(const qni_source *source, const qn_grid *grid, int64_t *bytes_out,
                         qn_error *error);
/* Read the packed samples that come next in `source` and make the volume. Sizes are checked against
 * what the source can hold before memory is asked for. *more_out, which may be NULL, tells whether
 * bytes follow. */
qn_status qni_load(qni_source *source, qn_grid *grid, qni_encoding encoding, const char *format,
                   bool *more_out, qn_volume **volume_out, qn_error *error);

static inline bool qni_machine_is_big_endian(void) {
    return __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
}

/* A reader: the source stands at its first byte, the options were checked. */
typedef qn_status qni_reader(qni_source *source, const qn_volume_read_options *options,
                             qn_volume **volume_out, qn_error *error);
qni_reader qni_read_nifti;
qni_reader qni_read_nrrd;
qni_reader qni_read_metaimage;
qni_reader qni_read_npy;
qni_reader qni_read_raw;
qni_reader qni_read_inr;
qni_reader qni_read_mitsuba;

/* qn_volume_read() of borrowed bytes; `name` stands for the path. */
qn_status qni_volume_read_memory(qn_context *context, const char *name, const void *bytes,
                                 int64_t size, const qn_volume_read_options *options,
                                 qn_volume **volume_out, qn_error *error);

#endif
