// SPDX-License-Identifier: MIT
/* Restoring tunnels: the points round the two vertices that are cut out, and the tube of quads
 * between them.
 *
 * Every point starts on the border of the cell, where its mesh edge or its quad meets the surface,
 * and goes part of the way to the middle of the tunnel; from there it is brought back onto the
 * surface along the gradient. */
#include "dmc/repair_parts.h"
#include "dmc/vertex_hd.h"

#include <math.h>
#include <string.h>

enum { LONGEST_RING = 2 * QNI_EDGES };

/* ---- points ---------------------------------------------------------------------------------- */

void qni_edge_crossing(const double d[8], int edge, double local[3]) {
    const int from = qni_edge_start_corner(edge), axis = qni_edge_axis(edge);
    for (int a = 0; a < 3; ++a)
        local[a] = from >> a & 1;
    local[axis] = d[from] / (d[from] - d[from | 1 << axis]);
}

/* The middle of the arc between two edges on their face; the middle of their crossings where the
 * arc has shrunk to a point. */
static void segment_middle(const double d[8], int edge, int next, double local[3]) {
    const int face = qni_face_of_edges(edge, next), axis = face >> 1;
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    qni_square square;
    int side[2];
    double uw[2], ends[2][3];
    for (int n = 0; n < 4; ++n)
        square.v[n] = d[(face & 1) << axis | (n & 1) << p | (n >> 1) << q];
    for (int n = 0; n < 2; ++n) {
        const int own = n ? next : edge, across = qni_edge_axis(own) == p ? q : p;
        side[n] = 2 * (across == q) + qni_edge_side(own, across);
        qni_edge_crossing(d, own, ends[n]);
    }
    for (int a = 0; a < 3; ++a)
        local[a] = (ends[0][a] + ends[1][a]) * 0.5;
    if (qni_arc_middle(&square, side[0], side[1], uw)) {
        local[p] = uw[0];
        local[q] = uw[1];
    }
}

/* The interpolant and its gradient. */
static double evaluate(const double d[8], const double at[3], double gradient[3]) {
    for (int a = 0; a < 3; ++a) {
        const int p = a == 0 ? 1 : 0, q = a == 2 ? 1 : 2;
        double rise[4];
        for (int n = 0; n < 4; ++n) {
            const int c = (n & 1) << p | (n >> 1) << q;
            rise[n] = d[c | 1 << a] - d[c];
        }
        gradient[a] = qni_bilinear(rise[0], rise[1], rise[2], rise[3], at[p], at[q]);
    }
    return qni_lerp(qni_bilinear(d[0], d[1], d[2], d[3], at[0], at[1]),
                    qni_bilinear(d[4], d[5], d[6], d[7], at[0], at[1]), at[2]);
}

static double distance(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

bool qni_bring_to_surface(const double d[8], double reach, double at[3]) {
    double to[3] = {at[0], at[1], at[2]}, gradient[3], step = 1;
    for (int round = 0; round < 12 && step > 1e-7; ++round) {
        const double value = evaluate(d, to, gradient);
        const double squares =
            gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
        if (!(squares > 0))
            return false;
        step = fabs(value) / sqrt(squares);
        for (int a = 0; a < 3; ++a) {
            to[a] -= value * gradient[a] / squares;
            if (!(to[a] >= 0 && to[a] <= 1))
                return false;
        }
        if (!(distance(to, at) <= reach))
            return false;
    }
    if (step > 1e-7)
        return false;
    memcpy(at, to, sizeof to);
    return true;
}

/* How far the points go to the tunnel's middle. On 280 tunnels of smoothed noise 0.5 left 75 of
 * 5530 points off the surface, since the gradient is small there, 0.4 left 17; 0.3 left 7 and more
 * quads crossed. */
static const double nearness = 0.4;

static int place_point(const qni_repair_job *job, const qni_tunnel_cell *tunnel, const double d[8],
                       const double border[3], uint32_t vertex) {
    const int64_t cell[3] = {tunnel->cell[0], tunnel->cell[1], tunnel->cell[2]};
    double local[3];
    for (int a = 0; a < 3; ++a)
        local[a] = border[a] + nearness * (tunnel->middle[a] - border[a]);
    const bool found = qni_bring_to_surface(d, distance(border, tunnel->middle) * 0.5, local);
    qni_repair_place(job, cell, local, vertex);
    return !found;
}

/* Returns how many of the points could not be brought onto the surface. */
int qni_tunnel_place_end(const qni_repair_job *job, int64_t index) {
    const qni_repair *repair = job->dmc->repair;
    const qni_tunnel_cell *tunnel = repair->tunnels + index / 2;
    qni_tunnel_end *end = repair->ends + index;
    const int64_t cell[3] = {tunnel->cell[0], tunnel->cell[1], tunnel->cell[2]};
    const qni_quad_split *first = repair->splits + end->split[0];
    double d[8], border[3];
    int left = 0;
    qni_repair_load_corners(&job->dmc->field, cell, d);
    end->vertex = first->corners[qni_quad_corner(qni_ring_place(end->edge[0]), first->forward)];
    for (int n = 0; n < end->count; ++n) {
        qni_edge_crossing(d, end->edge[n], border);
        left += place_point(job, tunnel, d, border, qni_end_edge_vertex(job->dmc, end, n));
        segment_middle(d, end->edge[n], end->edge[n + 1 < end->count ? n + 1 : 0], border);
        left += place_point(job, tunnel, d, border, qni_end_segment_vertex(job->dmc, end, n));
    }
    return left;
}

/* ---- the tube -------------------------------------------------------------------------------- */

/* The ring of an end, as its quads' boundaries run: which edge each even place is of, and the
 * vertices. */
typedef struct ring {
    int count;
    int edge[LONGEST_RING];
    uint32_t vertex[LONGEST_RING];
} ring;

/* The corner of an edge's quad that the end cuts off. */
static int cut_corner(const qni_quad_split *split, const qni_tunnel_end *end, int edge) {
    return qni_quad_corner(qni_ring_place(end->edge[edge]), split->forward);
}

static void make_ring(const qni_dmc *dmc, const qni_tunnel_end *end, ring *r) {
    const qni_quad_split *first = dmc->repair->splits + end->split[0];
    const int corner = cut_corner(first, end, 0);
    const bool as_polygon =
        qni_cut_side_vertex(dmc, first, corner, true) == qni_end_segment_vertex(dmc, end, 0);
    r->count = 2 * end->count;
    for (int n = 0; n < end->count; ++n) {
        const int edge = as_polygon || n == 0 ? n : end->count - n;
        r->edge[2 * n] = edge;
        r->vertex[2 * n] = qni_end_edge_vertex(dmc, end, edge);
        r->vertex[2 * n + 1] = qni_end_segment_vertex(
            dmc, end, as_polygon ? edge : (edge + end->count - 1) % end->count);
    }
}

/* The halfedge of a ring from place `at` to the next. */
static uint32_t ring_halfedge(const qni_dmc *dmc, const qni_tunnel_end *end, const ring *r,
                              int at) {
    const int of_edge = at % 2 == 0 ? at : (at + 1) % r->count, edge = r->edge[of_edge];
    const qni_quad_split *split = dmc->repair->splits + end->split[edge];
    const int corner_at = qni_split_corner_at(split, cut_corner(split, end, edge)),
              count = qni_split_boundary_size(split);
    return qni_boundary_halfedge(dmc, split,
                                 at % 2 == 0 ? corner_at : (corner_at + count - 1) % count);
}

/* Walks the tube: the longer ring backward from an even place, the shorter one forward. Where the
 * longer ring has edges to spare, one quad takes two of its steps, over a segment's point, which
 * keeps the mesh edge it ends. */
typedef struct tube_walk {
    const ring *longer, *shorter;
    int start[2];
    int edge;    /* of the longer ring's */
    int step[2]; /* places gone along each ring */
    bool second; /* of the two quads of an edge of both rings */
} tube_walk;

/* The next quad, and how many places it takes along the longer ring: 1 or 2. */
static int walk_on(tube_walk *w, uint32_t quad[4]) {
    const int a_count = w->longer->count, b_count = w->shorter->count, edges = a_count / 2;
    const int before = w->edge * (b_count / 2) / edges,
              after = (w->edge + 1) * (b_count / 2) / edges;
    const int taken = after == before ? 2 : 1;
    const int a = w->start[0] + a_count - w->step[0], b = w->start[1] + w->step[1];
    quad[0] = w->longer->vertex[a % a_count];
    quad[1] = w->longer->vertex[(a + a_count - 1) % a_count];
    quad[2] = taken == 2 ? w->longer->vertex[(a + a_count - 2) % a_count]
                         : w->shorter->vertex[(b + 1) % b_count];
    quad[3] = w->shorter->vertex[b % b_count];
    w->step[0] += taken;
    w->step[1] += taken == 1;
    if (taken == 2 || w->second)
        ++w->edge;
    w->second = taken == 1 && !w->second;
    return taken;
}

static double squared_length(const float *positions, uint32_t from, uint32_t to) {
    double sum = 0;
    for (int a = 0; a < 3; ++a) {
        const double step =
            (double)positions[3 * (size_t)to + a] - (double)positions[3 * (size_t)from + a];
        sum += step * step;
    }
    return sum;
}

/* The squared lengths of all edges between the rings, summed. */
static double tube_length(const float *positions, tube_walk walk) {
    double sum = 0;
    while (walk.edge < walk.longer->count / 2) {
        uint32_t quad[4];
        walk_on(&walk, quad);
        sum += squared_length(positions, quad[0], quad[3]);
    }
    return sum;
}

/* The tube that twists least: all turns of the rings are tried. */
void qni_tunnel_close(const qni_repair_job *job, int64_t index) {
    const qni_dmc *dmc = job->dmc;
    const qni_tunnel_end *ends = dmc->repair->ends + 2 * index;
    qni_tunnel_tube *tube = dmc->repair->tubes + index;
    ring rings[2];
    tube->longer = ends[1].count > ends[0].count;
    make_ring(dmc, ends + tube->longer, rings);
    make_ring(dmc, ends + 1 - tube->longer, rings + 1);
    tube_walk best = {.longer = rings, .shorter = rings + 1};
    double least = -1;
    for (int a = 0; a < rings[0].count; a += 2)
        for (int b = 0; b < rings[1].count; ++b) {
            const tube_walk walk = {.longer = rings, .shorter = rings + 1, .start = {a, b}};
            const double length = tube_length(job->mesh->positions, walk);
            if (least < 0 || length < least) {
                least = length;
                best = walk;
            }
        }
    memcpy(tube->start, best.start, sizeof tube->start);
    uint32_t *quad = job->mesh->quads +
                     4 * (size_t)(dmc->quad_count + dmc->repair->split_quads + tube->first_quad);
    for (; best.edge < rings[0].count / 2; quad += 4)
        walk_on(&best, quad);
}

static void pair(uint32_t *twins, uint32_t a, uint32_t b) {
    twins[a] = b;
    twins[b] = a;
}

void qni_tunnel_link(const qni_dmc *dmc, int64_t index, uint32_t *twins) {
    const qni_tunnel_tube *tube = dmc->repair->tubes + index;
    const qni_tunnel_end *longer = dmc->repair->ends + 2 * index + tube->longer;
    const qni_tunnel_end *shorter = dmc->repair->ends + 2 * index + 1 - tube->longer;
    const int quads = longer->count + shorter->count;
    const uint32_t first =
        (uint32_t)(4 * (dmc->quad_count + dmc->repair->split_quads + tube->first_quad));
    ring rings[2];
    make_ring(dmc, longer, rings);
    make_ring(dmc, shorter, rings + 1);
    tube_walk walk = {
        .longer = rings, .shorter = rings + 1, .start = {tube->start[0], tube->start[1]}};
    for (int n = 0; n < quads; ++n) {
        const uint32_t h = first + 4 * (uint32_t)n, next = first + 4 * (uint32_t)((n + 1) % quads);
        const int a = walk.start[0] + rings[0].count - walk.step[0],
                  b = walk.start[1] + walk.step[1];
        uint32_t quad[4];
        const int taken = walk_on(&walk, quad);
        for (int k = 0; k < taken; ++k)
            pair(twins, h + (uint32_t)k,
                 ring_halfedge(dmc, longer, rings, (a + rings[0].count - 1 - k) % rings[0].count));
        if (taken == 1)
            pair(twins, h + 2, ring_halfedge(dmc, shorter, rings + 1, b % rings[1].count));
        pair(twins, h + (uint32_t)taken, next + 3);
    }
}
