// SPDX-License-Identifier: MIT
/* Polygon models, sound and broken, remeshed by CMS as `quoin remesh --dim` does: closed,
 * 2-manifold, oriented, no self-intersections for every one of them; volume and genus of those
 * whose own are known (closed, 2-manifold, oriented, not crossing themselves). QUOIN_LONG=1: all
 * files, twice as fine. Prints a table. */
#include "lib/support.h"

#include <math.h>
#include <time.h>

/* Seconds for one file of the long run; what takes longer is a row that says so. */
enum { TIME_LIMIT = 120 };

/* Quick ones first; of the others the soup takes a minute, the rest seconds to half a minute. */
static const char *const quick[] = {
    "cross.off",         "star.off",         "joint.off",        "itemb.off",  "part.off",
    "fandisk_quads.off", "netgen_part1.stl", "couplingdown.off", "boeing.off", "busted.STL",
    "cow.obj",           "anchor_dense.off", "featuretype.STL",
};
static const char *const slow[] = {
    "3holes.off",
    "ADIS16480.STL.gz",
    "armadillo.obj.gz",
    "beetle-alt.obj.gz",
    "bumpy-cube.obj.gz",
    "cheese.off",
    "elephant.obj",
    "fandisk.obj",
    "gears.stl.gz",
    "hemisphere.off",
    "holes.off",
    "igl-truck.obj",
    "knot1.off",
    "mech-holes-shark.off",
    "octagonal_pocket.stl",
    "pinion.off",
    "plate_holes.STL",
    "quadknot.obj",
    "rocker-arm.obj",
    "rotor_small.off",
    "screwdriver.off",
    "self_intersectA.obj.gz",
    "self_intersectB.obj.gz",
    "soup.stl",
    "spot.obj",
    "stanford-bunny.obj.gz",
    "suzanne.obj",
    "teapot.obj",
    "thingi10k_112932.stl",
    "thingi10k_472042.stl",
    "thingi10k_72214.stl",
    "thingi10k_99865.stl.gz",
};

typedef struct limit {
    double end; /* seconds of the clock; 0: none */
} limit;

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int look_at_clock(void *user, const char *stage, double fraction) {
    (void)stage, (void)fraction;
    const limit *until = user;
    return until->end > 0 && now() > until->end;
}

/* The finest cell is 1/cells of the longest side. */
static void set_cells(const qn_solid *solid, int cells, qn_solid_surface_options *options) {
    double low[3], high[3], longest = 0;
    qn_solid_get_box(solid, low, high);
    for (int axis = 0; axis < 3; ++axis)
        longest = fmax(longest, high[axis] - low[axis]);
    qn_solid_surface_options_init(options);
    for (options->depth = QN_MIN_DEPTH; qn_depth_cells(options->depth) < cells;)
        ++options->depth;
    const double cell = longest / cells,
                 grow = 0.5 * (cell * qn_depth_cells(options->depth) - longest);
    options->has_box = true;
    for (int axis = 0; axis < 3; ++axis) {
        const double margin = high[axis] - low[axis] >= longest ? grow : 0.01 * cell;
        options->low[axis] = low[axis] - margin;
        options->high[axis] = high[axis] + margin;
    }
}

/* Its volume is that of the solid: the surface bounds it, nowhere twice. */
static bool is_sound(const qn_mesh_report *input, const qn_solid_mesh_report *model) {
    return model->closed && input->closed && input->manifold && input->oriented &&
           input->self_intersections == 0 && model->disagreeing_lines == 0;
}

static bool is_clean(const qn_mesh_report *report) {
    return report->closed && report->manifold && report->oriented &&
           report->self_intersections == 0 && report->degenerate_faces == 0;
}

/* Remesh a file. False when the time ran out. */
static bool remesh(qn_context *context, const char *path, int cells, qn_mesh_report *input,
                   qn_solid_mesh_report *model, qn_mesh_report *result) {
    qn_mesh *mesh, *surface = NULL;
    qn_solid *solid = NULL;
    qn_error error;
    if (qn_mesh_read(context, path, NULL, &mesh, &error) != QN_OK)
        fail_msg("%s", error.message);
    qn_status status = qn_mesh_check(context, mesh, NULL, input, &error);
    if (status == QN_OK)
        status = qn_solid_from_mesh(context, mesh, NULL, &solid, model, &error);
    qn_mesh_destroy(mesh);
    if (status == QN_OK) {
        qn_solid_surface_options options;
        set_cells(solid, cells, &options);
        status = qn_solid_surface(context, solid, &options, &surface, NULL, &error);
    }
    qn_solid_destroy(solid);
    if (status == QN_OK)
        status = qn_mesh_check(context, surface, NULL, result, &error);
    qn_mesh_destroy(surface);
    if (status != QN_OK && status != QN_ERROR_CANCELLED)
        fail_msg("%s: %s", path, error.message);
    return status == QN_OK;
}

/* 1 for a file that is good, 0 for one that is not, -1 for one that is not there. */
static int try_file(const char *file, int cells) {
    char name[256], path[4096];
    snprintf(name, sizeof name, "meshes/%s", file);
    if (!test_data_path(name, path, sizeof path))
        return -1;
    const double started = now();
    limit until = {test_is_long() ? started + TIME_LIMIT : 0};
    qn_context_options options;
    qn_context_options_init(&options);
    options.progress = look_at_clock;
    options.user = &until;
    qn_context *context;
    assert_int_equal(qn_context_create(&options, &context, NULL), QN_OK);
    qn_mesh_report input, result;
    qn_solid_mesh_report model;
    const bool done = remesh(context, path, cells, &input, &model, &result);
    test_context_end(context);
    if (!done) {
        print_message("%-24s %4d more than %d s\n", file, cells, TIME_LIMIT);
        return 1;
    }
    const bool sound = is_sound(&input, &model), clean = is_clean(&result);
    const double ratio = result.volume / fabs(input.volume);
    print_message("%-24s %4d %-7s %8lld triangles, %s, %s %8.5f of the volume, genus %lld for "
                  "%lld, %.2f s\n",
                  file, cells, model.used == QN_MESH_SIGN_PARITY ? "parity" : "winding",
                  (long long)result.triangle_count, clean ? "clean" : "NOT CLEAN",
                  sound ? "sound," : "broken, so not asked:", ratio, (long long)result.genus_sum,
                  (long long)input.genus_sum, now() - started);
    return clean && (!sound || (fabs(ratio - 1) < 0.005 && result.genus_sum == input.genus_sum));
}

static void models_come_out_clean(void **state) {
    (void)state;
    int seen = 0, bad = 0;
    const int cells = test_is_long() ? 128 : 64;
    for (size_t n = 0; n < sizeof quick / sizeof *quick; ++n) {
        const int result = try_file(quick[n], cells);
        seen += result >= 0;
        bad += result == 0;
    }
    for (size_t n = 0; n < sizeof slow / sizeof *slow && test_is_long(); ++n) {
        const int result = try_file(slow[n], cells);
        seen += result >= 0;
        bad += result == 0;
    }
    if (seen == 0)
        skip();
    assert_int_equal(bad, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(models_come_out_clean)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
