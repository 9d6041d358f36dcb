// SPDX-License-Identifier: MIT
/* Internal ambiguity [CMS05 3.4]: two loops of a finest cell that are one tube.
 *
 * Of a trilinear f the eight corners tell, exactly (face/tunnel_hd.h); of solids, samples and
 * crossings inside the cell (tube_solid.c). The tube is a strip between
 * the two loops, the one of least area by dynamic programming; no edge of it lies in a wall. Where
 * there is none such, it joins copies of the loops drawn towards the tube's middle. All is tested
 * on exact predicates, the tube against itself and what else is in the cell; the next best
 * beginnings are tried, then other copies, then the way that always works (nest.c). */
#include "cms/cms.h"
#include "core/cube_hd.h"
#include "face/tunnel_hd.h"

#include <math.h>
#include <string.h>

enum { MOST_VERTICES = 24, BEGINNINGS = 6, NEST_ATTEMPTS = 6 };

/* ---- which loops ----------------------------------------------------------------------------- */

/* The regions of a cell's corners by its border, as for dmc: joined are the ends of edges without
 * crossing, and across a face those that the decider joins. */
static void border_regions(const double d[8], int region[8]) {
    for (int corner = 0; corner < QNI_CORNERS; ++corner)
        region[corner] = corner;
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        const int from = qni_edge_start_corner(edge), to = from | 1 << qni_edge_axis(edge);
        if ((d[from] >= 0) == (d[to] >= 0))
            qni_merge_regions(region, region[from], region[to]);
    }
    for (int face = 0; face < QNI_FACES; ++face) {
        int corner[4];
        for (int n = 0; n < 4; ++n)
            corner[n] = qni_face_corner(face, n);
        const bool above = d[corner[0]] >= 0;
        if ((d[corner[1]] >= 0) == above || (d[corner[2]] >= 0) != above ||
            (d[corner[3]] >= 0) == above)
            continue;
        const int first = above ? 0 : 1; /* corners first and first + 2 are above */
        const bool joined = qni_face_joins_above(qni_face_saddle_sign(
            d[corner[first]], d[corner[first + 2]], d[corner[1 - first]], d[corner[3 - first]]));
        const int n = joined ? first : 1 - first;
        qni_merge_regions(region, region[corner[n]], region[corner[n + 2]]);
    }
}

/* The values as the decider takes them: 0 and more is above. */
static bool load_values(const qni_patch *patch, double d[8]) {
    if (!patch->settings->scalar || patch->cell.level != 0 ||
        !qni_hermite_cell_values(patch->hermite, patch->cell.low, d))
        return false;
    for (int corner = 0; corner < QNI_CORNERS; ++corner) {
        d[corner] = patch->settings->join_ties ? -d[corner] : d[corner];
        if (fabs(d[corner]) < 1e-200) /* stands for a sample on the surface */
            d[corner] = 0;
    }
    return true;
}

/* The two regions that meet at a loop. */
static int label_of(const qni_patch *patch, const qni_loop *loop, const double d[8],
                    const int region[8]) {
    const int edge =
        qni_edge_of_walls(patch->vertices[loop->first].walls); /* loops begin at crossings */
    const int from = qni_edge_start_corner(edge), to = from | 1 << qni_edge_axis(edge);
    return d[from] >= 0 ? 8 * region[from] + region[to] : 8 * region[to] + region[from];
}

bool qni_patch_find_tube(qni_patch *patch, int tube[2], double middle[3]) {
    double d[8];
    qni_edge_place stretch[4][2];
    int region[8], side, pairs = 0;
    if (!patch->settings->scalar)
        return qni_patch_find_solid_tube(patch, tube, middle);
    if (!load_values(patch, d))
        return false;
    const int joining = qni_joining_edges(d, stretch);
    if (!joining)
        return false;
    border_regions(d, region);
    if (!qni_join_regions(d, joining, (const qni_edge_place(*)[2])stretch, region, &side, middle))
        return false;
    for (int64_t m = 0; m < patch->loop_count; ++m)
        for (int64_t n = m + 1; n < patch->loop_count; ++n)
            if (label_of(patch, &patch->loops[m], d, region) ==
                label_of(patch, &patch->loops[n], d, region)) {
                tube[0] = (int)m;
                tube[1] = (int)n;
                ++pairs;
            }
    for (int k = 0; k < 3; ++k)
        middle[k] =
            (double)patch->low[k] + middle[k] * ((double)patch->high[k] - (double)patch->low[k]);
    return pairs == 1;
}

/* ---- the strip ------------------------------------------------------------------------------- */

/* A strip is a path: `i` steps along the first loop, `j` backwards along the second, whose walk
 * begins at `start`. All of one loop about one vertex of the other would have an edge twice; so
 * states tell whether a step along the second loop has been taken between the ends of the first
 * (1), and the other way round (2). */
enum { STATES = 4 };

typedef struct strip_step {
    double cost;
    int8_t state; /* before this step */
    bool along_a; /* the step was along the first loop */
} strip_step;

typedef struct strip_ring {
    int32_t ids[MOST_VERTICES]; /* of the patch's vertices or inner points, in the loop's order */
    int count;
} strip_ring;

typedef struct strip_job {
    const qni_patch *patch;
    strip_ring a, b;
    int start;
    strip_step steps[MOST_VERTICES + 1][MOST_VERTICES + 1][STATES];
} strip_job;

static int32_t vertex_a(const strip_job *job, int i) {
    return job->a.ids[i % job->a.count];
}

static int32_t vertex_b(const strip_job *job, int j) {
    return job->b.ids[(job->start + 2 * job->b.count - j) % job->b.count];
}

static double area_of(const qni_patch *patch, int32_t p, int32_t q, int32_t r) {
    const float *a = qni_patch_place(patch, p), *b = qni_patch_place(patch, q),
                *c = qni_patch_place(patch, r);
    double u[3], v[3], square = 0;
    for (int k = 0; k < 3; ++k) {
        u[k] = (double)b[k] - (double)a[k];
        v[k] = (double)c[k] - (double)a[k];
    }
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        const double x = u[l] * v[m] - u[m] * v[l];
        square += x * x;
    }
    return sqrt(square);
}

/* An edge that lies in a wall may be an edge of the cell across, too. */
static bool lies_in_wall(const strip_job *job, int i, int j) {
    const int32_t a = vertex_a(job, i), b = vertex_b(job, j);
    return a < QNI_INNER && b < QNI_INNER &&
           (job->patch->vertices[a].walls & job->patch->vertices[b].walls);
}

static void offer(strip_job *job, int i, int j, int state, double cost, int before, bool along_a) {
    strip_step *step = &job->steps[i][j][state];
    if (cost < step->cost) {
        const strip_step better = {cost, (int8_t)before, along_a};
        *step = better;
    }
}

/* The best ways to a place from the two before it. */
static void reach(strip_job *job, int i, int j) {
    const int n = job->a.count, m = job->b.count;
    const double by_a =
        i > 0 ? area_of(job->patch, vertex_a(job, i - 1), vertex_a(job, i), vertex_b(job, j)) : 0;
    const double by_b =
        j > 0 ? area_of(job->patch, vertex_b(job, j), vertex_b(job, j - 1), vertex_a(job, i)) : 0;
    for (int state = 0; state < STATES; ++state) {
        if (i > 0)
            offer(job, i, j, state | (j > 0 && j < m ? 2 : 0),
                  job->steps[i - 1][j][state].cost + by_a, state, true);
        if (j > 0)
            offer(job, i, j, state | (i > 0 && i < n ? 1 : 0),
                  job->steps[i][j - 1][state].cost + by_b, state, false);
    }
}

/* Least area of strips that begin with the edge from the first vertex to the second loop's `start`.
 */
static double solve_strip(strip_job *job) {
    const strip_step none = {HUGE_VAL, 0, false};
    for (int i = 0; i <= job->a.count; ++i)
        for (int j = 0; j <= job->b.count; ++j) {
            for (int state = 0; state < STATES; ++state)
                job->steps[i][j][state] = none;
            if (lies_in_wall(job, i, j))
                continue;
            if (i + j == 0)
                job->steps[0][0][0].cost = 0;
            else
                reach(job, i, j);
        }
    return job->steps[job->a.count][job->b.count][STATES - 1].cost;
}

static void add_triangle(qni_patch *patch, int32_t a, int32_t b, int32_t c) {
    if (!qni_patch_grow(patch, (void **)&patch->triangles, &patch->triangle_capacity,
                        patch->triangle_count + 1, sizeof *patch->triangles))
        return;
    int32_t *triangle = patch->triangles[patch->triangle_count++];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
    triangle[3] = -1;
}

static void add_strip(qni_patch *patch, const strip_job *job) {
    int i = job->a.count, j = job->b.count, state = STATES - 1;
    while (i + j > 0) {
        const strip_step *step = &job->steps[i][j][state];
        if (step->along_a) {
            add_triangle(patch, vertex_a(job, i - 1), vertex_a(job, i), vertex_b(job, j));
            --i;
        } else {
            add_triangle(patch, vertex_b(job, j), vertex_b(job, j - 1), vertex_a(job, i));
            --j;
        }
        state = step->state;
    }
}

/* The beginnings by their areas, best first; how many there are. */
static int order_beginnings(strip_job *job, int starts[BEGINNINGS]) {
    double areas[BEGINNINGS];
    int count = 0;
    for (job->start = 0; job->start < job->b.count; ++job->start) {
        const double area = solve_strip(job);
        if (!(area < HUGE_VAL) || (count == BEGINNINGS && area >= areas[count - 1]))
            continue;
        int at = count < BEGINNINGS ? count++ : count - 1;
        for (; at > 0 && areas[at - 1] > area; --at) {
            areas[at] = areas[at - 1];
            starts[at] = starts[at - 1];
        }
        areas[at] = area;
        starts[at] = job->start;
    }
    return count;
}

/* ---- the cell -------------------------------------------------------------------------------- */

/* What a tube is made with. `share` 0: straight from loop to loop. Else there is a ring of copies
 * of each loop, drawn that much towards the middle, and the strip joins the rings. */
typedef struct tube_plan {
    const int *tube;
    const double *middle;
    double share;
    int others; /* the other loops: 0 as they are placed, 1 own vertices only, 2 fans from means */
} tube_plan;

static void take_loop(const qni_patch *patch, int index, strip_ring *ring) {
    const qni_loop *loop = &patch->loops[index];
    ring->count = loop->count;
    for (int32_t n = 0; n < loop->count; ++n)
        ring->ids[n] = loop->first + n;
}

/* Copies of the loop's vertices, and the strip from it to them. */
static void draw_ring(qni_patch *patch, int index, const tube_plan *plan, strip_ring *ring) {
    const qni_loop *loop = &patch->loops[index];
    if (!qni_patch_grow(patch, (void **)&patch->inner, &patch->inner_capacity,
                        patch->inner_count + loop->count, sizeof *patch->inner))
        return;
    for (int32_t n = 0; n < loop->count; ++n) {
        const float *from = patch->vertices[loop->first + n].place;
        float *to = patch->inner[patch->inner_count];
        for (int k = 0; k < 3; ++k)
            to[k] = qni_between((double)from[k] + plan->share * (plan->middle[k] - (double)from[k]),
                                patch->clear_low[k], patch->clear_high[k]);
        ring->ids[n] = QNI_INNER + (int32_t)patch->inner_count++;
    }
    for (int32_t n = 0; n < loop->count; ++n) {
        const int32_t next = (n + 1) % loop->count;
        add_triangle(patch, loop->first + n, loop->first + next, ring->ids[next]);
        add_triangle(patch, loop->first + n, ring->ids[next], ring->ids[n]);
    }
}

static void build_others(qni_patch *patch, const tube_plan *plan) {
    for (int n = 0; n < patch->loop_count; ++n) {
        qni_loop *loop = &patch->loops[n];
        if (n == plan->tube[0] || n == plan->tube[1])
            qni_patch_drop_loop(patch, n);
        else if (plan->others > 0)
            qni_patch_rebuild_simply(patch, loop, plan->others == 2);
        else if (!qni_patch_flat(patch, loop, false))
            qni_patch_fan(patch, loop);
    }
}

/* All triangles of the cell but the strip itself; the rings that it is to join. */
static void prepare(qni_patch *patch, const tube_plan *plan, strip_job *job) {
    patch->triangle_count = patch->inner_count = 0;
    build_others(patch, plan);
    qni_patch_drop_loop(patch, plan->tube[0]); /* its triangles are the last ones */
    take_loop(patch, plan->tube[0], &job->a);
    take_loop(patch, plan->tube[1], &job->b);
    if (plan->share > 0) {
        draw_ring(patch, plan->tube[0], plan, &job->a);
        draw_ring(patch, plan->tube[1], plan, &job->b);
    }
}

static bool make_strip(qni_patch *patch, const tube_plan *plan) {
    qni_loop *loop = &patch->loops[plan->tube[0]];
    if (loop->count > MOST_VERTICES || patch->loops[plan->tube[1]].count > MOST_VERTICES)
        return false;
    strip_job job;
    int starts[BEGINNINGS];
    job.patch = patch;
    prepare(patch, plan, &job);
    const int64_t before = patch->triangle_count;
    const int count = order_beginnings(&job, starts);
    for (int n = 0; n < count && !patch->failed; ++n) {
        patch->triangle_count = before;
        job.start = starts[n];
        solve_strip(&job);
        add_strip(patch, &job);
        loop->triangle_count = (int32_t)patch->triangle_count - loop->triangle_first;
        if (!qni_patch_meets_itself(patch))
            return true;
    }
    return false;
}

bool qni_patch_make_tube(qni_patch *patch, const int tube[2], const double middle[3],
                         qni_cms_tally *tally) {
    static const double shares[] = {0, 0.3, 0.15, 0.5, 0.05};
    tube_plan plan = {tube, middle, 0, 0};
    for (plan.others = 0; plan.others < (patch->loop_count > 2 ? 3 : 1); ++plan.others)
        for (size_t n = 0; n < sizeof shares / sizeof *shares && !patch->failed; ++n) {
            plan.share = shares[n];
            if (make_strip(patch, &plan)) {
                ++tally->tubes;
                return true;
            }
        }
    for (int attempt = 0; attempt < NEST_ATTEMPTS && !patch->failed; ++attempt)
        if (qni_patch_nest(patch, tube, attempt) && !qni_patch_meets_itself(patch)) {
            ++tally->tubes;
            ++tally->nested_tubes;
            return true;
        }
    ++tally->lost_tubes;
    patch->inner_count = 0;
    return false;
}
