// SPDX-License-Identifier: MIT
/* Passes over all samples: range and histogram kernels for each type, rows fetched straight from
 * memory where they are packed and in this machine's byte order, else through a small buffer. */
#include "volume/scan.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    PIECE = 2048, /* samples a kernel gets at once: short enough for exact sums of integers */
    LANES = 8,    /* independent sums, so that they need not wait for each other */
    /* Equal neighbours would wait for each other's count: four tables take turns, while they are
       small. */
    TABLES = 4,
    LARGEST_SPLIT = 4096
};

typedef struct bin_map {
    int64_t first;          /* exact: the integer of bin 0 */
    double half_low, scale; /* else; halves, so that no range of doubles overflows */
    int64_t last_bin;
    int64_t table_stride; /* 0: one table only */
    bool finite;          /* the samples at hand are all finite */
} bin_map;

typedef struct kernels {
    void (*range)(const void *samples, int64_t count, qni_range *range);
    void (*bin)(const void *samples, int64_t count, const bin_map *map, int64_t *counts);
    void (*count)(const void *samples, int64_t count, const bin_map *map, int64_t *counts);
} kernels;

/* ---- kernels ---- */

#if defined(_OPENMP) && !defined(__clang__) /* clang 14 warns that it cannot */
#define SIMD(text) _Pragma(#text)
#else
#define SIMD(text)
#endif

static void merge_range(qni_range *range, double low, double high, double sum) {
    range->low = low < range->low ? low : range->low;
    range->high = high > range->high ? high : range->high;
    range->sum += sum;
}

#define INTEGER_RANGE(NAME, type)                                                                  \
    static void range_##NAME(const void *samples, int64_t count, qni_range *range) {               \
        const type *at = samples;                                                                  \
        type low = at[0], high = at[0];                                                            \
        int64_t sum = 0;                                                                           \
        for (int64_t i = 0; i < count; ++i) {                                                      \
            low = at[i] < low ? at[i] : low;                                                       \
            high = at[i] > high ? at[i] : high;                                                    \
            sum += at[i];                                                                          \
        }                                                                                          \
        merge_range(range, (double)low, (double)high, (double)sum);                                \
    }                                                                                              \
    static void count_##NAME(const void *samples, int64_t count, const bin_map *map,               \
                             int64_t *counts) {                                                    \
        const type *at = samples;                                                                  \
        for (int64_t i = 0; i < count; ++i)                                                        \
            ++counts[(int64_t)at[i] - map->first + (i & (TABLES - 1)) * map->table_stride];        \
    }

/* Two loops over the same few kilobytes: minima and counts may be taken in any order, sums may not.
 */
#define REAL_RANGE(NAME, type, largest)                                                            \
    static double sum_##NAME(const type *at, int64_t count) {                                      \
        double sums[LANES] = {0};                                                                  \
        int64_t whole = count - count % LANES;                                                     \
        for (int64_t i = 0; i < whole; i += LANES)                                                 \
            for (int l = 0; l < LANES; ++l)                                                        \
                sums[l] += (double)at[i + l];                                                      \
        for (int64_t i = whole; i < count; ++i)                                                    \
            sums[i - whole] += (double)at[i];                                                      \
        double sum = 0;                                                                            \
        for (int l = 0; l < LANES; ++l)                                                            \
            sum += sums[l];                                                                        \
        return sum;                                                                                \
    }                                                                                              \
    static void range_##NAME(const void *samples, int64_t count, qni_range *range) {               \
        const type *at = samples;                                                                  \
        type low = (type)INFINITY, high = (type)-INFINITY;                                         \
        int32_t nan = 0, infinite = 0, broken = 0;                                                 \
        SIMD(omp simd reduction(min : low) reduction(max : high) reduction(+ : nan, infinite)      \
                 reduction(| : broken)) \
        for (int32_t i = 0; i < (int32_t)count; ++i) {                                             \
            type size = at[i] < 0 ? -at[i] : at[i];                                                \
            type lower = size <= largest ? at[i] : (type)INFINITY;                                 \
            type upper = size <= largest ? at[i] : (type)-INFINITY;                                \
            type small = size < (type)(1 << 30) ? at[i] : 0;                                       \
            low = lower < low ? lower : low;                                                       \
            high = upper > high ? upper : high;                                                    \
            nan += at[i] != at[i];                                                                 \
            infinite += size > largest;                                                            \
            broken |= (type)(int32_t)small != small;                                               \
        }                                                                                          \
        double sum = 0;                                                                            \
        if (nan + infinite == 0)                                                                   \
            sum = sum_##NAME(at, count);                                                           \
        else                                                                                       \
            for (int64_t i = 0; i < count; ++i)                                                    \
                sum += isfinite(at[i]) ? (double)at[i] : 0;                                        \
        merge_range(range, (double)low, (double)high, sum);                                        \
        range->nan_count += nan;                                                                   \
        range->infinite_count += infinite;                                                         \
        range->has_fractions |= broken != 0;                                                       \
    }

#define BIN(NAME, type)                                                                            \
    static void bin_##NAME(const void *samples, int64_t count, const bin_map *map,                 \
                           int64_t *counts) {                                                      \
        const type *at = samples;                                                                  \
        const double last = (double)map->last_bin;                                                 \
        for (int64_t i = 0; i < count; ++i) {                                                      \
            double value = (double)at[i];                                                          \
            if (!map->finite && !isfinite(value))                                                  \
                continue;                                                                          \
            double place = (value * 0.5 - map->half_low) * map->scale;                             \
            place = place > 0 ? place : 0;                                                         \
            place = place < last ? place : last;                                                   \
            ++counts[(int32_t)place + (i & (TABLES - 1)) * map->table_stride];                     \
        }                                                                                          \
    }

#define INTEGER_KERNELS(NAME, type)                                                                \
    INTEGER_RANGE(NAME, type)                                                                      \
    BIN(NAME, type)
#define REAL_KERNELS(NAME, type, largest)                                                          \
    REAL_RANGE(NAME, type, largest)                                                                \
    BIN(NAME, type)

INTEGER_KERNELS(u8, uint8_t)
INTEGER_KERNELS(i8, int8_t)
INTEGER_KERNELS(u16, uint16_t)
INTEGER_KERNELS(i16, int16_t)
INTEGER_KERNELS(u32, uint32_t)
INTEGER_KERNELS(i32, int32_t)
REAL_KERNELS(f32, float, FLT_MAX)
REAL_KERNELS(f64, double, DBL_MAX)

static kernels kernels_of(qn_scalar scalar) {
    static const kernels of[QN_SCALAR_COUNT] = {
        [QN_U8] = {range_u8, bin_u8, count_u8},     [QN_I8] = {range_i8, bin_i8, count_i8},
        [QN_U16] = {range_u16, bin_u16, count_u16}, [QN_I16] = {range_i16, bin_i16, count_i16},
        [QN_U32] = {range_u32, bin_u32, count_u32}, [QN_I32] = {range_i32, bin_i32, count_i32},
        [QN_F32] = {range_f32, bin_f32, NULL},      [QN_F64] = {range_f64, bin_f64, NULL},
    };
    return of[scalar];
}

/* ---- rows ---- */

/* `count` samples of row (j, k) from i on: where they lie, or a packed copy in `buffer`. */
static const void *fetch_row(const qn_grid *grid, int64_t i, int64_t j, int64_t k, int64_t count,
                             unsigned char *buffer) {
    const unsigned char *from = (const unsigned char *)grid->samples + i * grid->stride[0] +
                                j * grid->stride[1] + k * grid->stride[2];
    int64_t size = (int64_t)qn_scalar_size(grid->scalar);
    bool aligned = (uintptr_t)from % (uintptr_t)size == 0;
    if (grid->stride[0] == size && !grid->swapped && aligned)
        return from;
    for (int64_t s = 0; s < count; ++s, from += grid->stride[0])
        for (int64_t b = 0; b < size; ++b)
            buffer[s * size + b] = from[grid->swapped ? size - 1 - b : b];
    return buffer;
}

typedef struct slice_work {
    const qn_grid *grid;
    kernels kernels;
    bin_map map;
    bool exact;
} slice_work;

static void scan_slice(const slice_work *work, int64_t k, qni_range *range, int64_t *counts) {
    _Alignas(64) unsigned char buffer[PIECE * 8];
    const qn_grid *grid = work->grid;
    for (int64_t j = 0; j < grid->size[1]; ++j)
        for (int64_t i = 0; i < grid->size[0]; i += PIECE) {
            int64_t count = grid->size[0] - i < PIECE ? grid->size[0] - i : PIECE;
            const void *row = fetch_row(grid, i, j, k, count, buffer);
            if (range)
                work->kernels.range(row, count, range);
            else if (work->exact)
                work->kernels.count(row, count, &work->map, counts);
            else
                work->kernels.bin(row, count, &work->map, counts);
        }
}

/* ---- passes ---- */

qn_status qni_scan_range(qn_context *context, const qn_grid *grid, qni_range *range_out,
                         qn_error *error) {
    slice_work work = {.grid = grid, .kernels = kernels_of(grid->scalar)};
    qni_range none = {.low = (double)INFINITY, .high = -(double)INFINITY};
    qni_range *slices = qni_alloc(context, grid->size[2], sizeof *slices);
    if (!slices)
        return qni_fail_memory(error, "the range of the samples");
    int64_t slice_count = grid->size[2];
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
#endif
    for (int64_t k = 0; k < slice_count; ++k) {
        slices[k] = none;
        scan_slice(&work, k, &slices[k], NULL);
    }
    *range_out = none;
    for (int64_t k = 0; k < slice_count; ++k) {
        merge_range(range_out, slices[k].low, slices[k].high, slices[k].sum);
        range_out->nan_count += slices[k].nan_count;
        range_out->infinite_count += slices[k].infinite_count;
        range_out->has_fractions |= slices[k].has_fractions;
    }
    qni_free(context, slices, slice_count, sizeof *slices);
    return QN_OK;
}

static bin_map make_map(const qni_bins *bins, const qni_range *range) {
    double half_range = bins->high * 0.5 - bins->low * 0.5;
    bin_map map = {.first = bins->exact ? (int64_t)bins->low : 0,
                   .half_low = bins->low * 0.5,
                   .scale = half_range > 0 ? (double)bins->bin_count / half_range : 0,
                   .last_bin = bins->bin_count - 1,
                   .table_stride = bins->bin_count <= LARGEST_SPLIT ? bins->bin_count : 0,
                   .finite = !range || range->nan_count + range->infinite_count == 0};
    if (!isfinite(map.scale)) /* a range of subnormal numbers */
        map.scale = DBL_MAX;
    return map;
}

qn_status qni_scan_bins(qn_context *context, const qn_grid *grid, const qni_range *range,
                        qni_bins *bins, qn_error *error) {
    slice_work work = {.grid = grid,
                       .kernels = kernels_of(grid->scalar),
                       .map = make_map(bins, range),
                       .exact = bins->exact};
    int64_t slice_count = grid->size[2];
    int32_t threads = qn_context_threads(context);
    threads = threads < slice_count ? threads : (int32_t)slice_count;
    int64_t table = bins->bin_count * (work.map.table_stride ? TABLES : 1);
    int64_t *counts = qni_alloc_zero(context, table * threads, sizeof *counts);
    if (!counts)
        return qni_fail_memory(error, "a histogram");
#ifdef _OPENMP
#pragma omp parallel for schedule(static) num_threads(threads)
#endif
    for (int64_t k = 0; k < slice_count; ++k)
        scan_slice(&work, k, NULL, counts + table * qni_thread_index());
    memset(bins->counts, 0, (size_t)bins->bin_count * sizeof *bins->counts);
    for (int64_t at = 0; at < table * threads; ++at)
        bins->counts[at % bins->bin_count] += counts[at];
    qni_free(context, counts, table * threads, sizeof *counts);
    return QN_OK;
}
