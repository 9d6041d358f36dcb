// SPDX-License-Identifier: MIT
/* All kernels. Each NAME has qni_gpu_NAME(args, shared, item, phase, thread), its block size and
 * phases as QNI_GPU_NAME_THREADS and QNI_GPU_NAME_PHASES, and how many items there are, which may
 * be known on the device only. An item is the work of one block; its threads pass a barrier after
 * each phase. kernels.cu runs these on a GPU, and a launcher in the tests on the processor. */
#ifndef QNI_GPU_KERNELS_HD_H
#define QNI_GPU_KERNELS_HD_H

#include "gpu/emit_hd.h"
#include "gpu/leaves_hd.h"
#include "gpu/repair_hd.h"
#include "gpu/scan_hd.h"
#include "gpu/signs_hd.h"
#include "gpu/simplify_hd.h"
#include "gpu/slab_hd.h"
#include "gpu/sparse_hd.h"

#define QNI_GPU_KERNEL_MAP(X)                                                                      \
    X(measure)                                                                                     \
    X(find_leaves)                                                                                 \
    X(sparse_signs)                                                                                \
    X(list_leaves)                                                                                 \
    X(scan_sums)                                                                                   \
    X(scan_tops)                                                                                   \
    X(scan_places)                                                                                 \
    X(count)                                                                                       \
    X(record)                                                                                      \
    X(emit)                                                                                        \
    X(link)                                                                                        \
    X(mark_quads)                                                                                  \
    X(count_marks)                                                                                 \
    X(list_splits)                                                                                 \
    X(note_splits)                                                                                 \
    X(place_faces)                                                                                 \
    X(split_quads)                                                                                 \
    X(link_splits)                                                                                 \
    X(split_apart)                                                                                 \
    X(split_valences)                                                                              \
    X(find_first)                                                                                  \
    X(merge_first)                                                                                 \
    X(spread)                                                                                      \
    X(look)                                                                                        \
    X(decide)                                                                                      \
    X(carry_out)                                                                                   \
    X(count_vertices)                                                                              \
    X(count_quads)                                                                                 \
    X(pack_vertices)                                                                               \
    X(pack_quads)                                                                                  \
    X(note_own)                                                                                    \
    X(note_own_splits)                                                                             \
    X(renumber_quads)                                                                              \
    X(renumber_halfedges)

/* `signs` stands apart: there the 32 threads of a warp make one word together. */
typedef enum qni_gpu_kernel {
    QNI_GPU_KERNEL_signs,
#define QNI_GPU_KERNEL_ENUM(name) QNI_GPU_KERNEL_##name,
    QNI_GPU_KERNEL_MAP(QNI_GPU_KERNEL_ENUM)
#undef QNI_GPU_KERNEL_ENUM
        QNI_GPU_KERNEL_COUNT
} qni_gpu_kernel;

#endif
