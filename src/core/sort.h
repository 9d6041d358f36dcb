// SPDX-License-Identifier: MIT
/* Sorting with the context's memory; qsort() may take the C library's. */
#ifndef QNI_CORE_SORT_H
#define QNI_CORE_SORT_H

#include "core/context.h"

/* Ascending and stable, in O(n log n), with room for as many items again; false when there is none.
 */
bool qni_sort(qn_context *context, void *items, int64_t count, size_t size,
              int (*compare)(const void *first, const void *second));

#endif
