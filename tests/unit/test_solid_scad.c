// SPDX-License-Identifier: MIT
/* .csg texts: what each module means, and the sentences that bad or unsupported ones end in. */
#include <math.h>

#include "lib/solid_claims.h"

static double volume_of(qn_context *context, const char *text, bool smooth, test_random *random) {
    qn_solid_read_options options;
    qn_solid_read_options_init(&options);
    options.smooth_primitives = smooth;
    qn_solid *solid;
    qn_error error;
    if (qn_solid_read_text(context, "test.csg", text, (int64_t)strlen(text), &options, &solid,
                           &error) != QN_OK)
        fail_msg("%s", error.message);
    double low[3], high[3], sum = 0;
    qn_solid_get_box(solid, low, high);
    enum { SIDE = 200 };
    for (int n = 0; n < SIDE * SIDE && low[0] < high[0]; ++n) {
        double a[3] = {low[0] - 1}, b[3] = {high[0] + 1}, before = 0;
        a[1] = b[1] = low[1] + (high[1] - low[1]) * (n % SIDE + test_random_unit(random)) / SIDE;
        a[2] = b[2] = low[2] + (high[2] - low[2]) * (n / SIDE + test_random_unit(random)) / SIDE;
        qni_crossing crossings[32];
        int32_t count;
        assert_int_equal(solid->ops->crossings(solid, a, b, 32, crossings, &count), QN_OK);
        for (int32_t i = 0; i < count; ++i) {
            sum += crossings[i].enters ? 0 : (crossings[i].at - before) * (b[0] - a[0]);
            before = crossings[i].at;
        }
    }
    qn_solid_destroy(solid);
    return sum * (high[1] - low[1]) * (high[2] - low[2]) / (SIDE * SIDE);
}

static void modules_have_their_volumes(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double volume;
        bool smooth, needs_hull;
    } cases[] = {
        {"cube(size = [1, 2, 3], center = false);", 6, false, false},
        {"union() { cube(size = 2); cube(size = [1, 1, 4]); }", 10, false, false},
        {"difference() { cube(size = 2); cube(size = [1, 1, 4]); %cube(size = 9); *cube(size = 9); "
         "}",
         6, false, false},
        {"difference() { group(); cube(size = 2); }", 0, false, false},
        {"intersection() { cube(size = 2); group(); }", 0, false, false},
        {"intersection() { cube(size = 2); #cube(size = [1, 1, 4]); }", 2, false, false},
        {"color([1, 0, 0, 1]) { render(convexity = 2) { cube(size = 1); } }", 1, false, false},
        {"multmatrix([[2, 0, 0, 5], [0, -1, 0, 0], [0, 0.5, 1, 0], [0, 0, 0, 1]]) { cube(size = "
         "1); }",
         2, false, false},
        {"multmatrix([[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(size = 1); }",
         0, false, false},
        {"sphere(r = 2);", 4.0 / 3 * 8 * 3.14159265358979323846, true, false},
        {"cylinder(h = 3, r1 = 2, r2 = 1, center = true);", 7 * 3.14159265358979323846, true,
         false},
        {"cylinder($fn = 4, h = 3, r1 = 1, r2 = 1, center = true);", 6, false, false},
        {"linear_extrude(height = 2, center = true, scale = [1, 1]) { difference() { square(size = "
         "[2, 3]); "
         "polygon(points = [[0, 0], [1, 0], [1, 1]], paths = undef); } }",
         11, false, false},
        {"linear_extrude(height = 1) { polygon(points = [[0, 0], [4, 0], [4, 4], [0, 4], [1, 1], "
         "[2, 1], [2, 2], [1, 2]], "
         "paths = [[0, 1, 2, 3], [4, 5, 6, 7]]); }",
         15, false, false},
        {"linear_extrude(height = 1) { circle(r = 2); }", 4 * 3.14159265358979323846, true, false},
        {"linear_extrude(height = 1) { projection(cut = true) { cube(size = [2, 3, 1], center = "
         "true); } }",
         6, false, false},
        {"linear_extrude(height = 1) { projection(cut = false) { multmatrix([[0.6, 0, 0.8, 5], [0, "
         "1, "
         "0, 0], [-0.8, 0, 0.6, 9], [0, 0, 0, 1]]) { cube(size = [2, 3, 1]); } } }",
         6, false, false},
        {"linear_extrude(height = 1) { projection(cut = false) { difference() { cube(size = [4, 4, "
         "2]); "
         "multmatrix([[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, -1], [0, 0, 0, 1]]) { cube(size = [1, "
         "1, "
         "9]); } multmatrix([[1, 0, 0, 2], [0, 1, 0, 2], [0, 0, 1, 1], [0, 0, 0, 1]]) { cube(size "
         "= 1); } } } }",
         15, false, false},
        {"rotate_extrude(angle = 90) { multmatrix([[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0], [0, "
         "0, 0, 1]]) { "
         "square(size = [1, 1], center = true); } }",
         1.5 * 3.14159265358979323846, true, false},
        {"rotate_extrude($fn = 4, angle = 360) { square(size = [1, 2]); }", 4, false, false},
        {"rotate_extrude($fn = 4, angle = -270) { square(size = [1, 2]); }", 3, false, false},
        {"hull() { cube(size = 1); multmatrix([[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, "
         "1]]) { cube(size = 1); } }",
         3, false, true},
        {"minkowski(convexity = 0) { cube(size = [1, 2, 3]); cube(size = [2, 1, 1], center = "
         "true); cube(size = 1); }",
         80, false, true},
        {"linear_extrude(height = 1) { minkowski() { square(size = 2); circle(r = 1, $fn = 4); } }",
         14, false, true},
        {"polyhedron(points = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 3]], faces = "
         "[[0, 1, 4], [1, 2, 4], "
         "[2, 3, 4], [3, 0, 4], [3, 2, 1, 0]]);",
         4, false, false},
        {"polyhedron(points = [[0, 0, 0], [3, 0, 0], [1, 1, 0], [0, 3, 0], [0, 0, 1], [3, 0, 1], "
         "[1, 1, 1], [0, 3, 1]], "
         "faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, "
         "7]]);",
         3, false, false},
    };
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        qn_solid *solid;
        qn_error error;
        if (cases[i].needs_hull &&
            qn_solid_hull(context, 0, NULL, &solid, &error) == QN_ERROR_UNSUPPORTED)
            continue;
        double found = volume_of(context, cases[i].text, cases[i].smooth, &random);
        if (!(fabs(found - cases[i].volume) <= 0.005 * (cases[i].volume + 0.1)))
            fail_msg("%s has volume %g, not %g", cases[i].text, found, cases[i].volume);
    }
    test_context_end(context);
}

static void bad_texts_end_in_one_sentence(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
        qn_status status;
    } cases[] = {
        {"cube(size = [1, 2, 3]", "line 1, column 22: expected ',' or ')', found the end",
         QN_ERROR_INPUT},
        {"cube(size = [1, 2, 3])", "expected ';' or '{', found the end", QN_ERROR_INPUT},
        {"\n  cube(size = [1, 2]);", "line 2, column 3, cube: size must be a vector of 3 numbers",
         QN_ERROR_INPUT},
        {"cube(size = [1, 2, nan]);", "finite", QN_ERROR_INPUT},
        {"sphere();", "r is missing", QN_ERROR_INPUT},
        {"cylinder(h = 1, r1 = 1);", "r2 is missing", QN_ERROR_INPUT},
        {"cube(size = 1); }", "expected the end or the name of a module, found '}'",
         QN_ERROR_INPUT},
        {"group() { cube(size = 1);", "expected '}'", QN_ERROR_INPUT},
        {"text(text = \"abc\", size = 10);", "flat shape", QN_ERROR_INPUT},
        {"linear_extrude(height = 1) { text(text = \"a\"); }", "text: this module is not supported",
         QN_ERROR_UNSUPPORTED},
        {"minkowski() { cube(size = 1);\n union() { cube(size = 1); cube(size = [2, 1, 0.5]); } }",
         "line 2: only convex", QN_ERROR_UNSUPPORTED},
        {"minkowski() { cube(size = 1);\n group(); }", "line 2: only convex", QN_ERROR_UNSUPPORTED},
        {"import(file = \"a.stl\");", "import: 'a.stl' is no file", QN_ERROR_INPUT},
        {"import(file = \"/dev/zero\");", "is no file", QN_ERROR_INPUT},
        {"import(1);", "expected the name of a file", QN_ERROR_INPUT},
        {"surface(file = \"a.png\");", "surface: this module", QN_ERROR_UNSUPPORTED},
        {"!cube(size = 1);", "the modifier '!'", QN_ERROR_UNSUPPORTED},
        {"linear_extrude(height = 1, twist = 90) { square(size = 1); }", "twist = 90",
         QN_ERROR_UNSUPPORTED},
        {"linear_extrude(height = 1, scale = [2, 1]) { square(size = 1); }", "scale = [2, 1]",
         QN_ERROR_UNSUPPORTED},
        {"linear_extrude(height = 0) { square(size = 1); }", "height is 0", QN_ERROR_INPUT},
        {"linear_extrude(height = 1) { offset(r = 1) { square(size = 1); } }",
         "offset: this module", QN_ERROR_UNSUPPORTED},
        {"rotate_extrude() { square(size = 1, center = true); }", "over the axis", QN_ERROR_INPUT},
        {"multmatrix([[1, 0], [0, 1]]) { cube(size = 1); }", "matrix of four rows", QN_ERROR_INPUT},
        {"polyhedron(points = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces = [[0, 1, 2]]);",
         "not closed", QN_ERROR_INPUT},
        {"polyhedron(points = [[0, 0, 0]], faces = [[0, 1, 2]]);", "face 0 names a point",
         QN_ERROR_INPUT},
        {"sphere(r = 1, $fn = 99999);", "99999 facets", QN_ERROR_UNSUPPORTED},
    };
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        qn_solid *solid;
        qn_error error = {0};
        qn_status status = qn_solid_read_text(context, "bad.csg", cases[i].text,
                                              (int64_t)strlen(cases[i].text), NULL, &solid, &error);
        if (status != cases[i].status || !strstr(error.message, cases[i].says) ||
            !strstr(error.message, "bad.csg"))
            fail_msg("%s ends in %d '%s', which should say '%s'", cases[i].text, (int)status,
                     error.message, cases[i].says);
        assert_null(solid);
    }
    test_context_end(context);
}

/* Nesting without end must not end on the stack. */
static void deep_nesting_is_refused(void **state) {
    (void)state;
    enum { DEPTH = 100000 };
    qn_context *context = test_context(1);
    char *text = test_alloc(DEPTH * 8 + 1, 1);
    text[0] = 0;
    for (int n = 0; n < DEPTH; ++n)
        memcpy(text + 8 * n, "group(){", 9);
    qn_solid *solid;
    qn_error error;
    assert_int_equal(qn_solid_read_text(context, "deep.csg", text, 8 * DEPTH, NULL, &solid, &error),
                     QN_ERROR_INPUT);
    assert_non_null(strstr(error.message, "less nesting"));
    free(text);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modules_have_their_volumes),
        cmocka_unit_test(bad_texts_end_in_one_sentence),
        cmocka_unit_test(deep_nesting_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
