// SPDX-License-Identifier: MIT
/* A block a leaf with surface: its vertices from a tile of values, and its quads. */
#ifndef QNI_GPU_EMIT_HD_H
#define QNI_GPU_EMIT_HD_H

#include "dmc/place_hd.h"
#include "gpu/lookup_hd.h"

enum { QNI_EMIT_THREADS = 128, QNI_GPU_TILE = 11, QNI_GPU_TILE_POINTS = 1331 };
enum { QNI_GPU_TILE_SLICE = QNI_GPU_TILE * QNI_GPU_TILE };

typedef struct qni_gpu_emit_shared {
    double tile[QNI_GPU_TILE][QNI_GPU_TILE][QNI_GPU_TILE];
    qni_leaf_masks masks;
    uint64_t quads[3][8];
    uint16_t quads_before[3][8];
    uint16_t signs[9][9];
    uint16_t cell[QNI_LEAF_CELLS]; /* the active ones, in order */
    qni_gpu_block block[27];       /* sparse: those that the tile touches */
} qni_gpu_emit_shared;

/* ---- vertices -------------------------------------------------------------------------------- */

/* A tile takes the last layer of the block before, eight of its own, two of the block after. */
QN_HD_INLINE void qni_gpu_find_tile_block(const qni_gpu_args *a, qni_gpu_emit_shared *s,
                                          const int32_t leaf[3], int n) {
    if (n < 27)
        s->block[n] =
            qni_gpu_find_block(&a->field.blocks, (int64_t)leaf[0] + n % 3 - 1,
                               (int64_t)leaf[1] + n / 3 % 3 - 1, (int64_t)leaf[2] + n / 9 - 1);
}

QN_HD_INLINE double qni_gpu_tile_value(const qni_gpu_args *a, const qni_gpu_emit_shared *s, int x,
                                       int y, int z) {
    const int block = (x + 7) / 8 + 3 * ((y + 7) / 8) + 9 * ((z + 7) / 8);
    return qni_gpu_value_in_block(&a->field, s->block + block,
                                  qni_gpu_place_in_block(x + 7, y + 7, z + 7));
}

QN_HD_INLINE void qni_gpu_load_sparse_tile(const qni_gpu_args *a, qni_gpu_emit_shared *s,
                                           int thread) {
    double *tile = &s->tile[0][0][0];
    QN_ROLLED
    for (int n = thread; n < QNI_GPU_TILE_POINTS; n += QNI_EMIT_THREADS)
        tile[n] = qni_gpu_tile_value(a, s, n % QNI_GPU_TILE, n / QNI_GPU_TILE % QNI_GPU_TILE,
                                     n / QNI_GPU_TILE_SLICE);
}

QN_HD_INLINE void qni_gpu_load_tile(const qni_gpu_args *a, qni_gpu_emit_shared *s,
                                    const int32_t leaf[3], int thread) {
    double *tile = &s->tile[0][0][0];
    QN_ROLLED
    for (int n = thread; n < QNI_GPU_TILE_POINTS; n += QNI_EMIT_THREADS) {
        const int64_t point[3] = {(int64_t)8 * leaf[0] - 1 + n % QNI_GPU_TILE,
                                  (int64_t)8 * leaf[1] - 1 + n / QNI_GPU_TILE % QNI_GPU_TILE,
                                  (int64_t)8 * leaf[2] - 1 + n / QNI_GPU_TILE_SLICE};
        tile[n] = qni_gpu_dense_extended_value(&a->field, point);
    }
}

/* The active cells of a leaf, in order. */
QN_HD_INLINE void qni_gpu_list_cells(const qni_gpu_args *a, uint16_t cells[QNI_LEAF_CELLS],
                                     int64_t slot, int thread, int threads) {
    const qni_gpu_leaf *leaf = a->leaves + slot;
    for (int cell = thread; cell < QNI_LEAF_CELLS; cell += threads) {
        const uint64_t active = leaf->active[cell >> 6];
        if (active >> (cell & 63) & 1)
            cells[leaf->before[cell >> 6] + qni_bits_below(active, cell & 63)] = (uint16_t)cell;
    }
}

QN_HD_INLINE int qni_gpu_cell_count(const qni_gpu_args *a, int64_t slot) {
    return a->leaves[slot].before[7] + qni_count_bits(a->leaves[slot].active[7]);
}

QN_HD_INLINE void qni_gpu_tally(const qni_gpu_args *a, uint32_t vertex, int kind) {
    if (vertex >= a->own_vertices[0] && vertex < a->own_vertices[1])
        qni_shared_add(&a->totals->tally[vertex % QNI_GPU_STRIPES][kind], 1);
}

QN_HD_APART void qni_gpu_mend_normal(const qni_gpu_args *a, const double d[8],
                                     const double local[3], uint32_t vertex, float normal[3]) {
    qni_mend_normal(d, local, &a->frame, normal);
    qni_gpu_tally(a, vertex, QNI_GPU_NO_GRADIENT);
}

QN_HD_INLINE void qni_gpu_load_corners(const double *corner, double d[8]) {
    for (int c = 0; c < 8; ++c)
        d[c] = corner[(c & 1) + (c >> 1 & 1) * QNI_GPU_TILE + (c >> 2) * QNI_GPU_TILE_SLICE];
}

/* Position and normal at a local point of the cell whose lowest corner is `corner` in the tile. */
QN_HD_INLINE void qni_gpu_store_vertex(const qni_gpu_args *a, const double *corner,
                                       const double cell[3], const double local[3],
                                       uint32_t vertex) {
    qni_placed placed;
#define QNI_GPU_S(n) corner[qni_stencil_offset(n, QNI_GPU_TILE, QNI_GPU_TILE_SLICE)]
    QNI_PLACE(QNI_GPU_S, cell[0], cell[1], cell[2], local[0], local[1], local[2], &a->frame,
              placed);
#undef QNI_GPU_S
    const size_t at = 3 * (size_t)vertex;
    a->positions[at] = placed.px;
    a->positions[at + 1] = placed.py;
    a->positions[at + 2] = placed.pz;
    if (!a->normals)
        return;
    float normal[3] = {placed.nx, placed.ny, placed.nz};
    if (!qni_is_unit(normal)) {
        double d[8];
        qni_gpu_load_corners(corner, d);
        qni_gpu_mend_normal(a, d, local, vertex, normal);
    }
    a->normals[at] = normal[0];
    a->normals[at + 1] = normal[1];
    a->normals[at + 2] = normal[2];
}

/* The local point of one polygon of a cell where no axis line will do. */
QN_HD_APART void qni_gpu_find_point(const qni_gpu_args *a, const double d[8], int entry,
                                    int polygon, uint32_t vertex, double local[3]) {
    const qni_point point =
        qni_point_of_polygon(d, qni_entry_edges(entry, polygon), qni_entry_next_code(entry));
    const int kind = point.kind == QNI_POINT_SLICE        ? QNI_GPU_BY_SLICE
                     : point.kind == QNI_POINT_DEGENERATE ? QNI_GPU_DEGENERATE
                                                          : QNI_GPU_BY_FALLBACK;
    qni_gpu_tally(a, vertex, kind);
    for (int axis = 0; axis < 3; ++axis)
        local[axis] = point.p[axis];
}

/* The vertices of active cell n of the leaf. */
QN_HD_INLINE void qni_gpu_emit_cell(const qni_gpu_args *a, const qni_gpu_emit_shared *s,
                                    int64_t slot, const int32_t leaf[3], int n) {
    const int index = s->cell[n], x = index & 7, y = index >> 3 & 7, z = index >> 6;
    const double *corner = &s->tile[z + 1][y + 1][x + 1];
    const double cell[3] = {(double)((int64_t)8 * leaf[0] + x), (double)((int64_t)8 * leaf[1] + y),
                            (double)((int64_t)8 * leaf[2] + z)};
    int entry, polygons = 1, on_axis = 0;
    uint32_t vertex = qni_gpu_place(a, QNI_GPU_VERTICES, slot) + (uint32_t)n;
    vertex += qni_gpu_extra_before(a, slot, index, &entry);
    double d[8], local[3];
    qni_gpu_load_corners(corner, d);
    if (entry == QNI_GPU_NO_ENTRY) {
        const qni_axis_point at = qni_point_of_one(d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]);
        local[0] = at.x;
        local[1] = at.y;
        local[2] = at.z;
        on_axis = at.distance < 2;
        if (!on_axis)
            entry = qni_gpu_resolve(d, qni_case_of_values(d)).entry;
    } else {
        polygons = qni_entry_polygons(entry);
    }
    QN_ROLLED
    for (int polygon = 0; polygon < polygons; ++polygon, ++vertex) {
        if (!on_axis)
            qni_gpu_find_point(a, d, entry, polygon, vertex, local);
        qni_gpu_store_vertex(a, corner, cell, local, vertex);
    }
}

/* ---- quads ----------------------------------------------------------------------------------- */

/* How far back the four cells round an edge along `axis` are, counter-clockwise seen from the
 * edge's end: bit a for one lower along axis a. This is also the corner of that cell where its edge
 * starts. */
QN_HD_INLINE int qni_gpu_ring_back(int axis, int place) {
    const int back = axis == 0 ? 0x2046 : axis == 1 ? 0x4015 : 0x1023;
    return back >> (4 * place) & 7;
}

QN_HD_INLINE void qni_gpu_emit_quad(const qni_gpu_args *a, const int32_t point[3], int axis,
                                    int above, uint32_t quad) {
    uint32_t corner[4];
    for (int n = 0; n < 4; ++n) {
        const int back = qni_gpu_ring_back(axis, n);
        const int32_t cell[3] = {point[0] - (back & 1), point[1] - (back >> 1 & 1),
                                 point[2] - (back >> 2)};
        corner[n] = qni_gpu_vertex_of(a, cell, qni_edge_at(axis, back));
    }
    /* Values fall along the axis where the edge starts above: then the outside of an inside above
     * lies ahead. */
    const int forward = above != a->reverse;
    uint32_t *out = a->quads + 4 * (size_t)quad;
    out[0] = corner[0];
    out[1] = forward ? corner[1] : corner[3];
    out[2] = corner[2];
    out[3] = forward ? corner[3] : corner[1];
    if (a->colours)
        a->colours[quad] = (uint8_t)axis;
}

QN_HD_INLINE void qni_gpu_emit_quads(const qni_gpu_args *a, const qni_gpu_emit_shared *s,
                                     int64_t slot, const int32_t leaf[3], int thread) {
    const uint32_t first = qni_gpu_place(a, QNI_GPU_QUADS, slot);
    QN_ROLLED
    for (int n = thread; n < 3 * QNI_LEAF_CELLS; n += QNI_EMIT_THREADS) {
        const int axis = n / QNI_LEAF_CELLS, cell = n % QNI_LEAF_CELLS;
        const int z = cell >> 6, bit = cell & 63;
        const uint64_t mask = s->quads[axis][z];
        if (!(mask >> bit & 1))
            continue;
        const int32_t point[3] = {8 * leaf[0] + (bit & 7), 8 * leaf[1] + (bit >> 3),
                                  8 * leaf[2] + z};
        if (!qni_gpu_slab_has_ring(a, point, axis))
            continue;
        qni_gpu_emit_quad(a, point, axis, (int)(s->masks.corner[0][z] >> bit & 1),
                          first + s->quads_before[axis][z] + (uint32_t)qni_bits_below(mask, bit));
    }
}

/* ---- the kernel ------------------------------------------------------------------------------ */

enum { QNI_GPU_emit_THREADS = QNI_EMIT_THREADS, QNI_GPU_emit_PHASES = 5 };

QN_HD_INLINE int64_t qni_gpu_emit_items(const qni_gpu_args *a) {
    return a->end_slot - a->first_slot;
}

QN_HD_INLINE void qni_gpu_emit(const qni_gpu_args *a, qni_gpu_emit_shared *s, int64_t item,
                               int phase, int thread) {
    const int64_t slot = a->first_slot + item;
    int32_t leaf[3];
    qni_gpu_leaf_at(&a->field, a->active_leaf[slot], leaf);
    if (phase == 0) {
        if (qni_gpu_is_sparse(&a->field))
            qni_gpu_find_tile_block(a, s, leaf, thread);
    } else if (phase == 1) {
        if (qni_gpu_is_sparse(&a->field))
            qni_gpu_load_sparse_tile(a, s, thread);
        else
            qni_gpu_load_tile(a, s, leaf, thread);
        qni_gpu_list_cells(a, s->cell, slot, thread, QNI_EMIT_THREADS);
        qni_gpu_load_signs(a, slot, leaf, s->signs, thread, QNI_EMIT_THREADS);
    } else if (phase == 2) {
        qni_gpu_make_masks((const uint16_t(*)[9])s->signs, &s->masks, thread, QNI_EMIT_THREADS);
        const int cells = qni_gpu_cell_count(a, slot);
        QN_ROLLED
        for (int n = thread; n < cells; n += QNI_EMIT_THREADS)
            qni_gpu_emit_cell(a, s, slot, leaf, n);
    } else if (phase == 3) {
        const qni_leaf_extent extent = qni_gpu_extent(&a->field, leaf);
        int before = 0;
        if (thread >= 24)
            return;
        for (int n = 0; n < thread; ++n)
            before += qni_count_bits(qni_quads_of_slice(&s->masks, &extent, n >> 3, n & 7));
        s->quads[thread >> 3][thread & 7] =
            qni_quads_of_slice(&s->masks, &extent, thread >> 3, thread & 7);
        s->quads_before[thread >> 3][thread & 7] = (uint16_t)before;
    } else if (a->quads) {
        qni_gpu_emit_quads(a, s, slot, leaf, thread);
    }
}

#endif
