// SPDX-License-Identifier: MIT
/* Extrusions and revolutions: flat shapes are prisms without ends, so one is an intersection with a
 * slab and the other a look at the shape round an axis. No polygon is ever clipped. */
#include <string.h>

#include "solid/facets.h"
#include "solid/primitives.h"

/* Whose the ends are: the owner of some point of the shape. */
static int32_t part_owner(const qn_solid *part) {
    double middle[1][3];
    int32_t owner = part->owner;
    for (int k = 0; k < 3; ++k) {
        middle[0][k] = 0.5 * (part->box.low[k] + part->box.high[k]);
        middle[0][k] = middle[0][k] == middle[0][k] ? middle[0][k] : 0;
    }
    if (part->ops->gradients(part, 1, (const double(*)[3])middle, NULL, &owner) != QN_OK)
        return part->owner;
    return owner;
}

/* The prism between two heights. A polytope takes the two planes up. */
qn_solid *qni_extrude_create(qn_context *context, qn_solid *part, double low, double high) {
    double ends[2][4] = {{0, 0, -1, -low}, {0, 0, 1, high}};
    qni_box box = part->box;
    box.low[2] = low;
    box.high[2] = high;
    int64_t count;
    const qni_plane *sides = qni_polytope_planes(part, &count);
    if (!sides) {
        for (int k = 0; k < 2; ++k) { /* of the slab alone */
            box.low[k] = -QNI_INFINITY;
            box.high[k] = QNI_INFINITY;
        }
        qn_solid *parts[2] = {part, qni_polytope_create(context, 2, (const double(*)[4])ends, &box,
                                                        part_owner(part))};
        qn_solid *solid = parts[1] ? qni_combine_create(context, true, 2, parts, NULL) : NULL;
        qn_solid_destroy(parts[1]);
        return solid;
    }
    double(*planes)[4] = qni_alloc(context, count + 2, sizeof *planes);
    if (!planes)
        return NULL;
    for (int64_t n = 0; n < count; ++n) {
        memcpy(planes[n], sides[n].normal, sizeof sides[n].normal);
        planes[n][3] = sides[n].distance;
    }
    memcpy(planes[count], ends, sizeof ends);
    qn_solid *solid =
        qni_polytope_create(context, count + 2, (const double(*)[4])planes, &box, part->owner);
    qni_free(context, planes, count + 2, sizeof *planes);
    return solid;
}

/* The wedge between two half-planes that begin at the z axis: convex up to half a turn, else the
 * complement of the wedge that is left. */
static qn_solid *cut_out(qn_context *context, qn_solid *turned, double start, double angle) {
    bool large = angle > 180;
    double from = large ? start + angle : start, to = large ? start + 360 : start + angle;
    double planes[2][4] = {{qni_sin_degrees(from), -qni_cos_degrees(from), 0, 0},
                           {-qni_sin_degrees(to), qni_cos_degrees(to), 0, 0}};
    qni_box box = qni_box_everything();
    qn_solid *parts[2] = {turned, qni_polytope_create(context, 2, (const double(*)[4])planes, &box,
                                                      part_owner(turned))};
    const bool minus[2] = {false, large};
    qn_solid *solid = parts[1] ? qni_combine_create(context, true, 2, parts, minus) : NULL;
    qn_solid_destroy(parts[1]);
    return solid;
}

/* Shapes left of the axis are looked at in a mirror, from the other side. */
static qn_solid *mirrored(qn_context *context, qn_solid *part) {
    static const double mirror[3][4] = {{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    return qni_transform_create(context, part, mirror, mirror, NULL);
}

qn_solid *qni_turn_create(qn_context *context, qn_solid *part, double angle, int32_t fragments,
                          bool left) {
    qn_solid *right = left ? mirrored(context, part) : qni_solid_retain(part);
    if (!right)
        return NULL;
    /* Whole turns begin opposite to the shape, parts of one at it; negative ones go the other way
     * round. */
    bool whole = fabs(angle) >= 360;
    double start = (whole       ? 180
                    : angle < 0 ? angle
                                : 0) +
                   (left ? 180 : 0),
           size = whole ? 360 : fabs(angle);
    qn_solid *turned = qni_revolve_create(context, right, start, size, fragments);
    qn_solid_destroy(right);
    if (!turned || whole)
        return turned;
    qn_solid *solid = cut_out(context, turned, start, size);
    qn_solid_destroy(turned);
    return solid;
}
