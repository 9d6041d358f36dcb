// SPDX-License-Identifier: MIT
/* Round primitives: sphere, cylinder or cone along z, torus about z. Each gives exact crossings
 * from the roots of its polynomial; values are distances, or below them. */
#include "solid/polynomial.h"
#include "solid/primitives.h"

#include <math.h>

typedef enum round_kind { SPHERE, CONE, TORUS } round_kind;

/* A cone is what lies within radius + slope z of the z axis, without ends: its node intersects it
 * with two half-spaces. */
typedef struct round_solid {
    qn_solid base;
    round_kind kind;
    double centre[3]; /* of the sphere */
    double radius;    /* of the sphere, of the cone at z = 0, of the torus' ring */
    double slope;     /* of the cone: growth of the radius with z */
    double scale;     /* of the cone: makes its values distances; the torus' tube radius */
} round_solid;

static const round_solid *shape(const qn_solid *solid) {
    return (const round_solid *)solid;
}

static void destroy(qn_solid *solid) {
    qni_solid_free(solid, sizeof(round_solid));
}

static double value_at(const round_solid *solid, const double p[3]) {
    double value;
    if (solid->kind == SPHERE) {
        double x = p[0] - solid->centre[0], y = p[1] - solid->centre[1],
               z = p[2] - solid->centre[2];
        value = sqrt(x * x + y * y + z * z) - solid->radius;
    } else if (solid->kind == CONE) {
        value = (sqrt(p[0] * p[0] + p[1] * p[1]) - (solid->radius + solid->slope * p[2])) *
                solid->scale;
    } else {
        double ring = sqrt(p[0] * p[0] + p[1] * p[1]) - solid->radius;
        value = sqrt(ring * ring + p[2] * p[2]) - solid->scale;
    }
    return value;
}

static qn_status round_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                              double *values) {
    for (int64_t n = 0; n < count; ++n)
        values[n] = value_at(shape(solid), points[n]);
    return QN_OK;
}

/* Where there is no direction (centre, axis) any unit vector is as good. */
static void gradient_at(const round_solid *solid, const double p[3], double gradient[3]) {
    static const double up[3] = {0, 0, 1}, aside[3] = {1, 0, 0};
    double radial[3] = {p[0], p[1], 0};
    if (solid->kind == SPHERE) {
        double offset[3] = {p[0] - solid->centre[0], p[1] - solid->centre[1],
                            p[2] - solid->centre[2]};
        qni_unit(offset, up, gradient);
        return;
    }
    qni_unit(radial, aside, radial);
    if (solid->kind == CONE) {
        for (int k = 0; k < 3; ++k)
            gradient[k] = (radial[k] - (k == 2 ? solid->slope : 0)) * solid->scale;
        return;
    }
    double ring = sqrt(p[0] * p[0] + p[1] * p[1]) - solid->radius;
    double offset[3] = {radial[0] * ring, radial[1] * ring, p[2]};
    qni_unit(offset, up, gradient);
}

static qn_status round_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 double (*gradients)[3], int32_t *owners) {
    for (int64_t n = 0; gradients && n < count; ++n)
        gradient_at(shape(solid), points[n], gradients[n]);
    for (int64_t n = 0; owners && n < count; ++n)
        owners[n] = solid->owner;
    return QN_OK;
}

/* Least and largest |x - c| for x from low to high. */
static void distance_range(double low, double high, double c, double range[2]) {
    double a = low - c, b = high - c;
    range[0] = a > 0 ? a : b < 0 ? -b : 0;
    range[1] = qni_max(fabs(a), fabs(b));
}

static void radius_range(const qni_box *box, const double centre[2], double range[2]) {
    double x[2], y[2];
    distance_range(box->low[0], box->high[0], centre[0], x);
    distance_range(box->low[1], box->high[1], centre[1], y);
    range[0] = sqrt(x[0] * x[0] + y[0] * y[0]);
    range[1] = sqrt(x[1] * x[1] + y[1] * y[1]);
}

static qn_status round_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const round_solid *s = shape(solid);
    static const double axis[2] = {0, 0};
    double flat[2], z[2], largest;
    radius_range(box, s->kind == SPHERE ? s->centre : axis, flat);
    if (s->kind == CONE) {
        double at_low = s->radius + s->slope * box->low[2],
               at_high = s->radius + s->slope * box->high[2];
        range[0] = (flat[0] - qni_max(at_low, at_high)) * s->scale;
        range[1] = (flat[1] - qni_min(at_low, at_high)) * s->scale;
        largest = flat[1] + fabs(at_low) + fabs(at_high) + fabs(s->radius);
    } else {
        double ring[2] = {flat[0], flat[1]}, tube = s->kind == SPHERE ? s->radius : s->scale;
        if (s->kind == TORUS)
            distance_range(flat[0], flat[1], s->radius, ring);
        distance_range(box->low[2], box->high[2], s->kind == SPHERE ? s->centre[2] : 0, z);
        range[0] = sqrt(ring[0] * ring[0] + z[0] * z[0]) - tube;
        range[1] = sqrt(ring[1] * ring[1] + z[1] * z[1]) - tube;
        largest = flat[1] + z[1] + s->radius + tube;
    }
    for (int k = 0; k < 3; ++k)
        largest += qni_max(fabs(box->low[k]), fabs(box->high[k]));
    range[0] -= 16 * QNI_EPSILON * largest;
    range[1] += 16 * QNI_EPSILON * largest;
    return QN_OK;
}

/* x / sqrt(x^2 + rest^2) rises with x, and falls towards 0 with the rest. */
static void share_range(const double x[2], const double rest[2], double range[2]) {
    for (int n = 0; n < 2; ++n) {
        const bool against = n ? x[n] > 0 : x[n] < 0; /* the extreme is where the rest is small */
        const double other = rest[against ? 0 : 1], length = sqrt(x[n] * x[n] + other * other);
        range[n] = length > 0 ? x[n] / length : 0;
    }
    if (x[0] <= 0 && x[1] >= 0 && rest[0] <= 0) { /* no direction at the middle */
        range[0] = -1;
        range[1] = 1;
    }
}

/* Range of sqrt(a^2 + b^2), of the ranges of a and b. */
static void length_range(const double a[2], const double b[2], double range[2]) {
    double p[2], q[2];
    distance_range(a[0], a[1], 0, p);
    distance_range(b[0], b[1], 0, q);
    range[0] = sqrt(p[0] * p[0] + q[0] * q[0]);
    range[1] = sqrt(p[1] * p[1] + q[1] * q[1]);
}

static void product_range(const double a[2], const double b[2], double range[2]) {
    const double p = a[0] * b[0], q = a[0] * b[1], r = a[1] * b[0], s = a[1] * b[1];
    range[0] = qni_min(qni_min(p, q), qni_min(r, s));
    range[1] = qni_max(qni_max(p, q), qni_max(r, s));
}

static bool round_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const round_solid *s = shape(solid);
    double at[3][2], flat[2], to_axis[2][2], rest[2];
    for (int k = 0; k < 3; ++k)
        for (int n = 0; n < 2; ++n)
            at[k][n] = (n ? box->high[k] : box->low[k]) - (s->kind == SPHERE ? s->centre[k] : 0);
    if (s->kind == SPHERE) {
        for (int k = 0; k < 3; ++k) {
            length_range(at[(k + 1) % 3], at[(k + 2) % 3], rest);
            share_range(at[k], rest, ranges[k]);
        }
        return true;
    }
    for (int k = 0; k < 2; ++k) { /* x and y parts of the direction away from the axis */
        length_range(at[1 - k], (const double[2]){0, 0}, rest);
        share_range(at[k], rest, to_axis[k]);
    }
    if (s->kind == CONE) {
        for (int k = 0; k < 2; ++k)
            for (int n = 0; n < 2; ++n)
                ranges[k][n] = to_axis[k][n] * s->scale;
        ranges[2][0] = ranges[2][1] = -s->slope * s->scale;
        return true;
    }
    double ring[2], outward[2];
    length_range(at[0], at[1], flat);
    ring[0] = flat[0] - s->radius;
    ring[1] = flat[1] - s->radius;
    length_range(at[2], (const double[2]){0, 0}, rest);
    share_range(ring, rest, outward);
    for (int k = 0; k < 2; ++k)
        product_range(to_axis[k], outward, ranges[k]);
    length_range(ring, (const double[2]){0, 0}, rest);
    share_range(at[2], rest, ranges[2]);
    return true;
}

/* A segment by its length: the point at s is origin + s direction, where the origin is the line's
 * point nearest to the centre (of a cone: to the axis). Measured from there the polynomials lose no
 * digits, however far away the ends are. */
typedef struct ray {
    double origin[3], direction[3];
    double start, length; /* s at a, and from a to b */
} ray;

static ray ray_of(const round_solid *s, const double a[3], const double b[3]) {
    ray way = {.length = 0};
    double p[3], squares = 0, along = 0, flat = 0;
    for (int k = 0; k < 3; ++k) {
        p[k] = a[k] - (s->kind == SPHERE ? s->centre[k] : 0);
        way.direction[k] = b[k] - a[k];
        squares += way.direction[k] * way.direction[k];
    }
    way.length = sqrt(squares);
    for (int k = 0; k < 3 && way.length > 0; ++k)
        way.direction[k] /= way.length;
    for (int k = 0; k < (s->kind == CONE ? 2 : 3); ++k) {
        along += p[k] * way.direction[k];
        flat += way.direction[k] * way.direction[k];
    }
    /* A cone's axis may be nearly parallel: then the nearest point is far off and of no use. */
    way.start = flat > 0 && fabs(along / flat) < 1e3 * way.length ? along / flat : 0;
    for (int k = 0; k < 3; ++k)
        way.origin[k] = p[k] - way.start * way.direction[k];
    return way;
}

/* The polynomial in s of the surface, of degree 2 or 4. The cone's equation is squared: it has a
 * second nappe, which `is_real` tells apart. */
static int polynomial_of(const round_solid *s, const ray *way, double c[5]) {
    const double *p = way->origin, *d = way->direction;
    double pp = p[0] * p[0] + p[1] * p[1], pd = p[0] * d[0] + p[1] * d[1],
           dd = d[0] * d[0] + d[1] * d[1];
    if (s->kind == CONE) {
        double r = s->radius + s->slope * p[2], m = s->slope * d[2];
        c[0] = pp - r * r;
        c[1] = 2 * (pd - r * m);
        c[2] = dd - m * m;
        return 2;
    }
    double qq = pp + p[2] * p[2], qd = pd + p[2] * d[2], ee = dd + d[2] * d[2];
    if (s->kind == SPHERE) {
        c[0] = qq - s->radius * s->radius;
        c[1] = 2 * qd;
        c[2] = ee;
        return 2;
    }
    /* (|q|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + y^2) */
    double k = qq + s->radius * s->radius - s->scale * s->scale, four = 4 * s->radius * s->radius;
    c[0] = k * k - four * pp;
    c[1] = 4 * k * qd - 2 * four * pd;
    c[2] = 4 * qd * qd + 2 * k * ee - four * dd;
    c[3] = 4 * qd * ee;
    c[4] = ee * ee;
    return 4;
}

/* Where the line meets the surface, as places on the segment: from a little before it to a little
 * behind it. */
static int places_of(const round_solid *s, const double a[3], const double b[3], double places[4]) {
    ray way = ray_of(s, a, b);
    if (!(way.length > 0))
        return 0;
    double c[5], low = way.start - 1e-3 * way.length, high = way.start + 1.001 * way.length;
    double reach = 1.01 * (s->kind == TORUS ? s->radius + s->scale : s->radius);
    if (s->kind != CONE) {
        low = qni_max(low, -reach);
        high = qni_min(high, reach);
    }
    if (!(low < high))
        return 0;
    int degree = polynomial_of(s, &way, c),
        count = qni_polynomial_roots(degree, c, low, high, places);
    for (int i = 0; i < count; ++i)
        places[i] = (places[i] - way.start) / way.length;
    return count;
}

static void point_on(const double a[3], const double b[3], double t, double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = a[k] + t * (b[k] - a[k]);
}

static bool is_real(const round_solid *s, const double p[3]) {
    return s->kind != CONE || s->radius + s->slope * p[2] >= 0;
}

static qn_status round_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                 int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const round_solid *s = shape(solid);
    double roots[4], kept[4], p[3];
    int found = places_of(s, a, b, roots), count = 0;
    for (int i = 0; i < found; ++i) {
        point_on(a, b, roots[i], p);
        if (is_real(s, p))
            kept[count++] = roots[i];
    }
    bool inside = value_at(s, a) < 0, ends_inside = value_at(s, b) < 0;
    count = qni_match_ends(kept, count, inside, ends_inside);
    while (count > capacity)
        count -= 2;
    for (int i = 0; i < count; ++i, inside = !inside) {
        point_on(a, b, kept[i], p);
        crossings[i] = (qni_crossing){.at = kept[i], .owner = solid->owner, .enters = !inside};
        gradient_at(s, p, crossings[i].normal);
    }
    *count_out = count > 0 ? count : 0;
    return QN_OK;
}

static const qni_solid_ops round_ops = {
    .destroy = destroy,
    .values = round_values,
    .gradients = round_gradients,
    .bounds = round_bounds,
    .crossings = round_crossings,
    .restrict_to = qni_restrict_to_itself,
    .slopes = round_slopes,
};

qn_solid *qni_sphere_create(qn_context *context, const double centre[3], double radius,
                            int32_t owner) {
    round_solid *solid = (round_solid *)qni_solid_new(context, sizeof *solid, &round_ops);
    if (!solid)
        return NULL;
    solid->kind = SPHERE;
    solid->radius = radius;
    solid->base.owner = owner;
    for (int k = 0; k < 3; ++k) {
        solid->centre[k] = centre[k];
        solid->base.box.low[k] = centre[k] - radius;
        solid->base.box.high[k] = centre[k] + radius;
    }
    return &solid->base;
}

qn_solid *qni_cone_create(qn_context *context, double radius, double slope, int32_t owner) {
    round_solid *solid = (round_solid *)qni_solid_new(context, sizeof *solid, &round_ops);
    if (!solid)
        return NULL;
    solid->kind = CONE;
    solid->radius = radius;
    solid->slope = slope;
    solid->scale = 1 / sqrt(1 + slope * slope);
    solid->base.owner = owner;
    return &solid->base;
}

qn_solid *qni_torus_create(qn_context *context, double ring_radius, double tube_radius,
                           int32_t owner) {
    round_solid *solid = (round_solid *)qni_solid_new(context, sizeof *solid, &round_ops);
    if (!solid)
        return NULL;
    solid->kind = TORUS;
    solid->radius = ring_radius;
    solid->scale = tube_radius;
    solid->base.owner = owner;
    double reach = ring_radius + tube_radius;
    solid->base.box = (qni_box){{-reach, -reach, -tube_radius}, {reach, reach, tube_radius}};
    return &solid->base;
}
