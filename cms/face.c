// SPDX-License-Identifier: MIT
/* Marching squares on one leaf face [CMS05 3.3]: crossings in cyclic order, paired without
 * crossing, with sharp features.
 *
 * Pure in the face: both cells get the same bits. All that decides on contact is exact, on the
 * coordinates as written. */
#include "cms/cms.h"
#include "face/face_hd.h"
#include "core/cube_hd.h"
#include "mesh/predicates.h"

#include <math.h>
#include <string.h>

/* A crossing on the face's boundary. */
typedef struct face_point {
    double at[2], normal[2],
        length; /* in the face's axes; normal of unit length in the face, `length` of it in space */
    const qni_hermite_crossing *crossing;
    uint32_t number;
    int8_t side;
    bool enters; /* walking counter-clockwise */
} face_point;

typedef struct face_job {
    const qni_hermite *hermite;
    const qn_solid *solid;
    const qni_cms_settings *settings;
    const qni_face *face;
    int p, q; /* the face's axes */
    double low[2], high[2];
    float low_float[2], high_float[2];
    face_point points[QNI_FACE_POINTS];
    int count;
    int partner[QNI_FACE_POINTS];
} face_job;

qni_face qni_face_of_cell(const qni_cell *cell, int face) {
    qni_face result = {{cell->low[0], cell->low[1], cell->low[2]}, cell->level, face >> 1};
    result.low[face >> 1] += face & 1 ? 1 << cell->level : 0;
    return result;
}

static void add_point(face_job *job, const qni_hermite_crossing *crossing, int64_t number,
                      int side) {
    face_point *point = &job->points[job->count++];
    double position[3];
    qni_crossing_position(crossing, position);
    point->at[0] = position[job->p];
    point->at[1] = position[job->q];
    point->length = hypot(crossing->normal[job->p], crossing->normal[job->q]);
    for (int k = 0; k < 2; ++k)
        point->normal[k] =
            point->length > 0 ? crossing->normal[k ? job->q : job->p] / point->length : 0;
    point->crossing = crossing;
    point->number = (uint32_t)number;
    point->side = (int8_t)side;
    point->enters = side < 2 ? crossing->enters : !crossing->enters;
}

/* Sides 0 bottom, 1 right, walked upwards; 2 top, 3 left, walked downwards. False when there is no
 * room. */
static bool gather_side(face_job *job, int side) {
    const qni_face *face = job->face;
    const int32_t size = 1 << face->level;
    const int axis = side & 1 ? job->q : job->p, other = side & 1 ? job->p : job->q;
    int32_t point[3] = {face->low[0], face->low[1], face->low[2]};
    point[other] += side == 1 || side == 2 ? size : 0;
    const bool down = side >= 2;
    for (int32_t n = 0; n < size; ++n) {
        int32_t start[3] = {point[0], point[1], point[2]};
        start[axis] += down ? size - 1 - n : n;
        const qni_edge_crossings found = qni_hermite_edge(job->hermite, start, axis);
        if (job->count + found.count > QNI_FACE_POINTS)
            return false;
        for (int m = 0; m < found.count; ++m) {
            const int item = down ? found.count - 1 - m : m;
            add_point(job, found.items + item, found.first + item, side);
        }
    }
    return true;
}

static bool alternates(const face_job *job) {
    for (int n = 0; n < job->count; ++n)
        if (job->points[n].enters == job->points[(n + 1) % job->count].enters)
            return false;
    return true;
}

/* ---- features of one pair
 * ------------------------------------------------------------------------ */

static double dot2(const double a[2], const double b[2]) {
    return a[0] * b[0] + a[1] * b[1];
}

/* Does the way from -> to have the solid on its right, as the normal there says? */
static bool runs_rightly(const double from[2], const double to[2], const double normal[2]) {
    return normal[1] * (to[0] - from[0]) - normal[0] * (to[1] - from[1]) > 0;
}

static bool is_sharp(const face_job *job, const face_point *a, const face_point *b) {
    const double *m = a->crossing->normal, *n = b->crossing->normal;
    return job->settings->features &&
           m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < job->settings->crease_cosine;
}

typedef struct tangent {
    double at[2], normal[2], space_normal[3];
} tangent;

static tangent tangent_at(const face_point *point) {
    tangent t;
    memcpy(t.at, point->at, sizeof t.at);
    memcpy(t.normal, point->normal, sizeof t.normal);
    memcpy(t.space_normal, point->crossing->normal, sizeof t.space_normal);
    return t;
}

static bool tangents_meet(const tangent *a, const tangent *b, double out[2]) {
    const double determinant = a->normal[0] * b->normal[1] - a->normal[1] * b->normal[0];
    if (!(fabs(determinant) > 1e-7))
        return false;
    const double m = dot2(a->normal, a->at), n = dot2(b->normal, b->at);
    out[0] = (m * b->normal[1] - n * a->normal[1]) / determinant;
    out[1] = (n * a->normal[0] - m * b->normal[0]) / determinant;
    return isfinite(out[0]) && isfinite(out[1]);
}

/* The tangent again, most of the way towards the feature. */
static void approach(const face_job *job, tangent *t, const double feature[2]) {
    double point[3], direction[3] = {0, 0, 0}, at[3], normal[3];
    const int axes[2] = {job->p, job->q};
    const double distance = hypot(feature[0] - t->at[0], feature[1] - t->at[1]);
    point[job->face->axis] =
        qni_lattice_at(&job->hermite->lattice, job->face->axis, job->face->low[job->face->axis]);
    for (int k = 0; k < 2; ++k) {
        point[axes[k]] = t->at[k] + 0.9 * (feature[k] - t->at[k]);
        direction[axes[k]] = t->normal[k];
    }
    const double in_face = hypot(t->space_normal[job->p], t->space_normal[job->q]);
    if (!(distance > 0) || !(in_face > 0.3) ||
        !qni_surface_near(job->solid, point, direction, 0.3 * distance, at, normal))
        return;
    const double length = hypot(normal[job->p], normal[job->q]);
    for (int k = 0; k < 2; ++k) {
        t->at[k] = at[axes[k]];
        t->normal[k] = normal[axes[k]] / length;
    }
    memcpy(t->space_normal, normal, sizeof normal);
}

/* Two steps square the error of curvature twice; flat surfaces do not move. */
static void refine_feature(const face_job *job, const face_point *enter, const face_point *leave,
                           double feature[2]) {
    tangent a = tangent_at(enter), b = tangent_at(leave);
    const double size = job->high[0] - job->low[0];
    for (int step = 0; step < 4; ++step) {
        double next[2], guess[2];
        for (int k = 0; k < 2; ++k)
            guess[k] = fmin(fmax(feature[k], job->low[k]), job->high[k]);
        approach(job, &a, guess);
        approach(job, &b, guess);
        if (!tangents_meet(&a, &b, next) ||
            hypot(next[0] - feature[0], next[1] - feature[1]) > size)
            return;
        const double moved = hypot(next[0] - feature[0], next[1] - feature[1]);
        memcpy(feature, next, sizeof next);
        if (moved < 1e-7 * size)
            return;
    }
}

static bool is_within(const face_job *job, const double point[2], double slack) {
    for (int k = 0; k < 2; ++k) {
        const double room = slack * (job->high[k] - job->low[k]);
        if (!(point[k] > job->low[k] - room && point[k] < job->high[k] + room))
            return false;
    }
    return true;
}

/* Where the tangents of a pair meet, as a float strictly inside the face. A point that escapes by
 * less than a thousandth of the face is rounding or curvature and is put back; more means that it
 * is no feature of this pair. */
static bool feature_of(const face_job *job, const face_point *enter, const face_point *leave,
                       float out[2]) {
    const double *m = enter->normal, *n = leave->normal;
    const tangent a = tangent_at(enter), b = tangent_at(leave);
    double point[2];
    if (!tangents_meet(&a, &b, point) || !is_within(job, point, 0.4))
        return false;
    refine_feature(job, enter, leave, point);
    if (!is_within(job, point, 1e-3))
        return false;
    const double near =
        1e-3 * (job->high[0] - job->low[0]); /* too near to an end to tell a direction */
    const double to_enter = fmax(fabs(point[0] - enter->at[0]), fabs(point[1] - enter->at[1]));
    const double to_leave = fmax(fabs(point[0] - leave->at[0]), fabs(point[1] - leave->at[1]));
    if ((to_enter > near && !runs_rightly(enter->at, point, m)) ||
        (to_leave > near && !runs_rightly(point, leave->at, n)))
        return false;
    for (int k = 0; k < 2; ++k)
        out[k] = qni_between(point[k], job->low_float[k], job->high_float[k]);
    return true;
}

/* How badly a pair fits its tangents, in lengths: 0 with a good feature. */
static double misfit(const face_job *job, int i, int j) {
    const face_point *a = &job->points[i], *b = &job->points[j];
    const face_point *enter = a->enters ? a : b, *leave = a->enters ? b : a;
    float feature[2];
    if (is_sharp(job, a, b) && feature_of(job, enter, leave, feature))
        return 0;
    const double way[2] = {leave->at[0] - enter->at[0], leave->at[1] - enter->at[1]};
    double cost = fabs(dot2(way, enter->normal)) + fabs(dot2(way, leave->normal));
    const double length = sqrt(dot2(way, way));
    cost += runs_rightly(enter->at, leave->at, enter->normal) ? 0 : length;
    cost += runs_rightly(enter->at, leave->at, leave->normal) ? 0 : length;
    return cost;
}

/* ---- pairing
 * ------------------------------------------------------------------------------------- */

/* Pair every crossing with its neighbour: first ones with the next or with the one before. */
static void pair_neighbors(face_job *job, int shift) {
    for (int n = 0; n < job->count; n += 2) {
        const int a = (n + shift) % job->count, b = (n + 1 + shift) % job->count;
        job->partner[a] = b;
        job->partner[b] = a;
    }
}

static double total_misfit(const face_job *job) {
    double total = 0;
    for (int n = 0; n < job->count; ++n)
        if (job->points[n].enters)
            total += misfit(job, n, job->partner[n]);
    return total;
}

/* The scalar rule on the values at the corners: are the outside corners joined? Corners beyond the
 * bounds count as outside and have no value: then the inside stays apart. */
static bool outside_is_joined(const face_job *job) {
    double corner[4][3], value[4];
    for (int n = 0; n < 4; ++n)
        for (int k = 0; k < 3; ++k) {
            const int step = k == job->p ? n == 1 || n == 2 : k == job->q ? n >= 2 : 0;
            corner[n][k] = qni_lattice_at(&job->hermite->lattice, k,
                                          job->face->low[k] + (step << job->face->level));
            if (corner[n][k] < job->hermite->lattice.bounds.low[k] ||
                corner[n][k] > job->hermite->lattice.bounds.high[k])
                return true;
        }
    const qn_solid *solid = job->solid;
    if (solid->ops->values(solid, 4, (const double(*)[3])corner, value) != QN_OK)
        return true;
    const bool first_inside = value[0] < 0;
    if ((value[2] < 0) != first_inside || (value[1] < 0) == first_inside ||
        (value[3] < 0) == first_inside)
        return true;
    return qni_face_joins_above(first_inside
                                    ? qni_face_saddle_sign(value[1], value[3], value[0], value[2])
                                    : qni_face_saddle_sign(value[0], value[2], value[1], value[3]));
}

/* Pairing without crossings of least misfit, over all of them: cost[i][j] of the points i .. j
 * among themselves. */
static void pair_by_cost(face_job *job) {
    static const double far = 1e300;
    double cost[QNI_FACE_POINTS + 1][QNI_FACE_POINTS + 1];
    int choice[QNI_FACE_POINTS][QNI_FACE_POINTS];
    const int count = job->count;
    for (int i = 0; i <= count; ++i)
        for (int j = 0; j <= count; ++j)
            cost[i][j] = 0; /* [i][j]: points i .. j - 1 */
    for (int length = 2; length <= count; length += 2)
        for (int i = 0; i + length <= count; ++i) {
            cost[i][i + length] = far;
            for (int j = i + 1; j < i + length; j += 2) {
                const double total = misfit(job, i, j) + cost[i + 1][j] + cost[j + 1][i + length];
                if (total < cost[i][i + length]) {
                    cost[i][i + length] = total;
                    choice[i][i + length - 1] = j;
                }
            }
        }
    int stack[QNI_FACE_POINTS][2], depth = 1;
    stack[0][0] = 0;
    stack[0][1] = count;
    while (depth > 0) {
        --depth;
        const int i = stack[depth][0], end = stack[depth][1];
        if (i >= end)
            continue;
        const int j = choice[i][end - 1];
        job->partner[i] = j;
        job->partner[j] = i;
        stack[depth][0] = i + 1;
        stack[depth++][1] = j;
        stack[depth][0] = j + 1;
        stack[depth++][1] = end;
    }
}

/* ---- segments
 * ------------------------------------------------------------------------------------ */

static const float *place_of(const face_job *job, const qni_face_solution *solution, int segment,
                             int step) {
    const qni_segment *s = &solution->segments[segment];
    const qni_hermite_crossing *all = job->hermite->crossings;
    if (step == 0)
        return all[s->from].place;
    if (step <= s->bends)
        return solution->features[s->feature + (uint32_t)step - 1].place;
    return all[s->to].place;
}

/* Do two closed pieces touch? Collinear ones count as touching. */
static bool pieces_touch(const face_job *job, const float *a, const float *b, const float *c,
                         const float *d) {
    const int p = job->p, q = job->q;
    return qni_orient2d(a, b, c, p, q) * qni_orient2d(a, b, d, p, q) <= 0 &&
           qni_orient2d(c, d, a, p, q) * qni_orient2d(c, d, b, p, q) <= 0;
}

static bool segments_touch(const face_job *job, const qni_face_solution *solution, int i, int j) {
    const int i_pieces = solution->segments[i].bends + 1,
              j_pieces = solution->segments[j].bends + 1;
    for (int m = 0; m < i_pieces; ++m)
        for (int n = 0; n < j_pieces; ++n)
            if (pieces_touch(job, place_of(job, solution, i, m), place_of(job, solution, i, m + 1),
                             place_of(job, solution, j, n), place_of(job, solution, j, n + 1)))
                return true;
    return false;
}

/* Does c lie strictly between a and b, of which it is known that the three are on a line? */
static bool is_between(const face_job *job, const float *a, const float *b, const float *c) {
    const int along = a[job->p] != b[job->p] ? job->p : job->q;
    return (a[along] < c[along] && c[along] < b[along]) ||
           (b[along] < c[along] && c[along] < a[along]);
}

/* Two pieces in a row overlap when they run back on one line; the first and third of three may
 * cross. */
static bool touches_itself(const face_job *job, const qni_face_solution *solution, int i) {
    const int bends = solution->segments[i].bends;
    const float *points[4];
    for (int n = 0; n < bends + 2; ++n)
        points[n] = place_of(job, solution, i, n);
    for (int n = 0; n < bends; ++n)
        if (qni_orient2d(points[n], points[n + 1], points[n + 2], job->p, job->q) == 0 &&
            !is_between(job, points[n], points[n + 2], points[n + 1]))
            return true;
    return bends == 2 && pieces_touch(job, points[0], points[1], points[2], points[3]);
}

static bool any_touch(const face_job *job, const qni_face_solution *solution) {
    for (int i = 0; i < solution->count; ++i)
        if (touches_itself(job, solution, i))
            return true;
    for (int i = 0; i < solution->count; ++i)
        for (int j = i + 1; j < solution->count; ++j)
            if (segments_touch(job, solution, i, j))
                return true;
    return false;
}

static qni_face_feature *add_feature(const face_job *job, qni_face_solution *solution,
                                     qni_segment *segment, const float at[2], bool sharp) {
    qni_face_feature *feature = &solution->features[solution->feature_count];
    memset(feature, 0, sizeof *feature);
    const int axis = job->face->axis;
    feature->place[axis] =
        (float)qni_lattice_at(&job->hermite->lattice, axis, job->face->low[axis]);
    feature->place[job->p] = at[0];
    feature->place[job->q] = at[1];
    feature->sharp = sharp;
    segment->feature = segment->bends++ ? segment->feature : (uint32_t)solution->feature_count;
    ++solution->feature_count;
    return feature;
}

/* A segment between two crossings of one side would lie in the edge: it bends into the face, the
 * less the shorter it is, so that nested ones stay apart. */
static void add_bend(const face_job *job, qni_face_solution *solution, qni_segment *segment,
                     const face_point *a, const face_point *b, double share) {
    const int side = a->side, along = side & 1, across = 1 - along;
    const double middle = 0.5 * (a->at[along] + b->at[along]);
    const double depth = share * fabs(a->at[along] - b->at[along]);
    const bool from_low = side == 0 || side == 3;
    double at[2];
    at[along] = middle;
    at[across] = from_low ? job->low[across] + depth : job->high[across] - depth;
    const float inside[2] = {qni_between(at[0], job->low_float[0], job->high_float[0]),
                             qni_between(at[1], job->low_float[1], job->high_float[1])};
    add_feature(job, solution, segment, inside, false);
}

/* The active branch's tangent at a point of the face, as a line in the face; false where it has
 * none there. */
typedef struct tangent_line {
    double normal[2], height; /* in the face, unit length: normal . x = height */
    double space_normal[3];
    double distance; /* of the point from the surface in space, to first order */
    int32_t owner;
} tangent_line;

static bool probe(const face_job *job, const double at[2], tangent_line *line) {
    const qn_solid *solid = job->solid;
    double point[3], value, gradient[3];
    point[job->face->axis] =
        qni_lattice_at(&job->hermite->lattice, job->face->axis, job->face->low[job->face->axis]);
    point[job->p] = at[0];
    point[job->q] = at[1];
    if (solid->ops->values(solid, 1, (const double(*)[3])point, &value) != QN_OK ||
        solid->ops->gradients(solid, 1, (const double(*)[3])point, (double(*)[3])gradient,
                              &line->owner) != QN_OK)
        return false;
    const double length =
        sqrt(gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2]);
    const double in_face = hypot(gradient[job->p], gradient[job->q]);
    if (!(in_face > 1e-6 * length) || !isfinite(length))
        return false;
    for (int k = 0; k < 3; ++k)
        line->space_normal[k] = gradient[k] / length;
    line->normal[0] = gradient[job->p] / in_face;
    line->normal[1] = gradient[job->q] / in_face;
    line->height = dot2(line->normal, at) - value / in_face;
    line->distance = fabs(value) / length;
    return true;
}

/* A made-up crossing on the third line, to be met with the tangents of the ends. */
static face_point on_line(const tangent_line *line) {
    face_point point;
    memset(&point, 0, sizeof point);
    for (int k = 0; k < 2; ++k) {
        point.normal[k] = line->normal[k];
        point.at[k] = line->height * line->normal[k];
    }
    return point;
}

/* Where two tangents meet, strictly within the face. */
static bool meet(const face_job *job, const face_point *a, const face_point *b, double out[2]) {
    const double determinant = a->normal[0] * b->normal[1] - a->normal[1] * b->normal[0];
    if (!(fabs(determinant) > 1e-4))
        return false;
    const double m = dot2(a->normal, a->at), n = dot2(b->normal, b->at);
    out[0] = (m * b->normal[1] - n * a->normal[1]) / determinant;
    out[1] = (n * a->normal[0] - m * b->normal[0]) / determinant;
    return out[0] > job->low[0] && out[0] < job->high[0] && out[1] > job->low[1] &&
           out[1] < job->high[1];
}

/* A third plane between the ends' own, found where the surface is not where they say: two features
 * in place of one. */
static bool add_two(const face_job *job, qni_face_solution *solution, qni_segment *segment,
                    const face_point *enter, const face_point *leave, const tangent_line *third) {
    const face_point middle = on_line(third);
    double first[2], second[2];
    tangent_line check;
    if (!meet(job, enter, &middle, first) || !meet(job, &middle, leave, second) ||
        !runs_rightly(enter->at, first, enter->normal) ||
        !runs_rightly(first, second, third->normal) ||
        !runs_rightly(second, leave->at, leave->normal))
        return false;
    const double *points[2] = {first, second};
    for (int n = 0; n < 2; ++n)
        if (!probe(job, points[n], &check) || check.distance > 0.25 * third->distance)
            return false;
    for (int n = 0; n < 2; ++n) {
        const float at[2] = {qni_between(points[n][0], job->low_float[0], job->high_float[0]),
                             qni_between(points[n][1], job->low_float[1], job->high_float[1])};
        qni_face_feature *feature = add_feature(job, solution, segment, at, true);
        memcpy(feature->normal, third->space_normal, sizeof feature->normal);
        feature->owner = third->owner;
        feature->has_plane = true;
    }
    return true;
}

/* The sharp features of a pair: where its tangents meet; but where the surface is elsewhere, look
 * for a plane between. */
static void add_sharp(const face_job *job, qni_face_solution *solution, qni_segment *segment,
                      const face_point *enter, const face_point *leave) {
    if (!is_sharp(job, enter, leave))
        return;
    float at[2];
    double guesses[2][2], met[2];
    tangent_line third;
    const tangent a = tangent_at(enter), b = tangent_at(leave);
    const bool found = feature_of(job, enter, leave, at), meets = tangents_meet(&a, &b, met);
    for (int k = 0; k < 2; ++k) {
        guesses[1][k] = 0.5 * (enter->at[k] + leave->at[k]);
        guesses[0][k] = found   ? (double)at[k]
                        : meets ? fmin(fmax(met[k], job->low[k]), job->high[k])
                                : guesses[1][k];
    }
    for (int n = 0; n < (found ? 1 : 2); ++n)
        if (probe(job, guesses[n], &third) &&
            third.distance > 0.01 * (job->high[0] - job->low[0]) &&
            add_two(job, solution, segment, enter, leave, &third))
            return;
    if (found)
        add_feature(job, solution, segment, at, true);
}

/* Segments of the pairing; `with_features` also the sharp ones. Tells how many features escaped. */
static void make_segments(const face_job *job, qni_face_solution *solution, bool with_features,
                          double bend_share) {
    solution->count = solution->feature_count = 0;
    solution->dropped = 0;
    for (int n = 0; n < job->count; ++n) {
        const face_point *enter = &job->points[n], *leave = &job->points[job->partner[n]];
        if (!enter->enters)
            continue;
        qni_segment *segment = &solution->segments[solution->count++];
        const qni_segment plain = {enter->number, leave->number, 0, 0, {0, 0}};
        *segment = plain;
        if (with_features)
            add_sharp(job, solution, segment, enter, leave);
        const bool missing = segment->bends == 0 && is_sharp(job, enter, leave);
        if (segment->bends == 0 && enter->side == leave->side)
            add_bend(job, solution, segment, enter, leave, bend_share);
        solution->dropped += missing;
    }
}

/* Features first; where they make segments touch, chords, which cannot, with ever flatter bends. */
static bool solve_pairing(const face_job *job, qni_face_solution *solution) {
    make_segments(job, solution, true, 0.5);
    if (!any_touch(job, solution))
        return true;
    double share = 0.5;
    for (int attempt = 0; attempt < 12; ++attempt, share *= 0.25) {
        make_segments(job, solution, false, share);
        if (!any_touch(job, solution))
            return false;
    }
    solution->unresolved = true;
    return false;
}

/* The Hermite rule of two pairings: the one whose features do not cross; else the one whose
 * tangents clearly fit; else the values at the corners. */
static void solve_ambiguous(face_job *job, qni_face_solution *solution) {
    const int apart = job->points[0].enters ? 0 : 1; /* cuts off the inside arcs */
    double cost[2];
    bool clean[2];
    for (int way = 0; way < 2; ++way) {
        pair_neighbors(job, way == 0 ? apart : 1 - apart);
        clean[way] = solve_pairing(job, solution);
        cost[way] = total_misfit(job);
    }
    const double size = job->high[0] - job->low[0], slack = 1e-9 * size;
    int way;
    if (clean[0] != clean[1])
        way = clean[0] ? 0 : 1;
    else if (2 * cost[0] + slack < cost[1])
        way = 0;
    else if (2 * cost[1] + slack < cost[0])
        way = 1;
    else
        way = outside_is_joined(job) ? 0 : 1;
    pair_neighbors(job, way == 0 ? apart : 1 - apart);
    solution->unresolved = false;
    solve_pairing(job, solution);
}

void qni_solve_face(const qni_hermite *hermite, const qn_solid *solid,
                    const qni_cms_settings *settings, const qni_face *face,
                    qni_face_solution *solution) {
    face_job job;
    job.hermite = hermite;
    job.solid = solid;
    job.settings = settings;
    job.face = face;
    job.p = face->axis == 0 ? 1 : 0;
    job.q = face->axis == 2 ? 1 : 2;
    job.count = 0;
    solution->count = solution->feature_count = solution->dropped = 0;
    solution->ambiguous = solution->unresolved = solution->broken = false;
    for (int side = 0; side < 4; ++side)
        if (!gather_side(&job, side)) {
            solution->broken = true;
            return;
        }
    if (job.count == 0)
        return;
    solution->broken = !alternates(&job);
    if (solution->broken)
        return;
    for (int k = 0; k < 2; ++k) {
        const int axis = k ? job.q : job.p;
        job.low[k] = qni_lattice_at(&hermite->lattice, axis, face->low[axis]);
        job.high[k] = qni_lattice_at(&hermite->lattice, axis, face->low[axis] + (1 << face->level));
        job.low_float[k] = (float)job.low[k];
        job.high_float[k] = (float)job.high[k];
    }
    solution->ambiguous = job.count > 2;
    if (job.count == 4) {
        solve_ambiguous(&job, solution);
        return;
    }
    if (job.count == 2)
        pair_neighbors(&job, 0);
    else
        pair_by_cost(&job);
    solve_pairing(&job, solution);
}
