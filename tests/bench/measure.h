// SPDX-License-Identifier: MIT
/* Clocks, resident memory, and where and of what a measurement was made. */
#ifndef BENCH_MEASURE_H
#define BENCH_MEASURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct bench_time {
    double wall, cpu; /* seconds; CPU of all threads of the process, in the kernel too */
} bench_time;

bench_time bench_now(void);
bench_time bench_since(bench_time start);

/* Run `work` in a process of its own, so that each case begins with the same memory; it fills
 * `result` [size]. False when it died. */
bool bench_run_apart(void (*work)(const void *job, void *result), const void *job, void *result,
                     size_t size);

/* Bytes of this process in memory, and the most since the reset; 0 where the system does not tell.
 */
int64_t bench_resident(void);
int64_t bench_peak_resident(void);
void bench_reset_peak_resident(void);

const char *bench_processor(void);
const char *bench_compiler(void);
const char *bench_commit(void); /* "" outside of a repository */

#endif
