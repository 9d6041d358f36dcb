// SPDX-License-Identifier: MIT
/* A loop that holds more than one corner, or creases that do not meet: cut in two, and again.
 *
 * A cut runs from one vertex of the loop to another, either straight through a sheet between two
 * creases, or by way of a point on the crease between two corners. Each part is a loop as any
 * other, with its own apex. Parts do not lie on walls only, so all triangles are tested against
 * each other. */
#include "cms/cms.h"
#include "cms/vector.h"

#include <math.h>
#include <string.h>

enum {
    MOST_DEPTH = 3,
    MOST_VERTICES = 24,
    LEAST_SHARP = 2,
    MOST_FLAT_CUTS = 400,
    MOST_CUTS = 40,
    FACE_SLACK = 3
};

/* A cut: from vertex a to vertex b of a loop, by way of an inner point if there is one. Ends that
 * are sharp belong to the part after them where the bit says so, else to the one before. */
typedef struct cut {
    int32_t a, b;
    int32_t inner;    /* number of the inner point; -1: none */
    bool sharp[2][2]; /* [part][end] */
} cut;

typedef struct marks {
    int64_t vertices, loops, triangles, inner;
} marks;

static marks mark(const qni_patch *patch) {
    const marks at = {patch->vertex_count, patch->loop_count, patch->triangle_count,
                      patch->inner_count};
    return at;
}

static void go_back(qni_patch *patch, const marks *at) {
    patch->vertex_count = at->vertices;
    patch->loop_count = at->loops;
    patch->triangle_count = at->triangles;
    patch->inner_count = at->inner;
}

static bool copy_vertex(qni_patch *patch, int64_t from) {
    if (!qni_patch_grow(patch, (void **)&patch->vertices, &patch->vertex_capacity,
                        patch->vertex_count + 1, sizeof *patch->vertices))
        return false;
    patch->vertices[patch->vertex_count++] = patch->vertices[from];
    return true;
}

/* The inner point as a vertex of a part. */
static bool add_inner_vertex(qni_patch *patch, int32_t inner) {
    if (!qni_patch_grow(patch, (void **)&patch->vertices, &patch->vertex_capacity,
                        patch->vertex_count + 1, sizeof *patch->vertices))
        return false;
    qni_loop_vertex *vertex = &patch->vertices[patch->vertex_count++];
    memset(vertex, 0, sizeof *vertex);
    memcpy(vertex->place, patch->inner[inner], sizeof vertex->place);
    for (int k = 0; k < 3; ++k)
        vertex->at[k] = (double)vertex->place[k];
    vertex->sharp = true;
    vertex->same = QNI_INNER + inner;
    return true;
}

/* One part, from one end of the cut along the loop to the other. */
static bool add_part(qni_patch *patch, int64_t whole, const cut *at, int part) {
    if (!qni_patch_grow(patch, (void **)&patch->loops, &patch->loop_capacity, patch->loop_count + 1,
                        sizeof *patch->loops))
        return false;
    const qni_loop from = patch->loops[whole];
    const int32_t first = part ? at->b : at->a, last = part ? at->a + from.count : at->b;
    qni_loop *loop = &patch->loops[patch->loop_count++];
    memset(loop, 0, sizeof *loop);
    loop->first = (int32_t)patch->vertex_count;
    for (int32_t n = first; n <= last; ++n) {
        if (!copy_vertex(patch, from.first + n % from.count))
            return false;
        qni_loop_vertex *vertex = &patch->vertices[patch->vertex_count - 1];
        if (n == first || n == last)
            vertex->sharp = at->sharp[part][(n == last) != (part == 1)];
        loop->sharp_count += vertex->sharp;
    }
    if (at->inner >= 0 && !add_inner_vertex(patch, at->inner))
        return false;
    loop->sharp_count += at->inner >= 0;
    loop->count = (int32_t)patch->vertex_count - loop->first;
    return true;
}

static bool split_loop(qni_patch *patch, int64_t whole, int depth);

/* Do the cut's ends lie on the sheets they were put to? What they know of planes is like what their
 * neighbours on the part know; where one knows none, its neighbours are alike. */
static bool ends_fit(const qni_patch *patch, const qni_loop *loop) {
    const qni_loop_vertex *v = &patch->vertices[loop->first];
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *a = &v[n], *b = &v[(n + 1) % loop->count];
        const bool beyond = !b->crossing && !b->has_plane && !b->sharp;
        double likeness = 0;
        if (beyond)
            b = &v[(n + 2) % loop->count];
        for (int k = 0; k < 3; ++k)
            likeness += a->normal[k] * b->normal[k];
        if ((beyond || !(a->crossing && b->crossing)) && a->has_plane && b->has_plane &&
            !a->sharp && !b->sharp && likeness < patch->settings->crease_cosine)
            return false;
    }
    return true;
}

static bool is_near_middle(const qni_patch *patch, const float *const *places, int count,
                           double within) {
    double middle[3] = {0, 0, 0};
    for (int n = 0; n < count; ++n)
        for (int k = 0; k < 3; ++k)
            middle[k] += (double)places[n][k] / count;
    return qni_is_on_surface(patch->solid, middle, within);
}

/* Do the part's triangles, and its creases, lie on the surface? A crease that is none can have both
 * its ends on true ones, and, between parts of the solid, its middle in the midst of a sheet. */
static bool lies_on_surface(const qni_patch *patch, const qni_loop *loop) {
    const float *places[3];
    for (int32_t t = 0; t < loop->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k)
            places[k] = qni_patch_place(patch, patch->triangles[loop->triangle_first + t][k]);
        if (!is_near_middle(patch, places, 3, FACE_SLACK * patch->cut_within))
            return false;
    }
    places[1] = loop->apex;
    for (int32_t n = 0; n < loop->count && loop->has_apex; ++n) {
        places[0] = patch->vertices[loop->first + n].place;
        if (patch->vertices[loop->first + n].sharp &&
            !is_near_middle(patch, places, 2, patch->cut_within))
            return false;
    }
    return !patch->of_owners || qni_loop_folds_hold(patch, loop);
}

/* Triangles of a part; false when it does not come out well. */
static bool finish_part(qni_patch *patch, int64_t part, int depth) {
    qni_loop *loop = &patch->loops[part];
    if (loop->count < 3 || loop->sharp_count < LEAST_SHARP || !ends_fit(patch, loop))
        return false;
    qni_patch_place_apex(patch, loop);
    if (qni_patch_flat(patch, loop, false))
        return !loop->escaped && lies_on_surface(patch, loop);
    if (loop->escaped)
        return loop->sharp_count >= 2 * LEAST_SHARP && split_loop(patch, part, depth + 1);
    qni_patch_fan(patch, loop);
    return lies_on_surface(patch, loop);
}

/* All triangles, each with the numbers that its vertices have in common. */
static void unify(qni_patch *patch) {
    for (int64_t t = 0; t < patch->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const int32_t vertex = patch->triangles[t][k];
            if (vertex >= 0 && vertex < QNI_INNER)
                patch->triangles[t][k] = patch->vertices[vertex].same;
        }
}

static bool try_cut(qni_patch *patch, int64_t whole, const cut *at, int depth) {
    if (patch->cuts_left-- <= 0)
        return false;
    const int64_t first = patch->loop_count;
    if (!add_part(patch, whole, at, 0) || !add_part(patch, whole, at, 1))
        return false;
    if (!finish_part(patch, first, depth) || !finish_part(patch, first + 1, depth))
        return false;
    if (depth > 0)
        return true;
    unify(patch);
    return !qni_patch_meets_itself(patch);
}

/* Ends that are sharp are so in one part only, unless the cut runs along no crease. */
static bool try_ends(qni_patch *patch, int64_t whole, cut *at, int depth) {
    const qni_loop *loop = &patch->loops[whole];
    const bool a = patch->vertices[loop->first + at->a].sharp,
               b = patch->vertices[loop->first + at->b].sharp;
    const marks before = mark(patch);
    for (int choice = 0; choice < 4; ++choice) {
        if (((choice & 1) && !a) || ((choice & 2) && !b))
            continue;
        at->sharp[0][0] = a && !(choice & 1);
        at->sharp[1][0] = a && (choice & 1);
        at->sharp[0][1] = b && !(choice & 2);
        at->sharp[1][1] = b && (choice & 2);
        if (try_cut(patch, whole, at, depth))
            return true;
        go_back(patch, &before);
    }
    return false;
}

/* May a cut run between these two? Creases must be left on either side. */
static bool may_cut(const qni_patch *patch, const qni_loop *loop, int32_t a, int32_t b,
                    bool straight) {
    const qni_loop_vertex *v = patch->vertices + loop->first;
    int32_t between = 0;
    for (int32_t n = a; n <= b; ++n)
        between += v[n].sharp;
    const int32_t beyond = loop->sharp_count - between + v[a].sharp + v[b].sharp;
    if (between < LEAST_SHARP || beyond < LEAST_SHARP)
        return false;
    return patch->cuts_left > 0 && b - a > 1 && a + loop->count - b > 1 &&
           !(straight && (v[a].walls & v[b].walls));
}

/* Straight through a sheet: the middle of the chord is near the surface. */
static bool cut_sheet(qni_patch *patch, int64_t whole, int depth) {
    const int32_t count = patch->loops[whole].count;
    for (int32_t a = 0; a < count; ++a)
        for (int32_t b = a + 2; b < count; ++b) {
            const qni_loop *loop = &patch->loops[whole];
            const qni_loop_vertex *v = patch->vertices + loop->first;
            double middle[3];
            for (int k = 0; k < 3; ++k)
                middle[k] = 0.5 * ((double)v[a].place[k] + (double)v[b].place[k]);
            cut at = {a, b, -1, {{false, false}, {false, false}}};
            if (may_cut(patch, loop, a, b, true) &&
                qni_is_on_surface(patch->solid, middle, patch->cut_within) &&
                try_ends(patch, whole, &at, depth))
                return true;
        }
    return false;
}

static void middle_of_sharp(const qni_patch *patch, const qni_loop *loop, double middle[3]) {
    middle[0] = middle[1] = middle[2] = 0;
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = &patch->vertices[loop->first + n];
        for (int k = 0; k < 3 && vertex->sharp; ++k)
            middle[k] += (double)vertex->place[k] / loop->sharp_count;
    }
}

/* What comes after a sharp feature speaks for the sheet between that one and the next: a crossing,
 * or at once the next one, if it knows the plane. */
static bool leads_sheet(const qni_loop_vertex *v, int32_t count, int32_t n) {
    return v[n].has_plane && v[(n + count - 1) % count].sharp;
}

/* How far the straight way between two points is off the surface, to first order. */
static double leaves_surface(const qni_patch *patch, const float from[3], const double to[3]) {
    enum { PARTS = 4 };
    const qn_solid *solid = patch->solid;
    double points[PARTS - 1][3], values[PARTS - 1], gradients[PARTS - 1][3], most = 0;
    for (int n = 0; n < PARTS - 1; ++n)
        for (int k = 0; k < 3; ++k)
            points[n][k] = (double)from[k] + (to[k] - (double)from[k]) * (n + 1) / PARTS;
    if (solid->ops->values(solid, PARTS - 1, (const double(*)[3])points, values) != QN_OK ||
        solid->ops->gradients(solid, PARTS - 1, (const double(*)[3])points, gradients, NULL) !=
            QN_OK)
        return HUGE_VAL;
    for (int n = 0; n < PARTS - 1; ++n) {
        const double slope = sqrt(qni_dot3(gradients[n], gradients[n]));
        most = fmax(most, fabs(values[n]) / (slope > 0 ? slope : 1));
    }
    return most;
}

/* Of the sheet that a vertex leads the one from which the straight way to a point is on the
 * surface; the leader, unless another is clearly better. */
static int32_t end_of_cut(const qni_patch *patch, const qni_loop *loop, int32_t leader,
                          const double point[3]) {
    const qni_loop_vertex *v = patch->vertices + loop->first;
    const double better = 0.1 * patch->cut_within;
    double least = leaves_surface(patch, v[leader].place, point);
    int32_t best = leader;
    for (int32_t n = leader + 1; n < leader + loop->count && !v[n % loop->count].sharp; ++n) {
        const double off = leaves_surface(patch, v[n % loop->count].place, point);
        if (off < least - better) {
            least = off;
            best = n % loop->count;
        }
    }
    return best;
}

/* The next vertex of the same sheet that knows a plane, or -1. */
static int32_t next_of_sheet(const qni_loop_vertex *v, int32_t count, int32_t n) {
    for (int32_t m = (n + 1) % count; !v[m].sharp; m = (m + 1) % count)
        if (v[m].has_plane)
            return m;
    return -1;
}

/* The inner point, by the tangents at the sheets' leaders, or at other vertices of theirs: where a
 * sheet is bent round a corner the way from its leader may leave it. */
static bool find_inner(qni_patch *patch, const qni_loop *loop, int32_t a, int32_t b,
                       const double middle[3], double point[3]) {
    const qni_loop_vertex *v = patch->vertices + loop->first;
    for (int32_t c = a; c >= 0; c = next_of_sheet(v, loop->count, c))
        for (int32_t d = b; d >= 0; d = next_of_sheet(v, loop->count, d))
            if (patch->cuts_left-- <= 0)
                return false;
            else if (qni_patch_meet_two(patch, &v[c], &v[d], middle, point))
                return qni_patch_holds(patch, point);
    return false;
}

/* A cut from vertex to vertex by way of an inner point. */
static bool try_inner(qni_patch *patch, int64_t whole, int32_t a, int32_t b, const double point[3],
                      int depth) {
    const int32_t first = a < b ? a : b, second = a < b ? b : a;
    if (!may_cut(patch, &patch->loops[whole], first, second, false) ||
        !qni_patch_grow(patch, (void **)&patch->inner, &patch->inner_capacity,
                        patch->inner_count + 1, sizeof *patch->inner))
        return false;
    for (int k = 0; k < 3; ++k)
        patch->inner[patch->inner_count][k] =
            qni_between(point[k], patch->clear_low[k], patch->clear_high[k]);
    cut at = {first, second, (int32_t)patch->inner_count++, {{false, false}, {false, false}}};
    if (try_ends(patch, whole, &at, depth))
        return true;
    --patch->inner_count;
    return false;
}

/* By way of the crease between two corners, where the sheets of both ends meet. */
static bool cut_crease(qni_patch *patch, int64_t whole, int depth) {
    const int32_t count = patch->loops[whole].count;
    double middle[3];
    middle_of_sharp(patch, &patch->loops[whole], middle);
    for (int32_t a = 0; a < count; ++a)
        for (int32_t b = a + 2; b < count; ++b) {
            const qni_loop *loop = &patch->loops[whole];
            const qni_loop_vertex *v = patch->vertices + loop->first;
            double point[3];
            if (!leads_sheet(v, count, a) || !leads_sheet(v, count, b) ||
                !may_cut(patch, loop, a, b, false) || !find_inner(patch, loop, a, b, middle, point))
                continue;
            const int32_t from = end_of_cut(patch, loop, a, point),
                          to = end_of_cut(patch, loop, b, point);
            if (try_inner(patch, whole, from, to, point, depth))
                return true;
        }
    return false;
}

/* The whole loop keeps no triangles of its own. */
static bool split_loop(qni_patch *patch, int64_t whole, int depth) {
    if (depth >= patch->most_depth || patch->loops[whole].count > MOST_VERTICES)
        return false;
    if (!cut_sheet(patch, whole, depth) && !cut_crease(patch, whole, depth))
        return false;
    qni_loop *loop = &patch->loops[whole];
    loop->escaped = loop->has_apex = false;
    loop->triangle_count = 0;
    return true;
}

/* Can all sheets be flat? Each triangle has a piece of the loop or of a cut for a side, so the
 * plane of a crossing holds what comes before and after it. */
static bool may_be_flat(const qni_patch *patch, const qni_loop *loop) {
    const qni_loop_vertex *v = &patch->vertices[loop->first];
    const double most = 1e-3 * patch->hermite->lattice.cell;
    for (int32_t n = 0; n < loop->count; ++n)
        for (int32_t m = 1; m < loop->count && v[n].crossing; m += loop->count - 2) {
            const float *place = v[(n + m) % loop->count].place;
            double height = 0;
            for (int k = 0; k < 3; ++k)
                height += v[n].normal[k] * ((double)place[k] - v[n].at[k]);
            if (fabs(height) > most)
                return false;
        }
    return true;
}

/* Do several parts of the solid have a piece of the loop? */
static bool has_owners(const qni_patch *patch, const qni_loop *loop) {
    const qni_loop_vertex *v = &patch->vertices[loop->first];
    int32_t first = 0;
    while (first < loop->count && !v[first].crossing)
        ++first;
    for (int32_t n = first; n < loop->count; ++n)
        if (v[n].crossing && v[n].owner != v[first].owner)
            return true;
    return false;
}

/* How to look for cuts. */
typedef struct split_pass {
    bool flat;
    bool of_owners;      /* for loops of several parts of the solid only */
    int32_t depth, cuts; /* at most */
    double within;       /* what is cut must lie this near to the surface, in cells */
} split_pass;

/* What is flat is found by values alone, and may be looked for long; what curves takes tangents.
 * Where parts of the solid meet two corners in a cell are the rule: one cut is tried everywhere
 * before what it leaves is cut again. */
static const split_pass passes[] = {
    {true, false, MOST_DEPTH, MOST_FLAT_CUTS, 2e-5},
    {false, true, 1, MOST_CUTS, 0.05},
    {false, false, MOST_DEPTH, MOST_CUTS, 0.05},
};

bool qni_patch_split(qni_patch *patch) {
    const marks before = mark(patch);
    const double cell = patch->hermite->lattice.cell;
    const int count = sizeof passes / sizeof *passes;
    const int first = may_be_flat(patch, &patch->loops[0]) ? 0 : 1,
              end = patch->united && patch->size_cells > 2 ? 1 : count;
    patch->of_owners = has_owners(patch, &patch->loops[0]);
    patch->split = false;
    for (int n = first; n < end && !patch->split; ++n) {
        if (passes[n].of_owners && !patch->of_owners)
            continue;
        patch->flat_only = passes[n].flat;
        patch->cut_within = passes[n].within * cell;
        patch->cuts_left = passes[n].cuts;
        patch->most_depth = passes[n].depth;
        patch->split = split_loop(patch, 0, 0);
        if (!patch->split)
            go_back(patch, &before);
    }
    patch->flat_only = false;
    return patch->split;
}
