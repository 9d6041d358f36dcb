// SPDX-License-Identifier: MIT
/* Which two loops of a finest cell of a solid are one tube, by the solid itself.
 *
 * Two loops can be the ends of a tube when, on the cell's border, they share the region on one of
 * their sides but not on the other. They are one when what lies beyond them on those other sides
 * hangs together inside the cell: a way through samples of that sign, whose every step crosses no
 * surface. Cells whose discs lie on the surface are not asked: thin walls have many of them. */
#include "cms/cms.h"
#include "core/cube_hd.h"

#include <math.h>
#include <string.h>

enum {
    SIDE = 8,
    SAMPLES = SIDE * SIDE * SIDE,
    MOST_LOOPS = 16,
    MOST_ON_EDGE = 32,
    MOST_TRIES = 40
};

static const double most_off = 0.03; /* of a cell: how far discs may be from the surface */

typedef struct way_job {
    const qni_patch *patch;
    bool inside[SAMPLES];
    bool blocked[3]
                [SAMPLES]; /* the step from a sample to the next along an axis meets the surface */
    int16_t before[SAMPLES]; /* on the way from the first loop; -1: not reached, itself: a start */
    bool end[SAMPLES];
    int parent[QNI_CORNERS +
               2 * MOST_LOOPS]; /* border regions: corners, then the loops' two sides */
} way_job;

/* ---- the border ------------------------------------------------------------------------------ */

static int find(way_job *job, int n) {
    while (job->parent[n] != n)
        n = job->parent[n] = job->parent[job->parent[n]];
    return n;
}

static int side_of(int loop, bool inside) {
    return QNI_CORNERS + 2 * loop + inside;
}

typedef struct edge_point {
    int loop;
    float at;
    bool enters; /* upwards */
} edge_point;

static int collect(const qni_patch *patch, int edge, edge_point *points) {
    const int axis = qni_edge_axis(edge);
    int count = 0;
    for (int n = 0; n < patch->loop_count; ++n)
        for (int32_t m = 0; m < patch->loops[n].count; ++m) {
            const qni_loop_vertex *vertex = &patch->vertices[patch->loops[n].first + m];
            if (!vertex->crossing || qni_edge_of_walls(vertex->walls) != edge ||
                count == MOST_ON_EDGE)
                continue;
            int at = count++;
            for (; at > 0 && points[at - 1].at > vertex->place[axis]; --at)
                points[at] = points[at - 1];
            const edge_point point = {n, vertex->place[axis], vertex->crossing->enters};
            points[at] = point;
        }
    return count;
}

/* What hangs together on the border: the pieces of edges between crossings and corners; a loop's
 * sides stay the same along its segments. */
static void join_border(way_job *job) {
    for (int n = 0; n < QNI_CORNERS + 2 * MOST_LOOPS; ++n)
        job->parent[n] = n;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        edge_point points[MOST_ON_EDGE];
        const int count = collect(job->patch, edge, points);
        int below = qni_edge_start_corner(edge);
        for (int n = 0; n < count; ++n) {
            job->parent[find(job, below)] = find(job, side_of(points[n].loop, !points[n].enters));
            below = side_of(points[n].loop, points[n].enters);
        }
        job->parent[find(job, below)] =
            find(job, qni_edge_start_corner(edge) | 1 << qni_edge_axis(edge));
    }
}

/* ---- samples --------------------------------------------------------------------------------- */

static void place_of(const way_job *job, int sample, double point[3]) {
    const int at[3] = {sample % SIDE, sample / SIDE % SIDE, sample / SIDE / SIDE};
    for (int k = 0; k < 3; ++k) {
        const double low = (double)job->patch->low[k], high = (double)job->patch->high[k];
        point[k] = low + (high - low) * at[k] / (SIDE - 1);
    }
}

static bool take_samples(way_job *job) {
    double points[SAMPLES][3];
    for (int n = 0; n < SAMPLES; ++n)
        place_of(job, n, points[n]);
    memset(job->blocked, 0, sizeof job->blocked);
    return qni_solid_inside(job->patch->solid, SAMPLES, (const double(*)[3])points, job->inside) ==
           QN_OK;
}

/* The samples next to a loop on one of its sides; false when there is none. */
static bool mark_beside(const way_job *job, int loop, bool inside, bool *marks) {
    const qni_patch *patch = job->patch;
    bool any = false;
    for (int32_t m = 0; m < patch->loops[loop].count; ++m) {
        const qni_loop_vertex *vertex = &patch->vertices[patch->loops[loop].first + m];
        if (!vertex->crossing)
            continue;
        int sample = 0;
        for (int k = 2; k >= 0; --k) {
            const double low = (double)patch->low[k], high = (double)patch->high[k];
            const double along = (SIDE - 1) * ((double)vertex->place[k] - low) / (high - low);
            const bool up = vertex->crossing->enters == inside;
            const int at = (int)(k != vertex->crossing->axis ? floor(along + 0.5)
                                 : up                        ? ceil(along)
                                                             : floor(along));
            sample = SIDE * sample + (at < 0 ? 0 : at >= SIDE ? SIDE - 1 : at);
        }
        if (job->inside[sample] == inside)
            marks[sample] = any = true;
    }
    return any;
}

/* ---- the way --------------------------------------------------------------------------------- */

static bool is_on_border(int sample) {
    for (int axis = 0; axis < 3; ++axis, sample /= SIDE)
        if (sample % SIDE == 0 || sample % SIDE == SIDE - 1)
            return true;
    return false;
}

/* Breadth first, or along the border alone; the first end that is reached, or -1. */
static int search(way_job *job, bool inside, const bool *starts, bool border) {
    int16_t queue[SAMPLES];
    int head = 0, tail = 0;
    for (int n = 0; n < SAMPLES; ++n) {
        job->before[n] = starts[n] ? (int16_t)n : -1;
        if (starts[n])
            queue[tail++] = (int16_t)n;
    }
    while (head < tail) {
        const int here = queue[head++];
        if (job->end[here])
            return here;
        for (int axis = 0, stride = 1; axis < 3; ++axis, stride *= SIDE)
            for (int up = 0; up < 2; ++up) {
                const int at = here / stride % SIDE, low = up ? here : here - stride;
                if (at == (up ? SIDE - 1 : 0))
                    continue;
                const int next = up ? here + stride : low;
                if (job->before[next] >= 0 || job->inside[next] != inside ||
                    job->blocked[axis][low] || (border && !is_on_border(next)))
                    continue;
                job->before[next] = (int16_t)here;
                queue[tail++] = (int16_t)next;
            }
    }
    return -1;
}

/* Does any step of the way meet the surface? The first that does is blocked. */
static bool way_is_clear(way_job *job, int end) {
    const qn_solid *solid = job->patch->solid;
    for (int here = end; job->before[here] != here; here = job->before[here]) {
        const int next = job->before[here], low = here < next ? here : next;
        const int step = (here < next ? next : here) - low;
        const int axis = step == 1 ? 0 : step == SIDE ? 1 : 2;
        double a[3], b[3];
        qni_crossing found[4];
        int32_t count = 0;
        place_of(job, low, a);
        place_of(job, low + step, b);
        if (solid->ops->crossings(solid, a, b, 4, found, &count) == QN_OK && count == 0)
            continue;
        job->blocked[axis][low] = true;
        return false;
    }
    return true;
}

/* The end of a clear way, or -1. */
static int find_way(way_job *job, bool inside, const bool *starts, bool border) {
    for (int n = 0; n < MOST_TRIES; ++n) {
        const int end = search(job, inside, starts, border);
        if (end < 0 || way_is_clear(job, end))
            return end;
    }
    return -1;
}

/* A way on the border means that the faces do not show all there is: a notch that misses the cell's
 * edges, not a tunnel. */
static bool are_joined(way_job *job, const int loops[2], bool inside, double middle[3]) {
    bool starts[SAMPLES] = {false};
    memset(job->end, 0, sizeof job->end);
    if (!mark_beside(job, loops[0], inside, starts) ||
        !mark_beside(job, loops[1], inside, job->end) || find_way(job, inside, starts, true) >= 0)
        return false;
    const int end = find_way(job, inside, starts, false);
    if (end < 0)
        return false;
    int steps = 0, here = end;
    for (; job->before[here] != here; here = job->before[here])
        ++steps;
    for (here = end; steps > 1; steps -= 2)
        here = job->before[here];
    place_of(job, here, middle);
    return true;
}

/* ---- the cell -------------------------------------------------------------------------------- */

static bool is_near_surface(const qni_patch *patch, const int32_t triangle[4]) {
    const qn_solid *solid = patch->solid;
    double point[1][3] = {{0, 0, 0}}, value, gradient[1][3], square = 0;
    for (int n = 0; n < 3; ++n)
        for (int k = 0; k < 3; ++k)
            point[0][k] += (double)qni_patch_place(patch, triangle[n])[k] / 3;
    if (solid->ops->values(solid, 1, (const double(*)[3])point, &value) != QN_OK ||
        solid->ops->gradients(solid, 1, (const double(*)[3])point, gradient, NULL) != QN_OK)
        return false;
    for (int k = 0; k < 3; ++k)
        square += gradient[0][k] * gradient[0][k];
    return fabs(value) <= most_off * patch->size * sqrt(square);
}

static bool discs_fit(const qni_patch *patch) {
    for (int64_t t = 0; t < patch->triangle_count; ++t)
        if (!is_near_surface(patch, patch->triangles[t]))
            return false;
    return true;
}

bool qni_patch_find_solid_tube(const qni_patch *patch, int tube[2], double middle[3]) {
    way_job job;
    bool sampled = false;
    if (patch->cell.level != 0 || patch->loop_count > MOST_LOOPS || discs_fit(patch))
        return false;
    job.patch = patch;
    join_border(&job);
    for (int m = 0; m < patch->loop_count; ++m)
        for (int n = m + 1; n < patch->loop_count; ++n) {
            const bool in = find(&job, side_of(m, true)) == find(&job, side_of(n, true)),
                       out = find(&job, side_of(m, false)) == find(&job, side_of(n, false));
            if (in == out)
                continue;
            if (!sampled && !take_samples(&job))
                return false;
            sampled = true;
            tube[0] = m;
            tube[1] = n;
            if (are_joined(&job, tube, out, middle))
                return true;
        }
    return false;
}
