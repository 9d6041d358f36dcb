// SPDX-License-Identifier: MIT
/* The same bytes whatever the number of threads, and however the same values are stored: scalar
 * type, strides, byte order, slope and intercept. */
#include "lib/random_volume.h"

static uint64_t hash_of(int32_t threads, const qn_grid *grid, const qn_surface_options *options,
                        const char *what) {
    qn_context *context = test_context(threads);
    qn_volume *volume;
    qn_mesh *mesh[2] = {NULL, NULL};
    qn_error error;
    uint64_t hash = TEST_HASH_START;
    if (qn_volume_create(context, grid, NULL, NULL, &volume, &error) != QN_OK ||
        qn_surface(context, volume, options, mesh, NULL, &error) != QN_OK)
        fail_msg("%s: %s", what, error.message);
    for (int i = 0; i < options->isovalue_count; ++i) {
        uint64_t one = test_hash_mesh(mesh[i]);
        hash = test_hash(hash, &one, sizeof one);
        const qn_halfedges h = qn_mesh_get_halfedges(mesh[i]);
        if (h.count > 0) {
            hash = test_hash(hash, h.twin, (size_t)h.count * sizeof *h.twin);
            hash = test_hash(hash, h.vertex_halfedge,
                             (size_t)qn_mesh_get_view(mesh[i]).vertex_count *
                                 sizeof *h.vertex_halfedge);
        }
        qn_mesh_destroy(mesh[i]);
    }
    qn_volume_destroy(volume);
    test_context_end(context);
    return hash;
}

static qn_grid packed_grid(const test_field *field) {
    qn_grid grid;
    memset(&grid, 0, sizeof grid);
    grid.samples = field->values;
    grid.scalar = QN_F64;
    memcpy(grid.size, field->size, sizeof grid.size);
    memcpy(grid.index_to_world, field->matrix, sizeof grid.index_to_world);
    return grid;
}

static void expect_equal(const char *field, const char *what, uint64_t found, uint64_t expected) {
    if (found != expected)
        fail_msg("%s: other bytes with %s (%016llx, plain %016llx)", field, what,
                 (unsigned long long)found, (unsigned long long)expected);
}

static void bytes_are_equal_for_1_2_8_threads(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    for (int64_t i = 0; i < test_count(60, 400); ++i) {
        test_random random = {seed + (uint64_t)i};
        test_field field = test_random_field(&random, (test_kind)(i % TEST_KIND_COUNT), 40);
        qn_grid grid = packed_grid(&field);
        const double isovalues[2] = {field.iso, field.iso + 0.25};
        qn_surface_options options = test_field_options(&field);
        options.isovalues = isovalues;
        options.isovalue_count = 2;
        options.triangles = i % 5 == 4;
        options.skip_normals = i % 7 == 6;
        options.halfedges = !options.triangles && i % 2 == 0;
        options.simplify = i % 3 == 1;
        options.topology = i % 3 == 2 ? QN_TOPOLOGY_EXACT : QN_TOPOLOGY_DISCS;
        uint64_t one = hash_of(1, &grid, &options, field.name);
        expect_equal(field.name, "2 threads", hash_of(2, &grid, &options, field.name), one);
        expect_equal(field.name, "8 threads", hash_of(8, &grid, &options, field.name), one);
        test_field_free(&field);
    }
}

/* ---- storage --------------------------------------------------------------------------------- */

static void swap_bytes(unsigned char *bytes, size_t count) {
    for (size_t i = 0; i < count / 2; ++i) {
        unsigned char byte = bytes[i];
        bytes[i] = bytes[count - 1 - i];
        bytes[count - 1 - i] = byte;
    }
}

static void store(void *at, qn_scalar scalar, double value, bool swapped) {
    switch (scalar) {
#define STORE(name, type, text)                                                                    \
    case QN_##name: {                                                                              \
        type stored = (type)value;                                                                 \
        memcpy(at, &stored, sizeof stored);                                                        \
        break;                                                                                     \
    }
        QN_SCALAR_MAP(STORE)
#undef STORE
    case QN_SCALAR_COUNT:
        break;
    }
    if (swapped)
        swap_bytes(at, qn_scalar_size(scalar));
}

/* The field's values, less the intercept, over the slope, in a layout of the given axis order with
 * gaps, running backward along the axes of `flips`. *block is to be freed. */
static qn_grid stored_grid(const test_field *field, qn_scalar scalar, bool swapped,
                           const int order[3], int flips, int gap, double slope, double intercept,
                           void **block) {
    qn_grid grid = packed_grid(field);
    int64_t size = (int64_t)qn_scalar_size(scalar), step = size + gap, origin = 0;
    for (int a = 0; a < 3; ++a) {
        int axis = order[a];
        grid.stride[axis] = step;
        step = step * field->size[axis] + gap;
    }
    unsigned char *bytes = *block = test_alloc((size_t)(step + size), 1);
    for (int a = 0; a < 3; ++a)
        if (flips >> a & 1) {
            origin += grid.stride[a] * (field->size[a] - 1);
            grid.stride[a] = -grid.stride[a];
        }
    const double *next = field->values;
    for (int64_t k = 0; k < field->size[2]; ++k)
        for (int64_t j = 0; j < field->size[1]; ++j)
            for (int64_t i = 0; i < field->size[0]; ++i)
                store(bytes + origin + i * grid.stride[0] + j * grid.stride[1] + k * grid.stride[2],
                      scalar, (*next++ - intercept) / slope, swapped);
    grid.samples = bytes + origin;
    grid.scalar = scalar;
    grid.swapped = swapped;
    grid.slope = slope;
    grid.intercept = intercept;
    return grid;
}

static void check_storage(const test_field *field, qn_scalar scalar, double slope, double intercept,
                          uint64_t expected) {
    static const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const qn_surface_options options = test_field_options(field);
    for (int layout = 0; layout < 12; ++layout) {
        /* packed; swapped; permuted; backward; with gaps that leave samples unaligned */
        const bool swapped = layout & 1;
        const int flips = layout % 8, gap = layout >= 6 ? layout - 5 : 0;
        void *block;
        qn_grid grid = stored_grid(field, scalar, swapped, orders[layout / 2],
                                   layout < 2 ? 0 : flips, gap, slope, intercept, &block);
        char what[128];
        snprintf(what, sizeof what, "%s%s, axes %d, flips %d, gap %d, slope %g, intercept %g",
                 qn_scalar_name(scalar), swapped ? " swapped" : "", layout / 2,
                 layout < 2 ? 0 : flips, gap, slope, intercept);
        expect_equal(field->name, what, hash_of(2, &grid, &options, what), expected);
        free(block);
    }
}

static void bytes_are_equal_for_all_storage(void **state) {
    (void)state;
    uint64_t seed = test_seed();
    for (int64_t round = 0; round < test_count(6, 40); ++round)
        for (int scalar = 0; scalar < QN_SCALAR_COUNT; ++scalar) {
            test_random random = {seed + (uint64_t)(round * QN_SCALAR_COUNT + scalar)};
            test_field field = test_random_field(&random, TEST_GAUSSIAN, 22);
            /* integers that every type holds, whole multiples of the slope above the intercept */
            const double slope = round % 2 ? -0.75 : 1, intercept = round % 2 ? 12.5 : 0;
            const bool is_unsigned = scalar == QN_U8 || scalar == QN_U16 || scalar == QN_U32;
            for (int64_t i = 0; i < field.size[0] * field.size[1] * field.size[2]; ++i)
                field.values[i] = intercept + slope * (double)test_random_range(
                                                          &random, is_unsigned ? 0 : -100, 100);
            field.iso = intercept + slope * (is_unsigned ? 50.25 : 3);
            test_field_prepare(&field);
            qn_grid grid = packed_grid(&field);
            qn_surface_options options = test_field_options(&field);
            check_storage(&field, (qn_scalar)scalar, slope, intercept,
                          hash_of(1, &grid, &options, field.name));
            test_field_free(&field);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_equal_for_1_2_8_threads),
        cmocka_unit_test(bytes_are_equal_for_all_storage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
