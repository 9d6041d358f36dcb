// SPDX-License-Identifier: MIT
/* Quads into triangles by the MaxMin angle criterion ([DMC21] section 5.3). */
#include "mesh/mesh.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "mesh/diagonals.h"

#include <math.h>
#include <string.h>

typedef struct point {
    double x, y, z;
} point;

static point corner_of(const float *positions, uint32_t vertex) {
    const float *p = positions + 3 * (size_t)vertex;
    point q = {(double)p[0], (double)p[1], (double)p[2]};
    return q;
}

/* Cosine of the angle at a, 1 for an edge without length: the worst there is. */
static double cosine_at(point a, point b, point c) {
    point u = {b.x - a.x, b.y - a.y, b.z - a.z};
    point v = {c.x - a.x, c.y - a.y, c.z - a.z};
    double squares = (u.x * u.x + u.y * u.y + u.z * u.z) * (v.x * v.x + v.y * v.y + v.z * v.z);
    return squares > 0 ? (u.x * v.x + u.y * v.y + u.z * v.z) / sqrt(squares) : 1;
}

/* The largest cosine belongs to the smallest angle. */
static double largest_cosine(point a, point b, point c) {
    return fmax(cosine_at(a, b, c), fmax(cosine_at(b, c, a), cosine_at(c, a, b)));
}

bool qni_quad_splits_02(const float *positions, const uint32_t quad[4]) {
    point p[4];
    for (int i = 0; i < 4; ++i)
        p[i] = corner_of(positions, quad[i]);
    double along_02 = fmax(largest_cosine(p[0], p[1], p[2]), largest_cosine(p[0], p[2], p[3]));
    double along_13 = fmax(largest_cosine(p[0], p[1], p[3]), largest_cosine(p[1], p[2], p[3]));
    return along_02 <= along_13;
}

void qni_split_quad(const float *positions, const uint32_t q[4], uint32_t out[6]) {
    qni_cut_quad(q, qni_quad_splits_02(positions, q), out);
}

/* Owners of the quads' halves and of the triangles behind them; without any when none are known. */
static bool split_owners(qn_context *context, qn_mesh *mesh, int64_t count) {
    int32_t *owners = NULL;
    if (mesh->quad_owners || mesh->triangle_owners) {
        owners = qni_alloc_zero(context, count, sizeof *owners);
        if (!owners)
            return false;
        for (int64_t n = 0; mesh->quad_owners && n < 2 * mesh->quad_count; ++n)
            owners[n] = mesh->quad_owners[n / 2];
        if (mesh->triangle_owners)
            memcpy(owners + 2 * mesh->quad_count, mesh->triangle_owners,
                   (size_t)mesh->triangle_count * sizeof *owners);
    }
    qni_free(mesh->context, mesh->triangle_owners, mesh->triangle_count, sizeof *owners);
    qni_free(mesh->context, mesh->quad_owners, mesh->quad_owner_count, sizeof *owners);
    mesh->triangle_owners = owners;
    mesh->quad_owners = NULL;
    mesh->quad_owner_count = 0;
    return true;
}

qn_status qn_mesh_triangulate(qn_context *context, qn_mesh *mesh, qn_error *error) {
    if (mesh->quad_count == 0)
        return QN_OK;
    int64_t quad_count = mesh->quad_count;
    int64_t count = mesh->triangle_count + 2 * quad_count;
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    qni_diagonals diagonals;
    QN_TRY(qni_diagonals_choose(context, &view, &diagonals, error));
    uint32_t *triangles = qni_alloc(context, count, 3 * sizeof(uint32_t));
    if (!triangles || !split_owners(context, mesh, count)) {
        qni_free(context, triangles, count, 3 * sizeof(uint32_t));
        qni_diagonals_free(&diagonals);
        return qni_fail(error, QN_ERROR_OUT_OF_MEMORY, "not enough memory for %lld triangles",
                        (long long)count);
    }
    const uint32_t *quads = mesh->quads;
#pragma omp parallel for schedule(static) num_threads(qn_context_threads(context))
    for (int64_t i = 0; i < quad_count; ++i)
        qni_cut_quad(quads + 4 * i, qni_along_02(&diagonals, i), triangles + 6 * i);
    qni_diagonals_free(&diagonals);
    if (mesh->triangle_count)
        memcpy(triangles + 6 * quad_count, mesh->triangles,
               (size_t)mesh->triangle_count * 3 * sizeof(uint32_t));
    qni_mesh_free_halfedges(mesh);
    qni_free(mesh->context, mesh->triangles, mesh->triangle_count, 3 * sizeof(uint32_t));
    qni_free(mesh->context, mesh->quads, mesh->quad_count + mesh->quad_slack, 4 * sizeof(uint32_t));
    mesh->quads = NULL;
    mesh->quad_count = mesh->quad_slack = 0;
    mesh->triangles = triangles;
    mesh->triangle_count = count;
    return QN_OK;
}
