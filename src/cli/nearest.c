// SPDX-License-Identifier: MIT
/* Edit distance (insert, delete, replace) by the usual table, one row at a time. */
#include "nearest.h"

#include <string.h>

enum { LONGEST = 32 };

static int smaller(int a, int b) {
    return a < b ? a : b;
}

static int edit_distance(const char *a, const char *b) {
    size_t m = strlen(a), n = strlen(b);
    int row[LONGEST + 1];
    if (m > LONGEST || n > LONGEST)
        return LONGEST;
    for (size_t j = 0; j <= n; ++j)
        row[j] = (int)j;
    for (size_t i = 1; i <= m; ++i) {
        int diagonal = row[0];
        row[0] = (int)i;
        for (size_t j = 1; j <= n; ++j) {
            int replaced = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = smaller(replaced, smaller(row[j], row[j - 1]) + 1);
        }
    }
    return row[n];
}

const char *nearest_word(const char *word, const char *const *words, int count) {
    const char *best = NULL;
    int best_distance = strlen(word) > 4 ? 3 : 2;
    for (int i = 0; i < count; ++i) {
        int distance = edit_distance(word, words[i]);
        if (distance < best_distance) {
            best = words[i];
            best_distance = distance;
        }
    }
    return best;
}
