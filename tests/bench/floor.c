// SPDX-License-Identifier: MIT
/* What no surfacer can beat: reading every sample once, and writing the mesh into fresh memory.
 * Both are run in the process, at the time and on the number of threads of what they are compared
 * with. */
#include "bench/bench.h"

#include <pthread.h>
#include <string.h>
#include <sys/mman.h>

#if defined(__x86_64__)
#include <immintrin.h>
#define HAVE_X86 1
#endif

enum { MAX_THREADS = 64, BLOCK = 64 /* samples packed into one 64-bit word */ };

/* Each function packs whole words of 64 samples: bit n is sample n >= limit. */
typedef void pack_function(const void *samples, int64_t words, double limit, uint64_t *bits);

/* The least stored whole number that is >= limit. */
static int64_t whole_limit(double limit) {
    int64_t low = (int64_t)limit;
    return (double)low < limit ? low + 1 : low;
}

#define PACK_PLAIN(name, type, load)                                                               \
    static void plain_##name(const void *samples, int64_t words, double limit, uint64_t *bits) {   \
        const type *p = samples;                                                                   \
        for (int64_t w = 0; w < words; ++w) {                                                      \
            uint64_t word = 0;                                                                     \
            for (int n = 0; n < BLOCK; ++n)                                                        \
                word |= (uint64_t)((double)(type)load(p[BLOCK * w + n]) >= limit) << n;            \
            bits[w] = word;                                                                        \
        }                                                                                          \
    }
PACK_PLAIN(u8, uint8_t, )
PACK_PLAIN(u16, uint16_t, )
PACK_PLAIN(u16_swapped, uint16_t, __builtin_bswap16)
PACK_PLAIN(i16, int16_t, )
PACK_PLAIN(f32, float, )

#ifdef HAVE_X86
#define AVX512 __attribute__((target("avx512f,avx512bw")))
#define AVX2   __attribute__((target("avx2")))

AVX512 static void avx512_u8(const void *samples, int64_t words, double limit, uint64_t *bits) {
    const uint8_t *p = samples;
    const __m512i least = _mm512_set1_epi8((char)whole_limit(limit));
    for (int64_t w = 0; w < words; ++w)
        bits[w] = _mm512_cmpge_epu8_mask(_mm512_loadu_si512(p + BLOCK * w), least);
}

AVX512 static void avx512_u16(const void *samples, int64_t words, double limit, uint64_t *bits) {
    const uint16_t *p = samples;
    const __m512i least = _mm512_set1_epi16((short)whole_limit(limit));
    for (int64_t w = 0; w < words; ++w) {
        const uint64_t low = _mm512_cmpge_epu16_mask(_mm512_loadu_si512(p + BLOCK * w), least);
        bits[w] =
            low | (uint64_t)_mm512_cmpge_epu16_mask(_mm512_loadu_si512(p + BLOCK * w + 32), least)
                      << 32;
    }
}

AVX512 static void avx512_u16_swapped(const void *samples, int64_t words, double limit,
                                      uint64_t *bits) {
    const uint16_t *p = samples;
    const __m512i least = _mm512_set1_epi16((short)whole_limit(limit));
    const __m512i swap =
        _mm512_broadcast_i32x4(_mm_set_epi8(14, 15, 12, 13, 10, 11, 8, 9, 6, 7, 4, 5, 2, 3, 0, 1));
    for (int64_t w = 0; w < words; ++w) {
        const __m512i a = _mm512_shuffle_epi8(_mm512_loadu_si512(p + BLOCK * w), swap);
        const __m512i b = _mm512_shuffle_epi8(_mm512_loadu_si512(p + BLOCK * w + 32), swap);
        bits[w] = _mm512_cmpge_epu16_mask(a, least) | (uint64_t)_mm512_cmpge_epu16_mask(b, least)
                                                          << 32;
    }
}

AVX512 static void avx512_i16(const void *samples, int64_t words, double limit, uint64_t *bits) {
    const int16_t *p = samples;
    const __m512i least = _mm512_set1_epi16((short)whole_limit(limit));
    for (int64_t w = 0; w < words; ++w) {
        const uint64_t low = _mm512_cmpge_epi16_mask(_mm512_loadu_si512(p + BLOCK * w), least);
        bits[w] =
            low | (uint64_t)_mm512_cmpge_epi16_mask(_mm512_loadu_si512(p + BLOCK * w + 32), least)
                      << 32;
    }
}

AVX512 static void avx512_f32(const void *samples, int64_t words, double limit, uint64_t *bits) {
    const float *p = samples;
    const __m512 least = _mm512_set1_ps((float)limit);
    for (int64_t w = 0; w < words; ++w) {
        uint64_t word = 0;
        for (int n = 0; n < 4; ++n)
            word |= (uint64_t)_mm512_cmp_ps_mask(_mm512_loadu_ps(p + BLOCK * w + 16 * n), least,
                                                 _CMP_GE_OQ)
                    << (16 * n);
        bits[w] = word;
    }
}

AVX2 static void avx2_u8(const void *samples, int64_t words, double limit, uint64_t *bits) {
    const uint8_t *p = samples;
    const __m256i least = _mm256_set1_epi8((char)whole_limit(limit));
    for (int64_t w = 0; w < words; ++w) {
        uint64_t word = 0;
        for (int n = 0; n < 2; ++n) {
            const __m256i v =
                _mm256_loadu_si256((const __m256i *)(const void *)(p + BLOCK * w + 32 * n));
            const __m256i above = _mm256_cmpeq_epi8(_mm256_max_epu8(v, least), v);
            word |= (uint64_t)(uint32_t)_mm256_movemask_epi8(above) << (32 * n);
        }
        bits[w] = word;
    }
}

/* Sixteen-bit samples: `flip` turns unsigned order into signed order, `swap` turns the bytes round.
 */
AVX2 static inline void avx2_words(const void *samples, int64_t words, int least_value, int flip,
                                   bool swap, uint64_t *bits) {
    const uint16_t *p = samples;
    const __m256i below_least = _mm256_set1_epi16((short)(least_value ^ flip)),
                  turn = _mm256_set1_epi16((short)flip);
    const __m256i order = _mm256_broadcastsi128_si256(
        _mm_set_epi8(14, 15, 12, 13, 10, 11, 8, 9, 6, 7, 4, 5, 2, 3, 0, 1));
    for (int64_t w = 0; w < words; ++w) {
        uint64_t word = 0;
        for (int n = 0; n < 2; ++n) {
            __m256i half[2];
            for (int h = 0; h < 2; ++h) {
                __m256i v = _mm256_loadu_si256(
                    (const __m256i *)(const void *)(p + BLOCK * w + 32 * n + 16 * h));
                v = swap ? _mm256_shuffle_epi8(v, order) : v;
                half[h] = _mm256_cmpgt_epi16(below_least, _mm256_xor_si256(v, turn));
            }
            const __m256i packed =
                _mm256_permute4x64_epi64(_mm256_packs_epi16(half[0], half[1]), 0xd8);
            word |= (uint64_t) ~(uint32_t)_mm256_movemask_epi8(packed) << (32 * n);
        }
        bits[w] = word;
    }
}

AVX2 static void avx2_u16(const void *samples, int64_t words, double limit, uint64_t *bits) {
    avx2_words(samples, words, (int)whole_limit(limit), 0x8000, false, bits);
}

AVX2 static void avx2_u16_swapped(const void *samples, int64_t words, double limit,
                                  uint64_t *bits) {
    avx2_words(samples, words, (int)whole_limit(limit), 0x8000, true, bits);
}

AVX2 static void avx2_i16(const void *samples, int64_t words, double limit, uint64_t *bits) {
    avx2_words(samples, words, (int)whole_limit(limit), 0, false, bits);
}

AVX2 static void avx2_f32(const void *samples, int64_t words, double limit, uint64_t *bits) {
    const float *p = samples;
    const __m256 least = _mm256_set1_ps((float)limit);
    for (int64_t w = 0; w < words; ++w) {
        uint64_t word = 0;
        for (int n = 0; n < 8; ++n) {
            const __m256 above =
                _mm256_cmp_ps(_mm256_loadu_ps(p + BLOCK * w + 8 * n), least, _CMP_GE_OQ);
            word |= (uint64_t)(unsigned)_mm256_movemask_ps(above) << (8 * n);
        }
        bits[w] = word;
    }
}
#endif

enum { LEVEL_PLAIN, LEVEL_AVX2, LEVEL_AVX512, LEVELS };

static int level(void) {
#ifdef HAVE_X86
    if (__builtin_cpu_supports("avx512bw"))
        return LEVEL_AVX512;
    if (__builtin_cpu_supports("avx2"))
        return LEVEL_AVX2;
#endif
    return LEVEL_PLAIN;
}

const char *bench_read_pass_name(void) {
    static const char *const names[LEVELS] = {"plain C", "AVX2", "AVX-512BW"};
    return names[level()];
}

static pack_function *pack_of(const bench_volume *volume) {
#ifdef HAVE_X86
#define PACKS(name)                                                                                \
    { plain_##name, avx2_##name, avx512_##name }
#else
#define PACKS(name)                                                                                \
    { plain_##name, plain_##name, plain_##name }
#endif
    static pack_function *const u8[LEVELS] = PACKS(u8), *const u16[LEVELS] = PACKS(u16),
                                *const swapped[LEVELS] = PACKS(u16_swapped),
                                *const i16[LEVELS] = PACKS(i16), *const f32[LEVELS] = PACKS(f32);
    switch (volume->scalar) {
    case QN_U8:
        return u8[level()];
    case QN_U16:
        return volume->swapped ? swapped[level()] : u16[level()];
    case QN_I16:
        return i16[level()];
    default:
        return f32[level()];
    }
}

/* ---- threads -----------------------------------------------------------------------------------
 */

typedef struct share {
    pack_function *pack; /* NULL: fill instead */
    const void *samples;
    double limit;
    int64_t words;
    void *out;
    int64_t bytes;
} share;

static void *do_share(void *user) {
    const share *part = user;
    if (part->pack)
        part->pack(part->samples, part->words, part->limit, part->out);
    else
        memset(part->out, 1, (size_t)part->bytes);
    return NULL;
}

/* The calling thread does the last share itself. */
static void run_shares(share *shares, int count) {
    pthread_t threads[MAX_THREADS];
    bool started[MAX_THREADS];
    for (int t = 0; t + 1 < count; ++t)
        started[t] = pthread_create(&threads[t], NULL, do_share, &shares[t]) == 0;
    do_share(&shares[count - 1]);
    for (int t = 0; t + 1 < count; ++t) {
        if (started[t])
            pthread_join(threads[t], NULL);
        else
            do_share(&shares[t]);
    }
}

void bench_read_pass(const bench_volume *volume, int threads, uint8_t *bits) {
    share shares[MAX_THREADS];
    const int64_t words = bench_sample_count(volume) / BLOCK;
    for (int t = 0; t < threads; ++t) {
        const int64_t from = words * t / threads, end = words * (t + 1) / threads;
        const char *samples = volume->samples;
        shares[t] = (share){
            pack_of(volume), samples + from * BLOCK * (int64_t)qn_scalar_size(volume->scalar),
            volume->iso,     end - from,
            bits + 8 * from, 0};
    }
    run_shares(shares, threads);
}

void bench_output_pass(int64_t bytes, int threads) {
    const size_t huge_page = (size_t)2 << 20;
    share shares[MAX_THREADS];
    const size_t mapped = (size_t)bytes + 2 * huge_page;
    char *memory = mmap(NULL, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
        return;
    char *start = memory + (huge_page - (uintptr_t)memory % huge_page) % huge_page;
#ifdef MADV_HUGEPAGE
    madvise(start, ((size_t)bytes + huge_page - 1) / huge_page * huge_page, MADV_HUGEPAGE);
#endif
    for (int t = 0; t < threads; ++t) {
        const int64_t from = bytes * t / threads, end = bytes * (t + 1) / threads;
        shares[t] = (share){NULL, NULL, 0, 0, start + from, end - from};
    }
    run_shares(shares, threads);
    munmap(memory, mapped);
}
