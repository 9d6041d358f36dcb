// SPDX-License-Identifier: MIT
/* Curvature at the vertices of sampled spheres and tori against the closed forms. */
#include "lib/analytic.h"

#include <math.h>

static const double sphere_radius = 0.73, ring_radius = 0.61,
                    tube_radius = 0.22; /* of tests/lib/analytic.c */

typedef struct curvatures {
    double mean, gaussian;
} curvatures;

/* At a place in the formula's coordinates; lengths there. */
static curvatures of_sphere(const double p[3]) {
    (void)p;
    curvatures c = {1 / sphere_radius, 1 / (sphere_radius * sphere_radius)};
    return c;
}

static curvatures of_torus(const double p[3]) {
    const double distance = sqrt(p[0] * p[0] + p[1] * p[1]);
    const double outward =
        (distance - ring_radius) / tube_radius; /* the cosine of the angle round the tube */
    const double along = outward / (ring_radius + tube_radius * outward);
    curvatures c = {0.5 * (1 / tube_radius + along), along / tube_radius};
    return c;
}

/* Root mean square and largest error, as shares of 1 / r and 1 / r^2 of the smallest radius. */
typedef struct errors {
    double mean, gaussian, largest_mean, largest_gaussian;
} errors;

static errors measure(const char *name, int64_t n, curvatures (*exact)(const double[3]),
                      double radius, bool normals, bool triangles) {
    qn_context *context = test_context(2);
    void *samples;
    const test_analytic *analytic = test_analytic_find(name);
    qn_volume *volume = test_analytic_volume(context, analytic, n, QN_F32, &samples);
    qn_surface_options options;
    qn_mesh *mesh;
    qn_surface_options_init(&options);
    options.inside = QN_INSIDE_BELOW;
    options.skip_normals = !normals;
    options.triangles = triangles;
    options.simplify = true;
    assert_int_equal(qn_surface(context, volume, &options, &mesh, NULL, NULL), QN_OK);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    float *mean = test_alloc((size_t)view.vertex_count, sizeof *mean);
    float *gaussian = test_alloc((size_t)view.vertex_count, sizeof *gaussian);
    assert_int_equal(qn_mesh_get_curvature(context, mesh, mean, gaussian, NULL), QN_OK);
    const double step = analytic->span / (double)(n - 1);
    errors e = {0, 0, 0, 0};
    for (int64_t v = 0; v < view.vertex_count; ++v) {
        double p[3];
        for (int a = 0; a < 3; ++a)
            p[a] = analytic->first + step * (double)view.positions[3 * v + a];
        const curvatures c = exact(p);
        const double mean_off = fabs((double)mean[v] / step - c.mean) * radius;
        const double gaussian_off =
            fabs((double)gaussian[v] / (step * step) - c.gaussian) * radius * radius;
        e.mean += mean_off * mean_off;
        e.gaussian += gaussian_off * gaussian_off;
        e.largest_mean = fmax(e.largest_mean, mean_off);
        e.largest_gaussian = fmax(e.largest_gaussian, gaussian_off);
    }
    e.mean = sqrt(e.mean / (double)view.vertex_count);
    e.gaussian = sqrt(e.gaussian / (double)view.vertex_count);
    printf("%s %lld%s%s: error of the mean %.4f (largest %.4f), of the Gaussian curvature %.4f "
           "(largest %.4f)\n",
           name, (long long)n, normals ? "" : ", no normals", triangles ? ", triangles" : "",
           e.mean, e.largest_mean, e.gaussian, e.largest_gaussian);
    free(mean);
    free(gaussian);
    qn_mesh_destroy(mesh);
    qn_volume_destroy(volume);
    free(samples);
    test_context_end(context);
    return e;
}

static void spheres_and_tori_are_as_curved_as_their_formulas(void **state) {
    (void)state;
    const errors sphere = measure("sphere", 64, of_sphere, sphere_radius, true, false);
    const errors torus = measure("torus", 64, of_torus, tube_radius, true, false);
    const errors fine = measure("torus", 128, of_torus, tube_radius, true, false);
    const errors split = measure("torus", 64, of_torus, tube_radius, true, true);
    measure("sphere", 64, of_sphere, sphere_radius, false, false);
    assert_true(sphere.mean < 0.01 && sphere.gaussian < 0.02);
    assert_true(torus.mean < 0.05 && torus.gaussian < 0.05);
    assert_true(split.mean < 0.05 && split.gaussian < 0.05);
    assert_true(fine.mean < 0.6 * torus.mean && fine.gaussian < 0.6 * torus.gaussian);
}

/* The sign follows the normals, a plane has none, and what has no faces gets 0. */
static void signs_and_flats(void **state) {
    (void)state;
    static const float positions[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0},
                                          {0, 1, 0}, {2, 0, 0}, {9, 9, 9}};
    static const uint32_t quads[1][4] = {{0, 1, 2, 3}}, triangles[1][3] = {{1, 4, 2}};
    const qn_mesh_view view = {.vertex_count = 6,
                               .quad_count = 1,
                               .triangle_count = 1,
                               .positions = positions[0],
                               .quads = quads[0],
                               .triangles = triangles[0]};
    qn_context *context = test_context(1);
    qn_mesh *mesh;
    float mean[6] = {1, 1, 1, 1, 1, 1}, gaussian[6] = {1, 1, 1, 1, 1, 1};
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    assert_int_equal(qn_mesh_get_curvature(context, mesh, mean, gaussian, NULL), QN_OK);
    for (int v = 0; v < 6; ++v)
        assert_true(mean[v] == 0 && gaussian[v] == 0);
    assert_int_equal(qn_mesh_get_curvature(context, mesh, NULL, NULL, NULL), QN_OK);
    qn_mesh_destroy(mesh);
    test_context_end(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_and_tori_are_as_curved_as_their_formulas),
        cmocka_unit_test(signs_and_flats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
