// SPDX-License-Identifier: MIT
/* The band of a mesh: exact distances by searches that begin at the last sample's triangle, signs
 * from the lattice's lines, offsets and shells from both. */
#include "band/lines.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"

#include <math.h>
#include <string.h>

enum { BLOCK_SIDE = 4 };

typedef struct mesh_band {
    const qni_lattice *lattice;
    const qni_nearest *mesh;
    const qni_lines *lines;
    bool parity;
    double offset, half_shell; /* half_shell < 0: no shell */
    double half_width;         /* world units */
    double reach;              /* distances beyond this do not matter */
} mesh_band;

/* ---- the field ---------------------------------------------------------------------------------
 */

static bool is_inside(const mesh_band *band, int32_t winding) {
    return band->parity ? winding & 1 : winding != 0;
}

/* From signed distance to what the band is of. */
static double field_of(const mesh_band *band, double distance) {
    const double shifted = distance - band->offset;
    return band->half_shell < 0 ? shifted : fabs(shifted) - band->half_shell;
}

/* The range of the field where signed distances run from `low` to `high`. */
static void field_range(const mesh_band *band, double low, double high, double range[2]) {
    low -= band->offset;
    high -= band->offset;
    range[0] = low;
    range[1] = high;
    if (band->half_shell < 0)
        return;
    const bool straddles = low <= 0 && high >= 0;
    range[0] = (straddles ? 0 : fmin(fabs(low), fabs(high))) - band->half_shell;
    range[1] = fmax(fabs(low), fabs(high)) - band->half_shell;
}

static void world_place(const qni_lattice *lattice, const double index[3], double world[3]) {
    for (int i = 0; i < 3; ++i)
        world[i] = lattice->origin[i] + lattice->voxel * index[i];
}

/* The distance of the middle of a cube of samples, at most `beyond`, and half its diagonal. */
static double middle_distance(const mesh_band *band, const int32_t origin[3], int32_t size,
                              uint32_t *hint, double *radius) {
    double middle[3], place[3];
    for (int i = 0; i < 3; ++i)
        middle[i] = (double)origin[i] + (size - 1) / 2.0;
    world_place(band->lattice, middle, place);
    *radius = (size - 1) / 2.0 * sqrt(3) * band->lattice->voxel * (1 + 1e-9);
    const double beyond = band->reach + *radius;
    const qni_near near = qni_nearest_find(band->mesh, place, beyond * beyond, *hint);
    if (near.triangle == QNI_NO_TRIANGLE)
        return beyond;
    *hint = near.triangle;
    return sqrt(near.squared);
}

static qn_status classify(const void *user, qni_band_node *node, int32_t size,
                          qni_band_class *class_out) {
    const mesh_band *band = user;
    double radius, range[2];
    const double distance = middle_distance(band, node->origin, size, &node->hint, &radius);
    const bool open_ended = distance >= band->reach + radius;
    const double infinite = (double)INFINITY;
    double low = distance - radius, high = open_ended ? infinite : distance + radius;
    if (distance <= radius)
        low = -high;
    else if (is_inside(band, qni_lines_winding(band->lines, node->origin))) {
        const double swapped = -low;
        low = -high;
        high = swapped;
    }
    field_range(band, low, high, range);
    *class_out = range[0] >= band->half_width    ? QNI_BAND_OUTSIDE
                 : range[1] <= -band->half_width ? QNI_BAND_INSIDE
                                                 : QNI_BAND_MIXED;
    return QN_OK;
}

/* ---- leaves ------------------------------------------------------------------------------------
 */

/* What can be nearest to a sample of a block: samples are within the radius of its middle, and so
 * is their nearest triangle, of theirs. */
static void gather_round(const mesh_band *band, const int32_t origin[3], double distance,
                         qni_near_set *set) {
    double middle[3], place[3];
    for (int i = 0; i < 3; ++i)
        middle[i] = (double)origin[i] + (BLOCK_SIDE - 1) / 2.0;
    world_place(band->lattice, middle, place);
    distance *= 1 + 1e-9;
    qni_nearest_gather(band->mesh, place, distance * distance, set);
}

/* Distances of the 4^3 samples of a block from `corner` on in leaf coordinates; infinity where they
 * do not matter. */
static void measure_block(const mesh_band *band, const qni_band_node *leaf, const int32_t corner[3],
                          uint32_t *hint, double distances[QNI_BAND_SAMPLES]) {
    double radius;
    int32_t origin[3];
    for (int i = 0; i < 3; ++i)
        origin[i] = leaf->origin[i] + corner[i];
    const double middle = middle_distance(band, origin, BLOCK_SIDE, hint, &radius);
    const bool far = middle >= band->reach + radius;
    const double limit = band->reach * band->reach;
    qni_near_set set;
    if (!far)
        gather_round(band, origin, fmin(middle + 2 * radius, band->reach + radius), &set);
    for (int32_t n = 0; n < BLOCK_SIDE * BLOCK_SIDE * BLOCK_SIDE; ++n) {
        const int32_t y = n >> 2 & 3, z = n >> 4, x = (y & 1) ? 3 - (n & 3) : n & 3;
        double *distance = &distances[corner[0] + x + 8 * (corner[1] + y) + 64 * (corner[2] + z)];
        *distance = INFINITY;
        if (far)
            continue;
        const double index[3] = {origin[0] + x, origin[1] + y, origin[2] + z};
        double place[3];
        world_place(band->lattice, index, place);
        const qni_near near = qni_nearest_find_among(band->mesh, &set, place, limit, *hint);
        if (near.triangle == QNI_NO_TRIANGLE)
            continue;
        *hint = near.triangle;
        *distance = sqrt(near.squared);
    }
}

/* Value and mask bit of one sample. */
static void settle(const mesh_band *band, double distance, bool inside, int n, float *values,
                   uint64_t *mask) {
    const double field = field_of(band, inside ? -distance : distance);
    const double width = band->half_width;
    values[n] = (float)(field > width ? width : field < -width ? -width : field);
    if (field < width && field > -width)
        mask[n >> 6] |= UINT64_C(1) << (n & 63);
}

static qn_status fill(const void *user, const qni_band_node *leaf, float values[QNI_BAND_SAMPLES],
                      uint64_t mask[QNI_BAND_WORDS]) {
    const mesh_band *band = user;
    double distances[QNI_BAND_SAMPLES];
    uint32_t hint = leaf->hint;
    for (int b = 0; b < 8; ++b) {
        const int32_t corner[3] = {b & 1 ? BLOCK_SIDE : 0, b & 2 ? BLOCK_SIDE : 0,
                                   b & 4 ? BLOCK_SIDE : 0};
        measure_block(band, leaf, corner, &hint, distances);
    }
    memset(mask, 0, QNI_BAND_WORDS * sizeof *mask);
    for (int32_t row = 0; row < 64; ++row) {
        int32_t windings[8];
        const int32_t first[3] = {leaf->origin[0], leaf->origin[1] + (row & 7),
                                  leaf->origin[2] + (row >> 3)};
        qni_lines_windings(band->lines, first, windings);
        for (int x = 0; x < 8; ++x)
            settle(band, distances[8 * row + x], is_inside(band, windings[x]), 8 * row + x, values,
                   mask);
    }
    return QN_OK;
}

/* ---- the whole ---------------------------------------------------------------------------------
 */

static qn_status run_stages(qni_band *band, const qni_band_source *source, qn_band_report *report) {
    const double started = qni_seconds();
    band->source = source;
    QN_TRY(qni_band_discover(band));
    const double discovered = qni_seconds();
    QN_TRY(qni_band_fill(band));
    report->seconds_discovery = discovered - started;
    report->seconds_values = qni_seconds() - discovered;
    report->voxel = band->lattice.voxel;
    report->background = band->background;
    report->leaf_count = band->leaf_count;
    report->tile_count = band->tile_count;
    report->active_count = band->active_count;
    report->visited_nodes = band->visited_nodes;
    return QN_OK;
}

static qn_status make_band(qni_band *band, const qn_band_options *options,
                           const qni_nearest *nearest, qn_band_report *report) {
    const double started = qni_seconds();
    qni_lines lines;
    QN_TRY(qni_lines_create(&band->work, nearest, &band->lattice, &lines));
    report->seconds_lines = qni_seconds() - started;
    mesh_band field = {.lattice = &band->lattice,
                       .mesh = nearest,
                       .lines = &lines,
                       .parity = options->sign == QN_BAND_SIGN_PARITY,
                       .offset = options->offset,
                       .half_shell = options->shell > 0 ? options->shell / 2 : -1,
                       .half_width = band->background};
    field.reach = fabs(options->offset) + options->shell / 2 + band->background;
    const qni_band_source source = {&field, classify, fill};
    report->sign = field.parity ? QN_BAND_SIGN_PARITY : QN_BAND_SIGN_WINDING;
    report->lines = lines.size[0] * lines.size[1];
    report->disagreeing_lines = field.parity ? lines.odd_lines : lines.open_lines;
    const qn_status status = run_stages(band, &source, report);
    qni_lines_destroy(&lines);
    return status;
}

static qn_status with_tree(qni_band *band, const qn_band_options *options,
                           const qni_nearest *nearest, qn_band_report *report) {
    if (nearest->tree.triangle_count == 0)
        return qni_fail(band->work.error, QN_ERROR_EMPTY,
                        "the mesh has no face with an area: there are no distances to take");
    report->triangles = nearest->tree.triangle_count;
    const double width = options->half_width > 0 ? options->half_width : 3;
    qni_lattice *lattice = &band->lattice;
    QN_TRY(qni_lattice_place(options, nearest->low, nearest->high, 0, lattice, band->work.error));
    band->background = width * lattice->voxel;
    const double reach = fmax(0, options->offset) + options->shell / 2 + band->background;
    QN_TRY(
        qni_lattice_place(options, nearest->low, nearest->high, reach, lattice, band->work.error));
    return make_band(band, options, nearest, report);
}

qn_status qn_volume_from_mesh(qn_context *context, const qn_mesh *mesh,
                              const qn_band_options *options, qn_volume **volume_out,
                              qn_band_report *report_out, qn_error *error) {
    qn_band_options defaults;
    qn_band_options_init(&defaults);
    *volume_out = NULL;
    QNI_CHECK_OPTIONS(options, "qn_band_options_init", error);
    options = options ? options : &defaults;
    QN_TRY(qni_band_check_options(options, error));
    const double started = qni_seconds();
    qn_band_report report;
    memset(&report, 0, sizeof report);
    qni_band band = {.work = {.context = context, .error = error, .stage = "distances"}};
    qni_nearest nearest;
    QN_TRY(qni_nearest_create(context, mesh, "distances", &nearest, error));
    report.seconds_tree = qni_seconds() - started;
    qn_status status = with_tree(&band, options, &nearest, &report);
    qni_nearest_destroy(&nearest);
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    if (status == QN_OK)
        status = qni_band_finish(&band, view.space, view.unit, volume_out);
    qni_band_free(&band);
    QN_TRY(status);
    report.seconds_total = qni_seconds() - started;
    if (report_out)
        *report_out = report;
    return QN_OK;
}
