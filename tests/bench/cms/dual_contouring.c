// SPDX-License-Identifier: MIT
#include "bench/cms/dual_contouring.h"
#include "core/cube_hd.h"

#include <math.h>

/* Eigenvectors of a symmetric 3 x 3 matrix by Jacobi's rotations: columns of `v`. */
static void eigenvectors(double a[3][3], double v[3][3]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            v[i][j] = i == j;
    for (int sweep = 0; sweep < 30; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (fabs(a[p][q]) < 1e-300)
                    continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)),
                             c = 1 / sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < 3; ++k) { /* A J */
                    const double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y;
                    a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) { /* J^T A J, and V J */
                    const double x = a[p][k], y = a[q][k], u = v[k][p], w = v[k][q];
                    a[p][k] = c * x - s * y;
                    a[q][k] = s * x + c * y;
                    v[k][p] = c * u - s * w;
                    v[k][q] = s * u + c * w;
                }
            }
}

/* About the mean of the crossings, the step of least norm. */
static void solve(int count, const qni_hermite_crossing *const *crossings, double vertex[3]) {
    double mean[3] = {0, 0, 0}, a[3][3] = {{0}}, b[3] = {0, 0, 0}, v[3][3], at[3];
    for (int n = 0; n < count; ++n) {
        qni_crossing_position(crossings[n], at);
        for (int k = 0; k < 3; ++k)
            mean[k] += at[k] / count;
    }
    for (int n = 0; n < count; ++n) {
        const double *normal = crossings[n]->normal;
        double height = 0;
        qni_crossing_position(crossings[n], at);
        for (int k = 0; k < 3; ++k)
            height += normal[k] * (at[k] - mean[k]);
        for (int i = 0; i < 3; ++i) {
            b[i] += normal[i] * height;
            for (int j = 0; j < 3; ++j)
                a[i][j] += normal[i] * normal[j];
        }
    }
    eigenvectors(a, v);
    const double largest = fmax(a[0][0], fmax(a[1][1], a[2][2]));
    for (int k = 0; k < 3; ++k)
        vertex[k] = mean[k];
    for (int n = 0; n < 3; ++n) {
        if (!(a[n][n] > 0.1 * largest))
            continue;
        double along = 0;
        for (int k = 0; k < 3; ++k)
            along += v[k][n] * b[k];
        for (int k = 0; k < 3; ++k)
            vertex[k] += along / a[n][n] * v[k][n];
    }
}

bool dual_contouring_vertex(const qni_hermite *hermite, const int32_t cell[3], double vertex[3]) {
    const qni_hermite_crossing *crossings[QNI_EDGES];
    int count = 0;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int corner = qni_edge_start_corner(edge), axis = qni_edge_axis(edge);
        int32_t point[3], other[3];
        for (int k = 0; k < 3; ++k) {
            point[k] = cell[k] + (corner >> k & 1);
            other[k] = point[k] + (k == axis);
        }
        const int from = qni_hermite_sign(hermite, point), to = qni_hermite_sign(hermite, other);
        if (from < 0 || to < 0 || from == to)
            continue;
        const qni_edge_crossings all = qni_hermite_edge(hermite, point, axis);
        int n = 0;
        while (n < all.count && all.items[n].enters != (to == 1))
            ++n;
        if (n < all.count)
            crossings[count++] = &all.items[n];
    }
    if (count == 0)
        return false;
    solve(count, crossings, vertex);
    return true;
}
