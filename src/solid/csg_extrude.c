// SPDX-License-Identifier: MIT
/* OpenSCAD's linear_extrude and rotate_extrude: their arguments, and how many facets a turn has. */
#include "solid/csg_build.h"

qn_status qni_csg_linear_extrude(qni_csg_builder *build, const qni_csg_call *call,
                                 qn_solid **solid_out) {
    double height, twist, scale[2] = {1, 1};
    bool centre;
    QN_TRY(qni_csg_number(build, call, "height", 100, &height));
    QN_TRY(qni_csg_number(build, call, "twist", 0, &twist));
    QN_TRY(qni_csg_flag(build, call, "center", &centre));
    if (qni_csg_find(call, "scale"))
        QN_TRY(qni_csg_numbers(build, call, "scale", 2, scale));
    if (qni_csg_find(call, "file"))
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "outlines from files are not supported");
    if (twist != 0)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "twist = %g: only straight extrusions are supported", twist);
    if (scale[0] != 1 || scale[1] != 1)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "scale = [%g, %g]: only extrusions that keep their size are supported",
                            scale[0], scale[1]);
    if (!(height > 0))
        return qni_csg_fail(build, call, QN_ERROR_INPUT, "height is %g: it must be above 0",
                            height);
    qn_solid *part;
    QN_TRY(qni_csg_children(build, call, 2, &part));
    if (qni_box_is_nothing(&part->box)) {
        *solid_out = part;
        return QN_OK;
    }
    qn_status status =
        qni_csg_give(build,
                     qni_extrude_create(build->context, part, centre ? -0.5 * height : 0,
                                        centre ? 0.5 * height : height),
                     solid_out);
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

qn_status qni_csg_rotate_extrude(qni_csg_builder *build, const qni_csg_call *call,
                                 qn_solid **solid_out) {
    double angle, range[2];
    QN_TRY(qni_csg_number(build, call, "angle", 360, &angle));
    if (qni_csg_find(call, "file"))
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "outlines from files are not supported");
    angle = fabs(angle) > 360 ? 360 : angle;
    QN_TRY(extent(build, call, range));
    if (angle == 0 || !(range[0] < range[1]))
        return qni_csg_give(build, qni_empty_create(build->context), solid_out);
    if (range[0] < 0 && range[1] > 0)
        return qni_csg_fail(
            build, call, QN_ERROR_INPUT,
            "the shape reaches from x = %g to %g over the axis: it must lie on one side of x = 0",
            range[0], range[1]);
    int32_t circle;
    QN_TRY(qni_csg_fragments(build, call, fmax(fabs(range[0]), fabs(range[1])), &circle));
    int32_t fragments = (int32_t)fmax(circle * fabs(angle) / 360, 1);
    if (!build->smooth && fabs(angle) / fragments >= 180)
        return qni_csg_fail(build, call, QN_ERROR_UNSUPPORTED,
                            "one facet would span %g degrees; give a larger $fn",
                            fabs(angle) / fragments);
    qn_solid *part;
    QN_TRY(qni_csg_children(build, call, 2, &part));
    qn_solid *turned =
        qni_turn_create(build->context, part, angle, build->smooth ? 0 : fragments, range[0] < 0);
    qn_status status = qni_csg_give(build, turned, solid_out);
    qn_solid_destroy(part);
    return status;
}
