// SPDX-License-Identifier: MIT
/* OpenVDB's and NanoVDB's leaves run z fastest (sample 64 x + 8 y + z), Quoin's x fastest (x + 8 y
 * + 64 z). For C and C++. */
#ifndef QNI_VOLUME_LEAF_ORDER_H
#define QNI_VOLUME_LEAF_ORDER_H

#include <stdint.h>
#include <string.h>

/* Where sample n of the one order is in the other; it is its own inverse. */
static inline int qni_leaf_turned(int n) {
    return n >> 6 | (n & 0x38) | (n & 7) << 6;
}

/* An active mask: from word x, bit 8 y + z to word z, bit x + 8 y. */
static inline void qni_leaf_turn_mask(const uint64_t in[8], uint64_t out[8]) {
    memset(out, 0, 8 * sizeof *out);
    for (unsigned x = 0; x < 8; ++x)
        for (unsigned y = 0; y < 8; ++y)
            for (unsigned bits = (unsigned)(in[x] >> (8 * y) & 0xff); bits; bits &= bits - 1)
                out[__builtin_ctz(bits)] |= UINT64_C(1) << (x + 8 * y);
}

#endif
