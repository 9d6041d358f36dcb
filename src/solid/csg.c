// SPDX-License-Identifier: MIT
/* The public calls that build CSG trees: arguments are checked here. */
#include <math.h>

#include "solid/facets.h"
#include "solid/hull.h"
#include "solid/polyhedron.h"
#include "solid/primitives.h"

static qn_status give(qn_solid *solid, qn_solid **solid_out, qn_error *error) {
    *solid_out = solid;
    return solid ? QN_OK : qni_fail_memory(error, "a solid");
}

static qn_status not_negative(const char *what, double value, qn_error *error) {
    if (value >= 0 && isfinite(value))
        return QN_OK;
    return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                    "%s is %g: it must be finite and not negative", what, value);
}

static qn_status check_fragments(int32_t fragments, int32_t most, qn_error *error) {
    if (fragments == 0 || (fragments >= 3 && fragments <= most))
        return QN_OK;
    return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                    "%d fragments round a circle: give 3 to %d, or 0 for a round one", fragments,
                    most);
}

qn_status qn_solid_box(qn_context *context, const double low[3], const double high[3],
                       qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    double planes[6][4] = {{0}};
    bool empty = false;
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        if (!isfinite(low[k]) || !isfinite(high[k]) || low[k] > high[k])
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "the box runs from %g to %g along axis %d: low must not be above high, "
                            "and both finite",
                            low[k], high[k], k);
        empty = empty || low[k] == high[k];
        planes[2 * k][k] = -1;
        planes[2 * k][3] = -low[k];
        planes[2 * k + 1][k] = 1;
        planes[2 * k + 1][3] = high[k];
        box.low[k] = low[k];
        box.high[k] = high[k];
    }
    if (empty)
        return give(qni_empty_create(context), solid_out, error);
    return give(qni_polytope_create(context, 6, (const double(*)[4])planes, &box, 0), solid_out,
                error);
}

qn_status qn_solid_sphere(qn_context *context, double radius, int32_t fragments,
                          qn_solid **solid_out, qn_error *error) {
    static const double origin[3] = {0, 0, 0};
    *solid_out = NULL;
    QN_TRY(not_negative("the radius of the sphere", radius, error));
    QN_TRY(check_fragments(fragments, QNI_SPHERE_FRAGMENTS, error));
    if (radius == 0)
        return give(qni_empty_create(context), solid_out, error);
    return give(fragments ? qni_facet_sphere(context, radius, fragments, 0)
                          : qni_sphere_create(context, origin, radius, 0),
                solid_out, error);
}

qn_status qn_solid_cylinder(qn_context *context, double height, double low_radius,
                            double high_radius, int32_t fragments, qn_solid **solid_out,
                            qn_error *error) {
    *solid_out = NULL;
    QN_TRY(not_negative("the height of the cylinder", height, error));
    QN_TRY(not_negative("the lower radius of the cylinder", low_radius, error));
    QN_TRY(not_negative("the upper radius of the cylinder", high_radius, error));
    QN_TRY(check_fragments(fragments, QNI_CIRCLE_FRAGMENTS, error));
    if (height == 0 || (low_radius == 0 && high_radius == 0))
        return give(qni_empty_create(context), solid_out, error);
    return give(fragments
                    ? qni_facet_cylinder(context, 0, height, low_radius, high_radius, fragments, 0)
                    : qni_round_cylinder(context, 0, height, low_radius, high_radius, 0),
                solid_out, error);
}

qn_status qn_solid_torus(qn_context *context, double ring_radius, double tube_radius,
                         qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(not_negative("the tube radius of the torus", tube_radius, error));
    QN_TRY(not_negative("the ring radius of the torus", ring_radius, error));
    if (tube_radius > ring_radius)
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "the tube radius %g of the torus is above its ring radius %g: it would meet itself",
            tube_radius, ring_radius);
    if (tube_radius == 0)
        return give(qni_empty_create(context), solid_out, error);
    return give(qni_torus_create(context, ring_radius, tube_radius, 0), solid_out, error);
}

qn_status qn_solid_half_space(qn_context *context, const double normal[3], double distance,
                              qn_solid **solid_out, qn_error *error) {
    static const double none[3] = {0, 0, 0};
    *solid_out = NULL;
    double plane[1][4];
    qni_unit(normal, none, plane[0]);
    plane[0][3] = distance;
    if ((plane[0][0] == 0 && plane[0][1] == 0 && plane[0][2] == 0) || !isfinite(distance))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the half-space has normal (%g, %g, %g) and distance %g: give a direction "
                        "and a finite number",
                        normal[0], normal[1], normal[2], distance);
    qni_box box = qni_box_everything();
    return give(qni_polytope_create(context, 1, (const double(*)[4])plane, &box, 0), solid_out,
                error);
}

static qn_status check_outline(const qn_outline *outline, double *least_x_out, qn_error *error) {
    if (!outline || outline->contour_count < 0 ||
        (outline->contour_count > 0 && (!outline->contour_sizes || !outline->points)))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the outline has no contours, sizes or points");
    int64_t first = 0;
    *least_x_out = QNI_INFINITY;
    for (int64_t c = 0; c < outline->contour_count; first += outline->contour_sizes[c++]) {
        if (outline->contour_sizes[c] < 3)
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "contour %lld has %lld points: give 3 or more", (long long)c,
                            (long long)outline->contour_sizes[c]);
        for (int64_t n = 0; n < outline->contour_sizes[c]; ++n) {
            const double *p = outline->points[first + n];
            if (!isfinite(p[0]) || !isfinite(p[1]))
                return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                                "point %lld of contour %lld is (%g, %g): not finite", (long long)n,
                                (long long)c, p[0], p[1]);
            *least_x_out = fmin(*least_x_out, p[0]);
        }
    }
    return QN_OK;
}

qn_status qn_solid_linear_extrude(qn_context *context, const qn_outline *outline, double height,
                                  qn_solid **solid_out, qn_error *error) {
    double least;
    *solid_out = NULL;
    QN_TRY(not_negative("the height of the extrusion", height, error));
    QN_TRY(check_outline(outline, &least, error));
    if (height == 0 || outline->contour_count == 0)
        return give(qni_empty_create(context), solid_out, error);
    qn_solid *part = qni_polygon_create(context, outline, 0);
    qn_status status =
        give(part ? qni_extrude_create(context, part, 0, height) : NULL, solid_out, error);
    qn_solid_destroy(part);
    return status;
}

qn_status qn_solid_rotate_extrude(qn_context *context, const qn_outline *outline, double angle,
                                  int32_t fragments, qn_solid **solid_out, qn_error *error) {
    double least;
    *solid_out = NULL;
    QN_TRY(check_outline(outline, &least, error));
    if (!(fabs(angle) <= 360))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "the angle is %g: give -360 to 360",
                        angle);
    if (fragments < 0 || fragments > QNI_CIRCLE_FRAGMENTS ||
        (fragments > 0 && fabs(angle) / fragments >= 180))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "%d fragments in %g degrees: give up to %d of less than 180 degrees each, "
                        "or 0 for a round one",
                        fragments, fabs(angle), QNI_CIRCLE_FRAGMENTS);
    if (least < 0)
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the outline reaches to x = %g: it must lie at x >= 0", least);
    if (angle == 0 || outline->contour_count == 0)
        return give(qni_empty_create(context), solid_out, error);
    qn_solid *part = qni_polygon_create(context, outline, 0);
    qn_status status = give(part ? qni_turn_create(context, part, angle, fragments, false) : NULL,
                            solid_out, error);
    qn_solid_destroy(part);
    return status;
}

qn_status qn_solid_hull(qn_context *context, int64_t count, const double (*points)[3],
                        qn_solid **solid_out, qn_error *error) {
    qni_points all = {0};
    qni_hull hull = {0};
    qni_box box = {{QNI_INFINITY, QNI_INFINITY, QNI_INFINITY},
                   {-QNI_INFINITY, -QNI_INFINITY, -QNI_INFINITY}};
    *solid_out = NULL;
    qn_status status = QN_OK;
    for (int64_t n = 0; n < count && status == QN_OK; ++n) {
        for (int k = 0; k < 3; ++k) {
            box.low[k] = fmin(box.low[k], points[n][k]);
            box.high[k] = fmax(box.high[k], points[n][k]);
        }
        if (!isfinite(points[n][0]) || !isfinite(points[n][1]) || !isfinite(points[n][2]))
            status = qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                              "point %lld of the hull is (%g, %g, %g): not finite", (long long)n,
                              points[n][0], points[n][1], points[n][2]);
        else if (!qni_points_add(context, &all, points[n]))
            status = qni_fail_memory(error, "a hull");
    }
    if (status == QN_OK)
        status = qni_hull_make(context, 3, &all, NULL, &hull, error);
    if (status == QN_OK && hull.flat)
        status = qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                          "the %lld points of the hull lie in one plane", (long long)count);
    if (status == QN_OK)
        status = give(qni_polytope_create(context, hull.plane_count,
                                          (const double(*)[4])hull.planes, &box, 0),
                      solid_out, error);
    qni_hull_free(context, &hull);
    qni_points_free(context, &all);
    return status;
}

qn_status qn_solid_polyhedron(qn_context *context, int64_t point_count, const double (*points)[3],
                              int64_t face_count, const int64_t *face_sizes, const int64_t *indices,
                              qn_solid **solid_out, qn_error *error) {
    int64_t first = 0;
    *solid_out = NULL;
    for (int64_t n = 0; n < point_count; ++n)
        if (!isfinite(points[n][0]) || !isfinite(points[n][1]) || !isfinite(points[n][2]))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "point %lld of the polyhedron is (%g, %g, %g): not finite",
                            (long long)n, points[n][0], points[n][1], points[n][2]);
    for (int64_t n = 0; n < face_count; first += face_sizes[n++])
        for (int64_t i = 0; i < face_sizes[n]; ++i)
            if (indices[first + i] < 0 || indices[first + i] >= point_count)
                return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                                "face %lld names point %lld of %lld", (long long)n,
                                (long long)indices[first + i], (long long)point_count);
    return qni_polyhedron_from_faces(context, "qn_solid_polyhedron", point_count, points,
                                     face_count, face_sizes, indices, 0, solid_out, error);
}

static qn_status check_parts(int64_t count, qn_solid *const *parts, qn_error *error) {
    if (count < 0 || (count > 0 && !parts))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "%lld parts were named, but none given",
                        (long long)count);
    for (int64_t n = 0; n < count; ++n) {
        if (!parts[n])
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "part %lld of %lld is NULL",
                            (long long)n, (long long)count);
        if (parts[n]->depth >= QNI_SOLID_MAX_DEPTH)
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "the tree would be deeper than %d levels: join more parts at once",
                            QNI_SOLID_MAX_DEPTH);
    }
    return QN_OK;
}

qn_status qn_solid_union(qn_context *context, int64_t count, qn_solid *const *parts,
                         qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(check_parts(count, parts, error));
    return give(qni_combine_create(context, false, count, parts, NULL), solid_out, error);
}

qn_status qn_solid_intersection(qn_context *context, int64_t count, qn_solid *const *parts,
                                qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(check_parts(count, parts, error));
    return give(qni_combine_create(context, true, count, parts, NULL), solid_out, error);
}

qn_status qn_solid_difference(qn_context *context, int64_t count, qn_solid *const *parts,
                              qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(check_parts(count, parts, error));
    bool *minus = qni_alloc(context, count, sizeof *minus);
    if (!minus)
        return qni_fail_memory(error, "a solid");
    for (int64_t n = 0; n < count; ++n)
        minus[n] = n > 0;
    qn_solid *solid = qni_combine_create(context, true, count, parts, minus);
    qni_free(context, minus, count, sizeof *minus);
    return give(solid, solid_out, error);
}

qn_status qn_solid_complement(qn_context *context, qn_solid *part, qn_solid **solid_out,
                              qn_error *error) {
    static const bool minus[1] = {true};
    *solid_out = NULL;
    QN_TRY(check_parts(1, &part, error));
    return give(qni_combine_create(context, true, 1, &part, minus), solid_out, error);
}

qn_status qn_solid_transform(qn_context *context, qn_solid *part, const double matrix[3][4],
                             qn_solid **solid_out, qn_error *error) {
    double inverse[3][4];
    *solid_out = NULL;
    QN_TRY(check_parts(1, &part, error));
    if (!qni_invert(matrix, inverse))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                        "the matrix of the transform cannot be inverted: it flattens the solid or "
                        "is not finite");
    return give(qni_transform_create(context, part, (const double(*)[4])inverse, matrix, NULL),
                solid_out, error);
}

qn_status qn_solid_offset(qn_context *context, qn_solid *part, double distance,
                          qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(check_parts(1, &part, error));
    if (!isfinite(distance))
        return qni_fail(error, QN_ERROR_INVALID_ARGUMENT, "the offset is %g: it must be finite",
                        distance);
    return give(qni_offset_create(context, part, distance), solid_out, error);
}

qn_status qn_solid_with_owner(qn_context *context, qn_solid *part, int32_t owner,
                              qn_solid **solid_out, qn_error *error) {
    *solid_out = NULL;
    QN_TRY(check_parts(1, &part, error));
    return give(qni_owned_create(context, part, owner), solid_out, error);
}
