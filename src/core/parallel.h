// SPDX-License-Identifier: MIT
/* Threads: the few OpenMP calls Quoin makes, so that everything builds without OpenMP too. */
#ifndef QNI_CORE_PARALLEL_H
#define QNI_CORE_PARALLEL_H

#include <stdint.h>

#ifdef _OPENMP
#include <omp.h>
static inline int32_t qni_core_count(void) {
    return omp_get_num_procs();
}
static inline int32_t qni_thread_index(void) {
    return omp_get_thread_num();
}
static inline double qni_seconds(void) {
    return omp_get_wtime();
}
#else
#include <time.h>
static inline int32_t qni_core_count(void) {
    return 1;
}
static inline int32_t qni_thread_index(void) {
    return 0;
}
static inline double qni_seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
#endif

#endif
