// SPDX-License-Identifier: MIT
/* A block a lattice leaf of a sparse volume that can hold surface: its 9^3 signs, from the eight
 * blocks of samples it touches, and whether they differ. */
#ifndef QNI_GPU_SPARSE_HD_H
#define QNI_GPU_SPARSE_HD_H

#include "gpu/signs_hd.h"

enum { QNI_GPU_sparse_signs_THREADS = 96, QNI_GPU_sparse_signs_PHASES = 3 };

typedef struct qni_gpu_sparse_signs_shared {
    qni_gpu_block block[8]; /* 1 for the next one in x, 2 in y, 4 in z */
    uint16_t line[QNI_GPU_SIGN_LINES];
} qni_gpu_sparse_signs_shared;

QN_HD_INLINE int64_t qni_gpu_sparse_signs_items(const qni_gpu_args *a) {
    return a->field.blocks.key_count;
}

/* The sign of a stored number, or of a value that fills a block. */
QN_HD_INLINE int qni_gpu_sign_in_block(const qni_gpu_field *field, const qni_gpu_block *block,
                                       int64_t place, int *odd) {
    if (block->at < 0)
        return qni_gpu_settle(field, block->value) >= 0;
    return qni_gpu_stored_sign(field, field->scalar, block->at + place, odd);
}

QN_HD_INLINE void qni_gpu_sparse_signs(const qni_gpu_args *a, qni_gpu_sparse_signs_shared *s,
                                       int64_t item, int phase, int thread) {
    const qni_gpu_field *field = &a->field;
    if (phase == 0) {
        int32_t leaf[3];
        qni_gpu_leaf_of_key(&field->blocks, field->blocks.keys[item], leaf);
        if (thread < 8)
            s->block[thread] =
                qni_gpu_find_block(&field->blocks, leaf[0] + (thread & 1),
                                   leaf[1] + (thread >> 1 & 1), leaf[2] + (thread >> 2));
    } else if (phase == 1 && thread < QNI_GPU_SIGN_LINES) {
        const int y = thread % 9, z = thread / 9, odd_block = (y == 8) * 2 + (z == 8) * 4;
        const int64_t place = qni_gpu_place_in_block(0, y, z);
        unsigned bits = 0;
        int odd = 0;
        for (int x = 0; x < 8; ++x)
            bits |= (unsigned)qni_gpu_sign_in_block(field, s->block + odd_block, place + x, &odd)
                    << x;
        bits |= (unsigned)qni_gpu_sign_in_block(field, s->block + odd_block + 1, place, &odd) << 8;
        s->line[thread] = (uint16_t)bits;
        a->leaf_signs[item * QNI_GPU_SIGN_LINES + thread] = (uint16_t)bits;
        if (odd)
            a->totals->nonfinite = 1; /* whoever writes, writes the same */
    } else if (phase == 2 && thread == 0) {
        unsigned all = 0x1ff, any = 0;
        for (int n = 0; n < QNI_GPU_SIGN_LINES; ++n) {
            all &= s->line[n];
            any |= s->line[n];
        }
        a->slot[item] = all != 0x1ff && any != 0;
    }
}

#endif
