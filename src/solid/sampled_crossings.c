// SPDX-License-Identifier: MIT
/* Crossings of segments with a sampled solid: on lattice edges exactly, elsewhere by its values. */
#include "solid/node.h"
#include "solid/sampled_parts.h"

#include <string.h>

/* Slopes at a sample, by central differences; by one-sided ones at the frame's border. */
static void sample_slopes(const sampled_solid *s, const int32_t point[3], double gradient[3]) {
    const qni_sample_frame *frame = &s->whole->frame;
    for (int k = 0; k < 3; ++k) {
        int32_t before[3] = {point[0], point[1], point[2]}, after[3];
        memcpy(after, before, sizeof after);
        before[k] = qni_clamped(point[k] - 1, 0, frame->count[k] - 1);
        after[k] = qni_clamped(point[k] + 1, 0, frame->count[k] - 1);
        gradient[k] =
            (qni_sample(s, after) - qni_sample(s, before)) /
            (qni_sample_plane(frame, k, after[k]) - qni_sample_plane(frame, k, before[k]));
    }
}

/* Does the segment run along one lattice edge, within it? Then it is axis `axis_out` of that cell's
 * lowest edge. */
static bool is_on_edge(const sampled_solid *s, const double a[3], const double b[3], int *axis_out,
                       qni_cell_place *from, qni_cell_place *to) {
    int axis = -1;
    *from = qni_locate(s, a);
    *to = qni_locate(s, b);
    for (int k = 0; k < 3; ++k) {
        if (a[k] != b[k]) {
            if (axis >= 0)
                return false;
            axis = k;
        } else if (from->along[k] == 1) { /* the frame's last plane */
            from->along[k] = 0;
            ++from->cell[k];
        } else if (from->along[k] != 0) {
            return false;
        }
    }
    if (axis < 0)
        return false;
    const int32_t steps = to->cell[axis] - from->cell[axis];
    if (steps == 1 && to->along[axis] == 0)
        to->along[axis] = 1;
    else if (steps == -1 && from->along[axis] == 0) {
        from->along[axis] = 1;
        --from->cell[axis];
    } else if (steps != 0)
        return false;
    *axis_out = axis;
    return true;
}

/* Where the planes leave the solid, or come into it, along an edge whose samples lie on both sides;
 * false when that is not on the edge. */
static bool cross_planes(const sampled_solid *s, const qni_sharp_fit *fit, const int32_t end[2][3],
                         int axis, double *along_out, double normal[3]) {
    const qni_sample_frame *frame = &s->whole->frame;
    double place[3], low = 0, high = 1;
    int active = 0;
    for (int k = 0; k < 3; ++k)
        place[k] = qni_sample_plane(frame, k, end[0][k]);
    const double from = place[axis], to = qni_sample_plane(frame, axis, end[1][axis]);
    const bool before = qni_fit_value(fit, place, &active) < 0;
    place[axis] = to;
    if ((qni_fit_value(fit, place, &active) < 0) == before)
        return false;
    for (int step = 0; step < 50; ++step) {
        const double middle = 0.5 * (low + high);
        place[axis] = qni_mix(from, to, middle);
        if ((qni_fit_value(fit, place, &active) < 0) == before)
            low = middle;
        else
            high = middle;
    }
    memcpy(normal, fit->tangents[active].slope, sizeof fit->tangents[active].slope);
    *along_out = low;
    return true;
}

/* The crossing of an edge in a distance: by the planes where there is a crease nearby; else on the
 * straight line between its samples, with the mean of the slopes that are known from a smooth side.
 */
static bool cross_sharply(const sampled_solid *s, const int32_t end[2][3], int axis,
                          double *along_out, double normal[3]) {
    const sampled_solid *whole = s->whole;
    const qni_sample_reader reader = {s, qni_read_sample, qni_read_plane};
    qni_sample_tangent tangent[2];
    const bool known[2] = {qni_tangent_at(&reader, end[0], whole->frame.step, &tangent[0]),
                           qni_tangent_at(&reader, end[1], whole->frame.step, &tangent[1])};
    qni_sharp_fit fit;
    fit.crease = false;
    if (!known[0] || !known[1] || !qni_tangents_agree(&tangent[0], &tangent[1]))
        qni_fit_edge(&reader, end[0], axis, whole->frame.step, whole->crease_cosine, &fit);
    if (fit.crease && cross_planes(s, &fit, end, axis, along_out, normal)) {
        __atomic_add_fetch((int64_t *)(uintptr_t)&whole->sharp_crossings, 1, __ATOMIC_RELAXED);
        return true;
    }
    if (!known[0] && !known[1])
        return false;
    for (int k = 0; k < 3; ++k)
        normal[k] = !known[0]   ? tangent[1].slope[k]
                    : !known[1] ? tangent[0].slope[k]
                                : qni_mix(tangent[0].slope[k], tangent[1].slope[k], *along_out);
    return true;
}

/* One crossing at most: the interpolant is linear. The normal is that of the field's central
 * differences, interpolated, which is the same for all cells at the edge. */
static void cross_edge(const sampled_solid *s, int axis, const qni_cell_place *from,
                       const qni_cell_place *to, int32_t capacity, qni_crossing *crossings,
                       int32_t *count_out) {
    int32_t end[2][3];
    memcpy(end[0], from->cell, sizeof end[0]);
    memcpy(end[1], from->cell, sizeof end[1]);
    ++end[1][axis];
    const double value[2] = {qni_sample(s, end[0]), qni_sample(s, end[1])};
    const double a = qni_mix(value[0], value[1], from->along[axis]),
                 b = qni_mix(value[0], value[1], to->along[axis]);
    *count_out = 0;
    if ((a < 0) == (b < 0) || capacity < 1)
        return;
    double t = a / (a - b), slope[2][3];
    double along = qni_mix(from->along[axis], to->along[axis], t);
    const bool whole_edge = fabs(to->along[axis] - from->along[axis]) == 1;
    if (s->whole->creases && whole_edge &&
        cross_sharply(s, (const int32_t(*)[3])end, axis, &along, crossings[0].normal)) {
        t = to->along[axis] > from->along[axis] ? along : 1 - along;
    } else {
        for (int n = 0; n < 2; ++n)
            sample_slopes(s, end[n], slope[n]);
        for (int k = 0; k < 3; ++k)
            crossings[0].normal[k] = qni_mix(slope[0][k], slope[1][k], along);
    }
    double back[3] = {0, 0, 0};
    const bool up = to->along[axis] > from->along[axis];
    back[axis] = (b < 0) == up ? -1 : 1;
    qni_unit(crossings[0].normal, back, crossings[0].normal);
    crossings[0].at = t;
    crossings[0].owner = s->base.owner;
    crossings[0].enters = b < 0;
    *count_out = 1;
}

qn_status qni_sampled_crossings_of(const qn_solid *solid, const double a[3], const double b[3],
                                   int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const sampled_solid *s = (const sampled_solid *)solid;
    qni_cell_place from, to;
    int axis;
    if (!is_on_edge(s, a, b, &axis, &from, &to))
        return qni_find_crossings(solid, a, b, capacity, crossings, count_out);
    cross_edge(s, axis, &from, &to, capacity, crossings, count_out);
    return QN_OK;
}
