// SPDX-License-Identifier: MIT
/* The face rule: its sign is the true one, whatever the order in which the corners are named. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "face/face_hd.h"

static uint64_t next_random(uint64_t *state) {
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static uint64_t seed(void) {
    const char *text = getenv("QUOIN_SEED");
    uint64_t value = text ? strtoull(text, NULL, 10) : 20261122;
    printf("QUOIN_SEED=%llu\n", (unsigned long long)value);
    return value;
}

/* Whole numbers below 2^53: their products are exact in 128 bits. */
static int true_sign(int64_t a, int64_t c, int64_t b, int64_t d) {
    __int128 difference = (__int128)a * c - (__int128)b * d;
    return difference > 0 ? 1 : difference < 0 ? -1 : 0;
}

static void check_orders(int64_t a, int64_t c, int64_t b, int64_t d) {
    const int expected = true_sign(a, c, b, d);
    const double x = (double)a, z = (double)c, y = (double)b, w = (double)d;
    assert_int_equal(qni_determinant_sign(x, z, y, w), expected);
    assert_int_equal(qni_determinant_sign(z, x, y, w), expected);
    assert_int_equal(qni_determinant_sign(x, z, w, y), expected);
    assert_int_equal(qni_determinant_sign(y, w, x, z), -expected);
    /* Scaling by powers of two changes nothing. */
    assert_int_equal(
        qni_determinant_sign(ldexp(x, -200), ldexp(z, -60), ldexp(y, -130), ldexp(w, -130)),
        expected);
}

/* Products that agree in their first 53 bits and more: neighbours of a square, and of one another.
 */
static void close_products_are_told_apart(void **state) {
    (void)state;
    uint64_t random = seed();
    int ties = 0;
    for (int n = 0; n < 2000000; ++n) {
        const int bits = 2 + (int)(next_random(&random) % 51);
        const int64_t a = 1 + (int64_t)(next_random(&random) >> (64 - bits));
        const int64_t step = (int64_t)(next_random(&random) % 5) - 2;
        int64_t b = a + step, c = a + (int64_t)(next_random(&random) % 5);
        int64_t d = c - step + (int64_t)(next_random(&random) % 3) - 1;
        if (n % 4 == 0) {
            b = c;
            d = a;
        }
        ties += true_sign(a, c, b, d) == 0;
        check_orders(a, c, b, d);
    }
    assert_true(ties > 400000);
}

static void random_products_have_their_sign(void **state) {
    (void)state;
    uint64_t random = seed();
    for (int n = 0; n < 1000000; ++n) {
        int64_t v[4];
        for (int i = 0; i < 4; ++i)
            v[i] = (int64_t)(next_random(&random) >> (12 + next_random(&random) % 50));
        check_orders(v[0], v[1], -v[2], -v[3]);
    }
}

static void ties_join_the_upper_corners(void **state) {
    (void)state;
    assert_true(qni_face_joins_above(qni_face_saddle_sign(1, 1, -1, -1)));
    assert_true(qni_face_joins_above(qni_face_saddle_sign(0, 5, -0.0, -3)));
    assert_false(qni_face_joins_above(qni_face_saddle_sign(0, 5, -1e-30, -3)));
    assert_true(qni_face_joins_above(qni_face_saddle_sign(0.1, 0.3, -0.1, -0.3)));
    assert_false(qni_face_joins_above(qni_face_saddle_sign(0.1, 0.3, -0.1, nextafter(-0.3, -1))));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(close_products_are_told_apart),
        cmocka_unit_test(random_products_have_their_sign),
        cmocka_unit_test(ties_join_the_upper_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
