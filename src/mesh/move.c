// SPDX-License-Identifier: MIT
/* A mesh moved in place by an affine map. */
#include "mesh/mesh.h"

static void move_points(float *points, int64_t count, const double matrix[3][4]) {
    for (int64_t n = 0; n < count; ++n) {
        double p[3];
        for (int k = 0; k < 3; ++k)
            p[k] = (double)points[3 * n + k];
        for (int row = 0; row < 3; ++row)
            points[3 * n + row] = (float)(matrix[row][0] * p[0] + matrix[row][1] * p[1] +
                                          matrix[row][2] * p[2] + matrix[row][3]);
    }
}

void qni_mesh_move(qn_mesh *mesh, const double matrix[3][4], bool mirrors) {
    move_points(mesh->positions, mesh->vertex_count, matrix);
    for (int64_t t = 0; mirrors && t < mesh->triangle_count; ++t) {
        const uint32_t last = mesh->triangles[3 * t + 2];
        mesh->triangles[3 * t + 2] = mesh->triangles[3 * t + 1];
        mesh->triangles[3 * t + 1] = last;
    }
}
