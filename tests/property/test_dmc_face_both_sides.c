// SPDX-License-Identifier: MIT
/* Two cells and the face between them: whatever the eight other samples are, both cells decide the
 * shared face alike and as exact arithmetic does. All pairs of sign patterns that fit together, and
 * volumes in which nearly every face is ambiguous, with adversarial values. */
#include "lib/mesh_measure.h"
#include "lib/random_volume.h"
#include "lib/reference_match.h"

#include <math.h>

static int64_t check_field(qn_context *context, const test_field *field) {
    qn_surface_report report;
    qn_mesh *mesh = test_field_surface(context, field, &report);
    test_reference reference = test_reference_make(field);
    test_match match = test_match_mesh(field, &reference, mesh);
    test_match_report(field, &reference, &report);
    int64_t faces = reference.ambiguous_inner_faces;
    test_match_free(&match);
    test_reference_free(&reference);
    qn_mesh_destroy(mesh);
    return faces;
}

/* Gives the samples the signs of a pattern, keeping their distance from the iso-value; a sample on
 * it counts as above. */
static void set_sign(test_field *field, int64_t at, bool above) {
    double d = field->values[at] - field->iso;
    if (d == 0 && !above)
        d = -1;
    field->values[at] = field->iso + ((d < 0) == above ? -d : d);
}

/* The pair of cells along each axis: 3 x 2 x 2 samples have 12 signs. */
static void all_pairs_of_cells_agree(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    int64_t faces = 0, volumes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        test_field field = test_field_make(axis == 0 ? 3 : 2, axis == 1 ? 3 : 2, axis == 2 ? 3 : 2);
        for (int pattern = 0; pattern < 4096; ++pattern)
            for (int64_t round = 0; round < test_count(2, 3 * TEST_KIND_COUNT); ++round) {
                test_kind kind = (test_kind)((pattern + round + axis) % TEST_KIND_COUNT);
                test_random_fill(&field, &random, kind);
                for (int s = 0; s < 12; ++s)
                    set_sign(&field, s, pattern >> s & 1);
                field.open = round & 1;
                field.inside = (pattern ^ round >> 1) & 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
                test_field_prepare(&field);
                faces += check_field(context, &field);
                volumes += 1;
            }
        test_field_free(&field);
    }
    printf("%lld pairs of cells, %lld ambiguous faces between cells\n", (long long)volumes,
           (long long)faces);
    test_context_end(context);
}

/* Checkerboards make every face ambiguous: n^3 of them 3 n^3 at a time. */
static void millions_of_adversarial_faces_agree(void **state) {
    (void)state;
    static const test_kind kinds[] = {TEST_SMALL_INTEGERS, TEST_SYMMETRIC, TEST_THOUSAND,
                                      TEST_HEAVY_TAILED,   TEST_GAUSSIAN,  TEST_NEAR_TIES};
    test_random random = {test_seed()};
    qn_context *context = test_context(2);
    int64_t faces = 0;
    const int64_t wanted = test_count(600000, 8000000);
    for (int round = 0; faces < wanted; ++round) {
        test_field field = test_field_make(31, 30, 29);
        test_random_fill(&field, &random, kinds[round % 6]);
        for (int64_t i = 0; i < 31 * 30 * 29; ++i) /* nearly all: a few faces plain among them */
            if (test_random_range(&random, 0, 29) > 0)
                set_sign(&field, i, (i % 31 + i / 31 % 30 + i / 31 / 30) & 1);
        field.open = true;
        field.inside = round & 1 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
        test_field_prepare(&field);
        faces += check_field(context, &field);
        test_field_free(&field);
    }
    printf("%lld ambiguous faces between two cells, no disagreement\n", (long long)faces);
    test_context_end(context);
}

/* Where products of doubles underflow or overflow, exactness ends; agreement must not. */
static void faces_of_extreme_size_agree(void **state) {
    (void)state;
    static const int exponents[] = {-1070, -1000, -540, -537, -530, -525, -515,
                                    -500,  -450,  450,  500,  512,  1000, 1020};
    static const test_kind kinds[] = {TEST_NEAR_TIES, TEST_SMALL_INTEGERS, TEST_GAUSSIAN,
                                      TEST_SYMMETRIC};
    test_random random = {test_seed()};
    qn_context *context = test_context(1);
    for (size_t e = 0; e < sizeof exponents / sizeof exponents[0]; ++e)
        for (int64_t round = 0; round < test_count(8, 80); ++round) {
            test_field field = test_field_make(9, 8, 10);
            test_random_fill(&field, &random, kinds[round % 4]);
            for (int64_t i = 0; i < 9 * 8 * 10; ++i)
                field.values[i] = ldexp(field.values[i] - field.iso, exponents[e]);
            field.iso = 0;
            snprintf(field.name, sizeof field.name, "%s times 2^%d, round %d",
                     test_kind_name(kinds[round % 4]), exponents[e], (int)round);
            field.inside = round & 4 ? QN_INSIDE_BELOW : QN_INSIDE_ABOVE;
            test_field_prepare(&field);
            qn_mesh *mesh = test_field_surface(context, &field, NULL);
            if (test_mesh_edges(mesh).unbalanced != 0 || !test_mesh_is_finite(mesh))
                fail_msg("%s: a crack, or a vertex that is not finite", field.name);
            qn_mesh_destroy(mesh);
            if (abs(exponents[e]) < 460)
                check_field(context, &field);
            test_field_free(&field);
        }
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_pairs_of_cells_agree),
        cmocka_unit_test(faces_of_extreme_size_agree),
        cmocka_unit_test(millions_of_adversarial_faces_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
