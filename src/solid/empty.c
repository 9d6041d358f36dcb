// SPDX-License-Identifier: MIT
/* The solid without points: what empty groups and cubes of no height are. */
#include "solid/primitives.h"

#include <math.h>

static void destroy(qn_solid *solid) {
    qni_solid_free(solid, sizeof *solid);
}

static qn_status empty_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                              double *values) {
    (void)solid, (void)points;
    for (int64_t n = 0; n < count; ++n)
        values[n] = QNI_INFINITY;
    return QN_OK;
}

static qn_status empty_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                 double (*gradients)[3], int32_t *owners) {
    (void)points;
    for (int64_t n = 0; n < count; ++n) {
        for (int k = 0; gradients && k < 3; ++k)
            gradients[n][k] = 0;
        if (owners)
            owners[n] = solid->owner;
    }
    return QN_OK;
}

static qn_status empty_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    (void)solid, (void)box;
    range[0] = range[1] = QNI_INFINITY;
    return QN_OK;
}

static qn_status empty_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                 int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    (void)solid, (void)a, (void)b, (void)capacity, (void)crossings;
    *count_out = 0;
    return QN_OK;
}

static bool empty_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    (void)solid, (void)box;
    for (int k = 0; k < 3; ++k)
        ranges[k][0] = ranges[k][1] = 0;
    return true;
}

static const qni_solid_ops empty_ops = {
    .destroy = destroy,
    .values = empty_values,
    .gradients = empty_gradients,
    .bounds = empty_bounds,
    .crossings = empty_crossings,
    .restrict_to = qni_restrict_to_itself,
    .slopes = empty_slopes,
};

qn_solid *qni_empty_create(qn_context *context) {
    qn_solid *solid = qni_solid_new(context, sizeof *solid, &empty_ops);
    if (solid)
        solid->box = qni_box_nothing();
    return solid;
}
