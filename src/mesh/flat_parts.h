// SPDX-License-Identifier: MIT
/* What the files that merge flat parts share: the triangles at hand, with their neighbours, and the
 * flat regions they lie in. */
#ifndef QNI_MESH_FLAT_PARTS_H
#define QNI_MESH_FLAT_PARTS_H

#include "mesh/flat.h"

#define QNI_NO_REGION UINT32_MAX

typedef struct qni_plane {
    double normal[3], height; /* unit length, out of the solid; normal . point == height on it */
    int x, y; /* the axes of the plane in which its triangles are seen; x, y, normal right-handed */
    int32_t owner;
    bool touched, barred; /* something was dropped; nothing may be */
} qni_plane;

typedef struct qni_flat {
    qn_context *context;
    const qn_mesh *mesh;
    double near;
    int64_t vertices, triangles;
    uint32_t *corners; /* [triangles][3]; the first QN_NO_HALFEDGE where it is gone */
    uint32_t *twins;   /* [triangles][3] */
    uint32_t *starts;  /* [vertices]: a halfedge that starts there, or QN_NO_HALFEDGE */
    uint8_t *creased;  /* [triangles][3]: the side is a crease edge */
    uint32_t *regions; /* [triangles] */
    uint8_t *changed;  /* [triangles]: not as they were */
    qni_plane *planes; /* [plane_count] */
    int64_t plane_count, plane_room;
    int64_t dropped;
} qni_flat;

static inline uint32_t qni_flat_next(uint32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}

static inline uint32_t qni_flat_before(uint32_t h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

static inline const float *qni_flat_place(const qni_flat *flat, uint32_t vertex) {
    return flat->mesh->positions + 3 * (size_t)vertex;
}

/* Neighbours from corners: twins, starts. False: no memory. */
bool qni_flat_link(qni_flat *flat);
/* Crease edges of the mesh to sides. */
void qni_flat_mark_creases(qni_flat *flat);
/* Are two vertices joined by an edge? */
bool qni_flat_joined(const qni_flat *flat, uint32_t a, uint32_t b);

/* Regions and their planes (flat_regions.c). */
qn_status qni_flat_find_regions(qni_flat *flat, qn_error *error);

/* Three vertices as a triangle of a region: seen from outside they run counter-clockwise, exactly,
 * and none is too near the line through the others for its place to be told from rounding. *worst:
 * the cosine of the smallest angle. */
bool qni_flat_is_good(const qni_flat *flat, const qni_plane *plane, uint32_t a, uint32_t b,
                      uint32_t c, double *worst);
/* A polygon of a region into count - 2 triangles of its own corners, by clipping the best ear
 * first. False when there is no way without an edge that is there already. */
enum { QNI_FLAT_MOST = 40 };
bool qni_flat_split(const qni_flat *flat, const qni_plane *plane, const uint32_t *polygon,
                    int count, uint32_t (*triangles)[3]);

/* The triangles that are new and those that come near any of them, by their corners' new numbers
 * (flat_near.c): to be freed as so many times three. False: no memory. */
bool qni_flat_near_changed(const qni_flat *flat, const uint32_t *numbers, uint32_t **near_out,
                           int64_t *count_out);

/* Drop what can be dropped, in the order of the vertices (flat_drop.c). */
void qni_flat_drop(qni_flat *flat);
/* Delaunay's rule within the regions where something was dropped (flat_flip.c). */
qn_status qni_flat_flip(qni_flat *flat, qn_error *error);

#endif
