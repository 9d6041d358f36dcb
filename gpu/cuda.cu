// SPDX-License-Identifier: MIT
/* The GPU as a device: memory, copies, and the kernels' outer shape. What kernels do is in the
 * *_hd.h headers, which the processor runs too. */
#include <cuda_runtime.h>

#include "gpu/cuda.h"
#include "gpu/kernels_hd.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- kernels --------------------------------------------------------------------------------- */

/* Tuned by hand where one is: blocks that shall fit one multiprocessor beside each other, which
 * bounds the registers of a thread. */
enum {
    BLOCKS_measure = 4,
    BLOCKS_find_leaves = 4,
    BLOCKS_sparse_signs = 8,
    BLOCKS_list_leaves = 4,
    BLOCKS_scan_sums = 4,
    BLOCKS_scan_tops = 1,
    BLOCKS_scan_places = 4,
    BLOCKS_count = 8,
    BLOCKS_record = 8,
    BLOCKS_emit = 4,
    BLOCKS_link = 4,
    BLOCKS_mark_quads = 4,
    BLOCKS_count_marks = 4,
    BLOCKS_list_splits = 4,
    BLOCKS_note_splits = 4,
    BLOCKS_place_faces = 4,
    BLOCKS_split_quads = 4,
    BLOCKS_link_splits = 4,
    BLOCKS_split_apart = 4,
    BLOCKS_split_valences = 4,
    BLOCKS_find_first = 8,
    BLOCKS_merge_first = 4,
    BLOCKS_spread = 8,
    BLOCKS_look = 8,
    BLOCKS_decide = 8,
    BLOCKS_carry_out = 4,
    BLOCKS_count_vertices = 8,
    BLOCKS_count_quads = 8,
    BLOCKS_pack_vertices = 8,
    BLOCKS_pack_quads = 8,
    BLOCKS_note_own = 1,
    BLOCKS_note_own_splits = 1,
    BLOCKS_renumber_quads = 4,
    BLOCKS_renumber_halfedges = 4
};
enum { SIGN_THREADS = 256, SIGN_WORDS = 4, BLOCKS_A_PROCESSOR = 32 };

#define DEFINE_KERNEL(name)                                                                        \
    __global__ void __launch_bounds__(QNI_GPU_##name##_THREADS, BLOCKS_##name)                     \
        kernel_##name(const __grid_constant__ qni_gpu_args args) {                                 \
        __shared__ qni_gpu_##name##_shared shared;                                                 \
        const int64_t items = qni_gpu_##name##_items(&args);                                       \
        for (int64_t item = blockIdx.x; item < items; item += gridDim.x) {                         \
            _Pragma("unroll") for (int phase = 0; phase < QNI_GPU_##name##_PHASES; ++phase) {      \
                qni_gpu_##name(&args, &shared, item, phase, (int)threadIdx.x);                     \
                __syncthreads();                                                                   \
            }                                                                                      \
        }                                                                                          \
    }
QNI_GPU_KERNEL_MAP(DEFINE_KERNEL)
#undef DEFINE_KERNEL

/* A warp makes SIGN_WORDS words of one line: all its loads are under way before the first vote. */
template <int scalar>
__global__ void __launch_bounds__(SIGN_THREADS)
    kernel_signs(const __grid_constant__ qni_gpu_args args) {
    const int64_t groups = (args.line_words + SIGN_WORDS - 1) / SIGN_WORDS;
    const int64_t warps = (int64_t)gridDim.x * (SIGN_THREADS / 32);
    const int lane = threadIdx.x & 31;
    for (int64_t item = (int64_t)blockIdx.x * (SIGN_THREADS / 32) + (threadIdx.x >> 5);
         item < groups * qni_gpu_sign_lines(&args); item += warps) {
        const int64_t line = item / groups, first = item % groups * SIGN_WORDS;
        const int64_t y = line % args.field.points[1];
        const int64_t z = line / args.field.points[1] + qni_gpu_sign_plane(&args);
        int sign[SIGN_WORDS], odd = 0;
#pragma unroll
        for (int n = 0; n < SIGN_WORDS; ++n)
            sign[n] = qni_gpu_sign(&args.field, scalar, 32 * (first + n) + lane, y, z, &odd);
#pragma unroll
        for (int n = 0; n < SIGN_WORDS; ++n) {
            const uint32_t bits = __ballot_sync(0xffffffffu, sign[n]);
            if (lane == n && first + n < args.line_words)
                args.signs[line * args.line_words + first + n] = bits;
        }
        if (__any_sync(0xffffffffu, odd) && lane == 0)
            args.totals->nonfinite = 1; /* whoever writes, writes the same */
    }
}

/* ---- the device ------------------------------------------------------------------------------ */

struct gpu {
    qni_device device;
    cudaStream_t stream;
    cudaEvent_t mark[2]; /* made when first asked for */
    int number, processors;
};

static qn_status fail(qn_error *error, qn_status status, const char *what, cudaError_t code) {
    if (error) {
        error->status = status;
        snprintf(error->message, sizeof error->message, "%s: %s (CUDA error %d)", what,
                 cudaGetErrorString(code), (int)code);
    }
    return status;
}

/* Errors that a later call would hear of again are taken out first. */
static qn_status check(cudaError_t code, const char *what, qn_error *error) {
    if (code == cudaSuccess)
        return QN_OK;
    (void)cudaGetLastError();
    return fail(error,
                code == cudaErrorMemoryAllocation ? QN_ERROR_OUT_OF_MEMORY : QN_ERROR_INTERNAL,
                what, code);
}

/* Threads have a current device each, and callers may have chosen another since. */
static gpu *self(qni_device *device) {
    gpu *g = static_cast<gpu *>(device->self);
    (void)cudaSetDevice(g->number); /* a failure is heard of in the call that follows */
    return g;
}

static qn_status gpu_alloc(qni_device *device, int64_t bytes, void **out, qn_error *error) {
    (void)self(device);
    const cudaError_t code = cudaMalloc(out, (size_t)bytes);
    if (code == cudaSuccess)
        return QN_OK;
    *out = NULL;
    (void)cudaGetLastError();
    if (code != cudaErrorMemoryAllocation)
        return fail(error, QN_ERROR_INTERNAL, "GPU memory could not be had", code);
    if (error) {
        error->status = QN_ERROR_OUT_OF_MEMORY;
        snprintf(error->message, sizeof error->message,
                 "the GPU has no %lld bytes left: take --device cpu", (long long)bytes);
    }
    return QN_ERROR_OUT_OF_MEMORY;
}

static void gpu_free(qni_device *device, void *memory) {
    (void)self(device);
    (void)cudaFree(memory); /* at the end nobody is left to tell */
}

static int64_t gpu_free_bytes(qni_device *device) {
    size_t free_bytes = 0, total = 0;
    (void)self(device);
    if (cudaMemGetInfo(&free_bytes, &total) != cudaSuccess)
        return 0;
    return (int64_t)free_bytes;
}

static qn_status gpu_upload(qni_device *device, void *to, const void *from, int64_t bytes,
                            qn_error *error) {
    return check(
        cudaMemcpyAsync(to, from, (size_t)bytes, cudaMemcpyHostToDevice, self(device)->stream),
        "copying to the GPU", error);
}

static qn_status gpu_upload_rows(qni_device *device, void *to, const void *from, int64_t row_bytes,
                                 int64_t stride, int64_t rows, qn_error *error) {
    return check(cudaMemcpy2DAsync(to, (size_t)row_bytes, from, (size_t)stride, (size_t)row_bytes,
                                   (size_t)rows, cudaMemcpyHostToDevice, self(device)->stream),
                 "copying rows to the GPU", error);
}

static qn_status gpu_download(qni_device *device, void *to, const void *from, int64_t bytes,
                              qn_error *error) {
    return check(
        cudaMemcpyAsync(to, from, (size_t)bytes, cudaMemcpyDeviceToHost, self(device)->stream),
        "copying from the GPU", error);
}

static qn_status gpu_fill(qni_device *device, void *memory, int byte, int64_t bytes,
                          qn_error *error) {
    return check(cudaMemsetAsync(memory, byte, (size_t)bytes, self(device)->stream),
                 "filling GPU memory", error);
}

static qn_status gpu_copy(qni_device *device, void *to, const void *from, int64_t bytes,
                          qn_error *error) {
    return check(
        cudaMemcpyAsync(to, from, (size_t)bytes, cudaMemcpyDeviceToDevice, self(device)->stream),
        "copying within the GPU", error);
}

static qn_status gpu_mark(qni_device *device, int index, qn_error *error) {
    gpu *g = self(device);
    if (!g->mark[index])
        QNI_CUDA_TRY(check(cudaEventCreate(&g->mark[index]), "making a CUDA event", error));
    return check(cudaEventRecord(g->mark[index], g->stream), "recording a CUDA event", error);
}

static qn_status gpu_elapsed(qni_device *device, double *milliseconds, qn_error *error) {
    const gpu *g = self(device);
    float elapsed = 0;
    QNI_CUDA_TRY(check(cudaEventSynchronize(g->mark[1]), "waiting for a CUDA event", error));
    QNI_CUDA_TRY(check(cudaEventElapsedTime(&elapsed, g->mark[0], g->mark[1]),
                       "reading CUDA events", error));
    *milliseconds = elapsed;
    return QN_OK;
}

static void launch_signs(const qni_gpu_args *args, unsigned blocks, cudaStream_t stream) {
    switch (args->field.scalar) {
#define LAUNCH_SIGNS(number, type)                                                                 \
    case number:                                                                                   \
        kernel_signs<number><<<blocks, SIGN_THREADS, 0, stream>>>(*args);                          \
        break;
        QNI_GPU_SCALAR_MAP(LAUNCH_SIGNS)
#undef LAUNCH_SIGNS
    }
}

static qn_status gpu_launch(qni_device *device, qni_gpu_kernel kernel, const qni_gpu_args *args,
                            int64_t blocks, qn_error *error) {
    const gpu *g = self(device);
    const int64_t most = (int64_t)g->processors * BLOCKS_A_PROCESSOR;
    const unsigned grid = (unsigned)(blocks < most ? blocks : most);
    const char *name = "signs";
    switch (kernel) {
    case QNI_GPU_KERNEL_signs:
        launch_signs(args, grid, g->stream);
        break;
#define LAUNCH_CASE(kernel_name)                                                                   \
    case QNI_GPU_KERNEL_##kernel_name:                                                             \
        name = #kernel_name;                                                                       \
        kernel_##kernel_name<<<grid, QNI_GPU_##kernel_name##_THREADS, 0, g->stream>>>(*args);      \
        break;
        QNI_GPU_KERNEL_MAP(LAUNCH_CASE)
#undef LAUNCH_CASE
    case QNI_GPU_KERNEL_COUNT:
        break;
    }
    char what[64];
    snprintf(what, sizeof what, "starting GPU kernel '%s'", name);
    return check(cudaGetLastError(), what, error);
}

static qn_status gpu_finish(qni_device *device, qn_error *error) {
    return check(cudaStreamSynchronize(self(device)->stream), "working on the GPU", error);
}

/* ---- opening --------------------------------------------------------------------------------- */

static qn_status no_device(qn_error *error, const char *reason) {
    if (error) {
        error->status = QN_ERROR_UNSUPPORTED;
        snprintf(error->message, sizeof error->message,
                 "no CUDA device: %s; take --device cpu, or leave it out", reason);
    }
    return QN_ERROR_UNSUPPORTED;
}

static qn_status find_device(int *number, qn_error *error) {
    int count = 0, driver = 0;
    if (cudaDriverGetVersion(&driver) != cudaSuccess || driver == 0) {
        (void)cudaGetLastError();
        return no_device(error, "driver missing");
    }
    const cudaError_t code = cudaGetDeviceCount(&count);
    (void)cudaGetLastError();
    if (code == cudaErrorInsufficientDriver)
        return no_device(error, "its driver is older than this program's CUDA");
    if (code != cudaSuccess)
        return no_device(error, cudaGetErrorString(code));
    if (count == 0)
        return no_device(error, "the driver finds none");
    if (cudaGetDevice(number) != cudaSuccess) {
        (void)cudaGetLastError();
        return no_device(error, "the driver gives none out");
    }
    return QN_OK;
}

/* A device whose architecture this program was not built for is found out here, by asking for one
 * kernel's attributes. */
static qn_status open_device(gpu *g, qn_error *error) {
    cudaFuncAttributes attributes;
    QNI_CUDA_TRY(check(cudaSetDevice(g->number), "choosing the GPU", error));
    QNI_CUDA_TRY(
        check(cudaDeviceGetAttribute(&g->processors, cudaDevAttrMultiProcessorCount, g->number),
              "asking for the GPU's size", error));
    if (cudaFuncGetAttributes(&attributes, kernel_emit) != cudaSuccess) {
        (void)cudaGetLastError();
        return no_device(error, "this program has no code for its architecture (7.5 and later)");
    }
    return QN_OK;
}

extern "C" qn_status qni_cuda_open(void *stream, qni_device **device_out, qn_error *error) {
    int number;
    *device_out = NULL;
    QNI_CUDA_TRY(find_device(&number, error));
    gpu *g = static_cast<gpu *>(calloc(1, sizeof *g));
    if (!g)
        return fail(error, QN_ERROR_OUT_OF_MEMORY, "opening the GPU", cudaErrorMemoryAllocation);
    g->number = number;
    g->stream = static_cast<cudaStream_t>(stream);
    g->device.self = g;
    g->device.alloc = gpu_alloc;
    g->device.free = gpu_free;
    g->device.free_bytes = gpu_free_bytes;
    g->device.upload = gpu_upload;
    g->device.upload_rows = gpu_upload_rows;
    g->device.download = gpu_download;
    g->device.fill = gpu_fill;
    g->device.launch = gpu_launch;
    g->device.copy = gpu_copy;
    g->device.mark = gpu_mark;
    g->device.elapsed = gpu_elapsed;
    g->device.finish = gpu_finish;
    const qn_status status = open_device(g, error);
    if (status != QN_OK) {
        free(g);
        return status;
    }
    *device_out = &g->device;
    return QN_OK;
}

extern "C" void qni_cuda_close(qni_device *device) {
    if (!device)
        return;
    gpu *g = self(device);
    for (int n = 0; n < 2; ++n)
        if (g->mark[n])
            (void)cudaEventDestroy(g->mark[n]); /* nobody is left to tell */
    free(g);
}

extern "C" qn_status qni_cuda_describe(qni_device *device, char text[128], qn_error *error) {
    cudaDeviceProp properties;
    QNI_CUDA_TRY(check(cudaGetDeviceProperties(&properties, self(device)->number),
                       "asking for the GPU's name", error));
    snprintf(text, 128, "%.80s, %d processors, compute %d.%d", properties.name,
             properties.multiProcessorCount, properties.major, properties.minor);
    return QN_OK;
}
