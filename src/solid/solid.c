// SPDX-License-Identifier: MIT
/* Solids in general: references, boxes, and the calls that forward to the kind of solid. */
#include "solid/node.h"

#include <math.h>

qn_solid *qni_solid_new(qn_context *context, size_t size, const qni_solid_ops *ops) {
    qn_solid *solid = qni_alloc_zero(context, 1, size);
    if (!solid)
        return NULL;
    solid->ops = ops;
    solid->context = context;
    solid->references = 1;
    solid->box = qni_box_everything();
    solid->depth = 1;
    solid->weight = 1;
    return solid;
}

void qni_solid_free(qn_solid *solid, size_t size) {
    qni_free(solid->context, solid, 1, size);
}

qn_solid *qni_solid_retain(const qn_solid *solid) {
    qn_solid *counted = (qn_solid *)(uintptr_t)solid; /* immutable but for the count */
    __atomic_add_fetch(&counted->references, 1, __ATOMIC_RELAXED);
    return counted;
}

void qn_solid_destroy(qn_solid *solid) {
    if (solid && __atomic_sub_fetch(&solid->references, 1, __ATOMIC_ACQ_REL) == 0)
        solid->ops->destroy(solid);
}

void qn_solid_get_box(const qn_solid *solid, double low[3], double high[3]) {
    for (int k = 0; k < 3; ++k) {
        low[k] = solid->box.low[k];
        high[k] = solid->box.high[k];
    }
}

qn_status qn_solid_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                          double *values, qn_error *error) {
    if (!solid || count < 0 || (count > 0 && (!points || !values)))
        return qni_fail(
            error, QN_ERROR_INVALID_ARGUMENT,
            "values of a solid were asked for without a solid, points or room for them");
    qn_status status = solid->ops->values(solid, count, points, values);
    if (status == QN_ERROR_OUT_OF_MEMORY)
        return qni_fail_memory(error, "values of a solid");
    if (status != QN_OK)
        return qni_fail(error, status, "a callback of the solid asked to stop");
    return QN_OK;
}

qni_box qni_box_everything(void) {
    return (qni_box){{-QNI_INFINITY, -QNI_INFINITY, -QNI_INFINITY},
                     {QNI_INFINITY, QNI_INFINITY, QNI_INFINITY}};
}

qni_box qni_box_nothing(void) {
    return (qni_box){{0, 0, 0}, {0, 0, 0}};
}

bool qni_box_is_nothing(const qni_box *box) {
    for (int k = 0; k < 3; ++k)
        if (!(box->low[k] < box->high[k]))
            return true;
    return false;
}

bool qni_box_is_finite(const qni_box *box) {
    for (int k = 0; k < 3; ++k)
        if (!isfinite(box->low[k]) || !isfinite(box->high[k]))
            return false;
    return true;
}

bool qni_boxes_meet(const qni_box *a, const qni_box *b) {
    for (int k = 0; k < 3; ++k)
        if (a->low[k] > b->high[k] || b->low[k] > a->high[k])
            return false;
    return true;
}

qn_status qni_solid_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                           bool *inside) {
    if (solid->ops->inside)
        return solid->ops->inside(solid, count, points, inside);
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        double values[QNI_SOLID_BLOCK];
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        QN_TRY(solid->ops->values(solid, block, points + first, values));
        for (int64_t i = 0; i < block; ++i)
            inside[first + i] = values[i] < 0;
    }
    return QN_OK;
}

qn_status qni_solid_first_order(const qn_solid *solid, const double p[3], double *value,
                                double gradient[3], int32_t *owner) {
    if (solid->ops->first_order)
        return solid->ops->first_order(solid, p, value, gradient, owner);
    const double point[1][3] = {{p[0], p[1], p[2]}};
    QN_TRY(solid->ops->values(solid, 1, point, value));
    return solid->ops->gradients(solid, 1, point, (double(*)[3])gradient, owner);
}

qn_status qni_solid_contains(const qn_solid *solid, const double p[3], bool *inside_out) {
    double point[1][3] = {{p[0], p[1], p[2]}};
    return qni_solid_inside(solid, 1, (const double(*)[3])point, inside_out);
}

void qni_unit(const double v[3], const double fallback[3], double unit[3]) {
    double largest = qni_greater(fabs(v[0]), qni_greater(fabs(v[1]), fabs(v[2])));
    bool usable =
        largest > 0 && largest < QNI_INFINITY && v[0] == v[0] && v[1] == v[1] && v[2] == v[2];
    if (!usable) {
        for (int k = 0; k < 3; ++k)
            unit[k] = fallback[k];
        return;
    }
    /* Scaled first: squares of very small or very large numbers would leave the range. */
    double x = v[0] / largest, y = v[1] / largest, z = v[2] / largest;
    double length = sqrt(x * x + y * y + z * z);
    unit[0] = x / length;
    unit[1] = y / length;
    unit[2] = z / length;
}

qn_status qni_restrict_to_itself(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    (void)box;
    *solid_out = qni_solid_retain(solid);
    return QN_OK;
}
