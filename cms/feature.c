// SPDX-License-Identifier: MIT
/* The apex of a loop [CMS05 3.4]: the number of clusters of normals says smooth, crease or corner,
 * and with that the rank.
 *
 * An apex is always strictly inside its cell: a fan from there over a simple loop on a convex
 * cell's walls is an embedded disc that touches the walls along the loop only. A crease's apex is
 * set on the segment between the loop's two face features, which is inside by convexity; the
 * least-norm point is not (15 % of clean cells). */
#include "cms/cms.h"
#include "cms/vector.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { MOST_CLUSTERS = 4, NEWTON_STEPS = 3 };
/* In cells: floats cannot tell what is nearer. */
static const double near_enough = 1e-9;

/* Farthest-point clustering: each next seed is the normal least like the seeds so far, while it
 * differs by more than the crease angle. At most 4: three make a corner, more tell no more. */
static int32_t count_clusters(const qni_patch *patch, const qni_loop *loop) {
    const double *seeds[MOST_CLUSTERS];
    int32_t clusters = 0;
    const qni_loop_vertex *vertices = patch->vertices + loop->first;
    while (clusters < MOST_CLUSTERS) {
        const double *farthest = NULL;
        double least = clusters ? patch->settings->crease_cosine : 2;
        for (int32_t n = 0; n < loop->count; ++n) {
            if (!vertices[n].has_plane)
                continue;
            const double *normal = vertices[n].normal;
            double most = -2;
            for (int32_t c = 0; c < clusters; ++c)
                most = fmax(most, qni_dot3(normal, seeds[c]));
            if (most < least) {
                least = most;
                farthest = normal;
                if (!clusters)
                    break;
            }
        }
        if (!farthest)
            break;
        seeds[clusters++] = farthest;
    }
    return clusters;
}

static void mean_of(const qni_patch *patch, const qni_loop *loop, bool features_only,
                    double mean[3]) {
    int32_t count = 0;
    mean[0] = mean[1] = mean[2] = 0;
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        if (features_only && !vertex->sharp)
            continue;
        for (int k = 0; k < 3; ++k)
            mean[k] += (double)vertex->place[k];
        ++count;
    }
    for (int k = 0; k < 3; ++k)
        mean[k] /= count ? count : 1;
}

/* The least-norm point of the loop's tangent planes about a centre. */
static bool solve_about(qni_patch *patch, const qni_loop *loop, int32_t rank,
                        const double centre[3], double point[3]) {
    if (!qni_patch_grow(patch, (void **)&patch->scratch, &patch->scratch_capacity,
                        4 * (int64_t)loop->count + 16, sizeof *patch->scratch))
        return false;
    double *rows = patch->scratch, *heights = patch->scratch + 3 * (int64_t)loop->count;
    int32_t count = 0;
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        if (!vertex->has_plane)
            continue;
        memcpy(rows + 3 * count, vertex->normal, sizeof vertex->normal);
        heights[count] = 0;
        for (int k = 0; k < 3; ++k)
            heights[count] += vertex->normal[k] * (vertex->at[k] - centre[k]);
        ++count;
    }
    double step[3];
    if (!qni_solve_planes(rows, heights, count, rank, step))
        return false;
    for (int k = 0; k < 3; ++k)
        point[k] = centre[k] + step[k];
    return true;
}

static void set_apex(const qni_patch *patch, qni_loop *loop, const double point[3]) {
    for (int k = 0; k < 3; ++k)
        loop->apex[k] = qni_between(point[k], patch->clear_low[k], patch->clear_high[k]);
    loop->has_apex = true;
}

/* Is the point on the surface? Where distances are known that costs less than a value. */
static bool is_there(const qni_patch *patch, const double point[3]) {
    const double most = near_enough * patch->size;
    double distance;
    return patch->solid->ops->distance &&
           patch->solid->ops->distance(patch->solid, point, most, &distance) && distance <= most;
}

/* One step from a point; false when the gradient does not say where to. */
static bool step_onto_surface(double value, const double gradient[3], double at[3]) {
    const double square = qni_dot3(gradient, gradient);
    if (!(square > 0) || !isfinite(square))
        return false;
    for (int k = 0; k < 3; ++k)
        at[k] -= value * gradient[k] / square;
    return true;
}

static bool stays_near(const qni_patch *patch, const double point[3], const double at[3]) {
    double length = 0;
    for (int k = 0; k < 3; ++k)
        length = fmax(length, fabs(at[k] - point[k]));
    return length < 0.5 * patch->size && qni_patch_holds(patch, at);
}

/* A few Newton steps onto the surface; what leaves the cell's middle, or does not help, is not
 * taken. */
static qn_status move_onto_surface(const qni_patch *patch, double point[3]) {
    const qn_solid *solid = patch->solid;
    double at[3] = {point[0], point[1], point[2]}, first, value, gradient[3];
    int32_t owner;
    QN_TRY(qni_solid_first_order(solid, at, &value, gradient, &owner));
    first = fabs(value);
    for (int step = 0; step < NEWTON_STEPS && fabs(value) > near_enough * patch->size; ++step) {
        if (step > 0)
            QN_TRY(solid->ops->gradients(solid, 1, (const double(*)[3])at, (double(*)[3])gradient,
                                         NULL));
        if (!step_onto_surface(value, gradient, at) || !stays_near(patch, point, at))
            return QN_OK;
        value = 0;
        if (!is_there(patch, at))
            QN_TRY(solid->ops->values(solid, 1, (const double(*)[3])at, &value));
    }
    if (fabs(value) < first)
        memcpy(point, at, sizeof at);
    return QN_OK;
}

/* How far the loop's tangent planes pass from a point, at most. */
static double largest_height(const qni_patch *patch, const qni_loop *loop, const double point[3]) {
    double most = 0;
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        if (!vertex->has_plane)
            continue;
        double height = 0;
        for (int k = 0; k < 3; ++k)
            height += vertex->normal[k] * (point[k] - vertex->at[k]);
        most = fmax(most, fabs(height));
    }
    return most;
}

static void place_smooth(const qni_patch *patch, qni_loop *loop) {
    double mean[3];
    mean_of(patch, loop, false, mean);
    set_apex(patch, loop, mean);
    loop->unsettled = patch->settings->features;
}

qn_status qni_patch_settle_apex(const qni_patch *patch, qni_loop *loop) {
    double mean[3];
    if (!loop->unsettled)
        return QN_OK;
    loop->unsettled = false;
    mean_of(patch, loop, false, mean);
    if (largest_height(patch, loop, mean) > patch->settings->tolerance)
        QN_TRY(move_onto_surface(patch, mean));
    set_apex(patch, loop, mean);
    return QN_OK;
}

/* Where the way from a point in the cell to a corner beyond it leaves the cell. */
static void leave_cell(const qni_patch *patch, const double from[3], const double corner[3],
                       double point[3]) {
    double share = 1;
    for (int k = 0; k < 3; ++k) {
        const double wall = (double)(corner[k] < from[k] ? patch->low[k] : patch->high[k]),
                     way = corner[k] - from[k];
        if (way != 0)
            share = fmin(share, fmax((wall - from[k]) / way, 0));
    }
    for (int k = 0; k < 3; ++k)
        point[k] = from[k] + share * (corner[k] - from[k]);
}

/* Next to the corner, as far as the cell goes, if it is known. */
static void set_escaped(const qni_patch *patch, qni_loop *loop, const double mean[3],
                        const double *corner) {
    double apex[3] = {mean[0], mean[1], mean[2]};
    loop->escaped = true;
    loop->knows_corner = corner != NULL;
    loop->of_facets = corner && largest_height(patch, loop, corner) < 1e-5 * patch->size;
    for (int k = 0; k < 3 && corner; ++k)
        loop->corner[k] = (float)corner[k];
    if (corner)
        leave_cell(patch, mean, corner, apex);
    set_apex(patch, loop, apex);
}

static double distance(const double a[3], const double b[3]) {
    const double off[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return sqrt(qni_dot3(off, off));
}

static double distance_to_line(const double p[3], const float a[3], const double b[3]) {
    double way[3], off[3];
    for (int k = 0; k < 3; ++k) {
        way[k] = b[k] - (double)a[k];
        off[k] = p[k] - (double)a[k];
    }
    const double length2 = qni_dot3(way, way),
                 along = length2 > 0 ? fmin(fmax(qni_dot3(way, off) / length2, 0), 1) : 0;
    for (int k = 0; k < 3; ++k)
        off[k] -= along * way[k];
    return sqrt(qni_dot3(off, off));
}

/* How far the crease from one feature to the other by way of a point passes from its corner. */
static double distance_to_crease(const qni_patch *patch, const qni_loop *loop,
                                 const double point[3], const double corner[3]) {
    double least = HUGE_VAL;
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        if (vertex->sharp)
            least = fmin(least, distance_to_line(corner, vertex->place, point));
    }
    return least;
}

/* Flaws that stay, whatever comes of the loops of more than two features. */
static int64_t sure_flaws(const qni_patch *patch) {
    int64_t flaws = patch->dropped;
    for (int64_t n = 0; n < patch->loop_count; ++n)
        flaws += patch->loops[n].escaped && patch->loops[n].sharp_count <= 2;
    return flaws;
}

/* Does it not matter where an apex is that has escaped? A coarse cell is a leaf only if its loops
 * that escape are flat, which does not depend on it; and a trial of a union can be lost by now. */
static bool may_forget(const qni_patch *patch) {
    return !patch->octree || sure_flaws(patch) >= patch->most_bad;
}

/* Two features: from the middle between them to the crease itself; or to the corner of facets where
 * it bends. Facets that no crossing knows are asked for where it seems to bend. A corner beyond a
 * wall counts when the crease would miss it. */
static void place_on_crease(qni_patch *patch, qni_loop *loop) {
    const double tolerance = patch->settings->tolerance;
    double middle[3], point[3], bend[3], hidden[3];
    const qni_kink kink = qni_patch_find_kink(patch, loop, false, bend);
    if (kink == QNI_KINK_INSIDE) {
        set_apex(patch, loop, bend);
        return;
    }
    mean_of(patch, loop, true, middle);
    const bool found = qni_patch_meet_sheets(patch, loop, middle, point),
               inside = found && qni_patch_holds(patch, point);
    if (inside && kink == QNI_NO_KINK && distance(point, middle) > 0.2 * tolerance &&
        qni_patch_find_kink(patch, loop, true, hidden) == QNI_KINK_INSIDE)
        set_apex(patch, loop, hidden);
    else if (inside &&
             (kink == QNI_NO_KINK || distance_to_crease(patch, loop, point, bend) <= 2 * tolerance))
        set_apex(patch, loop, point);
    else if (kink == QNI_KINK_BEYOND)
        set_escaped(patch, loop, middle, bend);
    else if (!found && !may_forget(patch) && qni_patch_cross_sheets(patch, loop, middle, point))
        set_escaped(patch, loop, point, NULL); /* a corner may lie unseen beyond a wall */
    else
        set_escaped(patch, loop, middle, found ? point : NULL);
}

/* The wall beyond which a point lies, in the pyramid that has the wall as its base and the centre
 * of the cell across as its tip; -1 when there is none such. */
static int wall_before(const qni_patch *patch, const float place[3]) {
    int wall = -1;
    for (int k = 0; k < 3; ++k) {
        const bool below = place[k] <= patch->low[k], above = place[k] >= patch->high[k];
        if ((below || above) && wall >= 0)
            return -1;
        wall = below ? 2 * k : above ? 2 * k + 1 : wall;
    }
    if (wall < 0)
        return -1;
    const int axis = wall >> 1;
    const double depth = wall & 1 ? (double)place[axis] - (double)patch->high[axis]
                                  : (double)patch->low[axis] - (double)place[axis];
    for (int k = 0; k < 3; ++k)
        if (k != axis && !(depth > 0 && depth < (double)place[k] - (double)patch->low[k] &&
                           depth < (double)patch->high[k] - (double)place[k]))
            return -1;
    return wall;
}

/* A corner beyond a wall that the lattice does not see: no edge of the cell across is crossed.
 * Where nothing of the surface lies on the wall, the loop runs over the walls of the two cells
 * together, and a fan from any point inside them is an embedded disc. Within the pyramid over the
 * wall it cannot meet one that comes into the empty cell over another of its walls. */
static bool reach_beyond(const qni_patch *patch, qni_loop *loop, const double point[3]) {
    const float place[3] = {(float)point[0], (float)point[1], (float)point[2]};
    const int wall = wall_before(patch, place);
    if (wall < 0 || !patch->octree || patch->cell.level != 0 || patch->united ||
        patch->loop_count != 1)
        return false;
    for (int32_t n = 0; n < loop->count; ++n)
        if (patch->vertices[loop->first + n].walls & 1 << wall)
            return false;
    const qni_cell across = qni_cell_across(&patch->cell, wall);
    if (!qni_octree_is_empty(patch->octree, across.low) ||
        (patch->unions && qni_find_union(patch->unions, across.low) >= 0))
        return false;
    memcpy(loop->apex, place, sizeof place);
    loop->has_apex = true;
    loop->beyond = true;
    return true;
}

/* A crease that ends: where the facets meet from which on none of them turns enough. */
static void place_end(qni_patch *patch, qni_loop *loop) {
    double mean[3], point[3];
    mean_of(patch, loop, true, mean);
    const qni_kink kink = qni_patch_find_kink(patch, loop, false, point);
    if (kink == QNI_KINK_INSIDE)
        set_apex(patch, loop, point);
    else
        set_escaped(patch, loop, mean, kink == QNI_KINK_BEYOND ? point : NULL);
}

/* Three features and more: where all sheets meet. */
static void place_corner(qni_patch *patch, qni_loop *loop) {
    double mean[3], point[3];
    mean_of(patch, loop, true, mean);
    if (qni_patch_meet_sheets(patch, loop, mean, point)) {
        if (qni_patch_holds(patch, point)) {
            set_apex(patch, loop, point);
            return;
        }
        if (!reach_beyond(patch, loop, point))
            set_escaped(patch, loop, mean, point);
        return;
    }
    set_escaped(patch, loop, mean, NULL);
}

/* No features: smooth, or the tip of a cone, where all tangent planes meet. */
static void place_featureless(qni_patch *patch, qni_loop *loop) {
    double mean[3], point[3];
    if (patch->settings->features && count_clusters(patch, loop) >= 3) {
        mean_of(patch, loop, false, mean);
        if (solve_about(patch, loop, 3, mean, point) && qni_patch_holds(patch, point) &&
            largest_height(patch, loop, point) < 1e-3 * patch->size &&
            qni_is_on_surface(patch->solid, point, 1e-3 * patch->size)) {
            loop->clusters = 3;
            set_apex(patch, loop, point);
            return;
        }
    }
    place_smooth(patch, loop);
}

void qni_patch_place_apex(qni_patch *patch, qni_loop *loop) {
    loop->escaped = loop->beyond = loop->knows_corner = loop->of_facets = loop->unsettled = false;
    loop->clusters = loop->sharp_count == 0 ? 1 : loop->sharp_count > 2 ? 3 : 2;
    if (loop->sharp_count == 0)
        place_featureless(patch, loop);
    else if (loop->sharp_count == 2)
        place_on_crease(patch, loop);
    else if (loop->sharp_count == 1)
        place_end(patch, loop);
    else
        place_corner(patch, loop);
}

qn_status qni_patch_place_apexes(qni_patch *patch, qni_cms_tally *tally) {
    for (int64_t n = 0; n < patch->loop_count && sure_flaws(patch) <= patch->most_bad; ++n) {
        qni_loop *loop = &patch->loops[n];
        qni_patch_place_apex(patch, loop);
        ++tally->loops;
        tally->smooth_loops += loop->clusters == 1;
        tally->crease_loops += loop->clusters == 2;
        tally->corner_loops += loop->clusters > 2;
        tally->reaching_corners += loop->beyond;
    }
    return patch->failed ? QN_ERROR_OUT_OF_MEMORY : QN_OK;
}
