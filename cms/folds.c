// SPDX-License-Identifier: MIT
/* Do the creases of a leaf's triangles lie where the solid's are?
 *
 * Samples are where lattice edges cross the surface, and between two of them a crease can turn, at
 * a corner of facets, without leaving their triangles by more than the tolerance; the crease itself
 * then is off by twice that or more. So points of it are asked: each must be on the surface, and as
 * far beside it as the tolerance says each side must have the sheet of its own triangle. */
#include "cms/cms.h"
#include "cms/vector.h"

#include <math.h>

enum { ALONG = 3 };

/* An edge between two triangles of a patch that is to be a crease. */
typedef struct fold {
    double ends[2][3];
    double normals[2][3]; /* unit length, of the triangles on both sides */
    double into[2][3];    /* unit length, across the edge into each of them */
    double length;
} fold;

static bool is_sharp(const qni_patch *patch, int32_t vertex) {
    if (vertex < 0)
        return patch->loops[-1 - vertex].sharp_count > 0;
    return vertex < QNI_INNER && patch->vertices[vertex].sharp;
}

/* The edge of triangle `a` that `b` has, too, the other way round: the number of its first corner,
 * -1 for none. */
static int shared_edge(const int32_t a[4], const int32_t b[4]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (a[i] == b[(j + 1) % 3] && a[(i + 1) % 3] == b[j])
                return i;
    return -1;
}

static bool set_fold(const qni_patch *patch, const int32_t ends[2], const double a[3],
                     const double b[3], fold *out) {
    double way[3];
    for (int n = 0; n < 2; ++n)
        for (int k = 0; k < 3; ++k)
            out->ends[n][k] = (double)qni_patch_place(patch, ends[n])[k];
    for (int k = 0; k < 3; ++k) {
        way[k] = out->ends[1][k] - out->ends[0][k];
        out->normals[0][k] = a[k];
        out->normals[1][k] = b[k];
    }
    out->length = sqrt(qni_dot3(way, way));
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        out->into[0][k] = (a[l] * way[m] - a[m] * way[l]) / out->length;
        out->into[1][k] = (b[m] * way[l] - b[l] * way[m]) / out->length;
    }
    return out->length > 0;
}

/* Do the triangles turn by two thirds of what the sheets do (by their chords)? Else the crease
 * would fade. */
static bool turns_enough(const fold *edge, const double gradients[2][3]) {
    const double lengths =
        sqrt(qni_dot3(gradients[0], gradients[0]) * qni_dot3(gradients[1], gradients[1]));
    const double turn = 1 - qni_dot3(edge->normals[0], edge->normals[1]),
                 wanted = 1 - qni_dot3(gradients[0], gradients[1]) / (lengths > 0 ? lengths : 1);
    return 9 * turn >= 4 * wanted;
}

/* Has each side of the point its own triangle's sheet? */
static bool sides_hold(const qn_solid *solid, const fold *edge, const double point[3],
                       double beside) {
    double points[2][3], gradients[2][3];
    for (int n = 0; n < 2; ++n)
        for (int k = 0; k < 3; ++k)
            points[n][k] = point[k] + beside * edge->into[n][k];
    if (solid->ops->gradients(solid, 2, (const double(*)[3])points, gradients, NULL) != QN_OK)
        return false;
    for (int n = 0; n < 2; ++n)
        if (qni_dot3(gradients[n], edge->normals[n]) < qni_dot3(gradients[n], edge->normals[1 - n]))
            return false;
    return turns_enough(edge, gradients);
}

/* Points nearer to an end than the creases that meet there can be told apart say nothing. */
static bool fold_holds(const qni_patch *patch, const fold *edge, double least) {
    const double beside = fmax(least, fmin(patch->settings->tolerance, 0.2 * edge->length));
    for (int n = 1; n <= ALONG; ++n) {
        const double share = (double)n / (ALONG + 1);
        double point[3];
        if (edge->length * fmin(share, 1 - share) < 2 * beside)
            continue;
        for (int k = 0; k < 3; ++k)
            point[k] = edge->ends[0][k] + share * (edge->ends[1][k] - edge->ends[0][k]);
        if (!qni_is_on_surface(patch->solid, point, beside) ||
            !sides_hold(patch->solid, edge, point, beside))
            return false;
    }
    return true;
}

/* Does the edge that two triangles share lie where the solid's crease is, if it is to be one? */
static bool pair_holds(const qni_patch *patch, const int32_t a[4], const int32_t b[4],
                       const double m[3], const double n[3], double least) {
    /* Half the crease angle: what should be a crease, but is not sharp, is in the wrong place. */
    const double most = sqrt(fmax(0.5 + 0.5 * patch->settings->crease_cosine, 0));
    const int at = shared_edge(a, b);
    fold edge;
    if (at < 0 || qni_dot3(m, n) >= most)
        return true;
    const int32_t ends[2] = {a[at], a[(at + 1) % 3]};
    return !is_sharp(patch, ends[0]) || !is_sharp(patch, ends[1]) ||
           !set_fold(patch, ends, m, n, &edge) || fold_holds(patch, &edge, least);
}

bool qni_folds_hold(const qni_patch *patch, const double (*normals)[3], double least) {
    int64_t sharp = 0;
    for (int64_t n = 0; n < patch->loop_count; ++n)
        sharp += patch->loops[n].sharp_count;
    for (int64_t s = 0; s < patch->triangle_count && sharp; ++s)
        for (int64_t t = s + 1; t < patch->triangle_count; ++t)
            if (!pair_holds(patch, patch->triangles[s], patch->triangles[t], normals[s], normals[t],
                            least))
                return false;
    return true;
}

/* Does a triangle reach as far from its edge to another one as sides are asked? */
static bool is_wide(const qni_patch *patch, const int32_t a[4], const int32_t b[4]) {
    const int at = shared_edge(a, b);
    double p[3][3], way[3], off[3], turned[3];
    if (at < 0)
        return false;
    for (int n = 0; n < 3; ++n)
        for (int k = 0; k < 3; ++k)
            p[n][k] = (double)qni_patch_place(patch, a[(at + n) % 3])[k];
    for (int k = 0; k < 3; ++k) {
        way[k] = p[1][k] - p[0][k];
        off[k] = p[2][k] - p[0][k];
    }
    qni_cross3(way, off, turned);
    const double height2 = qni_dot3(turned, turned) / qni_dot3(way, way),
                 beside = patch->settings->tolerance;
    return height2 >= beside * beside;
}

bool qni_is_true_fold(const qni_patch *patch, const int32_t a[4], const int32_t b[4]) {
    double m[3], n[3];
    qni_patch_unit_normal(patch, a, m);
    qni_patch_unit_normal(patch, b, n);
    return is_wide(patch, a, b) && is_wide(patch, b, a) &&
           qni_dot3(m, n) < patch->settings->crease_cosine &&
           pair_holds(patch, a, b, m, n, patch->settings->tolerance);
}

/* A spoke between two triangles that hardly turn is no crease. */
static bool is_flat_spoke(const qni_patch *patch, const int32_t a[4], const int32_t b[4],
                          const double m[3], const double n[3]) {
    static const double least_turn = 0.996; /* 5 degrees */
    const int at = shared_edge(a, b);
    const int32_t from = a[at], to = a[(at + 1) % 3];
    return (from < 0 || to < 0) && is_sharp(patch, from) && is_sharp(patch, to) &&
           qni_dot3(m, n) > least_turn;
}

bool qni_loop_folds_hold(const qni_patch *patch, const qni_loop *loop) {
    const int64_t end = loop->triangle_first + loop->triangle_count;
    for (int64_t s = loop->triangle_first; s < end; ++s)
        for (int64_t t = s + 1; t < end; ++t) {
            const int32_t *a = patch->triangles[s], *b = patch->triangles[t];
            double m[3], n[3];
            if (!is_wide(patch, a, b) || !is_wide(patch, b, a))
                continue;
            qni_patch_unit_normal(patch, a, m);
            qni_patch_unit_normal(patch, b, n);
            if (is_flat_spoke(patch, a, b, m, n) ||
                !pair_holds(patch, a, b, m, n, patch->settings->tolerance))
                return false;
        }
    return true;
}

const qni_loop_vertex *qni_plane_beside(const qni_loop_vertex *v, int32_t count, int32_t from,
                                        int32_t step) {
    for (int32_t n = 1; n < count; ++n) {
        const qni_loop_vertex *vertex = &v[(from + n * step + n * count) % count];
        if (vertex->has_plane)
            return vertex;
    }
    return NULL;
}

/* Is it from one feature to the next across the wall of a step? Beyond both is the same sheet, or
 * one much like it, and the way goes down from the one and down to the other; along a crease it
 * goes along the sheet, or to the same side of both ends. */
static qni_doubt is_wall(const qni_patch *patch, const qni_loop_vertex *v, int32_t count,
                         int32_t from, int32_t to) {
    static const double clear_slope = 0.25, least_slope = 0.1;
    const double cosine = patch->settings->crease_cosine;
    const qni_loop_vertex *before = qni_plane_beside(v, count, from, -1),
                          *wall =
                              v[from].has_plane ? &v[from] : qni_plane_beside(v, count, from, 1),
                          *after = qni_plane_beside(v, count, to, 1);
    double way[3];
    for (int k = 0; k < 3; ++k)
        way[k] = (double)v[to].place[k] - (double)v[from].place[k];
    if (!before || !wall || !after || qni_dot3(before->normal, after->normal) < cosine ||
        qni_dot3(before->normal, wall->normal) > cosine ||
        qni_dot3(after->normal, wall->normal) > cosine)
        return QNI_NO_DOUBT;
    const double length = sqrt(qni_dot3(way, way)), down = qni_dot3(before->normal, way),
                 on = qni_dot3(after->normal, way), slope = fmin(fabs(down), fabs(on)) / length;
    if (!(down * on > 0) || !(slope > least_slope))
        return QNI_NO_DOUBT;
    return slope > clear_slope ? QNI_CLEAR_DOUBT : QNI_SLIGHT_DOUBT;
}

qni_doubt qni_step_turns_back(const qni_patch *patch, const qni_loop *loop) {
    const qni_loop_vertex *v = patch->vertices + loop->first;
    qni_doubt most = QNI_NO_DOUBT;
    for (int32_t from = 0; from < loop->count; ++from) {
        int32_t n = 1;
        if (!v[from].sharp)
            continue;
        while (n < loop->count && !v[(from + n) % loop->count].sharp)
            ++n;
        const qni_doubt wall = n < loop->count
                                   ? is_wall(patch, v, loop->count, from, (from + n) % loop->count)
                                   : QNI_NO_DOUBT;
        most = wall > most ? wall : most;
    }
    return most;
}
