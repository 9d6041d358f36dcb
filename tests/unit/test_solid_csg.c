// SPDX-License-Identifier: MIT
/* CSG trees built by calls: every node keeps the claims of solids, closed forms, ties, owners,
 * failures. */
#include <math.h>

#include "lib/solid_claims.h"

static void succeed(qn_status status, const qn_error *error) {
    if (status != QN_OK)
        fail_msg("%s", error->message);
}

/* The solid that a call puts into `made`. */
#define MAKE(call) (succeed((call), &error), made)

static double value(const qn_solid *solid, double x, double y, double z) {
    double point[1][3] = {{x, y, z}}, result;
    assert_int_equal(qn_solid_values(solid, 1, (const double(*)[3])point, &result, NULL), QN_OK);
    return result;
}

static qn_solid *box(qn_context *context, double x0, double y0, double z0, double x1, double y1,
                     double z1) {
    qn_solid *made;
    qn_error error;
    const double low[3] = {x0, y0, z0}, high[3] = {x1, y1, z1};
    return MAKE(qn_solid_box(context, low, high, &made, &error));
}

/* A primitive chosen by number. */
static qn_solid *primitive(qn_context *context, int64_t kind, test_random *random) {
    qn_solid *made;
    qn_error error;
    double a = 0.2 + 0.7 * test_random_unit(random), b = 0.2 + 0.7 * test_random_unit(random);
    int32_t n = (int32_t)test_random_range(random, 3, 20);
    const double normal[3] = {test_random_gaussian(random), test_random_gaussian(random), a};
    switch (kind) {
    case 0:
        return box(context, -a, -b, -0.5, b, a, 0.5);
    case 1:
        return MAKE(qn_solid_sphere(context, a, 0, &made, &error));
    case 2:
        return MAKE(qn_solid_sphere(context, a, n, &made, &error));
    case 3:
        return MAKE(qn_solid_cylinder(context, 2 * a, b, b, 0, &made, &error));
    case 4:
        return MAKE(qn_solid_cylinder(context, a, b, 0, 0, &made, &error));
    case 5:
        return MAKE(qn_solid_cylinder(context, a, b, 0.3, n, &made, &error));
    case 6:
        return MAKE(qn_solid_cylinder(context, a, 0, b, n, &made, &error));
    case 7:
        return MAKE(qn_solid_torus(context, a, 0.5 * a, &made, &error));
    default:
        return MAKE(qn_solid_half_space(context, normal, 0.3 * b, &made, &error));
    }
}

enum { PRIMITIVES = 9 };

/* Any rotation, scaling and shear with a determinant that is not small. */
static void random_matrix(test_random *random, double matrix[3][4]) {
    double determinant;
    do {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 4; ++j)
                matrix[i][j] = 0.5 * test_random_gaussian(random);
        determinant = 0;
        for (int k = 0; k < 3; ++k)
            determinant += matrix[0][k] * (matrix[1][(k + 1) % 3] * matrix[2][(k + 2) % 3] -
                                           matrix[1][(k + 2) % 3] * matrix[2][(k + 1) % 3]);
    } while (fabs(determinant) < 0.05);
}

static qn_solid *random_scene(qn_context *context, test_random *random, int depth) {
    qn_solid *made, *parts[4];
    qn_error error;
    int64_t kind = test_random_range(random, 0, depth > 0 ? 6 : 0);
    if (kind == 0)
        return primitive(context, test_random_range(random, 0, PRIMITIVES - 1), random);
    int64_t count = kind < 4 ? test_random_range(random, 1, 4) : 1;
    for (int64_t n = 0; n < count; ++n)
        parts[n] = random_scene(context, random, depth - 1);
    double matrix[3][4];
    random_matrix(random, matrix);
    switch (kind) {
    case 1:
        made = MAKE(qn_solid_union(context, count, parts, &made, &error));
        break;
    case 2:
        made = MAKE(qn_solid_intersection(context, count, parts, &made, &error));
        break;
    case 3:
        made = MAKE(qn_solid_difference(context, count, parts, &made, &error));
        break;
    case 4:
        made = MAKE(qn_solid_complement(context, parts[0], &made, &error));
        break;
    case 5:
        made = MAKE(qn_solid_with_owner(context, parts[0], 7, &made, &error));
        break;
    default:
        made =
            MAKE(qn_solid_transform(context, parts[0], (const double(*)[4])matrix, &made, &error));
        break;
    }
    for (int64_t n = 0; n < count; ++n)
        qn_solid_destroy(parts[n]);
    return made;
}

/* A star with a hole: not convex, two contours, points at x >= 0. */
static void star(test_random *random, double (*points)[2]) {
    for (int n = 0; n < 10; ++n) {
        double radius = (n % 2 ? 0.3 : 0.6) + 0.1 * test_random_unit(random),
               angle = 0.6283185307179586 * n;
        points[n][0] = 0.75 + radius * cos(angle);
        points[n][1] = radius * sin(angle);
    }
    for (int n = 0; n < 4; ++n) {
        points[10 + n][0] = 0.7 + 0.15 * (n == 1 || n == 2);
        points[10 + n][1] = 0.2 * (n > 1);
    }
}

static const test_claims all_claims = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}, .rounds = 60,
                                       .slope = 20,        .all = true,     .difference = 1e-3};

static void primitives_keep_all_claims(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (int64_t kind = 0; kind < PRIMITIVES; ++kind)
        for (int64_t n = 0; n < test_count(20, 1000); ++n) {
            char name[40];
            snprintf(name, sizeof name, "primitive %d", (int)kind);
            qn_solid *solid = primitive(context, kind, &random);
            test_solid_claims(name, solid, &all_claims, &random);
            qn_solid_destroy(solid);
        }
    test_context_end(context);
}

static void scenes_keep_all_claims(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (int64_t n = 0; n < test_count(400, 20000); ++n) {
        char name[40];
        snprintf(name, sizeof name, "scene %d", (int)n);
        qn_solid *solid = random_scene(context, &random, 3);
        test_solid_claims(name, solid, &all_claims, &random);
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

static void extrusions_and_hulls_keep_all_claims(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (int64_t n = 0; n < test_count(60, 5000); ++n) {
        qn_solid *made;
        qn_error error;
        double points[14][2], cloud[12][3];
        const int64_t sizes[2] = {10, 4};
        star(&random, points);
        qn_outline outline = {2, sizes, (const double(*)[2])points};
        qn_solid *straight = MAKE(qn_solid_linear_extrude(context, &outline, 0.7, &made, &error));
        double angle = n % 3 ? 700 * (test_random_unit(&random) - 0.5) : 360;
        int32_t fragments = (int32_t)test_random_range(&random, 3, 24);
        qn_solid *turned =
            MAKE(qn_solid_rotate_extrude(context, &outline, angle, fragments, &made, &error));
        qn_solid *round = MAKE(qn_solid_rotate_extrude(context, &outline, angle, 0, &made, &error));
        for (int i = 0; i < 12; ++i)
            for (int k = 0; k < 3; ++k)
                cloud[i][k] = test_random_gaussian(&random) * 0.5;
        qn_solid *hull = NULL;
        qn_status status = qn_solid_hull(context, 12, (const double(*)[3])cloud, &hull, &error);
        assert_true(status == QN_OK || status == QN_ERROR_UNSUPPORTED);
        test_claims inexact = all_claims;
        inexact.all = false;
        inexact.slope = 0; /* a revolution may jump beyond its angle, where it is outside anyway */
        test_solid_claims("extrusion", straight, &all_claims, &random);
        test_solid_claims("revolution with facets", turned, &all_claims, &random);
        test_solid_claims("round revolution", round, &inexact, &random);
        for (int i = 0; hull && i < 12; ++i) /* in the hull or on it */
            assert_true(value(hull, cloud[i][0], cloud[i][1], cloud[i][2]) < 1e-12);
        if (hull)
            test_solid_claims("hull", hull, &all_claims, &random);
        qn_solid *all[] = {straight, turned, round, hull};
        for (int i = 0; i < 4; ++i)
            qn_solid_destroy(all[i]);
    }
    test_context_end(context);
}

/* A prism over a star, given by its faces: the same solid as the extrusion. */
static void polyhedra_keep_all_claims(void **state) {
    (void)state;
    enum { N = 10 };
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (int64_t round = 0; round < test_count(60, 5000); ++round) {
        qn_solid *made;
        qn_error error;
        double flat[14][2], points[2 * N][3];
        int64_t sizes[N + 2] = {N, N}, indices[6 * N], used = 0;
        const int64_t contour[1] = {N};
        star(&random, flat);
        for (int n = 0; n < 2 * N; ++n) {
            points[n][0] = flat[n % N][0] - 0.7;
            points[n][1] = flat[n % N][1];
            points[n][2] = n < N ? 0 : 0.8;
        }
        for (int n = 0; n < N; ++n)
            indices[used++] = N - 1 - n;
        for (int n = 0; n < N; ++n)
            indices[used++] = N + n;
        for (int n = 0; n < N; ++n) {
            const int64_t wall[4] = {n, (n + 1) % N, N + (n + 1) % N, N + n};
            memcpy(indices + used, wall, sizeof wall);
            used += 4;
            sizes[2 + n] = 4;
        }
        qn_solid *solid = MAKE(qn_solid_polyhedron(context, 2 * N, (const double(*)[3])points,
                                                   N + 2, sizes, indices, &made, &error));
        test_solid_claims("polyhedron", solid, &all_claims, &random);
        qn_outline outline = {1, contour, (const double(*)[2])flat};
        qn_solid *straight = MAKE(qn_solid_linear_extrude(context, &outline, 0.8, &made, &error));
        for (int n = 0; n < 100; ++n) {
            double x = 2 * test_random_unit(&random) - 1, y = 2 * test_random_unit(&random) - 1;
            double z = 2 * test_random_unit(&random) - 0.5;
            double a = value(solid, x, y, z), b = value(straight, x + 0.7, y, z);
            assert_true(fabs(b) < 1e-12 || (a < 0) == (b < 0));
        }
        sizes[0] = N - 1; /* a face too small: open */
        assert_int_equal(qn_solid_polyhedron(context, 2 * N, (const double(*)[3])points, 1, sizes,
                                             indices, &made, &error),
                         QN_ERROR_INPUT);
        assert_non_null(strstr(error.message, "not closed"));
        qn_solid_destroy(solid);
        qn_solid_destroy(straight);
    }
    test_context_end(context);
}

static void values_are_closed_forms(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *made;
    qn_error error;
    qn_solid *ball = MAKE(qn_solid_sphere(context, 2, 0, &made, &error));
    assert_true(value(ball, 3, 4, 0) == 3 && value(ball, 0, 0, 0) == -2);
    qn_solid *ring = MAKE(qn_solid_torus(context, 2, 0.5, &made, &error));
    assert_true(value(ring, 0, 2, 0.5) == 0 && value(ring, 3, 0, 0) == 0.5 &&
                value(ring, 0, 0, 0) == 1.5);
    qn_solid *can = MAKE(qn_solid_cylinder(context, 2, 1, 1, 0, &made, &error));
    assert_true(value(can, 3, 0, 1) == 2 && value(can, 0, 0, 2.5) == 0.5 &&
                value(can, 0, 0, 1) == -1);
    qn_solid *cone = MAKE(qn_solid_cylinder(context, 1, 1, 0, 0, &made, &error));
    assert_true(fabs(value(cone, 1, 0, 0.5) - 0.5 / sqrt(2)) < 1e-15);
    qn_solid *dice = box(context, 0, 0, 0, 1, 2, 3);
    assert_true(value(dice, 0.5, 1, 1) == -0.5 && value(dice, 2, 1, 1) == 1);
    /* A facetted cylinder: corners on the circle, sides cos(180 / n) from the axis. */
    qn_solid *hexagon = MAKE(qn_solid_cylinder(context, 1, 1, 1, 6, &made, &error));
    assert_true(fabs(value(hexagon, 1, 0, 0.5)) < 1e-15);
    assert_true(fabs(value(hexagon, 0, 0, 0.5) + 0.5) < 1e-15 &&
                fabs(value(hexagon, 0, 1, 0.5) - (1 - sqrt(0.75))) < 1e-15);
    qn_solid *all[] = {ball, ring, can, cone, dice, hexagon};
    for (int n = 0; n < 6; ++n)
        qn_solid_destroy(all[n]);
    test_context_end(context);
}

static int crossings_of(const qn_solid *solid, const double a[3], const double b[3],
                        qni_crossing *crossings) {
    int32_t count;
    assert_int_equal(solid->ops->crossings(solid, a, b, 16, crossings, &count), QN_OK);
    return count;
}

/* Two boxes that share a face: nothing between them, neither crossings nor samples on the face. */
static void touching_boxes_have_no_gap(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_error error;
    for (int turned = 0; turned < 2; ++turned) {
        qn_solid *made, *parts[2] = {box(context, 0, 0, 0, 1, 1, 1),
                                     box(context, 0.25, 0.25, 1, 0.75, 0.75, 2)};
        qn_solid *both = MAKE(qn_solid_union(context, 2, parts, &made, &error));
        const double a[3] = {0.5, 0.5, -0.5}, b[3] = {0.5, 0.5, 2.5}, on_face[3] = {0.5, 0.5, 1};
        double matrix[3][4] = {
            {0.36, 0.48, -0.8, 0.1}, {-0.8, 0.6, 0, 0.2}, {0.48, 0.64, 0.6, 0.3}};
        double ends[3][3];
        const double *from[3] = {a, b, on_face};
        for (int n = 0; n < 3; ++n)
            for (int k = 0; k < 3; ++k)
                ends[n][k] = !turned ? from[n][k]
                                     : matrix[k][0] * from[n][0] + matrix[k][1] * from[n][1] +
                                           matrix[k][2] * from[n][2] + matrix[k][3];
        if (turned) {
            qn_solid *moved =
                MAKE(qn_solid_transform(context, both, (const double(*)[4])matrix, &made, &error));
            qn_solid_destroy(both);
            both = moved;
        }
        qni_crossing crossings[16];
        assert_int_equal(crossings_of(both, ends[0], ends[1], crossings), 2);
        if (!turned) {
            assert_true(value(both, 0.5, 0.5, 1) < 0);
            assert_int_equal(crossings_of(both, a, on_face, crossings), 1);
        }
        qn_solid_destroy(both);
        qn_solid_destroy(parts[0]);
        qn_solid_destroy(parts[1]);
    }
    test_context_end(context);
}

static void owners_are_those_of_the_active_part(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *made, *parts[2], *owned[2];
    qn_error error;
    parts[0] = box(context, 0, 0, 0, 1, 1, 1);
    parts[1] = box(context, 0.25, 0.25, 0.5, 0.75, 0.75, 1.5);
    for (int n = 0; n < 2; ++n)
        owned[n] = MAKE(qn_solid_with_owner(context, parts[n], 10 + n, &made, &error));
    qn_solid *cut = MAKE(qn_solid_difference(context, 2, owned, &made, &error));
    qni_crossing crossings[16];
    const double a[3] = {0.5, 0.5, -1}, b[3] = {0.5, 0.5, 2};
    assert_int_equal(crossings_of(cut, a, b, crossings), 2);
    assert_int_equal(crossings[0].owner, 10);
    assert_int_equal(crossings[1].owner, 11);
    assert_true(crossings[1].normal[2] == 1); /* out of the solid: up into the hole */
    assert_true(crossings[0].at == 1.0 / 3 && crossings[1].at == 0.5);
    qn_solid_destroy(cut);
    for (int n = 0; n < 2; ++n) {
        qn_solid_destroy(parts[n]);
        qn_solid_destroy(owned[n]);
    }
    test_context_end(context);
}

static void empty_parts_are_no_error(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *made, *parts[2];
    qn_error error;
    double low[3], high[3];
    parts[0] = box(context, 0, 0, 0, 1, 0, 1);
    parts[1] = MAKE(qn_solid_sphere(context, 1, 0, &made, &error));
    assert_true(value(parts[0], 0.5, 0, 0.5) > 0);
    qn_solid *both = MAKE(qn_solid_union(context, 2, parts, &made, &error));
    qn_solid_get_box(both, low, high);
    assert_true(low[0] == -1 && high[2] == 1 && value(both, 0, 0, 0) == -1);
    qn_solid *none = MAKE(qn_solid_intersection(context, 2, parts, &made, &error));
    qn_solid_get_box(none, low, high);
    assert_true(low[0] == high[0] && value(none, 0, 0, 0) > 0);
    qn_solid *nothing = MAKE(qn_solid_union(context, 0, NULL, &made, &error));
    assert_true(value(nothing, 0, 0, 0) > 0);
    qn_solid *all[] = {parts[0], parts[1], both, none, nothing};
    for (int n = 0; n < 5; ++n)
        qn_solid_destroy(all[n]);
    test_context_end(context);
}

static void bad_arguments_are_named(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *solid, *part = box(context, 0, 0, 0, 1, 1, 1);
    qn_error error;
    const double low[3] = {0, 1, 0}, high[3] = {1, 0, 1}, zero[3] = {0, 0, 0},
                 flat[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}};
#define REFUSED(call, says)                                                                        \
    assert_int_equal((call), QN_ERROR_INVALID_ARGUMENT);                                           \
    assert_null(solid);                                                                            \
    assert_non_null(strstr(error.message, says))
    REFUSED(qn_solid_box(context, low, high, &solid, &error), "axis 1");
    REFUSED(qn_solid_sphere(context, -1, 0, &solid, &error), "radius");
    REFUSED(qn_solid_sphere(context, 1, 2, &solid, &error), "fragments");
    REFUSED(qn_solid_cylinder(context, (double)NAN, 1, 1, 0, &solid, &error), "height");
    REFUSED(qn_solid_torus(context, 1, 2, &solid, &error), "meet itself");
    REFUSED(qn_solid_half_space(context, zero, 1, &solid, &error), "direction");
    REFUSED(qn_solid_transform(context, part, flat, &solid, &error), "inverted");
    REFUSED(qn_solid_offset(context, part, (double)INFINITY, &solid, &error), "finite");
    REFUSED(qn_solid_union(context, 1, NULL, &solid, &error), "none given");
    qn_solid *deep = part;
    for (int n = 0; n < 1000 && deep; ++n) {
        qn_solid *next;
        if (qn_solid_complement(context, deep, &next, &error) != QN_OK)
            assert_non_null(strstr(error.message, "deeper"));
        qn_solid_destroy(deep);
        deep = next;
    }
    assert_null(deep);
    test_context_end(context);
}

static void offsets_grow_and_shrink(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    qn_solid *made;
    qn_error error;
    qn_solid *ball = MAKE(qn_solid_sphere(context, 0.6, 0, &made, &error));
    for (int n = 0; n < 2; ++n) {
        qn_solid *grown = MAKE(qn_solid_offset(context, ball, n ? 0.4 : -0.4, &made, &error));
        assert_true(value(grown, 0, 0, 0) == (n ? -1.0 : 0.4 - 0.6));
        double low[3], high[3];
        qn_solid_get_box(grown, low, high);
        assert_true(low[0] <= (n ? -1.0 : -0.2) && low[0] >= -2);
        test_claims claims = all_claims;
        claims.all = false; /* pairs nearer than a 32nd of the segment may be missed */
        test_solid_claims("offset ball", grown, &claims, &random);
        qn_solid_destroy(grown);
    }
    qn_solid_destroy(ball);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(primitives_keep_all_claims),
        cmocka_unit_test(scenes_keep_all_claims),
        cmocka_unit_test(extrusions_and_hulls_keep_all_claims),
        cmocka_unit_test(polyhedra_keep_all_claims),
        cmocka_unit_test(values_are_closed_forms),
        cmocka_unit_test(touching_boxes_have_no_gap),
        cmocka_unit_test(owners_are_those_of_the_active_part),
        cmocka_unit_test(empty_parts_are_no_error),
        cmocka_unit_test(bad_arguments_are_named),
        cmocka_unit_test(offsets_grow_and_shrink),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
