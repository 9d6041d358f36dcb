// SPDX-License-Identifier: MIT
/* Mitsuba grids (.vol, version 3): 48 bytes of header, then float samples, x fastest. The outermost
 * samples lie on the faces of the header's box, as a signed distance grid means it. */
#include "core/status.h"
#include "volume/load.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { HEADER_SIZE = 48, ENCODING_FLOAT32 = 1 };

static uint32_t little_endian(const unsigned char *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static double little_endian_float(const unsigned char *bytes) {
    uint32_t bits = little_endian(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

qn_status qni_read_mitsuba(qni_source *source, const qn_volume_read_options *options,
                           qn_volume **volume_out, qn_error *error) {
    unsigned char header[HEADER_SIZE];
    QN_TRY(qni_source_read(source, header, sizeof header, error));
    if (memcmp(header, "VOL\x03", 4) != 0)
        return qni_source_fail(source, error,
                               "does not begin with the mark of a Mitsuba grid, version 3");
    uint32_t encoding = little_endian(header + 4), channels = little_endian(header + 20);
    if (encoding != ENCODING_FLOAT32 || channels != 1)
        return qni_source_fail(
            source, error,
            "is a Mitsuba grid of encoding %u with %u channels; encoding 1 (float32) with "
            "one channel is read",
            encoding, channels);
    qn_grid grid = {.slope = 1, .scalar = QN_F32, .swapped = qni_machine_is_big_endian()};
    for (int a = 0; a < 3; ++a) {
        double low = little_endian_float(header + 24 + 4 * a);
        double high = little_endian_float(header + 36 + 4 * a);
        if (!isfinite(low) || !(high - low >= (double)FLT_MIN)) {
            low =
                0; /* integers stand there in some files: the unit cube, where Mitsuba puts grids */
            high = 1;
        }
        grid.size[a] = (int32_t)little_endian(header + 8 + 4 * a);
        grid.index_to_world[a][a] =
            (high - low) / (double)(grid.size[a] > 1 ? grid.size[a] - 1 : 1);
        grid.index_to_world[a][3] = low;
    }
    grid.index_to_world[3][3] = 1;
    QN_TRY(qni_load_overrides(source, options, grid.index_to_world, error));
    return qni_load(source, &grid, QNI_BINARY, "mitsuba", NULL, volume_out, error);
}
