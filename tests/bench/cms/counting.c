// SPDX-License-Identifier: MIT
#include "bench/cms/counting.h"
#include "solid/node.h"

typedef struct counting {
    qn_solid base;
    qn_solid *part;
    counting_tally *tally;
} counting;

static const counting *self(const qn_solid *solid) {
    return (const counting *)solid;
}

static void destroy(qn_solid *solid) {
    qn_solid_destroy(((counting *)solid)->part);
    qni_solid_free(solid, sizeof(counting));
}

static qn_status values(const qn_solid *solid, int64_t count, const double (*points)[3],
                        double *out) {
    self(solid)->tally->values += count;
    return self(solid)->part->ops->values(self(solid)->part, count, points, out);
}

static qn_status gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                           double (*out)[3], int32_t *owners) {
    self(solid)->tally->gradients += count;
    return self(solid)->part->ops->gradients(self(solid)->part, count, points, out, owners);
}

static qn_status bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    ++self(solid)->tally->bounds;
    return self(solid)->part->ops->bounds(self(solid)->part, box, range);
}

static qn_status crossings(const qn_solid *solid, const double a[3], const double b[3],
                           int32_t capacity, qni_crossing *list, int32_t *count_out) {
    ++self(solid)->tally->segments;
    return self(solid)->part->ops->crossings(self(solid)->part, a, b, capacity, list, count_out);
}

static qn_status restrict_to(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    qn_solid *part;
    ++self(solid)->tally->restrictions;
    *solid_out = NULL;
    QN_TRY(self(solid)->part->ops->restrict_to(self(solid)->part, box, &part));
    *solid_out = counting_create(part, self(solid)->tally);
    qn_solid_destroy(part);
    return *solid_out ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static bool slope(const qn_solid *solid, const double a[3], const double b[3], double range[2]) {
    const qn_solid *part = self(solid)->part;
    return part->ops->slope && part->ops->slope(part, a, b, range);
}

static bool slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const qn_solid *part = self(solid)->part;
    return part->ops->slopes && part->ops->slopes(part, box, ranges);
}

static const qni_solid_ops counting_ops = {
    .destroy = destroy,
    .values = values,
    .gradients = gradients,
    .bounds = bounds,
    .crossings = crossings,
    .restrict_to = restrict_to,
    .slope = slope,
    .slopes = slopes,
};

qn_solid *counting_create(qn_solid *part, counting_tally *tally) {
    counting *solid = (counting *)qni_solid_new(part->context, sizeof *solid, &counting_ops);
    if (!solid)
        return NULL;
    solid->part = qni_solid_retain(part);
    solid->tally = tally;
    solid->base.box = part->box;
    solid->base.depth = part->depth;
    return &solid->base;
}
