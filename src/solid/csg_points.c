// SPDX-License-Identifier: MIT
/* Points whose hull is that of a shape, for hull() and for extents. A difference is taken for its
 * first part only when the rest leaves every corner of that part's hull; an intersection when its
 * parts are convex. */
#include <string.h>

#include "solid/csg_build.h"

/* Planes of an intersection whose corners are looked for by trying all triples. */
enum { MOST_PLANES = 64 };

static qn_status add_moved(qni_csg_builder *build, const double matrix[3][4], const double p[3],
                           qni_points *points) {
    double moved[3];
    for (int k = 0; k < 3; ++k)
        moved[k] = matrix[k][0] * p[0] + matrix[k][1] * p[1] + matrix[k][2] * p[2] + matrix[k][3];
    return qni_points_add(build->context, points, moved) ? QN_OK
                                                         : qni_fail_memory(build->error, "a hull");
}

static void multiply(const double a[3][4], const double b[3][4], double out[3][4]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j)
            out[i][j] =
                a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + (j == 3 ? a[i][3] : 0);
}

static qn_status of_children(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                             const double matrix[3][4], qni_points *points) {
    for (const qni_csg_call *child = call->children; child; child = child->next)
        if (qni_csg_dimension(child) == dimension)
            QN_TRY(qni_csg_points(build, child, dimension, matrix, points));
    return QN_OK;
}

/* The points gathered by `of_children` in the call's own coordinates, with what is then done to
 * them. */
typedef struct gathered {
    qni_points points;
    bool *corner;
} gathered;

static void gathered_free(qni_csg_builder *build, gathered *all) {
    qni_free(build->context, all->corner, all->points.count, sizeof *all->corner);
    qni_points_free(build->context, &all->points);
}

static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

/* Whether the solid takes away a corner of the hull of the points. */
static qn_status takes_corner(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                              const qn_solid *less, gathered *first) {
    qni_hull hull;
    first->corner = qni_alloc(build->context, first->points.count, sizeof *first->corner);
    if (!first->corner)
        return qni_fail_memory(build->error, "a hull");
    QN_TRY(qni_hull_make(build->context, dimension, &first->points, first->corner, &hull,
                         build->error));
    qni_hull_free(build->context, &hull);
    for (int64_t n = 0; n < first->points.count; ++n) {
        bool inside;
        if (!first->corner[n])
            continue;
        QN_TRY(qni_solid_contains(less, first->points.at[n], &inside));
        if (inside)
            return qni_csg_fail(
                build, call, QN_ERROR_UNSUPPORTED,
                "the hull or extent of a difference that takes away a corner is not supported");
    }
    return QN_OK;
}

/* The corners of the first child, once it is sure that the others leave them. */
static qn_status of_difference(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                               const double matrix[3][4], qni_points *points) {
    gathered first = {0};
    const qni_csg_call *child = call->children;
    while (child && qni_csg_dimension(child) != dimension)
        child = child->next;
    qn_status status =
        child ? qni_csg_points(build, child, dimension, identity, &first.points) : QN_OK;
    for (const qni_csg_call *next = child ? child->next : NULL; next && status == QN_OK;
         next = next->next) {
        qn_solid *less;
        if (qni_csg_dimension(next) != dimension || first.points.count == 0)
            continue;
        status = qni_csg_build(build, next, &less);
        if (status != QN_OK)
            break;
        qni_free(build->context, first.corner, first.points.count, sizeof *first.corner);
        first.corner = NULL;
        status = takes_corner(build, call, dimension, less, &first);
        qn_solid_destroy(less);
    }
    for (int64_t n = 0; status == QN_OK && n < first.points.count; ++n)
        status = add_moved(build, matrix, first.points.at[n], points);
    gathered_free(build, &first);
    return status;
}

/* Where three planes meet; in two dimensions the third one is z = 0. */
static bool meet(const qni_plane *a, const qni_plane *b, const qni_plane *c, double point[3]) {
    double inverse[3][4], rows[3][4];
    for (int k = 0; k < 3; ++k) {
        rows[0][k] = a->normal[k];
        rows[1][k] = b->normal[k];
        rows[2][k] = c->normal[k];
    }
    rows[0][3] = rows[1][3] = rows[2][3] = 0;
    if (!qni_invert((const double(*)[4])rows, inverse))
        return false;
    for (int k = 0; k < 3; ++k)
        point[k] =
            inverse[k][0] * a->distance + inverse[k][1] * b->distance + inverse[k][2] * c->distance;
    return true;
}

static bool within(const qni_plane *planes, int count, const double p[3]) {
    for (int n = 0; n < count; ++n) {
        const double *m = planes[n].normal;
        double size = fabs(planes[n].distance) + fabs(p[0]) + fabs(p[1]) + fabs(p[2]);
        if (m[0] * p[0] + m[1] * p[1] + m[2] * p[2] - planes[n].distance > 1e-11 * size)
            return false;
    }
    return true;
}

/* All corners of the convex body, by trying; none when it has no room inside. */
static qn_status corners_of(qni_csg_builder *build, int dimension, const qni_plane *planes,
                            int count, const double matrix[3][4], qni_points *points) {
    static const qni_plane ground = {{0, 0, 1}, 0, 0};
    gathered all = {0};
    qn_status status = QN_OK;
    for (int i = 0; i < count; ++i)
        for (int j = i + 1; j < count; ++j)
            for (int k = dimension == 3 ? j + 1 : count - 1; k < count && status == QN_OK; ++k) {
                double p[3];
                if (meet(&planes[i], &planes[j], dimension == 3 ? &planes[k] : &ground, p) &&
                    within(planes, count, p))
                    status = add_moved(build, identity, p, &all.points);
            }
    qni_hull hull = {0};
    if (status == QN_OK)
        status = qni_hull_make(build->context, dimension, &all.points, NULL, &hull, build->error);
    for (int64_t n = 0; status == QN_OK && !hull.flat && n < all.points.count; ++n)
        status = add_moved(build, matrix, all.points.at[n], points);
    qni_hull_free(build->context, &hull);
    gathered_free(build, &all);
    return status;
}

static qn_status of_intersection(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                                 const double matrix[3][4], qni_points *points) {
    qni_plane planes[MOST_PLANES];
    int used = 0;
    for (const qni_csg_call *child = call->children; child; child = child->next) {
        qn_solid *part;
        int64_t count = 0;
        if (qni_csg_dimension(child) != dimension)
            continue;
        QN_TRY(qni_csg_build(build, child, &part));
        bool empty = qni_box_is_nothing(&part->box);
        const qni_plane *own = qni_polytope_planes(part, &count);
        bool fits = own && used + count <= MOST_PLANES;
        if (fits)
            memcpy(planes + used, own, (size_t)count * sizeof *own);
        used += fits ? (int)count : 0;
        qn_solid_destroy(part);
        if (empty)
            return QN_OK;
        if (!fits)
            return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                                "the hull or extent of an intersection is supported for convex "
                                "parts of %d facets in all",
                                MOST_PLANES);
    }
    return corners_of(build, dimension, planes, used, matrix, points);
}

/* The flat shape's points at both ends. */
static qn_status of_linear_extrude(qni_csg_builder *build, const qni_csg_call *call,
                                   const double matrix[3][4], qni_points *points) {
    double height;
    bool centre;
    gathered flat = {0};
    qn_solid *checked; /* says what is wrong with the call */
    QN_TRY(qni_csg_linear_extrude(build, call, &checked));
    qn_solid_destroy(checked);
    QN_TRY(qni_csg_number(build, call, "height", 100, &height));
    QN_TRY(qni_csg_flag(build, call, "center", &centre));
    qn_status status = of_children(build, call, 2, identity, &flat.points);
    for (int64_t n = 0; status == QN_OK && n < 2 * flat.points.count; ++n) {
        const double *p = flat.points.at[n / 2];
        double low = centre ? -0.5 * height : 0;
        status = add_moved(build, matrix, (const double[3]){p[0], p[1], n % 2 ? low + height : low},
                           points);
    }
    gathered_free(build, &flat);
    return status;
}

qn_status qni_csg_points(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                         const double matrix[3][4], qni_points *points) {
    static const char *const primitives[] = {"cube",   "sphere",  "cylinder",  "square",
                                             "circle", "polygon", "polyhedron"};
    static const char *const groups[] = {"group", "union", "color", "render", "hull"};
    for (size_t i = 0; i < sizeof primitives / sizeof *primitives; ++i)
        if (qni_csg_is(call, primitives[i])) {
            gathered own = {0};
            qn_status status = qni_csg_corners(build, call, &own.points);
            for (int64_t n = 0; status == QN_OK && n < own.points.count; ++n)
                status = add_moved(build, matrix, own.points.at[n], points);
            gathered_free(build, &own);
            return status;
        }
    for (size_t i = 0; i < sizeof groups / sizeof *groups; ++i)
        if (qni_csg_is(call, groups[i]))
            return of_children(build, call, dimension, matrix, points);
    if (qni_csg_is(call, "multmatrix")) {
        double own[3][4], both[3][4];
        QN_TRY(qni_csg_matrix(build, call, dimension, own));
        multiply(matrix, (const double(*)[4])own, both);
        return of_children(build, call, dimension, (const double(*)[4])both, points);
    }
    if (qni_csg_is(call, "difference"))
        return of_difference(build, call, dimension, matrix, points);
    if (qni_csg_is(call, "intersection"))
        return of_intersection(build, call, dimension, matrix, points);
    if (qni_csg_is(call, "linear_extrude"))
        return of_linear_extrude(build, call, matrix, points);
    return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                        "this module is not supported within a hull or as the "
                        "outline of rotate_extrude");
}

/* The hull of the points, as a solid. */
static qn_status hull_of(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                         const qni_points *points, int32_t owner, qn_solid **solid_out) {
    qni_hull hull = {0};
    if (points->count == 0)
        return qni_csg_give(build, qni_empty_create(build->context), solid_out);
    QN_TRY(qni_hull_make(build->context, dimension, points, NULL, &hull, build->error));
    if (hull.flat)
        return qni_csg_fail(build, call, QN_ERROR_INPUT,
                            "all its points lie in one plane: there is no room inside");
    qni_box box = qni_box_everything();
    for (int k = 0; k < dimension; ++k) {
        box.low[k] = box.high[k] = points->at[0][k];
        for (int64_t n = 1; n < points->count; ++n) {
            box.low[k] = fmin(box.low[k], points->at[n][k]);
            box.high[k] = fmax(box.high[k], points->at[n][k]);
        }
    }
    qn_status status =
        qni_csg_give(build,
                     qni_polytope_create(build->context, hull.plane_count,
                                         (const double(*)[4])hull.planes, &box, owner),
                     solid_out);
    qni_hull_free(build->context, &hull);
    return status;
}

qn_status qni_csg_hull(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out) {
    int dimension = qni_csg_dimension(call);
    gathered all = {0};
    int32_t owner = ++build->owner;
    qn_status status = of_children(build, call, dimension, identity, &all.points);
    if (status == QN_OK)
        status = hull_of(build, call, dimension, &all.points, owner, solid_out);
    gathered_free(build, &all);
    return status;
}

/* The corners of one part of a minkowski(), which must be convex. */
static qn_status convex_corners(qni_csg_builder *build, const qni_csg_call *call,
                                const qni_csg_call *child, int dimension, qni_points *points) {
    qn_solid *part;
    int64_t count;
    QN_TRY(qni_csg_build(build, child, &part));
    bool convex = qni_polytope_planes(part, &count) != NULL;
    qn_solid_destroy(part);
    if (!convex || qni_csg_dimension(child) != dimension)
        return qni_csg_fail(
            build, call, QN_ERROR_UNSUPPORTED,
            "line %lld: only convex parts with flat facets, each of one piece, can be added up",
            (long long)child->line);
    return qni_csg_points(build, child, dimension, identity, points);
}

enum { MOST_SUMS = 1 << 21 };

/* sums = all sums of a point of `a` and a point of `b`. */
static qn_status add_up(qni_csg_builder *build, const qni_csg_call *call, const qni_points *a,
                        const qni_points *b, qni_points *sums) {
    if (a->count > MOST_SUMS / (b->count > 0 ? b->count : 1))
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "%lld times %lld corners are too many to add up", (long long)a->count,
                            (long long)b->count);
    for (int64_t i = 0; i < a->count; ++i)
        for (int64_t j = 0; j < b->count; ++j) {
            const double sum[3] = {a->at[i][0] + b->at[j][0], a->at[i][1] + b->at[j][1],
                                   a->at[i][2] + b->at[j][2]};
            if (!qni_points_add(build->context, sums, sum))
                return qni_fail_memory(build->error, "a hull");
        }
    return QN_OK;
}

qn_status qni_csg_minkowski(qni_csg_builder *build, const qni_csg_call *call,
                            qn_solid **solid_out) {
    int dimension = qni_csg_dimension(call);
    qni_points sum = {0};
    int32_t owner = build->owner + 1;
    qn_status status = QN_OK;
    for (const qni_csg_call *child = call->children; child && status == QN_OK;
         child = child->next) {
        qni_points own = {0}, more = {0};
        status =
            convex_corners(build, call, child, dimension, child == call->children ? &sum : &own);
        if (status == QN_OK && child != call->children) {
            status = add_up(build, call, &sum, &own, &more);
            qni_points_free(build->context, &sum);
            sum = more;
        }
        qni_points_free(build->context, &own);
    }
    if (status == QN_OK)
        status = hull_of(build, call, dimension, &sum, owner, solid_out);
    qni_points_free(build->context, &sum);
    return status;
}
