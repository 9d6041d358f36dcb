// SPDX-License-Identifier: MIT
/* The vertex kernels: every instruction set this machine has gives the same bits as plain C. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <cmocka.h>
#include <string.h>

#include "dmc/dmc.h"

static uint64_t next_random(uint64_t *state) {
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static double tile[QNI_TILE][QNI_TILE][QNI_TILE];

static void fill(uint64_t *random, qni_point_batch *batch) {
    for (int n = 0; n < QNI_TILE_SAMPLES; ++n)
        (&tile[0][0][0])[n] = (double)(int64_t)(next_random(random) >> 40) / 1000 - 8000;
    memset(batch, 0, sizeof *batch);
    for (int l = 0; l < QNI_LANES; ++l) {
        const int x = (int)(next_random(random) % 8), y = (int)(next_random(random) % 8),
                  z = (int)(next_random(random) % 8);
        batch->corner[l] = &tile[z + 1][y + 1][x + 1];
        batch->cell[0][l] = x;
        batch->cell[1][l] = y;
        batch->cell[2][l] = z;
    }
}

static const qni_frame frame = {
    {{0.7, 0.1, -0.2, 31}, {0.05, 1.3, 0.2, -17}, {0.3, -0.4, 2.1, 0.125}},
    {{1, 0.2, 0.1}, {-0.3, 0.9, 0.2}, {0.1, 0.2, -1.1}},
};

/* Only lanes with surface mean anything: the others divide by zero crossings. */
static bool lane_has_surface(const qni_point_batch *batch, int l) {
    static const int corner[8] = {1, 2, 5, 6, 9, 10, 13, 14};
    int above = 0;
    for (int c = 0; c < 8; ++c)
        above += batch->stencil[corner[c]][l] >= 0;
    return above > 0 && above < 8;
}

static void compare(const qni_point_batch *a, const qni_point_batch *b, int64_t *lanes) {
    assert_memory_equal(a->stencil, b->stencil, sizeof a->stencil);
    for (int l = 0; l < QNI_LANES; ++l) {
        if (!lane_has_surface(a, l))
            continue;
        ++*lanes;
        assert_int_equal(a->apart[l], b->apart[l]);
        for (int n = 0; n < 3; ++n) {
            assert_memory_equal(&a->local[n][l], &b->local[n][l], sizeof(double));
            assert_memory_equal(&a->position[n][l], &b->position[n][l], sizeof(float));
            assert_memory_equal(&a->normal[n][l], &b->normal[n][l], sizeof(float));
        }
    }
}

static void kernels_agree_to_the_bit(void **state) {
    (void)state;
    uint64_t random = 5;
    int64_t lanes = 0;
    for (int round = 0; round < 20000; ++round) {
        qni_point_batch plain, other;
        fill(&random, &plain);
        other = plain;
        qni_kernels_at(0)->point(&plain, &frame);
        for (int n = 1; qni_kernels_at(n); ++n) {
            qni_kernels_at(n)->point(&other, &frame);
            compare(&plain, &other, &lanes);
        }
    }
    if (!qni_kernels_at(1)) {
        printf("skipped: this machine has plain kernels only\n");
        skip();
    }
    for (int n = 1; qni_kernels_at(n); ++n)
        printf("compared %s, ", qni_kernels_at(n)->name);
    printf("%lld lanes\n", (long long)lanes);
    assert_true(lanes > 100000);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(kernels_agree_to_the_bit)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
