// SPDX-License-Identifier: MIT
/* Pass 1 of DMC: which leaves and cells carry surface, how many vertices and quads each will give.
 * Only ambiguous cells look at sample values here; all else is bit work on the signs. */
#include "dmc/dmc.h"
#include "dmc/cell_hd.h"
#include "dmc/doubled_hd.h"
#include "dmc/extent.h"
#include "dmc/repair.h"
#include "dmc/rim.h"
#include "dmc/tunnel_hd.h"
#include "core/bits_hd.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>

/* One thread's room. Multiple cells of the row at hand are gathered here first. */
typedef struct worker {
    qni_scan scan;
    qni_multi_cell *multis;
    int64_t multi_count, multi_capacity;
    qni_doubled_face *doubled;
    int64_t doubled_count, doubled_capacity;
    qni_tunnel_cell *tunnels;
    int64_t tunnel_count, tunnel_capacity;
    qni_rim_vertex *rims;
    int64_t rim_count, rim_capacity;
    uint8_t *valences; /* of the row's vertices: how many edges their polygons have */
    int64_t valence_count, valence_capacity;
    qni_pool *kept, *kept_valences; /* what the rows have of it */
    qni_dmc_tally tally;
    uint8_t simple[256];  /* qni_case_is_simple(), looked up */
    uint8_t crossed[256]; /* edges of a case */
    bool with_tunnels, with_rims, with_valences, keep_doubled, failed;
} worker;

static bool reserve(qn_context *context, void **items, int64_t *capacity, int64_t wanted,
                    size_t size) {
    if (wanted <= *capacity)
        return true;
    void *grown = qni_realloc(context, *items, *capacity, 2 * wanted, size);
    if (!grown)
        return false;
    *items = grown;
    *capacity = 2 * wanted;
    return true;
}

/* Room for whatever one more leaf may hold. */
static bool reserve_leaf(qn_context *context, worker *w) {
    enum { CELLS = QNI_LEAF * QNI_LEAF * QNI_LEAF };
    void *multis = w->multis, *doubled = w->doubled, *tunnels = w->tunnels, *rims = w->rims;
    void *valences = w->valences;
    const bool good =
        reserve(context, &multis, &w->multi_capacity, w->multi_count + CELLS, sizeof *w->multis) &&
        reserve(context, &doubled, &w->doubled_capacity, w->doubled_count + 3 * CELLS,
                sizeof *w->doubled) &&
        reserve(context, &tunnels, &w->tunnel_capacity, w->tunnel_count + CELLS,
                sizeof *w->tunnels) &&
        (!w->with_rims ||
         reserve(context, &rims, &w->rim_capacity, w->rim_count + 4 * CELLS, sizeof *w->rims)) &&
        (!w->with_valences ||
         reserve(context, &valences, &w->valence_capacity, w->valence_count + 4 * CELLS, 1));
    w->multis = multis;
    w->doubled = doubled;
    w->tunnels = tunnels;
    w->rims = rims;
    w->valences = valences;
    return good;
}

static void find_doubled(const qni_field *field, const int64_t at[3], int ambiguous_faces,
                         int entry, worker *w) {
    for (int axis = 0; axis < 3; ++axis)
        if (ambiguous_faces >> (2 * axis) & 1)
            w->doubled_count +=
                qni_face_is_doubled(field, at, axis, entry, w->doubled + w->doubled_count);
}

/* Tunnels between polygons that have all their quads can be restored; an open surface's rim is left
 * as it is. */
static void note_tunnel(const qni_field *field, const double d[8], const int64_t at[3], int entry,
                        worker *w) {
    qni_tunnel tunnel = {{0}, 0, {0}};
    if (!qni_find_tunnel(d, entry, &tunnel))
        return;
    qni_tunnel_cell cell = {.entry = (uint16_t)entry};
    for (int n = 0; n < 2; ++n)
        cell.polygon[n] = (uint8_t)tunnel.polygon[n];
    for (int a = 0; a < 3; ++a) {
        cell.cell[a] = (int32_t)at[a];
        cell.middle[a] = tunnel.middle[a];
    }
    ++w->tally.tunnels;
    if (qni_tunnel_has_quads(field, &cell))
        w->tunnels[w->tunnel_count++] = cell;
}

/* A cell whose polygons are not known from its signs alone. */
static int resolve_cell(const qni_field *field, const int64_t at[3], int case_index, worker *w,
                        int *entry) {
    double d[8];
    qni_field_load_cell(field, at, d);
    if (qni_case_ambiguous_faces(case_index) == 0) {
        *entry = qni_case_offset(case_index);
    } else {
        qni_cell_choice choice = qni_cell_resolve(d, case_index);
        int own = 1 << 0 | 1 << 2 |
                  1 << 4; /* faces are counted by the cell above them, or by the last cell */
        for (int a = 0; a < 3; ++a)
            own |= (at[a] == field->cells[a] - 1) << (2 * a + 1);
        w->tally.ambiguous_faces += __builtin_popcount((unsigned)(choice.ambiguous_faces & own));
        w->tally.tied_faces += __builtin_popcount((unsigned)(choice.tied_faces & own));
        *entry = choice.entry;
        find_doubled(field, at, choice.ambiguous_faces, choice.entry, w);
    }
    if (w->with_tunnels && qni_entry_polygons(*entry) > 1)
        note_tunnel(field, d, at, *entry, w);
    return qni_entry_polygons(*entry);
}

/* Of a cell that is not simple; returns where the next ones go. */
static uint8_t *note_valences(const worker *w, int entry, int polygons, uint8_t *valence) {
    for (int n = 0; n < polygons; ++n)
        *valence++ = (uint8_t)qni_valence_of_polygon(qni_entry_edges(entry, n), w->keep_doubled);
    return valence;
}

/* The multiple cells of one slice; returns the vertices they add beyond one each. */
static int count_slice_extras(const qni_field *field, const uint16_t signs[9][9],
                              const int64_t leaf_at[3], int z, uint64_t active, int extra,
                              worker *w) {
    uint8_t unused, *valence = w->with_valences ? w->valences + w->valence_count : &unused;
    for (uint64_t rest = active; rest; rest &= rest - 1) {
        int bit = __builtin_ctzll(rest), x = bit & 7, y = bit >> 3, entry;
        int case_index = qni_case_of_cell(signs, x, y, z);
        *valence = w->crossed[case_index];
        valence += w->with_valences;
        if (w->simple[case_index])
            continue;
        int64_t at[3] = {leaf_at[0] + x, leaf_at[1] + y, leaf_at[2] + z};
        int polygons = resolve_cell(field, at, case_index, w, &entry);
        if (w->with_valences)
            valence = note_valences(w, entry, polygons, valence - 1);
        if (polygons < 2)
            continue;
        qni_multi_cell multi = {(uint16_t)(bit + 64 * z), (uint16_t)extra, (uint16_t)entry};
        w->multis[w->multi_count++] = multi;
        extra += polygons - 1;
    }
    if (w->with_valences)
        w->valence_count = valence - w->valences;
    return extra;
}

/* Quads are numbered by axis, then slice. `out` may be NULL when only their number is wanted. */
static int count_quads(const qni_leaf_masks *masks, const qni_leaf_extent *extent,
                       qni_leaf_quads *out) {
    int quads = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int z = 0; z < QNI_LEAF; ++z) {
            const uint64_t mask = qni_quads_of_slice(masks, extent, axis, z);
            if (out) {
                out->mask[axis][z] = mask;
                out->before[axis][z] = (uint16_t)quads;
            }
            quads += qni_count_bits(mask);
        }
    return quads;
}

static void count_leaf(const qni_field *field, const int32_t leaf[3], int32_t band_row, worker *w,
                       qni_dmc_row *row, qni_dmc_leaf *out) {
    uint16_t signs[QNI_LEAF_SAMPLES][QNI_LEAF_SAMPLES];
    qni_leaf_masks masks;
    const qni_leaf_extent extent = qni_leaf_extent_of(field, leaf);
    const int64_t at[3] = {(int64_t)leaf[0] * QNI_LEAF, (int64_t)leaf[1] * QNI_LEAF,
                           (int64_t)leaf[2] * QNI_LEAF};
    qni_scan_leaf(&w->scan, band_row, leaf[0], signs);
    qni_leaf_masks_init(signs, &masks);
    out->x = leaf[0];
    out->vertex_base = (uint32_t)row->vertex_count;
    out->quad_base = (uint32_t)row->quad_count;
    out->multi_base = (uint32_t)w->multi_count;
    int cells = 0, extra = 0;
    for (int z = 0; z < QNI_LEAF; ++z) {
        out->active[z] = qni_active_of_slice(&masks, &extent, z);
        out->before_slice[z] = (uint16_t)cells;
        cells += qni_count_bits(out->active[z]);
        extra = count_slice_extras(field, signs, at, z, out->active[z], extra, w);
    }
    out->multi_count = (uint16_t)(w->multi_count - out->multi_base);
    if (w->with_rims)
        w->rim_count += qni_rim_count_leaf(field, signs, leaf, row->vertex_count, out,
                                           w->multis + out->multi_base, w->rims + w->rim_count);
    row->vertex_count += cells + extra;
    row->quad_count +=
        count_quads(&masks, &extent, row->quads ? row->quads + (out - row->leaves) : NULL);
    w->tally.active_cells += cells;
    w->tally.multiple_cells += out->multi_count;
}

static int64_t count_mixed(const qni_field *field, const qni_scan *scan, int32_t band_row) {
    int64_t count = 0;
    for (int64_t x = 0; (x = qni_scan_next_mixed(field, scan, band_row, x)) < field->leaves[0]; ++x)
        ++count;
    return count;
}

/* A copy of what a worker gathered; NULL for nothing, and when there is no memory. */
static void *keep(qn_context *context, qni_pool *pool, const void *items, int64_t count,
                  size_t size) {
    void *copy = count ? qni_pool_take(context, pool, count, size) : NULL;
    if (copy)
        memcpy(copy, items, (size_t)count * size);
    return copy;
}

static bool count_row(qni_dmc *dmc, int64_t index, int32_t band_row, worker *w) {
    qni_dmc_row *row = dmc->rows + index;
    int32_t leaf[3];
    int64_t mixed = count_mixed(&dmc->field, &w->scan, band_row);
    w->multi_count = 0;
    w->doubled_count = 0;
    w->tunnel_count = 0;
    w->rim_count = 0;
    w->valence_count = 0;
    if (mixed == 0)
        return true;
    row->leaves = qni_pool_take(dmc->context, w->kept, mixed, sizeof *row->leaves);
    if (!row->leaves)
        return false;
    row->leaf_count = (int32_t)mixed;
    if ((dmc->with_halfedges || dmc->with_valences) &&
        !(row->quads = qni_pool_take(dmc->context, w->kept, mixed, sizeof *row->quads)))
        return false;
    qni_field_row_leaf(&dmc->field, index, leaf + 1);
    int64_t n = 0;
    for (int64_t x = 0; n < mixed; ++x) {
        x = qni_scan_next_mixed(&dmc->field, &w->scan, band_row, x);
        if (!reserve_leaf(dmc->context, w))
            return false;
        leaf[0] = (int32_t)x;
        count_leaf(&dmc->field, leaf, band_row, w, row, row->leaves + n++);
    }
    if (row->vertex_count > UINT32_MAX || row->quad_count > UINT32_MAX)
        return false;
    row->multi_count = (int32_t)w->multi_count;
    row->doubled_count = (int32_t)w->doubled_count;
    row->tunnel_count = (int32_t)w->tunnel_count;
    row->rim_count = (int32_t)w->rim_count;
    row->multis = keep(dmc->context, w->kept, w->multis, w->multi_count, sizeof *row->multis);
    row->doubled = keep(dmc->context, w->kept, w->doubled, w->doubled_count, sizeof *row->doubled);
    row->tunnels = keep(dmc->context, w->kept, w->tunnels, w->tunnel_count, sizeof *row->tunnels);
    row->rims = keep(dmc->context, w->kept, w->rims, w->rim_count, sizeof *row->rims);
    row->valences = keep(dmc->context, w->kept_valences, w->valences, w->valence_count, 1);
    if (!row->valences && w->valence_count)
        return false;
    return (row->multis || !w->multi_count) && (row->doubled || !w->doubled_count) &&
           (row->tunnels || !w->tunnel_count) && (row->rims || !w->rim_count);
}

static bool count_band(qni_dmc *dmc, int64_t band, worker *w) {
    const int64_t first = qni_field_band_row(&dmc->field, band);
    qni_field_scan_band(&dmc->field, band, &w->scan);
    if (w->scan.failed)
        return false;
    for (int32_t n = 0; n < w->scan.rows; ++n)
        if (!count_row(dmc, first + n, n, w))
            return false;
    return true;
}

void qni_dmc_free_rows(qni_dmc *dmc) {
    for (int32_t t = 0; dmc->pools && t < dmc->pool_count; ++t)
        qni_pool_free(dmc->context, dmc->pools + t);
    qni_free(dmc->context, dmc->pools, dmc->pool_count, sizeof *dmc->pools);
    qni_free(dmc->context, dmc->rows, dmc->row_count, sizeof *dmc->rows);
    dmc->pools = NULL;
    dmc->rows = NULL;
}

void qni_dmc_free_row_valences(qni_dmc *dmc) {
    for (int32_t t = 1; t < dmc->pool_count; t += 2)
        qni_pool_free(dmc->context, dmc->pools + t);
    for (int64_t r = 0; r < dmc->row_count; ++r)
        dmc->rows[r].valences = NULL;
}

static void add_tally(qni_dmc_tally *sum, const qni_dmc_tally *part) {
    sum->active_cells += part->active_cells;
    sum->ambiguous_faces += part->ambiguous_faces;
    sum->tied_faces += part->tied_faces;
    sum->multiple_cells += part->multiple_cells;
    sum->tunnels += part->tunnels;
}

static void destroy_workers(qni_dmc *dmc, worker *workers, int32_t threads) {
    for (int32_t t = 0; workers && t < threads; ++t) {
        qni_scan_destroy(dmc->context, &dmc->field, &workers[t].scan);
        qni_free(dmc->context, workers[t].multis, workers[t].multi_capacity,
                 sizeof *workers[t].multis);
        qni_free(dmc->context, workers[t].doubled, workers[t].doubled_capacity,
                 sizeof *workers[t].doubled);
        qni_free(dmc->context, workers[t].tunnels, workers[t].tunnel_capacity,
                 sizeof *workers[t].tunnels);
        qni_free(dmc->context, workers[t].rims, workers[t].rim_capacity, sizeof *workers[t].rims);
        qni_free(dmc->context, workers[t].valences, workers[t].valence_capacity, 1);
    }
    qni_free(dmc->context, workers, threads, sizeof *workers);
}

static worker *create_workers(qni_dmc *dmc, int32_t threads, qn_error *error) {
    worker *workers = qni_alloc_zero(dmc->context, threads, sizeof *workers);
    if (!workers) {
        qni_fail_memory(error, "the worker threads");
        return NULL;
    }
    for (int32_t t = 0; t < threads; ++t) {
        if (qni_scan_create(dmc->context, &dmc->field, &workers[t].scan, error) != QN_OK) {
            destroy_workers(dmc, workers, threads);
            return NULL;
        }
        workers[t].kept = dmc->pools + 2 * t;
        workers[t].kept_valences = dmc->pools + 2 * t + 1;
        workers[t].with_tunnels = dmc->with_tunnels;
        workers[t].with_rims = dmc->with_repair && dmc->field.border == 0;
        workers[t].with_valences = dmc->with_valences;
        workers[t].keep_doubled = !dmc->with_repair;
        for (int c = 0; c < 256; ++c) {
            workers[t].simple[c] = (uint8_t)qni_case_is_simple(c);
            for (int edge = 0; edge < QNI_EDGES; ++edge) {
                const int start = qni_edge_start_corner(edge),
                          end = start | 1 << qni_edge_axis(edge);
                workers[t].crossed[c] += (uint8_t)((c >> start ^ c >> end) & 1);
            }
        }
    }
    return workers;
}

/* Bands in slabs, so that progress is told and cancelling is heard on the calling thread. */
static qn_status count_bands(qni_dmc *dmc, worker *workers, int32_t threads, qn_error *error) {
    const int64_t slab = 64, bands = qni_field_band_count(&dmc->field);
    for (int64_t from = 0; from < bands; from += slab) {
        int64_t end = from + slab < bands ? from + slab : bands;
        if (qni_progress(dmc->context, "classify", (double)from / (double)bands))
            return qni_fail(error, QN_ERROR_CANCELLED, "cancelled");
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (int64_t b = from; b < end; ++b) {
            worker *w = workers + qni_thread_index();
            if (!w->failed && !count_band(dmc, b, w))
                w->failed = true;
        }
        for (int32_t t = 0; t < threads; ++t)
            if (workers[t].failed)
                return qni_fail_memory(error, "the leaves with surface");
    }
    return QN_OK;
}

static void assign_bases(qni_dmc *dmc) {
    dmc->vertex_count = dmc->quad_count = dmc->leaf_count = dmc->doubled_count = dmc->tunnel_count =
        dmc->rim_count = 0;
    for (int64_t r = 0; r < dmc->row_count; ++r) {
        qni_dmc_row *row = dmc->rows + r;
        row->vertex_base = dmc->vertex_count;
        row->quad_base = dmc->quad_count;
        dmc->vertex_count += row->vertex_count;
        dmc->quad_count += row->quad_count;
        dmc->leaf_count += row->leaf_count;
        dmc->doubled_count += row->doubled_count;
        dmc->tunnel_count += row->tunnel_count;
        for (int32_t n = 0; n < row->rim_count; ++n)
            dmc->rim_count += row->rims[n].fans - 1;
    }
}

qn_status qni_dmc_count(qni_dmc *dmc, qn_error *error) {
    const int32_t threads = qn_context_threads(dmc->context);
    dmc->row_count = qni_field_row_count(&dmc->field);
    dmc->rows = qni_alloc_zero(dmc->context, dmc->row_count, sizeof *dmc->rows);
    dmc->pool_count = 2 * threads;
    dmc->pools = qni_alloc_zero(dmc->context, dmc->pool_count, sizeof *dmc->pools);
    if (!dmc->rows || !dmc->pools)
        return qni_fail_memory(error, "the rows of leaves");
    worker *workers = create_workers(dmc, threads, error);
    if (!workers)
        return QN_ERROR_OUT_OF_MEMORY;
    qn_status status = count_bands(dmc, workers, threads, error);
    bool met_nonfinite = false;
    qni_dmc_note_memory(dmc, 0);
    memset(&dmc->tally, 0, sizeof dmc->tally);
    for (int32_t t = 0; t < threads; ++t) {
        add_tally(&dmc->tally, &workers[t].tally);
        met_nonfinite = met_nonfinite || workers[t].scan.met_nonfinite;
    }
    destroy_workers(dmc, workers, threads);
    if (status != QN_OK)
        return status;
    if (met_nonfinite) {
        /* Only now is it known that the rule for non-finite samples is needed: measure, and begin
         * again. */
        qni_dmc_free_rows(dmc);
        qni_field_measure_nonfinite(dmc->context, &dmc->field);
        return qni_dmc_count(dmc, error);
    }
    assign_bases(dmc);
    return QN_OK;
}
