// SPDX-License-Identifier: MIT
/* Which diagonal cuts each quad of a mesh into triangles: one choice for all who need triangles, so
 * that a file, a check and a triangulated mesh are the same surface. */
#ifndef QNI_MESH_DIAGONALS_H
#define QNI_MESH_DIAGONALS_H

#include <qn/mesh.h>

typedef struct qni_diagonals {
    qn_context *context;
    int64_t quad_count;
    uint64_t *along_02; /* a bit a quad: set for corners 0-2, else 1-3 */
    int64_t turned;     /* quads that take the other diagonal, theirs being an edge elsewhere */
    int64_t shared;     /* quads left on such a diagonal: both of theirs are edges elsewhere */
} qni_diagonals;

/* Choose the diagonals: of each quad the one of the MaxMin angle criterion, unless two other faces
 * meet along it already (two quads that share opposite corners, or a quad whose opposite corners
 * another face joins). Cut along it, four triangles would meet at an edge where the quads are a
 * manifold; so in the order of the quads those turn to their other diagonal whose other diagonal is
 * free. The same for every thread count. */
qn_status qni_diagonals_choose(qn_context *context, const qn_mesh_view *mesh,
                               qni_diagonals *diagonals, qn_error *error);
void qni_diagonals_free(qni_diagonals *diagonals);

static inline bool qni_along_02(const qni_diagonals *diagonals, int64_t quad) {
    return diagonals->along_02[quad / 64] >> (quad % 64) & 1;
}

/* The two triangles of a quad. */
static inline void qni_cut_quad(const uint32_t q[4], bool along_02, uint32_t triangles[6]) {
    triangles[0] = q[0];
    triangles[1] = q[1];
    triangles[2] = along_02 ? q[2] : q[3];
    triangles[3] = along_02 ? q[0] : q[1];
    triangles[4] = q[2];
    triangles[5] = q[3];
}

#endif
