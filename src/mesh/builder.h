// SPDX-License-Identifier: MIT
/* Building a mesh whose size shows only while it is read: growing arrays, polygons split at the
 * end. */
#ifndef QNI_MESH_BUILDER_H
#define QNI_MESH_BUILDER_H

#include <qn/mesh.h>

typedef struct qni_array {
    void *items;
    int64_t count, capacity;
} qni_array;

typedef struct qni_builder {
    qn_context *context;
    qni_array positions; /* float[3] */
    qni_array normals;   /* float[3]; as many as positions, or none */
    qni_array quads;     /* uint32_t[4] */
    qni_array triangles; /* uint32_t[3] */
    qni_array polygons;  /* uint32_t: a count, then as many corners, for faces of five and more */
    qni_array triangle_owners, quad_owners, polygon_owners; /* int32_t; fewer than the faces: the
                                                               rest has owner 0 */
    int64_t polygon_count;
    int32_t owner;         /* of the faces that are added next */
    int64_t skipped_faces; /* of fewer than three corners */
    uint32_t largest_index;
    int64_t largest_where; /* the line or face that names it */
    char space[32], unit[16];
} qni_builder;

void qni_builder_start(qni_builder *builder, qn_context *context);
void qni_builder_free(qni_builder *builder);
/* All return false when memory ran out. */
bool qni_builder_reserve(qni_builder *builder, int64_t vertices, bool with_normals);
bool qni_builder_add_vertex(qni_builder *builder, const float position[3], const float *normal);
/* `where` is the line or face number that a message shall name when a corner is out of range. */
bool qni_builder_add_face(qni_builder *builder, const uint32_t *corners, int64_t count,
                          int64_t where);
/* Check the indices, split the polygons and hand the arrays over to a mesh. `place` is "line" or
 * "face". The builder is empty afterwards, whatever happened. */
qn_status qni_builder_finish(qni_builder *builder, const char *path, const char *place,
                             qn_mesh **mesh_out, qn_error *error);

#endif
