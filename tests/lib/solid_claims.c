// SPDX-License-Identifier: MIT
/* Claims of solids at random places. */
#include "lib/solid_claims.h"

#include <math.h>

enum { POINTS = 24, ROOM = 64, SAMPLES = 40 };

typedef struct check {
    const char *name;
    const qn_solid *solid;
    const test_claims *claims;
    test_random *random;
} check;

#define CLAIM(test, held, ...)                                                                     \
    do {                                                                                           \
        if (!(held)) {                                                                             \
            print_error("%s: ", (test)->name);                                                     \
            print_error(__VA_ARGS__);                                                              \
            print_error("\n");                                                                     \
            fail();                                                                                \
        }                                                                                          \
    } while (0)

static double between(check *test, double low, double high) {
    return low + (high - low) * test_random_unit(test->random);
}

static void any_point(check *test, double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = between(test, test->claims->low[k], test->claims->high[k]);
}

/* Sizes of all orders of magnitude. */
static qni_box any_box(check *test) {
    double centre[3], scale = exp(between(test, log(1e-5), 0));
    qni_box box;
    any_point(test, centre);
    for (int k = 0; k < 3; ++k) {
        double half = 0.5 * scale * test_random_unit(test->random) *
                      (test->claims->high[k] - test->claims->low[k]);
        box.low[k] = centre[k] - half;
        box.high[k] = centre[k] + half;
    }
    return box;
}

static void points_in(check *test, const qni_box *box, double (*points)[3]) {
    for (int n = 0; n < POINTS; ++n)
        for (int k = 0; k < 3; ++k)
            points[n][k] = n < 8 ? (n >> k & 1 ? box->high[k] : box->low[k])
                                 : fmin(fmax(between(test, box->low[k], box->high[k]), box->low[k]),
                                        box->high[k]);
}

static void values_of(check *test, const qn_solid *solid, int count, double (*points)[3],
                      double *values) {
    CLAIM(test, solid->ops->values(solid, count, (const double(*)[3])points, values) == QN_OK,
          "no values");
}

static void bounds_enclose(check *test) {
    qni_box box = any_box(test);
    double points[POINTS][3], values[POINTS], range[2];
    points_in(test, &box, points);
    values_of(test, test->solid, POINTS, points, values);
    CLAIM(test, test->solid->ops->bounds(test->solid, &box, range) == QN_OK, "no bounds");
    for (int n = 0; n < POINTS; ++n)
        CLAIM(test, values[n] >= range[0] && values[n] <= range[1],
              "f(%.17g, %.17g, %.17g) = %.17g is not in [%.17g, %.17g]", points[n][0], points[n][1],
              points[n][2], values[n], range[0], range[1]);
}

/* Differences along the axes lie within the slopes, where those are known. */
static void slopes_enclose(check *test) {
    qni_box box = any_box(test);
    double points[POINTS][3], values[POINTS], moved[POINTS][3], others[POINTS], ranges[3][2];
    if (!test->solid->ops->slopes || !test->solid->ops->slopes(test->solid, &box, ranges))
        return;
    points_in(test, &box, points);
    values_of(test, test->solid, POINTS, points, values);
    for (int k = 0; k < 3; ++k) {
        memcpy(moved, points, sizeof moved);
        for (int n = 0; n < POINTS; ++n)
            moved[n][k] = between(test, box.low[k], box.high[k]);
        values_of(test, test->solid, POINTS, moved, others);
        for (int n = 0; n < POINTS; ++n) {
            const double step = moved[n][k] - points[n][k], rise = others[n] - values[n];
            const double low = step > 0 ? ranges[k][0] * step : ranges[k][1] * step,
                         high = step > 0 ? ranges[k][1] * step : ranges[k][0] * step;
            const double slack = 1e-9 * (fabs(low) + fabs(high)) +
                                 1e-13 * (1 + fabs(values[n]) + fabs(points[n][k]));
            if (isfinite(rise))
                CLAIM(test, rise >= low - slack && rise <= high + slack,
                      "f rises by %.17g over %.17g along axis %d, not within [%.17g, %.17g]", rise,
                      step, k, ranges[k][0], ranges[k][1]);
        }
    }
}

static int crossings_of(check *test, const qn_solid *solid, const double a[3], const double b[3],
                        qni_crossing *crossings) {
    int32_t count = -1;
    CLAIM(test, solid->ops->crossings(solid, a, b, ROOM, crossings, &count) == QN_OK,
          "no crossings");
    CLAIM(test, count >= 0 && count <= ROOM, "%d crossings", count);
    return count;
}

static void restriction_changes_nothing(check *test) {
    qni_box box = any_box(test);
    double points[POINTS][3], values[POINTS], restricted_values[POINTS];
    points_in(test, &box, points);
    qn_solid *restricted;
    CLAIM(test, test->solid->ops->restrict_to(test->solid, &box, &restricted) == QN_OK,
          "not restricted");
    values_of(test, test->solid, POINTS, points, values);
    values_of(test, restricted, POINTS, points, restricted_values);
    for (int n = 0; n < POINTS; ++n)
        CLAIM(test, values[n] == restricted_values[n],
              "f = %.17g, restricted to a box around %.17g", values[n], restricted_values[n]);
    bool inside[2][POINTS];
    CLAIM(test,
          qni_solid_inside(test->solid, POINTS, (const double(*)[3])points, inside[0]) == QN_OK &&
              qni_solid_inside(restricted, POINTS, (const double(*)[3])points, inside[1]) == QN_OK,
          "no signs");
    for (int n = 0; n < POINTS; ++n)
        CLAIM(test, inside[0][n] == (values[n] < 0) && inside[1][n] == inside[0][n],
              "f = %.17g, but inside is %d, restricted %d", values[n], inside[0][n], inside[1][n]);
    for (int n = 8; n + 1 < POINTS; n += 2) {
        qni_crossing all[ROOM], some[ROOM];
        int count = crossings_of(test, test->solid, points[n], points[n + 1], all);
        int restricted_count = crossings_of(test, restricted, points[n], points[n + 1], some);
        CLAIM(test, count == restricted_count, "%d crossings, %d when restricted", count,
              restricted_count);
        for (int i = 0; i < count; ++i)
            CLAIM(test, all[i].at == some[i].at && all[i].owner == some[i].owner,
                  "crossing %d at %.17g, restricted at %.17g", i, all[i].at, some[i].at);
    }
    qn_solid_destroy(restricted);
}

static void along(const double a[3], const double b[3], double t, double point[3]) {
    for (int k = 0; k < 3; ++k)
        point[k] = a[k] + t * (b[k] - a[k]);
}

/* Whether the list of crossings puts t inside; `near` is how far the next crossing is. */
static bool inside_by_list(bool inside, const qni_crossing *crossings, int count, double t,
                           double *near) {
    *near = 1;
    for (int i = 0; i < count; ++i) {
        *near = fmin(*near, fabs(crossings[i].at - t));
        if (crossings[i].at < t)
            inside = crossings[i].enters;
    }
    return inside;
}

static void check_crossing(check *test, const double a[3], const double b[3],
                           const qni_crossing *crossing) {
    const double *n = crossing->normal;
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), size = 0, step = 0;
    CLAIM(test, fabs(length - 1) < 1e-12, "a normal of length %.17g", length);
    for (int k = 0; k < 3; ++k) {
        step += n[k] * (b[k] - a[k]);
        size = fmax(size, fabs(b[k] - a[k]));
    }
    if (test->claims->all)
        CLAIM(test, crossing->enters ? step <= 1e-6 * size : step >= -1e-6 * size,
              "a normal that points into the solid: enters %d, %g along the segment",
              crossing->enters, step);
    if (test->claims->slope > 0) {
        double point[1][3], value;
        along(a, b, crossing->at, point[0]);
        values_of(test, test->solid, 1, point, &value);
        CLAIM(test, fabs(value) <= test->claims->slope * 1e-12 * (1 + size),
              "f = %g at crossing %.17g of (%.17g, %.17g, %.17g) - (%.17g, %.17g, %.17g), owner %d",
              value, crossing->at, a[0], a[1], a[2], b[0], b[1], b[2], crossing->owner);
    }
}

static void crossings_agree(check *test) {
    double ends[2][3], values[2], points[SAMPLES][3], sampled[SAMPLES];
    qni_crossing crossings[ROOM];
    any_point(test, ends[0]);
    any_point(test, ends[1]);
    int64_t kind = test_random_range(test->random, 0, 3);
    for (int k = 0; k < 3 && kind < 3; ++k) /* most edges of a lattice run along an axis */
        if (k != kind)
            ends[1][k] = ends[0][k];
    const double *a = ends[0], *b = ends[1];
    values_of(test, test->solid, 2, ends, values);
    int count = crossings_of(test, test->solid, a, b, crossings);
    CLAIM(test, (count % 2 != 0) == ((values[0] < 0) != (values[1] < 0)),
          "%d crossings between %g and %g", count, values[0], values[1]);
    for (int i = 0; i < count; ++i) {
        CLAIM(test, crossings[i].enters == ((values[0] < 0) == (i % 2 != 0)),
              "crossing %d turns the wrong way", i);
        CLAIM(test, crossings[i].at >= (i ? crossings[i - 1].at : 0) && crossings[i].at <= 1,
              "crossing at %g", crossings[i].at);
        check_crossing(test, a, b, &crossings[i]);
    }
    if (!test->claims->all)
        return;
    for (int n = 0; n < SAMPLES; ++n)
        along(a, b, (n + 0.5) / SAMPLES, points[n]);
    values_of(test, test->solid, SAMPLES, points, sampled);
    for (int n = 0; n < SAMPLES; ++n) {
        double near;
        bool inside = inside_by_list(values[0] < 0, crossings, count, (n + 0.5) / SAMPLES, &near);
        CLAIM(test, near < 1e-9 || fabs(sampled[n]) < 1e-11 || inside == (sampled[n] < 0),
              "f = %g where the crossings say %s, %g off the next one", sampled[n],
              inside ? "inside" : "outside", near);
    }
}

static void gradient_is_difference(check *test) {
    double centre[1][3], near[6][3], values[6], gradient[1][3], middle, step = 1e-5;
    any_point(test, centre[0]);
    for (int n = 0; n < 6; ++n) {
        for (int k = 0; k < 3; ++k)
            near[n][k] = centre[0][k];
        near[n][n / 2] += n % 2 ? step : -step;
    }
    values_of(test, test->solid, 1, centre, &middle);
    values_of(test, test->solid, 6, near, values);
    CLAIM(test,
          test->solid->ops->gradients(test->solid, 1, (const double(*)[3])centre, gradient, NULL) ==
              QN_OK,
          "no gradient");
    for (int k = 0; k < 3; ++k) {
        double before = (middle - values[2 * k]) / step,
               after = (values[2 * k + 1] - middle) / step;
        double tolerance = test->claims->difference * (1 + fabs(before));
        if (!(fabs(after - before) < tolerance)) /* a crease, or nothing there */
            continue;
        CLAIM(test, fabs(gradient[0][k] - 0.5 * (before + after)) <= tolerance,
              "gradient %g, difference %g along %d at (%.17g, %.17g, %.17g)", gradient[0][k],
              0.5 * (before + after), k, centre[0][0], centre[0][1], centre[0][2]);
    }
}

void test_solid_claims(const char *name, const qn_solid *solid, const test_claims *claims,
                       test_random *random) {
    check test = {name, solid, claims, random};
    for (int round = 0; round < claims->rounds; ++round) {
        bounds_enclose(&test);
        slopes_enclose(&test);
        restriction_changes_nothing(&test);
        crossings_agree(&test);
        if (claims->difference > 0)
            gradient_is_difference(&test);
    }
}
