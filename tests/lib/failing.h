// SPDX-License-Identifier: MIT
/* An allocator whose n-th call fails, and a progress callback that cancels at the n-th look. */
#ifndef TEST_FAILING_H
#define TEST_FAILING_H

#include <qn/qn.h>

#include <stdlib.h>

typedef struct test_failing {
    int64_t allocations_left; /* the call that finds 0 fails; negative: none does */
    int64_t looks_left;       /* likewise for progress */
    int64_t held;             /* blocks not yet given back */
} test_failing;

static inline void *test_failing_alloc(void *user, size_t size, size_t alignment) {
    test_failing *failing = user;
    if (failing->allocations_left-- == 0)
        return NULL;
    ++failing->held;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static inline void test_failing_free(void *user, void *pointer, size_t size) {
    (void)size;
    --((test_failing *)user)->held;
    free(pointer);
}

static inline int test_failing_progress(void *user, const char *stage, double fraction) {
    test_failing *failing = user;
    (void)stage;
    (void)fraction;
    return failing->looks_left-- == 0;
}

/* A context of one thread; NULL when its own memory is what fails. */
static inline qn_context *test_failing_context(test_failing *failing) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.threads = 1;
    options.allocator = (qn_allocator){failing, test_failing_alloc, test_failing_free};
    options.progress = test_failing_progress;
    options.user = failing;
    qn_context *context = NULL;
    qn_context_create(&options, &context, NULL);
    return context;
}

#endif
