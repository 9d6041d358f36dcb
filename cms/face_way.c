// SPDX-License-Identifier: MIT
/* Which pairing of four crossings is right, by the solid itself: of the arcs of the face's border
 * between them those inside hang together across the face, or those outside do. */
#include "cms/face_job.h"
#include "cms/way.h"

#include <string.h>

/* Where a point of the border lies, walking counter-clockwise: 0 to 4. */
static double along_border(const qni_face_job *job, int side, const double at[2]) {
    const double share = (at[side & 1] - job->low[side & 1]) / job->size;
    return side < 2 ? side + share : side + 1 - share;
}

static bool is_sample_on_border(const qni_face_job *job, int sample, double *along) {
    const int p = sample % QNI_WAY_SIDE, q = sample / QNI_WAY_SIDE, last = QNI_WAY_SIDE - 1;
    const int side = q == 0 ? 0 : p == last ? 1 : q == last ? 2 : 3;
    const double at[2] = {job->low[0] + (job->high[0] - job->low[0]) * p / last,
                          job->low[1] + (job->high[1] - job->low[1]) * q / last};
    *along = along_border(job, side, at);
    return p == 0 || q == 0 || p == last || q == last;
}

/* The samples of the border between one crossing and the next. */
static bool mark_arc(const qni_face_job *job, const qni_way *way, int from, bool *marks) {
    const qni_face_point *a = &job->points[from], *b = &job->points[(from + 1) % job->count];
    const double start = along_border(job, a->side, a->line.at);
    double length = along_border(job, b->side, b->line.at) - start;
    bool any = false;
    length += length <= 0 ? 4 : 0;
    for (int n = 0; n < QNI_WAY_SIDE * QNI_WAY_SIDE; ++n) {
        double along;
        if (!is_sample_on_border(job, n, &along) || way->inside[n] != a->enters)
            continue;
        along -= start;
        along += along < 0 ? 4 : 0;
        if (along > 0 && along < length)
            marks[n] = any = true;
    }
    return any;
}

static bool are_joined(const qni_face_job *job, qni_way *way, bool inside) {
    const int first = job->points[0].enters == inside ? 0 : 1;
    bool starts[QNI_WAY_SAMPLES] = {false};
    memset(way->end, 0, sizeof way->end);
    return mark_arc(job, way, first, starts) && mark_arc(job, way, first + 2, way->end) &&
           qni_way_find(way, inside, starts, false) >= 0;
}

bool qni_face_joins(const qni_face_job *job, bool *outside) {
    qni_way way;
    double low[3], high[3];
    low[job->face->axis] = high[job->face->axis] = job->height;
    low[job->p] = job->low[0];
    low[job->q] = job->low[1];
    high[job->p] = job->high[0];
    high[job->q] = job->high[1];
    if (!qni_way_init(&way, job->solid, low, high))
        return false;
    *outside = are_joined(job, &way, false);
    return *outside || are_joined(job, &way, true);
}
