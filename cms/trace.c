// SPDX-License-Identifier: MIT
/* The trace of the surface on a face between two crossings whose normals differ: a chain of tangent
 * lines that meet in bends.
 *
 * It begins with the tangents of the two ends. Where a bend is not on the surface, the branch that
 * is active there gives one more line to go between: for a convex piece that is the plane that cuts
 * the bend off. Bends of curved surfaces are met again with tangents taken close to them. All of it
 * asks the solid only, about points of the face only. */
#include "cms/face_job.h"

#include <math.h>
#include <string.h>

enum { STEPS = 24 };

bool qni_pair_is_sharp(const qni_face_job *job, const qni_face_point *a, const qni_face_point *b) {
    const double *m = a->crossing->normal, *n = b->crossing->normal;
    return job->settings->features &&
           qni_is_crease(job->settings, m[0] * n[0] + m[1] * n[1] + m[2] * n[2], a->crossing->owner,
                         b->crossing->owner);
}

double qni_line_step(const qni_face_job *job, const qni_face_line *a, const qni_face_line *b) {
    const double way[2] = {b->at[0] - a->at[0], b->at[1] - a->at[1]};
    const double *m = a->space_normal, *n = b->space_normal,
                 over_a = m[job->p] * way[0] + m[job->q] * way[1],
                 over_b = -(n[job->p] * way[0] + n[job->q] * way[1]);
    return over_a * over_b < 0 ? fmax(fabs(over_a), fabs(over_b)) / hypot(way[0], way[1]) : 0;
}

double qni_pair_step(const qni_face_job *job, const qni_face_point *a, const qni_face_point *b) {
    return qni_line_step(job, &a->line, &b->line);
}

static bool lines_meet(const qni_face_line *a, const qni_face_line *b, double out[2]) {
    const double determinant = a->normal[0] * b->normal[1] - a->normal[1] * b->normal[0];
    if (!(fabs(determinant) > 1e-7))
        return false;
    const double m = qni_dot2(a->normal, a->at), n = qni_dot2(b->normal, b->at);
    out[0] = (m * b->normal[1] - n * a->normal[1]) / determinant;
    out[1] = (n * a->normal[0] - m * b->normal[0]) / determinant;
    return isfinite(out[0]) && isfinite(out[1]);
}

void qni_face_to_space(const qni_face_job *job, const double at[2], double point[3]) {
    point[job->face->axis] = job->height;
    point[job->p] = at[0];
    point[job->q] = at[1];
}

bool qni_face_set_line(const qni_face_job *job, const double at[3], const double normal[3],
                       qni_face_line *line) {
    const double length = hypot(normal[job->p], normal[job->q]);
    if (!(length > 1e-6))
        return false;
    line->at[0] = at[job->p];
    line->at[1] = at[job->q];
    line->normal[0] = normal[job->p] / length;
    line->normal[1] = normal[job->q] / length;
    memcpy(line->space_normal, normal, sizeof line->space_normal);
    return true;
}

/* The tangent again, most of the way towards the bend. */
static bool approach(const qni_face_job *job, qni_face_line *line, const double bend[2]) {
    double point[3], direction[3] = {0, 0, 0}, foot[2];
    qni_tangent from, to;
    const double distance = hypot(bend[0] - line->at[0], bend[1] - line->at[1]);
    if (!(distance > 1e-9 * job->size))
        return true;
    for (int k = 0; k < 2; ++k)
        foot[k] = line->at[k] + 0.9 * (bend[k] - line->at[k]);
    qni_face_to_space(job, foot, point);
    direction[job->p] = line->normal[0];
    direction[job->q] = line->normal[1];
    qni_face_to_space(job, line->at, from.at);
    memcpy(from.normal, line->space_normal, sizeof from.normal);
    from.owner = line->owner;
    return qni_surface_along(job->solid, job->settings, &from, point, direction, 0.3 * distance,
                             &to) &&
           qni_face_set_line(job, to.at, to.normal, line);
}

static bool is_within(const qni_face_job *job, const double point[2], double slack) {
    for (int k = 0; k < 2; ++k)
        if (!(point[k] > job->low[k] - slack && point[k] < job->high[k] + slack))
            return false;
    return true;
}

/* How far one can go from a point of the face before leaving it. */
static double room(const qni_face_job *job, const double from[2], const double way[2]) {
    double most = HUGE_VAL;
    for (int k = 0; k < 2; ++k)
        if (way[k] != 0)
            most = fmin(most, ((way[k] > 0 ? job->high[k] : job->low[k]) - from[k]) / way[k]);
    return fmax(most, 0);
}

/* The trace halfway between two of its points: next to the middle of their chord, straight across
 * it; only where it has the solid on the same side. */
static bool sample_between(const qni_face_job *job, const qni_face_line *a, const qni_face_line *b,
                           qni_face_line *out) {
    const double chord[2] = {b->at[0] - a->at[0], b->at[1] - a->at[1]};
    const double length = hypot(chord[0], chord[1]);
    if (!(length > 1e-9 * job->size))
        return false;
    const double out_of_solid[2] = {-chord[1] / length, chord[0] / length},
                 into_solid[2] = {-out_of_solid[0], -out_of_solid[1]};
    double middle[2], ends[2][2], points[2][3], best = HUGE_VAL, reach[2];
    for (int k = 0; k < 2; ++k) /* the sum of two coordinates within bounds can round beyond them */
        middle[k] = fmin(fmax(0.5 * (a->at[k] + b->at[k]), job->low[k]), job->high[k]);
    reach[0] = room(job, middle, into_solid);
    reach[1] = room(job, middle, out_of_solid);
    for (int n = 0; n < 2; ++n) {
        for (int k = 0; k < 2; ++k)
            ends[n][k] = middle[k] + (n ? reach[1] : -reach[0]) * out_of_solid[k];
        qni_face_to_space(job, ends[n], points[n]);
    }
    qni_crossing found[8];
    int32_t count = 0;
    if (!(reach[0] + reach[1] > 0) ||
        job->solid->ops->crossings(job->solid, points[0], points[1], 8, found, &count) != QN_OK)
        return false;
    for (int32_t n = 0; n < count && n < 8; ++n) {
        const double off = fabs(found[n].at * (reach[0] + reach[1]) - reach[0]);
        double at[3];
        for (int k = 0; k < 3; ++k)
            at[k] = points[0][k] + found[n].at * (points[1][k] - points[0][k]);
        if (!found[n].enters && off < best && qni_face_set_line(job, at, found[n].normal, out)) {
            best = off;
            out->owner = found[n].owner;
        }
    }
    return best < HUGE_VAL;
}

static double likeness(const qni_face_line *a, const qni_face_line *b) {
    const double *m = a->space_normal, *n = b->space_normal;
    return m[0] * n[0] + m[1] * n[1] + m[2] * n[2];
}

static bool parts(const qni_face_job *job, const qni_face_line *a, const qni_face_line *b) {
    return qni_is_crease(job->settings, likeness(a, b), a->owner, b->owner);
}

/* Which of two lines is the one between them like, the first? By its owner, where theirs differ. */
static bool is_like_first(const qni_face_line *between, const qni_face_line *a,
                          const qni_face_line *b) {
    if (a->owner != b->owner && (between->owner == a->owner || between->owner == b->owner))
        return between->owner == a->owner;
    return likeness(between, a) > likeness(between, b);
}

bool qni_pair_is_plain(const qni_face_job *job, const qni_face_point *enter,
                       const qni_face_point *leave) {
    const double *from = enter->line.at, *to = leave->line.at;
    const double way[2] = {to[0] - from[0], to[1] - from[1]}, length = hypot(way[0], way[1]);
    qni_face_line middle;
    if (!qni_runs_rightly(from, to, enter->line.normal) ||
        !qni_runs_rightly(from, to, leave->line.normal))
        return false;
    if (fabs(qni_dot2(way, enter->line.normal)) + fabs(qni_dot2(way, leave->line.normal)) <
        1e-9 * length)
        return true;
    if (!sample_between(job, &enter->line, &leave->line, &middle))
        return false;
    const double off[2] = {middle.at[0] - 0.5 * (from[0] + to[0]),
                           middle.at[1] - 0.5 * (from[1] + to[1])};
    return hypot(off[0], off[1]) < 0.5 * length && !parts(job, &middle, &enter->line) &&
           !parts(job, &middle, &leave->line);
}

/* BEND_PARTED: another sheet lies between. */
typedef enum bend_kind { BEND_NONE, BEND_PARTED, BEND_SMOOTH, BEND_SHARP } bend_kind;

/* One step of both tangents towards where they meet. */
static bool step_closer(const qni_face_job *job, qni_face_line *a, qni_face_line *b,
                        double bend[2]) {
    qni_face_line closer[2] = {*a, *b};
    double met[2], guess[2];
    if (!lines_meet(a, b, met) || !is_within(job, met, 0.4 * job->size))
        return false;
    for (int k = 0; k < 2; ++k)
        guess[k] = fmin(fmax(met[k], job->low[k]), job->high[k]);
    if (!approach(job, &closer[0], guess) || !approach(job, &closer[1], guess))
        return false;
    *a = closer[0];
    *b = closer[1];
    if (parts(job, a, b) && !lines_meet(a, b, met))
        return false;
    memcpy(bend, met, sizeof met);
    return true;
}

/* Where two lines meet: each step takes the error of curvature to a hundredth; flat surfaces do not
 * move. Where the surface curves too much for that, the way between is halved. What is smooth has
 * no angle left when it is looked at closely. */
static bend_kind look_for_bend(const qni_face_job *job, const qni_face_line *first,
                               const qni_face_line *second, double bend[2],
                               qni_face_line *between) {
    qni_face_line a = *first, b = *second;
    const double cell = job->hermite->lattice.cell;
    double last[2] = {HUGE_VAL, HUGE_VAL};
    for (int step = 0; step < STEPS; ++step) {
        if (step_closer(job, &a, &b, bend)) {
            if (!parts(job, &a, &b))
                return BEND_SMOOTH;
            const double moved = hypot(bend[0] - last[0], bend[1] - last[1]);
            memcpy(last, bend, sizeof last);
            if (moved < 1e-7 * cell)
                return is_within(job, bend, 5e-5 * cell) ? BEND_SHARP : BEND_NONE;
            continue;
        }
        if (!sample_between(job, &a, &b, between))
            return BEND_NONE;
        if (parts(job, between, &a) && parts(job, between, &b))
            return BEND_PARTED;
        if (is_like_first(between, &a, &b))
            a = *between;
        else
            b = *between;
        if (!parts(job, &a, &b))
            return BEND_SMOOTH;
    }
    return BEND_NONE;
}

static bend_kind find_bend(const qni_face_job *job, const qni_face_line *first,
                           const qni_face_line *second, double bend[2], qni_face_line *between) {
    const qni_memo_bend *known = qni_memo_find_bend(job->memo, first, second);
    if (!known) {
        qni_memo_bend *fresh = qni_memo_add_bend(job->memo);
        memset(fresh, 0, sizeof *fresh);
        fresh->first = *first;
        fresh->second = *second;
        fresh->kind = (int)look_for_bend(job, first, second, fresh->bend, &fresh->between);
        known = fresh;
    }
    memcpy(bend, known->bend, sizeof known->bend);
    *between = known->between;
    return (bend_kind)known->kind;
}

/* The active branch's tangent at a point of the face; the point's distance from the surface, to
 * first order. */
static bool probe(const qni_face_job *job, const double at[2], qni_face_line *line,
                  double *distance) {
    const qn_solid *solid = job->solid;
    double point[3], value, gradient[3], length = 0;
    qni_face_to_space(job, at, point);
    if (qni_solid_first_order(solid, point, &value, gradient, &line->owner) != QN_OK)
        return false;
    for (int k = 0; k < 3; ++k)
        length += gradient[k] * gradient[k];
    length = sqrt(length);
    *distance = fabs(value) / length;
    const double in_face = hypot(gradient[job->p], gradient[job->q]);
    if (!isfinite(length) || !(in_face > 1e-6 * length))
        return false;
    for (int k = 0; k < 3; ++k)
        gradient[k] /= length;
    double foot[2] = {at[0] - value * gradient[job->p] * length / (in_face * in_face),
                      at[1] - value * gradient[job->q] * length / (in_face * in_face)};
    double direction[3] = {0, 0, 0};
    qni_tangent near;
    qni_face_to_space(job, foot, point);
    if (!qni_face_set_line(job, point, gradient, line))
        return false;
    direction[job->p] = line->normal[0];
    direction[job->q] = line->normal[1];
    const double moved = hypot(foot[0] - at[0], foot[1] - at[1]);
    if (moved > 0 && qni_surface_near(solid, point, direction, gradient, 0.3 * moved, &near))
        qni_face_set_line(job, near.at, near.normal, line);
    return true;
}

static bool same_line(const qni_face_job *job, const qni_face_line *a, const qni_face_line *b) {
    const double way[2] = {a->at[0] - b->at[0], a->at[1] - b->at[1]};
    return qni_dot2(a->normal, b->normal) > 1 - 1e-12 &&
           fabs(qni_dot2(way, a->normal)) < 1e-7 * job->size;
}

/* Do the pieces between bends run the way that their lines say? A bend can be too near to an end to
 * tell a direction. */
static bool runs_on(const qni_face_job *job, const qni_trace *trace) {
    const double near = 1e-3 * job->size;
    for (int n = 0; n <= trace->count; ++n) {
        const double *from = n ? trace->bends[n - 1] : trace->lines[0].at,
                     *to = n < trace->count ? trace->bends[n] : trace->lines[n].at;
        const bool tiny = (n == 0 || n == trace->count) &&
                          fmax(fabs(to[0] - from[0]), fabs(to[1] - from[1])) <= near;
        if (!tiny && !qni_runs_rightly(from, to, trace->lines[n].normal))
            return false;
    }
    return true;
}

/* The first bend that does not hold, and a line to go there. */
typedef struct objection {
    int bend; /* -1: all hold */
    qni_face_line line;
    bool has_line;
} objection;

static bool is_new_line(const qni_face_job *job, const qni_trace *trace, int n,
                        const qni_face_line *line) {
    return !same_line(job, line, &trace->lines[n]) && !same_line(job, line, &trace->lines[n + 1]);
}

/* By the branch that is active at a point, or by the trace halfway. */
static void object(const qni_face_job *job, const qni_trace *trace, int n, const double *at,
                   objection *out) {
    double guess[2], distance;
    out->bend = n;
    for (int k = 0; k < 2 && at; ++k)
        guess[k] = fmin(fmax(at[k], job->low[k]), job->high[k]);
    out->has_line =
        (at ? probe(job, guess, &out->line, &distance)
            : sample_between(job, &trace->lines[n], &trace->lines[n + 1], &out->line)) &&
        is_new_line(job, trace, n, &out->line);
}

/* Find all bends of the chain. */
static void find_bends(const qni_face_job *job, qni_trace *trace, bool halfway, objection *out) {
    out->bend = -1;
    for (int n = 0; n < trace->count; ++n) {
        double *bend = trace->bends[n], distance;
        qni_face_line unused;
        const bend_kind kind =
            find_bend(job, &trace->lines[n], &trace->lines[n + 1], bend, &out->line);
        if (kind == BEND_PARTED) {
            out->bend = n;
            out->has_line = true;
            return;
        }
        if (kind == BEND_SHARP && (!probe(job, bend, &unused, &distance) ||
                                   distance <= 1e-6 * job->hermite->lattice.cell))
            continue;
        object(job, trace, n, kind == BEND_SHARP && !halfway ? bend : NULL, out);
        if (!out->has_line && lines_meet(&trace->lines[n], &trace->lines[n + 1], bend))
            object(job, trace, n, bend, out);
        return;
    }
}

static void insert_line(qni_trace *trace, int bend, const qni_face_line *line) {
    for (int n = trace->count + 1; n > bend + 1; --n)
        trace->lines[n] = trace->lines[n - 1];
    trace->lines[bend + 1] = *line;
    ++trace->count;
}

/* Lines are added until no bend is objected to. */
static bool grow_chain(const qni_face_job *job, qni_trace *trace, bool halfway) {
    objection against;
    for (;;) {
        find_bends(job, trace, halfway, &against);
        if (against.bend < 0)
            return runs_on(job, trace);
        if (!against.has_line || trace->count == QNI_MOST_BENDS)
            return false;
        insert_line(trace, against.bend, &against.line);
    }
}

static void start_chain(const qni_face_point *enter, const qni_face_point *leave,
                        qni_trace *trace) {
    trace->count = 1;
    trace->lines[0] = enter->line;
    trace->lines[1] = leave->line;
}

/* One bend though the solid does not quite agree: gradients that are not exact. */
static bool accept_roughly(const qni_face_job *job, qni_trace *trace) {
    qni_face_line unused;
    double distance;
    return find_bend(job, &trace->lines[0], &trace->lines[1], trace->bends[0], &unused) ==
               BEND_SHARP &&
           runs_on(job, trace) && probe(job, trace->bends[0], &unused, &distance) &&
           distance < 0.01 * job->size;
}

/* Flat pieces that meet in one bend, as most do: their tangents say all. */
static bool trace_flat(const qni_face_job *job, const qni_face_point *enter,
                       const qni_face_point *leave, qni_trace *trace) {
    const double cell = job->hermite->lattice.cell;
    double bend[3], from[2][3];
    start_chain(enter, leave, trace);
    if (!parts(job, &enter->line, &leave->line) ||
        !lines_meet(&enter->line, &leave->line, trace->bends[0]) ||
        !is_within(job, trace->bends[0], 5e-5 * cell) || !runs_on(job, trace))
        return false;
    qni_face_to_space(job, trace->bends[0], bend);
    qni_face_to_space(job, enter->line.at, from[0]);
    qni_face_to_space(job, leave->line.at, from[1]);
    trace->verified =
        qni_flat_pieces_meet(job->solid, bend, 2, (const double(*)[3])from, 1e-8 * cell);
    return trace->verified;
}

bool qni_trace_within(const qni_face_job *job, const qni_face_point *enter,
                      const qni_face_point *leave, qni_trace *trace) {
    double bend[2];
    qni_face_line unused;
    if (trace_flat(job, enter, leave, trace))
        return true;
    if (find_bend(job, &enter->line, &leave->line, bend, &unused) == BEND_SMOOTH) {
        trace->count = 0;
        trace->verified = true;
        return true;
    }
    for (int way = 0; way < 2; ++way) {
        start_chain(enter, leave, trace);
        trace->verified = grow_chain(job, trace, way == 1);
        if (trace->verified)
            return true;
    }
    trace->count = 0;
    return false;
}

bool qni_trace_pair(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace) {
    if (qni_trace_within(job, enter, leave, trace) ||
        qni_trace_by_parts(job, enter, leave, 0, trace))
        return true;
    start_chain(enter, leave, trace);
    if (accept_roughly(job, trace))
        return true;
    trace->count = 0;
    return false;
}
