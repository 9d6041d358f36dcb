// SPDX-License-Identifier: MIT
/* Real volumes at several iso-values: closed, 2-manifold without exception, consistently oriented,
 * every vertex on the trilinear surface; open at the border 2-manifold as well; with exact topology
 * the same pieces and Euler characteristic as of the volume refined by trilinear interpolation.
 * Prints a table. */
#include "lib/mesh_measure.h"
#include "lib/trilinear.h"
#include "volume/volume.h"

#include <math.h>

typedef struct data_volume {
    const char *file;
    int64_t size[3]; /* raw files only */
    qn_scalar scalar;
    bool big_endian;
    int64_t header;
    double spacing[3];
    double iso;
    bool long_only;
} data_volume;

static const data_volume volumes[] = {
    {"torus_sdfgrid_40x40x40_f32le.vol", {40, 40, 40}, QN_F32, false, 48, {0}, 0, false},
    {"skull_2.9_64x64x64_f32le.inr",
     {64, 64, 64},
     QN_F32,
     false,
     256,
     {3.943, 3.943, 3.651},
     2.9,
     false},
    {"neghip_64x64x64_u8.raw.gz", {64, 64, 64}, QN_U8, false, 0, {0}, 100, false},
    {"carotid_mra_76x49x45_f32le.raw.gz", {76, 49, 45}, QN_F32, false, 0, {0}, 300, false},
    {"headsq_ct_64x64x93_i16le.raw.gz",
     {64, 64, 93},
     QN_I16,
     false,
     0,
     {3.2, 3.2, 1.5},
     1150,
     false},
    {"tooth_103x94x161_u8.nrrd", {0}, QN_U8, false, 0, {0}, 128, false},
    {"brainsmall_female_mri_128x128x84_u8.raw.gz",
     {128, 128, 84},
     QN_U8,
     false,
     0,
     {2, 2, 3},
     75,
     false},
    {"MR_Gd.nii.gz", {0}, QN_U8, false, 0, {0}, 100, false},
    {"engine_ct_256x256x128_u8.raw.gz", {256, 256, 128}, QN_U8, false, 0, {0}, 80, false},
    {"cthead_male_ct_256x256x113_u16be.raw.gz",
     {256, 256, 113},
     QN_U16,
     true,
     0,
     {1, 1, 2},
     1200,
     false},
    {"cranium_ct_256x256x108_i16le.raw.gz",
     {256, 256, 108},
     QN_I16,
     false,
     0,
     {0.957, 0.957, 1.5},
     226,
     false},
    {"eun.nii.gz", {0}, QN_U8, false, 0, {0}, 40, false},
    {"ch2.nii.gz", {0}, QN_U8, false, 0, {0}, 70, false},
    {"boston_teapot_ct_256x256x174_u8.raw.gz", {256, 256, 174}, QN_U8, false, 0, {0}, 60, true},
    {"aneurism_xa_256x256x256_u8.raw.gz", {256, 256, 256}, QN_U8, false, 0, {0}, 60, true},
    {"noisy_synthetic_256x256x256_u16le.raw.gz",
     {256, 256, 256},
     QN_U16,
     false,
     0,
     {0},
     2048,
     true},
    {"ch2better.nii.gz", {0}, QN_U8, false, 0, {0}, 50, true},
};

/* Samples of the largest volume that is refined, for the time and the memory that takes. */
enum { LARGEST_REFINED = 1500000 };

static qn_volume *read_volume(qn_context *context, const data_volume *data) {
    char name[512], path[4096];
    snprintf(name, sizeof name, "volumes/%s", data->file);
    if (!test_data_path(name, path, sizeof path))
        return NULL;
    qn_volume_read_options options;
    qn_volume_read_options_init(&options);
    if (data->size[0] > 0) {
        snprintf(options.format, sizeof options.format, "raw");
        memcpy(options.raw_size, data->size, sizeof options.raw_size);
        options.raw_scalar = data->scalar;
        options.raw_big_endian = data->big_endian;
        options.raw_header = data->header;
        options.has_spacing = data->spacing[0] > 0;
        memcpy(options.spacing, data->spacing, sizeof options.spacing);
    }
    qn_volume *volume;
    qn_error error;
    if (qn_volume_read(context, path, &options, &volume, &error) != QN_OK)
        fail_msg("%s: %s", data->file, error.message);
    return volume;
}

/* The samples as doubles, for the trilinear evaluator. */
static test_field field_of(const qn_volume *volume) {
    const qn_grid *grid = qn_volume_grid(volume);
    test_field field = test_field_make(grid->size[0], grid->size[1], grid->size[2]);
    double *next = field.values;
    for (int64_t k = 0; k < grid->size[2]; ++k)
        for (int64_t j = 0; j < grid->size[1]; ++j)
            for (int64_t i = 0; i < grid->size[0]; ++i)
                *next++ = qni_grid_value(grid, i, j, k);
    memcpy(field.matrix, grid->index_to_world, sizeof field.matrix);
    return field;
}

typedef struct deviations {
    double largest, beyond_rounding; /* relative to the data's range */
} deviations;

static deviations measure(const test_field *field, const qn_mesh *mesh) {
    qn_mesh_view view = qn_mesh_get_view(mesh);
    const double range = field->maximum - field->minimum;
    deviations result = {0, 0};
    for (int64_t v = 0; v < view.vertex_count; ++v) {
        double index[3];
        int64_t cell[3];
        test_to_index(field, view.positions + 3 * v, index);
        test_cell_of(field, index, cell);
        test_standing standing = test_vertex_standing(field, cell, view.positions + 3 * v);
        if (!(standing.outside <= 0)) /* beyond the border's caps, or not a number */
            fail_msg("%s: vertex %lld lies %g outside of the volume", field->name, (long long)v,
                     standing.outside);
        result.largest = fmax(result.largest, standing.deviation / range);
        result.beyond_rounding =
            fmax(result.beyond_rounding, (standing.deviation - standing.allowance) / range);
    }
    return result;
}

static qn_mesh *surface(qn_context *context, const qn_volume *volume, const test_field *field,
                        bool open, qn_topology topology, qn_surface_report *report) {
    qn_surface_options options = test_field_options(field);
    qn_mesh *mesh;
    qn_error error;
    options.open = open;
    options.keep_doubled = false;
    options.topology = topology;
    if (qn_surface(context, volume, &options, &mesh, report, &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    return mesh;
}

/* Measures a mesh, and fails unless it is an oriented 2-manifold, closed unless `open`. */
static qn_mesh_report check_mesh(qn_context *context, const test_field *field, const qn_mesh *mesh,
                                 bool open) {
    qn_mesh_check_options options;
    qn_mesh_report check;
    qn_error error;
    qn_mesh_check_options_init(&options);
    options.skip_intersections = true;
    if (qn_mesh_check(context, mesh, &options, &check, &error) != QN_OK)
        fail_msg("%s: %s", field->name, error.message);
    const int64_t open_edges = open ? 0 : check.boundary_edges + check.unused_vertices;
    if (check.nonmanifold_edges || check.nonmanifold_vertices || check.duplicate_faces ||
        check.orientation_conflicts || open_edges)
        fail_msg("%s at %g, %s: %lld non-manifold edges, %lld vertices, %lld duplicate faces, "
                 "%lld orientation conflicts, %lld boundary edges, %lld unused vertices",
                 field->name, field->iso, open ? "open" : "closed",
                 (long long)check.nonmanifold_edges, (long long)check.nonmanifold_vertices,
                 (long long)check.duplicate_faces, (long long)check.orientation_conflicts,
                 (long long)check.boundary_edges, (long long)check.unused_vertices);
    return check;
}

/* ---- the refined volume ---------------------------------------------------------------------- */

/* Twice as fine: the same trilinear function, virtual border layer included, on its own lattice. */
static test_field refine(const test_field *field) {
    const int64_t *n = field->size;
    test_field fine = test_field_make(2 * n[0] + 3, 2 * n[1] + 3, 2 * n[2] + 3);
    const int64_t *m = fine.size, step[3] = {1, m[0], m[0] * m[1]};
    fine.iso = 0;
    fine.inside = field->inside;
    fine.open = true; /* the border is all outside */
    snprintf(fine.name, sizeof fine.name, "%.50s, refined", field->name);
    for (int64_t z = 0; z < m[2]; z += 2)
        for (int64_t y = 0; y < m[1]; y += 2)
            for (int64_t x = 0; x < m[0]; x += 2) {
                const int64_t i = x / 2 - 1, j = y / 2 - 1, k = z / 2 - 1;
                const double value = test_field_distance(field, i, j, k);
                const bool below = value == 0 && !test_field_above(field, i, j, k);
                fine.values[x + step[1] * y + step[2] * z] = below ? -1e-200 : value;
            }
    for (int axis = 0; axis < 3; ++axis) /* axes before are whole, axes behind still coarse */
        for (int64_t z = axis == 2; z < m[2]; z += 2)
            for (int64_t y = axis == 1; y < m[1]; y += axis == 2 ? 1 : 2)
                for (int64_t x = axis == 0; x < m[0]; x += axis == 0 ? 2 : 1) {
                    double *value = fine.values + x + step[1] * y + step[2] * z;
                    *value = 0.5 * (value[-step[axis]] + value[step[axis]]);
                }
    test_field_prepare(&fine);
    return fine;
}

/* The check of [MDMC21] section 5. */
static void compare_with_refined(qn_context *context, const qn_volume *volume,
                                 const test_field *field) {
    qn_surface_report report;
    test_field fine = refine(field);
    qn_volume *fine_volume = test_field_volume(context, &fine);
    qn_mesh *mesh = surface(context, volume, field, false, QN_TOPOLOGY_EXACT, &report);
    qn_mesh *refined = surface(context, fine_volume, &fine, true, QN_TOPOLOGY_EXACT, NULL);
    const qn_mesh_report a = check_mesh(context, field, mesh, false);
    const qn_mesh_report b = check_mesh(context, &fine, refined, false);
    printf("%-28.28s %9.5g %9lld %9lld with exact topology (%lld tunnels) and refined: %lld, %lld "
           "pieces, Euler %lld, %lld\n",
           "", field->iso, (long long)a.vertex_count, (long long)b.vertex_count,
           (long long)report.restored_tunnels, (long long)a.components, (long long)b.components,
           (long long)a.euler_characteristic, (long long)b.euler_characteristic);
    assert_int_equal(a.components, b.components);
    assert_int_equal(a.euler_characteristic, b.euler_characteristic);
    qn_mesh_destroy(mesh);
    qn_mesh_destroy(refined);
    qn_volume_destroy(fine_volume);
    test_field_free(&fine);
}

/* ---- claims ---------------------------------------------------------------------------------- */

static void check_iso(qn_context *context, const qn_volume *volume, test_field *field, double iso) {
    const int64_t samples = field->size[0] * field->size[1] * field->size[2];
    field->iso = iso;
    test_field_prepare(field);
    qn_surface_report report;
    qn_mesh *mesh = surface(context, volume, field, false, QN_TOPOLOGY_DISCS, &report);
    const deviations deviation = measure(field, mesh);
    const qn_mesh_report check = check_mesh(context, field, mesh, false);
    printf("%-28.28s %9.5g %9lld %9lld %7lld %6lld %6lld %6lld %8.1e %8.1e %6.2f\n", field->name,
           iso, (long long)report.vertices, (long long)report.quads,
           (long long)report.ambiguous_faces, (long long)report.doubled_edges,
           (long long)check.components, (long long)report.fallback_points, deviation.largest,
           deviation.beyond_rounding, report.seconds_total);
    fflush(stdout);
    assert_int_equal(report.repaired_edges, report.doubled_edges);
    assert_true(deviation.beyond_rounding < 1e-6);
    assert_true(report.vertices == 0 || check.volume > 0);
    qn_mesh_destroy(mesh);
    mesh = surface(context, volume, field, true, QN_TOPOLOGY_DISCS, &report);
    check_mesh(context, field, mesh, true);
    qn_mesh_destroy(mesh);
    if (samples <= LARGEST_REFINED)
        compare_with_refined(context, volume, field);
}

static void data_volumes_are_manifold_and_exact(void **state) {
    (void)state;
    qn_context *context = test_context(0);
    int seen = 0;
    printf("%-28s %9s %9s %9s %7s %6s %6s %6s %8s %8s %6s\n", "volume", "iso", "vertices", "quads",
           "ambig.", "doubl.", "pieces", "fallb", "dev/rng", "beyond", "s");
    for (size_t i = 0; i < sizeof volumes / sizeof volumes[0]; ++i) {
        if (volumes[i].long_only && !test_is_long())
            continue;
        qn_volume *volume = read_volume(context, &volumes[i]);
        if (!volume)
            continue;
        qn_volume_statistics statistics;
        assert_int_equal(qn_volume_get_statistics(context, volume, &statistics, NULL), QN_OK);
        test_field field = field_of(volume);
        snprintf(field.name, sizeof field.name, "%s", volumes[i].file);
        check_iso(context, volume, &field, statistics.suggested);
        check_iso(context, volume, &field, volumes[i].iso);
        for (int n = 1; n < 4 && test_is_long(); ++n)
            check_iso(context, volume, &field,
                      statistics.minimum + n * 0.25 * (statistics.maximum - statistics.minimum));
        test_field_free(&field);
        qn_volume_destroy(volume);
        ++seen;
    }
    test_context_end(context);
    if (seen == 0)
        skip();
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(data_volumes_are_manifold_and_exact)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
