// SPDX-License-Identifier: MIT
/* The band of any solid: its bounds choose the leaves, its values fill them. */
#include "band/band.h"
#include "band/target.h"
#include "core/context.h"
#include "core/parallel.h"
#include "core/status.h"
#include "solid/solid.h"

#include <math.h>
#include <string.h>

enum { MARGIN = 2, SIDE_SAMPLES = 64 };

typedef struct solid_band {
    const qni_lattice *lattice;
    const qn_solid *solid;
    qni_band_target target;
} solid_band;

static qni_box box_of(const solid_band *band, const int32_t origin[3], int32_t size) {
    qni_box box;
    for (int i = 0; i < 3; ++i) {
        const double low = (double)origin[i] - MARGIN, high = (double)origin[i] + size - 1 + MARGIN;
        box.low[i] = band->lattice->origin[i] + band->lattice->voxel * low;
        box.high[i] = band->lattice->origin[i] + band->lattice->voxel * high;
    }
    return box;
}

static qn_status classify(const void *user, qni_band_node *node, int32_t size,
                          qni_band_class *class_out) {
    const solid_band *band = user;
    const qni_box box = box_of(band, node->origin, size);
    double bounds[2], range[2];
    QN_TRY(band->solid->ops->bounds(band->solid, &box, bounds));
    qni_band_range(&band->target, bounds[0], bounds[1], range);
    *class_out = range[0] >= 0 ? QNI_BAND_OUTSIDE : range[1] < 0 ? QNI_BAND_INSIDE : QNI_BAND_MIXED;
    return QN_OK;
}

/* ---- leaves ------------------------------------------------------------------------------------
 */

static void place_of(const solid_band *band, const qni_band_node *leaf, int x, int y, int z,
                     double place[3]) {
    const int offset[3] = {x, y, z};
    for (int i = 0; i < 3; ++i) {
        const double index = (double)leaf->origin[i] + offset[i];
        place[i] = band->lattice->origin[i] + band->lattice->voxel * index;
    }
}

/* What the band is of; NaN is outside. */
static double value_of(const solid_band *band, double field) {
    const double value = qni_band_value(&band->target, field);
    const double most = 1e30; /* finite as a float */
    return value < -most ? -most : value < most ? value : most;
}

/* Whether a sample beside the leaf is on the other side than all of it. */
static qn_status look_round(const solid_band *band, const qn_solid *local,
                            const qni_band_node *leaf, bool inside, bool *differs) {
    double points[SIDE_SAMPLES][3], values[SIDE_SAMPLES];
    *differs = false;
    for (int side = 0; side < 6 && !*differs; ++side) {
        const int axis = side >> 1, beyond = side & 1 ? QNI_BAND_LEAF : -1;
        for (int n = 0; n < SIDE_SAMPLES; ++n) {
            int p[3] = {0, 0, 0};
            p[axis] = beyond;
            p[axis == 0] = n & 7;
            p[axis == 2 ? 1 : 2] = n >> 3;
            place_of(band, leaf, p[0], p[1], p[2], points[n]);
        }
        QN_TRY(local->ops->values(local, SIDE_SAMPLES, (const double(*)[3])points, values));
        for (int n = 0; n < SIDE_SAMPLES; ++n)
            *differs = *differs || (value_of(band, values[n]) < 0) != inside;
    }
    return QN_OK;
}

static qn_status sample_leaf(const solid_band *band, const qn_solid *local,
                             const qni_band_node *leaf, float values[QNI_BAND_SAMPLES],
                             bool *crossed) {
    double points[QNI_BAND_SAMPLES][3], fields[QNI_BAND_SAMPLES];
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n)
        place_of(band, leaf, n & 7, n >> 3 & 7, n >> 6, points[n]);
    QN_TRY(local->ops->values(local, QNI_BAND_SAMPLES, (const double(*)[3])points, fields));
    int64_t inside = 0;
    for (int n = 0; n < QNI_BAND_SAMPLES; ++n) {
        values[n] = (float)value_of(band, fields[n]);
        inside += values[n] < 0;
    }
    *crossed = inside > 0 && inside < QNI_BAND_SAMPLES;
    return *crossed ? QN_OK : look_round(band, local, leaf, inside > 0, crossed);
}

static qn_status fill(const void *user, const qni_band_node *leaf, float values[QNI_BAND_SAMPLES],
                      uint64_t mask[QNI_BAND_WORDS]) {
    const solid_band *band = user;
    const qni_box box = box_of(band, leaf->origin, QNI_BAND_LEAF);
    qn_solid *local = NULL;
    bool crossed = false;
    QN_TRY(band->solid->ops->restrict_to(band->solid, &box, &local));
    const qn_status status = sample_leaf(band, local, leaf, values, &crossed);
    qn_solid_destroy(local);
    memset(mask, crossed ? 0xff : 0, QNI_BAND_WORDS * sizeof *mask);
    return status;
}

/* ---- the whole ---------------------------------------------------------------------------------
 */

/* What stands for all that is farther: the largest value in the leaves. */
static void set_background(qni_band *band) {
    double largest = 0;
    for (int64_t n = 0; n < QNI_BAND_SAMPLES * band->leaf_count; ++n)
        largest = fmax(largest, fabs((double)band->values[n]));
    band->background = largest;
    for (int64_t n = 0; n < band->tile_count; ++n)
        band->tiles[n].value = -largest;
}

static qn_status make_band(qni_band *band, const void *user, const qn_band_options *options,
                           qn_band_report *report) {
    const qn_solid *solid = user;
    qn_error *error = band->work.error;
    for (int i = 0; i < 3; ++i) {
        if (!(solid->box.low[i] < solid->box.high[i]))
            return qni_fail(error, QN_ERROR_EMPTY,
                            "the solid is empty: there is nothing to sample");
        if (!isfinite(solid->box.low[i]) || !isfinite(solid->box.high[i]))
            return qni_fail(error, QN_ERROR_INVALID_ARGUMENT,
                            "the solid has no end: intersect it with a box first");
    }
    qni_lattice *lattice = &band->lattice;
    QN_TRY(qni_lattice_place(options, solid->box.low, solid->box.high, 0, lattice, error));
    const double reach =
        fmax(0, options->offset) + options->shell / 2 + (MARGIN + 1) * lattice->voxel;
    QN_TRY(qni_lattice_place(options, solid->box.low, solid->box.high, reach, lattice, error));
    const solid_band field = {lattice, solid, qni_band_target_of(options)};
    const qni_band_source source = {&field, classify, fill};
    QN_TRY(qni_band_run(band, &source, report));
    if (band->leaf_count == 0)
        return qni_fail(error, QN_ERROR_EMPTY,
                        "no sample met the solid's surface: take smaller voxels than %g",
                        lattice->voxel);
    set_background(band);
    report->background = band->background;
    return QN_OK;
}

qn_status qn_volume_from_solid(qn_context *context, const qn_solid *solid,
                               const qn_band_options *options, qn_volume **volume_out,
                               qn_band_report *report_out, qn_error *error) {
    const qni_band_maker maker = {"samples", "", "", solid, make_band};
    return qni_band_make_volume(context, &maker, options, volume_out, report_out, error);
}
