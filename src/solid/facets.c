// SPDX-License-Identifier: MIT
/* Facetted spheres and cylinders: corners on the round surface, the first at angle 0; a sphere's
 * rings lie half a step from its poles, which are flat. Both are convex: the planes of their facets
 * say all. */
#include "solid/facets.h"

#include <math.h>

#include "solid/primitives.h"

double qni_sin_degrees(double degrees) {
    double turns = fmod(degrees, 360);
    turns = turns < 0 ? turns + 360 : turns;
    double sign = 1;
    if (turns >= 180) {
        turns -= 180;
        sign = -1;
    }
    turns = turns > 90 ? 180 - turns : turns;
    if (turns == 0)
        return 0;
    if (turns == 30)
        return 0.5 * sign;
    if (turns == 90)
        return sign;
    /* The smaller angle, so that both functions agree about 45 degrees to the bit. */
    return sign * (turns > 45 ? cos((90 - turns) * (3.14159265358979323846 / 180))
                              : sin(turns * (3.14159265358979323846 / 180)));
}

double qni_cos_degrees(double degrees) {
    return qni_sin_degrees(degrees + 90);
}

void qni_circle_point(double radius, int32_t fragments, int32_t n, double point[2]) {
    point[0] = radius * qni_cos_degrees(360.0 * n / fragments);
    point[1] = radius * qni_sin_degrees(360.0 * n / fragments);
}

int32_t qni_sphere_rings(int32_t fragments) {
    return (fragments + 1) / 2;
}

void qni_sphere_ring(double radius, int32_t fragments, int32_t ring, double *ring_radius,
                     double *z) {
    double phi = 180.0 * (ring + 0.5) / qni_sphere_rings(fragments);
    *ring_radius = radius * qni_sin_degrees(phi);
    *z = radius * qni_cos_degrees(phi);
}

/* The facets of the frustum between two rings: m . (x, y) < apothem at z, which goes linearly from
 * one ring to the other. */
static void frustum(double low_z, double low_radius, double high_z, double high_radius,
                    int32_t fragments, double (*planes)[4]) {
    double inner = qni_cos_degrees(180.0 / fragments), rise = high_z - low_z;
    for (int32_t n = 0; n < fragments; ++n) {
        double middle = 360.0 * (n + 0.5) / fragments;
        planes[n][0] = qni_cos_degrees(middle) * rise;
        planes[n][1] = qni_sin_degrees(middle) * rise;
        planes[n][2] = -(high_radius - low_radius) * inner;
        planes[n][3] = low_radius * inner * rise + planes[n][2] * low_z;
    }
}

static void cap(double z, bool up, double plane[4]) {
    plane[0] = plane[1] = 0;
    plane[2] = up ? 1 : -1;
    plane[3] = up ? z : -z;
}

qn_solid *qni_facet_cylinder(qn_context *context, double low, double height, double low_radius,
                             double high_radius, int32_t fragments, int32_t owner) {
    double radius = fmax(low_radius, high_radius);
    int64_t count = (int64_t)fragments + 2;
    double(*planes)[4] = qni_alloc(context, count, sizeof *planes);
    if (!planes)
        return NULL;
    frustum(low, low_radius, low + height, high_radius, fragments, planes);
    cap(low, false, planes[fragments]);
    cap(low + height, true, planes[fragments + 1]);
    qni_box box = {{-radius, -radius, low}, {radius, radius, low + height}};
    qn_solid *solid = qni_polytope_create(context, count, (const double(*)[4])planes, &box, owner);
    qni_free(context, planes, count, sizeof *planes);
    return solid;
}

qn_solid *qni_facet_sphere(qn_context *context, double radius, int32_t fragments, int32_t owner) {
    int32_t rings = qni_sphere_rings(fragments);
    int64_t count = (int64_t)fragments * (rings - 1) + 2;
    double(*planes)[4] = qni_alloc(context, count, sizeof *planes);
    if (!planes)
        return NULL;
    double upper_radius, upper_z, radius_here, z;
    qni_sphere_ring(radius, fragments, 0, &upper_radius, &upper_z);
    double top = upper_z;
    for (int32_t ring = 1; ring < rings; ++ring) {
        qni_sphere_ring(radius, fragments, ring, &radius_here, &z);
        frustum(z, radius_here, upper_z, upper_radius, fragments,
                planes + (int64_t)fragments * (ring - 1));
        upper_radius = radius_here;
        upper_z = z;
    }
    cap(upper_z, false, planes[count - 2]);
    cap(top, true, planes[count - 1]);
    qni_box box = {{-radius, -radius, upper_z}, {radius, radius, top}};
    qn_solid *solid = qni_polytope_create(context, count, (const double(*)[4])planes, &box, owner);
    qni_free(context, planes, count, sizeof *planes);
    return solid;
}

qn_solid *qni_round_cylinder(qn_context *context, double low, double height, double low_radius,
                             double high_radius, int32_t owner) {
    double radius = fmax(low_radius, high_radius), slope = (high_radius - low_radius) / height;
    double planes[2][4];
    cap(low, false, planes[0]);
    cap(low + height, true, planes[1]);
    qni_box box = {{-radius, -radius, low}, {radius, radius, low + height}},
            slab = qni_box_everything();
    slab.low[2] = low;
    slab.high[2] = low + height;
    qn_solid *parts[2] = {
        qni_cone_create(context, low_radius - slope * low, slope, owner),
        qni_polytope_create(context, 2, (const double(*)[4])planes, &slab, owner)};
    qn_solid *solid =
        parts[0] && parts[1] ? qni_combine_create(context, true, 2, parts, NULL) : NULL;
    if (solid)
        solid->box = box;
    qn_solid_destroy(parts[0]);
    qn_solid_destroy(parts[1]);
    return solid;
}
