// SPDX-License-Identifier: MIT
/* Hulls: points go to Qhull (its re-entrant library), planes and corners come back. Qhull takes its
 * own memory while it works and gives it back before the call ends. */
#include "solid/hull.h"

#include <stdio.h>
#include <string.h>

#include "qni_config.h"

bool qni_points_add(qn_context *context, qni_points *points, const double point[3]) {
    if (points->count == points->capacity) {
        int64_t room = points->capacity ? 2 * points->capacity : 64;
        double(*more)[3] = qni_realloc(context, points->at, points->capacity, room, sizeof *more);
        if (!more)
            return false;
        points->at = more;
        points->capacity = room;
    }
    memcpy(points->at[points->count++], point, sizeof *points->at);
    return true;
}

void qni_points_free(qn_context *context, qni_points *points) {
    qni_free(context, points->at, points->capacity, sizeof *points->at);
    *points = (qni_points){0};
}

void qni_hull_free(qn_context *context, qni_hull *hull) {
    qni_free(context, hull->planes, hull->plane_count, sizeof *hull->planes);
    *hull = (qni_hull){0};
}

#if QNI_HAVE_QHULL
#include <libqhull_r/qhull_ra.h>

/* Qhull calls points within its rounding of a plane flat; so are these. */
static bool is_flat(int dimension, const qni_points *points) {
    if (points->count <= dimension)
        return true;
    double span[3][3], size = 0;
    int found = 0;
    /* Directions from the first point: each new one is the farthest from those there are, made
     * orthogonal. */
    for (; found < dimension; ++found) {
        double best[3] = {0, 0, 0}, most = 0;
        for (int64_t n = 1; n < points->count; ++n) {
            double d[3] = {0, 0, 0}, square = 0;
            for (int k = 0; k < dimension; ++k)
                d[k] = points->at[n][k] - points->at[0][k];
            for (int s = 0; s < found; ++s) {
                double along = d[0] * span[s][0] + d[1] * span[s][1] + d[2] * span[s][2];
                for (int k = 0; k < 3; ++k)
                    d[k] -= along * span[s][k];
            }
            square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if (square > most) {
                most = square;
                memcpy(best, d, sizeof best);
            }
        }
        size = fmax(size, most);
        if (most <= 1e-20 * size)
            return true;
        for (int k = 0; k < 3; ++k)
            span[found][k] = best[k] / sqrt(most);
    }
    return false;
}

static bool take(qhT *qh, qn_context *context, int dimension, bool *corner, qni_hull *hull) {
    facetT *facet;
    vertexT *vertex;
    int64_t used = 0;
    FORALLfacets hull->plane_count += 1;
    hull->planes = qni_alloc(context, hull->plane_count, sizeof *hull->planes);
    if (!hull->planes)
        return false;
    FORALLfacets {
        double *plane = hull->planes[used++];
        for (int k = 0; k < 3; ++k)
            plane[k] = k < dimension ? facet->normal[k] : 0;
        plane[3] = -facet->offset;
    }
    if (corner)
        FORALLvertices corner[qh_pointid(qh, vertex->point)] = true;
    return true;
}

qn_status qni_hull_make(qn_context *context, int dimension, const qni_points *points, bool *corner,
                        qni_hull *hull, qn_error *error) {
    *hull = (qni_hull){0};
    if (corner)
        memset(corner, 0, (size_t)points->count * sizeof *corner);
    hull->flat = is_flat(dimension, points);
    if (hull->flat)
        return QN_OK;
    if (points->count > INT32_MAX / 8)
        return qni_fail(error, QN_ERROR_INPUT, "a hull of %lld points: more than can be",
                        (long long)points->count);
    coordT *packed = qni_alloc(context, points->count * dimension, sizeof *packed);
    FILE *nowhere = fopen("/dev/null", "w"); /* what Qhull has to say goes there */
    if (!packed || !nowhere) {
        qni_free(context, packed, points->count * dimension, sizeof *packed);
        if (nowhere)
            fclose(nowhere);
        return qni_fail_memory(error, "a hull");
    }
    for (int64_t n = 0; n < points->count; ++n)
        for (int k = 0; k < dimension; ++k)
            packed[n * dimension + k] = points->at[n][k];
    qhT qh_area, *qh = &qh_area;
    char options[] = "qhull Pp";
    qh_zero(qh, nowhere);
    int failed =
        qh_new_qhull(qh, dimension, (int)points->count, packed, False, options, NULL, nowhere);
    bool taken = failed || take(qh, context, dimension, corner, hull);
    int current, total;
    qh_freeqhull(qh, !qh_ALL);
    qh_memfreeshort(qh, &current, &total);
    fclose(nowhere);
    qni_free(context, packed, points->count * dimension, sizeof *packed);
    if (failed)
        return qni_fail(error, QN_ERROR_INPUT,
                        "the hull of %lld points fails (Qhull error %d): they are too "
                        "nearly flat, or not finite",
                        (long long)points->count, failed);
    return taken ? QN_OK : qni_fail_memory(error, "a hull");
}

#else
qn_status qni_hull_make(qn_context *context, int dimension, const qni_points *points, bool *corner,
                        qni_hull *hull, qn_error *error) {
    (void)context, (void)dimension, (void)points, (void)corner;
    *hull = (qni_hull){0};
    return qni_fail(
        error, QN_ERROR_UNSUPPORTED,
        "hulls need the Qhull library: build with -Dqhull=enabled (Debian: libqhull-dev)");
}
#endif
