// SPDX-License-Identifier: MIT
/* A device that is the processor: it runs the kernel bodies of gpu/ themselves, blocks and threads
 * in a shuffled order, with shared and fresh memory full of rubbish. */
#ifndef TEST_CPU_DEVICE_H
#define TEST_CPU_DEVICE_H

#include "gpu/device.h"

typedef struct test_cpu_device {
    qni_device device;
    uint64_t shuffle;    /* seed of the order */
    int64_t bytes, most; /* held now, and at most */
    int64_t limit;       /* allocations beyond this fail; 0: none do */
    double mark[2];
    int64_t launches, allocations, finishes;
} test_cpu_device;

void test_cpu_device_init(test_cpu_device *cpu, uint64_t shuffle);

#endif
