// SPDX-License-Identifier: MIT
/* Tangential relaxation: vertices slide along the surface inside their own cells towards squarer
 * quads. */
#ifndef QNI_DMC_RELAX_H
#define QNI_DMC_RELAX_H

#include "mesh/mesh.h"

/* The surface that vertices slide on (project.h has one for fields). Called from any worker. */
typedef struct qni_slide {
    const void *user;
    /* The cell of a vertex; false when it has to stay. */
    bool (*home)(const void *user, const float position[3], int32_t cell[3]);
    /* From a wished position onto the surface in the cell; false when there is no way. */
    bool (*slide)(const void *user, const int32_t cell[3], const float from[3],
                  const float normal[3], float position[3]);
    void (*normal)(const void *user, const int32_t cell[3], const float position[3],
                   float normal[3]);
} qni_slide;

typedef struct qni_relax_report {
    int64_t moved;    /* vertices that stand elsewhere in the end */
    int64_t reverted; /* moves taken back, over all sweeps, since a quad would have become worse
                         than the worst round it */
    int64_t scratch_bytes; /* memory held beside the mesh */
    double seconds;
} qni_relax_report;

/* The mesh must have quads alone, and halfedges. In each of the sweeps every vertex of a closed fan
 * looks for a place better for the quads round it; all then move at once. No vertex ends a sweep
 * with a worse worst quad than it had before, so none is turned over. Normals, where the mesh has
 * them, are found anew for those that moved. Same bytes for any number of threads. */
qn_status qni_relax(qn_context *context, qn_mesh *mesh, int32_t sweeps, const qni_slide *surface,
                    qni_relax_report *report_out, qn_error *error);

#endif
