// SPDX-License-Identifier: MIT
/* Merge sort from below: runs of 8 by insertion, then pairs of runs between two buffers. */
#include "core/sort.h"

#include <string.h>

enum { RUN = 8, LARGEST_ITEM = 64 };

static void insert_run(char *items, int64_t count, size_t size,
                       int (*compare)(const void *, const void *)) {
    char held[LARGEST_ITEM];
    for (int64_t n = 1; n < count; ++n) {
        int64_t to = n;
        while (to > 0 && compare(items + (size_t)(to - 1) * size, items + (size_t)n * size) > 0)
            --to;
        if (to == n)
            continue;
        memcpy(held, items + (size_t)n * size, size);
        memmove(items + (size_t)(to + 1) * size, items + (size_t)to * size,
                (size_t)(n - to) * size);
        memcpy(items + (size_t)to * size, held, size);
    }
}

/* Runs [0, middle) and [middle, end) of `from` into `to`. */
static void merge(const char *from, int64_t middle, int64_t end, size_t size, char *to,
                  int (*compare)(const void *, const void *)) {
    const char *a = from, *b = from + (size_t)middle * size;
    const char *a_end = b, *b_end = from + (size_t)end * size;
    while (a < a_end && b < b_end) {
        const char **next = compare(a, b) <= 0 ? &a : &b;
        memcpy(to, *next, size);
        *next += size;
        to += size;
    }
    memcpy(to, a, (size_t)(a_end - a));
    memcpy(to + (a_end - a), b, (size_t)(b_end - b));
}

static int64_t least(int64_t a, int64_t b) {
    return a < b ? a : b;
}

static bool is_sorted(const char *items, int64_t count, size_t size,
                      int (*compare)(const void *, const void *)) {
    int64_t n = 1;
    while (n < count && compare(items + (size_t)(n - 1) * size, items + (size_t)n * size) <= 0)
        ++n;
    return n >= count;
}

bool qni_sort(qn_context *context, void *items, int64_t count, size_t size,
              int (*compare)(const void *first, const void *second)) {
    char *from = items, *to, *buffer;
    if (size > LARGEST_ITEM || is_sorted(from, count, size, compare))
        return size <= LARGEST_ITEM;
    buffer = to = qni_alloc(context, count, size);
    if (!buffer)
        return false;
    for (int64_t at = 0; at < count; at += RUN)
        insert_run(from + (size_t)at * size, least(RUN, count - at), size, compare);
    for (int64_t run = RUN; run < count; run *= 2) {
        for (int64_t at = 0; at < count; at += 2 * run)
            merge(from + (size_t)at * size, least(run, count - at), least(2 * run, count - at),
                  size, to + (size_t)at * size, compare);
        char *merged = to;
        to = from;
        from = merged;
    }
    if (from != (char *)items)
        memcpy(items, from, (size_t)count * size);
    qni_free(context, buffer, count, size);
    return true;
}
