// SPDX-License-Identifier: MIT
/* Sort keys in place: insertion for the few, heap sort for the many. */
#ifndef QNI_MESH_SORT_KEYS_H
#define QNI_MESH_SORT_KEYS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct qni_key {
    uint64_t high, low;
} qni_key;

static inline bool qni_key_less(qni_key a, qni_key b) {
    return a.high < b.high || (a.high == b.high && a.low < b.low);
}

static inline void qni_sift_key(qni_key *keys, int64_t at, int64_t count) {
    qni_key key = keys[at];
    for (int64_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && qni_key_less(keys[child], keys[child + 1]))
            ++child;
        if (!qni_key_less(key, keys[child]))
            break;
        keys[at] = keys[child];
    }
    keys[at] = key;
}

static inline void qni_sort_keys(qni_key *keys, int64_t count) {
    if (count <= 32) {
        for (int64_t i = 1; i < count; ++i) {
            qni_key key = keys[i];
            int64_t at = i;
            for (; at > 0 && qni_key_less(key, keys[at - 1]); --at)
                keys[at] = keys[at - 1];
            keys[at] = key;
        }
        return;
    }
    for (int64_t i = count / 2; i-- > 0;)
        qni_sift_key(keys, i, count);
    for (int64_t last = count - 1; last > 0; --last) {
        qni_key largest = keys[0];
        keys[0] = keys[last];
        keys[last] = largest;
        qni_sift_key(keys, 0, last);
    }
}

#endif
