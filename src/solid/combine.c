// SPDX-License-Identifier: MIT
/* Booleans of any number of parts: union is the least value, intersection the largest, a part that
 * is taken away counts with its sign turned. The active part gives gradient and owner. Crossings
 * are those of the parts, in order, where the combination changes sides. */
#include "solid/primitives.h"

#include <math.h>
#include <string.h>

/* Everything is done as a union: an intersection is the complement of the union of the complements.
 */
typedef struct combination {
    qn_solid base;
    double sign; /* 1: union, -1: intersection */
    qn_solid **parts;
    double *signs; /* of the parts, in that union */
    int64_t count;
} combination;

static void destroy(qn_solid *solid) {
    combination *c = (combination *)solid;
    for (int64_t n = 0; c->parts && n < c->count; ++n)
        qn_solid_destroy(c->parts[n]);
    qni_free(solid->context, c->parts, c->count, sizeof *c->parts);
    qni_free(solid->context, c->signs, c->count, sizeof *c->signs);
    qni_solid_free(solid, sizeof *c);
}

/* A value of 0 is outside: so with the sign turned it is inside. */
static inline double turned(double value, double sign) {
    return sign > 0 ? value : value == 0 ? -QNI_TIE : -value;
}

/* Of one block: the least value, and which part gives it. */
static qn_status least(const combination *c, int64_t count, const double (*points)[3],
                       double *values, int64_t *active) {
    double each[QNI_SOLID_BLOCK];
    for (int64_t i = 0; i < count; ++i)
        values[i] = QNI_INFINITY;
    for (int64_t i = 0; active && i < count; ++i)
        active[i] = 0;
    for (int64_t n = 0; n < c->count; ++n) {
        QN_TRY(c->parts[n]->ops->values(c->parts[n], count, points, each));
        for (int64_t i = 0; i < count; ++i) {
            double value = turned(each[i], c->signs[n]);
            if (active && value < values[i])
                active[i] = n;
            values[i] = value < values[i] ? value : values[i];
        }
    }
    for (int64_t i = 0; i < count; ++i)
        values[i] = turned(values[i], c->sign);
    return QN_OK;
}

static qn_status combine_values(const qn_solid *solid, int64_t count, const double (*points)[3],
                                double *values) {
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        QN_TRY(least((const combination *)solid, block, points + first, values + first, NULL));
    }
    return QN_OK;
}

static bool holds(const qni_box *box, const double point[3]) {
    bool held = true;
    for (int k = 0; k < 3; ++k)
        held = held && box->low[k] <= point[k] && point[k] <= box->high[k];
    return held;
}

/* The signs of the values, from those of the parts. */
static qn_status combine_inside(const qn_solid *solid, int64_t count, const double (*points)[3],
                                bool *inside) {
    const combination *c = (const combination *)solid;
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        bool each[QNI_SOLID_BLOCK], any[QNI_SOLID_BLOCK] = {false};
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        bool all = false;
        for (int64_t n = 0; n < c->count && !all; ++n) {
            each[0] = false;
            if (block > 1 || holds(&c->parts[n]->box, points[first]))
                QN_TRY(qni_solid_inside(c->parts[n], block, points + first, each));
            all = true;
            for (int64_t i = 0; i < block; ++i) {
                any[i] = any[i] || each[i] == (c->signs[n] > 0);
                all = all && any[i];
            }
        }
        for (int64_t i = 0; i < block; ++i)
            inside[first + i] = any[i] == (c->sign > 0);
    }
    return QN_OK;
}

/* The gradients of the points of one block for which part n is active: gathered, asked for at once,
 * put back. */
static qn_status part_gradients(const combination *c, int64_t n, int64_t count,
                                const double (*points)[3], const int64_t *active,
                                double (*gradients)[3], int32_t *owners) {
    double near[QNI_SOLID_BLOCK][3], found[QNI_SOLID_BLOCK][3];
    int32_t found_owners[QNI_SOLID_BLOCK];
    int64_t places[QNI_SOLID_BLOCK], used = 0;
    for (int64_t i = 0; i < count; ++i)
        if (active[i] == n) {
            memcpy(near[used], points[i], sizeof near[used]);
            places[used++] = i;
        }
    if (used == 0)
        return QN_OK;
    QN_TRY(c->parts[n]->ops->gradients(c->parts[n], used, (const double(*)[3])near,
                                       gradients ? found : NULL, owners ? found_owners : NULL));
    for (int64_t i = 0; i < used; ++i) {
        for (int k = 0; gradients && k < 3; ++k)
            gradients[places[i]][k] = c->sign * c->signs[n] * found[i][k];
        if (owners)
            owners[places[i]] = found_owners[i];
    }
    return QN_OK;
}

static qn_status combine_gradients(const qn_solid *solid, int64_t count, const double (*points)[3],
                                   double (*gradients)[3], int32_t *owners) {
    const combination *c = (const combination *)solid;
    double values[QNI_SOLID_BLOCK];
    int64_t active[QNI_SOLID_BLOCK];
    for (int64_t first = 0; first < count; first += QNI_SOLID_BLOCK) {
        int64_t block = count - first < QNI_SOLID_BLOCK ? count - first : QNI_SOLID_BLOCK;
        QN_TRY(least(c, block, points + first, values, active));
        for (int64_t n = 0; n < c->count; ++n)
            QN_TRY(part_gradients(c, n, block, points + first, active,
                                  gradients ? gradients + first : NULL,
                                  owners ? owners + first : NULL));
    }
    return QN_OK;
}

/* Bounds of a part in the union. A tie may be of either sign. */
static qn_status part_bounds(const combination *c, int64_t n, const qni_box *box, double range[2]) {
    double each[2];
    QN_TRY(c->parts[n]->ops->bounds(c->parts[n], box, each));
    range[0] = c->signs[n] > 0 ? each[0] : -each[1] - QNI_TIE;
    range[1] = c->signs[n] > 0 ? each[1] : -each[0];
    return QN_OK;
}

static qn_status combine_bounds(const qn_solid *solid, const qni_box *box, double range[2]) {
    const combination *c = (const combination *)solid;
    double low = QNI_INFINITY, high = QNI_INFINITY, each[2];
    for (int64_t n = 0; n < c->count; ++n) {
        QN_TRY(part_bounds(c, n, box, each));
        low = qni_min(low, each[0]);
        high = qni_min(high, each[1]);
    }
    range[0] = c->sign > 0 ? low : -high - QNI_TIE;
    range[1] = c->sign > 0 ? high : -low;
    return QN_OK;
}

/* Any part may be the active one. */
static bool combine_slopes(const qn_solid *solid, const qni_box *box, double ranges[3][2]) {
    const combination *c = (const combination *)solid;
    for (int k = 0; k < 3; ++k) {
        ranges[k][0] = QNI_INFINITY;
        ranges[k][1] = -QNI_INFINITY;
    }
    for (int64_t n = 0; n < c->count; ++n) {
        const qn_solid *part = c->parts[n];
        double each[3][2];
        if (!part->ops->slopes || !part->ops->slopes(part, box, each))
            return false;
        const bool turned_round = c->signs[n] * c->sign < 0;
        for (int k = 0; k < 3; ++k) {
            ranges[k][0] = qni_min(ranges[k][0], turned_round ? -each[k][1] : each[k][0]);
            ranges[k][1] = qni_max(ranges[k][1], turned_round ? -each[k][0] : each[k][1]);
        }
    }
    return true;
}

/* Crossings of one solid on the segment, and on which side it begins. */
typedef struct row {
    qni_crossing crossings[QNI_CROSSINGS];
    int32_t count;
    bool inside;
} row;

static void turn(row *line) {
    line->inside = !line->inside;
    for (int32_t i = 0; i < line->count; ++i) {
        qni_crossing *crossing = &line->crossings[i];
        crossing->enters = !crossing->enters;
        for (int k = 0; k < 3; ++k)
            crossing->normal[k] = -crossing->normal[k];
    }
}

static qn_status part_row(const combination *c, int64_t n, const double a[3], const double b[3],
                          const qni_box *box, row *line) {
    const qn_solid *part = c->parts[n];
    line->count = 0;
    line->inside = false;
    if (qni_boxes_meet(&part->box, box)) {
        QN_TRY(part->ops->crossings(part, a, b, QNI_CROSSINGS, line->crossings, &line->count));
        if (line->count > 0)
            line->inside = !line->crossings[0].enters;
        else
            QN_TRY(qni_solid_contains(part, a, &line->inside));
    }
    if (c->signs[n] < 0)
        turn(line);
    return QN_OK;
}

/* One crossing of the place at hand; of several with one direction the first stands for all. */
static void note(const qni_crossing *crossing, bool *inside, const qni_crossing **enters,
                 const qni_crossing **leaves) {
    const qni_crossing **first = crossing->enters ? enters : leaves;
    *inside = crossing->enters;
    *first = *first ? *first : crossing;
}

/* The union of two rows. Crossings nearer to each other than rounding can tell count as one place:
 * so solids that touch in a face leave no film between them. */
static void unite(const row *a, const row *b, double same, row *both) {
    int32_t i = 0, j = 0;
    bool in_a = a->inside, in_b = b->inside, inside = in_a || in_b;
    both->inside = inside;
    both->count = 0;
    while (i < a->count || j < b->count) {
        bool a_next = j == b->count || (i < a->count && a->crossings[i].at <= b->crossings[j].at);
        double place = a_next ? a->crossings[i].at : b->crossings[j].at;
        const qni_crossing *enters = NULL, *leaves = NULL;
        for (; i < a->count && a->crossings[i].at <= place + same; ++i)
            note(&a->crossings[i], &in_a, &enters, &leaves);
        for (; j < b->count && b->crossings[j].at <= place + same; ++j)
            note(&b->crossings[j], &in_b, &enters, &leaves);
        if ((in_a || in_b) == inside)
            continue;
        inside = in_a || in_b;
        if (both->count ==
            QNI_CROSSINGS) /* no room: the last two go, the signs at the ends stay true */
            both->count -= 1;
        else
            both->crossings[both->count++] = *(inside ? enters : leaves);
    }
}

/* How near two places on the segment may come by rounding. */
static double sameness(const double a[3], const double b[3]) {
    double size = 0, length = 0;
    for (int k = 0; k < 3; ++k) {
        size = qni_max(size, fabs(a[k]) + fabs(b[k]));
        length = qni_max(length, fabs(b[k] - a[k]));
    }
    return length > 0 ? qni_min(32 * QNI_EPSILON * size / length, 1e-6) : 0;
}

static qn_status combine_crossings(const qn_solid *solid, const double a[3], const double b[3],
                                   int32_t capacity, qni_crossing *crossings, int32_t *count_out) {
    const combination *c = (const combination *)solid;
    row rows[3], *sum = &rows[0], *next = &rows[1];
    sum->count = 0;
    sum->inside = false;
    qni_box box = qni_segment_box(a, b);
    double same = sameness(a, b);
    for (int64_t n = 0; n < c->count && !(sum->inside && sum->count == 0); ++n) {
        QN_TRY(part_row(c, n, a, b, &box, &rows[2]));
        if (rows[2].count == 0 && !rows[2].inside)
            continue;
        unite(sum, &rows[2], same, next);
        row *swap = sum;
        sum = next;
        next = swap;
    }
    if (c->sign < 0)
        turn(sum);
    while (sum->count > capacity)
        sum->count -= 2;
    *count_out = sum->count > 0 ? sum->count : 0;
    memcpy(crossings, sum->crossings, (size_t)*count_out * sizeof *crossings);
    return QN_OK;
}

static combination *create(qn_context *context, double sign, int64_t count);
static const qni_solid_ops combine_ops;

/* The parts of a combination in a box. Those that are much smaller in it are restricted before
 * their bounds are asked for: that costs as much as the bounds, and those of what is left next to
 * nothing, so that the parts of nested ones are not gone through once for each that they lie in. */
typedef struct local_part {
    qn_solid *restricted; /* NULL: not yet */
    double low;
    bool keep;
} local_part;

static qn_status bound_locally(const combination *c, int64_t n, const qni_box *box,
                               local_part *local, double *high) {
    const qn_solid *part = c->parts[n];
    double each[2];
    if (part->narrows) {
        QN_TRY(part->ops->restrict_to(part, box, &local->restricted));
        part = local->restricted;
    }
    QN_TRY(part->ops->bounds(part, box, each));
    local->low = c->signs[n] > 0 ? each[0] : -each[1] - QNI_TIE;
    *high = qni_min(*high, c->signs[n] > 0 ? each[1] : -each[0]);
    return QN_OK;
}

/* Those that can be the least in the box are kept. */
static qn_status mark_kept(const combination *c, const qni_box *box, local_part *locals,
                           int64_t *kept_out) {
    double high = QNI_INFINITY;
    for (int64_t n = 0; n < c->count; ++n)
        QN_TRY(bound_locally(c, n, box, &locals[n], &high));
    *kept_out = 0;
    for (int64_t n = 0; n < c->count; ++n) {
        locals[n].keep = locals[n].low <= high;
        *kept_out += locals[n].keep;
    }
    if (*kept_out == 0) { /* all are infinite: any one will do */
        locals[0].keep = true;
        *kept_out = 1;
    }
    return QN_OK;
}

static qn_status restrict_kept(const combination *c, const qni_box *box, local_part *locals,
                               bool *changed_out) {
    for (int64_t n = 0; n < c->count; ++n) {
        if (locals[n].keep && !locals[n].restricted)
            QN_TRY(c->parts[n]->ops->restrict_to(c->parts[n], box, &locals[n].restricted));
        *changed_out = *changed_out || !locals[n].keep || locals[n].restricted != c->parts[n];
    }
    return QN_OK;
}

/* A union among the parts of a union gives its own parts instead: the least value is the same. */
static const combination *as_inner_union(const combination *c, int64_t n, const qn_solid *part) {
    const combination *inner = (const combination *)part;
    return part->ops == &combine_ops && c->sign > 0 && c->signs[n] > 0 && inner->sign > 0 ? inner
                                                                                          : NULL;
}

static void add_part(combination *smaller, int64_t *used, qn_solid *part, double sign) {
    smaller->parts[*used] = qni_solid_retain(part);
    smaller->base.weight += part->weight;
    smaller->signs[(*used)++] = sign;
}

static combination *join_kept(const combination *c, const local_part *locals) {
    int64_t count = 0, used = 0;
    for (int64_t n = 0; n < c->count; ++n) {
        const combination *inner =
            locals[n].keep ? as_inner_union(c, n, locals[n].restricted) : NULL;
        count += inner ? inner->count : locals[n].keep;
    }
    combination *smaller = create(c->base.context, c->sign, count);
    for (int64_t n = 0; smaller && n < c->count; ++n) {
        const combination *inner =
            locals[n].keep ? as_inner_union(c, n, locals[n].restricted) : NULL;
        for (int64_t m = 0; inner && m < inner->count; ++m)
            add_part(smaller, &used, inner->parts[m], inner->signs[m]);
        if (!inner && locals[n].keep)
            add_part(smaller, &used, locals[n].restricted, c->signs[n]);
    }
    return smaller;
}

static qn_status take_kept(const combination *c, const qni_box *box, local_part *locals,
                           int64_t kept, qn_solid **solid_out) {
    bool changed = kept != c->count;
    QN_TRY(restrict_kept(c, box, locals, &changed));
    if (!changed) {
        *solid_out = qni_solid_retain(&c->base);
        return QN_OK;
    }
    combination *smaller = join_kept(c, locals);
    if (!smaller)
        return QN_ERROR_OUT_OF_MEMORY;
    smaller->base.box = c->base.box;
    smaller->base.depth = c->base.depth;
    const bool alone = smaller->count == 1 && smaller->signs[0] * c->sign > 0;
    *solid_out = qni_solid_retain(alone ? smaller->parts[0] : &smaller->base);
    qn_solid_destroy(&smaller->base);
    return QN_OK;
}

static qn_status combine_restrict(const qn_solid *solid, const qni_box *box, qn_solid **solid_out) {
    const combination *c = (const combination *)solid;
    *solid_out = NULL;
    local_part *locals = qni_alloc_zero(solid->context, c->count, sizeof *locals);
    if (!locals)
        return QN_ERROR_OUT_OF_MEMORY;
    int64_t kept;
    qn_status status = mark_kept(c, box, locals, &kept);
    if (status == QN_OK)
        status = take_kept(c, box, locals, kept, solid_out);
    for (int64_t n = 0; n < c->count; ++n)
        qn_solid_destroy(locals[n].restricted);
    qni_free(solid->context, locals, c->count, sizeof *locals);
    return status;
}

static const qni_solid_ops combine_ops = {
    .destroy = destroy,
    .values = combine_values,
    .gradients = combine_gradients,
    .bounds = combine_bounds,
    .crossings = combine_crossings,
    .restrict_to = combine_restrict,
    .slopes = combine_slopes,
    .inside = combine_inside,
};

static combination *create(qn_context *context, double sign, int64_t count) {
    combination *c = (combination *)qni_solid_new(context, sizeof *c, &combine_ops);
    if (!c)
        return NULL;
    c->sign = sign;
    c->count = count;
    c->base.weight = 0; /* until its parts are known */
    c->base.narrows = true;
    c->parts = qni_alloc_zero(context, count, sizeof *c->parts);
    c->signs = qni_alloc_zero(context, count, sizeof *c->signs);
    if (c->parts && c->signs)
        return c;
    destroy(&c->base);
    return NULL;
}

/* The union's box holds all parts; the intersection's lies in each one that is not taken away. */
static qni_box box_of(bool intersect, int64_t count, qn_solid *const *parts, const bool *minus) {
    qni_box box = qni_box_everything();
    bool first = true;
    for (int64_t n = 0; n < count; ++n) {
        bool less = minus && minus[n];
        if (less && intersect)
            continue;
        qni_box part = less ? qni_box_everything() : parts[n]->box;
        bool nothing = qni_box_is_nothing(&part);
        if (nothing && intersect)
            return qni_box_nothing();
        if (nothing)
            continue;
        for (int k = 0; k < 3; ++k) {
            bool take_low =
                first || (intersect ? part.low[k] > box.low[k] : part.low[k] < box.low[k]);
            bool take_high =
                first || (intersect ? part.high[k] < box.high[k] : part.high[k] > box.high[k]);
            box.low[k] = take_low ? part.low[k] : box.low[k];
            box.high[k] = take_high ? part.high[k] : box.high[k];
        }
        first = false;
    }
    if ((first && !intersect) || qni_box_is_nothing(&box))
        return qni_box_nothing();
    return box;
}

qn_solid *qni_combine_create(qn_context *context, bool intersect, int64_t count,
                             qn_solid *const *parts, const bool *minus) {
    if (count == 0)
        return qni_empty_create(context);
    if (count == 1 && !(minus && minus[0]))
        return qni_solid_retain(parts[0]);
    combination *c = create(context, intersect ? -1 : 1, count);
    if (!c)
        return NULL;
    for (int64_t n = 0; n < count; ++n) {
        c->parts[n] = qni_solid_retain(parts[n]);
        c->signs[n] = minus && minus[n] ? -c->sign : c->sign;
        c->base.weight += parts[n]->weight;
        if (c->base.depth <= parts[n]->depth)
            c->base.depth = parts[n]->depth + 1;
    }
    c->base.box = box_of(intersect, count, parts, minus);
    return &c->base;
}

qn_solid *qni_combine_transformed(qn_context *context, const qn_solid *part,
                                  const double inverse[3][4], const double forward[3][4],
                                  bool *done_out) {
    const combination *c = (const combination *)part;
    *done_out = part->ops == &combine_ops;
    if (!*done_out)
        return NULL;
    combination *moved = create(context, c->sign, c->count);
    for (int64_t n = 0; moved && n < c->count; ++n) {
        moved->parts[n] = qni_transform_create(context, c->parts[n], inverse, forward, NULL);
        moved->signs[n] = c->signs[n];
        if (!moved->parts[n]) {
            destroy(&moved->base);
            return NULL;
        }
        moved->base.weight += moved->parts[n]->weight;
        if (moved->base.depth <= moved->parts[n]->depth)
            moved->base.depth = moved->parts[n]->depth + 1;
    }
    if (moved)
        moved->base.box = qni_box_image(forward, &part->box);
    return moved ? &moved->base : NULL;
}
