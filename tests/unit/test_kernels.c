// SPDX-License-Identifier: MIT
/* The vertex kernels: every instruction set this machine has gives the same bits as plain C. Those
 * of packing do what they say. */
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

/* ---- packing --------------------------------------------------------------------------------- */

enum { VERTICES = 150, GONE = 255 };

typedef struct packed {
    uint8_t marks[VERTICES];
    float points[3 * VERTICES];
    uint32_t renumber[VERTICES];
} packed;

/* A vertex that is gone names one before it that stays, or itself. */
static void fill_packed(uint64_t *random, packed *p) {
    const uint64_t rare = 1 + next_random(random) % 20;
    for (uint32_t v = 0; v < VERTICES; ++v) {
        const uint32_t other = (uint32_t)(next_random(random) % (v + 1));
        p->marks[v] = next_random(random) % rare == 0 ? GONE : (uint8_t)(next_random(random) % 200);
        p->renumber[v] = p->marks[other] == GONE ? v : other;
        for (int a = 0; a < 3; ++a)
            p->points[3 * v + a] = (float)(3 * v + a);
    }
}

/* What lies outside [from, end) is left alone; after the points that stay anything may follow. */
static void check_squeezed(const packed *before, const packed *after, int64_t from, int64_t end) {
    int64_t to = from;
    for (int64_t v = 0; v < VERTICES; ++v) {
        if (v < from || v >= end)
            assert_memory_equal(before->points + 3 * v, after->points + 3 * v, 3 * sizeof(float));
        else if (before->marks[v] != GONE)
            assert_memory_equal(before->points + 3 * v, after->points + 3 * to++,
                                3 * sizeof(float));
    }
}

static void check_numbers(const packed *before, const packed *after, int64_t from, int64_t end,
                          uint32_t first, bool follow) {
    uint32_t next = first;
    for (int64_t v = 0; v < VERTICES; ++v) {
        const uint32_t kept = before->renumber[v];
        if (v < from || v >= end)
            assert_int_equal(after->renumber[v], kept);
        else if (before->marks[v] != GONE)
            assert_int_equal(after->renumber[v], next++);
        else if (!follow)
            assert_int_equal(after->renumber[v], kept);
        else if (before->marks[kept] != GONE)
            assert_int_equal(after->renumber[v], after->renumber[kept]);
    }
}

static void vertices_are_packed(void **state) {
    (void)state;
    uint64_t random = 9;
    for (int round = 0; round < 20000; ++round) {
        packed before, after;
        fill_packed(&random, &before);
        const int64_t from = (int64_t)(next_random(&random) % VERTICES),
                      end =
                          from + (int64_t)(next_random(&random) % (uint64_t)(VERTICES + 1 - from));
        for (int n = 0; qni_kernels_at(n); ++n) {
            const uint32_t first = (uint32_t)(next_random(&random) >> 40);
            const bool follow = ((n + round) & 1) != 0;
            after = before;
            qni_kernels_at(n)->squeeze(after.points, before.marks, from, end);
            qni_kernels_at(n)->number(before.marks, from, end, first, follow, after.renumber);
            check_squeezed(&before, &after, from, end);
            check_numbers(&before, &after, from, end, first, follow);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(kernels_agree_to_the_bit),
                                       cmocka_unit_test(vertices_are_packed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
