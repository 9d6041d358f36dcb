// SPDX-License-Identifier: MIT
/* Do the segments of a face touch? Decided by exact predicates on the coordinates as written. */
#include "cms/face_job.h"
#include "mesh/predicates.h"

static const float *place_of(const qni_face_job *job, const qni_face_solution *solution,
                             int segment, int step) {
    const qni_segment *s = &solution->segments[segment];
    const qni_hermite_crossing *all = job->hermite->crossings;
    if (step == 0)
        return all[s->from].place;
    if (step <= s->bends)
        return solution->features[s->feature + (uint32_t)step - 1].place;
    return all[s->to].place;
}

/* Are all of two pieces' coordinates on an axis apart? */
static bool are_apart(const float *a, const float *b, const float *c, const float *d, int k) {
    const float low = a[k] < b[k] ? a[k] : b[k], high = a[k] < b[k] ? b[k] : a[k];
    return (c[k] < low && d[k] < low) || (c[k] > high && d[k] > high);
}

/* Do two closed pieces touch? Where all four ends are on one line their orders along it tell. */
static bool pieces_touch(const qni_face_job *job, const float *a, const float *b, const float *c,
                         const float *d) {
    const int p = job->p, q = job->q;
    if (are_apart(a, b, c, d, p) || are_apart(a, b, c, d, q))
        return false;
    return qni_orient2d(a, b, c, p, q) * qni_orient2d(a, b, d, p, q) <= 0 &&
           qni_orient2d(c, d, a, p, q) * qni_orient2d(c, d, b, p, q) <= 0;
}

static bool two_touch(const qni_face_job *job, const qni_face_solution *solution, int i, int j) {
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
static bool is_between(const qni_face_job *job, const float *a, const float *b, const float *c) {
    const int along = a[job->p] != b[job->p] ? job->p : job->q;
    return (a[along] < c[along] && c[along] < b[along]) ||
           (b[along] < c[along] && c[along] < a[along]);
}

/* Two pieces in a row overlap when they run back on one line; others may cross. */
static bool touches_itself(const qni_face_job *job, const qni_face_solution *solution, int i) {
    const int bends = solution->segments[i].bends;
    const float *points[QNI_MOST_BENDS + 2];
    for (int n = 0; n < bends + 2; ++n)
        points[n] = place_of(job, solution, i, n);
    for (int n = 0; n < bends; ++n)
        if (qni_orient2d(points[n], points[n + 1], points[n + 2], job->p, job->q) == 0 &&
            !is_between(job, points[n], points[n + 2], points[n + 1]))
            return true;
    for (int m = 0; m < bends; ++m)
        for (int n = m + 2; n <= bends; ++n)
            if (pieces_touch(job, points[m], points[m + 1], points[n], points[n + 1]))
                return true;
    return false;
}

bool qni_segments_touch(const qni_face_job *job, const qni_face_solution *solution) {
    for (int i = 0; i < solution->count; ++i)
        if (touches_itself(job, solution, i))
            return true;
    for (int i = 0; i < solution->count; ++i)
        for (int j = i + 1; j < solution->count; ++j)
            if (two_touch(job, solution, i, j))
                return true;
    return false;
}
