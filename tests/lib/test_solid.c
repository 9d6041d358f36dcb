// SPDX-License-Identifier: MIT
#include "lib/test_solid.h"
#include "core/context.h"

#include <math.h>

typedef enum body_kind { PLANE, SPHERE, CYLINDER, CONE, TORUS, LEAST, MOST } body_kind;

typedef struct body {
    qn_solid solid;
    body_kind kind;
    int32_t owner;
    test_frame frame;
    double size[2];
    bool complement; /* f -> -f */
    struct body *parts[2];
} body;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void to_body(const body *b, const double p[3], double q[3]) {
    const double d[3] = {p[0] - b->frame.origin[0], p[1] - b->frame.origin[1],
                         p[2] - b->frame.origin[2]};
    for (int k = 0; k < 3; ++k)
        q[k] = dot(b->frame.turn[k], d);
}

/* Value, gradient (may be NULL) and owner of the active branch. All are 1-Lipschitz. */
static double evaluate(const body *b, const double p[3], double gradient[3], int32_t *owner) {
    if (b->kind == LEAST || b->kind == MOST) {
        double other[3];
        int32_t other_owner;
        const double x = evaluate(b->parts[0], p, gradient, owner),
                     y = evaluate(b->parts[1], p, other, &other_owner);
        const bool first = b->kind == LEAST ? x <= y : x >= y;
        if (!first) {
            if (gradient)
                memcpy(gradient, other, sizeof other);
            *owner = other_owner;
        }
        return first ? x : y;
    }
    double q[3], g[3] = {0, 0, 0}, value = 0;
    to_body(b, p, q);
    const double r = hypot(q[0], q[1]), safe = r > 0 ? r : 1;
    switch (b->kind) {
    case PLANE:
        value = q[2];
        g[2] = 1;
        break;
    case SPHERE: {
        const double length = sqrt(dot(q, q));
        value = length - b->size[0];
        for (int k = 0; k < 3; ++k)
            g[k] = length > 0 ? q[k] / length : 0;
        break;
    }
    case CYLINDER:
        value = r - b->size[0];
        g[0] = q[0] / safe;
        g[1] = q[1] / safe;
        break;
    case CONE:
        value = r * cos(b->size[0]) + q[2] * sin(b->size[0]);
        g[0] = q[0] / safe * cos(b->size[0]);
        g[1] = q[1] / safe * cos(b->size[0]);
        g[2] = sin(b->size[0]);
        break;
    default: {
        const double across = r - b->size[0], length = hypot(across, q[2]);
        value = length - b->size[1];
        const double share = length > 0 ? across / length : 0;
        g[0] = share * q[0] / safe;
        g[1] = share * q[1] / safe;
        g[2] = length > 0 ? q[2] / length : 0;
    }
    }
    const double sign = b->complement ? -1 : 1;
    if (gradient)
        for (int k = 0; k < 3; ++k)
            gradient[k] = sign * (g[0] * b->frame.turn[0][k] + g[1] * b->frame.turn[1][k] +
                                  g[2] * b->frame.turn[2][k]);
    *owner = b->owner;
    return sign * value;
}

static void destroy(qn_solid *solid) {
    body *b = (body *)solid;
    for (int k = 0; k < 2; ++k)
        if (b->parts[k])
            qn_solid_destroy(&b->parts[k]->solid);
    qni_free(solid->context, b, 1, sizeof *b);
}

static qn_status values(const qn_solid *solid, int64_t count, const double (*points)[3],
                        double *out) {
    int32_t owner;
    for (int64_t n = 0; n < count; ++n)
        out[n] = evaluate((const body *)solid, points[n], NULL, &owner);
    return QN_OK;
}

static qn_status gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                           double (*out)[3], int32_t *owners) {
    for (int64_t n = 0; n < count; ++n) {
        double gradient[3];
        int32_t owner;
        evaluate((const body *)solid, points[n], gradient, &owner);
        if (out)
            memcpy(out[n], gradient, sizeof gradient);
        if (owners)
            owners[n] = owner;
    }
    return QN_OK;
}

static qn_status bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    double middle[3], half = 0;
    int32_t owner;
    for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (box->low[k] + box->high[k]);
        half += 0.25 * (box->high[k] - box->low[k]) * (box->high[k] - box->low[k]);
    }
    const double value = evaluate((const body *)solid, middle, NULL, &owner),
                 reach = sqrt(half) * (1 + 1e-12) + 1e-12;
    range[0] = value - reach;
    range[1] = value + reach;
    return QN_OK;
}

enum { MOST_ROOTS = 512, TORUS_STEPS = 256 };

typedef struct root {
    double at;
    const body *body;
} root;

typedef struct roots {
    root items[MOST_ROOTS];
    int count;
} roots;

static void add_root(roots *list, const body *b, double at) {
    if (at >= 0 && at <= 1 && list->count < MOST_ROOTS) {
        list->items[list->count].at = at;
        list->items[list->count++].body = b;
    }
}

/* a t^2 + 2 b t + c = 0, without cancellation. */
static void add_quadratic(roots *list, const body *owner, double a, double b, double c) {
    const double discriminant = b * b - a * c;
    if (!(discriminant >= 0))
        return;
    const double q = -(b + copysign(sqrt(discriminant), b));
    if (a != 0)
        add_root(list, owner, q / a);
    if (q != 0)
        add_root(list, owner, c / q);
}

static void along(const double a[3], const double b[3], double t, double p[3]) {
    for (int k = 0; k < 3; ++k)
        p[k] = a[k] + t * (b[k] - a[k]);
}

static void torus_roots(roots *list, const body *torus, const double a[3], const double b[3]) {
    int32_t owner;
    double p[3], before = evaluate(torus, a, NULL, &owner);
    for (int n = 1; n <= TORUS_STEPS; ++n) {
        along(a, b, (double)n / TORUS_STEPS, p);
        const double now = evaluate(torus, p, NULL, &owner);
        if ((before < 0) != (now < 0)) {
            double low = (double)(n - 1) / TORUS_STEPS, high = (double)n / TORUS_STEPS;
            for (int step = 0; step < 60; ++step) {
                const double middle = 0.5 * (low + high);
                along(a, b, middle, p);
                if ((evaluate(torus, p, NULL, &owner) < 0) == (before < 0))
                    low = middle;
                else
                    high = middle;
            }
            add_root(list, torus, low);
        }
        before = now;
    }
}

static void find_roots(roots *list, const body *b, const double from[3], const double to[3]) {
    if (b->kind == LEAST || b->kind == MOST) {
        find_roots(list, b->parts[0], from, to);
        find_roots(list, b->parts[1], from, to);
        return;
    }
    double p[3], q[3], d[3];
    to_body(b, from, p);
    to_body(b, to, q);
    for (int k = 0; k < 3; ++k)
        d[k] = q[k] - p[k];
    const double tangent = b->kind == CONE ? tan(b->size[0]) : 0;
    switch (b->kind) {
    case PLANE:
        if (d[2] != 0)
            add_root(list, b, -p[2] / d[2]);
        break;
    case SPHERE:
        add_quadratic(list, b, dot(d, d), dot(p, d), dot(p, p) - b->size[0] * b->size[0]);
        break;
    case CYLINDER:
        add_quadratic(list, b, d[0] * d[0] + d[1] * d[1], p[0] * d[0] + p[1] * d[1],
                      p[0] * p[0] + p[1] * p[1] - b->size[0] * b->size[0]);
        break;
    case CONE:
        add_quadratic(list, b, d[0] * d[0] + d[1] * d[1] - tangent * tangent * d[2] * d[2],
                      p[0] * d[0] + p[1] * d[1] - tangent * tangent * p[2] * d[2],
                      p[0] * p[0] + p[1] * p[1] - tangent * tangent * p[2] * p[2]);
        break;
    default:
        torus_roots(list, b, from, to);
    }
}

static int compare_roots(const void *a, const void *b) {
    const double p = ((const root *)a)->at, q = ((const root *)b)->at;
    return p < q ? -1 : p > q;
}

static qn_status crossings(const qn_solid *solid, const double a[3], const double b[3],
                           int32_t capacity, qni_crossing *out, int32_t *count_out) {
    roots list;
    list.count = 0;
    find_roots(&list, (const body *)solid, a, b);
    qsort(list.items, (size_t)list.count, sizeof *list.items, compare_roots);
    int32_t owner, count = 0;
    bool inside = evaluate((const body *)solid, a, NULL, &owner) < 0;
    const bool end = evaluate((const body *)solid, b, NULL, &owner) < 0;
    for (int n = 0; n < list.count; ++n) {
        double p[3];
        const double next = n + 1 < list.count ? list.items[n + 1].at : 1;
        along(a, b, 0.5 * (list.items[n].at + next), p);
        const bool then =
            n + 1 < list.count ? evaluate((const body *)solid, p, NULL, &owner) < 0 : end;
        if (then == inside || count >= capacity)
            continue;
        qni_crossing *crossing = &out[count++];
        along(a, b, list.items[n].at, p);
        evaluate(list.items[n].body, p, crossing->normal, &crossing->owner);
        crossing->at = list.items[n].at;
        crossing->enters = then;
        inside = then;
    }
    *count_out = count;
    return QN_OK;
}

static qn_status restrict_to(const qn_solid *solid, const qni_box *box, qn_solid **out) {
    (void)box;
    *out = qni_solid_retain(solid);
    return QN_OK;
}

static const qni_solid_ops ops = {
    .destroy = destroy,
    .values = values,
    .gradients = gradients,
    .bounds = bounds,
    .crossings = crossings,
    .restrict_to = restrict_to,
};

static body *new_body(qn_context *context, body_kind kind, const test_frame *frame, double first,
                      double second, int32_t owner) {
    body *b = qni_alloc_zero(context, 1, sizeof *b);
    assert_non_null(b);
    b->solid.ops = &ops;
    b->solid.context = context;
    b->solid.references = 1;
    for (int k = 0; k < 3; ++k) {
        b->solid.box.low[k] = -1;
        b->solid.box.high[k] = 1;
    }
    b->kind = kind;
    if (frame)
        b->frame = *frame;
    b->size[0] = first;
    b->size[1] = second;
    b->owner = owner;
    return b;
}

test_frame test_frame_at(double x, double y, double z) {
    test_frame frame = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {x, y, z}};
    return frame;
}

static test_frame frame_along(const double z_axis[3], const double origin[3]) {
    const double length = sqrt(dot(z_axis, z_axis));
    test_frame f;
    for (int k = 0; k < 3; ++k) {
        f.turn[2][k] = z_axis[k] / length;
        f.origin[k] = origin[k];
    }
    const int least = fabs(f.turn[2][0]) < 0.6 ? 0 : 1;
    double x[3] = {least == 0, least == 1, 0}, size = 0;
    const double share = x[0] * f.turn[2][0] + x[1] * f.turn[2][1];
    for (int k = 0; k < 3; ++k) {
        x[k] -= share * f.turn[2][k];
        size += x[k] * x[k];
    }
    for (int k = 0; k < 3; ++k)
        f.turn[0][k] = x[k] / sqrt(size);
    for (int k = 0; k < 3; ++k)
        f.turn[1][k] = f.turn[2][(k + 1) % 3] * f.turn[0][(k + 2) % 3] -
                       f.turn[2][(k + 2) % 3] * f.turn[0][(k + 1) % 3];
    return f;
}

test_frame test_random_frame(test_random *random, double spread) {
    double axis[3], origin[3];
    for (int k = 0; k < 3; ++k) {
        axis[k] = test_random_gaussian(random);
        origin[k] = spread * (2 * test_random_unit(random) - 1);
    }
    test_frame f = frame_along(axis, origin), turned = f;
    const double angle = 6.283185307179586 * test_random_unit(random);
    for (int k = 0; k < 3; ++k) {
        turned.turn[0][k] = cos(angle) * f.turn[0][k] + sin(angle) * f.turn[1][k];
        turned.turn[1][k] = cos(angle) * f.turn[1][k] - sin(angle) * f.turn[0][k];
    }
    return turned;
}

qn_solid *test_plane(qn_context *context, const double normal[3], double offset, int32_t owner) {
    const double length2 = dot(normal, normal);
    const double origin[3] = {normal[0] * offset / length2, normal[1] * offset / length2,
                              normal[2] * offset / length2};
    const test_frame frame = frame_along(normal, origin);
    return &new_body(context, PLANE, &frame, 0, 0, owner)->solid;
}

qn_solid *test_sphere(qn_context *context, const double centre[3], double radius, int32_t owner) {
    const test_frame frame = test_frame_at(centre[0], centre[1], centre[2]);
    return &new_body(context, SPHERE, &frame, radius, 0, owner)->solid;
}

qn_solid *test_cylinder(qn_context *context, const test_frame *frame, double radius,
                        int32_t owner) {
    return &new_body(context, CYLINDER, frame, radius, 0, owner)->solid;
}

qn_solid *test_cone(qn_context *context, const test_frame *frame, double half_angle,
                    int32_t owner) {
    return &new_body(context, CONE, frame, half_angle, 0, owner)->solid;
}

qn_solid *test_torus(qn_context *context, const test_frame *frame, double ring, double tube,
                     int32_t owner) {
    return &new_body(context, TORUS, frame, ring, tube, owner)->solid;
}

static qn_solid *join(body_kind kind, qn_solid *a, qn_solid *b) {
    body *both = new_body(a->context, kind, NULL, 0, 0, 0);
    both->parts[0] = (body *)a;
    both->parts[1] = (body *)b;
    both->solid.box = a->box;
    return &both->solid;
}

qn_solid *test_union(qn_solid *a, qn_solid *b) {
    return join(LEAST, a, b);
}

qn_solid *test_intersection(qn_solid *a, qn_solid *b) {
    return join(MOST, a, b);
}

static void turn_inside_out(body *b) {
    if (b->kind == LEAST || b->kind == MOST) {
        b->kind = b->kind == LEAST ? MOST : LEAST;
        turn_inside_out(b->parts[0]);
        turn_inside_out(b->parts[1]);
    } else {
        b->complement = !b->complement;
    }
}

qn_solid *test_difference(qn_solid *a, qn_solid *b) {
    turn_inside_out((body *)b);
    return join(MOST, a, b);
}

static qn_solid *half_space(qn_context *context, const test_frame *frame, int axis, double sign,
                            double distance, int32_t owner) {
    double normal[3], origin[3];
    for (int k = 0; k < 3; ++k) {
        normal[k] = sign * frame->turn[axis][k];
        origin[k] = frame->origin[k] + distance * normal[k];
    }
    const test_frame plane = frame_along(normal, origin);
    return &new_body(context, PLANE, &plane, 0, 0, owner)->solid;
}

qn_solid *test_box(qn_context *context, const test_frame *frame, const double half[3],
                   int32_t owner) {
    qn_solid *all = NULL;
    for (int n = 0; n < 6; ++n) {
        qn_solid *side = half_space(context, frame, n / 2, n & 1 ? 1 : -1, half[n / 2], owner + n);
        all = all ? test_intersection(all, side) : side;
    }
    return all;
}

qn_solid *test_finite_cylinder(qn_context *context, const test_frame *frame, double radius,
                               double half, int32_t owner) {
    qn_solid *round = test_cylinder(context, frame, radius, owner);
    return test_intersection(
        test_intersection(round, half_space(context, frame, 2, 1, half, owner + 1)),
        half_space(context, frame, 2, -1, half, owner + 2));
}

qn_solid *test_finite_cone(qn_context *context, const test_frame *frame, double half_angle,
                           double height, int32_t owner) {
    return test_intersection(test_cone(context, frame, half_angle, owner),
                             half_space(context, frame, 2, -1, height, owner + 1));
}

void test_solid_set_box(qn_solid *solid, double low, double high) {
    for (int k = 0; k < 3; ++k) {
        solid->box.low[k] = low;
        solid->box.high[k] = high;
    }
}

double test_solid_value(const qn_solid *solid, const double point[3]) {
    int32_t owner;
    return evaluate((const body *)solid, point, NULL, &owner);
}
