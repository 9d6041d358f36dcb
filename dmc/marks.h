// SPDX-License-Identifier: MIT
/* Quads that are marked as gone, eight at a time. */
#ifndef QNI_DMC_MARKS_H
#define QNI_DMC_MARKS_H

#include <stdint.h>
#include <string.h>

/* Which of the marks from `at` on, eight or up to the end, are 255: the highest bit of each byte.
 */
static inline uint64_t qni_gone_among(const uint8_t *marks, int64_t at, int64_t end) {
    const uint64_t low = UINT64_C(0x7f7f7f7f7f7f7f7f);
    uint64_t eight = 0;
    if (at + 8 <= end)
        memcpy(&eight, marks + at, sizeof eight);
    else
        memcpy(&eight, marks + at, (size_t)(end - at));
    eight = ~eight;
    return ~(((eight & low) + low) | eight | low);
}

/* Where the lowest bit of them was read from. */
static inline int qni_first_gone(uint64_t gone) {
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    return __builtin_ctzll(gone) >> 3;
#else
    return 7 - (__builtin_ctzll(gone) >> 3);
#endif
}

#endif
