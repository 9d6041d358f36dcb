// SPDX-License-Identifier: MIT
/* Polygon models for the tests. */
#include "lib/polygon_models.h"

#include <math.h>

static void *grow(void *items, int64_t count, size_t size) {
    if (count & (count - 1))
        return items;
    void *grown = realloc(items, (size_t)(count ? 2 * count : 1) * size);
    assert_non_null(grown);
    return grown;
}

uint32_t test_model_point(test_model *model, double x, double y, double z) {
    model->points = grow(model->points, model->point_count, sizeof *model->points);
    float *point = model->points[model->point_count];
    point[0] = (float)x;
    point[1] = (float)y;
    point[2] = (float)z;
    return (uint32_t)model->point_count++;
}

void test_model_triangle(test_model *model, uint32_t a, uint32_t b, uint32_t c) {
    model->triangles = grow(model->triangles, model->triangle_count, sizeof *model->triangles);
    uint32_t *triangle = model->triangles[model->triangle_count++];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
}

static uint32_t moved_point(test_model *model, const double p[3], const double matrix[3][4]) {
    double q[3] = {p[0], p[1], p[2]};
    for (int k = 0; matrix && k < 3; ++k)
        q[k] = matrix[k][0] * p[0] + matrix[k][1] * p[1] + matrix[k][2] * p[2] + matrix[k][3];
    return test_model_point(model, q[0], q[1], q[2]);
}

void test_model_box(test_model *model, const double low[3], const double high[3],
                    const double matrix[3][4]) {
    static const uint8_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t corner[8];
    for (int n = 0; n < 8; ++n) {
        const double p[3] = {n & 1 ? high[0] : low[0], n & 2 ? high[1] : low[1],
                             n & 4 ? high[2] : low[2]};
        corner[n] = moved_point(model, p, matrix);
    }
    for (int n = 0; n < 6; ++n) {
        const uint8_t *q = quads[n];
        test_model_triangle(model, corner[q[0]], corner[q[1]], corner[q[2]]);
        test_model_triangle(model, corner[q[0]], corner[q[2]], corner[q[3]]);
    }
}

static uint32_t middle(test_model *model, const double centre[3], double radius, uint32_t a,
                       uint32_t b) {
    double p[3], length = 0;
    for (int k = 0; k < 3; ++k) {
        p[k] = 0.5 * ((double)model->points[a][k] + (double)model->points[b][k]) - centre[k];
        length += p[k] * p[k];
    }
    length = sqrt(length);
    float q[3];
    for (int k = 0; k < 3; ++k)
        q[k] = (float)(centre[k] + radius * p[k] / length);
    for (int64_t n = model->point_count - 1; n >= 0; --n)
        if (memcmp(model->points[n], q, sizeof q) == 0)
            return (uint32_t)n;
    return test_model_point(model, (double)q[0], (double)q[1], (double)q[2]);
}

void test_model_ball(test_model *model, const double centre[3], double radius, int steps) {
    uint32_t corner[6];
    for (int n = 0; n < 6; ++n) {
        double p[3] = {centre[0], centre[1], centre[2]};
        p[n / 2] += n % 2 ? radius : -radius;
        corner[n] = test_model_point(model, p[0], p[1], p[2]);
    }
    int64_t first = model->triangle_count;
    for (int n = 0; n < 8; ++n) {
        uint32_t a = corner[n & 1], b = corner[2 + (n >> 1 & 1)], c = corner[4 + (n >> 2 & 1)];
        bool even = ((n & 1) + (n >> 1 & 1) + (n >> 2 & 1)) % 2 == 1;
        test_model_triangle(model, a, even ? b : c, even ? c : b);
    }
    for (int step = 0; step < steps; ++step) {
        int64_t end = model->triangle_count;
        for (int64_t n = first; n < end; ++n) {
            uint32_t a = model->triangles[n][0], b = model->triangles[n][1],
                     c = model->triangles[n][2];
            uint32_t ab = middle(model, centre, radius, a, b),
                     bc = middle(model, centre, radius, b, c),
                     ca = middle(model, centre, radius, c, a);
            model->triangles[n][1] = ab;
            model->triangles[n][2] = ca;
            test_model_triangle(model, ab, b, bc);
            test_model_triangle(model, ca, bc, c);
            test_model_triangle(model, ab, bc, ca);
        }
    }
}

void test_model_turn_round(test_model *model, int64_t first_triangle) {
    for (int64_t n = first_triangle; n < model->triangle_count; ++n) {
        uint32_t swap = model->triangles[n][1];
        model->triangles[n][1] = model->triangles[n][2];
        model->triangles[n][2] = swap;
    }
}

void test_model_free(test_model *model) {
    free(model->points);
    free(model->triangles);
    memset(model, 0, sizeof *model);
}

qn_mesh *test_model_mesh(qn_context *context, const test_model *model) {
    qn_mesh_view view;
    memset(&view, 0, sizeof view);
    view.vertex_count = model->point_count;
    view.triangle_count = model->triangle_count;
    view.positions = model->points[0];
    view.triangles = model->triangles[0];
    qn_mesh *mesh = NULL;
    assert_int_equal(qn_mesh_create(context, &view, &mesh, NULL), QN_OK);
    return mesh;
}

void test_random_matrix(test_random *random, double spread, double matrix[3][4]) {
    double q[4], length = 0;
    for (int k = 0; k < 4; ++k) {
        q[k] = test_random_gaussian(random);
        length += q[k] * q[k];
    }
    length = sqrt(length);
    double w = q[0] / length, x = q[1] / length, y = q[2] / length, z = q[3] / length;
    const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                               {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                               {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            matrix[i][k] = turn[i][k];
        matrix[i][3] = (2 * test_random_unit(random) - 1) * spread;
    }
}

qn_solid *test_model_solid(qn_context *context, test_model *model, int32_t owner) {
    qn_mesh *mesh = test_model_mesh(context, model);
    test_model_free(model);
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    options.owner = owner;
    options.one_owner = true;
    qn_solid *solid;
    qn_solid_mesh_report report;
    assert_int_equal(qn_solid_from_mesh(context, mesh, &options, &solid, &report, NULL), QN_OK);
    assert_true(report.closed);
    qn_mesh_destroy(mesh);
    return solid;
}
