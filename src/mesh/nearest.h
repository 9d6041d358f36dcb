// SPDX-License-Identifier: MIT
/* The nearest triangle of a mesh to a point: exact distances in double, over the tree of boxes. */
#ifndef QNI_MESH_NEAREST_H
#define QNI_MESH_NEAREST_H

#include "mesh/box_tree.h"

/* No triangle: what a search answers when none is near enough. */
#define QNI_NO_TRIANGLE UINT32_C(0xffffffff)

/* The triangles of a mesh, those without area or with coordinates that are not finite left out,
 * numbered along a space-filling curve. Borrows the mesh's positions. Any number of threads may
 * search it at once. */
typedef struct qni_nearest {
    qn_context *context;
    const float *positions;
    qni_box_tree tree;
    float slack; /* what rounding a point to float, and a difference, can cost */
    double low[3], high[3];
} qni_nearest;

typedef struct qni_near {
    double squared; /* distance to the triangle, squared; the limit when there is none */
    double point[3];
    uint32_t triangle; /* index into tree.triangles */
} qni_near;

/* `stage` is what progress calls the work. QN_ERROR_INVALID_ARGUMENT for coordinates beyond 1e18.
 */
qn_status qni_nearest_create(qn_context *context, const qn_mesh *mesh, const char *stage,
                             qni_nearest *nearest_out, qn_error *error);
void qni_nearest_destroy(qni_nearest *nearest);

/* The triangle nearest to p, the lowest number among equals, if one is nearer than sqrt(limit).
 * `hint` is one that is likely near, or QNI_NO_TRIANGLE; it changes the time only. */
qni_near qni_nearest_find(const qni_nearest *nearest, const double p[3], double limit,
                          uint32_t hint);
/* Rows of the tree near a place: what many searches close to each other share. */
enum { QNI_NEAR_ROWS = 64 };
typedef struct qni_near_set {
    int level; /* of the rows in the tree */
    int count;
    int64_t rows[QNI_NEAR_ROWS];
    qni_box_row boxes[QNI_NEAR_ROWS / QNI_BOX_WIDTH]; /* round each of them */
} qni_near_set;

/* The rows, of as fine a level as there is room for, that come as near to `centre` as sqrt(limit).
 */
void qni_nearest_gather(const qni_nearest *nearest, const double centre[3], double limit,
                        qni_near_set *set);
/* qni_nearest_find() among the triangles of the set. */
qni_near qni_nearest_find_among(const qni_nearest *nearest, const qni_near_set *set,
                                const double p[3], double limit, uint32_t hint);

/* The point of triangle a, b, c nearest to p, and its squared distance. */
double qni_triangle_distance(const double p[3], const float a[3], const float b[3],
                             const float c[3], double point[3]);
/* Unit normal of a triangle of the tree. */
void qni_nearest_normal(const qni_nearest *nearest, uint32_t triangle, double normal[3]);

static inline const float *qni_nearest_corner(const qni_nearest *nearest, uint32_t triangle,
                                              int corner) {
    return nearest->positions + 3 * (size_t)nearest->tree.triangles[triangle][corner];
}

#endif
