// SPDX-License-Identifier: MIT
/* Exclusive scans of whole numbers in three kernels: sums of tiles, a scan of these, places. Any
 * order of blocks gives the same. A kernel is a sequence of phases; all threads of a block end a
 * phase before any begins the next. */
#ifndef QNI_GPU_SCAN_HD_H
#define QNI_GPU_SCAN_HD_H

#include "gpu/args_hd.h"

enum { QNI_SCAN_THREADS = 256, QNI_SCAN_EACH = 8, QNI_SCAN_TILE = 2048, QNI_SCAN_GROUP = 16 };

typedef struct qni_gpu_scan_shared {
    uint64_t of_thread[QNI_SCAN_THREADS];
    uint64_t of_group[QNI_SCAN_GROUP];
} qni_gpu_scan_shared;

QN_HD_INLINE int64_t qni_gpu_scan_tiles(const qni_gpu_args *a) {
    return ((int64_t)*a->scan_length + QNI_SCAN_TILE) / QNI_SCAN_TILE;
}

/* Where this thread's share of a tile is, and how many entries of it exist. */
QN_HD_INLINE uint32_t *qni_gpu_scan_share(const qni_gpu_args *a, int64_t item, int thread,
                                          int *count) {
    const int64_t tiles = qni_gpu_scan_tiles(a), channel = item / tiles, tile = item % tiles;
    const int64_t from = tile * QNI_SCAN_TILE + thread * QNI_SCAN_EACH;
    const int64_t left = (int64_t)*a->scan_length - from;
    *count = left < 0 ? 0 : left < QNI_SCAN_EACH ? (int)left : QNI_SCAN_EACH;
    return a->scan_data + channel * a->scan_stride + from;
}

/* Phases 0 to 2: the sum of each thread's share, of each group of threads, of the groups before. */
QN_HD_INLINE void qni_gpu_scan_sum_share(const qni_gpu_args *a, qni_gpu_scan_shared *s,
                                         int64_t item, int thread) {
    int count;
    const uint32_t *share = qni_gpu_scan_share(a, item, thread, &count);
    uint64_t sum = 0;
    for (int n = 0; n < count; ++n)
        sum += share[n];
    s->of_thread[thread] = sum;
}

QN_HD_INLINE void qni_gpu_scan_sum_group(qni_gpu_scan_shared *s, int thread) {
    uint64_t sum = 0;
    if (thread >= QNI_SCAN_GROUP)
        return;
    for (int n = 0; n < QNI_SCAN_GROUP; ++n)
        sum += s->of_thread[QNI_SCAN_GROUP * thread + n];
    s->of_group[thread] = sum;
}

/* Groups' sums become what comes before each; returns the sum of all. */
QN_HD_INLINE uint64_t qni_gpu_scan_groups(qni_gpu_scan_shared *s) {
    uint64_t before = 0;
    for (int n = 0; n < QNI_SCAN_GROUP; ++n) {
        const uint64_t sum = s->of_group[n];
        s->of_group[n] = before;
        before += sum;
    }
    return before;
}

/* Threads' sums become what comes before each. */
QN_HD_INLINE void qni_gpu_scan_threads(qni_gpu_scan_shared *s, int thread) {
    if (thread >= QNI_SCAN_GROUP)
        return;
    uint64_t before = s->of_group[thread];
    for (int n = 0; n < QNI_SCAN_GROUP; ++n) {
        const uint64_t sum = s->of_thread[QNI_SCAN_GROUP * thread + n];
        s->of_thread[QNI_SCAN_GROUP * thread + n] = before;
        before += sum;
    }
}

/* ---- sums of tiles --------------------------------------------------------------------------- */

enum { QNI_GPU_scan_sums_THREADS = QNI_SCAN_THREADS, QNI_GPU_scan_sums_PHASES = 3 };
typedef qni_gpu_scan_shared qni_gpu_scan_sums_shared;

QN_HD_INLINE int64_t qni_gpu_scan_sums_items(const qni_gpu_args *a) {
    return a->scan_channels * qni_gpu_scan_tiles(a);
}

QN_HD_INLINE void qni_gpu_scan_sums(const qni_gpu_args *a, qni_gpu_scan_sums_shared *s,
                                    int64_t item, int phase, int thread) {
    if (phase == 0)
        qni_gpu_scan_sum_share(a, s, item, thread);
    else if (phase == 1)
        qni_gpu_scan_sum_group(s, thread);
    else if (thread == 0) {
        const int64_t tiles = qni_gpu_scan_tiles(a);
        a->scan_sums[item / tiles * a->scan_tiles + item % tiles] = qni_gpu_scan_groups(s);
    }
}

/* ---- places of tiles: one block a channel ---------------------------------------------------- */

enum { QNI_GPU_scan_tops_THREADS = QNI_SCAN_THREADS, QNI_GPU_scan_tops_PHASES = 5 };
typedef qni_gpu_scan_shared qni_gpu_scan_tops_shared;

QN_HD_INLINE int64_t qni_gpu_scan_tops_items(const qni_gpu_args *a) {
    return a->scan_channels;
}

QN_HD_INLINE void qni_gpu_scan_tops(const qni_gpu_args *a, qni_gpu_scan_tops_shared *s,
                                    int64_t item, int phase, int thread) {
    const int64_t tiles = qni_gpu_scan_tiles(a);
    const int64_t each = (tiles + QNI_SCAN_THREADS - 1) / QNI_SCAN_THREADS, from = thread * each;
    const int64_t end = from + each < tiles ? from + each : tiles;
    uint64_t *sums = a->scan_sums + item * a->scan_tiles;
    if (phase == 0) {
        uint64_t sum = 0;
        for (int64_t n = from; n < end; ++n)
            sum += sums[n];
        s->of_thread[thread] = sum;
    } else if (phase == 1) {
        qni_gpu_scan_sum_group(s, thread);
    } else if (phase == 2) {
        if (thread == 0)
            a->scan_totals[item] = qni_gpu_scan_groups(s);
    } else if (phase == 3) {
        qni_gpu_scan_threads(s, thread);
    } else {
        uint64_t before = s->of_thread[thread];
        for (int64_t n = from; n < end; ++n) {
            const uint64_t sum = sums[n];
            sums[n] = before;
            before += sum;
        }
    }
}

/* ---- places of entries ----------------------------------------------------------------------- */

enum { QNI_GPU_scan_places_THREADS = QNI_SCAN_THREADS, QNI_GPU_scan_places_PHASES = 5 };
typedef qni_gpu_scan_shared qni_gpu_scan_places_shared;

QN_HD_INLINE int64_t qni_gpu_scan_places_items(const qni_gpu_args *a) {
    return a->scan_placed * qni_gpu_scan_tiles(a);
}

QN_HD_INLINE void qni_gpu_scan_places(const qni_gpu_args *a, qni_gpu_scan_places_shared *s,
                                      int64_t item, int phase, int thread) {
    if (phase == 0) {
        qni_gpu_scan_sum_share(a, s, item, thread);
    } else if (phase == 1) {
        qni_gpu_scan_sum_group(s, thread);
    } else if (phase == 2) {
        if (thread == 0)
            (void)qni_gpu_scan_groups(s);
    } else if (phase == 3) {
        qni_gpu_scan_threads(s, thread);
    } else {
        const int64_t tiles = qni_gpu_scan_tiles(a), channel = item / tiles, tile = item % tiles;
        uint64_t before = s->of_thread[thread] + a->scan_sums[channel * a->scan_tiles + tile];
        int count;
        uint32_t *share = qni_gpu_scan_share(a, item, thread, &count);
        for (int n = 0; n < count; ++n) {
            const uint32_t sum = share[n];
            share[n] = (uint32_t)before;
            before += sum;
        }
        /* The entry after the last takes the sum: it belongs to the thread it would fall to. */
        const int64_t own = tile * QNI_SCAN_TILE + thread * QNI_SCAN_EACH;
        const int64_t length = (int64_t)*a->scan_length;
        if (own <= length && length < own + QNI_SCAN_EACH)
            share[count] = (uint32_t)before;
    }
}

#endif
