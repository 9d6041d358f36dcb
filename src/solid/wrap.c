// SPDX-License-Identifier: MIT
/* Solids that change one thing about another one: all owners, or the value by a constant. */
#include "solid/primitives.h"

#include <math.h>

typedef struct wrapped {
    qn_solid base;
    qn_solid *part;
    double distance; /* of offsets */
} wrapped;

static const wrapped *wrap(const qn_solid *solid) {
    return (const wrapped *)solid;
}

static void destroy(qn_solid *solid) {
    qn_solid_destroy(((wrapped *)solid)->part);
    qni_solid_free(solid, sizeof(wrapped));
}

static qn_solid *create(qn_context *context, const qn_solid *part, const qni_solid_ops *ops) {
    wrapped *solid = (wrapped *)qni_solid_new(context, sizeof *solid, ops);
    if (!solid)
        return NULL;
    solid->part = qni_solid_retain(part);
    solid->base.box = part->box;
    solid->base.depth = part->depth + 1;
    solid->base.weight = part->weight;
    solid->base.narrows = part->narrows;
    return &solid->base;
}

static qn_status owned_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                              double *values) {
    return wrap(solid)->part->ops->values(wrap(solid)->part, count, points, values);
}

static qn_status owned_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 double (*gradients)[3], int32_t *owners) {
    for (int64_t n = 0; owners && n < count; ++n)
        owners[n] = solid->owner;
    return wrap(solid)->part->ops->gradients(wrap(solid)->part, count, points, gradients, NULL);
}

static qn_status owned_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    return wrap(solid)->part->ops->bounds(wrap(solid)->part, box, range);
}

static qn_status owned_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                 int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    QN_TRY(
        wrap(solid)->part->ops->crossings(wrap(solid)->part, a, b, capacity, crossings, count_out));
    for (int32_t i = 0; i < *count_out; ++i)
        crossings[i].owner = solid->owner;
    return QN_OK;
}

static bool part_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const qn_solid *part = wrap(solid)->part;
    return part->ops->slopes && part->ops->slopes(part, box, ranges);
}

/* The wrapped part restricted, in a wrapping of its own. */
static qn_status rewrap(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    qn_solid *part;
    *solid_out = NULL;
    QN_TRY(wrap(solid)->part->ops->restrict_to(wrap(solid)->part, box, &part));
    if (part == wrap(solid)->part) {
        *solid_out = qni_solid_retain(solid);
    } else {
        *solid_out = create(solid->context, part, solid->ops);
        if (*solid_out) {
            (*solid_out)->owner = solid->owner;
            (*solid_out)->box = solid->box;
            ((wrapped *)*solid_out)->distance = wrap(solid)->distance;
        }
    }
    qn_solid_destroy(part);
    return *solid_out ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static const qni_solid_ops owned_ops = {
    .destroy = destroy,
    .values = owned_values,
    .gradients = owned_gradients,
    .bounds = owned_bounds,
    .crossings = owned_crossings,
    .restrict_to = rewrap,
    .slopes = part_slopes,
};

qn_solid *qni_owned_create(qn_context *context, const qn_solid *part, int32_t owner) {
    qn_solid *solid = create(context, part, &owned_ops);
    if (solid)
        solid->owner = owner;
    return solid;
}

static qn_status offset_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                               double *values) {
    QN_TRY(owned_values(solid, count, points, values));
    for (int64_t n = 0; n < count; ++n)
        values[n] -= wrap(solid)->distance;
    return QN_OK;
}

static qn_status offset_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double (*gradients)[3], int32_t *owners) {
    return wrap(solid)->part->ops->gradients(wrap(solid)->part, count, points, gradients, owners);
}

static qn_status offset_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    QN_TRY(owned_bounds(solid, box, range));
    range[0] -= wrap(solid)->distance;
    range[1] -= wrap(solid)->distance;
    return QN_OK;
}

static const qni_solid_ops offset_ops = {
    .destroy = destroy,
    .values = offset_values,
    .gradients = offset_gradients,
    .bounds = offset_bounds,
    .crossings = qni_find_crossings,
    .restrict_to = rewrap,
    .slopes = part_slopes,
};

/* Whether f stays above `distance` between the part's box grown by `inner` and by twice that. */
static bool shell_is_outside(const qn_solid *part, double inner, double distance) {
    enum { PATCHES = 8 };
    for (int side = 0; side < 6; ++side)
        for (int patch = 0; patch < PATCHES * PATCHES; ++patch) {
            qni_box box;
            int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
            double range[2], size[3];
            for (int k = 0; k < 3; ++k)
                size[k] = part->box.high[k] - part->box.low[k] + 4 * inner;
            box.low[axis] =
                side % 2 ? part->box.high[axis] + inner : part->box.low[axis] - 2 * inner;
            box.high[axis] = box.low[axis] + inner;
            box.low[u] = part->box.low[u] - 2 * inner + size[u] * (patch % PATCHES) / PATCHES;
            box.low[v] = part->box.low[v] - 2 * inner + size[v] * (patch / PATCHES) / PATCHES;
            box.high[u] = box.low[u] + size[u] / PATCHES;
            box.high[v] = box.low[v] + size[v] / PATCHES;
            if (part->ops->bounds(part, &box, range) != QN_OK || !(range[0] > distance))
                return false;
        }
    return true;
}

/* How far a sharp corner reaches depends on its angle: the box grows until a shell round it is
 * outside. */
static qni_box grown_box(const qn_solid *part, double distance) {
    if (!qni_box_is_finite(&part->box))
        return qni_box_everything();
    for (double reach = 1.0625 * distance; reach <= 1024 * distance; reach *= 2)
        if (shell_is_outside(part, reach, distance)) {
            qni_box box = part->box;
            for (int k = 0; k < 3; ++k) {
                box.low[k] -= reach;
                box.high[k] += reach;
            }
            return box;
        }
    return qni_box_everything();
}

qn_solid *qni_offset_create(qn_context *context, const qn_solid *part, double distance) {
    qn_solid *solid = create(context, part, &offset_ops);
    if (!solid)
        return NULL;
    ((wrapped *)solid)->distance = distance;
    if (distance > 0 && !qni_box_is_nothing(&part->box))
        solid->box = grown_box(part, distance);
    return solid;
}
