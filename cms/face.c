// SPDX-License-Identifier: MIT
/* Marching squares on one leaf face [CMS05 3.3]: crossings in cyclic order, paired without
 * crossing, with sharp features.
 *
 * Pure in the face: both cells get the same bits. All that decides on contact is exact, on the
 * coordinates as written. */
#include "cms/face_job.h"
#include "core/cube_hd.h"

#include <math.h>
#include <string.h>

enum { STEP_CUTS = 4 }; /* parts of a quarter of the face */

qni_face qni_face_of_cell(const qni_cell *cell, int face) {
    qni_face result = {{cell->low[0], cell->low[1], cell->low[2]}, cell->level, face >> 1};
    result.low[face >> 1] += face & 1 ? 1 << cell->level : 0;
    return result;
}

static void add_point(qni_face_job *job, const qni_hermite_crossing *crossing, int64_t number,
                      int side) {
    qni_face_point *point = &job->points[job->count++];
    const int axes[2] = {job->p, job->q};
    double position[3];
    qni_crossing_position(crossing, position);
    for (int k = 0; k < 2; ++k)
        point->line.at[k] = position[axes[k]];
    memcpy(point->line.space_normal, crossing->normal, sizeof point->line.space_normal);
    point->line.owner = crossing->owner;
    point->crossing = crossing;
    point->number = (uint32_t)number;
    point->side = (int8_t)side;
    point->enters = side < 2 ? crossing->enters : !crossing->enters;
}

/* The directions of the lines in the face. */
static void aim_lines(qni_face_job *job) {
    for (int n = 0; n < job->count; ++n) {
        const double *normal = job->points[n].crossing->normal;
        double *own = job->points[n].line.normal;
        const double length = hypot(normal[job->p], normal[job->q]);
        own[0] = length > 0 ? normal[job->p] / length : 0;
        own[1] = length > 0 ? normal[job->q] / length : 0;
    }
}

/* The crossings of one finest edge of a side; false when there is no room. */
static bool gather_edge(qni_face_job *job, int side, const int32_t start[3], int axis,
                        qni_last_block *last) {
    const qni_edge_crossings found = qni_hermite_edge_near(job->hermite, start, axis, last);
    if (job->count + found.count > QNI_FACE_POINTS)
        return false;
    for (int m = 0; m < found.count; ++m) {
        const int item = side >= 2 ? found.count - 1 - m : m;
        add_point(job, found.items + item, found.first + item, side);
    }
    return true;
}

/* Sides 0 bottom, 1 right, walked upwards; 2 top, 3 left, walked downwards; by runs that lie in one
 * block. False when there is no room. */
static bool gather_side(qni_face_job *job, int side, qni_last_block *last) {
    const qni_face *face = job->face;
    const int32_t size = 1 << face->level, run = size < QNI_BLOCK ? size : QNI_BLOCK;
    const int axis = side & 1 ? job->q : job->p, other = side & 1 ? job->p : job->q;
    int32_t point[3] = {face->low[0], face->low[1], face->low[2]};
    point[other] += side == 1 || side == 2 ? size : 0;
    const int32_t low = point[axis];
    for (int32_t from = 0; from < size; from += run) {
        const int32_t first = low + (side >= 2 ? size - run - from : from);
        point[axis] = first;
        unsigned crossed = qni_hermite_run(job->hermite, point, axis, run, last);
        while (crossed) {
            const int n = side >= 2 ? 31 - __builtin_clz(crossed) : __builtin_ctz(crossed);
            crossed &= ~(1U << n);
            point[axis] = first + n;
            if (!gather_edge(job, side, point, axis, last))
                return false;
        }
    }
    return true;
}

static bool alternates(const qni_face_job *job) {
    for (int n = 0; n < job->count; ++n)
        if (job->points[n].enters == job->points[(n + 1) % job->count].enters)
            return false;
    return true;
}

/* ---- segments ---------------------------------------------------------------------------------
 */

static qni_face_feature *add_feature(const qni_face_job *job, qni_face_solution *solution,
                                     qni_segment *segment, const float at[2], bool sharp) {
    qni_face_feature *feature = &solution->features[solution->feature_count];
    memset(feature, 0, sizeof *feature);
    const int axis = job->face->axis;
    feature->place[axis] = (float)job->height;
    feature->place[job->p] = at[0];
    feature->place[job->q] = at[1];
    feature->sharp = sharp;
    segment->feature = segment->bends++ ? segment->feature : (uint32_t)solution->feature_count;
    ++solution->feature_count;
    return feature;
}

/* How far from a point of one side the surface is, straight across the face; `most` when it is
 * farther. */
static double depth_of_trace(const qni_face_job *job, const double at[2], int across, bool from_low,
                             double most) {
    double end[2] = {at[0], at[1]}, a[3], b[3];
    qni_crossing found[1];
    int32_t count = 0;
    end[across] += from_low ? most : -most;
    qni_face_to_space(job, at, a);
    qni_face_to_space(job, end, b);
    const qn_status status = job->solid->ops->crossings(job->solid, a, b, 1, found, &count);
    return status == QN_OK && count > 0 ? most * found[0].at : most;
}

/* A segment between two crossings of one side would lie in the edge: it bends into the face, to
 * where the surface is, and the less the shorter it is, so that nested ones stay apart. */
static void add_bend(const qni_face_job *job, qni_face_solution *solution, qni_segment *segment,
                     const qni_face_point *a, const qni_face_point *b, double share) {
    const int side = a->side, along = side & 1, across = 1 - along;
    const bool from_low = side == 0 || side == 3;
    double at[2], depth = share * fabs(a->line.at[along] - b->line.at[along]);
    at[along] = 0.5 * (a->line.at[along] + b->line.at[along]);
    at[across] = from_low ? job->low[across] : job->high[across];
    if (job->settings->features && !job->settings->scalar)
        depth = depth_of_trace(job, at, across, from_low, depth);
    at[across] += from_low ? depth : -depth;
    const float inside[2] = {qni_between(at[0], job->low_float[0], job->high_float[0]),
                             qni_between(at[1], job->low_float[1], job->high_float[1])};
    add_feature(job, solution, segment, inside, false);
}

/* The sharp features of a pair. Where there are several, a plane lies between two of them that no
 * crossing knows: they do. */
static void add_sharp(const qni_face_job *job, qni_face_solution *solution, qni_segment *segment,
                      const qni_trace *trace) {
    for (int n = 0; n < trace->count; ++n) {
        float at[2];
        for (int k = 0; k < 2; ++k)
            at[k] = qni_between(trace->bends[n][k], job->low_float[k], job->high_float[k]);
        qni_face_feature *feature = add_feature(job, solution, segment, at, true);
        if (trace->count == 1)
            break;
        const qni_face_line *line = &trace->lines[n + 1 < trace->count ? n + 1 : n];
        memcpy(feature->normal, line->space_normal, sizeof feature->normal);
        feature->at[job->face->axis] = job->height;
        feature->at[job->p] = line->at[0];
        feature->at[job->q] = line->at[1];
        feature->owner = line->owner;
        feature->has_plane = true;
    }
}

static const double high_step = 0.5; /* 30 degrees */

/* The trace of a pair, if it needs one; false when that is not found. */
static bool trace_pair(const qni_face_job *job, const qni_face_point *enter,
                       const qni_face_point *leave, qni_trace *trace) {
    trace->count = 0;
    if (!job->settings->features || (job->closely && qni_trace_step(job, enter, leave, trace)))
        return true;
    if (qni_pair_is_sharp(job, enter, leave))
        return qni_face_trace(job, enter, leave, trace);
    if (job->closely || qni_pair_step(job, enter, leave) <= high_step ||
        !qni_trace_by_parts(job, enter, leave, STEP_CUTS, trace))
        trace->count = 0;
    return true;
}

/* Segments of the pairing; `with_features` also the sharp ones. Tells how many features escaped. */
static void make_segments(const qni_face_job *job, qni_face_solution *solution, bool with_features,
                          double bend_share) {
    solution->count = solution->feature_count = 0;
    solution->dropped = 0;
    for (int n = 0; n < job->count; ++n) {
        const qni_face_point *enter = &job->points[n], *leave = &job->points[job->partner[n]];
        if (!enter->enters)
            continue;
        qni_segment *segment = &solution->segments[solution->count++];
        const qni_segment plain = {.from = enter->number, .to = leave->number};
        *segment = plain;
        bool missing = qni_pair_is_sharp(job, enter, leave);
        if (with_features) {
            qni_trace trace;
            missing = !trace_pair(job, enter, leave, &trace);
            add_sharp(job, solution, segment, &trace);
        }
        if (segment->bends == 0 && enter->side == leave->side)
            add_bend(job, solution, segment, enter, leave, bend_share);
        segment->dropped = missing;
        solution->dropped += missing;
    }
}

/* Features first; where they make segments touch, chords, which cannot, with ever flatter bends. */
static bool solve_pairing(const qni_face_job *job, qni_face_solution *solution) {
    make_segments(job, solution, true, 0.5);
    if (!qni_segments_touch(job, solution))
        return true;
    double share = 0.5;
    for (int attempt = 0; attempt < 12; ++attempt, share *= 0.25) {
        make_segments(job, solution, false, share);
        if (!qni_segments_touch(job, solution))
            return false;
    }
    solution->unresolved = true;
    return false;
}

/* The Hermite rule: of two pairings the one whose features do not cross; else the one whose
 * tangents clearly fit; else by the values at the corners. */
static bool outside_joins_by_features(qni_face_job *job, qni_face_solution *solution, int apart) {
    double cost[2];
    bool clean[2];
    for (int way = 0; way < 2; ++way) {
        qni_pair_neighbors(job, way == 0 ? apart : 1 - apart);
        clean[way] = solve_pairing(job, solution);
        cost[way] = qni_pairing_cost(job);
    }
    const double size = job->high[0] - job->low[0], slack = 1e-9 * size;
    if (clean[0] != clean[1])
        return clean[0];
    if (2 * cost[0] + slack < cost[1])
        return true;
    if (2 * cost[1] + slack < cost[0])
        return false;
    return qni_outside_is_joined(job);
}

/* Samples have their own rule; a solid is asked, and only where it does not show which pairing is
 * right the features are. */
static void solve_ambiguous(qni_face_job *job, qni_face_solution *solution) {
    const int apart = job->points[0].enters ? 0 : 1; /* cuts off the inside arcs */
    bool outside;
    if (job->settings->scalar && job->face->level == 0)
        outside = qni_outside_is_joined(job);
    else if (!job->settings->features || !qni_face_joins(job, &outside))
        outside = outside_joins_by_features(job, solution, apart);
    qni_pair_neighbors(job, outside ? apart : 1 - apart);
    solution->unresolved = false;
    solve_pairing(job, solution);
}

/* Two crossings, as most faces have that have any, with a chord that nothing speaks against. */
static bool solve_plain(const qni_face_job *job, qni_face_solution *solution) {
    const qni_face_point *enter = &job->points[job->points[0].enters ? 0 : 1],
                         *leave = &job->points[job->points[0].enters ? 1 : 0];
    if (job->count != 2 || job->closely || enter->side == leave->side ||
        qni_pair_is_sharp(job, enter, leave) ||
        (job->settings->features && !(qni_pair_step(job, enter, leave) <= high_step)))
        return false;
    const qni_segment chord = {.from = enter->number, .to = leave->number};
    solution->segments[solution->count++] = chord;
    return true;
}

void qni_solve_face(const qni_hermite *hermite, const qn_solid *solid,
                    const qni_cms_settings *settings, const qni_face *face, bool closely,
                    qni_face_solution *solution) {
    qni_face_job job;
    qni_trace_memo memo;
    qni_trace_memo_start(&memo);
    job.memo = &memo;
    job.hermite = hermite;
    job.solid = solid;
    job.settings = settings;
    job.face = face;
    job.closely = closely;
    job.p = face->axis == 0 ? 1 : 0;
    job.q = face->axis == 2 ? 1 : 2;
    job.count = 0;
    solution->count = solution->feature_count = solution->dropped = 0;
    solution->ambiguous = solution->unresolved = solution->broken = false;
    qni_last_block last = QNI_NO_LAST_BLOCK;
    for (int side = 0; side < 4; ++side)
        if (!gather_side(&job, side, &last)) {
            solution->broken = true;
            return;
        }
    if (job.count == 0)
        return;
    solution->broken = !alternates(&job);
    if (solution->broken || solve_plain(&job, solution))
        return;
    aim_lines(&job);
    for (int k = 0; k < 2; ++k) {
        const int axis = k ? job.q : job.p;
        job.low[k] = qni_lattice_at(&hermite->lattice, axis, face->low[axis]);
        job.high[k] = qni_lattice_at(&hermite->lattice, axis, face->low[axis] + (1 << face->level));
        job.low_float[k] = (float)(job.low[k] + hermite->lattice.clearance);
        job.high_float[k] = (float)(job.high[k] - hermite->lattice.clearance);
    }
    job.height = qni_lattice_at(&hermite->lattice, face->axis, face->low[face->axis]);
    job.size = job.high[0] - job.low[0];
    solution->ambiguous = job.count > 2;
    if (job.count == 4) {
        solve_ambiguous(&job, solution);
        return;
    }
    if (job.count == 2)
        qni_pair_neighbors(&job, 0);
    else
        qni_pair_by_cost(&job);
    solve_pairing(&job, solution);
}
