// SPDX-License-Identifier: MIT
/* Polygons into triangles. */
#ifndef QNI_MESH_POLYGON_H
#define QNI_MESH_POLYGON_H

#include <stdbool.h>
#include <stdint.h>

enum { QNI_LARGEST_CLIPPED = 2048 }; /* corners; beyond that a polygon becomes a fan */

/* Room that splitting a polygon of `count` corners needs, and how much of it in bytes. */
static inline int64_t qni_polygon_scratch_bytes(int64_t count) {
    return count * (int64_t)(2 * sizeof(double) + 3 * sizeof(int32_t));
}

/* Split a polygon, which may be concave, into count - 2 triangles wound as it is, by clipping ears
 * in the plane of its Newell normal. What has no plane, crosses itself or has more than
 * QNI_LARGEST_CLIPPED corners still gives count - 2 triangles, though they may overlap.
 *
 * positions  all vertices, [..][3]; corners [count] names those of the polygon, count at least 3
 * scratch    qni_polygon_scratch_bytes(count), aligned as a double is
 * triangles  receives [count - 2][3] vertex indices */
void qni_polygon_split(const float *positions, const uint32_t *corners, int64_t count,
                       void *scratch, uint32_t *triangles);

#endif
