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

enum { STEPS = 6 };

bool qni_pair_is_sharp(const qni_face_job *job, const qni_face_point *a, const qni_face_point *b) {
    const double *m = a->crossing->normal, *n = b->crossing->normal;
    return job->settings->features &&
           m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < job->settings->crease_cosine;
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

static void to_space(const qni_face_job *job, const double at[2], double point[3]) {
    point[job->face->axis] = job->height;
    point[job->p] = at[0];
    point[job->q] = at[1];
}

static bool set_line(const qni_face_job *job, const double at[3], const double normal[3],
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
    double point[3], direction[3] = {0, 0, 0}, at[3], normal[3], foot[2];
    const double distance = hypot(bend[0] - line->at[0], bend[1] - line->at[1]);
    if (!(distance > 1e-9 * job->size))
        return true;
    for (int k = 0; k < 2; ++k)
        foot[k] = line->at[k] + 0.9 * (bend[k] - line->at[k]);
    to_space(job, foot, point);
    direction[job->p] = line->normal[0];
    direction[job->q] = line->normal[1];
    return qni_surface_near(job->solid, point, direction, line->space_normal, 0.3 * distance, at,
                            normal) &&
           set_line(job, at, normal, line);
}

static bool is_within(const qni_face_job *job, const double point[2], double slack) {
    for (int k = 0; k < 2; ++k)
        if (!(point[k] > job->low[k] - slack && point[k] < job->high[k] + slack))
            return false;
    return true;
}

typedef enum bend_kind { BEND_NONE, BEND_SMOOTH, BEND_SHARP } bend_kind;

/* Where two lines meet: each step takes the error of curvature to a hundredth; flat surfaces do not
 * move. What is smooth has no angle left when it is looked at closely. */
static bend_kind find_bend(const qni_face_job *job, const qni_face_line *first,
                           const qni_face_line *second, double bend[2]) {
    qni_face_line a = *first, b = *second;
    const double cell = job->hermite->lattice.cell;
    if (!lines_meet(&a, &b, bend) || !is_within(job, bend, 0.4 * job->size))
        return BEND_NONE;
    for (int step = 0; step < STEPS; ++step) {
        double next[2], guess[2];
        for (int k = 0; k < 2; ++k)
            guess[k] = fmin(fmax(bend[k], job->low[k]), job->high[k]);
        if (!approach(job, &a, guess) || !approach(job, &b, guess))
            return BEND_NONE;
        const double *m = a.space_normal, *n = b.space_normal;
        if (m[0] * n[0] + m[1] * n[1] + m[2] * n[2] >= job->settings->crease_cosine)
            return BEND_SMOOTH;
        if (!lines_meet(&a, &b, next))
            return BEND_NONE;
        const double moved = hypot(next[0] - bend[0], next[1] - bend[1]);
        if (!(moved < job->size))
            return BEND_NONE;
        memcpy(bend, next, sizeof next);
        if (moved < 1e-7 * cell)
            break;
    }
    return is_within(job, bend, 5e-5 * cell) ? BEND_SHARP : BEND_NONE;
}

/* The active branch's tangent at a point of the face; the point's distance from the surface, to
 * first order. */
static bool probe(const qni_face_job *job, const double at[2], qni_face_line *line,
                  double *distance) {
    const qn_solid *solid = job->solid;
    double point[3], value, gradient[3], length = 0;
    to_space(job, at, point);
    if (solid->ops->values(solid, 1, (const double(*)[3])point, &value) != QN_OK ||
        solid->ops->gradients(solid, 1, (const double(*)[3])point, (double(*)[3])gradient,
                              &line->owner) != QN_OK)
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
    double direction[3] = {0, 0, 0}, near[3], normal[3];
    to_space(job, foot, point);
    if (!set_line(job, point, gradient, line))
        return false;
    direction[job->p] = line->normal[0];
    direction[job->q] = line->normal[1];
    const double moved = hypot(foot[0] - at[0], foot[1] - at[1]);
    if (moved > 0 && qni_surface_near(solid, point, direction, gradient, 0.3 * moved, near, normal))
        set_line(job, near, normal, line);
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

/* What the solid says about the first bend that does not hold. */
typedef struct objection {
    int bend; /* -1: all hold */
    double guess[2];
    qni_face_line line;
    bool has_line;
    double distance; /* of the bend from the surface */
} objection;

static void object(const qni_face_job *job, const qni_trace *trace, int n, const double at[2],
                   objection *out) {
    out->bend = n;
    for (int k = 0; k < 2; ++k)
        out->guess[k] = fmin(fmax(at[k], job->low[k]), job->high[k]);
    out->has_line = probe(job, out->guess, &out->line, &out->distance) &&
                    !same_line(job, &out->line, &trace->lines[n]) &&
                    !same_line(job, &out->line, &trace->lines[n + 1]);
}

static void middle_of(const qni_trace *trace, int n, double middle[2]) {
    for (int k = 0; k < 2; ++k)
        middle[k] = 0.5 * (trace->lines[n].at[k] + trace->lines[n + 1].at[k]);
}

/* Find all bends of the chain; smooth ones are taken out. */
static void find_bends(const qni_face_job *job, qni_trace *trace, objection *out) {
    out->bend = -1;
    for (int n = 0; n < trace->count; ++n) {
        double *bend = trace->bends[n], middle[2], met[2];
        const bend_kind kind = find_bend(job, &trace->lines[n], &trace->lines[n + 1], bend);
        if (kind == BEND_SHARP) {
            qni_face_line unused;
            if (!probe(job, bend, &unused, &out->distance) ||
                out->distance <= 1e-6 * job->hermite->lattice.cell)
                continue;
            object(job, trace, n, bend, out);
            return;
        }
        if (kind == BEND_SMOOTH && trace->count == 1)
            continue;
        out->distance = HUGE_VAL;
        middle_of(trace, n, middle);
        const bool meets = lines_meet(&trace->lines[n], &trace->lines[n + 1], met);
        object(job, trace, n, meets ? met : middle, out);
        return;
    }
}

static void insert_line(qni_trace *trace, int bend, const qni_face_line *line) {
    for (int n = trace->count + 1; n > bend + 1; --n)
        trace->lines[n] = trace->lines[n - 1];
    trace->lines[bend + 1] = *line;
    ++trace->count;
}

/* Lines are added until no bend is objected to. `from_middle`: the first is looked for at the middle
 * between the ends. */
static bool grow_chain(const qni_face_job *job, qni_trace *trace, bool from_middle) {
    objection against;
    for (int round = 0;; ++round) {
        find_bends(job, trace, &against);
        if (against.bend < 0)
            return runs_on(job, trace);
        if (round == 0 && from_middle) {
            double middle[2];
            middle_of(trace, against.bend, middle);
            object(job, trace, against.bend, middle, &against);
        }
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
    return find_bend(job, &trace->lines[0], &trace->lines[1], trace->bends[0]) == BEND_SHARP &&
           runs_on(job, trace) && probe(job, trace->bends[0], &unused, &distance) &&
           distance < 0.01 * job->size;
}

bool qni_face_trace(const qni_face_job *job, const qni_face_point *enter,
                    const qni_face_point *leave, qni_trace *trace) {
    double bend[2];
    start_chain(enter, leave, trace);
    if (find_bend(job, &enter->line, &leave->line, bend) == BEND_SMOOTH) {
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
    start_chain(enter, leave, trace);
    if (accept_roughly(job, trace))
        return true;
    trace->count = 0;
    return false;
}
