// SPDX-License-Identifier: MIT
/* The panels near a local solid: a list whose boxes are compared eight at a time. */
#ifndef QNI_SOLID_MODEL_NEAR_H
#define QNI_SOLID_MODEL_NEAR_H

#include "solid/panel.h"

enum { QNI_EIGHT = 8, QNI_MOST_NEAR = 1024 }; /* longer lists are not kept */

/* Boxes of eight panels, or of eight such eights; what is not used meets nothing. */
typedef struct qni_near_eight {
    float low[3][QNI_EIGHT], high[3][QNI_EIGHT];
} qni_near_eight;

/* The slabs that hold the planes of eight panels: from the middle of the box that the list was made
 * for, points of the panel lie `height` along the normal, give or take `slack`; and no rounding of
 * a point of the box, or of what is made of it, takes that to the other side. */
typedef struct qni_near_slabs {
    float normal[3][QNI_EIGHT], height[QNI_EIGHT], slack[QNI_EIGHT];
} qni_near_slabs;

/* Panels of the surface first, then those of caps; neighbours in the tree are neighbours here. */
typedef struct qni_near_list {
    qni_near_eight *eights; /* of panels, then those of eights */
    qni_near_slabs *slabs;
    double middle[3], reach; /* that slabs are measured from, and of the box round it */
    int32_t *numbers; /* in the tree of the surface; of those in the tree of caps the complement */
    int32_t count, surface_count;
} qni_near_list;

/* All panels that meet a box, from the trees (`few`: no more than can be kept, else none are) or
 * from the list of a larger box. False: no memory. */
bool qni_near_from_trees(qn_context *context, const qni_panel_tree *surface,
                         const qni_panel_tree *caps, const qni_box *box, qni_near_list *near,
                         bool *few);
bool qni_near_from_larger(qn_context *context, const qni_panel_tree *surface,
                          const qni_panel_tree *caps, const qni_near_list *larger,
                          const qni_box *box, qni_near_list *near);
void qni_near_free(qn_context *context, qni_near_list *near);

/* The places in the list, ascending, of panels whose boxes meet a box; one that misses by rounding
 * to float may be among them. `chosen` has room for all of the list. */
int32_t qni_near_meeting(const qni_near_list *near, const qni_box *box, int32_t *chosen);

/* The same for a segment within the box, and only where its ends are not on the same side of the
 * panel's plane. */
int32_t qni_near_crossing(const qni_near_list *near, const double a[3], const double b[3],
                          int32_t *chosen);

/* The panel of the surface that is nearest of a list, which has one at least, and of the guess, if
 * that is not -1; ties as in qni_panel_tree_nearest(). `size`: the largest coordinate. */
int32_t qni_near_nearest(const qni_near_list *near, const qni_panel_tree *surface, double size,
                         const double p[3], int32_t guess, double *square, double nearest[3]);

/* The squared distance of the nearest panel of the surface; of none that is as near as `most`,
 * anything above its square. */
double qni_near_square(const qni_near_list *near, const qni_panel_tree *surface, double size,
                       const double p[3], double most);

#endif
