// SPDX-License-Identifier: MIT
/* Blocks of growing size, each filled from its start. */
#include "core/pool.h"

#include <stdalign.h>
#include <stddef.h>

enum { FIRST_BYTES = 4 << 10, LARGEST_BYTES = 64 << 10 };

typedef struct qni_pool_block {
    struct qni_pool_block *before;
    int64_t bytes, used; /* of `room` */
    alignas(max_align_t) char room[];
} qni_pool_block;

static bool add_block(qn_context *context, qni_pool *pool, int64_t least) {
    int64_t bytes = pool->last ? 2 * pool->last->bytes : FIRST_BYTES;
    bytes = bytes > LARGEST_BYTES ? LARGEST_BYTES : bytes;
    bytes = bytes < least ? least : bytes;
    qni_pool_block *block = qni_alloc(context, (int64_t)sizeof *block + bytes, 1);
    if (!block)
        return false;
    block->before = pool->last;
    block->bytes = bytes;
    block->used = 0;
    pool->last = block;
    return true;
}

void *qni_pool_take(qn_context *context, qni_pool *pool, int64_t count, size_t size) {
    const int64_t unit = alignof(max_align_t);
    int64_t bytes;
    if (count < 0 || __builtin_mul_overflow(count, (int64_t)size, &bytes) || bytes > INT64_MAX / 2)
        return NULL;
    bytes = (bytes + unit - 1) / unit * unit;
    if ((!pool->last || bytes > pool->last->bytes - pool->last->used) &&
        !add_block(context, pool, bytes))
        return NULL;
    void *taken = pool->last->room + pool->last->used;
    pool->last->used += bytes;
    return taken;
}

void qni_pool_free(qn_context *context, qni_pool *pool) {
    while (pool->last) {
        qni_pool_block *block = pool->last;
        pool->last = block->before;
        qni_free(context, block, (int64_t)sizeof *block + block->bytes, 1);
    }
}
