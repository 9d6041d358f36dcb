// SPDX-License-Identifier: MIT
/* The range of a sampled solid over a box: from the samples where the box is small, else from its
 * leaves. */
#include "solid/node.h"
#include "solid/sampled_parts.h"

enum {
    MOST_PLANES = 4, /* planes in a box, along an axis, whose range is found from the samples */
    BOX_POINTS = MOST_PLANES + 2
};

/* The places along an axis where the box begins, where planes cut it, and where it ends; 0 when
 * there are too many. */
static int cut_axis(const qni_sample_frame *frame, const qni_box *box, int k,
                    double out[BOX_POINTS]) {
    qni_cell_place low, high;
    qni_locate_axis(frame, k, box->low[k], &low);
    qni_locate_axis(frame, k, box->high[k], &high);
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
                const qni_cell_place place = qni_locate(s, point);
                double corner[8];
                qni_sampled_load(s, place.cell, corner);
                const double value = qni_sampled_mix(corner, place.along);
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
        qni_cell_place first, last;
        qni_locate_axis(&whole->frame, k, box->low[k], &first);
        qni_locate_axis(&whole->frame, k, box->high[k], &last);
        low[k] = first.cell[k] / QNI_LEAF;
        high[k] = last.cell[k] / QNI_LEAF;
    }
    if (qni_leaf_tree_range(&whole->tree, low, high, range))
        return;
    const double point[1][3] = {{box->low[0], box->low[1], box->low[2]}};
    double value;
    s->base.ops->values(&s->base, 1, point, &value);
    range[0] = whole->tree.complete ? value : value < 0 ? -1e300 : value == 0 ? 0 : 5e-324;
    range[1] = whole->tree.complete ? value : value < 0 ? -5e-324 : 1e300;
}

qn_status qni_sampled_bounds_of(const qn_solid *solid, const qni_box *box, double range[2]) {
    const sampled_solid *s = (const sampled_solid *)solid;
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
