// SPDX-License-Identifier: MIT
/* Numbers of vertices and quads from their places in the lattice, by counting bits. */
#ifndef QNI_GPU_LOOKUP_HD_H
#define QNI_GPU_LOOKUP_HD_H

#include "dmc/cell_hd.h"
#include "gpu/leaves_hd.h"

enum { QNI_GPU_NO_ENTRY = 0xffff };
#define QNI_GPU_NO_HALFEDGE 0xffffffffu

/* The place among the active leaves of the leaf that holds a lattice point. */
QN_HD_INLINE uint32_t qni_gpu_slot_of(const qni_gpu_args *a, const int32_t point[3]) {
    return a->slot[qni_gpu_leaf_index(&a->field, point[0] >> 3, point[1] >> 3, point[2] >> 3)];
}

/* The first entry of the leaf's multiple cells that is not before `cell`. */
QN_HD_INLINE uint32_t qni_gpu_find_multi(const qni_gpu_args *a, int64_t slot, int cell) {
    uint32_t low = qni_gpu_place(a, QNI_GPU_MULTIS, slot);
    uint32_t high = qni_gpu_place(a, QNI_GPU_MULTIS, slot + 1);
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (a->multis[middle].cell < cell)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The vertices that multiple cells before `cell` add; its own entry, or QNI_GPU_NO_ENTRY. */
QN_HD_INLINE uint32_t qni_gpu_extra_before(const qni_gpu_args *a, int64_t slot, int cell,
                                           int *entry) {
    const uint32_t first = qni_gpu_place(a, QNI_GPU_MULTIS, slot);
    const uint32_t end = qni_gpu_place(a, QNI_GPU_MULTIS, slot + 1);
    *entry = QNI_GPU_NO_ENTRY;
    if (first == end)
        return 0;
    const uint32_t at = qni_gpu_find_multi(a, slot, cell);
    if (at < end && a->multis[at].cell == cell) {
        *entry = a->multis[at].entry;
        return a->multis[at].extra_before;
    }
    if (at == first)
        return 0;
    return (uint32_t)a->multis[at - 1].extra_before +
           (uint32_t)qni_entry_polygons(a->multis[at - 1].entry) - 1;
}

/* The vertex of the polygon of an active cell that crosses its edge `edge`. */
QN_HD_INLINE uint32_t qni_gpu_vertex_of(const qni_gpu_args *a, const int32_t cell[3], int edge) {
    const uint32_t slot = qni_gpu_slot_of(a, cell);
    const int bit = (cell[0] & 7) + 8 * (cell[1] & 7), z = cell[2] & 7;
    const qni_gpu_leaf *leaf = a->leaves + slot;
    int entry;
    uint32_t vertex = qni_gpu_place(a, QNI_GPU_VERTICES, slot) + leaf->before[z] +
                      (uint32_t)qni_bits_below(leaf->active[z], bit);
    vertex += qni_gpu_extra_before(a, slot, bit + 64 * z, &entry);
    if (entry != QNI_GPU_NO_ENTRY)
        vertex += (uint32_t)qni_entry_polygon_of_edge(entry, edge);
    return vertex;
}

/* The four cells round a lattice edge are in the slab. */
QN_HD_INLINE int qni_gpu_slab_has_ring(const qni_gpu_args *a, const int32_t point[3], int axis) {
    const int32_t lowest = point[2] - (axis != 2), first = a->field.first_layer;
    return lowest < 0 || ((lowest >> 3) >= first && (point[2] >> 3) < first + a->field.layers);
}

/* The quad of a crossed lattice edge, or QNI_GPU_NO_HALFEDGE where it has none, or one that the
 * slab does not know: eight cells and more away from what is the slab's own. */
QN_HD_INLINE uint32_t qni_gpu_quad_of(const qni_gpu_args *a, const int32_t point[3], int axis) {
    const int64_t cells[3] = {a->field.points[0] - 1, a->field.points[1] - 1,
                              a->field.points[2] - 1};
    if (!qni_lattice_edge_is_inner(cells, point, axis) || !qni_gpu_slab_has_ring(a, point, axis))
        return QNI_GPU_NO_HALFEDGE;
    const uint32_t slot = qni_gpu_slot_of(a, point);
    const int bit = (point[0] & 7) + 8 * (point[1] & 7), z = point[2] & 7;
    const qni_gpu_quads *quads = a->leaf_quads + slot;
    return qni_gpu_place(a, QNI_GPU_QUADS, slot) + quads->before[axis][z] +
           (uint32_t)qni_bits_below(quads->mask[axis][z], bit);
}

#endif
