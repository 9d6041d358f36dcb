// SPDX-License-Identifier: MIT
/* Callbacks and expression tapes: files and what is wrong with them, values, bounds, gradients,
 * pruning. */
#include <math.h>

#include "lib/solid_claims.h"
#include "solid/tape.h"
#include "unit/vm_table.h"

static qn_solid *parse(qn_context *context, const char *text) {
    qn_solid *solid = NULL;
    qn_error error;
    if (qn_solid_read_text(context, "test.vm", text, (int64_t)strlen(text), NULL, &solid, &error) !=
        QN_OK)
        fail_msg("%s", error.message);
    return solid;
}

static double value(const qn_solid *solid, double x, double y, double z) {
    double point[1][3] = {{x, y, z}}, result;
    assert_int_equal(qn_solid_values(solid, 1, (const double(*)[3])point, &result, NULL), QN_OK);
    return result;
}

static void every_operation_is_what_it_says(void **state) {
    (void)state;
    static const struct {
        const char *operation;
        double expected;
    } cases[] = {
        {"neg x", -0.5},
        {"abs y", 0.25},
        {"recip x", 2},
        {"square y", 0.0625},
        {"sqrt x", 0.70710678118654757},
        {"sin x", 0.47942553860420301},
        {"cos x", 0.87758256189037276},
        {"tan x", 0.54630248984379048},
        {"asin x", 0.52359877559829893},
        {"acos x", 1.0471975511965979},
        {"atan x", 0.46364760900080609},
        {"exp x", 1.6487212707001282},
        {"ln x", -0.69314718055994529},
        {"log x", -0.69314718055994529},
        {"add x y", 0.25},
        {"sub x y", 0.75},
        {"mul x y", -0.125},
        {"div x y", -2},
        {"min x y", -0.25},
        {"max x y", 0.5},
        {"var-z", 2},
        {"const 1e3", 1000},
    };
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[100];
        snprintf(text, sizeof text, "x var-x\ny var-y # comment\n\nr %s\n", cases[i].operation);
        qn_solid *solid = parse(context, text);
        double found = value(solid, 0.5, -0.25, 2);
        if (fabs(found - cases[i].expected) > 1e-15 * (1 + fabs(found)))
            fail_msg("%s gives %.17g, not %.17g", cases[i].operation, found, cases[i].expected);
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

static void bad_files_end_in_one_sentence(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"", "no operation"},
        {"# only a comment\n", "no operation"},
        {"x var-x\ny", "line 2: nothing follows"},
        {"x var-x\ny mod x x", "line 2: unknown operation 'mod'"},
        {"x var-x\ny add x", "line 2: 'add' takes 2 operands, but 1 follow"},
        {"x var-x x", "'var-x' takes 0 operands"},
        {"x var-x\ny add x z", "no earlier line has the name 'z'"},
        {"x neg x", "no earlier line has the name 'x'"},
        {"x var-x\nx var-y", "a second line has the name 'x'"},
        {"c const 1.2.3", "not a finite number: '1.2.3'"},
        {"c const nan", "not a finite number"},
        {"c const 1e999", "not a finite number"},
        {"c const 0x10", "not a finite number"},
        {"\xff\xfe oops", "unknown operation 'oops'"},
    };
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        qn_solid *solid;
        qn_error error = {0};
        assert_int_equal(qn_solid_read_text(context, "bad.vm", cases[i].text,
                                            (int64_t)strlen(cases[i].text), NULL, &solid, &error),
                         QN_ERROR_INPUT);
        assert_null(solid);
        if (!strstr(error.message, cases[i].says) || !strstr(error.message, "bad.vm"))
            fail_msg("'%s' should say '%s'", error.message, cases[i].says);
    }
    test_context_end(context);
}

static void nan_is_outside(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *solid = parse(context, "x var-x\nr sqrt x\nh const 0.5\nf sub r h\n");
    assert_true(value(solid, -1, 0, 0) > 0);
    assert_true(value(solid, 0.2, 0, 0) < 0);
    double range[2];
    qni_box box = {{-1, 0, 0}, {0.1, 1, 1}};
    assert_int_equal(solid->ops->bounds(solid, &box, range), QN_OK);
    assert_true(range[0] <= -0.5 && isinf(range[1]));
    qn_solid_destroy(solid);
    test_context_end(context);
}

/* The tie rule of min and max: the first operand, in values, gradients and restriction alike. */
static void ties_take_the_first(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *solid = parse(context, "x var-x\ny var-y\nm max x y\n");
    double point[1][3] = {{0.5, 0.5, 0}}, gradient[1][3];
    assert_int_equal(solid->ops->gradients(solid, 1, (const double(*)[3])point, gradient, NULL),
                     QN_OK);
    assert_true(gradient[0][0] == 1 && gradient[0][1] == 0);
    qn_solid_destroy(solid);
    test_context_end(context);
}

/* A random expression of some depth, safe operations and unsafe ones alike. */
/* Faces that lie in each other: below z = 1/2 one branch is active, above another, and at 1/2 the
 * first of those that tie, which points the other way. */
static void crossings_at_ties_point_out(void **state) {
    (void)state;
    static const double low[3] = {0.1, 0.2, 0}, high[3] = {0.1, 0.2, 1};
    qn_context *context = test_context(1);
    qn_solid *solid = parse(context, "z var-z\nh const 0.5\nover sub z h\nunder sub h z\n"
                                     "both min under over\nr max both over\n");
    for (int turned = 0; turned < 2; ++turned) {
        qni_crossing found[4];
        int32_t count = 0;
        assert_int_equal(solid->ops->crossings(solid, turned ? high : low, turned ? low : high, 4,
                                               found, &count),
                         QN_OK);
        assert_int_equal(count, 1);
        assert_true(found[0].enters == (turned == 1));
        assert_float_equal(found[0].at, 0.5, 1e-9);
        assert_float_equal(found[0].normal[2], 1, 1e-12);
    }
    qn_solid_destroy(solid);
    test_context_end(context);
}

static void random_text(test_random *random, char *text, size_t size) {
    static const char *const unary[] = {"neg",  "abs", "square", "sqrt", "sin", "cos",  "exp",
                                        "atan", "tan", "asin",   "acos", "ln",  "recip"};
    static const char *const binary[] = {"add", "sub", "mul", "min", "max", "min", "max", "div"};
    size_t used = (size_t)snprintf(text, size, "n0 var-x\nn1 var-y\nn2 var-z\nn3 const %.3f\n",
                                   test_random_gaussian(random));
    int count = 4, total = (int)test_random_range(random, 8, 40);
    for (; count < total; ++count) {
        int a = (int)test_random_range(random, 0, count - 1),
            b = (int)test_random_range(random, 0, count - 1);
        if (count == total - 1 || test_random_unit(random) < 0.6) {
            used += (size_t)snprintf(text + used, size - used, "n%d %s n%d n%d\n", count,
                                     binary[test_random_range(random, 0, 7)],
                                     count == total - 1 ? count - 1 : a, b);
        } else {
            used += (size_t)snprintf(text + used, size - used, "n%d %s n%d\n", count,
                                     unary[test_random_range(random, 0, 12)], a);
        }
    }
}

static void random_tapes_keep_all_claims(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    test_claims claims = {{-2, -2, -2}, {2, 2, 2}, .rounds = 20};
    for (int64_t n = 0; n < test_count(1000, 40000); ++n) {
        char text[4000];
        random_text(&random, text, sizeof text);
        qn_solid *solid = parse(context, text);
        test_solid_claims(text, solid, &claims, &random);
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

static void smooth_tapes_have_exact_gradients(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    qn_solid *solid =
        parse(context, "x var-x\ny var-y\nz var-z\nx2 square x\ny2 square y\nz2 square z\n"
                       "a add x2 y2\nb sqrt a\nc const 1.5\nd sub b c\ne square d\ng add e z2\n"
                       "h sqrt g\ni const 0.5\nt sub h i\ns sin x\nk cos y\nl mul s k\nm exp l\n"
                       "o const 0.3\np mul m o\nq add t p\nr div q m\nu max r z\nv atan u\n");
    test_claims claims = {{-2, -2, -2}, {2, 2, 2}, .rounds = 5000, .difference = 1e-4};
    test_solid_claims("torus and more", solid, &claims, &random);
    qn_solid_destroy(solid);
    test_context_end(context);
}

static void restriction_shortens(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid *solid = parse(context, "x var-x\ny var-y\na neg x\nb square y\nm min a b\n");
    qni_box box = {{0.5, 0.5, 0}, {1, 1, 1}};
    qn_solid *restricted;
    assert_int_equal(solid->ops->restrict_to(solid, &box, &restricted), QN_OK);
    assert_int_equal(((qni_tape *)restricted)->count, 2);
    assert_true(value(restricted, 0.7, 0.7, 0) == -0.7);
    qn_solid_destroy(restricted);
    qn_solid_destroy(solid);
    test_context_end(context);
}

static void files_of_the_data_folder(void **state) {
    (void)state;
    static const char *const names[] = {"csg/colonnade.vm", "csg/hi.vm", "csg/quarter.vm",
                                        "csg/tanglecube.vm"};
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char path[4096];
        if (!test_data_path(names[i], path, sizeof path))
            continue;
        qn_solid *solid;
        qn_error error;
        if (qn_solid_read(context, path, NULL, &solid, &error) != QN_OK)
            fail_msg("%s", error.message);
        test_claims claims = {{-1, -1, -1}, {1, 1, 1}, .rounds = 300, .difference = 1e-3};
        test_solid_claims(names[i], solid, &claims, &random);
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

/* As evaluated by a few lines of Python, make_vm_table.py. */
static void values_are_those_of_another_evaluator(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    for (size_t i = 0; i < sizeof vm_table / sizeof *vm_table; ++i) {
        char path[4096], relative[256];
        snprintf(relative, sizeof relative, "csg/%s.vm", vm_table[i].name);
        if (!test_data_path(relative, path, sizeof path))
            break;
        qn_solid *solid;
        assert_int_equal(qn_solid_read(context, path, NULL, &solid, NULL), QN_OK);
        const double *p = vm_table[i].point;
        double found = value(solid, p[0], p[1], p[2]);
        if (!(fabs(found - vm_table[i].value) <= 1e-14))
            fail_msg("%s: %.17g, not %.17g", vm_table[i].name, found, vm_table[i].value);
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

/* The unit sphere as a callback; `stop` makes every function ask to stop. */
typedef struct ball {
    bool stop;
    int64_t evaluations;
} ball;

static int ball_values(void *user, int64_t count, const double (*points)[3], double *values) {
    ball *self = user;
    self->evaluations += count;
    for (int64_t n = 0; n < count; ++n) {
        const double *p = points[n];
        values[n] = p[0] > 9 ? (double)NAN : sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 1;
    }
    return self->stop;
}

static void callbacks_have_defaults(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    ball self = {0};
    qn_solid_callback callback;
    qn_solid_callback_init(&callback);
    callback.user = &self;
    callback.values = ball_values;
    for (int k = 0; k < 3; ++k)
        callback.low[k] = -1.5, callback.high[k] = 1.5;
    for (int known = 0; known < 2; ++known) {
        callback.lipschitz = known;
        qn_solid *solid;
        assert_int_equal(qn_solid_from_callback(context, &callback, &solid, NULL), QN_OK);
        test_claims claims = {
            {-1.3, -1.3, -1.3}, {1.3, 1.3, 1.3}, .rounds = 1000, .slope = 1, .difference = 1e-3};
        test_solid_claims("ball", solid, &claims, &random);
        assert_true(isinf(value(solid, 10, 0, 0)));
        qni_crossing crossings[4];
        int32_t count;
        const double a[3] = {-1.2, 0.1, 0}, b[3] = {1.2, 0.1, 0};
        assert_int_equal(solid->ops->crossings(solid, a, b, 4, crossings, &count), QN_OK);
        assert_int_equal(count, known ? 2 : 0); /* without a bound only the ends speak */
        self.stop = true;
        double v, point[1][3] = {{0, 0, 0}};
        assert_int_equal(qn_solid_values(solid, 1, (const double(*)[3])point, &v, NULL),
                         QN_ERROR_CANCELLED);
        self.stop = false;
        qn_solid_destroy(solid);
    }
    test_context_end(context);
}

static void bad_callbacks_are_named(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    qn_solid_callback callback;
    qn_solid *solid;
    qn_error error;
    memset(&callback, 0, sizeof callback);
    assert_int_equal(qn_solid_from_callback(context, &callback, &solid, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "qn_solid_callback_init"));
    qn_solid_callback_init(&callback);
    assert_int_equal(qn_solid_from_callback(context, &callback, &solid, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "values"));
    callback.values = ball_values;
    assert_int_equal(qn_solid_from_callback(context, &callback, &solid, &error),
                     QN_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "axis 0"));
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_operation_is_what_it_says),
        cmocka_unit_test(bad_files_end_in_one_sentence),
        cmocka_unit_test(nan_is_outside),
        cmocka_unit_test(ties_take_the_first),
        cmocka_unit_test(crossings_at_ties_point_out),
        cmocka_unit_test(random_tapes_keep_all_claims),
        cmocka_unit_test(smooth_tapes_have_exact_gradients),
        cmocka_unit_test(restriction_shortens),
        cmocka_unit_test(files_of_the_data_folder),
        cmocka_unit_test(values_are_those_of_another_evaluator),
        cmocka_unit_test(callbacks_have_defaults),
        cmocka_unit_test(bad_callbacks_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
