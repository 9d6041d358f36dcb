// SPDX-License-Identifier: MIT
/* Fields: their samples inside and outside of the border, and the surfacer's mesh of them. */
#include "lib/test_volume.h"

#include <math.h>

test_field test_field_make(int64_t nx, int64_t ny, int64_t nz) {
    test_field field;
    memset(&field, 0, sizeof field);
    field.size[0] = nx, field.size[1] = ny, field.size[2] = nz;
    field.values = test_alloc((size_t)(nx * ny * nz), sizeof *field.values);
    for (int a = 0; a < 4; ++a)
        field.matrix[a][a] = 1;
    return field;
}

void test_field_free(test_field *field) {
    free(field->values);
    field->values = NULL;
}

/* By cofactors; the matrices of the tests are well conditioned. */
static void invert(const double m[4][4], double inverse[3][4]) {
    double determinant = 0;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            inverse[c][r] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        }
    for (int c = 0; c < 3; ++c)
        determinant += m[0][c] * inverse[c][0];
    for (int r = 0; r < 3; ++r) {
        inverse[r][3] = 0;
        for (int c = 0; c < 3; ++c)
            inverse[r][c] /= determinant;
        for (int c = 0; c < 3; ++c)
            inverse[r][3] -= inverse[r][c] * m[c][3];
    }
}

void test_field_prepare(test_field *field) {
    invert(field->matrix, field->inverse);
    field->minimum = HUGE_VAL, field->maximum = -HUGE_VAL, field->largest_distance = 0;
    const int64_t count = field->size[0] * field->size[1] * field->size[2];
    for (int64_t i = 0; i < count; ++i) {
        double value = field->values[i];
        if (!isfinite(value))
            continue;
        field->minimum = fmin(field->minimum, value);
        field->maximum = fmax(field->maximum, value);
        field->largest_distance = fmax(field->largest_distance, fabs(value - field->iso));
    }
    if (field->minimum > field->maximum) /* nothing finite: any distance does */
        field->minimum = field->maximum = field->iso, field->largest_distance = 1;
}

void test_field_random_matrix(test_field *field, test_random *random) {
    do
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 4; ++c)
                field->matrix[r][c] = test_random_gaussian(random) * (c == 3 ? 20 : 1);
    while (invert(field->matrix, field->inverse),
           fabs(field->inverse[0][0]) + fabs(field->inverse[1][1]) + fabs(field->inverse[2][2]) >
               6);
}

static int64_t clamp_index(int64_t i, int64_t size) {
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

static bool is_virtual(const test_field *field, int64_t i, int64_t j, int64_t k) {
    return i < 0 || j < 0 || k < 0 || i >= field->size[0] || j >= field->size[1] ||
           k >= field->size[2];
}

static double outside_distance(const test_field *field, double distance) {
    return field->inside == QN_INSIDE_ABOVE ? -fabs(distance) : fabs(distance);
}

double test_field_distance(const test_field *field, int64_t i, int64_t j, int64_t k) {
    if (is_virtual(field, i, j, k))
        return outside_distance(field, test_field_distance(field, clamp_index(i, field->size[0]),
                                                           clamp_index(j, field->size[1]),
                                                           clamp_index(k, field->size[2])));
    double value = field->values[i + field->size[0] * (j + field->size[1] * k)];
    if (isnan(value))
        return outside_distance(field, field->largest_distance);
    if (isinf(value))
        return value > 0 ? field->largest_distance : -field->largest_distance;
    return value - field->iso;
}

bool test_field_above(const test_field *field, int64_t i, int64_t j, int64_t k) {
    if (is_virtual(field, i, j, k))
        return field->inside == QN_INSIDE_BELOW;
    double value = field->values[i + field->size[0] * (j + field->size[1] * k)];
    if (isnan(value))
        return field->inside == QN_INSIDE_BELOW;
    return value >= field->iso;
}

qn_volume *test_field_volume(qn_context *context, const test_field *field) {
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.samples = field->values;
    grid.scalar = QN_F64;
    memcpy(grid.size, field->size, sizeof grid.size);
    memcpy(grid.index_to_world, field->matrix, sizeof grid.index_to_world);
    qn_volume *volume;
    qn_error error;
    if (qn_volume_create(context, &grid, NULL, NULL, &volume, &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    return volume;
}

qn_surface_options test_field_options(const test_field *field) {
    qn_surface_options options;
    qn_surface_options_init(&options);
    options.isovalues = &field->iso;
    options.isovalue_count = 1;
    options.inside = field->inside;
    options.open = field->open;
    options.keep_doubled = true; /* what the reference makes: [DMC21] plain */
    return options;
}

qn_mesh *test_field_surface_with(qn_context *context, const test_field *field,
                                 const qn_surface_options *options, qn_surface_report *report) {
    qn_volume *volume = test_field_volume(context, field);
    qn_mesh *mesh;
    qn_error error;
    if (qn_surface(context, volume, options, &mesh, report, &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    qn_volume_destroy(volume);
    return mesh;
}

qn_mesh *test_field_surface(qn_context *context, const test_field *field,
                            qn_surface_report *report) {
    const qn_surface_options options = test_field_options(field);
    return test_field_surface_with(context, field, &options, report);
}

qn_mesh_report test_mesh_topology(qn_context *context, const qn_mesh *mesh) {
    qn_mesh_check_options options;
    qn_mesh_report report;
    qn_mesh_check_options_init(&options);
    options.skip_intersections = true;
    assert_int_equal(qn_mesh_check(context, mesh, &options, &report, NULL), QN_OK);
    return report;
}
