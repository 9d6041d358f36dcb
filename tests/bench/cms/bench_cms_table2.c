// SPDX-License-Identifier: MIT
/* [CMS05] Table 2: the mean distance from the mesh to the true surface for each case of marching
 * cubes, over unions of three random tetrahedra on a uniform grid, for Cubical Marching Squares,
 * for the same code without features (marching cubes with consistent faces) and for dual
 * contouring, all on the same Hermite data.
 *
 * The distance is in cell edges, of points spread evenly over the piece of mesh that the cell
 * makes: its triangles, or of dual contouring the quarters of quads at its vertex. A cell's error
 * is the mean over its points, a case's the mean over its cells. */
#include "bench/cms/cases.h"
#include "bench/cms/dual_contouring.h"
#include "bench/cms/tetrahedra.h"

#include <math.h>

enum { CMS, MARCHING_CUBES, DUAL_CONTOURING, METHODS, LONGEST = 64 };

/* [CMS05] table 2: cells, dual contouring, extended marching cubes, CMS. */
static const double printed[CASES][4] = {{0},
                                         {3590980, 0.01473, 0.00586, 0.00383},
                                         {1554028, 0.02309, 0.01310, 0.01013},
                                         {207302, 0.10027, 0.01801, 0.01263},
                                         {30972, 0.23064, 0.00601, 0.00422},
                                         {803311, 0.03779, 0.02631, 0.02011},
                                         {101875, 0.11998, 0.02737, 0.02633},
                                         {12198, 0.17139, 0.09565, 0.01628},
                                         {109141, 0.03979, 0.02831, 0.02184},
                                         {72201, 0.04721, 0.03525, 0.02492},
                                         {4237, 0.19682, 0.05283, 0.04541},
                                         {70238, 0.04789, 0.03535, 0.02620},
                                         {30706, 0.09845, 0.04559, 0.02419},
                                         {1405, 0.85461, 0.92935, 0.00100},
                                         {70238, 0.04821, 0.03573, 0.02653}};

typedef struct error_sum {
    double distance, area; /* distance times area */
} error_sum;

typedef struct experiment {
    int depth, scenes, show;
    uint64_t seed;
    double cell_error[METHODS][CASES]; /* sums over cells */
    int64_t cells[CASES];
    double worst; /* of the case to be shown */
    int64_t worst_scene;
    int32_t worst_cell[3];
    double worst_errors[METHODS];
} experiment;

typedef struct scene {
    const qni_hermite *hermite;
    const test_distance_tree *surface;
    error_sum *sums[METHODS]; /* of each cell of the grid */
} scene;

static int64_t cell_number(const qni_lattice *lattice, const int32_t cell[3]) {
    return cell[0] + (int64_t)lattice->cells[0] * (cell[1] + (int64_t)lattice->cells[1] * cell[2]);
}

/* Six points of equal weight, symmetric in the corners. */
static void add_triangle(const scene *s, error_sum *sum, const double t[3][3]) {
    static const double weights[6][3] = {{4, 1, 1},     {1, 4, 1},     {1, 1, 4},
                                         {1, 2.5, 2.5}, {2.5, 1, 2.5}, {2.5, 2.5, 1}};
    double u[3], v[3], square = 0;
    for (int k = 0; k < 3; ++k) {
        u[k] = t[1][k] - t[0][k];
        v[k] = t[2][k] - t[0][k];
    }
    for (int k = 0; k < 3; ++k) {
        const double n = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        square += n * n;
    }
    const double area = 0.5 * sqrt(square);
    for (int n = 0; n < 6; ++n) {
        double point[3];
        for (int k = 0; k < 3; ++k)
            point[k] =
                (weights[n][0] * t[0][k] + weights[n][1] * t[1][k] + weights[n][2] * t[2][k]) / 6;
        sum->distance += area / 6 * test_distance_to_mesh(s->surface, point);
        sum->area += area / 6;
    }
}

/* Each triangle lies within one cell. */
static void add_mesh(const scene *s, const qn_mesh *mesh, error_sum *sums) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const qni_lattice *lattice = &s->hermite->lattice;
    for (int64_t n = 0; n < view.triangle_count; ++n) {
        double t[3][3], middle[3] = {0, 0, 0};
        int32_t cell[3];
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k) {
                t[c][k] = (double)view.positions[3 * (int64_t)view.triangles[3 * n + c] + k];
                middle[k] += t[c][k] / 3;
            }
        for (int k = 0; k < 3; ++k) {
            cell[k] = (int32_t)floor((middle[k] - lattice->origin[k]) / lattice->step[k]) +
                      lattice->shift[k];
        }
        add_triangle(s, &sums[cell_number(lattice, cell)], (const double(*)[3])t);
    }
}

/* The quad round one edge with a change of sign, a quarter to each of its cells. */
static void add_quad(const scene *s, const int32_t point[3], int axis) {
    const int p = (axis + 1) % 3, q = (axis + 2) % 3;
    double corners[4][3], centre[3] = {0, 0, 0};
    int32_t cells[4][3];
    for (int n = 0; n < 4; ++n) {
        memcpy(cells[n], point, sizeof cells[n]);
        cells[n][p] -= n == 1 || n == 2;
        cells[n][q] -= n >= 2;
        if (!dual_contouring_vertex(s->hermite, cells[n], corners[n]))
            return;
        for (int k = 0; k < 3; ++k)
            centre[k] += 0.25 * corners[n][k];
    }
    for (int n = 0; n < 4; ++n) {
        double t[2][3][3];
        for (int k = 0; k < 3; ++k) {
            const double next = 0.5 * (corners[n][k] + corners[(n + 1) % 4][k]),
                         last = 0.5 * (corners[n][k] + corners[(n + 3) % 4][k]);
            t[0][0][k] = t[1][0][k] = corners[n][k];
            t[0][1][k] = next;
            t[0][2][k] = t[1][1][k] = centre[k];
            t[1][2][k] = last;
        }
        error_sum *sum = &s->sums[DUAL_CONTOURING][cell_number(&s->hermite->lattice, cells[n])];
        add_triangle(s, sum, (const double(*)[3])t[0]);
        add_triangle(s, sum, (const double(*)[3])t[1]);
    }
}

static void add_dual_contouring(const scene *s) {
    const int32_t *cells = s->hermite->lattice.cells;
    for (int axis = 0; axis < 3; ++axis)
        for (int32_t z = 1; z < cells[2]; ++z)
            for (int32_t y = 1; y < cells[1]; ++y)
                for (int32_t x = 1; x < cells[0]; ++x) {
                    const int32_t point[3] = {x, y, z};
                    int32_t other[3] = {x, y, z};
                    ++other[axis];
                    if (qni_hermite_sign(s->hermite, point) * qni_hermite_sign(s->hermite, other) ==
                            0 &&
                        qni_hermite_sign(s->hermite, point) != qni_hermite_sign(s->hermite, other))
                        add_quad(s, point, axis);
                }
}

static int signs_of(const qni_hermite *hermite, const int32_t cell[3]) {
    int signs = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int32_t point[3] = {cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                                  cell[2] + (corner >> 2)};
        signs |= (qni_hermite_sign(hermite, point) == 1) << corner;
    }
    return signs;
}

static void note_cell(experiment *e, const scene *s, int64_t number, const int32_t cell[3],
                      int64_t scene_number) {
    const int which = marching_cubes_case(signs_of(s->hermite, cell));
    double errors[METHODS];
    for (int m = 0; m < METHODS; ++m) {
        const error_sum *sum = &s->sums[m][number];
        if (!(sum->area > 0))
            return;
        errors[m] = sum->distance / sum->area / s->hermite->lattice.cell;
    }
    if (which <= 0)
        return;
    ++e->cells[which];
    for (int m = 0; m < METHODS; ++m)
        e->cell_error[m][which] += errors[m];
    if (which == e->show && errors[CMS] > e->worst) {
        e->worst = errors[CMS];
        e->worst_scene = scene_number;
        memcpy(e->worst_cell, cell, sizeof e->worst_cell);
        memcpy(e->worst_errors, errors, sizeof errors);
    }
}

static void measure(experiment *e, qn_context *context, const qn_solid *solid, scene *s,
                    int64_t number) {
    const qni_lattice *lattice = &s->hermite->lattice;
    const int64_t count = (int64_t)lattice->cells[0] * lattice->cells[1] * lattice->cells[2];
    qn_solid_surface_options options;
    qn_solid_surface_options_init(&options);
    options.depth = e->depth;
    options.uniform = true;
    for (int m = 0; m < METHODS; ++m) {
        s->sums[m] = test_alloc((size_t)count, sizeof *s->sums[m]);
        memset(s->sums[m], 0, (size_t)count * sizeof *s->sums[m]);
        if (m == DUAL_CONTOURING)
            break;
        qn_mesh *mesh;
        options.no_features = m == MARCHING_CUBES;
        assert_int_equal(qn_solid_surface(context, solid, &options, &mesh, NULL, NULL), QN_OK);
        add_mesh(s, mesh, s->sums[m]);
        qn_mesh_destroy(mesh);
    }
    add_dual_contouring(s);
    for (int64_t n = 0; n < count; ++n) {
        const int32_t cell[3] = {(int32_t)(n % lattice->cells[0]),
                                 (int32_t)(n / lattice->cells[0] % lattice->cells[1]),
                                 (int32_t)(n / lattice->cells[0] / lattice->cells[1])};
        note_cell(e, s, n, cell, number);
    }
    for (int m = 0; m < METHODS; ++m)
        free(s->sums[m]);
}

/* The lattice that qn_solid_surface() takes: a thousandth of room round the solid's box. */
static void run_scene(experiment *e, int64_t number) {
    qn_context *context = test_context(1);
    test_random random = {e->seed + (uint64_t)number};
    const tetrahedra three = tetrahedra_random(&random);
    qn_solid *solid = tetrahedra_solid(context, &three);
    qni_box box = solid->box;
    double extent = 0;
    for (int k = 0; k < 3; ++k)
        extent = fmax(extent, box.high[k] - box.low[k]);
    for (int k = 0; k < 3; ++k) {
        box.low[k] -= 1e-3 * extent;
        box.high[k] += 1e-3 * extent;
    }
    qni_lattice lattice;
    qni_hermite hermite;
    assert_int_equal(qni_lattice_init(&lattice, &box, extent, e->depth, 8, NULL), QN_OK);
    assert_int_equal(qni_hermite_create(context, solid, &lattice, &hermite, NULL), QN_OK);
    test_distance_tree *surface = tetrahedra_surface(context, &three);
    scene s = {&hermite, surface, {NULL}};
    measure(e, context, solid, &s, number);
    test_distance_tree_destroy(surface);
    qni_hermite_destroy(&hermite);
    qn_solid_destroy(solid);
    test_context_end(context);
}

/* How many times nearer than dual contouring, weighted by the cases' cells. */
static double print_table(const experiment *e) {
    double sums[METHODS] = {0}, printed_sums[3] = {0}, cells = 0, printed_cells = 0;
    printf(
        "| case | cells | marching cubes | dual contouring | CMS | CMS / DC | [CMS05]: DC | CMS | "
        "CMS / DC | at or below it |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (int n = 1; n < CASES; ++n) {
        double mean[METHODS];
        for (int m = 0; m < METHODS; ++m) {
            mean[m] = e->cells[n] ? e->cell_error[m][n] / (double)e->cells[n] : 0;
            sums[m] += e->cell_error[m][n];
        }
        cells += (double)e->cells[n];
        printed_cells += printed[n][0];
        for (int m = 0; m < 3; ++m)
            printed_sums[m] += printed[n][0] * printed[n][m + 1];
        const double ratio = mean[CMS] / mean[DUAL_CONTOURING],
                     theirs = printed[n][3] / printed[n][1];
        printf("| %d | %lld | %.5f | %.5f | %.5f | %.3f | %.5f | %.5f | %.3g | %s |\n", n,
               (long long)e->cells[n], mean[MARCHING_CUBES], mean[DUAL_CONTOURING], mean[CMS],
               ratio, printed[n][1], printed[n][3], theirs,
               !e->cells[n]      ? "not met"
               : ratio <= theirs ? "yes"
                                 : "**no**");
    }
    printf("| all | %.0f | %.5f | %.5f | %.5f | %.3f | %.5f | %.5f | %.3f | |\n", cells,
           sums[MARCHING_CUBES] / cells, sums[DUAL_CONTOURING] / cells, sums[CMS] / cells,
           sums[CMS] / sums[DUAL_CONTOURING], printed_sums[0] / printed_cells,
           printed_sums[2] / printed_cells, printed_sums[2] / printed_sums[0]);
    return sums[DUAL_CONTOURING] / sums[CMS];
}

static void print_worst(const experiment *e) {
    printf("\nCase %d, the cell farthest off: scene %lld of seed %llu, cell %d %d %d: CMS %.4f, "
           "marching cubes %.4f, dual contouring %.4f\n",
           e->show, (long long)e->worst_scene, (unsigned long long)e->seed, e->worst_cell[0],
           e->worst_cell[1], e->worst_cell[2], e->worst_errors[CMS],
           e->worst_errors[MARCHING_CUBES], e->worst_errors[DUAL_CONTOURING]);
}

int main(int argc, char **argv) {
    experiment e = {.depth = 3, .scenes = 500, .seed = 2005};
    double least_gain = 0;
    for (int n = 1; n + 1 < argc; n += 2) {
        const double value = atof(argv[n + 1]);
        if (strcmp(argv[n], "--depth") == 0)
            e.depth = (int)value;
        else if (strcmp(argv[n], "--scenes") == 0)
            e.scenes = (int)value;
        else if (strcmp(argv[n], "--seed") == 0)
            e.seed = (uint64_t)value;
        else if (strcmp(argv[n], "--show") == 0)
            e.show = (int)value;
        else if (strcmp(argv[n], "--least-gain") == 0)
            least_gain = value;
        else
            argc = 0;
    }
    if (argc % 2 == 0 || e.scenes < 1 || e.depth < QN_MIN_DEPTH || e.depth > LONGEST) {
        fprintf(stderr, "usage: bench_cms_table2 [--depth D] [--scenes N] [--seed S] [--show CASE] "
                        "[--least-gain TIMES-NEARER-THAN-DUAL-CONTOURING]\n");
        return 2;
    }
    printf("%d unions of three tetrahedra, seed %llu, 2^%d cells\n\n", e.scenes,
           (unsigned long long)e.seed, e.depth);
    for (int n = 0; n < e.scenes; ++n)
        run_scene(&e, n);
    const double gain = print_table(&e);
    if (e.show)
        print_worst(&e);
    return gain >= least_gain ? 0 : 1;
}
