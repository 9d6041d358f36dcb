// SPDX-License-Identifier: MIT
/* Putting merged vertices in place: the kernels of every instruction set this machine has give, in
 * all lanes, the bits of project_hd.h. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "dmc/project.h"
#include "dmc/project_hd.h"
#include "lib/support.h"

enum { ROUNDS = 20000 };

static double between(test_random *random, double low, double high) {
    return low + (high - low) * test_random_unit(random);
}

/* ---- meeting --------------------------------------------------------------------------------- */

/* Some pairs have opposite normals, or X where Y is. */
static void fill_meetings(test_random *random, qni_meetings *m, qni_landings *landings) {
    landings->count = QNI_LANDINGS;
    for (int l = 0; l < QNI_LANDINGS; ++l) {
        const bool opposite = test_random_range(random, 0, 9) == 0,
                   together = test_random_range(random, 0, 9) == 0,
                   without = test_random_range(random, 0, 9) == 0;
        for (int k = 0; k < 4; ++k)
            for (int a = 0; a < 3; ++a) {
                m->position[k][a][l] = (float)between(random, -2, 2);
                m->normal[k][a][l] = without ? 0 : (float)between(random, -1, 1);
            }
        for (int a = 0; a < 3; ++a) {
            if (opposite)
                m->normal[1][a][l] = -m->normal[0][a][l];
            if (together)
                m->position[3][a][l] = m->position[2][a][l];
        }
    }
}

static void check_meeting(const qni_meetings *m, int l, bool move, const qni_landings *landings) {
    float position[12], normal[12], to[3], turned[3];
    for (int k = 0; k < 4; ++k)
        for (int a = 0; a < 3; ++a) {
            position[3 * k + a] = m->position[k][a][l];
            normal[3 * k + a] = m->normal[k][a][l];
        }
    qni_middle_of_pair(position, normal, 0, 1, to, turned);
    if (move)
        qni_move_between(position, normal, 2, 3, to, turned);
    for (int a = 0; a < 3; ++a) {
        assert_memory_equal(to + a, &landings->position[a][l], sizeof(float));
        assert_memory_equal(turned + a, &landings->normal[a][l], sizeof(float));
    }
}

static void vertices_meet(void **state) {
    (void)state;
    test_random random = {test_seed()};
    for (int round = 0; round < ROUNDS; ++round) {
        qni_meetings meetings;
        qni_landings landings;
        fill_meetings(&random, &meetings, &landings);
        for (int n = 0; qni_kernels_at(n); ++n)
            for (int move = 0; move < 2; ++move) {
                qni_kernels_at(n)->meet(&meetings, move, &landings);
                for (int l = 0; l < QNI_LANDINGS; ++l)
                    check_meeting(&meetings, l, move, &landings);
            }
    }
}

/* ---- landing --------------------------------------------------------------------------------- */

static const qni_field field = {
    .inside_below = true,
    .cells = {7, 9, 8},
    .world = {{0.7, 0.1, -0.2, 31}, {0.05, 1.3, 0.2, -17}, {0.3, -0.4, 2.1, 0.125}},
};

static void fill_landings(const qni_projector *projector, test_random *random,
                          qni_landings *landings, qni_approach *approach) {
    const double(*m)[4] = (const double(*)[4])projector->field->world;
    landings->count = QNI_LANDINGS;
    for (int l = 0; l < QNI_LANDINGS; ++l) {
        const double x = between(random, -0.5, 7.5), y = between(random, -0.5, 9.5),
                     z = between(random, -0.5, 8.5);
        const bool known = test_random_range(random, 0, 3) > 0;
        for (int r = 0; r < 3; ++r) {
            landings->position[r][l] = (float)(m[r][0] * x + m[r][1] * y + m[r][2] * z + m[r][3]);
            landings->normal[r][l] = known ? (float)between(random, -1, 1) : 0;
        }
        for (int c = 0; c < 8; ++c)
            approach->corner[c][l] =
                (double)test_random_range(random, -4, 4) + (l & 1 ? 0 : between(random, 0, 1));
    }
}

/* The first axis' line within the cell; 0 where it does not meet the surface in the right sense. */
static bool land(const qni_approach *approach, int l, double at[3]) {
    double slope[3], local[3], d[8], end[2];
    int order[3];
    for (int a = 0; a < 3; ++a) {
        at[a] = approach->at[a][l];
        local[a] = at[a] - approach->cell[a][l];
        slope[a] = approach->slope[a][l];
    }
    for (int c = 0; c < 8; ++c)
        d[c] = approach->corner[c][l];
    if (slope[0] == 0 && slope[1] == 0 && slope[2] == 0)
        qni_slope_of_values(d, local, slope);
    qni_sort_axes(slope, order);
    qni_line_ends(d, order[0], local, end);
    const double zero = qni_crossing_of_line(end, slope[order[0]]);
    const double there = approach->cell[order[0]][l] + zero;
    if (zero < 0 || fabs(there - at[order[0]]) > 1)
        return false;
    at[order[0]] = there;
    return true;
}

static void check_landing(const qni_approach *approach, int l, const qni_landings *landings,
                          int64_t *landed) {
    double at[3];
    const bool lands = land(approach, l, at);
    assert_int_equal(landings->landed[l], lands);
    *landed += lands;
    for (int r = 0; r < 3 && lands; ++r) {
        const double *row = field.world[r];
        const float place = (float)((row[0] * at[0] + row[1] * at[1]) + (row[2] * at[2] + row[3]));
        assert_memory_equal(&place, &landings->position[r][l], sizeof place);
    }
}

static void vertices_land(void **state) {
    (void)state;
    test_random random = {test_seed()};
    qni_projector projector;
    int64_t landed = 0;
    qni_projector_init(&field, &projector);
    for (int round = 0; round < ROUNDS; ++round) {
        qni_landings landings, plain;
        qni_approach approach, first;
        memset(&approach, 0, sizeof approach);
        fill_landings(&projector, &random, &landings, &approach);
        for (int n = 0; qni_kernels_at(n); ++n) {
            qni_approach own = approach;
            plain = landings;
            qni_kernels_at(n)->locate(&projector, &plain, &own);
            if (n == 0)
                first = own;
            assert_memory_equal(&first, &own, sizeof own);
            const qni_approach before = own;
            qni_kernels_at(n)->land(&projector, &own, &plain);
            for (int l = 0; l < QNI_LANDINGS; ++l)
                check_landing(&before, l, &plain, &landed);
        }
    }
    assert_true(landed > ROUNDS);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(vertices_meet),
                                       cmocka_unit_test(vertices_land)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
