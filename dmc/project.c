// SPDX-License-Identifier: MIT
/* Back onto the trilinear surface. Along an axis the interpolant of a cell is linear, so one
 * division finds its zero. */
#include "dmc/project.h"
#include "dmc/cell_hd.h"
#include "dmc/project_hd.h"
#include "dmc/stencil.h"

#include <math.h>
#include <string.h>

/* Vertices stay this far inside their cells, so that rounding to float does not carry them out. */
static const double cell_margin = 1e-3;

void qni_projector_init(const qni_field *field, qni_projector *projector) {
    double determinant;
    projector->field = field;
    projector->kernels = qni_choose_kernels();
    qni_frame_of_field(field, &projector->frame, &determinant);
    const double(*m)[4] = (const double(*)[4])field->world;
    for (int r = 0; r < 3; ++r) {
        const int r1 = (r + 1) % 3, r2 = (r + 2) % 3;
        for (int c = 0; c < 3; ++c) {
            const int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            projector->lattice[c][r] =
                (m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]) / determinant;
        }
    }
    for (int a = 0; a < 3; ++a) {
        const double *row = projector->lattice[a];
        projector->lattice[a][3] = -(row[0] * m[0][3] + row[1] * m[1][3] + row[2] * m[2][3]);
    }
}

static void to_lattice(const qni_projector *projector, const float world[3], double at[3]) {
    for (int a = 0; a < 3; ++a) {
        const double *row = projector->lattice[a];
        at[a] = (row[0] * (double)world[0] + row[1] * (double)world[1]) +
                (row[2] * (double)world[2] + row[3]);
    }
}

static void to_world(const qni_projector *projector, const double at[3], float world[3]) {
    for (int r = 0; r < 3; ++r) {
        const double *row = projector->field->world[r];
        world[r] = (float)((row[0] * at[0] + row[1] * at[1]) + (row[2] * at[2] + row[3]));
    }
}

static void cell_of(const qni_field *field, const double at[3], int64_t cell[3]) {
    for (int a = 0; a < 3; ++a) {
        const double low = floor(at[a]), last = (double)(field->cells[a] - 1);
        cell[a] = (int64_t)(low < 0 ? 0 : low > last ? last : low);
    }
}

/* Where the slope of the values has to point along each axis for the normal to leave the solid. */
static void slope_of_normal(const qni_projector *projector, const float normal[3],
                            double slope[3]) {
    const qni_field *field = projector->field;
    for (int a = 0; a < 3; ++a) {
        const double sum =
            (field->world[0][a] * (double)normal[0] + field->world[1][a] * (double)normal[1]) +
            field->world[2][a] * (double)normal[2];
        slope[a] = field->inside_below ? sum : -sum;
    }
}

/* Along one axis from `at`, in the cell or the next one towards the zero. */
static bool project_along(const qni_field *field, const int64_t cell[3], const double d[8],
                          int axis, double slope, double at[3]) {
    double end[2], next_values[8];
    const double local[3] = {at[0] - (double)cell[0], at[1] - (double)cell[1],
                             at[2] - (double)cell[2]};
    qni_line_ends(d, axis, local, end);
    double zero = qni_crossing_of_line(end, slope);
    int64_t start = cell[axis];
    if (zero < 0) {
        const double here = qni_lerp(end[0], end[1], local[axis]);
        int64_t next[3] = {cell[0], cell[1], cell[2]};
        next[axis] += (here < 0) == (slope > 0) ? 1 : -1;
        if (next[axis] < 0 || next[axis] >= field->cells[axis])
            return false;
        qni_field_load_cell(field, next, next_values);
        qni_line_ends(next_values, axis, local, end);
        zero = qni_crossing_of_line(end, slope);
        start = next[axis];
    }
    if (zero < 0 || fabs((double)start + zero - at[axis]) > 1)
        return false;
    at[axis] = (double)start + zero;
    return true;
}

/* From a point of the lattice and its cell, with the values at its corners. */
static bool project_near(const qni_projector *projector, const int64_t cell[3], const double d[8],
                         double at[3], const float normal[3], float position[3]) {
    const qni_field *field = projector->field;
    double slope[3];
    int order[3];
    slope_of_normal(projector, normal, slope);
    if (slope[0] == 0 && slope[1] == 0 && slope[2] == 0) {
        const double local[3] = {at[0] - (double)cell[0], at[1] - (double)cell[1],
                                 at[2] - (double)cell[2]};
        qni_slope_of_values(d, local, slope);
    }
    qni_sort_axes(slope, order);
    for (int n = 0; n < 3; ++n)
        if (project_along(field, cell, d, order[n], slope[order[n]], at)) {
            to_world(projector, at, position);
            return true;
        }
    return false;
}

static int lanes_of(const qni_landings *landings) {
    return (landings->count + QNI_LANES - 1) / QNI_LANES * QNI_LANES;
}

void qni_project_start(const qni_projector *projector, const qni_landings *landings,
                       qni_approach *approach) {
    projector->kernels->locate(projector, landings, approach);
    for (int a = 0; a < 3; ++a)
        for (int l = 0; l < lanes_of(landings); ++l)
            approach->cells.cell[a][l] = (int64_t)approach->cell[a][l];
    qni_field_expect_cells(projector->field, lanes_of(landings), &approach->cells);
}

/* One that does not land in its own cell along the first axis. */
static void land_apart(const qni_projector *projector, const qni_approach *approach, int lane,
                       qni_landings *landings) {
    int64_t cell[3];
    double at[3], d[8];
    float normal[3], position[3];
    for (int c = 0; c < 8; ++c)
        d[c] = approach->corner[c][lane];
    for (int a = 0; a < 3; ++a) {
        cell[a] = approach->cells.cell[a][lane];
        at[a] = approach->at[a][lane];
        normal[a] = landings->normal[a][lane];
    }
    landings->landed[lane] = project_near(projector, cell, d, at, normal, position);
    for (int a = 0; a < 3 && landings->landed[lane]; ++a)
        landings->position[a][lane] = position[a];
}

void qni_project_end(const qni_projector *projector, qni_approach *approach,
                     qni_landings *landings) {
    qni_field_load_cells(projector->field, lanes_of(landings), &approach->cells, approach->corner);
    projector->kernels->land(projector, approach, landings);
    for (int l = 0; l < landings->count; ++l)
        if (!landings->landed[l])
            land_apart(projector, approach, l, landings);
}

bool qni_project_home(const void *user, const float position[3], int32_t cell_out[3]) {
    const qni_projector *projector = user;
    double at[3], d[8];
    int64_t cell[3];
    int signs = 0;
    to_lattice(projector, position, at);
    cell_of(projector->field, at, cell);
    qni_field_load_cell(projector->field, cell, d);
    for (int c = 0; c < 8; ++c)
        signs |= (d[c] >= 0) << c;
    for (int a = 0; a < 3; ++a)
        cell_out[a] = (int32_t)cell[a];
    return signs != 0 && signs != 255 && qni_entry_polygons(qni_cell_resolve(d, signs).entry) == 1;
}

/* As much of the way from `from` to `to` as the cell allows. */
static void step_back_into_cell(const int32_t cell[3], const double from[3], double to[3]) {
    double share = 1;
    for (int a = 0; a < 3; ++a) {
        const double low = cell[a] + cell_margin, high = cell[a] + 1 - cell_margin,
                     way = to[a] - from[a];
        if (to[a] < low && way < 0)
            share = fmin(share, fmax(0, (low - from[a]) / way));
        if (to[a] > high && way > 0)
            share = fmin(share, fmax(0, (high - from[a]) / way));
    }
    for (int a = 0; a < 3; ++a)
        to[a] = from[a] + share * (to[a] - from[a]);
}

bool qni_project_in_cell(const void *user, const int32_t cell[3], const float from[3],
                         const float normal[3], float position[3]) {
    const qni_projector *projector = user;
    double at[3], start[3], d[8], slope[3], end[2];
    int order[3];
    const int64_t cell_64[3] = {cell[0], cell[1], cell[2]};
    to_lattice(projector, position, at);
    to_lattice(projector, from, start);
    qni_field_load_cell(projector->field, cell_64, d);
    slope_of_normal(projector, normal, slope);
    qni_sort_axes(slope, order);
    step_back_into_cell(cell, start, at);
    const double local[3] = {at[0] - cell[0], at[1] - cell[1], at[2] - cell[2]};
    for (int n = 0; n < 3; ++n) {
        qni_line_ends(d, order[n], local, end);
        const double zero = qni_crossing_of_line(end, slope[order[n]]);
        if (zero < cell_margin || zero > 1 - cell_margin)
            continue;
        at[order[n]] = cell[order[n]] + zero;
        to_world(projector, at, position);
        return true;
    }
    return false;
}

void qni_project_normal(const void *user, const int32_t cell[3], const float position[3],
                        float normal[3]) {
    const qni_projector *projector = user;
    double at[3], stencil[QNI_STENCIL];
    float unused[3], found[3];
    const double base[3] = {cell[0], cell[1], cell[2]};
    to_lattice(projector, position, at);
    const int64_t cell_64[3] = {cell[0], cell[1], cell[2]};
    qni_load_stencil(projector->field, cell_64, stencil);
    const double local[3] = {at[0] - base[0], at[1] - base[1], at[2] - base[2]};
    qni_place_point(stencil, base, local, &projector->frame, unused, found);
    const float squares = (found[0] * found[0] + found[1] * found[1]) + found[2] * found[2];
    if (squares > 0.99f && squares < 1.01f)
        memcpy(normal, found, sizeof found);
}
