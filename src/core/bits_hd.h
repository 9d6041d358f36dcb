// SPDX-License-Identifier: MIT
/* Counting bits, and adding to what many threads share, for the processor and the GPU. */
#ifndef QNI_CORE_BITS_HD_H
#define QNI_CORE_BITS_HD_H

#include "core/hd.h"

#include <stdint.h>
#include <string.h>

QN_HD_INLINE int qni_count_bits(uint64_t bits) {
#ifdef __CUDA_ARCH__
    return __popcll(bits);
#elif defined(__POPCNT__) || defined(__aarch64__)
    return __builtin_popcountll(bits);
#else /* where that is a call: sums of pairs, of fours and of bytes */
    bits -= bits >> 1 & UINT64_C(0x5555555555555555);
    bits = (bits & UINT64_C(0x3333333333333333)) + (bits >> 2 & UINT64_C(0x3333333333333333));
    bits = (bits + (bits >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f);
    return (int)(bits * UINT64_C(0x0101010101010101) >> 56);
#endif
}

/* How many bits of a mask lie below bit `bit`, 0 to 63. */
QN_HD_INLINE int qni_bits_below(uint64_t mask, int bit) {
    return qni_count_bits(mask & ((UINT64_C(1) << bit) - 1));
}

/* Sums and unions of whole numbers come out the same in any order, so these decide no place. */
QN_HD_INLINE void qni_shared_add(uint64_t *sum, uint64_t part) {
#ifdef __CUDA_ARCH__
    atomicAdd((unsigned long long *)sum, (unsigned long long)part);
#else
    *sum += part;
#endif
}

/* A byte that others may change meanwhile. */
QN_HD_INLINE int qni_byte_now(const uint8_t *byte) {
    return *(const volatile uint8_t *)byte;
}

/* bytes[at] += change, for changes that neither overflow nor underflow a byte, in any order; the
 * bytes fill whole words. */
QN_HD_INLINE void qni_shared_add_byte(uint8_t *bytes, size_t at, int change) {
#ifdef __CUDA_ARCH__
    atomicAdd((unsigned *)bytes + at / 4, (unsigned)change << (8 * (at % 4)));
#else
    bytes[at] = (uint8_t)(bytes[at] + change);
#endif
}

QN_HD_INLINE void qni_shared_or(uint32_t *bits, uint32_t more) {
#ifdef __CUDA_ARCH__
    atomicOr(bits, more);
#else
    *bits |= more;
#endif
}

/* Doubles from 0 on are ordered as their bits are. */
QN_HD_INLINE void qni_shared_largest(uint64_t *largest_bits, double value) {
#ifdef __CUDA_ARCH__
    const unsigned long long bits = (unsigned long long)__double_as_longlong(value);
    if (bits > *largest_bits)
        atomicMax((unsigned long long *)largest_bits, bits);
#else
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    *largest_bits = bits > *largest_bits ? bits : *largest_bits;
#endif
}

#endif
