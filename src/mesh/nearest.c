// SPDX-License-Identifier: MIT
/* Nearest triangles: boxes are tried nearest first and left out when they are farther than what is
 * found. Box distances are taken in float and never too large; triangle distances in double. */
#include "mesh/nearest.h"
#include "core/context.h"
#include "core/status.h"
#include "mesh/mesh.h"

#include <float.h>
#include <math.h>

static const double largest_coordinate = 1e18; /* squares of differences stay far from overflow */

/* ---- one triangle ------------------------------------------------------------------------------
 */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void difference(const float a[3], const float b[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = (double)a[i] - (double)b[i];
}

/* Squared distance from p to a + s ab + t ac, that point being stored. */
static double finish(const double p[3], const float a[3], const double ab[3], const double ac[3],
                     double s, double t, double point[3]) {
    double squared = 0;
    for (int i = 0; i < 3; ++i) {
        point[i] = (double)a[i] + s * ab[i] + t * ac[i];
        squared += (p[i] - point[i]) * (p[i] - point[i]);
    }
    return squared;
}

/* The regions of the triangle's plane that belong to its corners, edges and inside, by the signs of
 * the projections of p on the edges (Ericson, "Real-Time Collision Detection", 2005, 5.1.5). */
double qni_triangle_distance(const double p[3], const float a[3], const float b[3],
                             const float c[3], double point[3]) {
    double ab[3], ac[3], ap[3];
    difference(b, a, ab);
    difference(c, a, ac);
    for (int i = 0; i < 3; ++i)
        ap[i] = p[i] - (double)a[i];
    const double bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac);
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    const double d3 = d1 - bb, d4 = d2 - bc, d5 = d1 - bc, d6 = d2 - cc;
    if (d1 <= 0 && d2 <= 0)
        return finish(p, a, ab, ac, 0, 0, point);
    if (d3 >= 0 && d4 <= d3)
        return finish(p, a, ab, ac, 1, 0, point);
    if (d6 >= 0 && d5 <= d6)
        return finish(p, a, ab, ac, 0, 1, point);
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0)
        return finish(p, a, ab, ac, d1 / bb, 0, point);
    if (vb <= 0 && d2 >= 0 && d6 <= 0)
        return finish(p, a, ab, ac, 0, d2 / cc, point);
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return finish(p, a, ab, ac, 1 - s, s, point);
    }
    const double sum = va + vb + vc;
    return finish(p, a, ab, ac, vb / sum, vc / sum, point);
}

void qni_nearest_normal(const qni_nearest *nearest, uint32_t triangle, double normal[3]) {
    double ab[3], ac[3];
    const float *a = qni_nearest_corner(nearest, triangle, 0);
    difference(qni_nearest_corner(nearest, triangle, 1), a, ab);
    difference(qni_nearest_corner(nearest, triangle, 2), a, ac);
    normal[0] = ab[1] * ac[2] - ab[2] * ac[1];
    normal[1] = ab[2] * ac[0] - ab[0] * ac[2];
    normal[2] = ab[0] * ac[1] - ab[1] * ac[0];
    const double length = sqrt(dot(normal, normal));
    for (int i = 0; i < 3; ++i)
        normal[i] /= length > 0 ? length : 1;
}

/* ---- the search --------------------------------------------------------------------------------
 */

typedef struct step {
    float squared;
    int level;
    int64_t row;
} step;

/* How far p is outside of an interval, less the slack. */
static inline float gap_to(float low, float high, float p, float slack) {
    const float below = low - p, above = p - high;
    const float gap = below > above ? below : above;
    return (gap > slack ? gap : slack) - slack;
}

/* Squared distances to the eight boxes, never more than the true ones. One loop without branches:
 * compilers make vectors of it. */
static inline void box_distances(const qni_box_row *restrict row, const float p[3], float slack,
                                 float squared[restrict QNI_BOX_WIDTH]) {
    const float x = p[0], y = p[1], z = p[2];
    for (int k = 0; k < QNI_BOX_WIDTH; ++k) {
        const float dx = gap_to(row->low[0][k], row->high[0][k], x, slack);
        const float dy = gap_to(row->low[1][k], row->high[1][k], y, slack);
        const float dz = gap_to(row->low[2][k], row->high[2][k], z, slack);
        squared[k] = (dx * dx + dy * dy + dz * dz) * (1 - 4 * FLT_EPSILON);
    }
}

static void try_triangle(const qni_nearest *nearest, const double p[3], uint32_t triangle,
                         qni_near *best) {
    double point[3];
    const double squared = qni_triangle_distance(p, qni_nearest_corner(nearest, triangle, 0),
                                                 qni_nearest_corner(nearest, triangle, 1),
                                                 qni_nearest_corner(nearest, triangle, 2), point);
    if (squared > best->squared || (squared == best->squared && triangle >= best->triangle))
        return;
    best->squared = squared;
    best->triangle = triangle;
    for (int i = 0; i < 3; ++i)
        best->point[i] = point[i];
}

/* The slots that may hold something nearer, nearest first. */
static int order_slots(const float squared[QNI_BOX_WIDTH], double best, int slots[QNI_BOX_WIDTH]) {
    int count = 0;
    for (int k = 0; k < QNI_BOX_WIDTH; ++k) {
        if (!((double)squared[k] <= best) || squared[k] == INFINITY)
            continue;
        int at = count++;
        for (; at > 0 && squared[slots[at - 1]] > squared[k]; --at)
            slots[at] = slots[at - 1];
        slots[at] = k;
    }
    return count;
}

/* A place as the boxes see it. */
typedef struct seen_place {
    float q[3], slack;
} seen_place;

static seen_place see(const qni_nearest *nearest, const double p[3]) {
    const float q[3] = {(float)p[0], (float)p[1], (float)p[2]};
    const float size = fabsf(q[0]) + fabsf(q[1]) + fabsf(q[2]);
    const seen_place seen = {{q[0], q[1], q[2]}, nearest->slack + 2 * FLT_EPSILON * size};
    return seen;
}

/* The slots of a row that are not farther than the limit; bit k for slot k. */
static unsigned near_slots(const qni_box_row *row, const seen_place *seen, float limit) {
    static const uint32_t bits[QNI_BOX_WIDTH] = {1, 2, 4, 8, 16, 32, 64, 128};
    float squared[QNI_BOX_WIDTH];
    box_distances(row, seen->q, seen->slack, squared);
    uint32_t mask = 0;
    for (int k = 0; k < QNI_BOX_WIDTH; ++k)
        mask |= (squared[k] <= limit && squared[k] < INFINITY) ? bits[k] : 0;
    return mask;
}

/* A limit for distances in float: not less than the one in double. */
static float limit_above(double squared) {
    return squared < 1e38 ? (float)squared * (1 + 2 * FLT_EPSILON) : INFINITY;
}

static void search_row(const qni_nearest *nearest, const double p[3], const seen_place *seen,
                       int64_t row, qni_near *best) {
    unsigned mask = near_slots(&nearest->tree.rows[0][row], seen, limit_above(best->squared));
    for (; mask; mask &= mask - 1)
        try_triangle(nearest, p, (uint32_t)(QNI_BOX_WIDTH * row + __builtin_ctz(mask)), best);
}

/* All below one row, nearest boxes first. */
static void search_below(const qni_nearest *nearest, const double p[3], const seen_place *seen,
                         int level, int64_t row, qni_near *best) {
    const qni_box_tree *tree = &nearest->tree;
    step stack[QNI_BOX_LEVELS * QNI_BOX_WIDTH];
    int depth = 0;
    stack[depth++] = (step){0, level, row};
    while (depth > 0) {
        const step s = stack[--depth];
        if ((double)s.squared > best->squared)
            continue;
        if (s.level == 0) {
            search_row(nearest, p, seen, s.row, best);
            continue;
        }
        float squared[QNI_BOX_WIDTH];
        int slots[QNI_BOX_WIDTH];
        box_distances(&tree->rows[s.level][s.row], seen->q, seen->slack, squared);
        const int count = order_slots(squared, best->squared, slots);
        for (int n = count - 1; n >= 0; --n)
            stack[depth++] =
                (step){squared[slots[n]], s.level - 1, QNI_BOX_WIDTH * s.row + slots[n]};
    }
}

qni_near qni_nearest_find(const qni_nearest *nearest, const double p[3], double limit,
                          uint32_t hint) {
    qni_near best = {limit, {0, 0, 0}, QNI_NO_TRIANGLE};
    if (nearest->tree.triangle_count == 0)
        return best;
    if (hint != QNI_NO_TRIANGLE)
        try_triangle(nearest, p, hint, &best);
    const seen_place seen = see(nearest, p);
    search_below(nearest, p, &seen, nearest->tree.levels - 1, 0, &best);
    return best;
}

/* ---- many searches near one place --------------------------------------------------------------
 */

/* The rows below those of the set that come near enough; false when they are too many. */
static bool refine(const qni_nearest *nearest, const seen_place *seen, float limit,
                   qni_near_set *set) {
    const qni_box_tree *tree = &nearest->tree;
    int64_t finer[QNI_NEAR_ROWS];
    int count = 0;
    for (int n = 0; n < set->count; ++n)
        for (unsigned mask = near_slots(&tree->rows[set->level][set->rows[n]], seen, limit); mask;
             mask &= mask - 1) {
            if (count == QNI_NEAR_ROWS)
                return false;
            finer[count++] = QNI_BOX_WIDTH * set->rows[n] + __builtin_ctz(mask);
        }
    set->count = count;
    --set->level;
    for (int n = 0; n < count; ++n)
        set->rows[n] = finer[n];
    return true;
}

/* The boxes of the set's rows, from the level above; none is left out of a set of the root. */
static void fetch_boxes(const qni_nearest *nearest, qni_near_set *set) {
    const qni_box_tree *tree = &nearest->tree;
    const bool is_root = set->level == tree->levels - 1;
    const int room = (set->count + QNI_BOX_WIDTH - 1) / QNI_BOX_WIDTH * QNI_BOX_WIDTH;
    for (int n = 0; n < room; ++n) {
        qni_box_row *to = &set->boxes[n / QNI_BOX_WIDTH];
        const int slot = n % QNI_BOX_WIDTH;
        for (int i = 0; i < 3; ++i) {
            to->low[i][slot] = n < set->count ? -INFINITY : INFINITY;
            to->high[i][slot] = n < set->count ? INFINITY : -INFINITY;
            if (n >= set->count || is_root)
                continue;
            const int64_t row = set->rows[n];
            const qni_box_row *from = &tree->rows[set->level + 1][row / QNI_BOX_WIDTH];
            to->low[i][slot] = from->low[i][row % QNI_BOX_WIDTH];
            to->high[i][slot] = from->high[i][row % QNI_BOX_WIDTH];
        }
    }
}

void qni_nearest_gather(const qni_nearest *nearest, const double centre[3], double limit,
                        qni_near_set *set) {
    const seen_place seen = see(nearest, centre);
    const float most = limit_above(limit);
    set->level = nearest->tree.levels - 1;
    set->count = nearest->tree.triangle_count > 0;
    set->rows[0] = 0;
    while (set->level > 0 && refine(nearest, &seen, most, set))
        ;
    fetch_boxes(nearest, set);
}

qni_near qni_nearest_find_among(const qni_nearest *nearest, const qni_near_set *set,
                                const double p[3], double limit, uint32_t hint) {
    qni_near best = {limit, {0, 0, 0}, QNI_NO_TRIANGLE};
    if (hint != QNI_NO_TRIANGLE)
        try_triangle(nearest, p, hint, &best);
    const seen_place seen = see(nearest, p);
    for (int first = 0; first < set->count; first += QNI_BOX_WIDTH) {
        const qni_box_row *boxes = &set->boxes[first / QNI_BOX_WIDTH];
        unsigned mask = near_slots(boxes, &seen, limit_above(best.squared));
        for (; mask; mask &= mask - 1) {
            const int64_t row = set->rows[first + __builtin_ctz(mask)];
            if (set->level == 0)
                search_row(nearest, p, &seen, row, &best);
            else
                search_below(nearest, p, &seen, set->level, row, &best);
        }
    }
    return best;
}

/* ---- making it ---------------------------------------------------------------------------------
 */

/* Flags what is not finite, and finds the box of the rest. */
static void look_at_vertices(const qn_mesh *mesh, uint8_t *flags, double bounds[2][3]) {
    for (int i = 0; i < 3; ++i) {
        bounds[0][i] = INFINITY;
        bounds[1][i] = -INFINITY;
    }
    for (int64_t v = 0; v < mesh->vertex_count; ++v) {
        const float *p = mesh->positions + 3 * v;
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) {
            flags[v] = QNI_VERTEX_NONFINITE;
            continue;
        }
        for (int i = 0; i < 3; ++i) {
            bounds[0][i] = fmin(bounds[0][i], (double)p[i]);
            bounds[1][i] = fmax(bounds[1][i], (double)p[i]);
        }
    }
}

/* The box of the triangles that are there. */
static void take_box(qni_nearest *nearest) {
    const qni_box_tree *tree = &nearest->tree;
    if (tree->triangle_count == 0)
        return;
    const qni_box_row *top = &tree->rows[tree->levels - 1][0];
    for (int i = 0; i < 3; ++i) {
        nearest->low[i] = INFINITY;
        nearest->high[i] = -INFINITY;
        for (int k = 0; k < QNI_BOX_WIDTH; ++k) {
            nearest->low[i] = fmin(nearest->low[i], (double)top->low[i][k]);
            nearest->high[i] = fmax(nearest->high[i], (double)top->high[i][k]);
        }
    }
}

static double largest_of(const double bounds[2][3]) {
    double largest = 0;
    for (int i = 0; i < 3; ++i)
        if (bounds[0][i] <= bounds[1][i])
            largest = fmax(largest, fmax(fabs(bounds[0][i]), fabs(bounds[1][i])));
    return largest;
}

static qn_status build(qni_check *check, qni_nearest *nearest) {
    const double largest = largest_of((const double(*)[3])check->report->bounds);
    if (largest > largest_coordinate)
        return qni_fail(check->error, QN_ERROR_INVALID_ARGUMENT,
                        "a coordinate of %g is too large for distances: scale the mesh below 1e18",
                        largest);
    const qni_check_span whole = {0, 1};
    if (2 * check->mesh.quad_count + check->mesh.triangle_count >= (int64_t)QNI_NO_TRIANGLE)
        return qni_fail(check->error, QN_ERROR_INVALID_ARGUMENT,
                        "distances are taken to at most 2^32 - 2 triangles");
    QN_TRY(qni_box_tree_create(check, whole, &nearest->tree));
    nearest->slack = (float)(largest * 2 * (double)FLT_EPSILON);
    take_box(nearest);
    return QN_OK;
}

qn_status qni_nearest_create(qn_context *context, const qn_mesh *mesh, const char *stage,
                             qni_nearest *nearest_out, qn_error *error) {
    const qni_nearest nothing = {.context = context, .positions = mesh->positions};
    *nearest_out = nothing;
    qn_mesh_report report;
    qni_check check = {.context = context,
                       .mesh = qn_mesh_get_view(mesh),
                       .report = &report,
                       .error = error,
                       .stage = stage};
    check.vertex_flags = qni_alloc_zero(context, mesh->vertex_count, 1);
    if (!check.vertex_flags)
        return qni_fail_memory(error, "a tree of boxes over triangles");
    look_at_vertices(mesh, check.vertex_flags, report.bounds);
    qn_status status = qni_diagonals_choose(context, &check.mesh, &check.diagonals, error);
    if (status == QN_OK)
        status = build(&check, nearest_out);
    qni_diagonals_free(&check.diagonals);
    qni_free(context, check.vertex_flags, mesh->vertex_count, 1);
    if (status != QN_OK)
        *nearest_out = nothing; /* a tree that failed has given its memory back */
    return status;
}

void qni_nearest_destroy(qni_nearest *nearest) {
    qni_check check = {.context = nearest->context};
    const qni_box_tree nothing = {0};
    qni_box_tree_destroy(&check, &nearest->tree);
    nearest->tree = nothing;
}
