// SPDX-License-Identifier: MIT
/* The trilinear interpolant, straight from its definition. */
#include "lib/trilinear.h"

#include <float.h>
#include <math.h>

void test_cell_corners(const test_field *field, const int64_t cell[3], double corners[8]) {
    for (int c = 0; c < 8; ++c)
        corners[c] = test_field_distance(field, cell[0] + (c & 1), cell[1] + (c >> 1 & 1),
                                         cell[2] + (c >> 2));
}

double test_trilinear(const double corners[8], const double local[3], double gradient[3]) {
    double value = 0, slope[3] = {0, 0, 0};
    for (int c = 0; c < 8; ++c) {
        double weight[3], sign[3];
        for (int a = 0; a < 3; ++a) {
            bool high = c >> a & 1;
            weight[a] = high ? local[a] : 1 - local[a];
            sign[a] = high ? 1 : -1;
        }
        value += corners[c] * weight[0] * weight[1] * weight[2];
        for (int a = 0; a < 3; ++a)
            slope[a] += corners[c] * sign[a] * weight[(a + 1) % 3] * weight[(a + 2) % 3];
    }
    if (gradient)
        memcpy(gradient, slope, sizeof slope);
    return value;
}

void test_to_world(const test_field *field, const double index[3], double world[3]) {
    for (int r = 0; r < 3; ++r)
        world[r] = field->matrix[r][0] * index[0] + field->matrix[r][1] * index[1] +
                   field->matrix[r][2] * index[2] + field->matrix[r][3];
}

void test_to_index(const test_field *field, const float world[3], double index[3]) {
    for (int r = 0; r < 3; ++r)
        index[r] = field->inverse[r][0] * (double)world[0] +
                   field->inverse[r][1] * (double)world[1] +
                   field->inverse[r][2] * (double)world[2] + field->inverse[r][3];
}

void test_cell_of(const test_field *field, const double index[3], int64_t cell[3]) {
    for (int a = 0; a < 3; ++a) {
        cell[a] = (int64_t)floor(index[a]);
        if (cell[a] < test_field_first_cell(field))
            cell[a] = test_field_first_cell(field);
        if (cell[a] >= test_field_end_cell(field, a))
            cell[a] = test_field_end_cell(field, a) - 1;
    }
}

void test_rounding(const test_field *field, const float world[3], double rounding[3]) {
    double half_ulp[3];
    for (int a = 0; a < 3; ++a) /* and a little for the products in double */
        half_ulp[a] = fmax(fabs((double)world[a]) * (double)FLT_EPSILON / 2, (double)FLT_MIN);
    for (int r = 0; r < 3; ++r) {
        rounding[r] = 1e-12;
        for (int c = 0; c < 3; ++c)
            rounding[r] += fabs(field->inverse[r][c]) * half_ulp[c];
    }
}

test_standing test_vertex_standing(const test_field *field, const int64_t cell[3],
                                   const float world[3]) {
    double corners[8], index[3], local[3], rounding[3], gradient[3];
    test_cell_corners(field, cell, corners);
    test_to_index(field, world, index);
    test_rounding(field, world, rounding);
    test_standing standing = {0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        local[a] = index[a] - (double)cell[a];
        double out = fmax(-local[a], local[a] - 1) - 2 * rounding[a];
        standing.outside = fmax(standing.outside, out);
    }
    standing.deviation = fabs(test_trilinear(corners, local, gradient));
    for (int a = 0; a < 3; ++a)
        standing.allowance += 2 * fabs(gradient[a]) * rounding[a];
    return standing;
}
