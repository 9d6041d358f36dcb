// SPDX-License-Identifier: MIT
/* linear_extrude and rotate_extrude: flat shapes are prisms without ends, so one is an intersection with a slab and the
 * other a look at the shape round an axis. No polygon is ever clipped. */
#include <string.h>

#include "solid/csg_build.h"
#include "solid/facets.h"

/* The prism between two heights. A polytope takes the two planes up. */
static qn_solid *slab(qni_csg_builder *build, qn_solid *part, double low, double high) {
    double ends[2][4] = {{0, 0, -1, -low}, {0, 0, 1, high}};
    qni_box box = part->box;
    box.low[2] = low;
    box.high[2] = high;
    int64_t count;
    const qni_plane *sides = qni_polytope_planes(part, &count);
    if (!sides) {
        qn_solid *parts[2] = {part, qni_polytope_create(build->context, 2, (const double(*)[4])ends, &box,
                                                    build->owner)};
        qn_solid *solid = parts[1] ? qni_combine_create(build->context, true, 2, parts, NULL) : NULL;
        qn_solid_destroy(parts[1]);
        return solid;
    }
    double(*planes)[4] = qni_alloc(build->context, count + 2, sizeof *planes);
    if (!planes)
        return NULL;
    for (int64_t n = 0; n < count; ++n) {
        memcpy(planes[n], sides[n].normal, sizeof sides[n].normal);
        planes[n][3] = sides[n].distance;
    }
    memcpy(planes[count], ends, sizeof ends);
    qn_solid *solid = qni_polytope_create(build->context, count + 2, (const double(*)[4])planes, &box, part->owner);
    qni_free(build->context, planes, count + 2, sizeof *planes);
    return solid;
}

qn_status qni_csg_linear_extrude(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out) {
    double height, twist, scale[2] = {1, 1};
    bool centre;
    QN_TRY(qni_csg_number(build, call, "height", 100, &height));
    QN_TRY(qni_csg_number(build, call, "twist", 0, &twist));
    QN_TRY(qni_csg_flag(build, call, "center", &centre));
    if (qni_csg_find(call, "scale"))
        QN_TRY(qni_csg_numbers(build, call, "scale", 2, scale));
    if (qni_csg_find(call, "file"))
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED, "outlines from files are not supported");
    if (twist != 0)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED, "twist = %g: only straight extrusions are supported", twist);
    if (scale[0] != 1 || scale[1] != 1)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "scale = [%g, %g]: only extrusions that keep their size are supported", scale[0],
                            scale[1]);
    if (!(height > 0))
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "height is %g: it must be above 0", height);
    qn_solid *part;
    QN_TRY(qni_csg_children(build, call, 2, &part));
    if (qni_box_is_nothing(&part->box)) {
        *solid_out = part;
        return QN_OK;
    }
    qn_status status = qni_csg_give(
        build, slab(build, part, centre ? -0.5 * height : 0, centre ? 0.5 * height : height), solid_out);
    qn_solid_destroy(part);
    return status;
}

/* What the facets' number depends on: the extent of the shape in x. */
static qn_status extent(qni_csg_builder *build, const qni_csg_call *call, double range[2]) {
    static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    qni_points points = {0};
    qn_status status = QN_OK;
    range[0] = QNI_INFINITY;
    range[1] = -QNI_INFINITY;
    for (const qni_csg_call *child = call->children; child && status == QN_OK; child = child->next)
        if (qni_csg_dimension(child) == 2)
            status = qni_csg_points(build, child, 2, identity, &points);
    for (int64_t n = 0; n < points.count; ++n) {
        range[0] = fmin(range[0], points.at[n][0]);
        range[1] = fmax(range[1], points.at[n][0]);
    }
    qni_points_free(build->context, &points);
    return status;
}

/* The wedge between two half-planes that begin at the z axis: convex up to half a turn, else the complement of the
 * wedge that is left. */
static qn_solid *cut_out(qni_csg_builder *build, qn_solid *turned, double start, double angle) {
    bool large = angle > 180;
    double from = large ? start + angle : start, to = large ? start + 360 : start + angle;
    double planes[2][4] = {{qni_sin_degrees(from), -qni_cos_degrees(from), 0, 0},
                           {-qni_sin_degrees(to), qni_cos_degrees(to), 0, 0}};
    qni_box box = qni_box_everything();
    qn_solid *parts[2] = {turned, qni_polytope_create(build->context, 2, (const double(*)[4])planes, &box,
                                                  turned->owner ? turned->owner : build->owner)};
    const bool minus[2] = {false, large};
    qn_solid *solid = parts[1] ? qni_combine_create(build->context, true, 2, parts, minus) : NULL;
    qn_solid_destroy(parts[1]);
    return solid;
}

/* Shapes left of the axis are looked at in a mirror, from the other side. */
static qn_solid *mirrored(qni_csg_builder *build, qn_solid *part) {
    static const double mirror[3][4] = {{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    return qni_transform_create(build->context, part, mirror, mirror, NULL);
}

static qn_solid *turn_part(qni_csg_builder *build, qn_solid *part, double angle, int32_t fragments, bool left) {
    qn_solid *right = left ? mirrored(build, part) : qni_solid_retain(part);
    if (!right)
        return NULL;
    /* Whole turns begin opposite to the shape, parts of one at it; negative ones go the other way round. */
    bool whole = fabs(angle) >= 360;
    double start = (whole ? 180 : angle < 0 ? angle : 0) + (left ? 180 : 0), size = whole ? 360 : fabs(angle);
    qn_solid *turned = qni_revolve_create(build->context, right, start, size, build->smooth ? 0 : fragments);
    qn_solid_destroy(right);
    if (!turned || whole)
        return turned;
    qn_solid *solid = cut_out(build, turned, start, size);
    qn_solid_destroy(turned);
    return solid;
}

qn_status qni_csg_rotate_extrude(qni_csg_builder *build, const qni_csg_call *call, qn_solid **solid_out) {
    double angle, range[2];
    QN_TRY(qni_csg_number(build, call, "angle", 360, &angle));
    if (qni_csg_find(call, "file"))
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED, "outlines from files are not supported");
    angle = fabs(angle) > 360 ? 360 : angle;
    QN_TRY(extent(build, call, range));
    if (angle == 0 || !(range[0] < range[1]))
        return qni_csg_give(build, qni_empty_create(build->context), solid_out);
    if (range[0] < 0 && range[1] > 0)
        return qni_csg_fail(build, call, QN_ERROR_INPUT,
                            "the shape reaches from x = %g to %g over the axis: it must lie on one side of x = 0",
                            range[0], range[1]);
    int32_t circle;
    QN_TRY(qni_csg_fragments(build, call, fmax(fabs(range[0]), fabs(range[1])), &circle));
    int32_t fragments = (int32_t)fmax(circle * fabs(angle) / 360, 1);
    if (!build->smooth && fabs(angle) / fragments >= 180)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED, "one facet would span %g degrees; give a larger $fn",
                            fabs(angle) / fragments);
    qn_solid *part;
    QN_TRY(qni_csg_children(build, call, 2, &part));
    qn_status status = qni_csg_give(build, turn_part(build, part, angle, fragments, range[0] < 0), solid_out);
    qn_solid_destroy(part);
    return status;
}
