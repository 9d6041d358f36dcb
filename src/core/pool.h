// SPDX-License-Identifier: MIT
/* Memory that is taken piece by piece and given back at once: for many small arrays of one life. */
#ifndef QNI_CORE_POOL_H
#define QNI_CORE_POOL_H

#include "core/context.h"

/* All 0 to begin with. One thread may use a pool at a time. */
typedef struct qni_pool {
    struct qni_pool_block *last;
} qni_pool;

/* Room for an array, aligned for any type, not set to anything; NULL when there is no memory. */
void *qni_pool_take(qn_context *context, qni_pool *pool, int64_t count, size_t size);
/* Everything that was taken. */
void qni_pool_free(qn_context *context, qni_pool *pool);

#endif
