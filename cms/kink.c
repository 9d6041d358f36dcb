// SPDX-License-Identifier: MIT
/* Creases of sheets that are made of facets: such a crease has kinks, and tangents that were taken
 * on one facet say nothing about the next. */
#include "cms/cms.h"
#include "cms/vector.h"

#include <math.h>
#include <string.h>

enum { MOST_FACETS = 16 };

typedef struct facets {
    qni_tangent items[MOST_FACETS];
    int32_t count;
} facets;

/* Does a vertex know one of the facets that make the crease? Where it comes and goes those are the
 * ones beside its two features; where it ends any may be. */
static bool speaks(const qni_patch *patch, const qni_loop *loop, int32_t n) {
    const qni_loop_vertex *v = patch->vertices + loop->first;
    return v[n].has_plane && (loop->sharp_count != 2 || v[(n + 1) % loop->count].sharp ||
                              v[(n + loop->count - 1) % loop->count].sharp);
}

/* The facets that the loop's vertices know; false when they are too many. */
static bool list_known(const qni_patch *patch, const qni_loop *loop, facets *list) {
    list->count = 0;
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        if (!speaks(patch, loop, n))
            continue;
        if (list->count == MOST_FACETS)
            return false;
        qni_tangent *facet = &list->items[list->count++];
        memcpy(facet->at, vertex->at, sizeof facet->at);
        memcpy(facet->normal, vertex->normal, sizeof facet->normal);
        facet->owner = vertex->owner;
    }
    return true;
}

/* The facet that a point lies next to. */
static bool add_near(const qni_patch *patch, const double point[3], facets *list) {
    double value, gradient[3];
    int32_t owner;
    if (list->count == MOST_FACETS ||
        qni_solid_first_order(patch->solid, point, &value, gradient, &owner) != QN_OK)
        return false;
    const double square = qni_dot3(gradient, gradient);
    if (!(square > 0) || !isfinite(square))
        return false;
    qni_tangent *facet = &list->items[list->count++];
    for (int k = 0; k < 3; ++k) {
        facet->at[k] = point[k] - value * gradient[k] / square;
        facet->normal[k] = gradient[k] / sqrt(square);
    }
    facet->owner = owner;
    return true;
}

/* The facets on both sides of a feature: the solid is asked there, on the cell's wall. */
static bool add_beside(const qni_patch *patch, const qni_loop *loop, int32_t feature,
                       facets *list) {
    static const double beside = 0.01;
    const qni_loop_vertex *v = patch->vertices + loop->first;
    for (int side = 0; side < 2; ++side) {
        const int32_t other = (feature + (side ? 1 : loop->count - 1)) % loop->count;
        double point[3];
        for (int k = 0; k < 3; ++k)
            point[k] = (double)v[feature].place[k] +
                       beside * ((double)v[other].place[k] - (double)v[feature].place[k]);
        if (!add_near(patch, point, list))
            return false;
    }
    return true;
}

static bool list_beside(const qni_patch *patch, const qni_loop *loop, facets *list) {
    list->count = 0;
    for (int32_t n = 0; n < loop->count; ++n)
        if (patch->vertices[loop->first + n].sharp && !add_beside(patch, loop, n, list))
            return false;
    return true;
}

/* The facet whose normal is the farthest from what is spanned so far: the largest product with a
 * direction, or the least with a normal. */
static const qni_tangent *choose(const facets *list, const double direction[3], bool least,
                                 double *best) {
    const qni_tangent *chosen = NULL;
    for (int32_t n = 0; n < list->count; ++n) {
        const double product = qni_dot3(direction, list->items[n].normal),
                     size = least ? 1 - product : fabs(product);
        if (size > *best) {
            *best = size;
            chosen = &list->items[n];
        }
    }
    return chosen;
}

/* Where three planes meet. */
static bool meet_three(const qni_tangent *const planes[3], const double turned[3],
                       double determinant, double point[3]) {
    double part[3][3], height[3];
    memcpy(part[2], turned, sizeof part[2]);
    qni_cross3(planes[1]->normal, planes[2]->normal, part[0]);
    qni_cross3(planes[2]->normal, planes[0]->normal, part[1]);
    for (int n = 0; n < 3; ++n) { /* from the first one's point, near which all lie */
        height[n] = 0;
        for (int k = 0; k < 3; ++k)
            height[n] += planes[n]->normal[k] * (planes[n]->at[k] - planes[0]->at[k]);
    }
    for (int k = 0; k < 3; ++k)
        point[k] = planes[0]->at[k] +
                   (height[0] * part[0][k] + height[1] * part[1][k] + height[2] * part[2][k]) /
                       determinant;
    return isfinite(point[0]) && isfinite(point[1]) && isfinite(point[2]);
}

/* The point of three facets that differ the most; false when they do not span space. */
static bool meet_most(const facets *list, double point[3]) {
    static const double least_turn = 1e-4, least_volume = 1e-3;
    const qni_tangent *planes[3] = {list->items, NULL, NULL};
    double best = least_turn, turned[3];
    if (list->count < 3)
        return false;
    planes[1] = choose(list, planes[0]->normal, true, &best);
    if (!planes[1])
        return false;
    qni_cross3(planes[0]->normal, planes[1]->normal, turned);
    best = least_volume;
    planes[2] = choose(list, turned, false, &best);
    return planes[2] && meet_three(planes, turned, qni_dot3(turned, planes[2]->normal), point);
}

/* Do the facets' planes all pass through a point? */
static bool all_pass(const facets *list, const double point[3], double tolerance) {
    for (int32_t n = 0; n < list->count; ++n) {
        const qni_tangent *facet = &list->items[n];
        double height = 0;
        for (int k = 0; k < 3; ++k)
            height += facet->normal[k] * (point[k] - facet->at[k]);
        if (!(fabs(height) <= tolerance))
            return false;
    }
    return true;
}

/* Do flat facets lead from where they are known to a point, and straight creases from the sharp
 * features? */
static bool facets_meet(const qni_patch *patch, const qni_loop *loop, const facets *list,
                        const double point[3]) {
    const double cell = patch->hermite->lattice.cell;
    double from[MOST_FACETS][3];
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        double middle[3];
        for (int k = 0; k < 3; ++k)
            middle[k] = 0.5 * (point[k] + (double)vertex->place[k]);
        if (vertex->sharp && !qni_is_on_surface(patch->solid, middle, 1e-4 * cell))
            return false;
    }
    for (int32_t n = 0; n < list->count; ++n)
        memcpy(from[n], list->items[n].at, sizeof from[n]);
    return qni_flat_pieces_meet(patch->solid, point, list->count, (const double(*)[3])from,
                                1e-6 * cell);
}

/* Where the patch's solid agrees with the whole one. */
static bool is_near(const qni_patch *patch, const double point[3]) {
    const double around = 0.5 * patch->size;
    for (int k = 0; k < 3; ++k)
        if (!(point[k] > (double)patch->low[k] - around &&
              point[k] < (double)patch->high[k] + around))
            return false;
    return true;
}

qni_kink qni_patch_find_kink(const qni_patch *patch, const qni_loop *loop, bool beside,
                             double point[3]) {
    facets list;
    if (!(beside ? list_beside(patch, loop, &list) : list_known(patch, loop, &list)) ||
        !meet_most(&list, point) || !is_near(patch, point) ||
        !all_pass(&list, point, 1e-6 * patch->hermite->lattice.cell) ||
        !facets_meet(patch, loop, &list, point))
        return QNI_NO_KINK;
    return qni_patch_holds(patch, point) ? QNI_KINK_INSIDE : QNI_KINK_BEYOND;
}

/* The surface halfway between two tangents, straight across the chord. */
static bool find_between(const qn_solid *solid, const qni_tangent *a, const qni_tangent *b,
                         qni_tangent *out) {
    double chord[3], across[3], ends[2][3], best = HUGE_VAL;
    qni_crossing found[8];
    int32_t count = 0;
    for (int k = 0; k < 3; ++k) {
        chord[k] = b->at[k] - a->at[k];
        across[k] = a->normal[k] + b->normal[k];
    }
    const double length2 = qni_dot3(chord, chord), along = qni_dot3(across, chord) / length2;
    for (int k = 0; k < 3; ++k)
        across[k] -= along * chord[k];
    const double reach = 0.6 * sqrt(length2 / qni_dot3(across, across));
    if (!(length2 > 0) || !isfinite(reach))
        return false;
    for (int k = 0; k < 3; ++k)
        for (int n = 0; n < 2; ++n)
            ends[n][k] = 0.5 * (a->at[k] + b->at[k]) + (n ? reach : -reach) * across[k];
    if (solid->ops->crossings(solid, ends[0], ends[1], 8, found, &count) != QN_OK)
        return false;
    for (int32_t n = 0; n < count && n < 8; ++n) {
        if (found[n].enters || !(fabs(found[n].at - 0.5) < best))
            continue;
        best = fabs(found[n].at - 0.5);
        memcpy(out->normal, found[n].normal, sizeof out->normal);
        for (int k = 0; k < 3; ++k)
            out->at[k] = ends[0][k] + found[n].at * (ends[1][k] - ends[0][k]);
    }
    return best < HUGE_VAL;
}

/* Where two tangent planes meet, next to the middle between their points. */
static bool meet_two(const qni_tangent *a, const qni_tangent *b, double point[3]) {
    double along[3], planes[3][3], height[3], part[3][3];
    qni_cross3(a->normal, b->normal, along);
    const double determinant = qni_dot3(along, along);
    if (!(determinant > 1e-6))
        return false;
    memcpy(planes[0], a->normal, sizeof planes[0]);
    memcpy(planes[1], b->normal, sizeof planes[1]);
    memcpy(planes[2], along, sizeof planes[2]);
    for (int n = 0; n < 3; ++n)
        qni_cross3(planes[(n + 1) % 3], planes[(n + 2) % 3], part[n]);
    height[0] = height[1] = height[2] = 0;
    for (int k = 0; k < 3; ++k) { /* from a's point */
        height[1] += b->normal[k] * (b->at[k] - a->at[k]);
        height[2] += 0.5 * along[k] * (b->at[k] - a->at[k]);
    }
    for (int k = 0; k < 3; ++k)
        point[k] = a->at[k] + (height[1] * part[1][k] + height[2] * part[2][k]) / determinant;
    return true;
}

/* The way from one sheet to the other is halved, and the half kept that turns more, until what is
 * left is two flat pieces. */
static bool halve(const qni_patch *patch, qni_tangent a, qni_tangent b, double point[3]) {
    enum { HALVINGS = 24 };
    const double cell = patch->hermite->lattice.cell;
    for (int step = 0; step < HALVINGS; ++step) {
        const double from[2][3] = {{a.at[0], a.at[1], a.at[2]}, {b.at[0], b.at[1], b.at[2]}};
        qni_tangent between = {{0, 0, 0}, {0, 0, 0}, -1};
        if (qni_dot3(a.normal, b.normal) >= patch->settings->crease_cosine)
            return false;
        if (meet_two(&a, &b, point) &&
            qni_flat_pieces_meet(patch->solid, point, 2, from, 1e-8 * cell))
            return true;
        if (!find_between(patch->solid, &a, &b, &between))
            return false;
        if (qni_dot3(between.normal, a.normal) > qni_dot3(between.normal, b.normal))
            a = between;
        else
            b = between;
    }
    return false;
}

bool qni_patch_halve_to_crease(const qni_patch *patch, const double at[2][3],
                               const double normal[2][3], double point[3]) {
    qni_tangent ends[2];
    for (int n = 0; n < 2; ++n) {
        memcpy(ends[n].at, at[n], sizeof ends[n].at);
        memcpy(ends[n].normal, normal[n], sizeof ends[n].normal);
        ends[n].owner = -1; /* all are the solid's here */
    }
    return halve(patch, ends[0], ends[1], point) && qni_patch_holds(patch, point);
}
