// SPDX-License-Identifier: MIT
/* Two reference surfacers, plain and small: marching cubes (Lorensen and Cline 1987, faces by
 * Nielson and Hamann 1991) and dual contouring (Ju et al. 2002, section 2, on a uniform lattice).
 */
#include "bench/tables.h"
#include "dmc/cell_hd.h"
#include "lib/support.h"
#include "volume/field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Four slices of values less iso: those of z - 1 to z + 2 when cells of slice z are at hand. */
typedef struct slices {
    qni_field field;
    int64_t n[3], z;
    double *slice[4];
} slices;

/* Growing arrays of the mesh to be. */
typedef struct output {
    float *positions;
    uint32_t *corners;
    int64_t vertices, vertex_room, indices, index_room;
} output;

static void fill_slice(slices *s, int64_t z, double *slice) {
    const int64_t inner = z < 0 ? 0 : z >= s->n[2] ? s->n[2] - 1 : z;
    for (int64_t y = 0; y < s->n[1]; ++y)
        for (int64_t x = 0; x < s->n[0]; ++x)
            *slice++ = qni_field_value(&s->field, x, y, inner);
}

static bool slices_start(slices *s, const qn_volume *volume, double iso) {
    memset(s, 0, sizeof *s);
    if (qni_field_init(volume, iso, false, true, &s->field, NULL) != QN_OK)
        return false;
    memcpy(s->n, s->field.samples, sizeof s->n);
    for (int n = 0; n < 4; ++n) {
        s->slice[n] = test_alloc((size_t)(s->n[0] * s->n[1]), sizeof(double));
        fill_slice(s, n - 1, s->slice[n]);
    }
    return true;
}

static void slices_step(slices *s) {
    double *first = s->slice[0];
    memmove(s->slice, s->slice + 1, 3 * sizeof *s->slice);
    s->slice[3] = first;
    ++s->z;
    fill_slice(s, s->z + 2, first);
}

static void slices_end(slices *s) {
    for (int n = 0; n < 4; ++n)
        free(s->slice[n]);
}

static double at(const slices *s, int64_t x, int64_t y, int64_t dz) {
    return s->slice[1 + dz][y * s->n[0] + x];
}

static uint32_t add_vertex(output *out, const double p[3]) {
    if (out->vertices == out->vertex_room) {
        out->vertex_room = 2 * out->vertex_room + 1024;
        out->positions =
            realloc(out->positions, (size_t)out->vertex_room * 3 * sizeof *out->positions);
    }
    for (int a = 0; a < 3; ++a)
        out->positions[3 * out->vertices + a] = (float)p[a];
    return (uint32_t)out->vertices++;
}

static void add_face(output *out, const uint32_t *corners, int count) {
    if (out->indices + count > out->index_room) {
        out->index_room = 2 * out->index_room + 4096;
        out->corners = realloc(out->corners, (size_t)out->index_room * sizeof *out->corners);
    }
    memcpy(out->corners + out->indices, corners, (size_t)count * sizeof *corners);
    out->indices += count;
}

static qn_mesh *finish(qn_context *context, output *out, int corners) {
    qn_mesh_view view;
    qn_mesh *mesh = NULL;
    memset(&view, 0, sizeof view);
    view.vertex_count = out->vertices;
    view.positions = out->positions;
    view.space = view.unit = "";
    if (corners == 4) {
        view.quads = out->corners;
        view.quad_count = out->indices / 4;
    } else {
        view.triangles = out->corners;
        view.triangle_count = out->indices / 3;
    }
    if (qn_mesh_create(context, &view, &mesh, NULL) != QN_OK)
        mesh = NULL;
    free(out->positions);
    free(out->corners);
    return mesh;
}

static qn_volume *borrow(qn_context *context, const bench_volume *volume) {
    qn_grid grid;
    qn_volume *result = NULL;
    memset(&grid, 0, sizeof grid);
    grid.samples = volume->samples;
    grid.scalar = volume->scalar;
    grid.swapped = volume->swapped;
    memcpy(grid.size, volume->size, sizeof grid.size);
    return qn_volume_create(context, &grid, NULL, NULL, &result, NULL) == QN_OK ? result : NULL;
}

/* Corner values of a cell of the slice; its case, 0 and 255 for none. */
static int load_cell(const slices *s, int64_t x, int64_t y, double d[8]) {
    int bits = 0;
    for (int c = 0; c < 8; ++c) {
        d[c] = at(s, x + (c & 1), y + (c >> 1 & 1), c >> 2);
        bits |= (d[c] >= 0) << c;
    }
    return bits;
}

static void edge_start(int edge, int step[3]) {
    const int corner = qni_edge_start_corner(edge);
    for (int a = 0; a < 3; ++a)
        step[a] = corner >> a & 1;
}

static double crossing(const double d[8], int edge) {
    const int from = qni_edge_start_corner(edge);
    return d[from] / (d[from] - d[from | 1 << qni_edge_axis(edge)]);
}

/* ---- marching cubes -------------------------------------------------------------------------- */

/* Vertices of the lattice edges that start on a slice: [axis][y][x]. */
typedef struct edge_ids {
    uint32_t *id[2][3];
} edge_ids;

static uint32_t edge_vertex(const slices *s, edge_ids *ids, const double d[8], int64_t x, int64_t y,
                            int edge, output *out) {
    int step[3];
    edge_start(edge, step);
    const int axis = qni_edge_axis(edge);
    uint32_t *id = ids->id[step[2]][axis] + (y + step[1]) * s->n[0] + x + step[0];
    if (*id == UINT32_MAX) {
        double p[3] = {(double)(x + step[0]), (double)(y + step[1]), (double)(s->z + step[2])};
        p[axis] += crossing(d, edge);
        *id = add_vertex(out, p);
    }
    return *id;
}

static void march_cell(const slices *s, edge_ids *ids, int64_t x, int64_t y, output *out) {
    double d[8];
    const int bits = load_cell(s, x, y, d);
    if (bits == 0 || bits == 255)
        return;
    const int entry = qni_cell_resolve(d, bits).entry;
    const uint64_t next = qni_entry_next_code(entry);
    for (int polygon = 0; polygon < qni_entry_polygons(entry); ++polygon) {
        const unsigned edges = qni_entry_edges(entry, polygon);
        int first = 0;
        while (!(edges >> first & 1))
            ++first;
        uint32_t fan[3] = {edge_vertex(s, ids, d, x, y, first, out), 0, 0};
        for (int edge = (int)(next >> (4 * first) & 15);;) {
            const int after = (int)(next >> (4 * edge) & 15);
            if (after == first)
                break;
            fan[1] = edge_vertex(s, ids, d, x, y, edge, out);
            fan[2] = edge_vertex(s, ids, d, x, y, after, out);
            add_face(out, fan, 3);
            edge = after;
        }
    }
}

qn_mesh *tables_marching_cubes(qn_context *context, const bench_volume *bench) {
    output out = {NULL, NULL, 0, 0, 0, 0};
    slices s;
    edge_ids ids;
    qn_volume *volume = borrow(context, bench);
    if (!volume || !slices_start(&s, volume, bench->iso))
        return NULL;
    const size_t area = (size_t)(s.n[0] * s.n[1]) * sizeof(uint32_t);
    for (int n = 0; n < 6; ++n)
        memset(ids.id[n / 3][n % 3] = test_alloc(area, 1), 0xff, area);
    for (int64_t z = 0; z + 1 < s.n[2]; ++z) {
        for (int64_t y = 0; y + 1 < s.n[1]; ++y)
            for (int64_t x = 0; x + 1 < s.n[0]; ++x)
                march_cell(&s, &ids, x, y, &out);
        for (int axis = 0; axis < 3; ++axis) {
            uint32_t *old = ids.id[0][axis];
            ids.id[0][axis] = ids.id[1][axis];
            ids.id[1][axis] = old;
            memset(old, 0xff, area);
        }
        slices_step(&s);
    }
    for (int n = 0; n < 6; ++n)
        free(ids.id[n / 3][n % 3]);
    slices_end(&s);
    qn_volume_destroy(volume);
    return finish(context, &out, 3);
}

/* ---- dual contouring ------------------------------------------------------------------------- */

/* Central differences at a lattice point, one-sided at the border. */
static void gradient_at(const slices *s, int64_t x, int64_t y, int dz, double g[3]) {
    const int64_t *n = s->n;
    const int64_t x0 = x > 0 ? x - 1 : x, x1 = x + 1 < n[0] ? x + 1 : x;
    const int64_t y0 = y > 0 ? y - 1 : y, y1 = y + 1 < n[1] ? y + 1 : y;
    const int64_t z = s->z + dz;
    g[0] = (at(s, x1, y, dz) - at(s, x0, y, dz)) / (double)(x1 - x0);
    g[1] = (at(s, x, y1, dz) - at(s, x, y0, dz)) / (double)(y1 - y0);
    g[2] = (at(s, x, y, dz + 1) - at(s, x, y, dz - 1)) / (z > 0 && z + 1 < n[2] ? 2.0 : 1.0);
}

/* The edge's crossing, local, and the unit normal there. */
static void hermite(const slices *s, const double d[8], int64_t x, int64_t y, int edge, double p[3],
                    double normal[3]) {
    int step[3];
    double g[2][3], squares = 0;
    const int axis = qni_edge_axis(edge);
    const double t = crossing(d, edge);
    edge_start(edge, step);
    for (int end = 0; end < 2; ++end) {
        const int64_t to[3] = {step[0] + (end && axis == 0), step[1] + (end && axis == 1),
                               step[2] + (end && axis == 2)};
        gradient_at(s, x + to[0], y + to[1], (int)to[2], g[end]);
    }
    for (int a = 0; a < 3; ++a) {
        p[a] = step[a];
        normal[a] = g[0][a] + t * (g[1][a] - g[0][a]);
        squares += normal[a] * normal[a];
    }
    p[axis] += t;
    for (int a = 0; a < 3 && squares > 0; ++a)
        normal[a] /= sqrt(squares);
}

/* Eigenvectors of a symmetric matrix, which becomes diagonal: cyclic Jacobi. */
static void diagonalise(double m[3][3], double vectors[3][3]) {
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            vectors[r][c] = r == c;
    for (int sweep = 0; sweep < 20; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (fabs(m[p][q]) < 1e-300)
                    continue;
                const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
                const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
                const double c = 1 / sqrt(t * t + 1), sine = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double a = m[k][p], b = m[k][q];
                    m[k][p] = c * a - sine * b;
                    m[k][q] = sine * a + c * b;
                }
                for (int k = 0; k < 3; ++k) {
                    const double a = m[p][k], b = m[q][k];
                    m[p][k] = c * a - sine * b;
                    m[q][k] = sine * a + c * b;
                }
                for (int k = 0; k < 3; ++k) {
                    const double a = vectors[k][p], b = vectors[k][q];
                    vectors[k][p] = c * a - sine * b;
                    vectors[k][q] = sine * a + c * b;
                }
            }
}

/* Least squares from the mean of the crossings, directions of less than a tenth of the largest
 * eigenvalue left out (Ju et al. section 2.3); brought back into the cell. */
static void place_by_error(const double p[QNI_EDGES][3], const double normal[QNI_EDGES][3],
                           int count, double place[3]) {
    double mean[3] = {0, 0, 0}, m[3][3] = {{0}}, b[3] = {0, 0, 0}, vectors[3][3], largest = 0;
    for (int n = 0; n < count; ++n)
        for (int a = 0; a < 3; ++a)
            mean[a] += p[n][a] / count;
    for (int n = 0; n < count; ++n) {
        double off = 0;
        for (int a = 0; a < 3; ++a)
            off += normal[n][a] * (p[n][a] - mean[a]);
        for (int a = 0; a < 3; ++a) {
            b[a] += normal[n][a] * off;
            for (int c = 0; c < 3; ++c)
                m[a][c] += normal[n][a] * normal[n][c];
        }
    }
    diagonalise(m, vectors);
    for (int k = 0; k < 3; ++k)
        largest = fmax(largest, m[k][k]);
    memcpy(place, mean, sizeof mean);
    for (int k = 0; k < 3; ++k) {
        if (!(m[k][k] > 0.1 * largest))
            continue;
        const double along =
            (vectors[0][k] * b[0] + vectors[1][k] * b[1] + vectors[2][k] * b[2]) / m[k][k];
        for (int a = 0; a < 3; ++a)
            place[a] += along * vectors[a][k];
    }
    for (int a = 0; a < 3; ++a)
        place[a] = fmin(fmax(place[a], 0), 1);
}

static uint32_t contour_cell(const slices *s, int64_t x, int64_t y, output *out) {
    double d[8], p[QNI_EDGES][3], normal[QNI_EDGES][3], place[3];
    const int bits = load_cell(s, x, y, d);
    int count = 0;
    if (bits == 0 || bits == 255)
        return UINT32_MAX;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int from = qni_edge_start_corner(edge), to = from | 1 << qni_edge_axis(edge);
        if ((bits >> from & 1) == (bits >> to & 1))
            continue;
        hermite(s, d, x, y, edge, p[count], normal[count]);
        ++count;
    }
    place_by_error((const double(*)[3])p, (const double(*)[3])normal, count, place);
    place[0] += (double)x;
    place[1] += (double)y;
    place[2] += (double)s->z;
    return add_vertex(out, place);
}

/* The quads of the edges that start at a lattice point of slice z; ids[0] are the cells of slice
 * z - 1, ids[1] those of slice z. */
static void contour_point(const slices *s, uint32_t *const ids[2], int64_t x, int64_t y,
                          output *out) {
    const int64_t row = s->n[0], cell = y * row + x;
    const bool above = at(s, x, y, 0) >= 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int64_t end[3] = {x + (axis == 0), y + (axis == 1), s->z + (axis == 2)};
        const bool inner = (axis == 0 || (x > 0 && x + 1 < s->n[0])) &&
                           (axis == 1 || (y > 0 && y + 1 < s->n[1])) &&
                           (axis == 2 || (s->z > 0 && s->z + 1 < s->n[2])) && end[0] < s->n[0] &&
                           end[1] < s->n[1] && end[2] < s->n[2];
        if (!inner || above == (at(s, end[0], end[1], axis == 2) >= 0))
            continue;
        const int64_t back[3] = {1, row, 0};
        const int u = axis == 0 ? 1 : axis == 1 ? 2 : 0, v = 3 - axis - u;
        uint32_t quad[4];
        for (int n = 0; n < 4;
             ++n) { /* (-u,-v) (0,-v) (0,0) (-u,0): counter-clockwise from above */
            const bool low_u = n == 0 || n == 3, low_v = n < 2;
            const int down = (low_u && u == 2) || (low_v && v == 2);
            const int64_t to = cell - (low_u ? back[u] : 0) - (low_v ? back[v] : 0);
            quad[above ? n : 3 - n] = ids[1 - down][to];
        }
        add_face(out, quad, 4);
    }
}

qn_mesh *tables_dual_contouring(qn_context *context, const bench_volume *bench) {
    output out = {NULL, NULL, 0, 0, 0, 0};
    slices s;
    qn_volume *volume = borrow(context, bench);
    if (!volume || !slices_start(&s, volume, bench->iso))
        return NULL;
    const int64_t area = s.n[0] * s.n[1];
    uint32_t *ids[2];
    for (int n = 0; n < 2; ++n)
        ids[n] = test_alloc((size_t)area, sizeof(uint32_t));
    for (int64_t z = 0; z + 1 < s.n[2]; ++z) {
        for (int64_t y = 0; y + 1 < s.n[1]; ++y)
            for (int64_t x = 0; x + 1 < s.n[0]; ++x)
                ids[1][y * s.n[0] + x] = contour_cell(&s, x, y, &out);
        for (int64_t y = 0; y < s.n[1]; ++y)
            for (int64_t x = 0; x < s.n[0]; ++x)
                contour_point(&s, ids, x, y, &out);
        uint32_t *old = ids[0];
        ids[0] = ids[1];
        ids[1] = old;
        slices_step(&s);
    }
    free(ids[0]);
    free(ids[1]);
    slices_end(&s);
    qn_volume_destroy(volume);
    return finish(context, &out, 4);
}
