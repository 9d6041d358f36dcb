// SPDX-License-Identifier: MIT
/* A NanoVDB grid in memory, as its file holds it, turned into leaves and tiles. */
#ifndef QNI_VOLUME_NVDB_H
#define QNI_VOLUME_NVDB_H

#include "volume/load.h"

/* The name of a NanoVDB grid type ("float", "vec3f"); `scalar_out` gets what its samples are read
 * as, and false is returned when they are not. */
bool qni_nvdb_type(uint32_t type, const char **name_out, qn_scalar *scalar_out);

/* Make a volume of a grid of `size` bytes, which lie 8-byte aligned. Nothing in them is trusted. */
qn_status qni_nvdb_load(const qni_source *source, const void *bytes, int64_t size, const char *name,
                        const qn_volume_read_options *options, qn_volume **volume_out,
                        qn_error *error);

#endif
