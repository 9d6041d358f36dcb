// SPDX-License-Identifier: MIT
/* Polyhedra from points and faces. Convex ones become polytopes. Others keep their triangles: the
 * value is the distance to the nearest one, inside by the parity of a ray along +x, whatever way
 * round the faces are given; a box keeps the triangles that can be nearest in it, and those that
 * rays from it can meet. */
#include "solid/polyhedron.h"

#include <stdlib.h>
#include <string.h>

#include "solid/polynomial.h"

typedef struct triangle {
    double at[3][3];
    double normal[3];
} triangle;

typedef struct polyhedron {
    qn_solid base;
    triangle *triangles; /* `near` for distances, then `across` for rays */
    int64_t near, across;
} polyhedron;

static int64_t room(const polyhedron *p) {
    return p->near + p->across;
}

static void destroy(qn_solid *solid) {
    polyhedron *p = (polyhedron *)solid;
    qni_free(solid->context, p->triangles, room(p), sizeof *p->triangles);
    qni_solid_free(solid, sizeof *p);
}

static double dot(const double u[3], const double v[3]) {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static void subtract(const double u[3], const double v[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = u[k] - v[k];
}

static void cross(const double u[3], const double v[3], double out[3]) {
    out[0] = u[1] * v[2] - u[2] * v[1];
    out[1] = u[2] * v[0] - u[0] * v[2];
    out[2] = u[0] * v[1] - u[1] * v[0];
}

static double square_to_edge(const double a[3], const double b[3], const double p[3],
                             double offset[3]) {
    double along[3], from[3];
    subtract(b, a, along);
    subtract(p, a, from);
    double t = dot(from, along) / dot(along, along);
    t = t > 0 ? t < 1 ? t : 1 : 0;
    for (int k = 0; k < 3; ++k)
        offset[k] = from[k] - t * along[k];
    return dot(offset, offset);
}

/* The squared distance to a triangle and the offset from its nearest point: in its plane when the
 * foot lies within. */
static double square_to(const triangle *t, const double p[3], double offset[3]) {
    double from[3], edge[3], side[3], best[3] = {0, 0, 0}, least = QNI_INFINITY;
    bool within = true;
    for (int k = 0; k < 3; ++k) {
        const double *a = t->at[k], *b = t->at[(k + 1) % 3];
        subtract(b, a, edge);
        subtract(p, a, from);
        cross(edge, from, side);
        within = within && dot(side, t->normal) >= 0;
    }
    if (within) {
        subtract(p, t->at[0], from);
        double height = dot(from, t->normal);
        for (int k = 0; k < 3; ++k)
            offset[k] = height * t->normal[k];
        return height * height;
    }
    for (int k = 0; k < 3; ++k) {
        double each[3], square = square_to_edge(t->at[k], t->at[(k + 1) % 3], p, each);
        if (square < least) {
            least = square;
            memcpy(best, each, sizeof best);
        }
    }
    memcpy(offset, best, sizeof best);
    return least;
}

/* Whether the edge's shadow on the y-z plane passes above (y, z) in y; the lower end in z first,
 * for equal bits. */
static bool edge_above(const double *a, const double *b, double y, double z) {
    bool up = a[2] < b[2] || (a[2] == b[2] && a[1] < b[1]);
    const double *low = up ? a : b, *high = up ? b : a;
    return (low[2] > z) != (high[2] > z) &&
           y < low[1] + (z - low[2]) * (high[1] - low[1]) / (high[2] - low[2]);
}

/* Whether the ray from p along +x meets the triangle. */
static bool meets(const triangle *t, const double p[3]) {
    bool covers = false;
    for (int k = 0; k < 3; ++k)
        covers ^= edge_above(t->at[k], t->at[(k + 1) % 3], p[1], p[2]);
    if (!covers)
        return false;
    double from[3];
    subtract(t->at[0], p, from);
    return dot(from, t->normal) / t->normal[0] > 0;
}

static double value_at(const polyhedron *p, const double at[3]) {
    double least = QNI_INFINITY, offset[3];
    bool inside = false;
    for (int64_t n = 0; n < p->near; ++n) {
        double square = square_to(&p->triangles[n], at, offset);
        least = square < least ? square : least;
    }
    for (int64_t n = p->near; n < room(p); ++n)
        inside ^= meets(&p->triangles[n], at);
    double distance = sqrt(least);
    distance = distance > 0 ? distance : QNI_TIE;
    return inside ? -distance : distance;
}

static qn_status polyhedron_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                   double *values) {
    for (int64_t n = 0; n < count; ++n)
        values[n] = value_at((const polyhedron *)solid, points[n]);
    return QN_OK;
}

/* Away from the nearest point; on the surface across the triangle, to the side that is outside. */
static void gradient_at(const polyhedron *p, const double at[3], double gradient[3]) {
    double least = QNI_INFINITY, offset[3] = {0, 0, 0},
           size = fabs(at[0]) + fabs(at[1]) + fabs(at[2]);
    const triangle *nearest = &p->triangles[0];
    for (int64_t n = 0; n < p->near; ++n) {
        double each[3], square = square_to(&p->triangles[n], at, each);
        if (square < least) {
            least = square;
            nearest = &p->triangles[n];
            memcpy(offset, each, sizeof offset);
        }
    }
    double sign = value_at(p, at) < 0 ? -1 : 1, beside[3], across[3], step = 1e-9 * (size + 1e-30);
    for (int k = 0; k < 3; ++k)
        beside[k] = at[k] + step * nearest->normal[k];
    bool turn = value_at(p, beside) < 0;
    for (int k = 0; k < 3; ++k) {
        across[k] = turn ? -nearest->normal[k] : nearest->normal[k];
        offset[k] *= sign;
    }
    qni_unit(sqrt(least) <= step * 1e-3 ? across : offset, across, gradient);
}

static qn_status polyhedron_gradients(const qn_solid *solid, int64_t count,
                                      const double (*points)[3], double (*gradients)[3],
                                      int32_t *owners) {
    for (int64_t n = 0; gradients && n < count; ++n)
        gradient_at((const polyhedron *)solid, points[n], gradients[n]);
    for (int64_t n = 0; owners && n < count; ++n)
        owners[n] = solid->owner;
    return QN_OK;
}

/* The value in the middle of the box, and how far it can change: distances change by as much as one
 * moves. */
static double middle_of(const polyhedron *p, const qni_box *box, double centre[3],
                        double *reach_out) {
    double squares = 0, size = 0;
    for (int k = 0; k < 3; ++k) {
        centre[k] = 0.5 * (box->low[k] + box->high[k]);
        double half = fmax(box->high[k] - centre[k], centre[k] - box->low[k]);
        squares += half * half;
        size += fabs(centre[k]);
    }
    double value = value_at(p, centre);
    *reach_out = sqrt(squares) + 64 * QNI_EPSILON * (fabs(value) + sqrt(squares) + size) + QNI_TIE;
    return value;
}

static qn_status polyhedron_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    double centre[3], reach, value = middle_of((const polyhedron *)solid, box, centre, &reach);
    range[0] = value - reach;
    range[1] = value + reach;
    return QN_OK;
}

/* Where the line passes through the triangle, as a place on the segment. */
static bool line_meets(const triangle *t, const double a[3], const double along[3],
                       double *place_out) {
    bool left[3];
    for (int k = 0; k < 3; ++k) {
        /* Each edge from its smaller end, so that both triangles at it decide alike. */
        const double *p = t->at[k], *q = t->at[(k + 1) % 3];
        bool swap = memcmp(p, q, 3 * sizeof *p) > 0;
        double from[3], to[3], side[3];
        subtract(swap ? q : p, a, from);
        subtract(swap ? p : q, a, to);
        cross(from, to, side);
        left[k] = (dot(side, along) >= 0) != swap;
    }
    double slant = dot(t->normal, along), from[3];
    if (left[0] != left[1] || left[1] != left[2] || slant == 0)
        return false;
    subtract(t->at[0], a, from);
    *place_out = dot(t->normal, from) / slant;
    return *place_out > -1e-3 && *place_out < 1.001;
}

static const triangle *triangle_at(const polyhedron *p, const double a[3], const double b[3],
                                   double place) {
    const triangle *best = &p->triangles[0];
    double point[3], least = QNI_INFINITY, offset[3];
    for (int k = 0; k < 3; ++k)
        point[k] = a[k] + place * (b[k] - a[k]);
    for (int64_t n = 0; n < p->near; ++n) {
        double square = square_to(&p->triangles[n], point, offset);
        if (square < least) {
            least = square;
            best = &p->triangles[n];
        }
    }
    return best;
}

static qn_status polyhedron_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                      int32_t capacity, qni_crossing *crossings,
                                      int32_t *count_out) {
    const polyhedron *p = (const polyhedron *)solid;
    double places[QNI_CROSSINGS + 1], along[3];
    int count = 0;
    subtract(b, a, along);
    for (int64_t n = 0; n < p->near && count < QNI_CROSSINGS; ++n) {
        double place;
        if (!line_meets(&p->triangles[n], a, along, &place))
            continue;
        int at = count++;
        for (; at > 0 && places[at - 1] > place; --at)
            places[at] = places[at - 1];
        places[at] = place;
    }
    bool inside = value_at(p, a) < 0;
    count = qni_match_ends(places, count, inside, value_at(p, b) < 0);
    while (count > capacity)
        count -= 2;
    for (int i = 0; i < count; ++i, inside = !inside) {
        const double *normal = triangle_at(p, a, b, places[i])->normal;
        double sign = (dot(normal, along) > 0) == inside ? 1 : -1;
        crossings[i] = (qni_crossing){.at = places[i], .owner = solid->owner, .enters = !inside};
        for (int k = 0; k < 3; ++k)
            crossings[i].normal[k] = sign * normal[k];
    }
    *count_out = count > 0 ? count : 0;
    return QN_OK;
}

/* Whether a ray from the box along +x may meet the triangle. */
static bool may_meet(const triangle *t, const qni_box *box) {
    for (int k = 0; k < 3; ++k) {
        double low = fmin(t->at[0][k], fmin(t->at[1][k], t->at[2][k]));
        double high = fmax(t->at[0][k], fmax(t->at[1][k], t->at[2][k]));
        if (high < box->low[k] || (k > 0 && low > box->high[k]))
            return false;
    }
    return true;
}

static polyhedron *create(qn_context *context, int64_t near, int64_t across);

static qn_status polyhedron_restrict(const qn_solid *solid, const qni_box *box,
                                     qn_solid **solid_out) {
    const polyhedron *p = (const polyhedron *)solid;
    double centre[3], reach, value = middle_of(p, box, centre, &reach), offset[3];
    double most = (fabs(value) + 2 * reach) * (1 + 1e-12);
    int64_t near = 0, across = 0, used = 0;
    for (int64_t n = 0; n < p->near; ++n)
        near += square_to(&p->triangles[n], centre, offset) <= most * most;
    for (int64_t n = p->near; n < room(p); ++n)
        across += may_meet(&p->triangles[n], box);
    *solid_out = NULL;
    if (near == p->near && across == p->across)
        return qni_restrict_to_itself(solid, box, solid_out);
    polyhedron *smaller = create(solid->context, near, across);
    if (!smaller)
        return QN_ERROR_OUT_OF_MEMORY;
    smaller->base.box = solid->box;
    smaller->base.owner = solid->owner;
    for (int64_t n = 0; n < p->near; ++n)
        if (square_to(&p->triangles[n], centre, offset) <= most * most)
            smaller->triangles[used++] = p->triangles[n];
    for (int64_t n = p->near; n < room(p); ++n)
        if (may_meet(&p->triangles[n], box))
            smaller->triangles[used++] = p->triangles[n];
    *solid_out = &smaller->base;
    return QN_OK;
}

/* A distance grows by one at most. */
static bool polyhedron_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    (void)solid, (void)box;
    for (int k = 0; k < 3; ++k) {
        ranges[k][0] = -1;
        ranges[k][1] = 1;
    }
    return true;
}

static const qni_solid_ops polyhedron_ops = {
    .destroy = destroy,
    .values = polyhedron_values,
    .gradients = polyhedron_gradients,
    .bounds = polyhedron_bounds,
    .crossings = polyhedron_crossings,
    .restrict_to = polyhedron_restrict,
    .slopes = polyhedron_slopes,
};

static polyhedron *create(qn_context *context, int64_t near, int64_t across) {
    polyhedron *p = (polyhedron *)qni_solid_new(context, sizeof *p, &polyhedron_ops);
    if (!p)
        return NULL;
    p->near = near;
    p->across = across;
    p->triangles = qni_alloc(context, near + across, sizeof *p->triangles);
    if (p->triangles)
        return p;
    qni_solid_free(&p->base, sizeof *p);
    return NULL;
}

/* False for a triangle without area, which bounds nothing. */
static bool set_triangle(triangle *t, const double (*points)[3], const int64_t corners[3]) {
    double u[3], v[3];
    for (int k = 0; k < 3; ++k)
        memcpy(t->at[k], points[corners[k]], sizeof t->at[k]);
    subtract(t->at[1], t->at[0], u);
    subtract(t->at[2], t->at[0], v);
    cross(u, v, t->normal);
    double length = sqrt(dot(t->normal, t->normal));
    for (int k = 0; k < 3; ++k)
        t->normal[k] /= length;
    return length > 0 && length < QNI_INFINITY;
}

static qni_box box_of(int64_t count, const double (*points)[3]) {
    qni_box box = {{QNI_INFINITY, QNI_INFINITY, QNI_INFINITY},
                   {-QNI_INFINITY, -QNI_INFINITY, -QNI_INFINITY}};
    for (int64_t n = 0; n < count; ++n)
        for (int k = 0; k < 3; ++k) {
            box.low[k] = fmin(box.low[k], points[n][k]);
            box.high[k] = fmax(box.high[k], points[n][k]);
        }
    return box;
}

/* The planes of the triangles when all points lie on one side of each, coplanar ones once; 0 planes
 * otherwise. */
static int64_t convex_planes(const triangle *triangles, int64_t count, int64_t point_count,
                             const double (*points)[3], double (*planes)[4]) {
    int64_t used = 0;
    for (int64_t n = 0; n < count; ++n) {
        const triangle *t = &triangles[n];
        double distance = dot(t->normal, t->at[0]), above = 0, below = 0, size = 0;
        for (int64_t i = 0; i < point_count; ++i) {
            double height = dot(t->normal, points[i]) - distance;
            above = fmax(above, height);
            below = fmax(below, -height);
            size = fmax(size, fabs(points[i][0]) + fabs(points[i][1]) + fabs(points[i][2]));
        }
        double sign = above > below ? -1 : 1;
        if (fmin(above, below) > 1e-12 * size || fmax(above, below) <= 1e-12 * size)
            return 0;
        bool known = false;
        for (int64_t i = 0; i < used && !known; ++i)
            known = sign * dot(t->normal, planes[i]) > 1 - 1e-12 &&
                    fabs(planes[i][3] - sign * distance) <= 1e-12 * size;
        if (known)
            continue;
        for (int k = 0; k < 3; ++k)
            planes[used][k] = sign * t->normal[k];
        planes[used++][3] = sign * distance;
    }
    return used;
}

static int compare_edges(const void *a, const void *b) {
    return memcmp(a, b, 2 * sizeof(int64_t));
}

bool qni_triangles_are_closed(qn_context *context, int64_t count, const int64_t (*corners)[3],
                              bool *closed_out) {
    int64_t(*edges)[2] = qni_alloc(context, 3 * count, sizeof *edges);
    if (!edges)
        return false;
    for (int64_t n = 0; n < 3 * count; ++n) {
        int64_t a = corners[n / 3][n % 3], b = corners[n / 3][(n + 1) % 3];
        edges[n][0] = a < b ? a : b;
        edges[n][1] = a < b ? b : a;
    }
    qsort(edges, (size_t)(3 * count), sizeof *edges, compare_edges);
    *closed_out = true;
    for (int64_t n = 0; n < 3 * count && *closed_out; n += 2)
        *closed_out = n + 1 < 3 * count && compare_edges(edges[n], edges[n + 1]) == 0;
    qni_free(context, edges, 3 * count, sizeof *edges);
    return true;
}

qn_solid *qni_polyhedron_create(qn_context *context, int64_t point_count, const double (*points)[3],
                                int64_t count, const int64_t (*corners)[3], int32_t owner) {
    polyhedron *p = create(context, count, count);
    double(*planes)[4] = qni_alloc(context, count, sizeof *planes);
    qn_solid *solid = NULL;
    int64_t used = 0;
    qni_box box = box_of(point_count, points);
    for (int64_t n = 0; p && planes && n < count; ++n)
        used += set_triangle(&p->triangles[used], points, corners[n]);
    int64_t plane_count =
        p && planes ? convex_planes(p->triangles, used, point_count, points, planes) : 0;
    if (p && planes && (used < 4 || qni_box_is_nothing(&box)))
        solid = qni_empty_create(context);
    else if (plane_count > 0)
        solid = qni_polytope_create(context, plane_count, (const double(*)[4])planes, &box, owner);
    else if (p && planes) {
        polyhedron *exact = create(context, used, used);
        for (int64_t n = 0; exact && n < 2 * used; ++n)
            exact->triangles[n] = p->triangles[n % used];
        if (exact) {
            exact->base.box = box;
            exact->base.owner = owner;
        }
        solid = exact ? &exact->base : NULL;
    }
    if (p)
        destroy(&p->base);
    qni_free(context, planes, count, sizeof *planes);
    return solid;
}
