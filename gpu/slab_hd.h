// SPDX-License-Identifier: MIT
/* What slabs need beside the kernels of a whole volume: where their own part begins and ends, and
 * its numbers in the mesh. */
#ifndef QNI_GPU_SLAB_HD_H
#define QNI_GPU_SLAB_HD_H

#include "gpu/repair_hd.h"

/* ---- the own part ---------------------------------------------------------------------------- */

enum { QNI_GPU_note_own_THREADS = 32, QNI_GPU_note_own_PHASES = 1 };
typedef qni_gpu_nothing_shared qni_gpu_note_own_shared;

QN_HD_INLINE int64_t qni_gpu_note_own_items(const qni_gpu_args *a) {
    (void)a;
    return 1;
}

/* From the places of all leaves: one thread each end and channel. */
QN_HD_INLINE void qni_gpu_note_own(const qni_gpu_args *a, qni_gpu_note_own_shared *s, int64_t item,
                                   int phase, int thread) {
    const int end = thread & 1, channel = thread >> 1;
    (void)s;
    (void)item;
    (void)phase;
    if (channel >= QNI_GPU_CHANNELS)
        return;
    const uint32_t slot = a->slot[qni_gpu_leaf_index(&a->field, 0, 0, a->own_layers[end])];
    a->totals->own[end][channel] = a->counts[channel * a->count_stride + slot];
    if (channel == 0)
        a->totals->own_active[end] = slot;
}

enum { QNI_GPU_note_own_splits_THREADS = 32, QNI_GPU_note_own_splits_PHASES = 1 };
typedef qni_gpu_nothing_shared qni_gpu_note_own_splits_shared;

QN_HD_INLINE int64_t qni_gpu_note_own_splits_items(const qni_gpu_args *a) {
    (void)a;
    return 1;
}

QN_HD_INLINE void qni_gpu_note_own_splits(const qni_gpu_args *a, qni_gpu_note_own_splits_shared *s,
                                          int64_t item, int phase, int thread) {
    (void)s;
    (void)item;
    (void)phase;
    if (thread >= 2)
        return;
    const uint32_t quad = (uint32_t)a->totals->own[thread][QNI_GPU_QUADS];
    uint32_t rank = a->mark_ranks[quad / 32];
    if (quad % 32)
        rank += (uint32_t)qni_bits_below(a->marks[quad / 32], (int)(quad % 32));
    a->totals->own_splits[thread] = rank;
    a->totals->own_split_quads[thread] = a->split_sizes[rank];
}

/* ---- numbers in the mesh --------------------------------------------------------------------- */

QN_HD_INLINE uint32_t qni_gpu_vertex_in_mesh(const qni_gpu_args *a, uint32_t vertex) {
    if (vertex < a->plain_vertices)
        return vertex + a->shifts.vertices;
    const int of_face = vertex - a->plain_vertices < 4 * (uint32_t)a->doubled_count;
    return vertex + (of_face ? a->shifts.points : a->shifts.centres);
}

QN_HD_INLINE uint32_t qni_gpu_halfedge_in_mesh(const qni_gpu_args *a, uint32_t halfedge) {
    if (halfedge == QNI_GPU_NO_HALFEDGE)
        return halfedge;
    const int plain = halfedge / 4 < a->plain_quads;
    return halfedge + 4 * (plain ? a->shifts.quads : a->shifts.extra_quads);
}

QN_HD_INLINE void qni_gpu_renumber_quad(const qni_gpu_args *a, int64_t n) {
    const size_t first = 4 * (size_t)(a->range_first + n);
    for (size_t k = first; k < first + 4; ++k) {
        a->quads[k] = qni_gpu_vertex_in_mesh(a, a->quads[k]);
        if (a->twins)
            a->twins[k] = qni_gpu_halfedge_in_mesh(a, a->twins[k]);
    }
}
QNI_GPU_THINGS(renumber_quads, a->range_count, qni_gpu_renumber_quad)

QN_HD_INLINE void qni_gpu_renumber_halfedge(const qni_gpu_args *a, int64_t n) {
    uint32_t *halfedge = a->vertex_halfedges + a->range_first + n;
    *halfedge = qni_gpu_halfedge_in_mesh(a, *halfedge);
}
QNI_GPU_THINGS(renumber_halfedges, a->range_count, qni_gpu_renumber_halfedge)

#endif
