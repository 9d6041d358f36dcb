// SPDX-License-Identifier: MIT
/* Sorting with the context's memory; qsort() may take the C library's. Merge sort from below: runs
 * of 8 by insertion, then pairs of runs between two buffers. Inline, so that no calls are left of a
 * size and a comparison that are known. */
#ifndef QNI_CORE_SORT_H
#define QNI_CORE_SORT_H

#include "core/context.h"

#include <string.h>

#define QNI_SORT_INLINE static inline __attribute__((always_inline))

typedef int qni_compare(const void *first, const void *second);

enum { QNI_SORT_RUN = 8, QNI_SORT_LARGEST_ITEM = 64 };

QNI_SORT_INLINE void qni_sort_insert(char *items, int64_t count, size_t size,
                                     qni_compare *compare) {
    char held[QNI_SORT_LARGEST_ITEM];
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
QNI_SORT_INLINE void qni_sort_merge(const char *from, int64_t middle, int64_t end, size_t size,
                                    char *to, qni_compare *compare) {
    const char *a = from, *b = from + (size_t)middle * size;
    const char *a_end = b, *b_end = from + (size_t)end * size;
    while (a < a_end && b < b_end) {
        const bool first = compare(a, b) <= 0;
        memcpy(to, first ? a : b, size);
        a += first ? size : 0;
        b += first ? 0 : size;
        to += size;
    }
    memcpy(to, a, (size_t)(a_end - a));
    memcpy(to + (a_end - a), b, (size_t)(b_end - b));
}

QNI_SORT_INLINE bool qni_is_sorted(const char *items, int64_t count, size_t size,
                                   qni_compare *compare) {
    int64_t n = 1;
    while (n < count && compare(items + (size_t)(n - 1) * size, items + (size_t)n * size) <= 0)
        ++n;
    return n >= count;
}

static inline int64_t qni_sort_least(int64_t a, int64_t b) {
    return a < b ? a : b;
}

/* Ascending and stable, in O(n log n), with room for as many items again; false when there is none.
 */
QNI_SORT_INLINE bool qni_sort(qn_context *context, void *items, int64_t count, size_t size,
                              qni_compare *compare) {
    char *from = items, *to, *buffer;
    if (size > QNI_SORT_LARGEST_ITEM || qni_is_sorted(from, count, size, compare))
        return size <= QNI_SORT_LARGEST_ITEM;
    buffer = to = qni_alloc(context, count, size);
    if (!buffer)
        return false;
    for (int64_t at = 0; at < count; at += QNI_SORT_RUN)
        qni_sort_insert(from + (size_t)at * size, qni_sort_least(QNI_SORT_RUN, count - at), size,
                        compare);
    for (int64_t run = QNI_SORT_RUN; run < count; run *= 2) {
        for (int64_t at = 0; at < count; at += 2 * run)
            qni_sort_merge(from + (size_t)at * size, qni_sort_least(run, count - at),
                           qni_sort_least(2 * run, count - at), size, to + (size_t)at * size,
                           compare);
        char *merged = to;
        to = from;
        from = merged;
    }
    if (from != (char *)items)
        memcpy(items, from, (size_t)count * size);
    qni_free(context, buffer, count, size);
    return true;
}

#endif
