// SPDX-License-Identifier: MIT
/* Pass 2 of DMC: every leaf writes its vertices and quads to the places that pass 1 counted out.
 * Order of vertices: leaf, cell, polygon; of quads: leaf, axis of the edge, cell. So no thread
 * waits for another, and all give the same. */
#include "dmc/dmc.h"
#include "dmc/cell_hd.h"
#include "dmc/extent.h"
#include "dmc/link.h"
#include "dmc/place_hd.h"
#include "dmc/repair.h"
#include "dmc/rim.h"
#include "dmc/vertex_hd.h"
#include "core/bits_hd.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum { IDS = QNI_LEAF + 1, NO_ENTRY = 0xffff };

/* Vertices of the cells of a leaf and of its lower neighbours: [z + 1][y + 1][x + 1]. */
typedef struct leaf_ids {
    uint32_t first[IDS][IDS][IDS]; /* the cell's first vertex */
    uint16_t entry[IDS][IDS]
                  [IDS]; /* table entry of multiple cells, else NO_ENTRY; valid if `any_multi` */
    bool any_multi;
} leaf_ids;

typedef struct worker {
    double tile[QNI_TILE][QNI_TILE][QNI_TILE];
    qni_point_batch batch;
    int64_t batch_vertex[QNI_LANES]; /* where in the mesh each lane goes */
    int32_t batch_count;
    uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES];
    qni_leaf_masks masks;
    leaf_ids ids;
    qni_quad_ids quad_ids;
    qni_dmc_tally tally;
} worker;

/* What all leaves share. */
typedef struct emission {
    const qni_dmc *dmc;
    qn_mesh *mesh;
    qni_frame frame;
    qni_point_kernel *kernel;
    qni_link_tables link_tables;
    bool reverse; /* wind quads the other way round */
} emission;

/* ---- vertices -------------------------------------------------------------------------------- */

bool qni_store_vertex(qn_mesh *mesh, int64_t vertex, const float position[3], float normal[3],
                      const double stencil[QNI_STENCIL], const double local[3],
                      const qni_frame *frame) {
    memcpy(mesh->positions + 3 * vertex, position, 3 * sizeof(float));
    if (!mesh->normals)
        return true;
    const bool good = qni_is_unit(normal);
    if (!good) {
        double d[8];
        for (int c = 0; c < 8; ++c)
            d[c] = stencil[qni_corner_of_stencil(c)];
        qni_mend_normal(d, local, frame, normal);
    }
    memcpy(mesh->normals + 3 * vertex, normal, 3 * sizeof(float));
    return good;
}

static void store_vertex(const emission *job, worker *w, int64_t vertex, const float position[3],
                         float normal[3], const double stencil[QNI_STENCIL],
                         const double local[3]) {
    w->tally.zero_gradients +=
        !qni_store_vertex(job->mesh, vertex, position, normal, stencil, local, &job->frame);
}

static void emit_polygon(const emission *job, worker *w, const double stencil[QNI_STENCIL],
                         const double cell[3], unsigned edges, uint64_t next_code, int64_t vertex) {
    double d[8];
    float position[3], normal[3];
    for (int c = 0; c < 8; ++c)
        d[c] = stencil[qni_corner_of_stencil(c)];
    qni_point point = qni_point_of_polygon(d, edges, next_code);
    w->tally.slice_points += point.kind == QNI_POINT_SLICE;
    w->tally.degenerate_points += point.kind == QNI_POINT_DEGENERATE;
    w->tally.fallback_points += point.kind == QNI_POINT_FALLBACK;
    qni_place_point(stencil, cell, point.p, &job->frame, position, normal);
    store_vertex(job, w, vertex, position, normal, stencil, point.p);
}

/* A single polygon that no axis line met. */
static void emit_lane_by_slices(const emission *job, worker *w, int lane,
                                const double stencil[QNI_STENCIL], const double cell[3]) {
    double d[8];
    int case_index = 0;
    for (int c = 0; c < 8; ++c) {
        d[c] = stencil[qni_corner_of_stencil(c)];
        case_index |= (d[c] >= 0) << c;
    }
    const int entry = qni_cell_resolve(d, case_index).entry;
    emit_polygon(job, w, stencil, cell, qni_entry_edges(entry, 0), qni_entry_next_code(entry),
                 w->batch_vertex[lane]);
}

static void store_lane_apart(const emission *job, worker *w, int l) {
    const qni_point_batch *batch = &w->batch;
    double stencil[QNI_STENCIL];
    for (int n = 0; n < QNI_STENCIL; ++n)
        stencil[n] = batch->stencil[n][l];
    const double cell[3] = {batch->cell[0][l], batch->cell[1][l], batch->cell[2][l]};
    if (batch->distance[l] >= 2) {
        emit_lane_by_slices(job, w, l, stencil, cell);
        return;
    }
    const double local[3] = {batch->local[0][l], batch->local[1][l], batch->local[2][l]};
    const float position[3] = {batch->position[0][l], batch->position[1][l], batch->position[2][l]};
    float normal[3] = {batch->normal[0][l], batch->normal[1][l], batch->normal[2][l]};
    store_vertex(job, w, w->batch_vertex[l], position, normal, stencil, local);
}

static void flush_batch(const emission *job, worker *w) {
    qni_point_batch *batch = &w->batch;
    if (w->batch_count == 0)
        return;
    for (int l = w->batch_count; l < QNI_LANES; ++l) {
        batch->corner[l] = batch->corner[0];
        for (int a = 0; a < 3; ++a)
            batch->cell[a][l] = batch->cell[a][0];
    }
    job->kernel(batch, &job->frame);
    for (int l = 0; l < w->batch_count; ++l) {
        if (batch->apart[l]) {
            store_lane_apart(job, w, l);
            continue;
        }
        float *p = job->mesh->positions + 3 * w->batch_vertex[l];
        p[0] = batch->position[0][l];
        p[1] = batch->position[1][l];
        p[2] = batch->position[2][l];
        if (job->mesh->normals) {
            float *n = job->mesh->normals + 3 * w->batch_vertex[l];
            n[0] = batch->normal[0][l];
            n[1] = batch->normal[1][l];
            n[2] = batch->normal[2][l];
        }
    }
    w->batch_count = 0;
}

static void queue_single(const emission *job, worker *w, const int64_t leaf_at[3], int x, int y,
                         int z, int64_t vertex) {
    qni_point_batch *batch = &w->batch;
    const int lane = w->batch_count++;
    batch->corner[lane] = &w->tile[z + 1][y + 1][x + 1];
    batch->cell[0][lane] = (double)(leaf_at[0] + x);
    batch->cell[1][lane] = (double)(leaf_at[1] + y);
    batch->cell[2][lane] = (double)(leaf_at[2] + z);
    w->batch_vertex[lane] = vertex;
    if (w->batch_count == QNI_LANES)
        flush_batch(job, w);
}

static int emit_multiple(const emission *job, worker *w, const int64_t leaf_at[3], int x, int y,
                         int z, int entry, int64_t vertex) {
    double stencil[QNI_STENCIL];
    const double cell[3] = {(double)(leaf_at[0] + x), (double)(leaf_at[1] + y),
                            (double)(leaf_at[2] + z)};
    const int polygons = qni_entry_polygons(entry);
    qni_gather_stencil(&w->tile[z + 1][y + 1][x + 1], stencil);
    for (int n = 0; n < polygons; ++n)
        emit_polygon(job, w, stencil, cell, qni_entry_edges(entry, n), qni_entry_next_code(entry),
                     vertex + n);
    return polygons;
}

/* Writes the leaf's vertices and notes each cell's first one. */
static void emit_vertices(const emission *job, worker *w, const qni_dmc_row *row,
                          const qni_dmc_leaf *leaf, const int64_t leaf_at[3]) {
    const qni_multi_cell *multi = row->multis + leaf->multi_base,
                         *multi_end = multi + leaf->multi_count;
    int64_t vertex = row->vertex_base + leaf->vertex_base;
    for (int z = 0; z < QNI_LEAF; ++z)
        for (uint64_t rest = leaf->active[z]; rest; rest &= rest - 1) {
            const int bit = __builtin_ctzll(rest), x = bit & 7, y = bit >> 3;
            w->ids.first[z + 1][y + 1][x + 1] = (uint32_t)vertex;
            if (multi < multi_end && multi->cell == bit + 64 * z) {
                w->ids.entry[z + 1][y + 1][x + 1] = multi->entry;
                vertex += emit_multiple(job, w, leaf_at, x, y, z, multi->entry, vertex);
                ++multi;
            } else {
                queue_single(job, w, leaf_at, x, y, z, vertex++);
            }
        }
    flush_batch(job, w);
}

/* ---- neighbours ------------------------------------------------------------------------------ */

/* The cells of a lower neighbour that touch the leaf, into their places; `shift` is 1 along the
 * axes where it is lower. */
static void note_neighbour(leaf_ids *ids, const qni_dmc_row *row, const qni_dmc_leaf *leaf,
                           const int shift[3]) {
    const uint64_t touching =
        (shift[0] ? qni_columns(7, 8) : ~UINT64_C(0)) & (shift[1] ? qni_rows(7, 8) : ~UINT64_C(0));
    const qni_multi_cell *multis = row->multis + leaf->multi_base;
    const uint32_t base = (uint32_t)(row->vertex_base + leaf->vertex_base);
    int next_multi = 0, extra = 0;
    for (int z = shift[2] ? 7 : 0; z < QNI_LEAF; ++z)
        for (uint64_t rest = leaf->active[z] & touching; rest; rest &= rest - 1) {
            const int bit = __builtin_ctzll(rest), cell = bit + 64 * z;
            const int to_x = shift[0] ? 0 : (bit & 7) + 1, to_y = shift[1] ? 0 : (bit >> 3) + 1;
            const int to_z = shift[2] ? 0 : z + 1;
            const int before = leaf->before_slice[z] + qni_bits_below(leaf->active[z], bit);
            for (; next_multi < leaf->multi_count && multis[next_multi].cell < cell; ++next_multi)
                extra = multis[next_multi].extra_before +
                        qni_entry_polygons(multis[next_multi].entry) - 1;
            ids->first[to_z][to_y][to_x] = base + (uint32_t)(before + extra);
            if (next_multi < leaf->multi_count && multis[next_multi].cell == cell)
                ids->entry[to_z][to_y][to_x] = multis[next_multi].entry;
        }
}

/* The leaves at x and x - 1 of the row at hand and of its three lower neighbours, walked in step.
 */
typedef struct neighbour_rows {
    const qni_dmc_row
        *row[4]; /* bit 0: one lower in y, bit 1: one lower in z; NULL beyond the lattice */
    int32_t at[4];
} neighbour_rows;

static void find_neighbour_rows(const qni_dmc *dmc, int64_t index, neighbour_rows *rows) {
    int32_t leaf[2];
    qni_field_row_leaf(&dmc->field, index, leaf);
    for (int n = 0; n < 4; ++n) {
        const int64_t row = qni_field_find_row(&dmc->field, leaf[0] - (n & 1), leaf[1] - (n >> 1));
        rows->row[n] = row < 0 ? NULL : dmc->rows + row;
        rows->at[n] = 0;
    }
}

static void note_neighbours(worker *w, neighbour_rows *rows, int32_t x, const qni_dmc_leaf *own) {
    const qni_dmc_leaf *found[8];
    w->ids.any_multi = own->multi_count > 0;
    for (int n = 0; n < 4; ++n) {
        found[2 * n] = found[2 * n + 1] = NULL;
        const qni_dmc_row *row = rows->row[n];
        if (!row)
            continue;
        while (rows->at[n] < row->leaf_count && row->leaves[rows->at[n]].x < x)
            ++rows->at[n];
        const int32_t at = rows->at[n];
        if (at < row->leaf_count && row->leaves[at].x == x)
            found[2 * n] = row->leaves + at;
        if (at > 0 && row->leaves[at - 1].x == x - 1)
            found[2 * n + 1] = row->leaves + at - 1;
    }
    for (int n = 1; n < 8; ++n)
        w->ids.any_multi = w->ids.any_multi || (found[n] && found[n]->multi_count > 0);
    if (w->ids.any_multi)
        memset(w->ids.entry, 0xff, sizeof w->ids.entry);
    for (int n = 1; n < 8; ++n) {
        const int shift[3] = {n & 1, n >> 1 & 1, n >> 2};
        if (found[n])
            note_neighbour(&w->ids, rows->row[n >> 1], found[n], shift);
    }
}

/* ---- quads ----------------------------------------------------------------------------------- */

/* The four cells round an edge along each axis, counter-clockwise seen from the edge's end, as
 * places in leaf_ids before the edge's own cell, and the edge's number in each. */
enum { IDS_Y = IDS, IDS_Z = IDS * IDS };
static const uint8_t ring_back[3][4] = {
    {IDS_Y + IDS_Z, IDS_Z, 0, IDS_Y}, {1 + IDS_Z, 1, 0, IDS_Z}, {1 + IDS_Y, IDS_Y, 0, 1}};
static const uint8_t ring_edge[3][4] = {{3, 2, 0, 1}, {7, 5, 4, 6}, {11, 10, 8, 9}};

/* The polygons that the edge crosses in multiple cells are not their first ones. */
static void pick_polygons(const leaf_ids *ids, int place, int axis, uint32_t corner[4]) {
    const uint16_t *entries = &ids->entry[0][0][0];
    for (int n = 0; n < 4; ++n) {
        const uint16_t entry = entries[place - ring_back[axis][n]];
        if (entry != NO_ENTRY)
            corner[n] += (uint32_t)qni_entry_polygon_of_edge(entry, ring_edge[axis][n]);
    }
}

static void emit_quads(const emission *job, worker *w, const qni_leaf_extent *extent,
                       int64_t first_quad) {
    uint32_t *quad = job->mesh->quads + 4 * first_quad;
    uint8_t *colours = job->dmc->colours ? job->dmc->colours + first_quad : NULL;
    const uint32_t *first = &w->ids.first[0][0][0];
    const bool any_multi = w->ids.any_multi;
    for (int axis = 0; axis < 3; ++axis) {
        const int back[4] = {ring_back[axis][0], ring_back[axis][1], ring_back[axis][2],
                             ring_back[axis][3]};
        const uint32_t *first_of_axis = quad;
        for (int z = 0; z < QNI_LEAF; ++z) {
            /* Values fall along the axis where the edge starts above: then the outside of an inside
             * above lies ahead. */
            const uint64_t forward = job->reverse ? ~w->masks.corner[0][z] : w->masks.corner[0][z];
            for (uint64_t rest = qni_quads_of_slice(&w->masks, extent, axis, z); rest;
                 rest &= rest - 1) {
                const int bit = __builtin_ctzll(rest);
                const int place = (z + 1) * IDS_Z + ((bit >> 3) + 1) * IDS_Y + (bit & 7) + 1;
                uint32_t corner[4] = {first[place - back[0]], first[place - back[1]],
                                      first[place - back[2]], first[place - back[3]]};
                if (any_multi)
                    pick_polygons(&w->ids, place, axis, corner);
                const int turn = (int)(forward >> bit & 1);
                quad[0] = corner[0];
                quad[1] = corner[turn ? 1 : 3];
                quad[2] = corner[2];
                quad[3] = corner[turn ? 3 : 1];
                quad += 4;
            }
        }
        const size_t of_axis = (size_t)(quad - first_of_axis) / 4;
        if (colours) {
            memset(colours, axis, of_axis);
            colours += of_axis;
        }
    }
}

/* ---- leaves, rows ---------------------------------------------------------------------------- */

static void signs_of_tile(worker *w) {
    for (int z = 0; z < QNI_LEAF_SAMPLES; ++z)
        for (int y = 0; y < QNI_LEAF_SAMPLES; ++y) {
            const double *row = &w->tile[z + 1][y + 1][1];
            unsigned bits = 0;
#ifdef __SSE2__
            const __m128d zero = _mm_setzero_pd();
            for (int n = 0; n < 4; ++n)
                bits |= (unsigned)_mm_movemask_pd(_mm_cmpge_pd(_mm_loadu_pd(row + 2 * n), zero))
                        << (2 * n);
            bits |= (unsigned)(row[8] >= 0) << 8;
#else
            for (int n = 0; n < QNI_LEAF_SAMPLES; ++n)
                bits |= (unsigned)(row[n] >= 0) << n;
#endif
            w->signs[z][y] = (uint16_t)bits;
        }
}

static bool is_at_border(const emission *job, const qni_leaf_extent *extent, const int64_t at[3]) {
    bool at_border = false;
    for (int a = 0; a < 3; ++a)
        at_border = at_border || extent->at_low[a] || at[a] + QNI_LEAF >= job->dmc->field.cells[a];
    return at_border;
}

/* Valences are edges of polygons, as pass 1 found them; but 0 where some of those are on the border
 * of an open lattice and have no quads. */
static void mend_valences(const emission *job, worker *w, const qni_dmc_row *row,
                          const qni_dmc_leaf *own, const qni_leaf_extent *extent,
                          const int64_t at[3]) {
    if (job->dmc->field.border != 0 || !is_at_border(job, extent, at))
        return;
    const qni_link_leaf link = {
        .tile = (const double(*)[QNI_TILE][QNI_TILE])w->tile,
        .signs = (const uint16_t(*)[QNI_LEAF_SAMPLES])w->signs,
        .leaf = own,
        .multis = row->multis + own->multi_base,
        .at_border = true,
    };
    qni_note_valences(&link, job->dmc->field.cells, at, !job->dmc->with_repair,
                      job->dmc->valences + row->vertex_base + own->vertex_base);
}

static void link_leaf(const emission *job, worker *w, const qni_dmc_row *row,
                      const qni_dmc_leaf *own, const qni_leaf_extent *extent, const int64_t at[3],
                      qni_upper_rows *upper) {
    const bool at_border = is_at_border(job, extent, at);
    const qni_link_leaf link = {
        .tile = (const double(*)[QNI_TILE][QNI_TILE])w->tile,
        .signs = (const uint16_t(*)[QNI_LEAF_SAMPLES])w->signs,
        .masks = &w->masks,
        .tables = &job->link_tables,
        .extent = extent,
        .leaf = own,
        .multis = row->multis + own->multi_base,
        .first_vertex = (uint32_t)(row->vertex_base + own->vertex_base),
        .at_border = at_border,
    };
    qni_quad_ids_note(upper, own->x, at_border, &w->quad_ids);
    qni_link(&link, &w->quad_ids, job->mesh->twins, job->mesh->vertex_halfedges);
}

/* Tell the repair where the quads are that it will split: those of the leaf at x, from split `from`
 * on. */
static int64_t note_splits(const qni_dmc *dmc, const worker *w, const qni_leaf_extent *extent,
                           int64_t row, int32_t x, uint32_t first_quad, int64_t from) {
    const qni_repair *repair = dmc->repair;
    for (; from < repair->split_count; ++from) {
        qni_quad_split *split = repair->splits + from;
        if (split->row != row || split->point[0] / QNI_LEAF != x)
            break;
        const int z = split->point[2] % QNI_LEAF,
                  bit = split->point[0] % QNI_LEAF + 8 * (split->point[1] % QNI_LEAF);
        split->quad = first_quad;
        for (int axis = 0; axis <= split->axis; ++axis)
            for (int s = 0; s < (axis < split->axis ? QNI_LEAF : z); ++s)
                split->quad +=
                    (uint32_t)qni_count_bits(qni_quads_of_slice(&w->masks, extent, axis, s));
        const uint64_t slice = qni_quads_of_slice(&w->masks, extent, split->axis, z);
        split->quad += (uint32_t)qni_bits_below(slice, bit);
    }
    return from;
}

static void emit_row(const emission *job, int64_t index, worker *w) {
    const qni_dmc *dmc = job->dmc;
    const qni_dmc_row *row = dmc->rows + index;
    neighbour_rows rows;
    qni_upper_rows upper;
    int32_t leaf[3];
    qni_field_row_leaf(&dmc->field, index, leaf + 1);
    find_neighbour_rows(dmc, index, &rows);
    qni_upper_rows_init(dmc, index, &upper);
    int64_t next_split = dmc->repair ? qni_repair_row_split(dmc->repair, index) : 0;
    if (dmc->valences && row->valences)
        memcpy(dmc->valences + row->vertex_base, row->valences, (size_t)row->vertex_count);
    for (int32_t n = 0; n < row->leaf_count; ++n) {
        const qni_dmc_leaf *own = row->leaves + n;
        leaf[0] = own->x;
        const qni_leaf_extent extent = qni_leaf_extent_of(&dmc->field, leaf);
        const int64_t at[3] = {(int64_t)leaf[0] * QNI_LEAF, (int64_t)leaf[1] * QNI_LEAF,
                               (int64_t)leaf[2] * QNI_LEAF};
        qni_field_load_tile(&dmc->field, leaf, w->tile);
        if (n + 1 < row->leaf_count) {
            const int32_t next[3] = {own[1].x, leaf[1], leaf[2]};
            qni_field_prefetch_tile(&dmc->field, next);
        }
        signs_of_tile(w);
        qni_leaf_masks_init((const uint16_t(*)[9])w->signs, &w->masks);
        note_neighbours(w, &rows, own->x, own);
        emit_vertices(job, w, row, own, at);
        if (job->mesh->quads)
            emit_quads(job, w, &extent, row->quad_base + own->quad_base);
        if (dmc->repair)
            next_split = note_splits(dmc, w, &extent, index, own->x,
                                     (uint32_t)(row->quad_base + own->quad_base), next_split);
        if (job->mesh->twins)
            link_leaf(job, w, row, own, &extent, at, &upper);
        if (dmc->valences)
            mend_valences(job, w, row, own, &extent, at);
    }
}

/* Gradients go to the world by the inverse transpose, with the sign that points out of the solid.
 */
void qni_frame_of_field(const qni_field *field, qni_frame *frame, double *determinant) {
    const double(*m)[4] = (const double(*)[4])field->world;
    memcpy(frame->world, field->world, sizeof frame->world);
    double cofactor[3][3];
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            cofactor[r][c] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        }
    *determinant = m[0][0] * cofactor[0][0] + m[0][1] * cofactor[0][1] + m[0][2] * cofactor[0][2];
    const double sign = (*determinant > 0) == field->inside_below ? 1 : -1;
    double largest = 0;
    for (int n = 0; n < 9; ++n)
        largest = fmax(largest, fabs(cofactor[n / 3][n % 3]));
    for (int n = 0; n < 9; ++n)
        frame->normal[n / 3][n % 3] = sign * cofactor[n / 3][n % 3] / largest;
}

static qn_status emit_rows(const emission *job, worker *workers, int32_t threads, qn_error *error) {
    const int64_t slab = 256, row_count = job->dmc->row_count;
    for (int64_t from = 0; from < row_count; from += slab) {
        int64_t end = from + slab < row_count ? from + slab : row_count;
        if (qni_progress(job->dmc->context, "emit", (double)from / (double)row_count))
            return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
        for (int64_t r = from; r < end; ++r)
            emit_row(job, r, workers + qni_thread_index());
    }
    return QN_OK;
}

qn_status qni_dmc_emit(qni_dmc *dmc, qn_mesh *mesh, qn_error *error) {
    const int32_t threads = qn_context_threads(dmc->context);
    double determinant;
    emission job = {.dmc = dmc, .mesh = mesh, .kernel = qni_choose_kernels()->point};
    qni_frame_of_field(&dmc->field, &job.frame, &determinant);
    job.reverse = dmc->field.inside_below != (determinant < 0);
    if (mesh->vertex_count == 0)
        return QN_OK;
    if (mesh->twins)
        qni_link_prepare(job.reverse, &job.link_tables);
    worker *workers = qni_alloc_zero(dmc->context, threads, sizeof *workers);
    if (!workers)
        return qni_fail_memory(error, "the worker threads");
    qn_status status = emit_rows(&job, workers, threads, error);
    qni_dmc_note_memory(dmc, qni_dmc_mesh_bytes(dmc, mesh->normals != NULL));
    for (int32_t t = 0; t < threads; ++t) {
        dmc->tally.slice_points += workers[t].tally.slice_points;
        dmc->tally.degenerate_points += workers[t].tally.degenerate_points;
        dmc->tally.fallback_points += workers[t].tally.fallback_points;
        dmc->tally.zero_gradients += workers[t].tally.zero_gradients;
    }
    qni_free(dmc->context, workers, threads, sizeof *workers);
    qni_dmc_free_row_valences(dmc); /* they are in the mesh's order now */
    if (status == QN_OK && dmc->rim_count > 0)
        dmc->rim_points_left = qni_rim_apply(dmc, &job.frame, job.reverse, mesh);
    if (status == QN_OK && dmc->repair)
        qni_repair_apply(dmc, &job.frame, job.reverse, mesh);
    if (status == QN_OK && dmc->repair && mesh->twins)
        qni_repair_link(dmc, mesh);
    if (status == QN_OK && dmc->valences)
        qni_repair_count_valences(dmc, mesh);
    return status;
}
