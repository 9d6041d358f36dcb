// SPDX-License-Identifier: MIT
/* Otsu's thresholds by trying all places for them; with 512 bins that is a quarter of a million
 * tries. */
#include "volume/otsu.h"

/* Samples and sum of bin numbers in the bins before each edge. */
typedef struct moments {
    double weight[QNI_OTSU_BINS + 1];
    double sum[QNI_OTSU_BINS + 1];
} moments;

/* A class's part of the variance between classes, of the bins from edge a to edge b. */
static double class_score(const moments *of, int a, int b) {
    double weight = of->weight[b] - of->weight[a];
    double sum = of->sum[b] - of->sum[a];
    return weight > 0 ? sum * sum / weight : 0;
}

/* All edges within a run of empty bins part the samples alike: the middle of the run is the
 * fairest. */
static double middle_of_gap(const int64_t *counts, int count, int edge) {
    int first = edge, last = edge;
    while (first > 1 && counts[first - 1] == 0)
        --first;
    while (last < count - 1 && counts[last] == 0)
        ++last;
    return 0.5 * (first + last);
}

bool qni_otsu(const int64_t *counts, int count, double *one_out, double two_out[2]) {
    moments of = {.weight = {0}};
    int filled = 0;
    for (int b = 0; b < count; ++b) {
        of.weight[b + 1] = of.weight[b] + (double)counts[b];
        of.sum[b + 1] = of.sum[b] + (double)counts[b] * b;
        filled += counts[b] > 0;
    }
    if (filled < 2)
        return false;
    int best = 0, best_low = 0, best_high = 0;
    double score = -1, score_two = -1;
    for (int low = 1; low < count; ++low) {
        double below = class_score(&of, 0, low);
        double one = below + class_score(&of, low, count);
        if (one > score) {
            score = one;
            best = low;
        }
        for (int high = low + 1; high < count && counts[low - 1] > 0; ++high) {
            double two = below + class_score(&of, low, high) + class_score(&of, high, count);
            if (two > score_two && counts[high - 1] > 0) {
                score_two = two;
                best_low = low;
                best_high = high;
            }
        }
    }
    *one_out = middle_of_gap(counts, count, best);
    two_out[0] = filled > 2 ? middle_of_gap(counts, count, best_low) : *one_out;
    two_out[1] = filled > 2 ? middle_of_gap(counts, count, best_high) : *one_out;
    return true;
}
