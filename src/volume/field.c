// SPDX-License-Identifier: MIT
/* Fields over dense volumes: the rule for borders and non-finite samples, values one by one, in
 * rows and in tiles. */
#include "volume/field.h"
#include "volume/field_rows.h"
#include "volume/field_sparse.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

/* A closed border must lie outside even where its sample equals the iso-value. */
static const double least_outside = 1e-30;
/* Keeps products of two values finite; no data of use comes near it. */
static const double largest_distance = 1e140;

static void set_world(qni_field *field) {
    for (int r = 0; r < 3; ++r) {
        const double *m = field->grid->index_to_world[r];
        double border = field->border;
        field->world[r][0] = m[0];
        field->world[r][1] = m[1];
        field->world[r][2] = m[2];
        field->world[r][3] = m[3] - border * m[0] - border * m[1] - border * m[2];
    }
}

qn_status qni_field_init(const qn_volume *volume, double isovalue, bool inside_below, bool open,
                         qni_field *field, qn_error *error) {
    if (!isfinite(isovalue))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "the iso-value must be a finite number");
    memset(field, 0, sizeof *field);
    field->grid = &volume->grid;
    field->isovalue = isovalue;
    field->inside_below = inside_below;
    if (volume->sparse) {
        qni_sparse_field_init(volume->sparse, field);
        return QN_OK;
    }
    field->border = open ? 0 : 1;
    for (int a = 0; a < 3; ++a) {
        field->samples[a] = volume->grid.size[a] + 2 * field->border;
        field->cells[a] = field->samples[a] - 1;
        field->leaves[a] = (field->cells[a] + QNI_LEAF - 1) / QNI_LEAF;
    }
    set_world(field);
    qni_field_set_threshold(field);
    return QN_OK;
}

double qni_field_settle(const qni_field *field, double value) {
    double d = value - field->isovalue;
    if (!(fabs(d) <= largest_distance)) {
        if (isfinite(value))
            return d > 0 ? largest_distance : -largest_distance;
        bool above = isnan(value) ? field->inside_below : value > 0;
        return above ? field->nonfinite_distance : -field->nonfinite_distance;
    }
    return d;
}

/* The virtual layer mirrors the border's values at the iso-value to the outside. */
static double outside_of(const qni_field *field, double d) {
    double distance = fabs(d) > least_outside ? fabs(d) : least_outside;
    return field->inside_below ? distance : -distance;
}

static int64_t clamp_index(int64_t i, int64_t size) {
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

double qni_field_value(const qni_field *field, int64_t x, int64_t y, int64_t z) {
    if (field->sparse)
        return qni_sparse_field_value(field, x, y, z);
    const int64_t *size = field->grid->size;
    int64_t i = x - field->border, j = y - field->border, k = z - field->border;
    int64_t ci = clamp_index(i, size[0]), cj = clamp_index(j, size[1]),
            ck = clamp_index(k, size[2]);
    double d = qni_field_settle(field, qni_grid_value(field->grid, ci, cj, ck));
    return i == ci && j == cj && k == ck ? d : outside_of(field, d);
}

double qni_field_extended_value(const qni_field *field, const int64_t point[3]) {
    int64_t end[3], before_end[3];
    bool beyond = false;
    for (int a = 0; a < 3; ++a) {
        end[a] = clamp_index(point[a], field->samples[a]);
        before_end[a] = clamp_index(2 * end[a] - point[a], field->samples[a]);
        beyond = beyond || end[a] != point[a];
    }
    const double d = qni_field_value(field, end[0], end[1], end[2]);
    return beyond ? 2 * d - qni_field_value(field, before_end[0], before_end[1], before_end[2]) : d;
}

/* Sample values to distances from the iso-value. */
static inline void settle_values(const qni_field *field, int64_t count, double *out) {
    const qn_grid *grid = field->grid;
    bool may_be_huge = grid->scalar == QN_F64 || grid->slope != 1 || grid->intercept != 0;
    if (field->nonfinite_distance > 0 || may_be_huge) {
        for (int64_t n = 0; n < count; ++n)
            out[n] = qni_field_settle(field, out[n]);
    } else {
        for (int64_t n = 0; n < count; ++n)
            out[n] = out[n] - field->isovalue;
    }
}

/* `count` lattice points from (x, y, z) along x; all must be true samples of the grid. */
static void load_row(const qni_field *field, int64_t x, int64_t y, int64_t z, int64_t count,
                     double *out) {
    qni_grid_load_row(field->grid, x - field->border, y - field->border, z - field->border, count,
                      out);
    settle_values(field, count, out);
}

bool qni_field_load_run(const qni_field *field, const int64_t point[3], int64_t count,
                        double *out) {
    if (field->sparse)
        return false;
    for (int a = 0; a < 3; ++a)
        if (point[a] < field->border ||
            point[a] + (a == 0 ? count : 1) > field->samples[a] - field->border)
            return false;
    load_row(field, point[0], point[1], point[2], count, out);
    return true;
}

bool qni_field_load_runs(const qni_field *field, const int64_t cell[3], int low, int high,
                         const qni_run *runs, int count, double *out) {
    int64_t at[3];
    if (field->sparse)
        return false;
    for (int a = 0; a < 3; ++a) {
        at[a] = cell[a] - field->border;
        if (at[a] + low < 0 || at[a] + high >= field->grid->size[a])
            return false;
    }
    const int values = qni_grid_load_plain_runs(field->grid, at, runs, count, out);
    settle_values(field, values, out);
    return values > 0;
}

/* A row of lattice points of any place in the lattice, virtual layer included. */
void qni_field_load_lattice_row(const qni_field *field, int64_t y, int64_t z, double *out) {
    const qn_grid *grid = field->grid;
    int64_t j = y - field->border, k = z - field->border;
    int64_t cj = clamp_index(j, grid->size[1]), ck = clamp_index(k, grid->size[2]);
    load_row(field, field->border, cj + field->border, ck + field->border, grid->size[0],
             out + field->border);
    if (j != cj || k != ck)
        for (int64_t n = 0; n < grid->size[0]; ++n)
            out[field->border + n] = outside_of(field, out[field->border + n]);
    if (field->border) {
        out[0] = outside_of(field, out[1]);
        out[field->samples[0] - 1] = outside_of(field, out[field->samples[0] - 2]);
    }
}

/* Lattice points [from, end) of lattice row (y, z), all inside the lattice, into out[0 ..]. */
static void load_lattice_part(const qni_field *field, int64_t from, int64_t end, int64_t y,
                              int64_t z, double *out) {
    const int64_t *size = field->grid->size;
    int64_t border = field->border;
    int64_t cy = clamp_index(y - border, size[1]) + border,
            cz = clamp_index(z - border, size[2]) + border;
    int64_t first = clamp_index(from - border, size[0]) + border;
    int64_t last = clamp_index(end - 1 - border, size[0]) + border;
    load_row(field, first, cy, cz, last - first + 1, out + (first - from));
    if (cy != y || cz != z)
        for (int64_t x = first; x <= last; ++x)
            out[x - from] = outside_of(field, out[x - from]);
    if (from < first)
        out[0] = outside_of(field, out[first - from]);
    if (last < end - 1)
        out[end - 1 - from] = outside_of(field, out[last - from]);
}

/* A cell of samples only. */
static bool load_plain_cell(const qni_field *field, const int64_t cell[3], double corner[8]) {
    int64_t at[3];
    for (int a = 0; a < 3; ++a) {
        at[a] = cell[a] - field->border;
        if (at[a] < 0 || at[a] + 1 >= field->grid->size[a])
            return false;
    }
    if (!qni_grid_load_plain_cell(field->grid, at, corner))
        return false;
    settle_values(field, 8, corner);
    return true;
}

void qni_field_load_cell(const qni_field *field, const int64_t cell[3], double corner[8]) {
    if (field->sparse) {
        qni_sparse_field_load_cell(field, cell, corner);
        return;
    }
    if (load_plain_cell(field, cell, corner))
        return;
    for (int n = 0; n < 4; ++n) {
        const int64_t y = cell[1] + (n & 1), z = cell[2] + (n >> 1);
        const int64_t first[3] = {cell[0], y, z};
        if (qni_field_load_run(field, first, 2, corner + 2 * n))
            continue;
        corner[2 * n] = qni_field_value(field, cell[0], y, z);
        corner[2 * n + 1] = qni_field_value(field, cell[0] + 1, y, z);
    }
}

/* Cells that have more than samples are left for one by one; the first cell stands for them. */
void qni_field_expect_cells(const qni_field *field, int count, qni_cells *cells) {
    const qn_grid *grid = field->grid;
    cells->others = field->sparse ? count : 0;
    for (int n = 0; n < count && !field->sparse; ++n) {
        bool inside = true;
        int64_t offset = 0;
        for (int a = 0; a < 3; ++a) {
            const int64_t at = cells->cell[a][n] - field->border;
            inside = inside && at >= 0 && at + 1 < grid->size[a];
            offset += at * grid->stride[a];
        }
        const char *from = (const char *)grid->samples + (inside ? offset : 0);
        for (int r = 0; r < 4; ++r)
            __builtin_prefetch(from + (r & 1) * grid->stride[1] + (r >> 1) * grid->stride[2]);
        cells->from[n] = from;
        cells->other[n] = !inside;
        cells->others += !inside;
    }
}

void qni_field_load_cells(const qni_field *field, int count, const qni_cells *cells,
                          double corner[8][QNI_CELLS_TOGETHER]) {
    bool all = true;
    if (cells->others < count && qni_grid_load_plain_cells(field->grid, cells->from, count, corner))
        for (int c = 0; c < 8; ++c)
            settle_values(field, count, corner[c]);
    else
        all = false;
    for (int n = 0; n < count && (cells->others > 0 || !all); ++n) {
        double own[8];
        if (all && !cells->other[n])
            continue;
        const int64_t at[3] = {cells->cell[0][n], cells->cell[1][n], cells->cell[2][n]};
        qni_field_load_cell(field, at, own);
        for (int c = 0; c < 8; ++c)
            corner[c][n] = own[c];
    }
}

/* Not in parts: gcc takes a static function that only prefetches for one without effect. */
void qni_field_prefetch_rows(const qni_field *field, const int64_t cell[3], int low, int high) {
    const qn_grid *grid = field->grid;
    int64_t at[3];
    if (field->sparse)
        return;
    for (int a = 0; a < 3; ++a) {
        at[a] = cell[a] - field->border;
        if (at[a] + low < 0 || at[a] + high >= grid->size[a])
            return;
    }
    const char *first = (const char *)grid->samples + at[0] * grid->stride[0] +
                        at[1] * grid->stride[1] + at[2] * grid->stride[2];
    for (int z = low; z <= high; ++z)
        for (int y = low; y <= high; ++y)
            __builtin_prefetch(first + y * grid->stride[1] + z * grid->stride[2]);
}

/* What a tile has of the lattice along one axis: positions [begin, end) of its 11. */
typedef struct tile_span {
    int begin, end;
} tile_span;

static tile_span span_of(const qni_field *field, int axis, int64_t from) {
    int64_t begin = from < 0 ? -from : 0;
    int64_t end = field->samples[axis] - from;
    tile_span span = {(int)begin, (int)(end > QNI_TILE ? QNI_TILE : end)};
    return span;
}

/* Continue a line of the tile linearly beyond the lattice, one point on each side, and repeat after
 * that. */
static void extrapolate(double *line, int stride, tile_span span) {
    double *first = line + span.begin * stride, *last = line + (span.end - 1) * stride;
    int several = span.end - span.begin > 1;
    if (span.begin > 0)
        *(first - stride) = several ? 2 * *first - first[stride] : *first;
    for (int n = span.end; n < QNI_TILE; ++n)
        line[n * stride] = several ? 2 * *last - *(last - stride) : *last;
}

static void load_tile_at_end(const qni_field *field, const int64_t from[3],
                             double tile[QNI_TILE][QNI_TILE][QNI_TILE]) {
    tile_span x = span_of(field, 0, from[0]), y = span_of(field, 1, from[1]),
              z = span_of(field, 2, from[2]);
    for (int n = z.begin; n < z.end; ++n) {
        for (int m = y.begin; m < y.end; ++m) {
            load_lattice_part(field, from[0] + x.begin, from[0] + x.end, from[1] + m, from[2] + n,
                              tile[n][m] + x.begin);
            extrapolate(tile[n][m], 1, x);
        }
        for (int m = 0; m < QNI_TILE; ++m)
            extrapolate(&tile[n][0][m], QNI_TILE, y);
    }
    for (int m = 0; m < QNI_TILE * QNI_TILE; ++m)
        extrapolate(&tile[0][m / QNI_TILE][m % QNI_TILE], QNI_TILE * QNI_TILE, z);
}

void qni_field_load_tile(const qni_field *field, const int32_t leaf[3],
                         double tile[QNI_TILE][QNI_TILE][QNI_TILE]) {
    if (field->sparse) {
        qni_sparse_field_load_tile(field, leaf, tile);
        return;
    }
    int64_t from[3], sample[3];
    bool inner = true;
    for (int a = 0; a < 3; ++a) {
        from[a] = (int64_t)leaf[a] * QNI_LEAF - 1;
        sample[a] = from[a] - field->border;
        inner = inner && sample[a] >= 0 && sample[a] + QNI_TILE <= field->grid->size[a];
    }
    if (!inner) {
        load_tile_at_end(field, from, tile);
        return;
    }
    if (qni_grid_load_plain_tile(field, sample, tile))
        return;
    for (int z = 0; z < QNI_TILE; ++z)
        for (int y = 0; y < QNI_TILE; ++y)
            load_row(field, from[0], from[1] + y, from[2] + z, QNI_TILE, tile[z][y]);
}

void qni_field_prefetch_tile(const qni_field *field, const int32_t leaf[3]) {
    const qn_grid *grid = field->grid;
    int64_t from[3];
    if (field->sparse)
        return;
    for (int a = 0; a < 3; ++a) {
        from[a] = (int64_t)leaf[a] * QNI_LEAF - 1 - field->border;
        if (from[a] < 0 || from[a] + QNI_TILE > grid->size[a])
            return;
    }
    /* Rows advance by one leaf along x: the end of each is what the cache does not hold yet. */
    const char *end = (const char *)grid->samples + (from[0] + QNI_TILE - 1) * grid->stride[0] +
                      from[1] * grid->stride[1] + from[2] * grid->stride[2];
    for (int z = 0; z < QNI_TILE; ++z)
        for (int y = 0; y < QNI_TILE; ++y)
            __builtin_prefetch(end + z * grid->stride[2] + y * grid->stride[1]);
}

static qni_nonfinite_count count_slice(const qni_field *field, int64_t k) {
    qni_nonfinite_count count = {0, 0, 0};
    if (field->sparse)
        return qni_sparse_field_count_part(field, k);
    const qn_grid *grid = field->grid;
    for (int64_t j = 0; j < grid->size[1]; ++j)
        for (int64_t i = 0; i < grid->size[0]; ++i) {
            double value = qni_grid_value(grid, i, j, k);
            if (isnan(value))
                ++count.nan_count;
            else if (isinf(value))
                ++count.infinite_count;
            else
                count.largest = fmax(count.largest, fabs(value - field->isovalue));
        }
    return count;
}

void qni_field_set_nonfinite(qni_field *field, int64_t nan_count, int64_t infinite_count,
                             double largest) {
    field->nan_count = nan_count;
    field->infinite_count = infinite_count;
    field->nonfinite_distance = largest > 0 ? fmin(largest, largest_distance) : 1;
    field->direct = false;
}

void qni_field_measure_nonfinite(qn_context *context, qni_field *field) {
    int64_t nan_count = 0, infinite_count = 0;
    const int64_t parts = field->sparse ? qni_sparse_field_part_count(field) : field->grid->size[2];
    double largest = 0;
#pragma omp parallel for schedule(dynamic) reduction(+ : nan_count, infinite_count)                \
    reduction(max : largest) num_threads(qn_context_threads(context))
    for (int64_t k = 0; k < parts; ++k) {
        qni_nonfinite_count count = count_slice(field, k);
        nan_count += count.nan_count;
        infinite_count += count.infinite_count;
        largest = largest > count.largest ? largest : count.largest;
    }
    qni_field_set_nonfinite(field, nan_count, infinite_count, largest);
}
