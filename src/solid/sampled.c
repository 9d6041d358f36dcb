// SPDX-License-Identifier: MIT
/* A volume's trilinear interpolant as a solid: values and gradients cell by cell; its bounds,
 * crossings, blocks and creases are in sampled_*.c. */
#include "solid/sampled.h"
#include "solid/node.h"
#include "solid/sampled_parts.h"
#include "volume/field.h"

#include <string.h>

static const sampled_solid *as_sampled(const qn_solid *solid) {
    return (const sampled_solid *)solid;
}

static void destroy(qn_solid *solid) {
    sampled_solid *s = (sampled_solid *)solid;
    qni_sampled_free_fits(s);
    qni_free(solid->context, s->block.values, qni_block_samples(&s->block),
             sizeof *s->block.values);
    if (s->whole == s)
        qni_leaf_tree_free(solid->context, &s->tree);
    else
        qn_solid_destroy((qn_solid *)(uintptr_t)&s->whole->base);
    qni_solid_free(solid, sizeof *s);
}

bool qni_sampled_corners(const qn_solid *solid, const int64_t cell[3], double corner[8]) {
    const sampled_solid *s = as_sampled(solid);
    int32_t at[3];
    for (int k = 0; k < 3; ++k) {
        if (cell[k] < 0 || cell[k] + 1 >= s->whole->frame.count[k])
            return false;
        at[k] = (int32_t)cell[k];
    }
    qni_sampled_load(s, at, corner);
    return true;
}

/* ---- places ---------------------------------------------------------------------------------- */

/* Which planes a position lies between is decided by these; the cell that is tried first is a
 * guess.
 */
void qni_locate_axis(const qni_sample_frame *frame, int k, double position, qni_cell_place *place) {
    const int32_t last = frame->count[k] - 2;
    const double guess = (position - frame->origin[k]) * frame->per_step[k];
    int32_t cell = !(guess > 0) ? 0 : guess < (double)last ? (int32_t)guess : last;
    double low = qni_sample_plane(frame, k, cell), high = qni_sample_plane(frame, k, cell + 1);
    for (; cell > 0 && position < low; high = low, low = qni_sample_plane(frame, k, cell))
        --cell;
    for (; cell < last && position >= high; low = high, high = qni_sample_plane(frame, k, cell + 1))
        ++cell;
    const double along = (position - low) / (high - low);
    place->cell[k] = cell;
    place->width[k] = high - low;
    place->along[k] = along > 0 ? along < 1 ? along : 1 : 0;
}

qni_cell_place qni_locate(const sampled_solid *s, const double point[3]) {
    qni_cell_place place;
    for (int k = 0; k < 3; ++k)
        qni_locate_axis(&s->whole->frame, k, point[k], &place);
    return place;
}

/* ---- values and gradients -------------------------------------------------------------------- */

double qni_sampled_mix(const double c[8], const double t[3]) {
    const double low = qni_mix(qni_mix(c[0], c[1], t[0]), qni_mix(c[2], c[3], t[0]), t[1]);
    const double high = qni_mix(qni_mix(c[4], c[5], t[0]), qni_mix(c[6], c[7], t[0]), t[1]);
    return qni_mix(low, high, t[2]);
}

static void slopes(const double c[8], const qni_cell_place *place, double gradient[3]) {
    for (int k = 0; k < 3; ++k) {
        const int p = k == 0 ? 1 : 0, q = k == 2 ? 1 : 2;
        double side[2];
        for (int n = 0; n < 2; ++n) {
            const int base = n << k, u = 1 << p, v = 1 << q;
            side[n] =
                qni_mix(qni_mix(c[base], c[base | u], place->along[p]),
                        qni_mix(c[base | v], c[base | u | v], place->along[p]), place->along[q]);
        }
        gradient[k] = (side[1] - side[0]) / place->width[k];
    }
}

static bool is_sample(const qni_cell_place *place) {
    for (int k = 0; k < 3; ++k)
        if (place->along[k] != 0 && place->along[k] != 1)
            return false;
    return true;
}

static qn_status sampled_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                double *values) {
    const sampled_solid *s = as_sampled(solid);
    for (int64_t n = 0; n < count; ++n) {
        const qni_cell_place place = qni_locate(s, points[n]);
        double corner[8];
        qni_sampled_load(s, place.cell, corner);
        qni_sharp_fit room;
        int active;
        const qni_sharp_fit *fit =
            is_sample(&place) ? NULL : qni_sampled_fit(s, place.cell, corner, &room);
        values[n] =
            fit ? qni_fit_value(fit, points[n], &active) : qni_sampled_mix(corner, place.along);
    }
    return QN_OK;
}

static qn_status sampled_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                   double (*gradients)[3], int32_t *owners) {
    const sampled_solid *s = as_sampled(solid);
    for (int64_t n = 0; n < count; ++n) {
        if (owners)
            owners[n] = solid->owner;
        if (!gradients)
            continue;
        const qni_cell_place place = qni_locate(s, points[n]);
        double corner[8];
        qni_sampled_load(s, place.cell, corner);
        slopes(corner, &place, gradients[n]);
        qni_sharp_fit room;
        int active;
        const qni_sharp_fit *fit = qni_sampled_fit(s, place.cell, corner, &room);
        if (fit) {
            qni_fit_value(fit, points[n], &active);
            memcpy(gradients[n], fit->tangents[active].slope, sizeof gradients[n]);
        }
    }
    return QN_OK;
}

/* ---- restricting ----------------------------------------------------------------------------- */

static qn_status sampled_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out);

static const qni_solid_ops sampled_ops = {
    .destroy = destroy,
    .values = sampled_values,
    .gradients = sampled_gradients,
    .bounds = qni_sampled_bounds_of,
    .crossings = qni_sampled_crossings_of,
    .restrict_to = sampled_restrict,
};

static qn_status sampled_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const sampled_solid *s = as_sampled(solid);
    sample_block block = {.values = NULL};
    if (!qni_block_lay(s, box, &block) || qni_block_holds(s, &block)) {
        *solid_out = qni_solid_retain(solid);
        return QN_OK;
    }
    *solid_out = NULL;
    sampled_solid *part =
        (sampled_solid *)qni_solid_new(solid->context, sizeof *part, &sampled_ops);
    if (!part)
        return QN_ERROR_OUT_OF_MEMORY;
    part->whole = (const sampled_solid *)qni_solid_retain(&s->whole->base);
    part->base.box = solid->box;
    part->base.owner = solid->owner;
    block.values = qni_alloc(solid->context, qni_block_samples(&block), sizeof *block.values);
    part->block = block;
    if (block.values && s->whole->creases) {
        part->block.fits =
            qni_alloc_zero(solid->context, qni_block_samples(&block), sizeof *part->block.fits);
        if (!part->block.fits) {
            qn_solid_destroy(&part->base);
            return QN_ERROR_OUT_OF_MEMORY;
        }
    }
    if (!block.values) {
        qn_solid_destroy(&part->base);
        return QN_ERROR_OUT_OF_MEMORY;
    }
    qni_block_fill(&s->whole->field, &part->block);
    *solid_out = &part->base;
    return QN_OK;
}

/* ---- making ---------------------------------------------------------------------------------- */

static qni_box box_of(const sampled_solid *s) {
    const qni_leaf_tree *tree = &s->tree;
    if (tree->mixed_count == 0)
        return qni_box_nothing();
    qni_box box;
    for (int k = 0; k < 3; ++k) {
        int32_t low = INT32_MAX, high = 0;
        for (int64_t n = 0; n < tree->mixed_count; ++n) {
            low = tree->mixed[n][k] < low ? tree->mixed[n][k] : low;
            high = tree->mixed[n][k] > high ? tree->mixed[n][k] : high;
        }
        const int64_t end = (int64_t)(high + 1) * QNI_LEAF, last = s->frame.count[k] - 1;
        box.low[k] = qni_sample_plane(&s->frame, k, (int64_t)low * QNI_LEAF);
        box.high[k] = qni_sample_plane(&s->frame, k, end < last ? end : last);
    }
    return box;
}

static double measure_distance(const sampled_solid *s) {
    enum { MOST_LEAVES = 2000 };
    const qni_leaf_tree *tree = &s->tree;
    const int64_t stride = tree->mixed_count / MOST_LEAVES + 1;
    const qni_sample_reader reader = {s, qni_read_sample, qni_read_plane};
    int64_t crossed = 0, unit = 0;
    for (int64_t n = 0; n < tree->mixed_count; n += stride)
        for (int m = 0; m < 512; ++m) {
            const int32_t point[3] = {8 * tree->mixed[n][0] + (m & 7),
                                      8 * tree->mixed[n][1] + (m >> 3 & 7),
                                      8 * tree->mixed[n][2] + (m >> 6)};
            int32_t next[3] = {point[0] + 1, point[1], point[2]};
            if (next[0] >= s->frame.count[0] || point[1] >= s->frame.count[1] ||
                point[2] >= s->frame.count[2] ||
                (qni_sample(s, point) < 0) == (qni_sample(s, next) < 0))
                continue;
            qni_sample_tangent tangent;
            ++crossed;
            unit += qni_tangent_at(&reader, point, s->frame.step, &tangent) ||
                    qni_tangent_at(&reader, next, s->frame.step, &tangent);
        }
    return crossed ? (double)unit / (double)crossed : 0;
}

qn_status qni_sampled_create(qn_context *context, const qn_volume *volume,
                             const qni_sampled_settings *settings, qn_solid **solid_out,
                             qn_error *error) {
    *solid_out = NULL;
    sampled_solid *s = (sampled_solid *)qni_solid_new(context, sizeof *s, &sampled_ops);
    if (!s)
        return qni_fail_memory(error, "a solid");
    s->whole = s;
    s->base.owner = settings->owner;
    s->base.direct = true;
    qn_status status =
        qni_field_init(volume, settings->isovalue, settings->inside_below, false, &s->field, error);
    if (status == QN_OK) {
        qni_sample_frame_init(&s->frame, (const double(*)[4])s->field.world, s->field.samples);
        status = qni_leaf_tree_build(context, &s->field, settings->every_leaf, &s->tree, error);
    }
    if (status != QN_OK) {
        qn_solid_destroy(&s->base);
        return status;
    }
    s->base.box = box_of(s);
    s->distance_share = settings->creases ? measure_distance(s) : 0;
    s->creases = settings->creases && s->distance_share >= settings->least_share;
    s->crease_cosine = settings->crease_cosine;
    *solid_out = &s->base;
    return QN_OK;
}

const qni_sample_frame *qni_sampled_frame(const qn_solid *solid) {
    return solid->ops == &sampled_ops ? &as_sampled(solid)->whole->frame : NULL;
}

const int32_t (*qni_sampled_mixed_leaves(const qn_solid *solid, int64_t *count_out))[3] {
    const qni_leaf_tree *tree = &as_sampled(solid)->whole->tree;
    *count_out = tree->mixed_count;
    return (const int32_t(*)[3])tree->mixed;
}

double qni_sampled_distance_share(const qn_solid *solid) {
    return as_sampled(solid)->whole->distance_share;
}

bool qni_sampled_has_creases(const qn_solid *solid) {
    return as_sampled(solid)->whole->creases;
}

int64_t qni_sampled_sharp_crossings(const qn_solid *solid) {
    return __atomic_load_n(&as_sampled(solid)->whole->sharp_crossings, __ATOMIC_RELAXED);
}
