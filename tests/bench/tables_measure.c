// SPDX-License-Identifier: MIT
/* Deviation, shape and valences of a mesh, as [DMC21] section 5.3 defines them. */
#include "bench/tables_measure.h"
#include "lib/mesh_measure.h"
#include "lib/support.h"
#include "volume/volume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double sample(const qn_grid *grid, int64_t x, int64_t y, int64_t z) {
    return qni_grid_value(grid, x, y, z);
}

/* The trilinear interpolant at a place in index space. */
static double trilinear(const qn_grid *grid, const float position[3]) {
    int64_t cell[3];
    double t[3], value[8];
    for (int a = 0; a < 3; ++a) {
        cell[a] = (int64_t)floor((double)position[a]);
        cell[a] = cell[a] < 0 ? 0 : cell[a] > grid->size[a] - 2 ? grid->size[a] - 2 : cell[a];
        t[a] = (double)position[a] - (double)cell[a];
    }
    for (int c = 0; c < 8; ++c)
        value[c] = sample(grid, cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2));
    for (int a = 0; a < 3; ++a)
        for (int c = 0; c < 4; ++c)
            value[c] = value[2 * c] + t[a] * (value[2 * c + 1] - value[2 * c]);
    return value[0];
}

/* Valence by edges: faces round the vertex, and one more at the boundary. */
static void measure_valences(qn_context *context, qn_mesh *mesh, int regular, tables_measure *m) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const int corners = view.quad_count ? 4 : 3;
    const int64_t count = corners == 4 ? 4 * view.quad_count : 3 * view.triangle_count;
    const uint32_t *origin = corners == 4 ? view.quads : view.triangles;
    int64_t irregular = 0, inner = 0, irregular_inner = 0;
    uint8_t *valence = test_alloc((size_t)view.vertex_count, 1);
    uint8_t *open = test_alloc((size_t)view.vertex_count, 1);
    memset(valence, 0, (size_t)view.vertex_count);
    memset(open, 0, (size_t)view.vertex_count);
    if (qn_mesh_build_halfedges(context, mesh, NULL) != QN_OK)
        abort();
    const qn_halfedges he = qn_mesh_get_halfedges(mesh);
    for (int64_t h = 0; h < count; ++h) {
        const int64_t next = h % corners == corners - 1 ? h + 1 - corners : h + 1;
        ++valence[origin[h]];
        if (he.twin[h] == QN_NO_HALFEDGE) {
            ++valence[origin[next]];
            open[origin[h]] = open[origin[next]] = 1;
        }
    }
    for (int64_t v = 0; v < view.vertex_count; ++v) {
        irregular += valence[v] != regular;
        inner += !open[v];
        irregular_inner += !open[v] && valence[v] != regular;
        if (corners == 4)
            m->valences[valence[v] < TABLES_VALENCES ? valence[v] : TABLES_VALENCES - 1] +=
                100.0 / (double)view.vertex_count;
    }
    const double share = 100.0 * (double)irregular / (double)view.vertex_count;
    if (corners == 4) {
        m->irregular_quads = share;
        m->irregular_inner = 100.0 * (double)irregular_inner / (double)inner;
    } else {
        m->irregular_triangles = share;
    }
    free(valence);
    free(open);
}

static void measure_deviations(const qn_grid *grid, double iso,
                               double (*value)(const void *user, const double index[3]),
                               const void *user, const qn_mesh_view *view, tables_measure *m) {
    double of_formula = 0, of_samples = 0;
    for (int64_t v = 0; v < view->vertex_count; ++v) {
        const float *p = view->positions + 3 * v;
        const double index[3] = {(double)p[0], (double)p[1], (double)p[2]};
        of_samples += fabs(trilinear(grid, p) - iso);
        of_formula += value ? fabs(value(user, index)) : (double)NAN;
    }
    m->deviation = of_samples / (double)view->vertex_count;
    m->deviation_formula = of_formula / (double)view->vertex_count;
}

static double range_of(const qn_grid *grid) {
    double low = INFINITY, high = -INFINITY;
    for (int64_t z = 0; z < grid->size[2]; ++z)
        for (int64_t y = 0; y < grid->size[1]; ++y)
            for (int64_t x = 0; x < grid->size[0]; ++x) {
                const double v = sample(grid, x, y, z);
                low = fmin(low, v);
                high = fmax(high, v);
            }
    return high - low;
}

tables_measure tables_measure_mesh(qn_context *context, const bench_volume *volume,
                                   double (*value)(const void *user, const double index[3]),
                                   const void *user, qn_mesh *mesh) {
    tables_measure m;
    qn_grid grid;
    qn_volume *borrowed = NULL;
    qn_mesh_check_options options;
    qn_mesh_report check;
    memset(&m, 0, sizeof m);
    memset(&grid, 0, sizeof grid);
    grid.samples = volume->samples;
    grid.scalar = volume->scalar;
    grid.swapped = volume->swapped;
    memcpy(grid.size, volume->size, sizeof grid.size);
    qn_mesh_check_options_init(&options);
    options.skip_intersections = true;
    if (qn_volume_create(context, &grid, NULL, NULL, &borrowed, NULL) != QN_OK ||
        qn_mesh_check(context, mesh, &options, &check, NULL) != QN_OK)
        abort();
    qn_mesh_view view = qn_mesh_get_view(mesh);
    m.known = true;
    m.vertices = view.vertex_count;
    m.quads = view.quad_count;
    m.range = range_of(qn_volume_grid(borrowed));
    m.nonmanifold = 100.0 * (double)check.nonmanifold_vertices / (double)view.vertex_count;
    measure_deviations(qn_volume_grid(borrowed), volume->iso, value, user, &view, &m);
    if (view.quad_count) {
        m.quad_quality = test_mean_quad_quality(mesh);
        measure_valences(context, mesh, 4, &m);
        if (qn_mesh_triangulate(context, mesh, NULL) != QN_OK)
            abort();
    }
    m.triangles = qn_mesh_get_view(mesh).triangle_count;
    m.triangle_quality = test_mean_triangle_quality(mesh);
    measure_valences(context, mesh, 6, &m);
    qn_volume_destroy(borrowed);
    return m;
}
