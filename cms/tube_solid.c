// SPDX-License-Identifier: MIT
/* Which two loops of a finest cell of a solid are one tube, by the solid itself.
 *
 * Two loops can be the ends of a tube when, on the cell's border, they share the region on one of
 * their sides but not on the other. They are one when what lies beyond them on those other sides
 * hangs together inside the cell: a way through samples of that sign, whose every step crosses no
 * surface. Cells whose discs lie on the surface are not asked: thin walls have many of them. */
#include "cms/cms.h"
#include "cms/way.h"
#include "core/cube_hd.h"

#include <math.h>
#include <string.h>

enum { MOST_LOOPS = 16, MOST_ON_EDGE = 32 };

static const double most_off = 0.03; /* of a cell: how far discs may be from the surface */

typedef struct way_job {
    const qni_patch *patch;
    qni_way way;
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

static bool take_samples(way_job *job) {
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = (double)job->patch->low[k];
        high[k] = (double)job->patch->high[k];
    }
    return qni_way_init(&job->way, job->patch->solid, low, high);
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
            const double along =
                (QNI_WAY_SIDE - 1) * ((double)vertex->place[k] - low) / (high - low);
            const bool up = vertex->crossing->enters == inside;
            const int at = (int)(k != vertex->crossing->axis ? floor(along + 0.5)
                                 : up                        ? ceil(along)
                                                             : floor(along));
            sample = QNI_WAY_SIDE * sample + (at < 0               ? 0
                                              : at >= QNI_WAY_SIDE ? QNI_WAY_SIDE - 1
                                                                   : at);
        }
        if (job->way.inside[sample] == inside)
            marks[sample] = any = true;
    }
    return any;
}

/* A way on the border means that the faces do not show all there is: a notch that misses the cell's
 * edges, not a tunnel. */
static bool are_joined(way_job *job, const int loops[2], bool inside, double middle[3]) {
    qni_way *way = &job->way;
    bool starts[QNI_WAY_SAMPLES] = {false};
    memset(way->end, 0, sizeof way->end);
    if (!mark_beside(job, loops[0], inside, starts) ||
        !mark_beside(job, loops[1], inside, way->end) ||
        qni_way_find(way, inside, starts, true) >= 0)
        return false;
    const int end = qni_way_find(way, inside, starts, false);
    if (end < 0)
        return false;
    int steps = 0, here = end;
    for (; way->before[here] != here; here = way->before[here])
        ++steps;
    for (here = end; steps > 1; steps -= 2)
        here = way->before[here];
    qni_way_point(way, here, middle);
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
