// SPDX-License-Identifier: MIT
/* The boxes of eight panels are compared at once, and those of eight eights before them. */
#include "solid/model_near.h"

#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* ---- eight boxes at a time ----------------------------------------------------------------------
 */

#ifdef __SSE2__

/* Which of the eight meet a box: a bit each. */
static unsigned meeting(const qni_near_eight *eight, const qni_float_box *box) {
    unsigned bits = 0;
    for (int half = 0; half < QNI_EIGHT; half += 4) {
        __m128 meets = _mm_cmple_ps(_mm_loadu_ps(eight->low[0] + half), _mm_set1_ps(box->high[0]));
        for (int k = 0; k < 3; ++k) {
            meets = _mm_and_ps(
                meets, _mm_cmple_ps(_mm_loadu_ps(eight->low[k] + half), _mm_set1_ps(box->high[k])));
            meets = _mm_and_ps(
                meets, _mm_cmpge_ps(_mm_loadu_ps(eight->high[k] + half), _mm_set1_ps(box->low[k])));
        }
        bits |= (unsigned)_mm_movemask_ps(meets) << half;
    }
    return bits;
}

static __m128 over_slab(const qni_near_slabs *slabs, int half, const float p[3]) {
    __m128 sum = _mm_setzero_ps();
    for (int k = 0; k < 3; ++k)
        sum = _mm_add_ps(sum, _mm_mul_ps(_mm_loadu_ps(slabs->normal[k] + half), _mm_set1_ps(p[k])));
    return _mm_sub_ps(sum, _mm_loadu_ps(slabs->height + half));
}

/* Which of the eight slabs have two points on one side. */
static unsigned beside(const qni_near_slabs *slabs, const float a[3], const float b[3]) {
    unsigned bits = 0;
    for (int half = 0; half < QNI_EIGHT; half += 4) {
        const __m128 at_a = over_slab(slabs, half, a), at_b = over_slab(slabs, half, b),
                     slack = _mm_loadu_ps(slabs->slack + half);
        const __m128 above = _mm_cmpgt_ps(_mm_min_ps(at_a, at_b), slack),
                     below =
                         _mm_cmplt_ps(_mm_max_ps(at_a, at_b), _mm_sub_ps(_mm_setzero_ps(), slack));
        bits |= (unsigned)_mm_movemask_ps(_mm_or_ps(above, below)) << half;
    }
    return bits;
}

/* Squared distances from a point, less `slack` along each axis. */
static void measure(const qni_near_eight *eight, const float p[3], float slack,
                    float squares[QNI_EIGHT]) {
    for (int half = 0; half < QNI_EIGHT; half += 4) {
        __m128 sum = _mm_setzero_ps();
        for (int k = 0; k < 3; ++k) {
            const __m128 at = _mm_set1_ps(p[k]);
            const __m128 below = _mm_sub_ps(_mm_loadu_ps(eight->low[k] + half), at),
                         above = _mm_sub_ps(at, _mm_loadu_ps(eight->high[k] + half));
            const __m128 away = _mm_max_ps(_mm_sub_ps(_mm_max_ps(below, above), _mm_set1_ps(slack)),
                                           _mm_setzero_ps());
            sum = _mm_add_ps(sum, _mm_mul_ps(away, away));
        }
        _mm_storeu_ps(squares + half, sum);
    }
}

#else

static unsigned meeting(const qni_near_eight *eight, const qni_float_box *box) {
    unsigned bits = 0;
    for (int n = 0; n < QNI_EIGHT; ++n) {
        bool meets = true;
        for (int k = 0; k < 3; ++k)
            meets = meets && eight->low[k][n] <= box->high[k] && eight->high[k][n] >= box->low[k];
        bits |= (unsigned)meets << n;
    }
    return bits;
}

static unsigned beside(const qni_near_slabs *slabs, const float a[3], const float b[3]) {
    unsigned bits = 0;
    for (int n = 0; n < QNI_EIGHT; ++n) {
        float at_a = -slabs->height[n], at_b = at_a;
        for (int k = 0; k < 3; ++k) {
            at_a += slabs->normal[k][n] * a[k];
            at_b += slabs->normal[k][n] * b[k];
        }
        const bool above = at_a > slabs->slack[n] && at_b > slabs->slack[n],
                   below = at_a < -slabs->slack[n] && at_b < -slabs->slack[n];
        bits |= (unsigned)(above || below) << n;
    }
    return bits;
}

static void measure(const qni_near_eight *eight, const float p[3], float slack,
                    float squares[QNI_EIGHT]) {
    for (int n = 0; n < QNI_EIGHT; ++n) {
        squares[n] = 0;
        for (int k = 0; k < 3; ++k) {
            const float below = eight->low[k][n] - p[k], above = p[k] - eight->high[k][n];
            const float away = (below > above ? below : above) - slack;
            squares[n] += away > 0 ? away * away : 0;
        }
    }
}

#endif

static int32_t eights_of(int32_t count) {
    return (count + QNI_EIGHT - 1) / QNI_EIGHT;
}

/* `ends` of a segment from the list's middle; without, only boxes are compared. */
static int32_t choose(const qni_near_list *near, const qni_box *box, const float (*ends)[3],
                      int32_t *chosen) {
    const qni_float_box around = qni_rounded_outwards(box);
    const int32_t eights = eights_of(near->count);
    int32_t count = 0;
    for (int32_t group = 0; group < eights_of(eights); ++group)
        for (unsigned some = meeting(&near->eights[eights + group], &around); some;
             some &= some - 1) {
            const int32_t eight = QNI_EIGHT * group + __builtin_ctz(some);
            unsigned bits = meeting(&near->eights[eight], &around);
            if (bits && ends)
                bits &= ~beside(&near->slabs[eight], ends[0], ends[1]);
            for (; bits; bits &= bits - 1)
                chosen[count++] = QNI_EIGHT * eight + __builtin_ctz(bits);
        }
    return count;
}

int32_t qni_near_meeting(const qni_near_list *near, const qni_box *box, int32_t *chosen) {
    return choose(near, box, NULL, chosen);
}

int32_t qni_near_crossing(const qni_near_list *near, const double a[3], const double b[3],
                          int32_t *chosen) {
    const qni_box box = qni_segment_box(a, b);
    float ends[2][3];
    for (int k = 0; k < 3; ++k) {
        ends[0][k] = (float)(a[k] - near->middle[k]);
        ends[1][k] = (float)(b[k] - near->middle[k]);
    }
    return choose(near, &box, (const float(*)[3])ends, chosen);
}

/* ---- making lists -------------------------------------------------------------------------------
 */

static int64_t room_for(int32_t count) {
    const int32_t eights = eights_of(count);
    return (int64_t)(eights + eights_of(eights)) * (int64_t)sizeof(qni_near_eight) +
           (int64_t)eights * (int64_t)sizeof(qni_near_slabs) +
           (int64_t)count * (int64_t)sizeof(int32_t);
}

static bool start(qn_context *context, qni_near_list *near, int32_t count) {
    memset(near, 0, sizeof *near);
    near->eights = qni_alloc(context, 1, room_for(count));
    if (!near->eights)
        return false;
    const int32_t eights = eights_of(count), all = eights + eights_of(eights);
    near->count = count;
    near->slabs = (qni_near_slabs *)(void *)(near->eights + all);
    near->numbers = (int32_t *)(void *)(near->slabs + eights);
    for (int32_t n = 0; n < all; ++n)
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < QNI_EIGHT; ++i) {
                near->eights[n].low[k][i] = INFINITY;
                near->eights[n].high[k][i] = -INFINITY;
            }
    return true;
}

void qni_near_free(qn_context *context, qni_near_list *near) {
    qni_free(context, near->eights, 1, near->eights ? room_for(near->count) : 0);
}

/* Sets a box, and makes that of its eight larger. */
static void put(qni_near_list *near, int32_t at, const float low[3], const float high[3]) {
    const int32_t eight = at / QNI_EIGHT;
    qni_near_eight *own = &near->eights[eight],
                   *group = &near->eights[eights_of(near->count) + eight / QNI_EIGHT];
    for (int k = 0; k < 3; ++k) {
        own->low[k][at % QNI_EIGHT] = low[k];
        own->high[k][at % QNI_EIGHT] = high[k];
        float *least = &group->low[k][eight % QNI_EIGHT],
              *most = &group->high[k][eight % QNI_EIGHT];
        *least = low[k] < *least ? low[k] : *least;
        *most = high[k] > *most ? high[k] : *most;
    }
}

static void put_panel(qni_near_list *near, int32_t at, const qni_panel *panel) {
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        const float x = panel->at[0][k], y = panel->at[1][k], z = panel->at[2][k];
        low[k] = qni_least_of(x, y, z);
        high[k] = qni_most_of(x, y, z);
    }
    put(near, at, low, high);
}

/* The panel's corners lie in the slab by construction: so it holds of slivers too, whose normal may
 * be any. It need not have length 1: its largest component does. */
static void put_slab(qni_near_list *near, int32_t at, const qni_panel *panel) {
    qni_near_slabs *slabs = &near->slabs[at / QNI_EIGHT];
    const int place = at % QNI_EIGHT;
    double normal[3], corner[3][3], low = QNI_INFINITY, high = -QNI_INFINITY, largest = 0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            corner[i][k] = (double)panel->at[i][k] - near->middle[k];
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        normal[k] = (corner[1][l] - corner[0][l]) * (corner[2][m] - corner[0][m]) -
                    (corner[1][m] - corner[0][m]) * (corner[2][l] - corner[0][l]);
        largest = qni_greater(largest, fabs(normal[k]));
    }
    const double scale = largest > 1e-300 ? 1 / largest : 0;
    for (int k = 0; k < 3; ++k)
        slabs->normal[k][place] = (float)(scale * normal[k]);
    for (int i = 0; i < 3; ++i) {
        double height = 0;
        for (int k = 0; k < 3; ++k)
            height += (double)slabs->normal[k][place] * corner[i][k];
        low = qni_lesser(low, height);
        high = qni_greater(high, height);
    }
    const double height = 0.5 * (low + high);
    slabs->height[place] = (float)height;
    slabs->slack[place] = (float)(0.5 * (high - low) + 4e-6 * (near->reach + fabs(height)));
}

static const qni_panel *panel_of(const qni_panel_tree *surface, const qni_panel_tree *caps,
                                 int32_t number) {
    return number < 0 ? &caps->panels[~number] : &surface->panels[number];
}

bool qni_near_from_trees(qn_context *context, const qni_panel_tree *surface,
                         const qni_panel_tree *caps, const qni_box *box, qni_near_list *near,
                         bool *few) {
    int32_t numbers[QNI_MOST_NEAR], of_surface, of_caps = 0;
    memset(near, 0, sizeof *near);
    *few =
        qni_panel_tree_list(surface, box, QNI_MOST_NEAR, numbers, &of_surface) &&
        qni_panel_tree_list(caps, box, QNI_MOST_NEAR - of_surface, numbers + of_surface, &of_caps);
    if (!*few)
        return true;
    if (!start(context, near, of_surface + of_caps))
        return false;
    near->surface_count = of_surface;
    for (int k = 0; k < 3; ++k) {
        near->middle[k] = 0.5 * (box->low[k] + box->high[k]);
        near->reach += box->high[k] - near->middle[k];
    }
    for (int32_t n = 0; n < near->count; ++n) {
        near->numbers[n] = n < of_surface ? numbers[n] : ~numbers[n];
        put_panel(near, n, panel_of(surface, caps, near->numbers[n]));
        put_slab(near, n, panel_of(surface, caps, near->numbers[n]));
    }
    return true;
}

static void copy_slab(const qni_near_list *from, int32_t place, qni_near_list *near, int32_t at) {
    const qni_near_slabs *a = &from->slabs[place / QNI_EIGHT];
    qni_near_slabs *b = &near->slabs[at / QNI_EIGHT];
    for (int k = 0; k < 3; ++k)
        b->normal[k][at % QNI_EIGHT] = a->normal[k][place % QNI_EIGHT];
    b->height[at % QNI_EIGHT] = a->height[place % QNI_EIGHT];
    b->slack[at % QNI_EIGHT] = a->slack[place % QNI_EIGHT];
}

/* The longest side of a panel's box. */
static double extent_of(const qni_near_list *near, int32_t at) {
    const qni_near_eight *eight = &near->eights[at / QNI_EIGHT];
    double extent = 0;
    for (int k = 0; k < 3; ++k)
        extent = qni_greater(extent, (double)eight->high[k][at % QNI_EIGHT] -
                                         (double)eight->low[k][at % QNI_EIGHT]);
    return extent;
}

bool qni_near_from_larger(qn_context *context, const qni_panel_tree *surface,
                          const qni_panel_tree *caps, const qni_near_list *larger,
                          const qni_box *box, qni_near_list *near) {
    int32_t chosen[QNI_MOST_NEAR], count = 0;
    double room = 0;
    for (int k = 0; k < 3; ++k)
        room = qni_greater(room, box->high[k] - box->low[k]);
    const int32_t candidates = qni_near_meeting(larger, box, chosen);
    for (int32_t n = 0; n < candidates; ++n)
        if (!(extent_of(larger, chosen[n]) > room) ||
            qni_panel_meets(panel_of(surface, caps, larger->numbers[chosen[n]]), box))
            chosen[count++] = chosen[n];
    if (!start(context, near, count))
        return false;
    memcpy(near->middle, larger->middle, sizeof near->middle);
    near->reach = larger->reach;
    for (int32_t n = 0; n < count; ++n) {
        const qni_near_eight *eight = &larger->eights[chosen[n] / QNI_EIGHT];
        const int place = chosen[n] % QNI_EIGHT;
        copy_slab(larger, chosen[n], near, n);
        float low[3], high[3];
        for (int k = 0; k < 3; ++k) {
            low[k] = eight->low[k][place];
            high[k] = eight->high[k][place];
        }
        put(near, n, low, high);
        near->numbers[n] = larger->numbers[chosen[n]];
        near->surface_count += chosen[n] < larger->surface_count;
    }
    return true;
}

/* ---- the nearest panel --------------------------------------------------------------------------
 */

typedef struct nearest_job {
    const qni_panel_tree *surface;
    const double *p;
    double *square, *nearest;
    float below; /* squares of distances by float that can be less than the least so far */
    int32_t best;
} nearest_job;

static void set_least(nearest_job *job, int32_t panel, double square, const double at[3]) {
    job->best = panel;
    *job->square = square;
    job->below = (float)(square * (1 + 1e-6));
    memcpy(job->nearest, at, 3 * sizeof *at);
}

static void consider(nearest_job *job, int32_t panel) {
    double at[3];
    if (panel == job->best)
        return;
    const qni_panel *panels = job->surface->panels;
    const double each = qni_panel_nearest(&panels[panel], job->p, at);
    const bool tie = job->best >= 0 && !(each < *job->square) && !(each > *job->square) &&
                     panels[panel].number < panels[job->best].number;
    if (each < *job->square || tie)
        set_least(job, panel, each, at);
}

/* The nearest of boxes that are asked first, when nothing is known. */
static int32_t place_to_begin(const qni_near_list *near, const float p[3]) {
    float least = INFINITY;
    int32_t best = 0;
    for (int32_t eight = 0; eight < eights_of(near->surface_count); ++eight) {
        float squares[QNI_EIGHT];
        measure(&near->eights[eight], p, 0, squares);
        for (int n = 0; n < QNI_EIGHT && QNI_EIGHT * eight + n < near->surface_count; ++n)
            if (squares[n] < least) {
                least = squares[n];
                best = QNI_EIGHT * eight + n;
            }
    }
    return best;
}

static void search_eight(nearest_job *job, const qni_near_list *near, int32_t eight,
                         const float p[3], float slack) {
    float squares[QNI_EIGHT];
    measure(&near->eights[eight], p, slack, squares);
    for (int n = 0; n < QNI_EIGHT && QNI_EIGHT * eight + n < near->surface_count; ++n)
        if (squares[n] <= job->below)
            consider(job, near->numbers[QNI_EIGHT * eight + n]);
}

/* Four roundings to float, and more. */
static float slack_of(double size, const double p[3]) {
    return (float)(5e-7 *
                   qni_greater(size, qni_greater(fabs(p[0]), qni_greater(fabs(p[1]), fabs(p[2])))));
}

static void search(nearest_job *job, const qni_near_list *near, const float p[3], float slack) {
    const int32_t eights = eights_of(near->count);
    for (int32_t group = 0; group < eights_of(eights); ++group) {
        float squares[QNI_EIGHT];
        measure(&near->eights[eights + group], p, slack, squares);
        for (int n = 0; n < QNI_EIGHT; ++n)
            if (squares[n] <= job->below)
                search_eight(job, near, QNI_EIGHT * group + n, p, slack);
    }
}

int32_t qni_near_nearest(const qni_near_list *near, const qni_panel_tree *surface, double size,
                         const double p[3], int32_t guess, double *square, double nearest[3]) {
    const float at[3] = {(float)p[0], (float)p[1], (float)p[2]};
    nearest_job job = {surface, p, square, nearest, INFINITY, -1};
    *square = QNI_INFINITY;
    consider(&job, guess >= 0 && guess < surface->count ? guess
                                                        : near->numbers[place_to_begin(near, at)]);
    search(&job, near, at, slack_of(size, p));
    return job.best;
}

double qni_near_square(const qni_near_list *near, const qni_panel_tree *surface, double size,
                       const double p[3], double most) {
    const float at[3] = {(float)p[0], (float)p[1], (float)p[2]};
    double square = QNI_INFINITY, nearest[3];
    nearest_job job = {surface, p, &square, nearest, (float)(most * most * (1 + 1e-6)), -1};
    search(&job, near, at, slack_of(size, p));
    return square;
}
