// SPDX-License-Identifier: MIT
/* Closed polygon models never leak: whatever way one comes to a point, it is on the same side, and
 * crossings along lattice lines alternate and agree with it. Soups of turned boxes and flat or
 * twisted tetrahedra, cubes turned by tiny angles, corners exactly on lattice lines, faces that
 * coincide. Boxes along the axes are known point by point. */
#include "lib/polygon_models.h"
#include "solid/solid.h"

#include <math.h>

enum { POINTS = 6, PARTS = 5 };

typedef struct known_box {
    double low[3], high[3];
} known_box;

typedef struct soup {
    test_model model;
    known_box boxes[PARTS];
    int box_count;      /* 0: not known point by point */
    double first, step; /* of the lattice, along all axes */
} soup;

static double small_whole(test_random *random) {
    return (double)test_random_range(random, 0, 4);
}

/* Boxes with whole corners: faces, edges and corners coincide with each other and with the lattice.
 */
static void make_whole_boxes(test_random *random, soup *out) {
    out->box_count = 1 + (int)test_random_range(random, 0, PARTS - 1);
    for (int n = 0; n < out->box_count; ++n) {
        known_box *box = &out->boxes[n];
        for (int k = 0; k < 3; ++k) {
            box->low[k] = small_whole(random);
            box->high[k] = box->low[k] + 1 + (double)test_random_range(random, 0, 2);
        }
        test_model_box(&out->model, box->low, box->high, NULL);
    }
}

static void make_turned_boxes(test_random *random, soup *out) {
    int count = 1 + (int)test_random_range(random, 0, PARTS - 1);
    for (int n = 0; n < count; ++n) {
        double low[3], high[3], matrix[3][4];
        test_random_matrix(random, 3, matrix);
        for (int k = 0; k < 3; ++k) {
            low[k] = -0.2 - 1.5 * test_random_unit(random);
            high[k] = 0.2 + 1.5 * test_random_unit(random);
            matrix[k][3] += 3;
        }
        int64_t first = out->model.triangle_count;
        test_model_box(&out->model, low, high, (const double(*)[4])matrix);
        if (test_random_range(random, 0, 3) == 0)
            test_model_turn_round(&out->model, first);
    }
}

/* A cube on the lattice, turned about an axis by 10^-1 to 10^-16. */
static void make_tilted_cube(test_random *random, soup *out) {
    double angle = pow(10, -1 - 15 * test_random_unit(random)), c = cos(angle), s = sin(angle);
    int u = (int)test_random_range(random, 0, 2), v = (u + 1) % 3, w = (u + 2) % 3;
    double matrix[3][4] = {{0}};
    matrix[u][u] = matrix[v][v] = c;
    matrix[u][v] = -s;
    matrix[v][u] = s;
    matrix[w][w] = 1;
    static const double low[3] = {1, 1, 1}, high[3] = {4, 4, 4};
    test_model_box(&out->model, low, high, (const double(*)[4])matrix);
}

/* Tetrahedra with whole corners, some of them flat, some inside out, sharing what they happen to.
 */
static void make_tetrahedra(test_random *random, soup *out) {
    int count = 1 + (int)test_random_range(random, 0, 2 * PARTS);
    for (int n = 0; n < count; ++n) {
        uint32_t p[4];
        for (int i = 0; i < 4; ++i)
            p[i] = test_model_point(&out->model, small_whole(random), small_whole(random),
                                    small_whole(random));
        test_model_triangle(&out->model, p[0], p[2], p[1]);
        test_model_triangle(&out->model, p[0], p[1], p[3]);
        test_model_triangle(&out->model, p[1], p[2], p[3]);
        test_model_triangle(&out->model, p[2], p[0], p[3]);
    }
}

static void lattice_point(const soup *s, int n, double p[3]) {
    p[0] = s->first + s->step * (n % POINTS);
    p[1] = s->first + s->step * (n / POINTS % POINTS);
    p[2] = s->first + s->step * (n / POINTS / POINTS);
}

/* By winding: in any box. Points stand for themselves moved by (e, e^2, e^3). */
static bool is_known_inside(const soup *s, const double p[3]) {
    bool inside = false;
    for (int n = 0; n < s->box_count; ++n) {
        bool here = true;
        for (int k = 0; k < 3; ++k)
            here = here && p[k] >= s->boxes[n].low[k] && p[k] < s->boxes[n].high[k];
        inside = inside || here;
    }
    return inside;
}

static int64_t check_segment(const qn_solid *solid, const double a[3], const double b[3],
                             bool start, bool end) {
    qni_crossing found[64];
    int32_t count = -1;
    assert_int_equal(solid->ops->crossings(solid, a, b, 64, found, &count), QN_OK);
    int64_t stray = count % 2 != (start != end);
    bool inside = start;
    double before = 0;
    for (int32_t n = 0; n < count; ++n) {
        stray += found[n].enters == inside || found[n].at < before || found[n].at > 1;
        inside = found[n].enters;
        before = found[n].at;
    }
    return stray + (inside != end);
}

static int64_t check_model(const soup *s, const qn_solid *solid, bool winding) {
    enum { ALL = POINTS * POINTS * POINTS };
    double points[ALL][3];
    bool inside[ALL], again[ALL];
    int64_t stray = 0;
    for (int n = 0; n < ALL; ++n)
        lattice_point(s, n, points[n]);
    assert_int_equal(solid->ops->inside(solid, ALL, (const double(*)[3])points, inside), QN_OK);
    const qni_box box = {{points[0][0], points[0][1], points[0][2]},
                         {points[ALL - 1][0], points[ALL - 1][1], points[ALL - 1][2]}};
    qn_solid *local;
    assert_int_equal(solid->ops->restrict_to(solid, &box, &local), QN_OK);
    assert_int_equal(local->ops->inside(local, ALL, (const double(*)[3])points, again), QN_OK);
    for (int n = 0; n < ALL; ++n) {
        static const int strides[3] = {1, POINTS, POINTS * POINTS};
        stray += inside[n] != again[n];
        stray += winding && s->box_count && inside[n] != is_known_inside(s, points[n]);
        for (int k = 0; k < 3; ++k)
            if (n / strides[k] % POINTS + 1 < POINTS) {
                int m = n + strides[k];
                stray += check_segment(solid, points[n], points[m], inside[n], inside[m]);
                stray += check_segment(local, points[n], points[m], inside[n], inside[m]);
            }
        int far = (n * 97 + 31) % ALL; /* across the lattice, through corners and edges */
        stray += check_segment(solid, points[n], points[far], inside[n], inside[far]);
    }
    qn_solid_destroy(local);
    return stray;
}

static void make(test_random *random, int64_t round, soup *out) {
    static void (*const kinds[])(test_random *, soup *) = {make_whole_boxes, make_turned_boxes,
                                                           make_tilted_cube, make_tetrahedra};
    memset(out, 0, sizeof *out);
    out->first = -1;
    out->step = 1.5;
    if (round % 3 == 1)
        out->first = 0, out->step = 1;
    if (round % 3 == 2)
        out->first = 0.5, out->step = 0.75;
    kinds[round % 4](random, out);
}

static void closed_models_never_leak(void **state) {
    (void)state;
    qn_context *context = test_context(1);
    uint64_t seed = test_seed();
    int64_t rounds = test_count(400, 10000), stray = 0;
    for (int64_t round = 0; round < rounds; ++round) {
        test_random random = {seed + (uint64_t)round};
        soup s;
        make(&random, round, &s);
        qn_mesh *mesh = test_model_mesh(context, &s.model);
        for (int sign = QN_MESH_SIGN_PARITY; sign <= QN_MESH_SIGN_WINDING; ++sign) {
            qn_solid_mesh_options options;
            qn_solid_mesh_options_init(&options);
            options.sign = (qn_mesh_sign)sign;
            qn_solid *solid;
            qn_status status = qn_solid_from_mesh(context, mesh, &options, &solid, NULL, NULL);
            if (status == QN_ERROR_INPUT) /* all tetrahedra repeat a corner */
                continue;
            assert_int_equal(status, QN_OK);
            int64_t here = check_model(&s, solid, sign == QN_MESH_SIGN_WINDING);
            if (here)
                print_error("model %lld, sign %d: %lld stray\n", (long long)round, sign,
                            (long long)here);
            stray += here;
            qn_solid_destroy(solid);
        }
        qn_mesh_destroy(mesh);
        test_model_free(&s.model);
    }
    printf("%lld models, %lld stray crossings\n", (long long)rounds, (long long)stray);
    assert_int_equal(stray, 0);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(closed_models_never_leak)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
