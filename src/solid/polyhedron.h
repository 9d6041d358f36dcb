// SPDX-License-Identifier: MIT
/* Polyhedra from triangles, and triangles from faces. */
#ifndef QNI_SOLID_POLYHEDRON_H
#define QNI_SOLID_POLYHEDRON_H

#include "solid/primitives.h"

/* Inside is where a ray meets an odd number of triangles. NULL when memory is short. */
qn_solid *qni_polyhedron_create(qn_context *context, int64_t point_count, const double (*points)[3],
                                int64_t count, const int64_t (*corners)[3], int32_t owner);
/* Whether every edge is used an even number of times; false when memory is short. */
bool qni_triangles_are_closed(qn_context *context, int64_t count, const int64_t (*corners)[3],
                              bool *closed_out);
/* A face of `count` points as count - 2 triangles, by cutting off ears; `left` has room for
 * `count`. */
void qni_cut_face(int64_t count, const int64_t *face, const double (*points)[3], int64_t *left,
                  int64_t (*corners)[3]);

/* Faces one after the other; every number of a point is checked by the caller. Reasons of failure:
 * a face of fewer than three points, an open edge, short memory; the sentence begins with `where`.
 */
qn_status qni_polyhedron_from_faces(qn_context *context, const char *where, int64_t point_count,
                                    const double (*points)[3], int64_t face_count,
                                    const int64_t *face_sizes, const int64_t *indices,
                                    int32_t owner, qn_solid **solid_out, qn_error *error);

#endif
