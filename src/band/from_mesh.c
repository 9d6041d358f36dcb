// SPDX-License-Identifier: MIT
/* The band of a mesh: exact distances by searches that begin at the last sample's triangle, signs
 * from the lattice's lines, offsets and shells from both. */
#include "band/leaf.h"
#include "band/lines.h"
#include "band/target.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "solid/model.h"

#include <math.h>
#include <string.h>

enum { BLOCK_SIDE = 4 };

typedef struct mesh_band {
    const qni_lattice *lattice;
    const qni_nearest *mesh;
    const qni_lines *lines;
    int64_t *tears;        /* neighbours on two sides with no face between them: seen holes */
    const qn_solid *solid; /* says what is inside, and what lies over holes; NULL: the lines do */
    bool parity;
    qni_band_target target;
    double half_width; /* world units */
    double reach;      /* distances beyond this do not matter */
} mesh_band;

/* ---- the field ---------------------------------------------------------------------------------
 */

static bool is_inside(const mesh_band *band, int32_t winding) {
    return band->parity ? winding & 1 : winding != 0;
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

static qni_band_class class_of(const mesh_band *band, double low, double high) {
    double range[2];
    qni_band_range(&band->target, low, high, range);
    return range[0] >= band->half_width    ? QNI_BAND_OUTSIDE
           : range[1] <= -band->half_width ? QNI_BAND_INSIDE
                                           : QNI_BAND_MIXED;
}

/* The box round a cube of samples, wider by `margin` on all sides. */
static qni_box samples_box(const mesh_band *band, const int32_t origin[3], int32_t size,
                           double margin) {
    qni_box box;
    for (int i = 0; i < 3; ++i) {
        box.low[i] = band->lattice->origin[i] + band->lattice->voxel * origin[i];
        box.high[i] = box.low[i] + band->lattice->voxel * (size - 1) + margin;
        box.low[i] -= margin;
    }
    return box;
}

/* +1: all samples of the node are outside, -1: inside, 0: not known. By the solid also 0 where a
 * sheet over a hole is so near that the band has it. */
static qn_status side_of(const mesh_band *band, const qni_band_node *node, int32_t size,
                         bool near_triangles, int *side) {
    *side = 0;
    if (near_triangles)
        return QN_OK;
    if (!band->solid) {
        *side = is_inside(band, qni_lines_winding(band->lines, node->origin)) ? -1 : 1;
        return QN_OK;
    }
    const qni_box box = samples_box(band, node->origin, size, band->half_width);
    double range[2];
    QN_TRY(band->solid->ops->bounds(band->solid, &box, range));
    *side = range[0] > 0 ? 1 : range[1] < 0 ? -1 : 0;
    return QN_OK;
}

static qn_status classify(const void *user, qni_band_node *node, int32_t size,
                          qni_band_class *class_out) {
    const mesh_band *band = user;
    const double infinite = (double)INFINITY;
    double radius;
    int side;
    const double distance = middle_distance(band, node->origin, size, &node->hint, &radius);
    const bool open_ended = distance >= band->reach + radius;
    const double low = distance - radius, high = open_ended ? infinite : distance + radius;
    QN_TRY(side_of(band, node, size, distance <= radius, &side));
    *class_out = side == 0  ? class_of(band, -high, high)
                 : side < 0 ? class_of(band, -high, -low)
                            : class_of(band, low, high);
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
    const double field = qni_band_value(&band->target, inside ? -distance : distance);
    const double width = band->half_width;
    values[n] = (float)(field > width ? width : field < -width ? -width : field);
    if (field < width && field > -width)
        mask[n >> 6] |= UINT64_C(1) << (n & 63);
}

static void sides_by_lines(const mesh_band *band, const qni_band_node *leaf,
                           bool inside[QNI_BAND_SAMPLES]) {
    for (int32_t row = 0; row < 64; ++row) {
        int32_t windings[8];
        const int32_t first[3] = {leaf->origin[0], leaf->origin[1] + (row & 7),
                                  leaf->origin[2] + (row >> 3)};
        qni_lines_windings(band->lines, first, windings);
        for (int x = 0; x < 8; ++x)
            inside[8 * row + x] = is_inside(band, windings[x]);
    }
}

/* The same as qni_leaf_tears() for samples and their neighbours in other leaves. */
static int64_t tears_beyond(const mesh_band *band, const qni_band_node *leaf,
                            const double distances[QNI_BAND_SAMPLES],
                            const bool inside[QNI_BAND_SAMPLES]) {
    const double least = band->lattice->voxel * (1 + 1e-9);
    int64_t tears = 0;
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n) {
        const int at[3] = {n & 7, n >> 3 & 7, n >> 6};
        for (int axis = 0; axis < 3; ++axis) {
            if ((at[axis] != 0 && at[axis] != 7) || !(distances[n] > least))
                continue;
            int32_t beyond[3] = {leaf->origin[0] + at[0], leaf->origin[1] + at[1],
                                 leaf->origin[2] + at[2]};
            beyond[axis] += at[axis] ? 1 : -1;
            tears += is_inside(band, qni_lines_winding(band->lines, beyond)) != inside[n];
        }
    }
    return tears;
}

static void place_of(const mesh_band *band, const qni_band_node *leaf, int sample,
                     double place[3]) {
    const double index[3] = {(double)leaf->origin[0] + (sample & 7),
                             (double)leaf->origin[1] + (sample >> 3 & 7),
                             (double)leaf->origin[2] + (sample >> 6)};
    world_place(band->lattice, index, place);
}

/* Values by the solid where sheets over holes can pass. */
static qn_status ask_values(const mesh_band *band, const qn_solid *local, const qni_band_node *leaf,
                            double distances[QNI_BAND_SAMPLES], bool inside[QNI_BAND_SAMPLES]) {
    double places[QNI_BAND_SAMPLES][3], values[QNI_BAND_SAMPLES];
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n)
        place_of(band, leaf, n, places[n]);
    QN_TRY(local->ops->values(local, QNI_BAND_SAMPLES, (const double(*)[3])places, values));
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n) {
        distances[n] = fabs(values[n]);
        inside[n] = values[n] < 0;
    }
    return QN_OK;
}

/* Sides by the solid where none can: one question for each region. */
static qn_status ask_regions(const mesh_band *band, const qn_solid *local,
                             const qni_band_node *leaf, const double distances[QNI_BAND_SAMPLES],
                             bool inside[QNI_BAND_SAMPLES]) {
    double places[QNI_BAND_SAMPLES][3];
    int16_t regions[QNI_BAND_SAMPLES], first[QNI_BAND_SAMPLES];
    bool answers[QNI_BAND_SAMPLES];
    const int count = qni_leaf_regions(distances, band->lattice->voxel, regions, first);
    for (int n = 0; n < count; ++n)
        place_of(band, leaf, first[n], places[n]);
    QN_TRY(local->ops->inside(local, count, (const double(*)[3])places, answers));
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n)
        inside[n] = answers[regions[n]];
    return QN_OK;
}

static qn_status ask_solid(const mesh_band *band, const qni_band_node *leaf,
                           double distances[QNI_BAND_SAMPLES], bool inside[QNI_BAND_SAMPLES]) {
    const qni_box box = samples_box(band, leaf->origin, QNI_BAND_LEAF, 0);
    qn_solid *local = NULL;
    QN_TRY(band->solid->ops->restrict_to(band->solid, &box, &local));
    const bool smooth = !qni_is_meshed(local) || ((const qni_meshed *)local)->smooth;
    const qn_status status = smooth ? ask_values(band, local, leaf, distances, inside)
                                    : ask_regions(band, local, leaf, distances, inside);
    qn_solid_destroy(local);
    return status;
}

static qn_status fill(const void *user, const qni_band_node *leaf, float values[QNI_BAND_SAMPLES],
                      uint64_t mask[QNI_BAND_WORDS]) {
    const mesh_band *band = user;
    double distances[QNI_BAND_SAMPLES];
    bool inside[QNI_BAND_SAMPLES];
    uint32_t hint = leaf->hint;
    for (int b = 0; b < 8; ++b) {
        const int32_t corner[3] = {b & 1 ? BLOCK_SIDE : 0, b & 2 ? BLOCK_SIDE : 0,
                                   b & 4 ? BLOCK_SIDE : 0};
        measure_block(band, leaf, corner, &hint, distances);
    }
    if (band->solid)
        QN_TRY(ask_solid(band, leaf, distances, inside));
    else {
        sides_by_lines(band, leaf, inside);
        const int64_t tears = qni_leaf_tears(distances, band->lattice->voxel, inside) +
                              tears_beyond(band, leaf, distances, inside);
        __atomic_fetch_add(band->tears, tears, __ATOMIC_RELAXED);
    }
    memset(mask, 0, QNI_BAND_WORDS * sizeof *mask);
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n)
        settle(band, distances[n], inside[n], n, values, mask);
    return QN_OK;
}

/* ---- the whole ---------------------------------------------------------------------------------
 */

/* The solid of a mesh whose lines disagree. */
static qn_status make_solid(const qni_band *band, const qn_mesh *mesh, qn_mesh_sign sign,
                            qn_solid **solid_out, qn_band_report *report) {
    qn_solid_mesh_options options;
    qn_solid_mesh_options_init(&options);
    options.sign = sign;
    qn_solid_mesh_report found;
    QN_TRY(qn_solid_from_mesh(band->work.context, mesh, &options, solid_out, &found,
                              band->work.error));
    report->sign = found.used;
    report->holes = found.holes;
    report->turned_triangles = found.turned_triangles;
    return QN_OK;
}

static qn_status make_band(qni_band *band, const qn_mesh *mesh, const qn_band_options *options,
                           const qni_nearest *nearest, const qni_lines *lines,
                           qn_band_report *report) {
    const bool parity = options->sign == QN_MESH_SIGN_PARITY;
    mesh_band field = {.lattice = &band->lattice,
                       .mesh = nearest,
                       .lines = lines,
                       .parity = parity,
                       .target = qni_band_target_of(options),
                       .half_width = band->background};
    field.reach = fabs(options->offset) + options->shell / 2 + band->background;
    const qni_band_source source = {&field, classify, fill};
    report->sign = parity ? QN_MESH_SIGN_PARITY : QN_MESH_SIGN_WINDING;
    report->lines = lines->size[0] * lines->size[1];
    report->disagreeing_lines = parity ? lines->odd_lines : lines->open_lines;
    field.tears = &report->torn_pairs;
    const bool signs_matter = options->shell == 0 || options->offset != 0;
    if (report->disagreeing_lines == 0 || !signs_matter) {
        QN_TRY(qni_band_run(band, &source, report));
        if (report->torn_pairs == 0 || !signs_matter)
            return QN_OK;
        qni_band_clear(band);
    }
    qn_solid *solid = NULL;
    QN_TRY(make_solid(band, mesh, options->sign, &solid, report));
    field.solid = solid;
    const qn_status status = qni_band_run(band, &source, report);
    qn_solid_destroy(solid);
    return status;
}

static qn_status with_tree(qni_band *band, const qn_mesh *mesh, const qn_band_options *options,
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
    const double started = qni_seconds();
    qni_lines lines;
    QN_TRY(qni_lines_create(&band->work, nearest, lattice, &lines));
    report->seconds_lines = qni_seconds() - started;
    const qn_status status = make_band(band, mesh, options, nearest, &lines, report);
    qni_lines_destroy(&lines);
    return status;
}

static qn_status make(qni_band *band, const void *user, const qn_band_options *options,
                      qn_band_report *report) {
    const qn_mesh *mesh = user;
    const double started = qni_seconds();
    qni_nearest nearest;
    QN_TRY(qni_nearest_create(band->work.context, mesh, "distances", &nearest, band->work.error));
    report->seconds_tree = qni_seconds() - started;
    const qn_status status = with_tree(band, mesh, options, &nearest, report);
    qni_nearest_destroy(&nearest);
    return status;
}

qn_status qn_volume_from_mesh(qn_context *context, const qn_mesh *mesh,
                              const qn_band_options *options, qn_volume **volume_out,
                              qn_band_report *report_out, qn_error *error) {
    const qn_mesh_view view = qn_mesh_get_view(mesh);
    const qni_band_maker maker = {"distances", view.space, view.unit, mesh, make};
    return qni_band_make_volume(context, &maker, options, volume_out, report_out, error);
}
