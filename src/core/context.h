// SPDX-License-Identifier: MIT
/* The context from inside: memory, threads, log and progress for all modules. */
#ifndef QNI_CORE_CONTEXT_H
#define QNI_CORE_CONTEXT_H

#include <qn/base.h>

/* Bytes for `count` things of `size`. NULL when the product overflows or the allocator has none
 * left; never NULL for a count of 0. Alignment is 64, a cache line. May be called from any worker.
 */
void *qni_alloc(qn_context *context, int64_t count, size_t size);
/* The same, cleared. */
void *qni_alloc_zero(qn_context *context, int64_t count, size_t size);
/* Give back what qni_alloc() gave for the same count and size. NULL is accepted. */
void qni_free(qn_context *context, void *pointer, int64_t count, size_t size);
/* Move `old_count` things into room for `new_count`; on failure NULL, and the old memory stays. */
void *qni_realloc(qn_context *context, void *pointer, int64_t old_count, int64_t new_count,
                  size_t size);

/* Let the system have the pages that were freed: what comes next is large, and of another shape. */
void qni_return_memory(qn_context *context);

/* True when the caller asked to stop. To be called on the calling thread only. */
bool qni_progress(qn_context *context, const char *stage, double fraction);
void qni_log(qn_context *context, qn_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
