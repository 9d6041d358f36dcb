// SPDX-License-Identifier: MIT
/* Polygon models as CAD programs write them, remeshed: their creases come out unbroken. Made here:
 * rings turned on a lathe, whose creases are rims of short facets; prisms with random outlines;
 * blocks with a groove that runs out at both ends; fans of facets about a vertex. As they are and
 * turned at random. */
#include "lib/crease_share.h"

#include <math.h>

enum { MOST_OUTLINE = 16 };

/* All points go where the matrix takes them. */
typedef struct workshop {
    test_random *random;
    test_model model;
    double matrix[3][4];
} workshop;

static double between(workshop *shop, double low, double high) {
    return low + (high - low) * test_random_unit(shop->random);
}

static uint32_t place(workshop *shop, double x, double y, double z) {
    double q[3];
    for (int k = 0; k < 3; ++k)
        q[k] = shop->matrix[k][0] * x + shop->matrix[k][1] * y + shop->matrix[k][2] * z +
               shop->matrix[k][3];
    return test_model_point(&shop->model, q[0], q[1], q[2]);
}

static void quad(workshop *shop, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    test_model_triangle(&shop->model, a, b, c);
    test_model_triangle(&shop->model, a, c, d);
}

/* A ring with steps, as a lathe makes it, of so many facets. */
static void make_ring(workshop *shop) {
    enum { CORNERS = 6 };
    const int facets = (int)test_random_range(shop->random, 24, 40);
    const double bore = between(shop, 0.25, 0.4), hub = bore + between(shop, 0.15, 0.25),
                 rim = hub + between(shop, 0.2, 0.3), low = between(shop, -0.35, -0.25),
                 step = between(shop, -0.1, 0.1), high = between(shop, 0.25, 0.35);
    const double profile[CORNERS][2] = {{bore, low}, {rim, low},  {rim, step},
                                        {hub, step}, {hub, high}, {bore, high}};
    for (int n = 0; n < facets; ++n) {
        const double angle = 2 * 3.14159265358979323846 * n / facets;
        for (int m = 0; m < CORNERS; ++m)
            place(shop, profile[m][0] * cos(angle), profile[m][0] * sin(angle), profile[m][1]);
    }
    for (int n = 0; n < facets; ++n)
        for (int m = 0; m < CORNERS; ++m) {
            const uint32_t here = (uint32_t)(CORNERS * n),
                           next = (uint32_t)(CORNERS * ((n + 1) % facets)), a = (uint32_t)m,
                           b = (uint32_t)((m + 1) % CORNERS);
            quad(shop, here + a, next + a, next + b, here + b);
        }
}

/* An outline that is star-shaped about the origin, counter-clockwise, drawn out along z. */
static void draw_out(workshop *shop, const double (*outline)[2], int count, double low,
                     double high) {
    uint32_t rings[2][MOST_OUTLINE], middle[2];
    for (int end = 0; end < 2; ++end) {
        const double z = end ? high : low;
        middle[end] = place(shop, 0, 0, z);
        for (int n = 0; n < count; ++n)
            rings[end][n] = place(shop, outline[n][0], outline[n][1], z);
    }
    for (int n = 0; n < count; ++n) {
        const int next = (n + 1) % count;
        quad(shop, rings[0][n], rings[0][next], rings[1][next], rings[1][n]);
        test_model_triangle(&shop->model, middle[1], rings[1][n], rings[1][next]);
        test_model_triangle(&shop->model, middle[0], rings[0][next], rings[0][n]);
    }
}

static void make_prism(workshop *shop) {
    double outline[MOST_OUTLINE][2];
    const int count = (int)test_random_range(shop->random, 3, 7);
    for (int n = 0; n < count; ++n) {
        const double angle = 2 * 3.14159265358979323846 * (n + between(shop, 0, 0.3)) / count;
        const double radius = between(shop, 0.5, 0.9);
        outline[n][0] = radius * cos(angle);
        outline[n][1] = radius * sin(angle);
    }
    draw_out(shop, (const double(*)[2])outline, count, -between(shop, 0.2, 0.8),
             between(shop, 0.2, 0.8));
}

/* Every edge along an axis but those of the groove. */
static void make_grooved(workshop *shop) {
    const double width = between(shop, 0.6, 0.9), top = between(shop, 0.5, 0.8),
                 half = between(shop, 0.1, 0.3), left = between(shop, -0.2, 0.2);
    const double outline[7][2] = {{-width, -0.4},     {width, -0.4},      {width, top},
                                  {left + half, top}, {left, top - half}, {left - half, top},
                                  {-width, top}};
    draw_out(shop, outline, 7, -between(shop, 0.3, 0.8), between(shop, 0.3, 0.8));
}

/* A fan of facets about a vertex: creases run into it, side by side with softer edges, and end. */
static void make_fan(workshop *shop) {
    const int count = (int)test_random_range(shop->random, 6, 10);
    const uint32_t middle[2] = {place(shop, 0, 0, -0.6), place(shop, 0, 0, 0)};
    uint32_t rings[2][MOST_OUTLINE];
    for (int n = 0; n < count; ++n) {
        const double angle = 2 * 3.14159265358979323846 * (n + between(shop, 0, 0.8)) / count,
                     x = 0.7 * cos(angle), y = 0.7 * sin(angle);
        rings[0][n] = place(shop, x, y, -0.6);
        rings[1][n] = place(shop, x, y, between(shop, -0.25, 0.25));
    }
    for (int n = 0; n < count; ++n) {
        const int next = (n + 1) % count;
        quad(shop, rings[0][n], rings[0][next], rings[1][next], rings[1][n]);
        test_model_triangle(&shop->model, middle[1], rings[1][n], rings[1][next]);
        test_model_triangle(&shop->model, middle[0], rings[0][next], rings[0][n]);
    }
}

typedef void make_model(workshop *shop);

static test_crease_share measure(uint64_t seed, int64_t number, make_model *make) {
    test_random random = {seed};
    qn_context *context = test_context(1);
    workshop shop = {&random, {NULL, NULL, 0, 0}, {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    if (number % 3)
        test_random_matrix(&random, 0.1, shop.matrix);
    make(&shop);
    qn_mesh *mesh = test_model_mesh(context, &shop.model), *surface;
    qn_solid *solid;
    qn_solid_surface_options options;
    qn_solid_surface_report report;
    qn_mesh_report checked;
    qn_error error;
    assert_int_equal(qn_solid_from_mesh(context, mesh, NULL, &solid, NULL, NULL), QN_OK);
    qn_solid_surface_options_init(&options);
    options.depth = 5 + (int)(number % 2);
    if (qn_solid_surface(context, solid, &options, &surface, &report, &error) != QN_OK)
        fail_msg("%s", error.message);
    assert_int_equal(qn_mesh_check(context, surface, NULL, &checked, NULL), QN_OK);
    assert_true(checked.closed && checked.manifold && checked.oriented);
    assert_int_equal(checked.self_intersections, 0);
    const test_crease_share share =
        test_measure_creases(&shop.model, 40, surface, report.finest_cell);
    qn_mesh_destroy(surface);
    qn_solid_destroy(solid);
    qn_mesh_destroy(mesh);
    test_model_free(&shop.model);
    test_context_end(context);
    return share;
}

/* One point of `one_of` may be missing; 0: none. */
static void measure_all(const char *name, make_model *make, int64_t count, int64_t one_of) {
    const uint64_t seed = test_seed();
    int64_t missing = 0, points = 0;
    for (int64_t n = 0; n < count; ++n) {
        const test_crease_share share = measure(seed + 1000003 * (uint64_t)n, n, make);
        if (share.missing)
            print_message("%s %lld: %lld of %lld points missing, up to %.2f cells off, at %.6f "
                          "%.6f %.6f\n",
                          name, (long long)n, (long long)share.missing, (long long)share.points,
                          share.farthest, share.where[0], share.where[1], share.where[2]);
        missing += share.missing;
        points += share.points;
    }
    print_message("%s: %lld models, %lld points of creases, %lld missing\n", name, (long long)count,
                  (long long)points, (long long)missing);
    assert_true(one_of ? one_of * missing <= points : missing == 0);
}

static void rings(void **state) {
    (void)state;
    measure_all("ring", make_ring, test_count(18, 300), 0);
}

static void prisms(void **state) {
    (void)state;
    measure_all("prism", make_prism, test_count(36, 600), 0);
}

static void grooved_blocks(void **state) {
    (void)state;
    measure_all("grooved block", make_grooved, test_count(36, 600), 0);
}

/* Where several creases run into a corner within a fraction of a cell, next to a wall, some of the
 * walls' bends go unseen. */
static void fans(void **state) {
    (void)state;
    measure_all("fan", make_fan, test_count(36, 600), 10000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings),
        cmocka_unit_test(prisms),
        cmocka_unit_test(grooved_blocks),
        cmocka_unit_test(fans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
