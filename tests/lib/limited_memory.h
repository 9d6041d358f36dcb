// SPDX-License-Identifier: MIT
/* An allocator that gives so many blocks and no more, and counts those not given back. */
#ifndef TESTS_LIB_LIMITED_MEMORY_H
#define TESTS_LIB_LIMITED_MEMORY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct limited_memory {
    int64_t left; /* blocks still to be had */
    int64_t live; /* blocks given and not given back */
    bool refused; /* some block was */
} limited_memory;

static inline void *limited_alloc(void *user, size_t size, size_t alignment) {
    limited_memory *state = user;
    if (state->left-- <= 0) {
        state->refused = true;
        return NULL;
    }
    void *pointer = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    state->live += pointer != NULL;
    return pointer;
}

static inline void limited_free(void *user, void *pointer, size_t size) {
    (void)size;
    limited_memory *state = user;
    --state->live;
    free(pointer);
}

#endif
