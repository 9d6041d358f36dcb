// SPDX-License-Identifier: MIT
/* Any bytes as raw samples: the first eight choose shape, type, byte order and header. The
 * statistics of the samples are taken as well. */
#include "fuzz_volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    if (size < 8)
        return 0;
    for (int a = 0; a < 3; ++a)
        options.raw_size[a] = data[a] ? data[a] : INT32_MAX;
    options.raw_scalar = (qn_scalar)(data[3] % QN_SCALAR_COUNT);
    options.raw_big_endian = data[4] & 1;
    options.raw_header = (int64_t)data[5] << (data[6] % 56);
    fuzz_volume("x.raw", data + 8, size - 8, &options, true);
    return 0;
}
