// SPDX-License-Identifier: MIT
/* A volume's trilinear interpolant as a solid: values and gradients cell by cell, exact ranges over
 * small boxes, exact crossings of lattice edges; near a box from a block of samples of its own. */
#include "solid/sampled.h"
#include "solid/node.h"
#include "solid/sampled_parts.h"
#include "volume/field.h"

#include <string.h>

enum {
    MOST_BLOCK = 40, /* points along a side of a block of samples */
    MOST_PLANES = 4, /* planes in a box, along an axis, whose range is found from the samples */
    BOX_POINTS = MOST_PLANES + 2
};

static const qni_sharp_fit no_crease = {.count = 0};

static const sampled_solid *as_sampled(const qn_solid *solid) {
    return (const sampled_solid *)solid;
}

static int64_t block_samples(const sample_block *block) {
    return (int64_t)block->size[0] * block->size[1] * block->size[2];
}

static void destroy(qn_solid *solid) {
    sampled_solid *s = (sampled_solid *)solid;
    const int64_t cells = block_samples(&s->block);
    for (int64_t n = 0; s->block.fits && n < cells; ++n)
        if (s->block.fits[n] != &no_crease)
            qni_free(solid->context, (void *)(uintptr_t)s->block.fits[n], 1,
                     sizeof **s->block.fits);
    qni_free(solid->context, s->block.fits, cells, sizeof *s->block.fits);
    qni_free(solid->context, s->block.values, block_samples(&s->block), sizeof *s->block.values);
    if (s->whole == s)
        qni_leaf_tree_free(solid->context, &s->tree);
    else
        qn_solid_destroy((qn_solid *)(uintptr_t)&s->whole->base);
    qni_solid_free(solid, sizeof *s);
}

/* ---- samples --------------------------------------------------------------------------------- */

static int32_t clamped(int64_t value, int64_t low, int64_t high) {
    return (int32_t)(value < low ? low : value > high ? high : value);
}

static const double *in_block(const sampled_solid *s, const int32_t point[3]) {
    const sample_block *block = &s->block;
    if (!block->values)
        return NULL;
    int64_t at = 0;
    for (int k = 2; k >= 0; --k) {
        const int32_t offset = point[k] - block->low[k];
        if (offset < 0 || offset >= block->size[k])
            return NULL;
        at = at * block->size[k] + offset;
    }
    return block->values + at;
}

static double sample(const sampled_solid *s, const int32_t point[3]) {
    const double *value = in_block(s, point);
    if (value)
        return *value;
    const qni_field *field = &s->whole->field;
    return qni_sampled_sign(field->inside_below,
                            qni_field_value(field, point[0], point[1], point[2]));
}

static void load_corners(const sampled_solid *s, const int32_t cell[3], double corner[8]) {
    const int32_t last[3] = {cell[0] + 1, cell[1] + 1, cell[2] + 1};
    const double *first = in_block(s, cell);
    if (first && in_block(s, last)) {
        const int64_t row = s->block.size[0], slice = row * s->block.size[1];
        for (int c = 0; c < 8; ++c)
            corner[c] = first[(c & 1) + (c >> 1 & 1) * row + (c >> 2) * slice];
        return;
    }
    const qni_field *field = &s->whole->field;
    const int64_t at[3] = {cell[0], cell[1], cell[2]};
    qni_field_load_cell(field, at, corner);
    for (int c = 0; c < 8; ++c)
        corner[c] = qni_sampled_sign(field->inside_below, corner[c]);
}

bool qni_sampled_corners(const qn_solid *solid, const int64_t cell[3], double corner[8]) {
    const sampled_solid *s = as_sampled(solid);
    int32_t at[3];
    for (int k = 0; k < 3; ++k) {
        if (cell[k] < 0 || cell[k] + 1 >= s->whole->frame.count[k])
            return false;
        at[k] = (int32_t)cell[k];
    }
    load_corners(s, at, corner);
    return true;
}

/* ---- places ---------------------------------------------------------------------------------- */

/* A place in a cell: which cell, and how far along it, 0 to 1. Places beyond the frame are those
 * nearest to them on its border, which lies outside. */
typedef struct cell_place {
    int32_t cell[3];
    double along[3], width[3];
} cell_place;

static void locate_axis(const qni_sample_frame *frame, int k, double position, cell_place *place) {
    const int64_t last = frame->count[k] - 2;
    const double guess = (position - frame->origin[k]) / frame->step[k];
    int64_t cell = !(guess > 0) ? 0 : guess < (double)last ? (int64_t)guess : last;
    while (cell > 0 && position < qni_sample_plane(frame, k, cell))
        --cell;
    while (cell < last && position >= qni_sample_plane(frame, k, cell + 1))
        ++cell;
    const double low = qni_sample_plane(frame, k, cell),
                 high = qni_sample_plane(frame, k, cell + 1);
    const double along = (position - low) / (high - low);
    place->cell[k] = (int32_t)cell;
    place->width[k] = high - low;
    place->along[k] = along > 0 ? along < 1 ? along : 1 : 0;
}

static cell_place locate(const sampled_solid *s, const double point[3]) {
    cell_place place;
    for (int k = 0; k < 3; ++k)
        locate_axis(&s->whole->frame, k, point[k], &place);
    return place;
}

/* ---- creases --------------------------------------------------------------------------------- */

static double read_sample(const void *samples, const int32_t point[3]) {
    const sampled_solid *s = samples;
    const qni_sample_frame *frame = &s->whole->frame;
    int32_t at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = clamped(point[k], 0, frame->count[k] - 1);
    return sample(s, at);
}

static double read_plane(const void *samples, int axis, int64_t point) {
    return qni_sample_plane(&((const sampled_solid *)samples)->whole->frame, axis, point);
}

static void make_fit(const sampled_solid *s, const int32_t cell[3], const double corner[8],
                     qni_sharp_fit *fit) {
    const qni_sample_reader reader = {s, read_sample, read_plane};
    fit->crease = false;
    if (!qni_cell_is_plain(corner, s->whole->frame.step))
        qni_fit_cell(&reader, cell, s->whole->frame.step, s->whole->crease_cosine, fit);
}

/* The fit of a cell of a block, kept once it is made; NULL where there is no crease. `room` is used
 * when memory is short. */
static const qni_sharp_fit *kept_fit(const sampled_solid *s, int64_t at, const int32_t cell[3],
                                     const double corner[8], qni_sharp_fit *room) {
    const qni_sharp_fit **slot = &s->block.fits[at];
    const qni_sharp_fit *known = __atomic_load_n(slot, __ATOMIC_ACQUIRE);
    if (!known) {
        make_fit(s, cell, corner, room);
        qni_sharp_fit *kept = NULL;
        if (room->crease) {
            kept = qni_alloc(s->base.context, 1, sizeof *kept);
            if (!kept)
                return room;
            *kept = *room;
        }
        const qni_sharp_fit *fresh = kept ? kept : &no_crease;
        if (__atomic_compare_exchange_n(slot, &known, fresh, false, __ATOMIC_ACQ_REL,
                                        __ATOMIC_ACQUIRE))
            known = fresh;
        else
            qni_free(s->base.context, kept, 1, sizeof *kept);
    }
    return known == &no_crease ? NULL : known;
}

/* What planes make of the cell when a crease runs through it, else NULL. */
static const qni_sharp_fit *fit_crease(const sampled_solid *s, const int32_t cell[3],
                                       const double corner[8], qni_sharp_fit *room) {
    if (!s->whole->creases)
        return NULL;
    const double *first = s->block.fits ? in_block(s, cell) : NULL;
    if (first)
        return kept_fit(s, first - s->block.values, cell, corner, room);
    make_fit(s, cell, corner, room);
    return room->crease ? room : NULL;
}

/* ---- values and gradients -------------------------------------------------------------------- */

static double interpolate(const double c[8], const double t[3]) {
    const double low = mix(mix(c[0], c[1], t[0]), mix(c[2], c[3], t[0]), t[1]);
    const double high = mix(mix(c[4], c[5], t[0]), mix(c[6], c[7], t[0]), t[1]);
    return mix(low, high, t[2]);
}

static void slopes(const double c[8], const cell_place *place, double gradient[3]) {
    for (int k = 0; k < 3; ++k) {
        const int p = k == 0 ? 1 : 0, q = k == 2 ? 1 : 2;
        double side[2];
        for (int n = 0; n < 2; ++n) {
            const int base = n << k, u = 1 << p, v = 1 << q;
            side[n] = mix(mix(c[base], c[base | u], place->along[p]),
                          mix(c[base | v], c[base | u | v], place->along[p]), place->along[q]);
        }
        gradient[k] = (side[1] - side[0]) / place->width[k];
    }
}

static bool is_sample(const cell_place *place) {
    for (int k = 0; k < 3; ++k)
        if (place->along[k] != 0 && place->along[k] != 1)
            return false;
    return true;
}

static qn_status sampled_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                double *values) {
    const sampled_solid *s = as_sampled(solid);
    for (int64_t n = 0; n < count; ++n) {
        const cell_place place = locate(s, points[n]);
        double corner[8];
        load_corners(s, place.cell, corner);
        qni_sharp_fit room;
        int active;
        const qni_sharp_fit *fit =
            is_sample(&place) ? NULL : fit_crease(s, place.cell, corner, &room);
        values[n] = fit ? qni_fit_value(fit, points[n], &active) : interpolate(corner, place.along);
    }
    return QN_OK;
}

static qn_status sampled_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                   double (*gradients)[3], int32_t *owners) {
    const sampled_solid *s = as_sampled(solid);
    for (int64_t n = 0; n < count; ++n) {
        if (owners)
            owners[n] = solid->owner;
        if (!gradients)
            continue;
        const cell_place place = locate(s, points[n]);
        double corner[8];
        load_corners(s, place.cell, corner);
        slopes(corner, &place, gradients[n]);
        qni_sharp_fit room;
        int active;
        const qni_sharp_fit *fit = fit_crease(s, place.cell, corner, &room);
        if (fit) {
            qni_fit_value(fit, points[n], &active);
            memcpy(gradients[n], fit->tangents[active].slope, sizeof gradients[n]);
        }
    }
    return QN_OK;
}

/* ---- bounds ---------------------------------------------------------------------------------- */

/* The places along an axis where the box begins, where planes cut it, and where it ends; 0 when
 * there are too many. */
static int cut_axis(const qni_sample_frame *frame, const qni_box *box, int k,
                    double out[BOX_POINTS]) {
    cell_place low, high;
    locate_axis(frame, k, box->low[k], &low);
    locate_axis(frame, k, box->high[k], &high);
    const int32_t planes = high.cell[k] - low.cell[k];
    if (planes > MOST_PLANES)
        return 0;
    int count = 0;
    out[count++] = box->low[k];
    for (int32_t n = 1; n <= planes; ++n)
        out[count++] = qni_sample_plane(frame, k, low.cell[k] + n);
    if (box->high[k] > out[count - 1])
        out[count++] = box->high[k];
    return count;
}

/* Within a cell the interpolant is linear along each axis, so its extremes over a box are at the
 * box's corners. False when the box is too large for that. */
static bool range_by_samples(const sampled_solid *s, const qni_box *box, double range[2]) {
    double at[3][BOX_POINTS];
    int count[3];
    for (int k = 0; k < 3; ++k) {
        count[k] = cut_axis(&s->whole->frame, box, k, at[k]);
        if (count[k] == 0)
            return false;
    }
    range[0] = QNI_INFINITY;
    range[1] = -QNI_INFINITY;
    for (int z = 0; z < count[2]; ++z)
        for (int y = 0; y < count[1]; ++y)
            for (int x = 0; x < count[0]; ++x) {
                const double point[3] = {at[0][x], at[1][y], at[2][z]};
                const cell_place place = locate(s, point);
                double corner[8];
                load_corners(s, place.cell, corner);
                const double value = interpolate(corner, place.along);
                range[0] = fmin(range[0], value);
                range[1] = fmax(range[1], value);
            }
    return true;
}

/* By the leaves that the box meets. Where it meets none that is known, its side is that of any of
 * its points. */
static void range_by_leaves(const sampled_solid *s, const qni_box *box, double range[2]) {
    const sampled_solid *whole = s->whole;
    int32_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        cell_place first, last;
        locate_axis(&whole->frame, k, box->low[k], &first);
        locate_axis(&whole->frame, k, box->high[k], &last);
        low[k] = first.cell[k] / QNI_LEAF;
        high[k] = last.cell[k] / QNI_LEAF;
    }
    if (qni_leaf_tree_range(&whole->tree, low, high, range))
        return;
    const double point[1][3] = {{box->low[0], box->low[1], box->low[2]}};
    double value;
    sampled_values(&s->base, 1, point, &value);
    range[0] = whole->tree.complete ? value : value < 0 ? -1e300 : value == 0 ? 0 : 5e-324;
    range[1] = whole->tree.complete ? value : value < 0 ? -5e-324 : 1e300;
}

static qn_status sampled_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const sampled_solid *s = as_sampled(solid);
    if (!range_by_samples(s, box, range))
        range_by_leaves(s, box, range);
    /* The roundings of three interpolations; and planes may be so far from what they replace. */
    const double *step = s->whole->frame.step;
    const double slack = 8 * QNI_EPSILON * fmax(fabs(range[0]), fabs(range[1])) +
                         (s->whole->creases ? fmax(step[0], fmax(step[1], step[2])) : 0);
    const double low = range[0] - slack, high = range[1] + slack;
    range[0] = range[0] > 0 ? fmax(low, 5e-324) : low;
    range[1] = range[1] < 0 ? fmin(high, -5e-324) : high;
    return QN_OK;
}

/* ---- crossings ------------------------------------------------------------------------------- */

/* Slopes at a sample, by central differences; by one-sided ones at the frame's border. */
static void sample_slopes(const sampled_solid *s, const int32_t point[3], double gradient[3]) {
    const qni_sample_frame *frame = &s->whole->frame;
    for (int k = 0; k < 3; ++k) {
        int32_t before[3] = {point[0], point[1], point[2]}, after[3];
        memcpy(after, before, sizeof after);
        before[k] = clamped(point[k] - 1, 0, frame->count[k] - 1);
        after[k] = clamped(point[k] + 1, 0, frame->count[k] - 1);
        gradient[k] =
            (sample(s, after) - sample(s, before)) /
            (qni_sample_plane(frame, k, after[k]) - qni_sample_plane(frame, k, before[k]));
    }
}

/* Does the segment run along one lattice edge, within it? Then it is axis `axis_out` of that cell's
 * lowest edge. */
static bool is_on_edge(const sampled_solid *s, const double a[3], const double b[3], int *axis_out,
                       cell_place *from, cell_place *to) {
    int axis = -1;
    *from = locate(s, a);
    *to = locate(s, b);
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

/* One crossing at most: the interpolant is linear. The normal is that of the field's central
 * differences, interpolated, which is the same for all cells at the edge. */
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
        place[axis] = mix(from, to, middle);
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
    const qni_sample_reader reader = {s, read_sample, read_plane};
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
                                : mix(tangent[0].slope[k], tangent[1].slope[k], *along_out);
    return true;
}

static void cross_edge(const sampled_solid *s, int axis, const cell_place *from,
                       const cell_place *to, int32_t capacity, qni_crossing *crossings,
                       int32_t *count_out) {
    int32_t end[2][3];
    memcpy(end[0], from->cell, sizeof end[0]);
    memcpy(end[1], from->cell, sizeof end[1]);
    ++end[1][axis];
    const double value[2] = {sample(s, end[0]), sample(s, end[1])};
    const double a = mix(value[0], value[1], from->along[axis]),
                 b = mix(value[0], value[1], to->along[axis]);
    *count_out = 0;
    if ((a < 0) == (b < 0) || capacity < 1)
        return;
    double t = a / (a - b), slope[2][3];
    double along = mix(from->along[axis], to->along[axis], t);
    const bool whole_edge = fabs(to->along[axis] - from->along[axis]) == 1;
    if (s->whole->creases && whole_edge &&
        cross_sharply(s, (const int32_t(*)[3])end, axis, &along, crossings[0].normal)) {
        t = to->along[axis] > from->along[axis] ? along : 1 - along;
    } else {
        for (int n = 0; n < 2; ++n)
            sample_slopes(s, end[n], slope[n]);
        for (int k = 0; k < 3; ++k)
            crossings[0].normal[k] = mix(slope[0][k], slope[1][k], along);
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

static qn_status sampled_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                   int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const sampled_solid *s = as_sampled(solid);
    cell_place from, to;
    int axis;
    if (!is_on_edge(s, a, b, &axis, &from, &to))
        return qni_find_crossings(solid, a, b, capacity, crossings, count_out);
    cross_edge(s, axis, &from, &to, capacity, crossings, count_out);
    return QN_OK;
}

/* ---- restricting ----------------------------------------------------------------------------- */

/* The samples of one leaf's tile that lie in the block. A leaf gives its own 8^3 points; the border
 * leaves, and the only leaf of a small block, all that their tiles hold of it. */
static void copy_tile(const qni_field *field, const int32_t leaf[3], bool alone,
                      sample_block *block) {
    double tile[QNI_TILE][QNI_TILE][QNI_TILE];
    int32_t low[3], high[3], base[3];
    qni_field_load_tile(field, leaf, tile);
    for (int k = 0; k < 3; ++k) {
        const int32_t first = leaf[k] * QNI_LEAF, end = block->low[k] + block->size[k] - 1;
        base[k] = first - 1;
        low[k] = clamped(alone ? first - 1 : first, block->low[k], end);
        high[k] = clamped(alone || leaf[k] + 1 == field->leaves[k] ? first + 9 : first + 7,
                          block->low[k], end);
    }
    for (int32_t z = low[2]; z <= high[2]; ++z)
        for (int32_t y = low[1]; y <= high[1]; ++y)
            for (int32_t x = low[0]; x <= high[0]; ++x)
                block->values[((int64_t)(z - block->low[2]) * block->size[1] + y - block->low[1]) *
                                  block->size[0] +
                              x - block->low[0]] =
                    qni_sampled_sign(field->inside_below,
                                     tile[z - base[2]][y - base[1]][x - base[0]]);
}

static void fill_block(const qni_field *field, sample_block *block) {
    int32_t first[3], last[3], leaf[3];
    bool alone = true;
    for (int k = 0; k < 3; ++k) {
        const int32_t end = block->low[k] + block->size[k] - 1;
        first[k] = clamped((block->low[k] + 1) / QNI_LEAF, 0, field->leaves[k] - 1);
        alone = alone && end <= first[k] * QNI_LEAF + 9;
    }
    if (alone) {
        copy_tile(field, first, true, block);
        return;
    }
    for (int k = 0; k < 3; ++k) {
        first[k] = clamped(block->low[k] / QNI_LEAF, 0, field->leaves[k] - 1);
        last[k] = clamped((block->low[k] + block->size[k] - 1) / QNI_LEAF, 0, field->leaves[k] - 1);
    }
    for (leaf[2] = first[2]; leaf[2] <= last[2]; ++leaf[2])
        for (leaf[1] = first[1]; leaf[1] <= last[1]; ++leaf[1])
            for (leaf[0] = first[0]; leaf[0] <= last[0]; ++leaf[0])
                copy_tile(field, leaf, false, block);
}

/* The points that the box's cells, and the slopes at their corners, need; false when they are too
 * many. */
static bool lay_block(const sampled_solid *s, const qni_box *box, sample_block *block) {
    for (int k = 0; k < 3; ++k) {
        cell_place first, last;
        const qni_sample_frame *frame = &s->whole->frame;
        locate_axis(frame, k, box->low[k], &first);
        locate_axis(frame, k, box->high[k], &last);
        const int32_t end = last.cell[k] + (last.along[k] > 0) + 1;
        const int32_t more = s->whole->creases ? 2 : 0; /* for stencils on either side */
        const int32_t low = clamped(first.cell[k] - 1 - more, 0, frame->count[k] - 1),
                      high = clamped(end + more, 0, frame->count[k] - 1);
        block->low[k] = low;
        block->size[k] = high - low + 1;
        if (block->size[k] > MOST_BLOCK)
            return false;
    }
    return true;
}

/* What a block holds is there at once, fits that are known with it: a smaller one is no cheaper. */
static bool holds_block(const sampled_solid *s, const sample_block *block) {
    int32_t last[3];
    for (int k = 0; k < 3; ++k)
        last[k] = block->low[k] + block->size[k] - 1;
    return in_block(s, block->low) && in_block(s, last);
}

static qn_status sampled_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out);

static const qni_solid_ops sampled_ops = {
    .destroy = destroy,
    .values = sampled_values,
    .gradients = sampled_gradients,
    .bounds = sampled_bounds,
    .crossings = sampled_crossings,
    .restrict_to = sampled_restrict,
};

static qn_status sampled_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const sampled_solid *s = as_sampled(solid);
    sample_block block = {.values = NULL};
    if (!lay_block(s, box, &block) || holds_block(s, &block)) {
        *solid_out = qni_solid_retain(solid);
        return QN_OK;
    }
    *solid_out = NULL;
    sampled_solid *part =
        (sampled_solid *)qni_solid_new(solid->context, sizeof *part, &sampled_ops);
    if (!part)
        return QN_ERROR_OUT_OF_MEMORY;
    part->whole = (const sampled_solid *)qni_solid_retain(&s->whole->base);
    part->base.box = solid->box;
    part->base.owner = solid->owner;
    block.values = qni_alloc(solid->context, block_samples(&block), sizeof *block.values);
    part->block = block;
    if (block.values && s->whole->creases) {
        part->block.fits =
            qni_alloc_zero(solid->context, block_samples(&block), sizeof *part->block.fits);
        if (!part->block.fits) {
            qn_solid_destroy(&part->base);
            return QN_ERROR_OUT_OF_MEMORY;
        }
    }
    if (!block.values) {
        qn_solid_destroy(&part->base);
        return QN_ERROR_OUT_OF_MEMORY;
    }
    fill_block(&s->whole->field, &part->block);
    *solid_out = &part->base;
    return QN_OK;
}

/* ---- making ---------------------------------------------------------------------------------- */

static qni_box box_of(const sampled_solid *s) {
    const qni_leaf_tree *tree = &s->tree;
    if (tree->mixed_count == 0)
        return qni_box_nothing();
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        int32_t low = INT32_MAX, high = 0;
        for (int64_t n = 0; n < tree->mixed_count; ++n) {
            low = tree->mixed[n][k] < low ? tree->mixed[n][k] : low;
            high = tree->mixed[n][k] > high ? tree->mixed[n][k] : high;
        }
        const int64_t end = (int64_t)(high + 1) * QNI_LEAF, last = s->frame.count[k] - 1;
        box.low[k] = qni_sample_plane(&s->frame, k, (int64_t)low * QNI_LEAF);
        box.high[k] = qni_sample_plane(&s->frame, k, end < last ? end : last);
    }
    return box;
}

static double measure_distance(const sampled_solid *s) {
    enum { MOST_LEAVES = 2000 };
    const qni_leaf_tree *tree = &s->tree;
    const int64_t stride = tree->mixed_count / MOST_LEAVES + 1;
    const qni_sample_reader reader = {s, read_sample, read_plane};
    int64_t crossed = 0, unit = 0;
    for (int64_t n = 0; n < tree->mixed_count; n += stride)
        for (int m = 0; m < 512; ++m) {
            const int32_t point[3] = {8 * tree->mixed[n][0] + (m & 7),
                                      8 * tree->mixed[n][1] + (m >> 3 & 7),
                                      8 * tree->mixed[n][2] + (m >> 6)};
            int32_t next[3] = {point[0] + 1, point[1], point[2]};
            if (next[0] >= s->frame.count[0] || point[1] >= s->frame.count[1] ||
                point[2] >= s->frame.count[2] || (sample(s, point) < 0) == (sample(s, next) < 0))
                continue;
            qni_sample_tangent tangent;
            ++crossed;
            unit += qni_tangent_at(&reader, point, s->frame.step, &tangent) ||
                    qni_tangent_at(&reader, next, s->frame.step, &tangent);
        }
    return crossed ? (double)unit / (double)crossed : 0;
}

qn_status qni_sampled_create(qn_context *context, const qn_volume *volume,
                             const qni_sampled_settings *settings, qn_solid **solid_out,
                             qn_error *error) {
    *solid_out = NULL;
    sampled_solid *s = (sampled_solid *)qni_solid_new(context, sizeof *s, &sampled_ops);
    if (!s)
        return qni_fail_memory(error, "a solid");
    s->whole = s;
    s->base.owner = settings->owner;
    qn_status status =
        qni_field_init(volume, settings->isovalue, settings->inside_below, false, &s->field, error);
    if (status == QN_OK) {
        qni_sample_frame_init(&s->frame, (const double(*)[4])s->field.world, s->field.samples);
        status = qni_leaf_tree_build(context, &s->field, settings->every_leaf, &s->tree, error);
    }
    if (status != QN_OK) {
        qn_solid_destroy(&s->base);
        return status;
    }
    s->base.box = box_of(s);
    s->distance_share = settings->creases ? measure_distance(s) : 0;
    s->creases = settings->creases && s->distance_share >= settings->least_share;
    s->crease_cosine = settings->crease_cosine;
    *solid_out = &s->base;
    return QN_OK;
}

const qni_sample_frame *qni_sampled_frame(const qn_solid *solid) {
    return solid->ops == &sampled_ops ? &as_sampled(solid)->whole->frame : NULL;
}

const int32_t (*qni_sampled_mixed_leaves(const qn_solid *solid, int64_t *count_out))[3] {
    const qni_leaf_tree *tree = &as_sampled(solid)->whole->tree;
    *count_out = tree->mixed_count;
    return (const int32_t(*)[3])tree->mixed;
}

double qni_sampled_distance_share(const qn_solid *solid) {
    return as_sampled(solid)->whole->distance_share;
}

bool qni_sampled_has_creases(const qn_solid *solid) {
    return as_sampled(solid)->whole->creases;
}

int64_t qni_sampled_sharp_crossings(const qn_solid *solid) {
    return __atomic_load_n(&as_sampled(solid)->whole->sharp_crossings, __ATOMIC_RELAXED);
}
