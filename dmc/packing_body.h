// SPDX-License-Identifier: MIT
/* The inner loops of packing, included once for each instruction set (kernel_*.c). They have no
 * branches on the marks, since which vertices go is hard to foresee. */
#include "dmc/dmc.h"
#include "dmc/simplify_hd.h"

#include <string.h>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

/* What is read in order is asked for a page ahead: the processor does not look beyond one itself.
 */
enum { PACKED_TOGETHER = 16, POINTS_AHEAD = 1024 };

/* Four numbers for three where `wide`: what comes after them is read already, or stays as it is. */
static inline void move_point(float *points, int64_t from, int64_t to, bool wide) {
    float held[4];
    memcpy(held, points + 3 * from, wide ? sizeof held : 3 * sizeof *held);
    memcpy(points + 3 * to, held, wide ? sizeof held : 3 * sizeof *held);
}

static int64_t squeeze_singly(float *points, const uint8_t *marks, int64_t v, int64_t end,
                              int64_t to) {
    for (; v < end - 1; ++v) {
        move_point(points, v, to, true);
        to += marks[v] != QNI_VALENCE_GONE;
    }
    if (v < end) {
        move_point(points, v, to, false);
        to += marks[v] != QNI_VALENCE_GONE;
    }
    return to;
}

static inline uint32_t pick(uint32_t mask, uint32_t first, uint32_t second) {
    return (first & mask) | (second & ~mask);
}

static void number_singly(const uint8_t *marks, int64_t v, int64_t end, uint32_t next, bool follow,
                          uint32_t *renumber) {
    const uint32_t followed = follow ? ~UINT32_C(0) : 0;
    for (; v < end; ++v) {
        const uint32_t stays = marks[v] != QNI_VALENCE_GONE, goes = stays - 1;
        const uint32_t kept = pick(goes & followed, renumber[v], (uint32_t)v);
        renumber[v] = pick(goes, renumber[kept], next);
        next += stays;
    }
}

#ifdef __AVX512F__
/* One bit each: whether the vertex stays. */
static inline unsigned staying(const uint8_t *marks) {
    const __m128i own = _mm_loadu_si128((const __m128i *)(const void *)marks);
    const __m128i gone = _mm_cmpeq_epi8(own, _mm_set1_epi8((char)QNI_VALENCE_GONE));
    return ~(unsigned)_mm_movemask_epi8(gone) & 0xffff;
}

/* 48 numbers of 16 vertices at once; all are read before any is written. */
static int64_t squeeze(float *points, const uint8_t *marks, int64_t v, int64_t end) {
    int32_t vertex_of_lane[3 * PACKED_TOGETHER];
    float *to = points + 3 * v;
    for (int n = 0; n < 3 * PACKED_TOGETHER; ++n)
        vertex_of_lane[n] = 1 << n / 3;
    for (; v + PACKED_TOGETHER <= end; v += PACKED_TOGETHER) {
        const __m512i stay = _mm512_set1_epi32((int)staying(marks + v));
        __m512 part[3];
        for (int n = 0; n < 3; ++n) {
            part[n] = _mm512_loadu_ps(points + 3 * v + 16 * n);
            __builtin_prefetch(points + 3 * v + 16 * n + POINTS_AHEAD);
        }
        for (int n = 0; n < 3; ++n) {
            const __mmask16 mask =
                _mm512_test_epi32_mask(stay, _mm512_loadu_si512(vertex_of_lane + 16 * n));
            _mm512_storeu_ps(to, _mm512_maskz_compress_ps(mask, part[n]));
            to += __builtin_popcount(mask);
        }
    }
    return squeeze_singly(points, marks, v, end, (to - points) / 3);
}

/* Those that stay are numbered some hundred at a time, then those that are gone follow: which are
 * is hard to foresee, so they are listed without a look at each. */
static void number(const uint8_t *marks, int64_t v, int64_t end, uint32_t next, bool follow,
                   uint32_t *renumber) {
    enum { LISTED = 1024 };
    const __m512i count = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    uint32_t gone[LISTED + PACKED_TOGETHER];
    while (v + PACKED_TOGETHER <= end) {
        uint32_t *of = renumber + v, some = 0, at = 0;
        for (; at < LISTED && v + PACKED_TOGETHER <= end; v += PACKED_TOGETHER) {
            const unsigned stay = staying(marks + v);
            const __mmask16 goes = (__mmask16)~stay;
            const __m512i own = _mm512_add_epi32(_mm512_maskz_expand_epi32((__mmask16)stay, count),
                                                 _mm512_set1_epi32((int)next));
            _mm512_mask_storeu_epi32(of + at, (__mmask16)stay, own);
            next += (uint32_t)__builtin_popcount(stay);
            _mm512_storeu_si512(gone + some,
                                _mm512_maskz_compress_epi32(
                                    goes, _mm512_add_epi32(count, _mm512_set1_epi32((int)at))));
            some += (uint32_t)__builtin_popcount(goes);
            at += PACKED_TOGETHER;
        }
        for (uint32_t n = 0; follow && n < some; ++n)
            of[gone[n]] = renumber[of[gone[n]]];
    }
    number_singly(marks, v, end, next, follow, renumber);
}
#else
static int64_t squeeze(float *points, const uint8_t *marks, int64_t v, int64_t end) {
    int64_t to = v;
    for (; v + PACKED_TOGETHER < end; v += PACKED_TOGETHER) {
        for (int n = 0; n < 3; ++n)
            __builtin_prefetch(points + 3 * v + 16 * n + POINTS_AHEAD);
        to = squeeze_singly(points, marks, v, v + PACKED_TOGETHER, to);
    }
    return squeeze_singly(points, marks, v, end, to);
}

static void number(const uint8_t *marks, int64_t v, int64_t end, uint32_t next, bool follow,
                   uint32_t *renumber) {
    number_singly(marks, v, end, next, follow, renumber);
}
#endif

qni_squeeze_kernel KERNEL(qni_squeeze);

void KERNEL(qni_squeeze)(float *points, const uint8_t *marks, int64_t from, int64_t end) {
    squeeze(points, marks, from, end);
}

qni_number_kernel KERNEL(qni_number);

void KERNEL(qni_number)(const uint8_t *marks, int64_t from, int64_t end, uint32_t first,
                        bool follow, uint32_t *renumber) {
    number(marks, from, end, first, follow, renumber);
}
