// SPDX-License-Identifier: MIT
/* Tiles of plain samples: where emission reads the volume. Rows have a fixed length, so compilers
 * unroll the plain form; with AVX2 a row is three vectors of four, the last two overlapping. Both
 * give the same bits. */
#include "volume/field_rows.h"

#include <string.h>

#if defined(__x86_64__)
#include <immintrin.h>
#define HAVE_AVX2_TILES 1
#else
#define HAVE_AVX2_TILES 0
#endif

#define PLAIN_TILE(name, type, text)                                                               \
    static void plain_tile_##name(const char *from, const int64_t stride[3], double isovalue,      \
                                  double tile[QNI_TILE][QNI_TILE][QNI_TILE]) {                     \
        for (int z = 0; z < QNI_TILE; ++z)                                                         \
            for (int y = 0; y < QNI_TILE; ++y) {                                                   \
                const type *stored = (const void *)(from + z * stride[2] + y * stride[1]);         \
                double *row = tile[z][y];                                                          \
                for (int x = 0; x < QNI_TILE; ++x)                                                 \
                    row[x] = (double)stored[x] - isovalue;                                         \
            }                                                                                      \
    }
QN_SCALAR_MAP(PLAIN_TILE)
#undef PLAIN_TILE

#if HAVE_AVX2_TILES
#define AVX2 __attribute__((target("avx2")))

AVX2 static inline __m256d four_U8(const uint8_t *p) {
    int32_t bytes;
    memcpy(&bytes, p, sizeof bytes);
    return _mm256_cvtepi32_pd(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(bytes)));
}

AVX2 static inline __m256d four_I8(const int8_t *p) {
    int32_t bytes;
    memcpy(&bytes, p, sizeof bytes);
    return _mm256_cvtepi32_pd(_mm_cvtepi8_epi32(_mm_cvtsi32_si128(bytes)));
}

AVX2 static inline __m256d four_U16(const uint16_t *p) {
    return _mm256_cvtepi32_pd(
        _mm_cvtepu16_epi32(_mm_loadl_epi64((const __m128i *)(const void *)p)));
}

AVX2 static inline __m256d four_I16(const int16_t *p) {
    return _mm256_cvtepi32_pd(
        _mm_cvtepi16_epi32(_mm_loadl_epi64((const __m128i *)(const void *)p)));
}

AVX2 static inline __m256d four_I32(const int32_t *p) {
    return _mm256_cvtepi32_pd(_mm_loadu_si128((const __m128i *)(const void *)p));
}

AVX2 static inline __m256d four_F32(const float *p) {
    return _mm256_cvtps_pd(_mm_loadu_ps(p));
}

#define AVX2_TILE(name, type)                                                                      \
    AVX2 static void avx2_tile_##name(const char *from, const int64_t stride[3], double isovalue,  \
                                      double tile[QNI_TILE][QNI_TILE][QNI_TILE]) {                 \
        const __m256d iso = _mm256_set1_pd(isovalue);                                              \
        for (int z = 0; z < QNI_TILE; ++z)                                                         \
            for (int y = 0; y < QNI_TILE; ++y) {                                                   \
                const type *stored = (const void *)(from + z * stride[2] + y * stride[1]);         \
                double *row = tile[z][y];                                                          \
                _mm256_storeu_pd(row, _mm256_sub_pd(four_##name(stored), iso));                    \
                _mm256_storeu_pd(row + 4, _mm256_sub_pd(four_##name(stored + 4), iso));            \
                _mm256_storeu_pd(row + 7, _mm256_sub_pd(four_##name(stored + 7), iso));            \
            }                                                                                      \
    }
AVX2_TILE(U8, uint8_t)
AVX2_TILE(I8, int8_t)
AVX2_TILE(U16, uint16_t)
AVX2_TILE(I16, int16_t)
AVX2_TILE(I32, int32_t)
AVX2_TILE(F32, float)
#undef AVX2_TILE
#endif

typedef void load_tile(const char *from, const int64_t stride[3], double isovalue,
                       double tile[QNI_TILE][QNI_TILE][QNI_TILE]);

static load_tile *loader_of(qn_scalar scalar) {
#define PLAIN_ENTRY(name, type, text) [QN_##name] = plain_tile_##name,
    static load_tile *const plain[QN_SCALAR_COUNT] = {QN_SCALAR_MAP(PLAIN_ENTRY)};
#if HAVE_AVX2_TILES
    static load_tile *const avx2[QN_SCALAR_COUNT] = {
        [QN_U8] = avx2_tile_U8,   [QN_I8] = avx2_tile_I8,   [QN_U16] = avx2_tile_U16,
        [QN_I16] = avx2_tile_I16, [QN_I32] = avx2_tile_I32, [QN_F32] = avx2_tile_F32};
    if (avx2[scalar] && __builtin_cpu_supports("avx2"))
        return avx2[scalar];
#endif
    return plain[scalar];
}

bool qni_grid_load_plain_tile(const qni_field *field, const int64_t from[3],
                              double tile[QNI_TILE][QNI_TILE][QNI_TILE]) {
    const qn_grid *grid = field->grid;
    if (!field->direct || grid->scalar == QN_F64 || grid->slope != 1 || grid->intercept != 0)
        return false;
    const char *at = (const char *)grid->samples + from[0] * grid->stride[0] +
                     from[1] * grid->stride[1] + from[2] * grid->stride[2];
    loader_of(grid->scalar)(at, grid->stride, field->isovalue, tile);
    return true;
}
