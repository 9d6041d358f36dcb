// SPDX-License-Identifier: MIT
#include "parity/cpu_device.h"
#include "core/parallel.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

/* ---- orders ---------------------------------------------------------------------------------- */

static uint64_t next_random(test_cpu_device *cpu) {
    uint64_t z = (cpu->shuffle += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* All numbers below `count`, each once: offset, then steps that share no divisor with the count. */
typedef struct order {
    int64_t count, at, step;
} order;

static int64_t common_divisor(int64_t a, int64_t b) {
    while (b) {
        const int64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

static order shuffled(test_cpu_device *cpu, int64_t count) {
    order o = {count, 0, 1};
    if (count > 1) {
        o.at = (int64_t)(next_random(cpu) % (uint64_t)count);
        do
            o.step = 1 + (int64_t)(next_random(cpu) % (uint64_t)(count - 1));
        while (common_divisor(o.step, count) != 1);
    }
    return o;
}

static int64_t next(order *o) {
    const int64_t now = o->at;
    o->at = (o->at + o->step) % o->count;
    return now;
}

/* ---- kernels --------------------------------------------------------------------------------- */

/* What kernels.cu does with a warp's votes. */
static void run_signs(test_cpu_device *cpu, const qni_gpu_args *a) {
    const qni_gpu_field *field = &a->field;
    order lines = shuffled(cpu, qni_gpu_sign_lines(a));
    for (int64_t n = 0; n < lines.count; ++n) {
        const int64_t line = next(&lines), y = line % field->points[1],
                      z = line / field->points[1] + qni_gpu_sign_plane(a);
        int odd = 0;
        for (int64_t word = 0; word < a->line_words; ++word) {
            uint32_t bits = 0;
            for (int lane = 0; lane < 32; ++lane)
                bits |= (uint32_t)qni_gpu_sign(field, field->scalar, 32 * word + lane, y, z, &odd)
                        << lane;
            a->signs[line * a->line_words + word] = bits;
        }
        if (odd)
            a->totals->nonfinite = 1;
    }
}

#define RUN_KERNEL(name)                                                                           \
    static void run_##name(test_cpu_device *cpu, const qni_gpu_args *a) {                          \
        static qni_gpu_##name##_shared shared;                                                     \
        order items = shuffled(cpu, qni_gpu_##name##_items(a));                                    \
        for (int64_t n = 0; n < items.count; ++n) {                                                \
            const int64_t item = next(&items);                                                     \
            memset(&shared, 0xcd, sizeof shared);                                                  \
            for (int phase = 0; phase < QNI_GPU_##name##_PHASES; ++phase) {                        \
                order threads = shuffled(cpu, QNI_GPU_##name##_THREADS);                           \
                for (int t = 0; t < QNI_GPU_##name##_THREADS; ++t)                                 \
                    qni_gpu_##name(a, &shared, item, phase, (int)next(&threads));                  \
            }                                                                                      \
        }                                                                                          \
    }
QNI_GPU_KERNEL_MAP(RUN_KERNEL)
#undef RUN_KERNEL

static qn_status launch(qni_device *device, qni_gpu_kernel kernel, const qni_gpu_args *args,
                        int64_t blocks, qn_error *error) {
    test_cpu_device *cpu = device->self;
    ++cpu->launches;
    if (blocks <= 0)
        return qni_fail(error, QN_ERROR_INTERNAL, "a launch without blocks");
    switch (kernel) {
    case QNI_GPU_KERNEL_signs:
        run_signs(cpu, args);
        break;
#define RUN_CASE(name)                                                                             \
    case QNI_GPU_KERNEL_##name:                                                                    \
        run_##name(cpu, args);                                                                     \
        break;
        QNI_GPU_KERNEL_MAP(RUN_CASE)
#undef RUN_CASE
    case QNI_GPU_KERNEL_COUNT:
        break;
    }
    return QN_OK;
}

/* ---- memory ---------------------------------------------------------------------------------- */

enum { HEAD = 64 };

static qn_status cpu_alloc(qni_device *device, int64_t bytes, void **out, qn_error *error) {
    test_cpu_device *cpu = device->self;
    *out = NULL;
    if (cpu->limit && cpu->bytes + bytes > cpu->limit)
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY, "the device has no memory left");
    char *memory = malloc((size_t)bytes + HEAD);
    if (!memory)
        return qni_fail_memory(error, "the device that is the processor");
    memcpy(memory, &bytes, sizeof bytes);
    memset(memory + HEAD, 0xdd, (size_t)bytes);
    cpu->bytes += bytes;
    cpu->most = cpu->bytes > cpu->most ? cpu->bytes : cpu->most;
    ++cpu->allocations;
    *out = memory + HEAD;
    return QN_OK;
}

static void cpu_free(qni_device *device, void *memory) {
    test_cpu_device *cpu = device->self;
    int64_t bytes;
    memcpy(&bytes, (char *)memory - HEAD, sizeof bytes);
    cpu->bytes -= bytes;
    free((char *)memory - HEAD);
}

static int64_t cpu_free_bytes(qni_device *device) {
    const test_cpu_device *cpu = device->self;
    return cpu->limit ? cpu->limit - cpu->bytes : INT64_MAX;
}

static qn_status cpu_copy(qni_device *device, void *to, const void *from, int64_t bytes,
                          qn_error *error) {
    (void)device;
    (void)error;
    memcpy(to, from, (size_t)bytes);
    return QN_OK;
}

static qn_status cpu_upload_rows(qni_device *device, void *to, const void *from, int64_t row_bytes,
                                 int64_t stride, int64_t rows, qn_error *error) {
    (void)device;
    (void)error;
    for (int64_t n = 0; n < rows; ++n)
        memcpy((char *)to + n * row_bytes, (const char *)from + n * stride, (size_t)row_bytes);
    return QN_OK;
}

static qn_status cpu_fill(qni_device *device, void *memory, int byte, int64_t bytes,
                          qn_error *error) {
    (void)device;
    (void)error;
    memset(memory, byte, (size_t)bytes);
    return QN_OK;
}

static qn_status cpu_mark(qni_device *device, int index, qn_error *error) {
    test_cpu_device *cpu = device->self;
    (void)error;
    cpu->mark[index] = qni_seconds();
    return QN_OK;
}

static qn_status cpu_elapsed(qni_device *device, double *milliseconds, qn_error *error) {
    const test_cpu_device *cpu = device->self;
    (void)error;
    *milliseconds = 1e3 * (cpu->mark[1] - cpu->mark[0]);
    return QN_OK;
}

static qn_status cpu_finish(qni_device *device, qn_error *error) {
    test_cpu_device *cpu = device->self;
    (void)error;
    ++cpu->finishes;
    return QN_OK;
}

void test_cpu_device_init(test_cpu_device *cpu, uint64_t shuffle) {
    *cpu = (test_cpu_device){.shuffle = shuffle};
    cpu->device = (qni_device){.self = cpu,
                               .alloc = cpu_alloc,
                               .free = cpu_free,
                               .free_bytes = cpu_free_bytes,
                               .upload = cpu_copy,
                               .upload_rows = cpu_upload_rows,
                               .download = cpu_copy,
                               .fill = cpu_fill,
                               .launch = launch,
                               .copy = cpu_copy,
                               .mark = cpu_mark,
                               .elapsed = cpu_elapsed,
                               .finish = cpu_finish};
}
