// SPDX-License-Identifier: MIT
/* What the samples of a volume hold: range, mean, histogram, and iso-values worth trying. */
#include "core/context.h"
#include "core/status.h"
#include "volume/otsu.h"
#include "volume/scan.h"
#include "volume/volume.h"

#include <math.h>
#include <string.h>

enum {
    FINE_BINS = 4096,
    /* The range is narrowed until the bulk of the samples fills this many bins of the fine
       histogram. */
    FEWEST_BULK_BINS = 64,
    MOST_NARROWINGS = 12
};

/* A share this small at either end is noise or a marker, and does not set the scale of the
 * thresholds. */
static const double outlier_share = 1e-4;
/* A surface with less above it is dust, with more above it is background. */
static const double least_share_above = 0.003, most_share_above = 0.6;

/* The samples counted for thresholds, in stored numbers. */
typedef struct fine_histogram {
    qni_bins bins;
    double offset; /* of a bin's lower edge: -0.5 for exact bins, whose integer is the middle */
    double width;
    bool integers; /* thresholds go to half-integers */
} fine_histogram;

static bool is_real(qn_scalar scalar) {
    return scalar == QN_F32 || scalar == QN_F64;
}

/* ---- counting ---- */

static void fill_mean(const qn_grid *grid, const qni_range *range, int64_t finite,
                      qn_volume_statistics *statistics) {
    double low = grid->slope * range->low + grid->intercept;
    double high = grid->slope * range->high + grid->intercept;
    statistics->minimum = low < high ? low : high;
    statistics->maximum = low < high ? high : low;
    double mean = range->sum / (double)finite;
    if (!isfinite(mean)) /* the sum of huge numbers overflowed */
        mean = range->low * 0.5 + range->high * 0.5;
    statistics->mean = grid->slope * mean + grid->intercept;
}

/* The public histogram: equal parts of the stored range, turned round by a negative slope. */
static void fill_histogram(const qn_grid *grid, const qni_range *range, const qni_bins *bins,
                           qn_volume_statistics *statistics) {
    double span = range->high - range->low;
    for (int64_t b = 0; b < bins->bin_count; ++b) {
        if (bins->counts[b] == 0)
            continue;
        int64_t to = b * QN_HISTOGRAM_BINS / bins->bin_count;
        if (bins->exact)
            to = span > 0
                     ? (int64_t)((bins->low + (double)b - range->low) / span * QN_HISTOGRAM_BINS)
                     : 0;
        to = to < QN_HISTOGRAM_BINS ? to : QN_HISTOGRAM_BINS - 1;
        statistics->histogram[grid->slope < 0 ? QN_HISTOGRAM_BINS - 1 - to : to] += bins->counts[b];
    }
}

static int64_t total(const qni_bins *bins) {
    int64_t sum = 0;
    for (int64_t b = 0; b < bins->bin_count; ++b)
        sum += bins->counts[b];
    return sum;
}

/* The bins from *first to *last hold all samples but the outliers of both ends. */
static void find_bulk(const qni_bins *bins, int64_t *first, int64_t *last) {
    double most = outlier_share * (double)total(bins);
    int64_t below = 0, above = 0;
    *first = 0;
    *last = bins->bin_count - 1;
    while (*first < *last && (double)(below += bins->counts[*first]) <= most)
        ++*first;
    while (*last > *first && (double)(above += bins->counts[*last]) <= most)
        --*last;
}

/* One far-off sample would put all others into one bin: count again over the bulk, until it fills
 * some. */
static qn_status narrow(qn_context *context, const qn_grid *grid, const qni_range *range,
                        qni_bins *bins, qn_error *error) {
    for (int round = 0; round < MOST_NARROWINGS && !bins->exact; ++round) {
        int64_t first, last;
        find_bulk(bins, &first, &last);
        if (last - first + 1 >= FEWEST_BULK_BINS)
            break;
        double width = bins->high / (double)bins->bin_count - bins->low / (double)bins->bin_count;
        double low = bins->low + (double)(first - 1) * width;
        double high = bins->low + (double)(last + 2) * width;
        if (!(low < high) || !isfinite(low) || !isfinite(high) || width == 0)
            break;
        bins->low = low > range->low ? low : range->low;
        bins->high = high < range->high ? high : range->high;
        QN_TRY(qni_scan_bins(context, grid, range, bins, error));
    }
    return QN_OK;
}

/* ---- suggestions ---- */

/* Group the bulk into few bins and find Otsu's thresholds of it: one between two, ascending, stored
 * numbers. */
static bool find_thresholds(const fine_histogram *fine, double thresholds[3]) {
    const qni_bins *bins = &fine->bins;
    int64_t first, last, grouped[QNI_OTSU_BINS] = {0};
    find_bulk(bins, &first, &last);
    int64_t group = (last - first + QNI_OTSU_BINS) / QNI_OTSU_BINS;
    for (int64_t b = first; b <= last; ++b)
        grouped[(b - first) / group] += bins->counts[b];
    double two[2];
    if (!qni_otsu(grouped, (int)((last - first) / group + 1), &thresholds[1], two))
        return false;
    thresholds[0] = two[0];
    thresholds[2] = two[1];
    for (int t = 0; t < 3; ++t) {
        double place = (double)first + thresholds[t] * (double)group;
        thresholds[t] = bins->low + fine->offset + place * fine->width;
        if (fine->integers)
            thresholds[t] = floor(thresholds[t]) + 0.5;
    }
    return true;
}

static double share_above(const fine_histogram *fine, const qn_grid *grid, double threshold) {
    const qni_bins *bins = &fine->bins;
    int64_t above = 0;
    for (int64_t b = 0; b < bins->bin_count; ++b)
        if (bins->low + ((double)b + 0.5) * fine->width + fine->offset > threshold)
            above += bins->counts[b];
    double share = (double)above / (double)total(bins);
    return grid->slope < 0 ? 1 - share : share;
}

/* A field of both signs that is no scan: a distance, whose surface is at 0. */
static bool is_distance(const fine_histogram *fine, const qn_grid *grid) {
    if (!is_real(grid->scalar) || fine->integers || grid->intercept != 0)
        return false;
    double positive = share_above(fine, grid, 0);
    return positive > 0.001 && positive < 0.999;
}

/* In scans of 16 bits and wide range (CT) the surface asked for first is the densest class, bone;
 * else it is the object against its background. The share above must make a surface. */
static double choose(const fine_histogram *fine, const qn_grid *grid, const double thresholds[3]) {
    bool wide = fine->integers && fine->bins.high - fine->bins.low >= 1000 && grid->slope > 0;
    const double order[3] = {thresholds[wide ? 2 : 1], thresholds[wide ? 1 : 2], thresholds[0]};
    for (int t = 0; t < 3; ++t) {
        double share = share_above(fine, grid, order[t]);
        if (share >= least_share_above && share <= most_share_above)
            return order[t];
    }
    return thresholds[1];
}

static void add_suggestion(qn_volume_statistics *statistics, double value) {
    int at = statistics->suggestion_count;
    for (int s = 0; s < at; ++s)
        if (statistics->suggestions[s] == value)
            return;
    while (at > 0 && statistics->suggestions[at - 1] > value) {
        statistics->suggestions[at] = statistics->suggestions[at - 1];
        --at;
    }
    statistics->suggestions[at] = value;
    ++statistics->suggestion_count;
}

static void suggest(const qn_grid *grid, const fine_histogram *fine,
                    qn_volume_statistics *statistics) {
    double thresholds[3];
    if (!find_thresholds(fine, thresholds))
        return;
    double chosen = choose(fine, grid, thresholds);
    if (is_distance(fine, grid))
        chosen = thresholds[0] = 0; /* in the place of the lower threshold */
    for (int t = 0; t < 3; ++t)
        add_suggestion(statistics, grid->slope * thresholds[t] + grid->intercept);
    statistics->suggested = grid->slope * chosen + grid->intercept;
}

/* ---- the whole ---- */

static qn_status analyse(qn_context *context, const qn_grid *grid, const qni_range *range,
                         int64_t *counts, qn_volume_statistics *statistics, qn_error *error) {
    bool exact = !is_real(grid->scalar) && range->high - range->low < QNI_LARGEST_BIN_COUNT;
    fine_histogram fine = {
        .bins = {.exact = exact,
                 .low = range->low,
                 .high = range->high,
                 .bin_count = exact ? (int64_t)(range->high - range->low) + 1 : FINE_BINS,
                 .counts = counts},
        .offset = exact ? -0.5 : 0,
        .integers = !range->has_fractions};
    if (qni_progress(context, "statistics", 0.5))
        return qni_fail(error, QN_ERROR_CANCELLED, "the statistics were cancelled");
    QN_TRY(qni_scan_bins(context, grid, range, &fine.bins, error));
    fill_histogram(grid, range, &fine.bins, statistics);
    QN_TRY(narrow(context, grid, range, &fine.bins, error));
    fine.width = exact ? 1
                       : fine.bins.high / (double)fine.bins.bin_count -
                             fine.bins.low / (double)fine.bins.bin_count;
    suggest(grid, &fine, statistics);
    return QN_OK;
}

/* The samples to look at: those of a sparse volume's leaves lie side by side like a dense grid. */
static qn_grid samples_of(const qn_volume *volume) {
    qn_grid grid = *qn_volume_grid(volume);
    const qn_sparse_grid *sparse = qn_volume_sparse_grid(volume);
    if (!sparse)
        return grid;
    const int64_t size = (int64_t)qn_scalar_size(sparse->scalar);
    grid.samples = sparse->values;
    for (int a = 0; a < 3; ++a) {
        grid.size[a] = a < 2 ? (a == 0 ? 512 : 1) : sparse->leaf_count;
        grid.stride[a] = a == 0 ? size : 512 * size;
    }
    return grid;
}

qn_status qn_volume_get_statistics(qn_context *context, const qn_volume *volume,
                                   qn_volume_statistics *statistics_out, qn_error *error) {
    const qn_grid samples = samples_of(volume), *grid = &samples;
    memset(statistics_out, 0, sizeof *statistics_out);
    qni_range range;
    if (qni_progress(context, "statistics", 0))
        return qni_fail(error, QN_ERROR_CANCELLED, "the statistics were cancelled");
    QN_TRY(qni_scan_range(context, grid, &range, error));
    statistics_out->sample_count = grid->size[0] * grid->size[1] * grid->size[2];
    statistics_out->nan_count = range.nan_count;
    statistics_out->infinite_count = range.infinite_count;
    statistics_out->minimum = statistics_out->maximum = (double)NAN;
    statistics_out->mean = statistics_out->suggested = (double)NAN;
    int64_t finite = statistics_out->sample_count - range.nan_count - range.infinite_count;
    if (finite == 0)
        return QN_OK;
    fill_mean(grid, &range, finite, statistics_out);
    int64_t *counts = qni_alloc(context, QNI_LARGEST_BIN_COUNT, sizeof *counts);
    if (!counts)
        return qni_fail_memory(error, "a histogram");
    qn_status status = analyse(context, grid, &range, counts, statistics_out, error);
    qni_free(context, counts, QNI_LARGEST_BIN_COUNT, sizeof *counts);
    return status;
}
