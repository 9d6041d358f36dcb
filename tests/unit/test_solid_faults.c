// SPDX-License-Identifier: MIT
/* Memory that runs out at any moment while solids are read and asked: the right status, nothing
 * left behind. */
#include "lib/solid_claims.h"

/* malloc that fails once `left` requests were served. */
typedef struct meagre {
    int64_t left;
} meagre;

static void *meagre_alloc(void *user, size_t size, size_t alignment) {
    meagre *self = user;
    if (self->left-- <= 0)
        return NULL;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void meagre_free(void *user, void *pointer, size_t size) {
    (void)user, (void)size;
    free(pointer);
}

/* Everything that asks for memory, once. */
static qn_status use(qn_context *context, const char *name, const char *text) {
    static const double a[3] = {-1.5, 0.1, 0.2}, b[3] = {2.5, 0.3, 0.4};
    const qni_box box = {{0.1, 0.1, 0.1}, {0.3, 0.4, 0.3}};
    qn_solid *solid, *restricted = NULL;
    qni_crossing crossings[16];
    int32_t count;
    double range[2], value, gradient[1][3];
    qn_error error = {0};
    qn_status status =
        qn_solid_read_text(context, name, text, (int64_t)strlen(text), NULL, &solid, &error);
    if (status != QN_OK) {
        assert_null(solid);
        assert_true(error.message[0]);
        return status;
    }
    status = solid->ops->bounds(solid, &box, range);
    if (status == QN_OK)
        status = solid->ops->values(solid, 1, (const double(*)[3]) & a, &value);
    if (status == QN_OK)
        status = solid->ops->gradients(solid, 1, (const double(*)[3]) & a, gradient, NULL);
    if (status == QN_OK)
        status = solid->ops->crossings(solid, a, b, 16, crossings, &count);
    if (status == QN_OK)
        status = solid->ops->restrict_to(solid, &box, &restricted);
    qn_solid_destroy(restricted);
    qn_solid_destroy(solid);
    return status;
}

static void runs_out(const char *name, const char *text) {
    int64_t failures = 0;
    for (int64_t served = 1;; ++served) {
        meagre self = {served};
        qn_context_options options;
        qn_context_options_init(&options);
        options.allocator = (qn_allocator){&self, meagre_alloc, meagre_free};
        options.threads = 1;
        qn_context *context;
        if (qn_context_create(&options, &context, NULL) != QN_OK)
            continue;
        qn_status status = use(context, name, text);
        assert_int_equal(qn_context_memory(context).current_bytes, 0);
        qn_context_destroy(context);
        if (status == QN_OK ||
            status == QN_ERROR_UNSUPPORTED) /* a build without Qhull: that much is read */
            break;
        assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
        ++failures;
    }
    assert_true(failures > 3);
}

static void tapes_survive_lack_of_memory(void **state) {
    (void)state;
    runs_out("x.vm", "x var-x\ny var-y\na neg x\nb square y\nm min a b\nn max m y\n");
}

/* More registers than fit on the stack: every value is used only at the end. */
static void long_tapes_survive_lack_of_memory(void **state) {
    (void)state;
    enum { LINES = 3000 };
    char *text = test_alloc(LINES * 40, 1);
    size_t used = (size_t)sprintf(text, "x var-x\nv0 neg x\n");
    for (int n = 1; n < LINES / 2; ++n)
        used += (size_t)sprintf(text + used, "v%d add v%d x\n", n, n - 1);
    used += (size_t)sprintf(text + used, "s0 neg x\n");
    for (int n = 1; n < LINES / 2; ++n)
        used += (size_t)sprintf(text + used, "s%d min s%d v%d\n", n, n - 1, n);
    runs_out("x.vm", text);
    free(text);
}

static void trees_survive_lack_of_memory(void **state) {
    (void)state;
    runs_out(
        "x.csg",
        "difference() { cube(size = [2, 2, 2], center = true); multmatrix([[0.8, -0.6, 0, 0], "
        "[0.6, 0.8, 0, 0], "
        "[0, 0, 1, 0], [0, 0, 0, 1]]) { union() { cube(size = [3, 0.3, 0.5], center = true); "
        "sphere(r = 0.4, "
        "$fn = 8); } } }\n"
        "linear_extrude(height = 1) { difference() { polygon(points = [[0, 0], [2, 0], [1, 0.5], "
        "[2, 2], [0, 2]], "
        "paths = [[0, 1, 2, 3, 4]]); circle(r = 0.3, $fn = 6); } }\n"
        "rotate_extrude(angle = 200, $fn = 12) { difference() { square(size = [2, 1], center = "
        "false); "
        "polygon(points = [[0.1, 0.1], [1, 0.2], [0.5, 0.3], [1, 0.6]]); } }\n"
        "hull() { cube(size = [1, 1, 1]); intersection() { cube(size = [3, 3, 3]); cube(size = [2, "
        "4, 1]); } "
        "linear_extrude(height = 2) { hull() { square(size = 1); circle(r = 1, $fn = 5); } } }\n"
        "linear_extrude(height = 3) { projection(cut = true) { cylinder(h = 1, r1 = 1, r2 = 0.5, "
        "center = true); "
        "} }\n");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tapes_survive_lack_of_memory),
        cmocka_unit_test(long_tapes_survive_lack_of_memory),
        cmocka_unit_test(trees_survive_lack_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
