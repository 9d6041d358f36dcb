// SPDX-License-Identifier: MIT
/* A solid and the volume it borrows: the volume goes when the solid does. Restricted solids keep
 * the whole. Or a solid whose box says where to look, not where it ends. */
#include "solid/primitives.h"

typedef struct keeper {
    qn_solid base;
    qn_solid *part, *whole; /* the part is asked; the whole, which may be NULL, is kept alive */
    qn_volume *volume;      /* of the whole itself */
} keeper;

static const qn_solid *part_of(const qn_solid *solid) {
    return ((const keeper *)solid)->part;
}

static void destroy(qn_solid *solid) {
    keeper *k = (keeper *)solid;
    qn_solid_destroy(k->part);
    qn_solid_destroy(k->whole);
    qn_volume_destroy(k->volume);
    qni_solid_free(solid, sizeof *k);
}

static qn_status keeper_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                               double *values) {
    return part_of(solid)->ops->values(part_of(solid), count, points, values);
}

static qn_status keeper_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double (*gradients)[3], int32_t *owners) {
    return part_of(solid)->ops->gradients(part_of(solid), count, points, gradients, owners);
}

static qn_status keeper_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    return part_of(solid)->ops->bounds(part_of(solid), box, range);
}

static qn_status keeper_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                  int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    return part_of(solid)->ops->crossings(part_of(solid), a, b, capacity, crossings, count_out);
}

static qn_status keeper_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                               bool *inside) {
    return qni_solid_inside(part_of(solid), count, points, inside);
}

static keeper *create(qn_context *context, const qn_solid *part);

static qn_status keeper_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const keeper *k = (const keeper *)solid;
    qn_solid *part;
    *solid_out = NULL;
    QN_TRY(k->part->ops->restrict_to(k->part, box, &part));
    if (part == k->part) {
        qn_solid_destroy(part);
        return qni_restrict_to_itself(solid, box, solid_out);
    }
    keeper *local = create(solid->context, part);
    qn_solid_destroy(part);
    if (!local)
        return QN_ERROR_OUT_OF_MEMORY;
    local->whole = qni_solid_retain(k->whole ? k->whole : solid);
    local->base.box = solid->box;
    *solid_out = &local->base;
    return QN_OK;
}

static const qni_solid_ops keeper_ops = {
    .destroy = destroy,
    .values = keeper_values,
    .gradients = keeper_gradients,
    .bounds = keeper_bounds,
    .crossings = keeper_crossings,
    .restrict_to = keeper_restrict,
    .inside = keeper_inside,
};

static keeper *create(qn_context *context, const qn_solid *part) {
    keeper *k = (keeper *)qni_solid_new(context, sizeof *k, &keeper_ops);
    if (!k)
        return NULL;
    k->part = qni_solid_retain(part);
    k->base.box = part->box;
    k->base.depth = part->depth + 1;
    k->base.weight = part->weight;
    k->base.narrows = part->narrows;
    k->base.owner = part->owner;
    return k;
}

qn_solid *qni_keeper_create(qn_context *context, const qn_solid *part, qn_volume *volume) {
    keeper *k = create(context, part);
    if (!k)
        return NULL;
    k->volume = volume;
    return &k->base;
}

qn_solid *qni_solid_boundless(qn_context *context, const qn_solid *part) {
    keeper *k = create(context, part);
    if (!k)
        return NULL;
    k->base.box = qni_box_everything();
    return &k->base;
}
