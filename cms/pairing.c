// SPDX-License-Identifier: MIT
/* Which crossings of a face belong together. */
#include "cms/face_job.h"
#include "face/face_hd.h"

#include <math.h>
#include <string.h>

/* How badly a pair fits its tangents, in lengths: 0 when its trace is known. */
static double misfit(const qni_face_job *job, int i, int j) {
    const qni_face_point *a = &job->points[i], *b = &job->points[j];
    const qni_face_point *enter = a->enters ? a : b, *leave = a->enters ? b : a;
    qni_trace trace;
    const bool sharp = qni_pair_is_sharp(job, a, b);
    if (sharp && qni_face_trace(job, enter, leave, &trace) && trace.count > 0)
        return 0;
    if (!sharp && job->settings->features && qni_pair_is_plain(job, enter, leave))
        return 0;
    const double *from = enter->line.at, *to = leave->line.at;
    const double way[2] = {to[0] - from[0], to[1] - from[1]};
    double cost = fabs(qni_dot2(way, enter->line.normal)) + fabs(qni_dot2(way, leave->line.normal));
    const double length = sqrt(qni_dot2(way, way));
    cost += qni_runs_rightly(from, to, enter->line.normal) ? 0 : length;
    cost += qni_runs_rightly(from, to, leave->line.normal) ? 0 : length;
    return cost;
}

void qni_pair_neighbors(qni_face_job *job, int shift) {
    for (int n = 0; n < job->count; n += 2) {
        const int a = (n + shift) % job->count, b = (n + 1 + shift) % job->count;
        job->partner[a] = b;
        job->partner[b] = a;
    }
}

double qni_pairing_cost(const qni_face_job *job) {
    double total = 0;
    for (int n = 0; n < job->count; ++n)
        if (job->points[n].enters)
            total += misfit(job, n, job->partner[n]);
    return total;
}

/* Corners beyond the bounds count as outside and have no value: then the inside stays apart. */
bool qni_outside_is_joined(const qni_face_job *job) {
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
    const int sign = first_inside ? qni_face_saddle_sign(value[1], value[3], value[0], value[2])
                                  : qni_face_saddle_sign(value[0], value[2], value[1], value[3]);
    return job->settings->join_ties ? sign > 0 : qni_face_joins_above(sign);
}

typedef struct pairing_job {
    double misfit[QNI_FACE_POINTS][QNI_FACE_POINTS];
    double cost[QNI_FACE_POINTS + 1][QNI_FACE_POINTS + 1]; /* [i][j]: points i .. j - 1 */
    int choice[QNI_FACE_POINTS][QNI_FACE_POINTS];
} pairing_job;

/* Least cost of the points i .. j - 1 among themselves, for all i and j. */
static void choose_pairs(const qni_face_job *job, pairing_job *pairing) {
    static const double far = 1e300;
    const int count = job->count;
    for (int i = 0; i <= count; ++i)
        for (int j = 0; j <= count; ++j)
            pairing->cost[i][j] = 0;
    for (int i = 0; i < count; ++i)
        for (int j = i + 1; j < count; j += 2)
            pairing->misfit[i][j] = misfit(job, i, j);
    for (int length = 2; length <= count; length += 2)
        for (int i = 0; i + length <= count; ++i) {
            double *least = &pairing->cost[i][i + length];
            *least = far;
            for (int j = i + 1; j < i + length; j += 2) {
                const double total = pairing->misfit[i][j] + pairing->cost[i + 1][j] +
                                     pairing->cost[j + 1][i + length];
                if (total < *least) {
                    *least = total;
                    pairing->choice[i][i + length - 1] = j;
                }
            }
        }
}

void qni_pair_by_cost(qni_face_job *job) {
    pairing_job pairing;
    choose_pairs(job, &pairing);
    int stack[QNI_FACE_POINTS][2], depth = 1;
    stack[0][0] = 0;
    stack[0][1] = job->count;
    while (depth > 0) {
        --depth;
        const int i = stack[depth][0], end = stack[depth][1];
        if (i >= end)
            continue;
        const int j = pairing.choice[i][end - 1];
        job->partner[i] = j;
        job->partner[j] = i;
        stack[depth][0] = i + 1;
        stack[depth++][1] = j;
        stack[depth][0] = j + 1;
        stack[depth++][1] = end;
    }
}
