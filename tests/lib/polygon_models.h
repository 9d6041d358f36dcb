// SPDX-License-Identifier: MIT
/* Polygon models for the tests: boxes, balls, sheets, turned, moved and put together. */
#ifndef TEST_POLYGON_MODELS_H
#define TEST_POLYGON_MODELS_H

#include "lib/support.h"

/* Grows as parts are added; free with test_model_free(). */
typedef struct test_model {
    float (*points)[3];
    uint32_t (*triangles)[3];
    int64_t point_count, triangle_count;
} test_model;

uint32_t test_model_point(test_model *model, double x, double y, double z);
void test_model_triangle(test_model *model, uint32_t a, uint32_t b, uint32_t c);
/* Faces outward. matrix[row][column] takes the part to its place; NULL leaves it. */
void test_model_box(test_model *model, const double low[3], const double high[3],
                    const double matrix[3][4]);
/* An octahedron divided `steps` times, its corners on the sphere. */
void test_model_ball(test_model *model, const double centre[3], double radius, int steps);
void test_model_turn_round(test_model *model, int64_t first_triangle);
void test_model_free(test_model *model);
qn_mesh *test_model_mesh(qn_context *context, const test_model *model);
/* A solid of a model that must be closed, all of it one owner's; frees the model. */
qn_solid *test_model_solid(qn_context *context, test_model *model, int32_t owner);
/* A random rotation and a shift of up to `spread` along each axis. */
void test_random_matrix(test_random *random, double spread, double matrix[3][4]);

#endif
