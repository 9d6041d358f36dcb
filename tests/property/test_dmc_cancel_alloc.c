// SPDX-License-Identifier: MIT
/* The n-th allocation fails, for every n; the n-th progress call cancels, for every n: the right
 * status, no mesh, no memory kept. And samples that are no numbers: counted, closed, finite. */
#include "lib/mesh_measure.h"
#include "lib/random_volume.h"
#include "lib/reference_match.h"

#include <math.h>
#include <stdatomic.h>

typedef struct trouble {
    _Atomic int64_t allocations, releases;
    int64_t failing; /* the allocation that fails, from 1; 0: none */
    int64_t progress_calls, cancelling;
    bool fraction_is_bad;
} trouble;

static void *alloc_or_fail(void *user, size_t size, size_t alignment) {
    trouble *t = user;
    if (atomic_fetch_add(&t->allocations, 1) + 1 == t->failing)
        return NULL;
    void *memory = NULL;
    return posix_memalign(&memory, alignment < sizeof memory ? sizeof memory : alignment,
                          size ? size : 1) == 0
               ? memory
               : NULL;
}

static void count_free(void *user, void *pointer, size_t size) {
    (void)size;
    atomic_fetch_add(&((trouble *)user)->releases, 1);
    free(pointer);
}

static int progress(void *user, const char *stage, double fraction) {
    trouble *t = user;
    t->fraction_is_bad |= !(fraction >= 0 && fraction <= 1) || !stage;
    return ++t->progress_calls == t->cancelling;
}

static qn_context *troubled_context(trouble *t, int32_t threads) {
    qn_context_options options;
    qn_context_options_init(&options);
    options.allocator.user = t;
    options.allocator.alloc = alloc_or_fail;
    options.allocator.free = count_free;
    options.threads = threads;
    options.progress = progress;
    options.user = t;
    qn_context *context;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    return context;
}

static void free_meshes(qn_mesh *meshes[2]) {
    qn_mesh_destroy(meshes[0]);
    qn_mesh_destroy(meshes[1]);
}

/* One run with trouble: what it ended with. Checks that a failure leaves nothing. */
static qn_status troubled_run(trouble *t, const test_field *field, int32_t threads) {
    const int64_t failing = t->failing;
    t->failing = 0; /* not while the context and the volume are made */
    qn_context *context = troubled_context(t, threads);
    qn_volume *volume = test_field_volume(context, field);
    const double isovalues[2] = {field->iso, field->iso + 0.3};
    qn_surface_options options = test_field_options(field);
    options.isovalues = isovalues;
    options.isovalue_count = 2;
    options.keep_doubled = false;
    options.topology = QN_TOPOLOGY_EXACT;
    options.triangles = threads == 2;
    int64_t before = qn_context_memory(context).current_bytes;
    qn_mesh *meshes[2] = {(qn_mesh *)t, (qn_mesh *)t};
    qn_error error = {QN_OK, ""};
    t->failing = failing ? failing + atomic_load(&t->allocations) : 0;
    qn_status status = qn_surface(context, volume, &options, meshes, NULL, &error);
    if (status != QN_OK) {
        assert_null(meshes[0]);
        assert_null(meshes[1]);
        assert_int_equal(error.status, status);
        assert_true(strlen(error.message) > 0);
        assert_int_equal(qn_context_memory(context).current_bytes, before);
    } else {
        free_meshes(meshes);
    }
    qn_volume_destroy(volume);
    test_context_end(context);
    assert_int_equal(atomic_load(&t->allocations) - (failing && status != QN_OK), t->releases);
    return status;
}

static test_field noise(test_random *random, int64_t n) {
    test_field field = test_field_make(n, n + 3, n - 2);
    test_random_fill(&field, random, TEST_GAUSSIAN);
    test_field_prepare(&field);
    return field;
}

static void failed_allocations_leave_nothing(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int32_t threads = 1; threads <= 2; ++threads) {
        test_field field = noise(&random, 12);
        int64_t n = 0;
        qn_status status;
        do {
            trouble t = {.failing = ++n};
            status = troubled_run(&t, &field, threads);
            if (status != QN_OK)
                assert_int_equal(status, QN_ERROR_OUT_OF_MEMORY);
        } while (status != QN_OK);
        printf("%d threads: %lld allocations failed in turn\n", (int)threads, (long long)(n - 1));
        assert_true(n > 3);
        test_field_free(&field);
    }
}

static void cancelling_leaves_nothing(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int32_t threads = 1; threads <= 2; ++threads) {
        test_field field = noise(&random, threads == 1 ? 12 : 70);
        int64_t n = 0;
        qn_status status;
        do {
            trouble t = {.cancelling = ++n};
            status = troubled_run(&t, &field, threads);
            assert_false(t.fraction_is_bad);
            if (status != QN_OK)
                assert_int_equal(status, QN_ERROR_CANCELLED);
        } while (status != QN_OK);
        printf("%d threads: cancelled at %lld places\n", (int)threads, (long long)(n - 1));
        assert_true(n > 2);
        test_field_free(&field);
    }
}

/* ---- samples that are no numbers --------------------------------------------------------------
 */

static void check_strange(qn_context *context, test_field *field, test_random *random,
                          int64_t *odd) {
    const int64_t count = field->size[0] * field->size[1] * field->size[2];
    int64_t nans = 0, infinities = 0;
    for (int64_t i = 0; i < count; ++i) {
        int64_t dice = test_random_range(random, 0, 11);
        if (dice < 2)
            field->values[i] = (double)NAN, nans += 1;
        else if (dice < 4)
            field->values[i] = dice == 2 ? HUGE_VAL : -HUGE_VAL, infinities += 1;
    }
    test_field_prepare(field);
    qn_surface_report report;
    qn_mesh *mesh = test_field_surface(context, field, &report);
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    if (report.nan_samples != nans || report.infinite_samples != infinities)
        fail_msg("%s, %s: %lld NaN and %lld infinite samples reported, there are %lld and %lld",
                 field->name, field->open ? "open" : "closed", (long long)report.nan_samples,
                 (long long)report.infinite_samples, (long long)nans, (long long)infinities);
    assert_true(test_mesh_is_finite(mesh));
    if (!field->open)
        assert_int_equal(test_mesh_edges(mesh).unbalanced, 0);
    *odd += nans + infinities;
    test_match_free(&match);
    test_reference_free(&reference);
    qn_mesh_destroy(mesh);
}

static void strange_samples_are_counted_and_closed(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    qn_context *context = test_context(2);
    int64_t odd = 0;
    for (int64_t i = 0; i < test_count(100, 600); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 16);
        check_strange(context, &field, &random, &odd);
        test_field_free(&field);
    }
    printf("%lld samples were no finite numbers\n", (long long)odd);
    assert_true(odd > 1000);
    test_context_end(context);
}

/* Nothing finite at all, and values near the end of what doubles hold. */
static void extremes_stay_finite(void **state) {
    (void)state;
    static const double extremes[][2] = {
        {HUGE_VAL, -HUGE_VAL},   {(double)NAN, HUGE_VAL}, {1e308, -1e308},    {1.5e308, -1.7e308},
        {0x1p-1074, -0x1p-1074}, {1e300, -1e-300},        {HUGE_VAL, -1e-320}};
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (size_t e = 0; e < sizeof extremes / sizeof extremes[0]; ++e)
        for (int round = 0; round < 20; ++round) {
            test_field field = test_field_make(5, 4, 6);
            snprintf(field.name, sizeof field.name, "%g and %g", extremes[e][0], extremes[e][1]);
            for (int i = 0; i < 5 * 4 * 6; ++i)
                field.values[i] = extremes[e][test_random_bits(&random) & 1];
            field.inside = round & 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
            test_field_prepare(&field);
            qn_mesh *mesh = test_field_surface(context, &field, NULL);
            if (!test_mesh_is_finite(mesh))
                fail_msg("%s: vertices that are not finite", field.name);
            assert_int_equal(test_mesh_edges(mesh).unbalanced, 0);
            qn_mesh_destroy(mesh);
            test_field_free(&field);
        }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(failed_allocations_leave_nothing),
        cmocka_unit_test(cancelling_leaves_nothing),
        cmocka_unit_test(strange_samples_are_counted_and_closed),
        cmocka_unit_test(extremes_stay_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
