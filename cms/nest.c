// SPDX-License-Identifier: MIT
/* The way that always keeps the loops of a finest cell apart: nested boxes.
 *
 * Each loop parts the cell's walls in two; it gets the part that does not hold a chosen corner, its
 * lid. The loop is drawn inward, as a strip of the cone over it about the cell's middle, to the
 * surface of a smaller box, and closed there by the copy of its lid. Cones over different loops are
 * apart; a loop within another's lid is drawn less deep, so strips miss the lids of others.
 *
 * Two loops that are one tube are both drawn inward to the same box, and joined there by the copy
 * of what of the walls lies between them: the outer lid less the inner one. */
#include "cms/cms.h"
#include "core/cube_hd.h"
#include "mesh/predicates.h"

#include <string.h>

enum { MOST_LOOPS = 32, MOST_POLYGON = 256, SHARES = 16, MOST_HEIGHT = SHARES / 2 - 2 };

typedef struct nest_job {
    qni_patch *patch;
    int reference;                        /* a corner that no lid holds */
    int outer, inner;                     /* the loops of a tube; -1: there is none */
    bool in_lid[MOST_LOOPS][QNI_CORNERS]; /* of each loop: which corners of the cell */
    int height[MOST_LOOPS];
    float inner_low[3], inner_high[3]; /* walls of the box in use */
    double share;
    int32_t copies[MOST_LOOPS]; /* first inner point of each loop */
    int32_t corners[QNI_CORNERS];
} nest_job;

static const qni_loop_vertex *vertex_of(const nest_job *job, const qni_loop *loop, int32_t n) {
    return &job->patch->vertices[loop->first + n % loop->count];
}

static int crossings_on_edge(const nest_job *job, const qni_loop *loop, int edge) {
    int count = 0;
    for (int32_t n = 0; n < loop->count; ++n)
        count += vertex_of(job, loop, n)->crossing &&
                 qni_edge_of_walls(vertex_of(job, loop, n)->walls) == edge;
    return count;
}

/* Corners reached from the reference over an odd number of the loop's crossings. */
static void find_lid(nest_job *job, int index) {
    const qni_loop *loop = &job->patch->loops[index];
    bool *in_lid = job->in_lid[index];
    in_lid[0] = false;
    for (int corner = 1; corner < QNI_CORNERS; ++corner) {
        const int axis = __builtin_ctz((unsigned)corner), before = corner & (corner - 1);
        in_lid[corner] =
            in_lid[before] ^ (crossings_on_edge(job, loop, qni_edge_at(axis, before)) & 1);
    }
    const bool turned = in_lid[job->reference];
    for (int corner = 0; corner < QNI_CORNERS; ++corner)
        in_lid[corner] ^= turned;
}

/* Does a vertex of one loop lie in the lid of another? */
static bool lies_in_lid(const nest_job *job, int inner, int outer) {
    const qni_loop *loop = &job->patch->loops[outer];
    const qni_loop_vertex *vertex = vertex_of(job, &job->patch->loops[inner], 0);
    const int edge = qni_edge_of_walls(vertex->walls), axis = qni_edge_axis(edge);
    bool within = job->in_lid[outer][qni_edge_start_corner(edge)];
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *other = vertex_of(job, loop, n);
        within ^= other->crossing && qni_edge_of_walls(other->walls) == edge &&
                  other->place[axis] < vertex->place[axis];
    }
    return within;
}

static bool find_heights(nest_job *job) {
    const int count = (int)job->patch->loop_count;
    memset(job->height, 0, sizeof job->height);
    for (int round = 0; round < count; ++round)
        for (int outer = 0; outer < count; ++outer)
            for (int inner = 0; inner < count; ++inner)
                if (inner != outer && lies_in_lid(job, inner, outer) &&
                    job->height[outer] <= job->height[inner])
                    job->height[outer] = job->height[inner] + 1;
    for (int n = 0; n < count; ++n)
        if (job->height[n] > MOST_HEIGHT)
            return false;
    return true;
}

/* ---- points of the smaller box
 * --------------------------------------------------------------------- */

static void draw_inward(const nest_job *job, const float place[3], float out[3]) {
    const qni_patch *patch = job->patch;
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * ((double)patch->low[k] + (double)patch->high[k]);
        if (place[k] == patch->low[k])
            out[k] = job->inner_low[k];
        else if (place[k] == patch->high[k])
            out[k] = job->inner_high[k];
        else
            out[k] = qni_between(middle + (1 - 2 * job->share) * ((double)place[k] - middle),
                                 job->inner_low[k], job->inner_high[k]);
    }
}

static int32_t add_inner(nest_job *job, const float place[3]) {
    qni_patch *patch = job->patch;
    if (!qni_patch_grow(patch, (void **)&patch->inner, &patch->inner_capacity,
                        patch->inner_count + 1, sizeof *patch->inner))
        return QNI_INNER;
    draw_inward(job, place, patch->inner[patch->inner_count]);
    return QNI_INNER + (int32_t)patch->inner_count++;
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

static void add_strip(nest_job *job, int index) {
    const qni_loop *loop = &job->patch->loops[index];
    const int32_t copies = job->copies[index];
    for (int32_t n = 0; n < loop->count; ++n) {
        const int32_t next = (n + 1) % loop->count;
        add_triangle(job->patch, loop->first + n, loop->first + next, copies + next);
        add_triangle(job->patch, loop->first + n, copies + next, copies + n);
    }
}

/* ---- lids
 * ------------------------------------------------------------------------------------------ */

/* The boundary of a wall, counter-clockwise seen from outside: corners, and the loops' crossings
 * between them. */
typedef struct wall_node {
    int corner; /* or -1 */
    int loop;   /* of which the next is a vertex */
    int32_t vertex;
    int partner; /* the node at the other end of its segment */
    int bends;   /* vertices between them in the loop, 0 to 2 */
    bool starts; /* the loop runs from here to the partner */
} wall_node;

typedef struct wall_path {
    wall_node nodes[4 + QNI_FACE_POINTS];
    int count;
} wall_path;

static bool lies_on_edge(const qni_loop_vertex *vertex, int edge) {
    return vertex->crossing && qni_edge_of_walls(vertex->walls) == edge;
}

static const qni_loop_vertex *vertex_of_node(const nest_job *job, const wall_node *node) {
    return vertex_of(job, &job->patch->loops[node->loop], node->vertex);
}

static void add_side(const nest_job *job, int index, wall_path *wall, int first, int axis, int edge,
                     bool up) {
    const qni_loop *loop = &job->patch->loops[index];
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = vertex_of(job, loop, n);
        if (!lies_on_edge(vertex, edge))
            continue;
        int at = wall->count++;
        for (; at > first; --at) {
            const float before = vertex_of_node(job, &wall->nodes[at - 1])->place[axis];
            if (up ? before < vertex->place[axis] : before > vertex->place[axis])
                break;
            wall->nodes[at] = wall->nodes[at - 1];
        }
        const wall_node node = {-1, index, n, -1, 0, false};
        wall->nodes[at] = node;
    }
}

static int node_of_vertex(const wall_path *wall, int loop, int32_t vertex) {
    for (int n = 0; n < wall->count; ++n)
        if (wall->nodes[n].corner < 0 && wall->nodes[n].loop == loop &&
            wall->nodes[n].vertex == vertex)
            return n;
    return -1;
}

/* Join the ends of a loop's segments that lie on this wall. */
static void join_nodes(const nest_job *job, int index, wall_path *wall, int face) {
    const qni_loop *loop = &job->patch->loops[index];
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *vertex = vertex_of(job, loop, n),
                              *next = vertex_of(job, loop, n + 1);
        if (!vertex->crossing || !(vertex->walls & next->walls & 1 << face))
            continue;
        int bends = 0;
        while (!vertex_of(job, loop, n + 1 + bends)->crossing)
            ++bends;
        const int32_t end = (n + 1 + bends) % loop->count;
        const int a = node_of_vertex(wall, index, n), b = node_of_vertex(wall, index, end);
        if (a < 0 || b < 0)
            continue;
        wall->nodes[a].partner = b;
        wall->nodes[b].partner = a;
        wall->nodes[a].bends = wall->nodes[b].bends = bends;
        wall->nodes[a].starts = true;
        wall->nodes[b].starts = false;
    }
}

/* With one loop, or with two: `second` is -1 or the other. */
static void make_wall(const nest_job *job, int index, int second, int face, wall_path *wall) {
    wall->count = 0;
    for (int n = 0; n < 4; ++n) {
        const int a = qni_face_points_out(face) ? n : 3 - n,
                  b = qni_face_points_out(face) ? (n + 1) % 4 : (6 - n) % 4;
        const int from = qni_face_corner(face, a), to = qni_face_corner(face, b);
        const int axis = __builtin_ctz((unsigned)(from ^ to)), edge = qni_edge_at(axis, from);
        const wall_node corner = {from, -1, -1, -1, 0, false};
        wall->nodes[wall->count++] = corner;
        const int first = wall->count;
        add_side(job, index, wall, first, axis, edge, to > from);
        if (second >= 0)
            add_side(job, second, wall, first, axis, edge, to > from);
    }
    join_nodes(job, index, wall, face);
    if (second >= 0)
        join_nodes(job, second, wall, face);
}

/* ---- triangles of one polygon in a wall of the smaller box
 * ------------------------------------------- */

typedef struct lid_polygon {
    int32_t points[MOST_POLYGON];
    int count;
    int p, q; /* axes in which it is counter-clockwise */
} lid_polygon;

static int turn(const nest_job *job, const lid_polygon *polygon, int32_t a, int32_t b, int32_t c) {
    return qni_orient2d(qni_patch_place(job->patch, a), qni_patch_place(job->patch, b),
                        qni_patch_place(job->patch, c), polygon->p, polygon->q);
}

static bool is_ear(const nest_job *job, const lid_polygon *polygon, int n) {
    const int32_t a = polygon->points[(n + polygon->count - 1) % polygon->count],
                  b = polygon->points[n], c = polygon->points[(n + 1) % polygon->count];
    if (turn(job, polygon, a, b, c) <= 0)
        return false;
    for (int m = 0; m < polygon->count; ++m) {
        const int32_t v = polygon->points[m];
        if (v != a && v != b && v != c && turn(job, polygon, a, b, v) >= 0 &&
            turn(job, polygon, b, c, v) >= 0 && turn(job, polygon, c, a, v) >= 0)
            return false;
    }
    return true;
}

static bool clip_ears(nest_job *job, lid_polygon *polygon, bool reversed) {
    while (polygon->count > 2) {
        int n = 0;
        while (n < polygon->count && !is_ear(job, polygon, n))
            ++n;
        if (n == polygon->count)
            return false;
        const int32_t a = polygon->points[(n + polygon->count - 1) % polygon->count],
                      b = polygon->points[n], c = polygon->points[(n + 1) % polygon->count];
        add_triangle(job->patch, a, reversed ? c : b, reversed ? b : c);
        memmove(polygon->points + n, polygon->points + n + 1,
                sizeof *polygon->points * (size_t)(polygon->count - n - 1));
        --polygon->count;
    }
    return true;
}

static bool push(lid_polygon *polygon, int32_t point) {
    if (polygon->count == MOST_POLYGON)
        return false;
    polygon->points[polygon->count++] = point;
    return true;
}

/* The region of the wall that begins with an arc: along the boundary, and across by segments. */
static bool trace_region(nest_job *job, const wall_path *wall, int start, bool *visited,
                         lid_polygon *polygon) {
    polygon->count = 0;
    int arc = start;
    do {
        visited[arc] = true;
        const int node = (arc + 1) % wall->count;
        const wall_node *at = &wall->nodes[node];
        if (at->corner >= 0) {
            if (!push(polygon, job->corners[at->corner]))
                return false;
            arc = node;
            continue;
        }
        if (at->partner < 0)
            return false;
        const int32_t count = job->patch->loops[at->loop].count;
        for (int n = 0; n <= at->bends + 1; ++n)
            if (!push(polygon,
                      job->copies[at->loop] + (at->vertex + (at->starts ? n : count - n)) % count))
                return false;
        arc = at->partner;
    } while (arc != start && polygon->count < MOST_POLYGON);
    return arc == start;
}

/* Is a corner in what closes a loop: its lid, or what lies between the two of a tube? */
static bool in_region(const nest_job *job, int index, int second, int corner) {
    return job->in_lid[index][corner] != (second >= 0 && job->in_lid[second][corner]);
}

static bool add_lid_on_wall(nest_job *job, int index, int second, int face, bool reversed) {
    wall_path wall;
    bool visited[4 + QNI_FACE_POINTS] = {false};
    make_wall(job, index, second, face, &wall);
    const int axis = face >> 1, p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    lid_polygon polygon = {.p = qni_face_points_out(face) ? p : q,
                           .q = qni_face_points_out(face) ? q : p};
    bool in_lid = false;
    for (int arc = 0; arc < wall.count; ++arc) {
        in_lid = wall.nodes[arc].corner >= 0 ? in_region(job, index, second, wall.nodes[arc].corner)
                                             : !in_lid;
        if (!in_lid || visited[arc])
            continue;
        if (!trace_region(job, &wall, arc, visited, &polygon) ||
            !clip_ears(job, &polygon, reversed))
            return false;
    }
    return true;
}

/* Is the lid the part of the walls that is in the solid? The loop has it on its right, seen from
 * outside. */
static bool lid_is_inside(const nest_job *job, int index) {
    const qni_loop *loop = &job->patch->loops[index];
    const qni_loop_vertex *vertex = vertex_of(job, loop, 0);
    const int edge = qni_edge_of_walls(vertex->walls), axis = qni_edge_axis(edge);
    bool before =
        job->in_lid[index]
                   [qni_edge_start_corner(edge)]; /* just before the crossing, along the edge */
    for (int32_t n = 0; n < loop->count; ++n) {
        const qni_loop_vertex *other = vertex_of(job, loop, n);
        before ^= lies_on_edge(other, edge) && other->place[axis] < vertex->place[axis];
    }
    return before != vertex->crossing->enters;
}

static void copy_loop(nest_job *job, int index) {
    const qni_loop *loop = &job->patch->loops[index];
    job->copies[index] = QNI_INNER + (int32_t)job->patch->inner_count;
    for (int32_t n = 0; n < loop->count; ++n)
        add_inner(job, vertex_of(job, loop, n)->place);
}

/* One loop with its lid, or the two of a tube. */
static bool add_nested(nest_job *job, int index, int second) {
    qni_patch *patch = job->patch;
    qni_loop *loop = &patch->loops[index];
    for (int k = 0; k < 3; ++k) {
        const double size = (double)patch->high[k] - (double)patch->low[k];
        job->inner_low[k] = (float)((double)patch->low[k] + job->share * size);
        job->inner_high[k] = (float)((double)patch->high[k] - job->share * size);
    }
    copy_loop(job, index);
    if (second >= 0)
        copy_loop(job, second);
    for (int corner = 0; corner < QNI_CORNERS; ++corner) {
        if (!in_region(job, index, second, corner))
            continue;
        float place[3];
        for (int k = 0; k < 3; ++k)
            place[k] = corner >> k & 1 ? patch->high[k] : patch->low[k];
        job->corners[corner] = add_inner(job, place);
    }
    if (patch->failed)
        return false;
    loop->has_apex = false;
    loop->triangle_first = (int32_t)patch->triangle_count;
    add_strip(job, index);
    if (second >= 0)
        add_strip(job, second);
    const bool reversed = lid_is_inside(job, index);
    for (int face = 0; face < QNI_FACES; ++face)
        if (!add_lid_on_wall(job, index, second, face, reversed))
            return false;
    loop->triangle_count = (int32_t)patch->triangle_count - loop->triangle_first;
    return !patch->failed;
}

static void find_lids(nest_job *job, int reference) {
    job->reference = reference;
    for (int n = 0; n < job->patch->loop_count; ++n)
        find_lid(job, n);
}

/* A reference beyond one loop of the tube, so that one lid holds the other. */
static bool lay_tube(nest_job *job, const int tube[2]) {
    for (int corner = 0; corner < QNI_CORNERS; ++corner) {
        find_lids(job, corner);
        for (int n = 0; n < 2; ++n) {
            job->outer = tube[n];
            job->inner = tube[1 - n];
            if (lies_in_lid(job, job->inner, job->outer))
                return true;
        }
    }
    return false;
}

bool qni_patch_nest(qni_patch *patch, const int *tube, int attempt) {
    nest_job job = {.patch = patch, .outer = -1, .inner = -1};
    if (patch->loop_count > MOST_LOOPS || patch->cell.level != 0)
        return false;
    patch->triangle_count = patch->inner_count = 0;
    find_lids(&job, 0);
    if ((tube && !lay_tube(&job, tube)) || !find_heights(&job))
        return false;
    for (int n = 0; n < patch->loop_count; ++n) {
        job.share = (job.height[n] + 1.0) / (SHARES + attempt);
        if (n == job.inner) {
            qni_patch_drop_loop(patch, n);
            continue;
        }
        if (!add_nested(&job, n, n == job.outer ? job.inner : -1))
            return false;
    }
    return true;
}
