// SPDX-License-Identifier: MIT
/* Triangles in the order of a space-filling curve, and an eight-fold tree of boxes over them. */
#ifndef QNI_MESH_BOX_TREE_H
#define QNI_MESH_BOX_TREE_H

#include "mesh/check.h"

enum { QNI_BOX_WIDTH = 8, QNI_BOX_LEVELS = 24 };

/* Eight boxes, side by side; missing ones are empty (low > high). */
typedef struct qni_box_row {
    float low[3][QNI_BOX_WIDTH], high[3][QNI_BOX_WIDTH];
} qni_box_row;

/* Row r of level 0 holds the boxes of triangles 8r .. 8r + 7; row r of level l + 1 the boxes round
 * the rows 8r .. 8r + 7 of level l. The last level is one row. */
typedef struct qni_box_tree {
    int64_t triangle_count;
    uint32_t (*triangles)[3];
    int levels;
    int64_t row_count[QNI_BOX_LEVELS];
    qni_box_row *rows[QNI_BOX_LEVELS];
} qni_box_tree;

/* The triangles of the mesh's polygons that are finite and have an area, quads split. */
qn_status qni_box_tree_create(qni_check *check, qni_check_span span, qni_box_tree *tree);
void qni_box_tree_destroy(qni_check *check, qni_box_tree *tree);

/* Shares of a vertex in `wanted`: enough that all triangles at it are, and so much that those are
 * which have it at all three corners. */
enum { QNI_WANTED = 3, QNI_WANTED_WITH_ALL = 1, QNI_WANTED_MASK = 15 };
/* And beside it: no two triangles at this vertex meet but as neighbours do. */
enum { QNI_SOUND = 16 };

/* The pairs of triangles that meet where they should not (check_intersections.c). `wanted`, a byte
 * a vertex or NULL: only pairs with a triangle whose corners' shares make up QNI_WANTED. `marks`,
 * likewise: set to 1 at their corners. */
qn_status qni_count_crossings(qni_check *check, const qni_box_tree *tree, qni_check_span span,
                              const uint8_t *wanted, uint8_t *marks, int64_t *count_out);

/* The same for a mesh that is not being checked; `marks`, a byte a vertex, are cleared first. */
qn_status qni_mesh_crossings(qn_context *context, const qn_mesh_view *mesh, const char *stage,
                             const uint8_t *wanted, uint8_t *marks, int64_t *count_out,
                             qn_error *error);

#endif
