// SPDX-License-Identifier: MIT
/* The tunnels of single cells: found exactly where brute force finds that two polygons bound one
 * piece of surface. */
#include "lib/random_volume.h"
#include "lib/refined_cell.h"
#include "dmc/tunnel_hd.h"

typedef struct tally {
    int64_t cells, tunnels, by_polygons[5], late, ties;
} tally;

static int case_of(const double d[8]) {
    int bits = 0;
    for (int c = 0; c < 8; ++c)
        bits |= (d[c] >= 0) << c;
    return bits;
}

static void fail_cell(const char *what, const double d[8], const test_refined *refined,
                      int polygons) {
    char values[400] = "";
    for (int c = 0; c < 8; ++c)
        snprintf(values + strlen(values), sizeof values - strlen(values), " %.17g", d[c]);
    fail_msg("%s: %d polygons, by brute force %d pieces, Euler %d; corners%s", what, polygons,
             refined->surfaces, refined->euler, values);
}

/* Finer and finer, odd and even, until the boxes see the tunnel. Where the saddle is at the
 * iso-value, or too near to it for any box, it is looked for a little beside the iso-value, on the
 * side to which a tie counts. */
static bool tunnel_shows(const double d[8], int polygons, int side, tally *t) {
    static const int cuts[] = {16, 27, 41, 64, 97, 160};
    for (size_t n = 0; n < sizeof cuts / sizeof cuts[0]; ++n) {
        const test_refined refined = test_refine_cell(d, cuts[n]);
        t->late += n == 3;
        if (refined.surfaces == polygons - 1)
            return true;
    }
    double moved[8], size = 0;
    for (int c = 0; c < 8; ++c)
        size = d[c] * d[c] > size * size ? (d[c] < 0 ? -d[c] : d[c]) : size;
    for (int c = 0; c < 8; ++c)
        moved[c] = d[c] + (side ? 1 : -1) * 1e-3 * size;
    ++t->ties;
    return test_refine_cell(moved, 64).surfaces == polygons - 1 &&
           test_refine_cell(moved, 97).surfaces == polygons - 1;
}

static void compare_cell(const double d[8], int n, tally *t) {
    const int case_index = case_of(d);
    if (case_index == 0 || case_index == 255)
        return;
    const int entry = qni_cell_resolve(d, case_index).entry, polygons = qni_entry_polygons(entry);
    qni_tunnel tunnel;
    const int found = qni_find_tunnel(d, entry, &tunnel);
    test_refined refined = test_refine_cell(d, n);
    ++t->cells;
    ++t->by_polygons[polygons];
    t->tunnels += found;
    if (refined.surfaces < polygons - 1)
        fail_cell("more than two polygons joined", d, &refined, polygons);
    if (refined.surfaces < polygons && !found)
        fail_cell("tunnel missed", d, &refined, polygons);
    if (refined.surfaces == polygons && found && !tunnel_shows(d, polygons, tunnel.side, t))
        fail_cell("tunnel made up", d, &refined, polygons);
    /* Discs, and one ring: no handles. */
    if (refined.euler != polygons - 2 * (polygons - refined.surfaces))
        fail_cell("neither discs nor rings", d, &refined, polygons);
}

static void fill(double d[8], test_random *random, test_kind kind, int signs) {
    for (int c = 0; c < 8; ++c) {
        d[c] = test_random_sample(random, kind);
        if (signs >= 0 && (d[c] >= 0) != (signs >> c & 1))
            d[c] = d[c] == 0 ? -1 : -d[c];
    }
}

static void report(const char *name, const tally *t) {
    printf("%s: %lld cells (%lld, %lld, %lld, %lld with 1 to 4 polygons), %lld tunnels; %lld seen "
           "only beyond 41 boxes, %lld "
           "only beside the iso-value\n",
           name, (long long)t->cells, (long long)t->by_polygons[1], (long long)t->by_polygons[2],
           (long long)t->by_polygons[3], (long long)t->by_polygons[4], (long long)t->tunnels,
           (long long)t->late, (long long)t->ties);
}

static void as_by_brute_force(void **state) {
    (void)state;
    const test_kind kinds[] = {TEST_GAUSSIAN, TEST_HEAVY_TAILED, TEST_SMALL_INTEGERS,
                               TEST_SYMMETRIC, TEST_NEAR_TIES};
    const uint64_t seed = test_seed();
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k) {
        test_random random = {seed + k};
        tally t = {0};
        for (int64_t i = 0; i < test_count(2000, 20000); ++i) {
            double d[8];
            fill(d, &random, kinds[k], -1);
            compare_cell(d, 8, &t);
        }
        report(test_kind_name(kinds[k]), &t);
    }
}

/* Cases 3, 4, 6, 7, 10, 12, 13 of Marching Cubes, upright and turned over. */
static void cases_with_several_polygons(void **state) {
    (void)state;
    static const int signs[] = {0x09, 0x81, 0x83, 0x16, 0xc3, 0x1e, 0x69};
    static const char *const names[] = {"case 3",  "case 4",  "case 6", "case 7",
                                        "case 10", "case 12", "case 13"};
    const uint64_t seed = test_seed();
    for (size_t k = 0; k < sizeof signs / sizeof signs[0]; ++k) {
        tally t = {0};
        for (int64_t i = 0; i < test_count(1500, 15000); ++i) {
            static const test_kind kinds[] = {TEST_GAUSSIAN, TEST_HEAVY_TAILED,
                                              TEST_SMALL_INTEGERS};
            test_random random = {seed + 7919 * (uint64_t)i + k};
            double d[8];
            fill(d, &random, kinds[i % 3], i & 1 ? signs[k] : 255 - signs[k]);
            compare_cell(d, i % 5 == 0 ? 24 : 9, &t);
        }
        report(names[k], &t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_by_brute_force),
        cmocka_unit_test(cases_with_several_polygons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
