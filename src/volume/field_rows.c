// SPDX-License-Identifier: MIT
/* Rows of samples by type: conversion to values, the stored threshold, packing of signs (SSE2 where
 * there is). */
#include "volume/field_rows.h"

#include <math.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* ---- conversion ------------------------------------------------------------------------------ */

#define LOAD_CONTIGUOUS(name, type, text)                                                          \
    static void load_##name(const void *from, int64_t count, double *out) {                        \
        const type *stored = from;                                                                 \
        for (int64_t n = 0; n < count; ++n)                                                        \
            out[n] = (double)stored[n];                                                            \
    }
QN_SCALAR_MAP(LOAD_CONTIGUOUS)
#undef LOAD_CONTIGUOUS

static bool row_is_plain(const qn_grid *grid, const void *from) {
    const size_t size = qn_scalar_size(grid->scalar); /* a power of two */
    return !grid->swapped && grid->stride[0] == (int64_t)size &&
           ((uintptr_t)from & (size - 1)) == 0;
}

static void scale(const qn_grid *grid, int64_t count, double *out) {
    if (grid->slope != 1 || grid->intercept != 0)
        for (int64_t n = 0; n < count; ++n) {
            double scaled = grid->slope * out[n];
            out[n] = scaled + grid->intercept;
        }
}

void qni_samples_load(qn_scalar scalar, const void *from, int64_t count, double *out) {
    switch (scalar) {
#define LOAD_CASE(name, type, text)                                                                \
    case QN_##name:                                                                                \
        load_##name(from, count, out);                                                             \
        break;
        QN_SCALAR_MAP(LOAD_CASE)
#undef LOAD_CASE
    case QN_SCALAR_COUNT:
        break;
    }
}

#define LOAD_RUNS(name, type, text)                                                                \
    static void load_runs_##name(const qn_grid *grid, const char *from, const qni_run *runs,       \
                                 int count, double *out) {                                         \
        for (int r = 0; r < count; ++r) {                                                          \
            const type *row = (const type *)(const void *)(from + runs[r].y * grid->stride[1] +    \
                                                           runs[r].z * grid->stride[2]);           \
            for (int n = 0; n < runs[r].count; ++n)                                                \
                *out++ = (double)row[runs[r].x + n];                                               \
        }                                                                                          \
    }
QN_SCALAR_MAP(LOAD_RUNS)
#undef LOAD_RUNS

/* Rows are aligned when the first is and they lie whole samples apart. */
static bool runs_are_plain(const qn_grid *grid, const void *from) {
    const int64_t size = (int64_t)qn_scalar_size(grid->scalar);
    return row_is_plain(grid, from) && ((grid->stride[1] | grid->stride[2]) & (size - 1)) == 0;
}

int qni_grid_load_plain_runs(const qn_grid *grid, const int64_t at[3], const qni_run *runs,
                             int count, double *out) {
    const char *from = (const char *)grid->samples + at[0] * grid->stride[0] +
                       at[1] * grid->stride[1] + at[2] * grid->stride[2];
    int values = 0;
    if (!runs_are_plain(grid, from))
        return 0;
    switch (grid->scalar) {
#define LOAD_CASE(name, type, text)                                                                \
    case QN_##name:                                                                                \
        load_runs_##name(grid, from, runs, count, out);                                            \
        break;
        QN_SCALAR_MAP(LOAD_CASE)
#undef LOAD_CASE
    case QN_SCALAR_COUNT:
        return 0;
    }
    for (int r = 0; r < count; ++r)
        values += runs[r].count;
    scale(grid, values, out);
    return values;
}

/* In the fewest steps, for points here and there. */
#define LOAD_CELL(name, type, text)                                                                \
    static bool load_cell_##name(const qn_grid *grid, const char *from, double corner[8]) {        \
        const int64_t size = sizeof(type), y = grid->stride[1], z = grid->stride[2];               \
        if (grid->stride[0] != size || ((int64_t)(uintptr_t)from | y | z) & (size - 1))            \
            return false;                                                                          \
        for (int n = 0; n < 4; ++n) {                                                              \
            const type *row = (const type *)(const void *)(from + (n & 1) * y + (n >> 1) * z);     \
            corner[2 * n] = (double)row[0];                                                        \
            corner[2 * n + 1] = (double)row[1];                                                    \
        }                                                                                          \
        return true;                                                                               \
    }
QN_SCALAR_MAP(LOAD_CELL)
#undef LOAD_CELL

bool qni_grid_load_plain_cell(const qn_grid *grid, const int64_t at[3], double corner[8]) {
    const char *from = (const char *)grid->samples + at[0] * grid->stride[0] +
                       at[1] * grid->stride[1] + at[2] * grid->stride[2];
    bool good = false;
    if (grid->swapped)
        return false;
    switch (grid->scalar) {
#define LOAD_CASE(name, type, text)                                                                \
    case QN_##name:                                                                                \
        good = load_cell_##name(grid, from, corner);                                               \
        break;
        QN_SCALAR_MAP(LOAD_CASE)
#undef LOAD_CASE
    case QN_SCALAR_COUNT:
        break;
    }
    if (good)
        scale(grid, 8, corner);
    return good;
}

#define LOAD_CELLS(name, type, text)                                                               \
    static void load_cells_##name(const qn_grid *grid, const char *const *from, int count,         \
                                  double(*corner)[QNI_CELLS_TOGETHER]) {                           \
        const int64_t y = grid->stride[1], z = grid->stride[2];                                    \
        for (int n = 0; n < count; ++n)                                                            \
            for (int r = 0; r < 4; ++r) {                                                          \
                const type *row =                                                                  \
                    (const type *)(const void *)(from[n] + (r & 1) * y + (r >> 1) * z);            \
                corner[2 * r][n] = (double)row[0];                                                 \
                corner[2 * r + 1][n] = (double)row[1];                                             \
            }                                                                                      \
    }
QN_SCALAR_MAP(LOAD_CELLS)
#undef LOAD_CELLS

bool qni_grid_load_plain_cells(const qn_grid *grid, const char *const from[QNI_CELLS_TOGETHER],
                               int count, double corner[8][QNI_CELLS_TOGETHER]) {
    if (!runs_are_plain(grid, grid->samples))
        return false;
    switch (grid->scalar) {
#define LOAD_CASE(name, type, text)                                                                \
    case QN_##name:                                                                                \
        load_cells_##name(grid, from, count, corner);                                              \
        break;
        QN_SCALAR_MAP(LOAD_CASE)
#undef LOAD_CASE
    case QN_SCALAR_COUNT:
        return false;
    }
    for (int c = 0; c < 8; ++c)
        scale(grid, count, corner[c]);
    return true;
}

void qni_grid_load_row(const qn_grid *grid, int64_t i, int64_t j, int64_t k, int64_t count,
                       double *out) {
    const char *from = (const char *)grid->samples + i * grid->stride[0] + j * grid->stride[1] +
                       k * grid->stride[2];
    if (!row_is_plain(grid, from)) {
        for (int64_t n = 0; n < count; ++n)
            out[n] = qni_grid_stored(grid, i + n, j, k);
    } else {
        qni_samples_load(grid->scalar, from, count, out);
    }
    scale(grid, count, out);
}

/* ---- threshold ------------------------------------------------------------------------------- */

/* Numbers of a type in ascending order, from their place in that order. Floats: the sign-magnitude
 * bits turned into a two's complement order; infinities are the ends. */
static double float_at(int64_t place) {
    uint32_t bits = place >= 0 ? (uint32_t)place : 0x80000000u | (uint32_t)(-place);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static double double_at(int64_t place) {
    uint64_t bits =
        place >= 0 ? (uint64_t)place : UINT64_C(0x8000000000000000) | (uint64_t)(-place);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double stored_at(qn_scalar scalar, int64_t place) {
    return scalar == QN_F32 ? float_at(place) : scalar == QN_F64 ? double_at(place) : (double)place;
}

static void place_range(qn_scalar scalar, int64_t *first, int64_t *last) {
    static const int64_t ends[QN_SCALAR_COUNT][2] = {
        [QN_U8] = {0, UINT8_MAX},
        [QN_I8] = {INT8_MIN, INT8_MAX},
        [QN_U16] = {0, UINT16_MAX},
        [QN_I16] = {INT16_MIN, INT16_MAX},
        [QN_U32] = {0, UINT32_MAX},
        [QN_I32] = {INT32_MIN, INT32_MAX},
        [QN_F32] = {-0x7f800000, 0x7f800000},
        [QN_F64] = {-0x7ff0000000000000, 0x7ff0000000000000},
    };
    *first = ends[scalar][0];
    *last = ends[scalar][1];
}

static bool is_above(const qni_field *field, double stored) {
    double scaled = field->grid->slope * stored;
    double value = scaled + field->grid->intercept;
    return value - field->isovalue >= 0;
}

void qni_field_set_threshold(qni_field *field) {
    const qn_grid *grid = field->grid;
    field->direct = row_is_plain(grid, grid->samples);
    for (int a = 1; a < 3; ++a)
        field->direct =
            field->direct && grid->stride[a] % (int64_t)qn_scalar_size(grid->scalar) == 0;
    field->inverted = grid->slope < 0;
    field->constant = -1;
    int64_t low, high;
    place_range(grid->scalar, &low, &high);
    /* Rounding is monotone, so the answer turns once. Find the first place where it differs from
     * `inverted`. */
    if (is_above(field, stored_at(grid->scalar, high)) == field->inverted) {
        field->constant = field->inverted;
        return;
    }
    while (low < high) {
        int64_t middle = low + (int64_t)(((uint64_t)high - (uint64_t)low) / 2);
        if (is_above(field, stored_at(grid->scalar, middle)) != field->inverted)
            high = middle;
        else
            low = middle + 1;
    }
    if (grid->scalar == QN_F32)
        field->threshold.f32 = (float)float_at(low);
    else if (grid->scalar == QN_F64)
        field->threshold.f64 = double_at(low);
    else
        field->threshold.whole = low;
}

/* ---- packing --------------------------------------------------------------------------------- */

/* Each group function gives the bits of 16 samples; `odd` collects whether one was not finite. */
#ifdef __SSE2__
static uint32_t group_U8(const uint8_t *p, uint8_t t) {
    __m128i v = _mm_loadu_si128((const __m128i *)p);
    __m128i below = _mm_subs_epu8(_mm_set1_epi8((char)t), v);
    return (uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(below, _mm_setzero_si128()));
}

static uint32_t group_I8(const int8_t *p, int8_t t) {
    __m128i v = _mm_loadu_si128((const __m128i *)p);
    return 0xffffu & ~(uint32_t)_mm_movemask_epi8(_mm_cmplt_epi8(v, _mm_set1_epi8(t)));
}

static uint32_t group_U16(const uint16_t *p, uint16_t t) {
    const __m128i limit = _mm_set1_epi16((short)t), zero = _mm_setzero_si128();
    __m128i a = _mm_cmpeq_epi16(_mm_subs_epu16(limit, _mm_loadu_si128((const __m128i *)p)), zero);
    __m128i b =
        _mm_cmpeq_epi16(_mm_subs_epu16(limit, _mm_loadu_si128((const __m128i *)(p + 8))), zero);
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(a, b));
}

static uint32_t group_I16(const int16_t *p, int16_t t) {
    const __m128i limit = _mm_set1_epi16(t);
    __m128i a = _mm_cmplt_epi16(_mm_loadu_si128((const __m128i *)p), limit);
    __m128i b = _mm_cmplt_epi16(_mm_loadu_si128((const __m128i *)(p + 8)), limit);
    return 0xffffu & ~(uint32_t)_mm_movemask_epi8(_mm_packs_epi16(a, b));
}

/* Unsigned values compare like signed ones with their top bit flipped. */
static uint32_t group_words(const void *p, int32_t t, int32_t flip) {
    const __m128i limit = _mm_set1_epi32(t), turn = _mm_set1_epi32(flip);
    __m128i less[4];
    for (int n = 0; n < 4; ++n) {
        __m128i v = _mm_loadu_si128((const __m128i *)p + n);
        less[n] = _mm_cmplt_epi32(_mm_xor_si128(v, turn), limit);
    }
    __m128i packed =
        _mm_packs_epi16(_mm_packs_epi32(less[0], less[1]), _mm_packs_epi32(less[2], less[3]));
    return 0xffffu & ~(uint32_t)_mm_movemask_epi8(packed);
}

static uint32_t group_U32(const uint32_t *p, uint32_t t) {
    return group_words(p, (int32_t)(t ^ 0x80000000u), INT32_MIN);
}

static uint32_t group_I32(const int32_t *p, int32_t t) {
    return group_words(p, t, 0);
}

static uint32_t group_F32(const float *p, float t, uint32_t *odd) {
    const __m128 limit = _mm_set1_ps(t);
    __m128i above[4];
    __m128 strange = _mm_setzero_ps();
    for (int n = 0; n < 4; ++n) {
        __m128 v = _mm_loadu_ps(p + 4 * n);
        __m128 difference = _mm_sub_ps(v, v); /* NaN unless v is finite */
        strange = _mm_or_ps(strange, _mm_cmpunord_ps(difference, difference));
        above[n] = _mm_castps_si128(_mm_cmpge_ps(v, limit));
    }
    *odd |= (uint32_t)_mm_movemask_ps(strange);
    __m128i packed =
        _mm_packs_epi16(_mm_packs_epi32(above[0], above[1]), _mm_packs_epi32(above[2], above[3]));
    return (uint32_t)_mm_movemask_epi8(packed);
}

static uint32_t group_F64(const double *p, double t, uint32_t *odd) {
    const __m128d limit = _mm_set1_pd(t);
    uint32_t bits = 0;
    for (int n = 0; n < 8; ++n) {
        __m128d v = _mm_loadu_pd(p + 2 * n);
        __m128d difference = _mm_sub_pd(v, v);
        *odd |= (uint32_t)_mm_movemask_pd(_mm_cmpunord_pd(difference, difference));
        bits |= (uint32_t)_mm_movemask_pd(_mm_cmpge_pd(v, limit)) << (2 * n);
    }
    return bits;
}
#else
#define GROUP(name, type)                                                                          \
    static uint32_t group_##name(const type *p, type t) {                                          \
        uint32_t bits = 0;                                                                         \
        for (int n = 0; n < 16; ++n)                                                               \
            bits |= (uint32_t)(p[n] >= t) << n;                                                    \
        return bits;                                                                               \
    }
#define GROUP_FLOAT(name, type)                                                                    \
    static uint32_t group_##name(const type *p, type t, uint32_t *odd) {                           \
        uint32_t bits = 0;                                                                         \
        for (int n = 0; n < 16; ++n) {                                                             \
            bits |= (uint32_t)(p[n] >= t) << n;                                                    \
            *odd |= (uint32_t)!isfinite(p[n]);                                                     \
        }                                                                                          \
        return bits;                                                                               \
    }
GROUP(U8, uint8_t)
GROUP(I8, int8_t)
GROUP(U16, uint16_t)
GROUP(I16, int16_t)
GROUP(U32, uint32_t)
GROUP(I32, int32_t)
GROUP_FLOAT(F32, float)
GROUP_FLOAT(F64, double)
#endif

static void store_group(uint8_t *bits, uint32_t group, int64_t count) {
    bits[0] = (uint8_t)(group & (count >= 8 ? 0xff : (1u << count) - 1));
    if (count > 8)
        bits[1] = (uint8_t)(group >> 8 & (count >= 16 ? 0xff : (1u << (count - 8)) - 1));
}

/* The tail that fills no group of 16 goes through a padded copy. */
#define PACK(name, type, limit, ...)                                                               \
    static uint32_t pack_##name(const qni_field *field, const void *from, int64_t count,           \
                                uint8_t *bits) {                                                   \
        const type *p = from, t = (type)(limit);                                                   \
        const uint32_t turn = field->inverted ? 0xffffu : 0;                                       \
        uint32_t odd = 0;                                                                          \
        int64_t n = 0;                                                                             \
        for (; n + 16 <= count; n += 16)                                                           \
            store_group(bits + n / 8, group_##name(p + n, t __VA_ARGS__) ^ turn, 16);              \
        if (n < count) {                                                                           \
            type last[16] = {0};                                                                   \
            memcpy(last, p + n, (size_t)(count - n) * sizeof(type));                               \
            store_group(bits + n / 8, group_##name(last, t __VA_ARGS__) ^ turn, count - n);        \
        }                                                                                          \
        return odd;                                                                                \
    }
#define AND_ODD , &odd
PACK(U8, uint8_t, field->threshold.whole)
PACK(I8, int8_t, field->threshold.whole)
PACK(U16, uint16_t, field->threshold.whole)
PACK(I16, int16_t, field->threshold.whole)
PACK(U32, uint32_t, field->threshold.whole)
PACK(I32, int32_t, field->threshold.whole)
PACK(F32, float, field->threshold.f32, AND_ODD)
PACK(F64, double, field->threshold.f64, AND_ODD)

static uint32_t pack_by_type(const qni_field *field, const void *from, int64_t count,
                             uint8_t *bits) {
    switch (field->grid->scalar) {
#define PACK_CASE(name, type, text)                                                                \
    case QN_##name:                                                                                \
        return pack_##name(field, from, count, bits);
        QN_SCALAR_MAP(PACK_CASE)
#undef PACK_CASE
    case QN_SCALAR_COUNT:
        break;
    }
    return 0;
}

static void fill_constant(uint8_t *bits, int64_t count, bool above) {
    memset(bits, above ? 0xff : 0, (size_t)(count / 8));
    if (count % 8)
        bits[count / 8] = above ? (uint8_t)((1u << (count % 8)) - 1) : 0;
}

bool qni_field_pack_samples(const qni_field *field, const void *from, int64_t count,
                            uint8_t *bits) {
    const bool odd = pack_by_type(field, from, count, bits) != 0;
    if (field->constant >= 0)
        fill_constant(bits, count, field->constant != 0);
    return odd;
}

bool qni_field_pack_row(const qni_field *field, int64_t j, int64_t k, uint8_t *bits) {
    const qn_grid *grid = field->grid;
    const char *from = (const char *)grid->samples + j * grid->stride[1] + k * grid->stride[2];
    return qni_field_pack_samples(field, from, grid->size[0], bits);
}
