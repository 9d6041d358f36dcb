// SPDX-License-Identifier: MIT
/* The context: one allocator whose use is counted, a thread count, log and progress. */
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

/* Of arrays, so that rows of them start on cache lines; small things have the common one. */
enum { ALIGNMENT = 64, SMALL_BYTES = 1024 };

/* Large blocks start on a huge page and ask for huge ones: a mesh of hundreds of megabytes written
 * once would otherwise cost more time in page faults than in computing. */
static const size_t huge_page = (size_t)2 << 20;
static const size_t huge_from = (size_t)8 << 20;

struct qn_context {
    qn_context_options options;
    atomic_llong current_bytes;
    atomic_llong peak_bytes;
};

static void *default_alloc(void *user, size_t size, size_t alignment) {
    (void)user;
    alignment = size >= huge_from ? huge_page : alignment;
    size_t rounded = (size + alignment - 1) / alignment * alignment;
    if (rounded < size)
        return NULL;
    if (alignment <= _Alignof(max_align_t)) /* malloc() reuses small blocks much faster */
        return malloc(size);
    void *pointer = aligned_alloc(alignment, rounded ? rounded : alignment);
#ifdef MADV_HUGEPAGE
    if (pointer && size >= huge_from)
        madvise(pointer, rounded, MADV_HUGEPAGE); /* a hint: failing changes nothing */
#endif
    return pointer;
}

static void default_free(void *user, void *pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

qn_status qn_context_create(const qn_context_options *options, qn_context **context_out,
                            qn_error *error) {
    *context_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_context_options_init", error);
    qn_context_options own;
    qn_context_options_init(&own);
    if (options)
        own = *options;
    if (own.threads < 0 || own.threads > 4096)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "%d threads: give a number from 1 to 4096, or 0 for all cores",
                        own.threads);
    if (!own.allocator.alloc != !own.allocator.free)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "an allocator needs both functions, alloc and free");
    if (!own.allocator.alloc) {
        own.allocator.alloc = default_alloc;
        own.allocator.free = default_free;
    }
    if (own.threads == 0)
        own.threads = qni_core_count();
    qn_context *context = own.allocator.alloc(own.allocator.user, sizeof *context, ALIGNMENT);
    if (!context)
        return qni_fail_memory(error, "a context");
    context->options = own;
    atomic_init(&context->current_bytes, 0);
    atomic_init(&context->peak_bytes, 0);
    *context_out = context;
    return QN_OK;
}

void qn_context_destroy(qn_context *context) {
    if (context)
        context->options.allocator.free(context->options.allocator.user, context, sizeof *context);
}

int32_t qn_context_threads(const qn_context *context) {
    return context->options.threads;
}

qn_memory_use qn_context_memory(const qn_context *context) {
    qn_memory_use use = {atomic_load(&context->current_bytes), atomic_load(&context->peak_bytes)};
    return use;
}

void qn_context_reset_peak(qn_context *context) {
    atomic_store(&context->peak_bytes, atomic_load(&context->current_bytes));
}

static void count_bytes(qn_context *context, long long bytes) {
    long long now = atomic_fetch_add(&context->current_bytes, bytes) + bytes;
    long long peak = atomic_load(&context->peak_bytes);
    while (now > peak && !atomic_compare_exchange_weak(&context->peak_bytes, &peak, now)) {
    }
}

void *qni_alloc(qn_context *context, int64_t count, size_t size) {
    if (count < 0 || (size && (uint64_t)count > (uint64_t)PTRDIFF_MAX / size))
        return NULL;
    size_t bytes = (size_t)count * size;
    const qn_allocator *allocator = &context->options.allocator;
    void *pointer = allocator->alloc(allocator->user, bytes ? bytes : 1,
                                     bytes < SMALL_BYTES ? _Alignof(max_align_t) : ALIGNMENT);
    if (pointer)
        count_bytes(context, (long long)(bytes ? bytes : 1));
    return pointer;
}

void *qni_alloc_zero(qn_context *context, int64_t count, size_t size) {
    void *pointer = qni_alloc(context, count, size);
    if (pointer)
        memset(pointer, 0, (size_t)count * size);
    return pointer;
}

void qni_free(qn_context *context, void *pointer, int64_t count, size_t size) {
    if (!pointer)
        return;
    size_t bytes = (size_t)count * size;
    bytes = bytes ? bytes : 1;
    const qn_allocator *allocator = &context->options.allocator;
    allocator->free(allocator->user, pointer, bytes);
    count_bytes(context, -(long long)bytes);
}

void *qni_realloc(qn_context *context, void *pointer, int64_t old_count, int64_t new_count,
                  size_t size) {
    void *fresh = qni_alloc(context, new_count, size);
    if (!fresh)
        return NULL;
    int64_t kept = old_count < new_count ? old_count : new_count;
    if (pointer && kept > 0)
        memcpy(fresh, pointer, (size_t)kept * size);
    qni_free(context, pointer, old_count, size);
    return fresh;
}

void qni_return_memory(qn_context *context) {
#ifdef __GLIBC__
    if (context->options.allocator.alloc == default_alloc)
        malloc_trim(0);
#else
    (void)context;
#endif
}

bool qni_progress(qn_context *context, const char *stage, double fraction) {
    const qn_context_options *options = &context->options;
    return options->progress && options->progress(options->user, stage, fraction) != 0;
}

void qni_log(qn_context *context, qn_log_level level, const char *format, ...) {
    const qn_context_options *options = &context->options;
    if (!options->log)
        return;
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    options->log(options->user, level, message);
}
