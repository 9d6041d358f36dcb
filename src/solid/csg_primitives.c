// SPDX-License-Identifier: MIT
/* OpenSCAD's primitives as solids, and their corners for hulls. */
#include <string.h>

#include "solid/csg_build.h"
#include "solid/facets.h"

/* What cube, sphere, cylinder, square and circle come to: nothing when there is no room inside. */
typedef struct shape {
    double low[3], high[3]; /* of cube and square; z of cylinders */
    double low_radius, high_radius;
    int32_t fragments;
    bool empty;
} shape;

static qn_status read_block(qni_csg_builder *build, const qni_csg_call *call, int dimension,
                            shape *out) {
    double size[3];
    bool centre;
    QN_TRY(qni_csg_numbers(build, call, "size", dimension, size));
    QN_TRY(qni_csg_flag(build, call, "center", &centre));
    for (int k = 0; k < dimension; ++k) {
        out->empty = out->empty || !(size[k] > 0);
        out->low[k] = centre ? -0.5 * size[k] : 0;
        out->high[k] = centre ? 0.5 * size[k] : size[k];
    }
    return QN_OK;
}

/* Spheres and circles. */
static qn_status read_round(qni_csg_builder *build, const qni_csg_call *call, shape *out) {
    QN_TRY(qni_csg_number(build, call, "r", (double)NAN, &out->low_radius));
    out->high_radius = out->low_radius;
    out->empty = !(out->low_radius > 0);
    return qni_csg_fragments(build, call, out->low_radius, &out->fragments);
}

static qn_status read_cylinder(qni_csg_builder *build, const qni_csg_call *call, shape *out) {
    double height;
    bool centre;
    QN_TRY(qni_csg_number(build, call, "h", (double)NAN, &height));
    QN_TRY(qni_csg_number(build, call, "r1", (double)NAN, &out->low_radius));
    QN_TRY(qni_csg_number(build, call, "r2", (double)NAN, &out->high_radius));
    QN_TRY(qni_csg_flag(build, call, "center", &centre));
    double largest = fmax(out->low_radius, out->high_radius);
    out->empty = !(height > 0 && largest > 0 && out->low_radius >= 0 && out->high_radius >= 0);
    out->low[2] = centre ? -0.5 * height : 0;
    out->high[2] = centre ? 0.5 * height : height;
    return qni_csg_fragments(build, call, largest, &out->fragments);
}

static qn_status read_shape(qni_csg_builder *build, const qni_csg_call *call, shape *out) {
    *out = (shape){.empty = false};
    if (qni_csg_is(call, "cube"))
        return read_block(build, call, 3, out);
    if (qni_csg_is(call, "square"))
        return read_block(build, call, 2, out);
    return qni_csg_is(call, "cylinder") ? read_cylinder(build, call, out)
                                        : read_round(build, call, out);
}

/* Upright planes round a box in the first `dimension` axes. */
static qn_solid *block(qni_csg_builder *build, const shape *s, int dimension) {
    double planes[6][4] = {{0}};
    qni_box box = qni_box_everything();
    for (int k = 0; k < dimension; ++k) {
        planes[2 * k][k] = -1;
        planes[2 * k][3] = -s->low[k];
        planes[2 * k + 1][k] = 1;
        planes[2 * k + 1][3] = s->high[k];
        box.low[k] = s->low[k];
        box.high[k] = s->high[k];
    }
    return qni_polytope_create(build->context, 2 * dimension, (const double(*)[4])planes, &box,
                               build->owner);
}

/* A prism without ends over a convex polygon given counter-clockwise. */
static qn_solid *convex_prism(qni_csg_builder *build, int64_t count, const double (*points)[2]) {
    double(*planes)[4] = qni_alloc(build->context, count, sizeof *planes);
    if (!planes)
        return NULL;
    qni_box box = {{QNI_INFINITY, QNI_INFINITY, -QNI_INFINITY},
                   {-QNI_INFINITY, -QNI_INFINITY, QNI_INFINITY}};
    for (int64_t n = 0; n < count; ++n) {
        const double *from = points[n], *to = points[(n + 1) % count];
        planes[n][0] = to[1] - from[1];
        planes[n][1] = from[0] - to[0];
        planes[n][2] = 0;
        planes[n][3] = planes[n][0] * from[0] + planes[n][1] * from[1];
        for (int k = 0; k < 2; ++k) {
            box.low[k] = fmin(box.low[k], from[k]);
            box.high[k] = fmax(box.high[k], from[k]);
        }
    }
    qn_solid *solid =
        qni_polytope_create(build->context, count, (const double(*)[4])planes, &box, build->owner);
    qni_free(build->context, planes, count, sizeof *planes);
    return solid;
}

static qn_solid *circle(qni_csg_builder *build, const shape *s) {
    if (build->smooth) {
        qn_solid *solid = qni_cone_create(build->context, s->low_radius, 0, build->owner);
        for (int k = 0; solid && k < 2; ++k) {
            solid->box.low[k] = -s->low_radius;
            solid->box.high[k] = s->low_radius;
        }
        return solid;
    }
    double(*points)[2] = qni_alloc(build->context, s->fragments, sizeof *points);
    if (!points)
        return NULL;
    for (int32_t n = 0; n < s->fragments; ++n)
        qni_circle_point(s->low_radius, s->fragments, n, points[n]);
    qn_solid *solid = convex_prism(build, s->fragments, (const double(*)[2])points);
    qni_free(build->context, points, s->fragments, sizeof *points);
    return solid;
}

static qn_solid *solid_of(qni_csg_builder *build, const qni_csg_call *call, const shape *s) {
    static const double origin[3] = {0, 0, 0};
    if (s->empty)
        return qni_empty_create(build->context);
    if (qni_csg_is(call, "cube"))
        return block(build, s, 3);
    if (qni_csg_is(call, "square"))
        return block(build, s, 2);
    if (qni_csg_is(call, "circle"))
        return circle(build, s);
    if (qni_csg_is(call, "sphere"))
        return build->smooth
                   ? qni_sphere_create(build->context, origin, s->low_radius, build->owner)
                   : qni_facet_sphere(build->context, s->low_radius, s->fragments, build->owner);
    double height = s->high[2] - s->low[2];
    return build->smooth ? qni_round_cylinder(build->context, s->low[2], height, s->low_radius,
                                              s->high_radius, build->owner)
                         : qni_facet_cylinder(build->context, s->low[2], height, s->low_radius,
                                              s->high_radius, s->fragments, build->owner);
}

static qn_status add(qni_csg_builder *build, qni_points *points, double x, double y, double z) {
    const double point[3] = {x, y, z};
    return qni_points_add(build->context, points, point) ? QN_OK
                                                         : qni_fail_memory(build->error, "a hull");
}

static qn_status ring(qni_csg_builder *build, qni_points *points, double radius, int32_t fragments,
                      double z) {
    if (radius == 0)
        return add(build, points, 0, 0, z);
    for (int32_t n = 0; n < fragments; ++n) {
        double point[2];
        qni_circle_point(radius, fragments, n, point);
        QN_TRY(add(build, points, point[0], point[1], z));
    }
    return QN_OK;
}

/* The lists `points` and `paths` of a polygon, as an outline; its memory goes with `points`. */
typedef struct outline {
    double (*points)[2];
    int64_t *sizes;
    int64_t count, contours;
} outline;

static void outline_free(qni_csg_builder *build, outline *o) {
    qni_free(build->context, o->points, o->count, sizeof *o->points);
    qni_free(build->context, o->sizes, o->contours, sizeof *o->sizes);
}

static bool is_list(const qni_csg_value *value) {
    return value && value->kind == QNI_CSG_VECTOR;
}

/* The coordinates of one point of a list. */
static bool coordinates(const qni_csg_value *point, int dimension, double *out) {
    if (!is_list(point) || point->count < dimension)
        return false;
    const qni_csg_value *item = point->items;
    for (int k = 0; k < dimension; ++k, item = item->next) {
        if (item->kind != QNI_CSG_NUMBER || !isfinite(item->number))
            return false;
        out[k] = item->number;
    }
    return true;
}

/* The points that the paths name, path by path; all of them in one path when there are none.
 * `given` has all points. */
static qn_status follow_paths(qni_csg_builder *build, const qni_csg_call *call,
                              const qni_csg_value *paths, const double (*given)[2],
                              int64_t given_count, outline *out) {
    int64_t used = 0, path_number = 0;
    for (const qni_csg_value *path = paths->items; path; path = path->next, ++path_number) {
        out->sizes[path_number] = path->count;
        for (const qni_csg_value *item = path->items; item; item = item->next) {
            if (item->kind != QNI_CSG_NUMBER ||
                !(item->number >= 0 && item->number < (double)given_count))
                return qni_csg_fail(build, call, QN_ERROR_INPUT,
                                    "path %lld names a point that is not one of the %lld",
                                    (long long)path_number, (long long)given_count);
            memcpy(out->points[used++], given[(int64_t)item->number], sizeof *out->points);
        }
    }
    return QN_OK;
}

static qn_status count_paths(qni_csg_builder *build, const qni_csg_call *call,
                             const qni_csg_value *paths, outline *out) {
    if (!is_list(paths))
        return qni_csg_fail(build, call, QN_ERROR_INPUT,
                            "paths must be a list of lists of point numbers");
    out->contours = paths->count;
    for (const qni_csg_value *path = paths->items; path; path = path->next) {
        if (!is_list(path))
            return qni_csg_fail(build, call, QN_ERROR_INPUT,
                                "paths must be a list of lists of point numbers");
        out->count += path->count;
    }
    return QN_OK;
}

static qn_status read_outline(qni_csg_builder *build, const qni_csg_call *call, outline *out) {
    const qni_csg_value *list = qni_csg_find(call, "points"), *paths = qni_csg_find(call, "paths");
    *out = (outline){.count = 0};
    if (!is_list(list))
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "points must be a list of points");
    int64_t given_count = list->count, n = 0;
    double(*given)[2] = qni_alloc(build->context, given_count, sizeof *given);
    if (!given)
        return qni_fail_memory(build->error, "a polygon");
    qn_status status = QN_OK;
    for (const qni_csg_value *point = list->items; point && status == QN_OK;
         point = point->next, ++n)
        if (!coordinates(point, 2, given[n]))
            status = qni_csg_fail(build, call, QN_ERROR_INPUT,
                                  "point %lld is not two finite numbers", (long long)n);
    if (status == QN_OK && !paths) {
        out->points = given;
        out->count = given_count;
        out->contours = 1;
        out->sizes = qni_alloc(build->context, 1, sizeof *out->sizes);
        if (out->sizes)
            out->sizes[0] = given_count;
        return out->sizes ? QN_OK : qni_fail_memory(build->error, "a polygon");
    }
    if (status == QN_OK)
        status = count_paths(build, call, paths, out);
    if (status == QN_OK) {
        out->points = qni_alloc(build->context, out->count, sizeof *out->points);
        out->sizes = qni_alloc(build->context, out->contours, sizeof *out->sizes);
        status = out->points && out->sizes
                     ? follow_paths(build, call, paths, (const double(*)[2])given, given_count, out)
                     : qni_fail_memory(build->error, "a polygon");
    }
    qni_free(build->context, given, given_count, sizeof *given);
    return status;
}

/* 1 or -1 when the contour is convex and goes round once, by its direction; else 0. */
static int convexity(const outline *o) {
    if (o->contours != 1 || o->count < 3)
        return 0;
    int direction = 0, flips = 0, last_sign = 0, first_sign = 0;
    for (int64_t n = 0; n < o->count; ++n) {
        const double *a = o->points[n], *b = o->points[(n + 1) % o->count],
                     *c = o->points[(n + 2) % o->count];
        double turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]),
               dx = b[0] - a[0];
        int sign = turn > 0 ? 1 : turn < 0 ? -1 : 0, side = dx > 0 ? 1 : dx < 0 ? -1 : 0;
        if (sign == 0 || (direction && sign != direction))
            return 0;
        direction = sign;
        if (side && last_sign && side != last_sign)
            ++flips;
        first_sign = first_sign ? first_sign : side;
        last_sign = side ? side : last_sign;
    }
    flips += first_sign != last_sign;
    return flips <= 2 ? direction : 0;
}

static void reverse(outline *o) {
    for (int64_t i = 0, j = o->count - 1; i < j; ++i, --j)
        for (int k = 0; k < 2; ++k) {
            double swap = o->points[i][k];
            o->points[i][k] = o->points[j][k];
            o->points[j][k] = swap;
        }
}

static qn_status polygon(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out) {
    outline o;
    qn_status status = read_outline(build, call, &o);
    if (status == QN_OK) {
        int direction = convexity(&o);
        qn_outline view = {o.contours, o.sizes, (const double(*)[2])o.points};
        if (direction < 0)
            reverse(&o);
        status =
            qni_csg_give(build,
                         direction     ? convex_prism(build, o.count, view.points)
                         : o.count < 3 ? qni_empty_create(build->context)
                                       : qni_polygon_create(build->context, &view, build->owner),
                         solid_out);
    }
    outline_free(build, &o);
    return status;
}

static bool is_simple(const qni_csg_call *call) {
    static const char *const names[] = {"cube", "sphere", "cylinder", "square", "circle"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (qni_csg_is(call, names[i]))
            return true;
    return false;
}

qn_status qni_csg_primitive(qni_csg_builder *build, const qni_csg_call *call, bool *known_out,
                            qn_solid **solid_out) {
    bool simple = is_simple(call), solid = qni_csg_is(call, "polyhedron");
    *known_out = simple || solid || qni_csg_is(call, "polygon");
    if (!*known_out)
        return QN_OK;
    ++build->owner;
    if (solid)
        return qni_csg_polyhedron(build, call, solid_out);
    if (!simple)
        return polygon(build, call, solid_out);
    shape s;
    QN_TRY(read_shape(build, call, &s));
    return qni_csg_give(build, solid_of(build, call, &s), solid_out);
}

static qn_status polygon_corners(qni_csg_builder *build, const qni_csg_call *call,
                                 qni_points *points) {
    outline o;
    qn_status status = read_outline(build, call, &o);
    for (int64_t n = 0; status == QN_OK && n < o.count; ++n)
        status = add(build, points, o.points[n][0], o.points[n][1], 0);
    outline_free(build, &o);
    return status;
}

qn_status qni_csg_corners(qni_csg_builder *build, const qni_csg_call *call, qni_points *points) {
    if (qni_csg_is(call, "polygon"))
        return polygon_corners(build, call, points);
    if (qni_csg_is(call, "polyhedron"))
        return qni_csg_polyhedron_corners(build, call, points);
    shape s;
    QN_TRY(read_shape(build, call, &s));
    if (s.empty)
        return QN_OK;
    bool flat = qni_csg_is(call, "square");
    if (flat || qni_csg_is(call, "cube")) {
        for (int n = 0; n < (flat ? 4 : 8); ++n)
            QN_TRY(add(build, points, n & 1 ? s.high[0] : s.low[0], n & 2 ? s.high[1] : s.low[1],
                       n & 4 ? s.high[2] : s.low[2]));
        return QN_OK;
    }
    if (build->smooth)
        return qni_csg_fail(
            build, call, QN_ERROR_UNSUPPORTED,
            "hulls of round primitives are not supported; read the file with their facets");
    if (qni_csg_is(call, "circle"))
        return ring(build, points, s.low_radius, s.fragments, 0);
    if (qni_csg_is(call, "cylinder")) {
        QN_TRY(ring(build, points, s.low_radius, s.fragments, s.low[2]));
        return ring(build, points, s.high_radius, s.fragments, s.high[2]);
    }
    for (int32_t n = 0; n < qni_sphere_rings(s.fragments); ++n) {
        double radius, z;
        qni_sphere_ring(s.low_radius, s.fragments, n, &radius, &z);
        QN_TRY(ring(build, points, radius, s.fragments, z));
    }
    return QN_OK;
}
