// SPDX-License-Identifier: MIT
/* Sheets: what lies between two sharp features that follow each other in a loop. Where they meet is
 * the loop's corner; where two of them meet the plane between its features, a point of its crease.
 * [CMS05 3.4] takes one solution of the planes that crossings have; curved sheets need several. */
#include "cms/cms.h"
#include "cms/vector.h"

#include <math.h>
#include <string.h>

enum { MOST_SHEETS = 16, REFINE_STEPS = 12 };

typedef struct sheet {
    qni_tangent tangent;
    double middle[3]; /* of all its vertices */
    bool fixed;       /* a plane to stay in */
} sheet;

static double height_over(const qni_loop_vertex *plane, const float place[3]) {
    double height = 0;
    for (int k = 0; k < 3; ++k)
        height += plane->normal[k] * ((double)place[k] - plane->at[k]);
    return fabs(height);
}

static double distance2(const double a[3], const double b[3]) {
    double sum = 0;
    for (int k = 0; k < 3; ++k)
        sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum;
}

/* The vertex that speaks for the sheet from one sharp feature to the next: the crossing next to a
 * point; without any, the feature in whose plane both lie. */
static const qni_loop_vertex *speaker_of(const qni_patch *patch, const qni_loop *loop, int32_t from,
                                         int32_t to, const double point[3]) {
    const qni_loop_vertex *v = patch->vertices + loop->first, *best = NULL;
    double least = HUGE_VAL;
    for (int32_t n = from + 1; n < to; ++n) {
        const qni_loop_vertex *vertex = &v[n % loop->count];
        const double distance = distance2(vertex->at, point);
        if (vertex->has_plane && distance < least) {
            least = distance;
            best = vertex;
        }
    }
    for (int n = 0; n < 2 && least == HUGE_VAL; ++n) {
        const qni_loop_vertex *a = &v[(n ? to : from) % loop->count],
                              *b = &v[(n ? from : to) % loop->count];
        if (a->has_plane && (!best || height_over(a, b->place) < height_over(best, a->place)))
            best = a;
    }
    return best;
}

static void middle_of(const qni_loop_vertex *v, int32_t count, int32_t from, int32_t to,
                      double middle[3]) {
    for (int k = 0; k < 3; ++k) {
        middle[k] = 0;
        for (int32_t n = from; n <= to; ++n)
            middle[k] += (double)v[n % count].place[k] / (to - from + 1);
    }
}

static int32_t gather_sheets(const qni_patch *patch, const qni_loop *loop, const double point[3],
                             sheet *sheets) {
    const qni_loop_vertex *v = patch->vertices + loop->first;
    int32_t count = 0, first = 0;
    while (first < loop->count && !v[first].sharp)
        ++first;
    for (int32_t from = first; from < first + loop->count && count < MOST_SHEETS;) {
        int32_t to = from + 1;
        while (to < first + loop->count && !v[to % loop->count].sharp)
            ++to;
        const qni_loop_vertex *speaker = speaker_of(patch, loop, from, to, point);
        if (speaker) {
            sheets[count].fixed = false;
            middle_of(v, loop->count, from, to, sheets[count].middle);
            memcpy(sheets[count].tangent.at, speaker->at, sizeof speaker->at);
            memcpy(sheets[count].tangent.normal, speaker->normal, sizeof speaker->normal);
            sheets[count++].tangent.owner = speaker->owner;
        }
        from = to;
    }
    return count;
}

/* The least-norm point of the sheets' tangent planes about a centre. */
static bool solve_sheets(const sheet *sheets, int32_t count, int32_t rank, const double centre[3],
                         double point[3]) {
    double rows[3 * MOST_SHEETS], heights[MOST_SHEETS], step[3];
    for (int32_t n = 0; n < count; ++n) {
        memcpy(rows + 3 * n, sheets[n].tangent.normal, sizeof sheets->tangent.normal);
        heights[n] = 0;
        for (int k = 0; k < 3; ++k)
            heights[n] += sheets[n].tangent.normal[k] * (sheets[n].tangent.at[k] - centre[k]);
    }
    if (!qni_solve_planes(rows, heights, count, rank, step))
        return false;
    for (int k = 0; k < 3; ++k)
        point[k] = centre[k] + step[k];
    return true;
}

typedef enum advance { AT_ONCE, PARTLY, STUCK } advance;

/* The tangent again, most of the way towards a point; less of it where that is too far. */
static advance approach(const qni_patch *patch, sheet *own, const double point[3]) {
    qni_tangent *tangent = &own->tangent;
    const double distance = sqrt(distance2(tangent->at, point));
    if (own->fixed || !(distance > 1e-9 * patch->size))
        return AT_ONCE;
    static const double shares[3] = {0.9, 0.5, 0.2}, reaches[3] = {0.3, 0.5, 0.3};
    for (int attempt = 0; attempt < 3; ++attempt) {
        const double share = shares[attempt], reach = reaches[attempt];
        double target[3];
        for (int k = 0; k < 3; ++k)
            target[k] = tangent->at[k] + share * (point[k] - tangent->at[k]);
        if (qni_surface_along(patch->solid, patch->settings, tangent, target, tangent->normal,
                              reach * distance, tangent))
            return attempt == 0 ? AT_ONCE : PARTLY;
    }
    return STUCK;
}

/* The tangent again in the midst of its sheet: the way from there to a point stays on the sheet
 * where that from its rim may not. */
static void settle(const qni_patch *patch, sheet *own, const double point[3]) {
    qni_tangent *tangent = &own->tangent;
    double target[3], height = 0;
    for (int k = 0; k < 3; ++k) {
        target[k] = 0.5 * (own->middle[k] + point[k]);
        height += tangent->normal[k] * (target[k] - tangent->at[k]);
    }
    for (int k = 0; k < 3; ++k)
        target[k] -= height * tangent->normal[k];
    const double distance = sqrt(distance2(target, tangent->at));
    qni_surface_along(patch->solid, patch->settings, tangent, target, tangent->normal,
                      0.5 * distance, tangent);
}

/* Sheets that are flat as far as the point where they meet: it is known at once. */
static bool are_flat(const qni_patch *patch, const sheet *sheets, int32_t count,
                     const double point[3]) {
    double from[MOST_SHEETS + 1][3];
    int32_t free_count = 0;
    for (int32_t n = 0; n < count; ++n)
        if (!sheets[n].fixed)
            memcpy(from[free_count++], sheets[n].tangent.at, sizeof from[0]);
    return qni_flat_pieces_meet(patch->solid, point, free_count, (const double(*)[3])from,
                                1e-8 * patch->hermite->lattice.cell);
}

/* Do all tangents pass through a point? Those of creases side by side do not. */
static bool all_pass(const sheet *sheets, int32_t count, const double point[3], double tolerance) {
    for (int32_t n = 0; n < count; ++n) {
        double height = 0;
        for (int k = 0; k < 3; ++k)
            height += sheets[n].tangent.normal[k] * (point[k] - sheets[n].tangent.at[k]);
        if (!(fabs(height) <= tolerance))
            return false;
    }
    return true;
}

/* All sheets a step towards a point; how far the one got that got least far. */
static advance approach_all(const qni_patch *patch, sheet *sheets, int32_t count,
                            const double point[3]) {
    advance least = AT_ONCE;
    for (int32_t n = 0; n < count; ++n) {
        const advance own = approach(patch, &sheets[n], point);
        least = own > least ? own : least;
    }
    return least;
}

/* Where all sheets meet, next to a point: each step takes the error of curvature to a hundredth. A
 * sheet that gets no nearer to a point that stays will not do so in the next step. */
static bool meet_sheets(const qni_patch *patch, sheet *sheets, int32_t count, int32_t rank,
                        double point[3]) {
    const double cell = patch->hermite->lattice.cell;
    double next[3];
    if (!solve_sheets(sheets, count, rank, point, next))
        return false;
    memcpy(point, next, sizeof next);
    if (patch->flat_only) /* the solid is asked last: it costs most */
        return all_pass(sheets, count, point, 1e-5 * cell) && are_flat(patch, sheets, count, point);
    if (are_flat(patch, sheets, count, point))
        return all_pass(sheets, count, point, 1e-5 * cell);
    for (int32_t n = 0; n < count; ++n)
        if (!sheets[n].fixed)
            settle(patch, &sheets[n], point);
    for (int step = 0; step < REFINE_STEPS; ++step) {
        const advance got = approach_all(patch, sheets, count, point);
        if (!solve_sheets(sheets, count, rank, point, next))
            return false;
        const double moved = sqrt(distance2(next, point));
        if (!(moved < 2 * patch->size))
            return false;
        memcpy(point, next, sizeof next);
        if (moved < 1e-7 * cell && got != PARTLY)
            return got == AT_ONCE && all_pass(sheets, count, point, 1e-5 * cell);
    }
    return false;
}

/* The plane through the middle between the loop's two features, across the way between them. */
static bool plane_across(const qni_patch *patch, const qni_loop *loop, const double middle[3],
                         sheet *plane) {
    double length = 0;
    int32_t n = 0;
    while (!patch->vertices[loop->first + n].sharp)
        ++n;
    for (int k = 0; k < 3; ++k) {
        plane->tangent.at[k] = middle[k];
        plane->tangent.normal[k] = (double)patch->vertices[loop->first + n].place[k] - middle[k];
        length += plane->tangent.normal[k] * plane->tangent.normal[k];
    }
    length = sqrt(length);
    for (int k = 0; k < 3; ++k)
        plane->tangent.normal[k] /= length > 0 ? length : 1;
    plane->fixed = true;
    return length > 0;
}

bool qni_patch_meet_sheets(const qni_patch *patch, const qni_loop *loop, const double middle[3],
                           double point[3]) {
    sheet sheets[MOST_SHEETS + 1];
    int32_t count = gather_sheets(patch, loop, middle, sheets);
    if (loop->sharp_count == 2) {
        if (count != 2 || !plane_across(patch, loop, middle, &sheets[2]))
            return false;
        count = 3;
    }
    memcpy(point, middle, 3 * sizeof *point);
    return count >= 3 && meet_sheets(patch, sheets, count, 3, point) &&
           qni_is_on_surface(patch->solid, point, 1e-3 * patch->size);
}

bool qni_patch_cross_sheets(const qni_patch *patch, const qni_loop *loop, const double middle[3],
                            double point[3]) {
    sheet sheets[MOST_SHEETS + 1];
    double at[2][3], normal[2][3];
    if (gather_sheets(patch, loop, middle, sheets) != 2)
        return false;
    for (int n = 0; n < 2; ++n) {
        memcpy(at[n], sheets[n].tangent.at, sizeof at[n]);
        memcpy(normal[n], sheets[n].tangent.normal, sizeof normal[n]);
    }
    return qni_patch_halve_to_crease(patch, (const double(*)[3])at, (const double(*)[3])normal,
                                     point);
}

static void start_sheet(const qni_loop_vertex *vertex, sheet *out) {
    memcpy(out->tangent.at, vertex->at, sizeof out->tangent.at);
    memcpy(out->tangent.normal, vertex->normal, sizeof out->tangent.normal);
    out->tangent.owner = vertex->owner;
    memcpy(out->middle, vertex->at, sizeof out->middle);
    out->fixed = false;
}

bool qni_patch_meet_two(const qni_patch *patch, const qni_loop_vertex *a, const qni_loop_vertex *b,
                        const double middle[3], double point[3]) {
    sheet sheets[3];
    start_sheet(a, &sheets[0]);
    start_sheet(b, &sheets[1]);
    double length = 0;
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        sheets[2].tangent.normal[k] = a->normal[l] * b->normal[m] - a->normal[m] * b->normal[l];
        sheets[2].tangent.at[k] = middle[k];
        length += sheets[2].tangent.normal[k] * sheets[2].tangent.normal[k];
    }
    length = sqrt(length);
    if (!(length > 1e-6))
        return false;
    for (int k = 0; k < 3; ++k)
        sheets[2].tangent.normal[k] /= length;
    sheets[2].fixed = true;
    memcpy(point, middle, 3 * sizeof *point);
    return meet_sheets(patch, sheets, 3, 3, point) &&
           qni_is_on_surface(patch->solid, point, 1e-3 * patch->size);
}
