// SPDX-License-Identifier: MIT
/* Solids seen through an affine map. A segment stays a segment, so crossings keep their places on
 * it. The values are the part's own: after a scaling they are no distances, but signs, bounds and
 * gradients are right. */
#include "solid/primitives.h"

#include <math.h>
#include <string.h>

typedef struct transformed {
    qn_solid base;
    qn_solid *part;
    double inverse[3][4]; /* from here to the part */
    bool invertible;
} transformed;

static void destroy(qn_solid *solid) {
    qn_solid_destroy(((transformed *)solid)->part);
    qni_solid_free(solid, sizeof(transformed));
}

static void apply(const double m[3][4], const double p[3], double out[3]) {
    double x = p[0], y = p[1], z = p[2];
    for (int k = 0; k < 3; ++k)
        out[k] = m[k][0] * x + m[k][1] * y + m[k][2] * z + m[k][3];
}

static qn_status transform_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                  double *values) {
    const transformed *t = (const transformed *)solid;
    double moved[QNI_SOLID_BLOCK][3];
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        for (int64_t i = 0; i < block; ++i)
            apply(t->inverse, points[first + i], moved[i]);
        QN_TRY(t->part->ops->values(t->part, block, (const double(*)[3])moved, values + first));
    }
    return QN_OK;
}

/* Gradients are rows: they are multiplied from the left. */
static void turn_back(const transformed *t, double gradient[3]) {
    double old[3] = {gradient[0], gradient[1], gradient[2]};
    for (int k = 0; k < 3; ++k)
        gradient[k] =
            old[0] * t->inverse[0][k] + old[1] * t->inverse[1][k] + old[2] * t->inverse[2][k];
}

static qn_status transform_gradients(const qn_solid *solid, int64_t count,
                                     const double (*points)[3], double (*gradients)[3],
                                     int32_t *owners) {
    const transformed *t = (const transformed *)solid;
    double moved[QNI_SOLID_BLOCK][3];
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        for (int64_t i = 0; i < block; ++i)
            apply(t->inverse, points[first + i], moved[i]);
        QN_TRY(t->part->ops->gradients(t->part, block, (const double(*)[3])moved,
                                       gradients ? gradients + first : NULL,
                                       owners ? owners + first : NULL));
        for (int64_t i = 0; gradients && i < block; ++i)
            turn_back(t, gradients[first + i]);
    }
    return QN_OK;
}

/* The box that holds the image of a box, with room for rounding. */
static qni_box image(const double m[3][4], const qni_box *box) {
    qni_box out;
    for (int row = 0; row < 3; ++row) {
        double low = m[row][3], high = m[row][3], size = fabs(m[row][3]);
        for (int k = 0; k < 3; ++k) {
            if (m[row][k] == 0)
                continue;
            double a = m[row][k] * box->low[k], b = m[row][k] * box->high[k];
            low += a < b ? a : b;
            high += a < b ? b : a;
            size += qni_max(fabs(a), fabs(b));
        }
        double slack = size < QNI_INFINITY ? 4 * QNI_EPSILON * size : 0;
        out.low[row] = low - slack;
        out.high[row] = high + slack;
    }
    return out;
}

static qn_status transform_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const transformed *t = (const transformed *)solid;
    qni_box moved = image(t->inverse, box);
    return t->part->ops->bounds(t->part, &moved, range);
}

static bool transform_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const transformed *t = (const transformed *)solid;
    const qni_box moved = image(t->inverse, box);
    double inner[3][2];
    if (!t->part->ops->slopes || !t->part->ops->slopes(t->part, &moved, inner))
        return false;
    for (int k = 0; k < 3; ++k) {
        ranges[k][0] = ranges[k][1] = 0;
        for (int row = 0; row < 3; ++row) {
            const double factor = t->inverse[row][k];
            if (factor == 0)
                continue;
            ranges[k][0] += factor * inner[row][factor < 0];
            ranges[k][1] += factor * inner[row][factor > 0];
        }
    }
    return true;
}

static qn_status transform_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                     int32_t capacity, qni_crossing *crossings,
                                     int32_t *count_out) {
    const transformed *t = (const transformed *)solid;
    double from[3], to[3];
    apply(t->inverse, a, from);
    apply(t->inverse, b, to);
    QN_TRY(t->part->ops->crossings(t->part, from, to, capacity, crossings, count_out));
    for (int32_t i = 0; i < *count_out; ++i) {
        double out[3];
        for (int k = 0; k < 3; ++k)
            out[k] = crossings[i].enters ? a[k] - b[k] : b[k] - a[k];
        qni_unit(out, (const double[3]){1, 0, 0}, out);
        turn_back(t, crossings[i].normal);
        qni_unit(crossings[i].normal, out, crossings[i].normal);
    }
    return QN_OK;
}

static qn_status transform_restrict(const qn_solid *solid, const qni_box *box,
                                    qn_solid **solid_out) {
    const transformed *t = (const transformed *)solid;
    qni_box moved = image(t->inverse, box);
    qn_solid *part;
    *solid_out = NULL;
    QN_TRY(t->part->ops->restrict_to(t->part, &moved, &part));
    if (part == t->part)
        *solid_out = qni_solid_retain(solid);
    else
        *solid_out = qni_transform_create(solid->context, part, t->inverse, NULL, &solid->box);
    qn_solid_destroy(part);
    return *solid_out ? QN_OK : QN_ERROR_OUT_OF_MEMORY;
}

static const qni_solid_ops transform_ops = {
    .destroy = destroy,
    .values = transform_values,
    .gradients = transform_gradients,
    .bounds = transform_bounds,
    .crossings = transform_crossings,
    .restrict_to = transform_restrict,
    .slopes = transform_slopes,
};

/* a after b. */
static void multiply(const double a[3][4], const double b[3][4], double out[3][4]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j)
            out[i][j] =
                a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + (j == 3 ? a[i][3] : 0);
}

/* Invertible transforms go down to the leaves, where polytopes take them up into their planes:
 * cheaper to evaluate, and with bounds as tight as those of upright ones. Other kinds leave
 * *done_out false. */
static qn_solid *pushed_down(qn_context *context, const qn_solid *part, const double inverse[3][4],
                             const double forward[3][4], bool *done_out) {
    *done_out = true;
    if (part->ops == &transform_ops && ((const transformed *)part)->invertible) {
        const transformed *inner = (const transformed *)part;
        double both[3][4], both_inverse[3][4];
        multiply(inner->inverse, inverse, both_inverse);
        if (qni_invert((const double(*)[4])both_inverse, both))
            return qni_transform_create(context, inner->part, (const double(*)[4])both_inverse,
                                        (const double(*)[4])both, NULL);
    }
    qn_solid *solid = qni_polytope_transformed(context, part, inverse, forward, done_out);
    if (!*done_out)
        solid = qni_combine_transformed(context, part, inverse, forward, done_out);
    return solid;
}

qni_box qni_box_image(const double matrix[3][4], const qni_box *box) {
    if (qni_box_is_nothing(box))
        return qni_box_nothing();
    qni_box out = image(matrix, box);
    for (int k = 0; k < 3; ++k) /* infinity less infinity */
        if (out.low[k] != out.low[k] || out.high[k] != out.high[k])
            return qni_box_everything();
    return out;
}

qn_solid *qni_transform_create(qn_context *context, const qn_solid *part,
                               const double inverse[3][4], const double forward[3][4],
                               const qni_box *box) {
    if (forward) {
        bool done;
        qn_solid *solid = pushed_down(context, part, inverse, forward, &done);
        if (done)
            return solid;
    }
    transformed *t = (transformed *)qni_solid_new(context, sizeof *t, &transform_ops);
    if (!t)
        return NULL;
    t->part = qni_solid_retain(part);
    memcpy(t->inverse, inverse, sizeof t->inverse);
    t->base.depth = part->depth + 1;
    t->base.weight = part->weight;
    t->base.narrows = part->narrows;
    t->invertible = forward;
    t->base.box = forward ? qni_box_image(forward, &part->box) : *box;
    return &t->base;
}

bool qni_invert(const double m[3][4], double inverse[3][4]) {
    double adjoint[3][3], determinant = 0, size = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            int r = (j + 1) % 3, s = (j + 2) % 3, u = (i + 1) % 3, v = (i + 2) % 3;
            adjoint[i][j] = m[r][u] * m[s][v] - m[r][v] * m[s][u];
            size = qni_max(size, fabs(m[i][j]));
        }
    for (int k = 0; k < 3; ++k)
        determinant += m[0][k] * adjoint[k][0];
    if (!(fabs(determinant) > 1e-12 * size * size * size))
        return false;
    for (int i = 0; i < 3; ++i) {
        inverse[i][3] = 0;
        for (int j = 0; j < 3; ++j) {
            inverse[i][j] = adjoint[i][j] / determinant;
            inverse[i][3] -= inverse[i][j] * m[j][3];
        }
        for (int j = 0; j < 4; ++j)
            if (!isfinite(inverse[i][j]))
                return false;
    }
    return true;
}
