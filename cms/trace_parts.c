// SPDX-License-Identifier: MIT
/* The trace of a segment that could not be found in one piece: the face is cut in two, and again,
 * and the trace is followed from part to part. In a part it is short: of a rim made of many facets
 * few are left, and creases that pass close by each other are apart. */
#include "cms/face_job.h"

#include <math.h>
#include <string.h>

/* Faces larger than a block are asked only for leaves that are larger still, which are divided
 * where this fails; on a level set of 250,000 finest cells their parts took a third of all time,
 * for no leaf. */
enum { LARGEST_LEVEL = 3 };

/* No trace that was found, on models, solids and level sets, took more than 24 parts. */
enum {
    STEP_CUTS = 4,
    MOST_CUTS = 12,
    MOST_PARTS = 48,
    PART_POINTS = 16,
    MOST_CROSSINGS = 8,
    MOST_STEPS = 16
};

/* A crossing on the border of a part. */
typedef struct border_point {
    qni_face_line line;
    double order; /* along the border, counter-clockwise from its lowest corner: 0 to 4 */
    int32_t from; /* number in the larger part's list; -1 - n: on the cut */
    bool enters;
} border_point;

typedef struct part {
    double low[2], high[2];
    int count;
    border_point points[PART_POINTS];
} part;

typedef struct walk {
    qni_face_job job; /* its bounds are those of the part that is looked at */
    qni_trace *trace;
    int least_cuts; /* parts that were cut less often are cut again */
    bool steps;     /* so are parts with a step between two of like normals */
    int parts;      /* looked at */
    bool lost;      /* more bends than a segment can have, or too many parts: cutting on is idle */
} walk;

static void order_point(const part *here, border_point *point) {
    double share[2];
    for (int k = 0; k < 2; ++k)
        share[k] = (point->line.at[k] - here->low[k]) / (here->high[k] - here->low[k]);
    const double off[4] = {fabs(share[1]), fabs(1 - share[0]), fabs(1 - share[1]), fabs(share[0])};
    int side = 0;
    for (int n = 1; n < 4; ++n)
        side = off[n] < off[side] ? n : side;
    const double along = share[side & 1];
    point->order = side + fmin(fmax(side < 2 ? along : 1 - along, 0), 1);
}

/* Into its place; false when there is no room. */
static bool add_point(part *here, border_point point) {
    int n = here->count;
    if (n == PART_POINTS)
        return false;
    order_point(here, &point);
    for (; n > 0 && here->points[n - 1].order > point.order; --n)
        here->points[n] = here->points[n - 1];
    here->points[n] = point;
    ++here->count;
    return true;
}

static bool alternates(const part *here) {
    for (int n = 0; n < here->count; ++n)
        if (here->points[n].enters == here->points[(n + 1) % here->count].enters)
            return false;
    return here->count % 2 == 0;
}

/* Where the surface meets the cut. */
static bool cross_cut(const walk *w, const part *whole, int axis, double at, border_point *points,
                      int *count) {
    const qni_face_job *job = &w->job;
    double ends[2][2], space[2][3];
    qni_crossing found[MOST_CROSSINGS];
    int32_t crossings = 0;
    for (int n = 0; n < 2; ++n) {
        ends[n][axis] = at;
        ends[n][1 - axis] = n ? whole->high[1 - axis] : whole->low[1 - axis];
        qni_face_to_space(job, ends[n], space[n]);
    }
    if (job->solid->ops->crossings(job->solid, space[0], space[1], MOST_CROSSINGS, found,
                                   &crossings) != QN_OK ||
        crossings > MOST_CROSSINGS)
        return false;
    *count = crossings;
    for (int n = 0; n < crossings; ++n) {
        double place[3];
        for (int k = 0; k < 3; ++k)
            place[k] = space[0][k] + found[n].at * (space[1][k] - space[0][k]);
        if (!qni_face_set_line(job, place, found[n].normal, &points[n].line))
            return false;
        points[n].line.owner = found[n].owner;
        points[n].line.at[axis] = at;
        points[n].from = -1 - n;
        points[n].enters = found[n].enters;
    }
    return true;
}

/* Across the longer side, not quite in the middle, where lattices and models like to have
 * something. */
static bool cut_part(const walk *w, const part *whole, part halves[2]) {
    const int axis = whole->high[0] - whole->low[0] >= whole->high[1] - whole->low[1] ? 0 : 1;
    const double at = whole->low[axis] + 0.4871 * (whole->high[axis] - whole->low[axis]);
    border_point on_cut[MOST_CROSSINGS];
    int count = 0;
    if (!cross_cut(w, whole, axis, at, on_cut, &count))
        return false;
    for (int half = 0; half < 2; ++half) {
        memcpy(halves[half].low, whole->low, sizeof whole->low);
        memcpy(halves[half].high, whole->high, sizeof whole->high);
        (half ? halves[half].low : halves[half].high)[axis] = at;
        halves[half].count = 0;
    }
    for (int n = 0; n < whole->count; ++n) {
        border_point point = whole->points[n];
        point.from = n;
        if (!add_point(&halves[point.line.at[axis] > at], point))
            return false;
    }
    for (int n = 0; n < count; ++n) /* upwards along the cut is counter-clockwise for one of both */
        for (int half = 0; half < 2; ++half) {
            border_point point = on_cut[n];
            point.enters = point.enters == ((axis == 0) == (half == 0));
            if (!add_point(&halves[half], point))
                return false;
        }
    return alternates(&halves[0]) && alternates(&halves[1]);
}

static bool append(qni_trace *trace, const qni_trace *more) {
    if (trace->count + more->count > QNI_MOST_BENDS)
        return false;
    for (int n = 0; n < more->count; ++n) {
        memcpy(trace->bends[trace->count], more->bends[n], sizeof more->bends[n]);
        trace->lines[++trace->count] = more->lines[n + 1];
    }
    return true;
}

/* The trace between the only two points of a part. */
static bool trace_part(walk *w, const part *here, const border_point *enter,
                       const border_point *leave) {
    qni_face_point ends[2];
    qni_trace_memo memo;
    qni_trace found;
    memset(ends, 0, sizeof ends);
    ends[0].line = enter->line;
    ends[1].line = leave->line;
    qni_trace_memo_start(&memo);
    w->job.memo = &memo;
    memcpy(w->job.low, here->low, sizeof here->low);
    memcpy(w->job.high, here->high, sizeof here->high);
    w->job.size = fmax(here->high[0] - here->low[0], here->high[1] - here->low[1]);
    if (!qni_trace_within(&w->job, &ends[0], &ends[1], &found))
        return false;
    w->lost = !append(w->trace, &found);
    return !w->lost;
}

/* How high the step between the only two points of a part is, in shares of its length; of like
 * normals only. */
static double step_of(const walk *w, const part *here) {
    const qni_face_line *a = &here->points[0].line, *b = &here->points[1].line;
    const double *m = a->space_normal, *n = b->space_normal;
    if (m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < w->job.settings->crease_cosine)
        return 0;
    return qni_line_step(&w->job, a, b);
}

/* Is a part to be cut before its trace is asked for? Where a step is in it that is the higher in
 * it the smaller the part: what only curves gets flatter. */
static bool holds_step(const walk *w, const part *here, int cuts, double step, double before) {
    static const double lowest = 0.01, grows = 0.9;
    return w->steps && cuts < MOST_CUTS && here->count == 2 && step > fmax(lowest, grows * before);
}

static int find_from(const part *here, int32_t from) {
    for (int n = 0; n < here->count; ++n)
        if (here->points[n].from == from)
            return n;
    return -1;
}

/* Follow the trace from where it comes into a part to where it leaves it: that point's number; -1
 * when it is lost. */
static int follow(walk *w, const part *whole, int start, int cuts, double step_before) {
    const int before = w->trace->count;
    const double own_step = w->steps && whole->count == 2 ? step_of(w, whole) : step_before;
    if (whole->count == 2 && cuts >= w->least_cuts &&
        !holds_step(w, whole, cuts, own_step, step_before) &&
        trace_part(w, whole, &whole->points[start], &whole->points[1 - start]))
        return 1 - start;
    part halves[2];
    if (w->lost || cuts == MOST_CUTS || ++w->parts > MOST_PARTS || !cut_part(w, whole, halves))
        return -1;
    w->trace->count = before;
    int half = find_from(&halves[0], start) >= 0 ? 0 : 1, at = find_from(&halves[half], start);
    for (int step = 0; step < MOST_STEPS && at >= 0; ++step) {
        const int end = follow(w, &halves[half], at, cuts + 1, own_step);
        if (end < 0)
            return -1;
        const int32_t from = halves[half].points[end].from;
        if (from >= 0)
            return from;
        half = 1 - half;
        at = find_from(&halves[half], from);
    }
    return -1;
}

static bool trace_by_parts(const qni_face_job *job, const qni_face_point *enter,
                           const qni_face_point *leave, int least_cuts, bool steps,
                           qni_trace *trace) {
    part whole = {.low = {job->low[0], job->low[1]}, .high = {job->high[0], job->high[1]}};
    walk w = {*job, trace, least_cuts, steps, 0, false};
    if (job->count > PART_POINTS || job->face->level > LARGEST_LEVEL)
        return false;
    int start = -1, end = -1;
    for (int n = 0; n < job->count; ++n) {
        const qni_face_point *point = &job->points[n];
        const border_point on_border = {point->line, 0, n, point->enters};
        whole.points[whole.count++] = on_border;
        start = point == enter ? n : start;
        end = point == leave ? n : end;
    }
    trace->count = 0;
    trace->lines[0] = enter->line;
    if (start < 0 || follow(&w, &whole, start, 0, 0) != end)
        return false;
    trace->verified = true;
    return true;
}

bool qni_trace_by_parts(const qni_face_job *job, const qni_face_point *enter,
                        const qni_face_point *leave, int least_cuts, qni_trace *trace) {
    return trace_by_parts(job, enter, leave, least_cuts, false, trace);
}

bool qni_trace_step(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace) {
    return trace_by_parts(job, enter, leave, STEP_CUTS, true, trace);
}
