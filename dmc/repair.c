// SPDX-License-Identifier: MIT
/* Splitting the quads at doubled edges: where the new vertices lie, which quads they make. All of
 * it is arithmetic on the cells at hand; every point and every quad is written by itself. */
#include "dmc/repair_parts.h"
#include "dmc/cell_hd.h"
#include "dmc/vertex_hd.h"
#include "core/context.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

/* ---- vertices -------------------------------------------------------------------------------- */

/* The same order as in place_hd.h. */
static void load_stencil(const qni_field *field, const int64_t cell[3],
                         double stencil[QNI_STENCIL]) {
    for (int n = 0; n < QNI_STENCIL; ++n) {
        int step[3];
        if (n < 16) {
            step[0] = n % 4 - 1;
            step[1] = n / 4 & 1;
            step[2] = n / 8;
        } else {
            const int beside = n < 24 ? 1 : 2, other = 3 - beside, m = n - (n < 24 ? 16 : 24);
            step[0] = m & 1;
            step[beside] = m < 4 ? -1 : 2;
            step[other] = m >> 1 & 1;
        }
        const int64_t point[3] = {cell[0] + step[0], cell[1] + step[1], cell[2] + step[2]};
        stencil[n] = qni_field_extended_value(field, point);
    }
}

void qni_repair_place(const qni_repair_job *job, const int64_t cell[3], const double local[3],
                      int64_t vertex) {
    double stencil[QNI_STENCIL];
    const double at[3] = {(double)cell[0], (double)cell[1], (double)cell[2]};
    float position[3], normal[3];
    load_stencil(&job->dmc->field, cell, stencil);
    qni_place_point(stencil, at, local, job->frame, position, normal);
    qni_store_vertex(job->mesh, vertex, position, normal, stencil, local, job->frame);
}

void qni_repair_load_corners(const qni_field *field, const int64_t cell[3], double d[8]) {
    for (int c = 0; c < 8; ++c)
        d[c] =
            qni_field_value(field, cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2));
}

/* The middle of a segment's arc on its face, in the face's two axes; `length` of the arc's chord.
 */
static bool arc_middle(const qni_doubled_face *face, int segment, const double d[8], double uw[2],
                       double *length) {
    const int axis = face->axis, p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    qni_square square;
    int side[2];
    double ends[2][2];
    for (int n = 0; n < 4; ++n)
        square.v[n] = d[(n & 1) << p | (n >> 1) << q];
    for (int n = 0; n < 2; ++n) {
        const int edge = qni_face_edge(2 * axis, face->first_cut + 2 * segment + 3 + n);
        const int across = qni_edge_axis(edge) == p ? q : p;
        const int start = qni_edge_start_corner(edge), end = start | 1 << qni_edge_axis(edge);
        const double at = d[start] / (d[start] - d[end]);
        side[n] = 2 * (across == q) + qni_edge_side(edge, across);
        ends[n][across == q] = qni_edge_side(edge, across);
        ends[n][across != q] = at;
    }
    *length = hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]);
    return qni_arc_middle(&square, side[0], side[1], uw);
}

/* From the arc's middle into a cell, along the surface: in the slice across one axis of the face,
 * the arc that starts in the middle is followed to a plane at `depth` from the face. There the
 * slice is linear along the face's other axis, so the surface has one point; as long as the ends of
 * that line keep their signs, it is on the same arc, hence on the right branch. */
static bool follow(const double d[8], int axis, int face_side, const double uw[2], int slice,
                   double depth, double *found) {
    const int in_face[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    const int across = in_face[slice], along = in_face[1 - slice];
    double at_face[2], inside[2];
    for (int n = 0; n < 2; ++n) {
        const int near = n << along | face_side << axis, far = n << along | (1 - face_side) << axis;
        const double on_face = qni_lerp(d[near], d[near | 1 << across], uw[slice]);
        const double opposite = qni_lerp(d[far], d[far | 1 << across], uw[slice]);
        at_face[n] = on_face;
        inside[n] = qni_lerp(on_face, opposite, depth);
    }
    *found = inside[0] / (inside[0] - inside[1]);
    return qni_differ(at_face[0], at_face[1]) && qni_differ(inside[0], inside[1]) &&
           (at_face[0] >= 0) == (inside[0] >= 0);
}

/* The point of a segment in the cell above its face (side 0) or below it (side 1); false when it
 * stays on the face. */
static bool point_in_cell(const double d[8], int axis, int face_side, const double uw[2],
                          double first_depth, double local[3]) {
    const int in_face[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    for (double depth = first_depth; depth > first_depth / 64; depth /= 2) {
        double found[2], move[2] = {2, 2};
        for (int slice = 0; slice < 2; ++slice)
            if (follow(d, axis, face_side, uw, slice, depth, found + slice))
                move[slice] = fabs(found[slice] - uw[1 - slice]);
        if (fmin(move[0], move[1]) >= 2)
            continue;
        const int slice = move[0] <= move[1] ? 0 : 1;
        local[axis] = face_side ? 1 - depth : depth;
        local[in_face[slice]] = uw[slice];
        local[in_face[1 - slice]] = found[slice];
        return true;
    }
    local[axis] = face_side;
    local[in_face[0]] = uw[0];
    local[in_face[1]] = uw[1];
    return false;
}

/* How deep into its cells a segment's points lie, against the length of its arc. Nearer points make
 * narrower quads but cross others less often: crossing pairs of triangles in
 * models/mri-brain.nii.gz at 40.5, with its 287 doubled edges, are 1,497 at 0.0625, 903 at 0.02,
 * 753 at 0.005. */
static const double nearness = 0.02;

/* The four points of a doubled face: two for each segment, first the one above the face. Returns
 * how many stay on it. */
static int place_face_points(const qni_repair_job *job, int64_t index) {
    const qni_doubled_face *face = job->dmc->repair->faces + index;
    const int axis = face->axis;
    double d[2][8];
    int64_t cell[2][3];
    int left = 0;
    for (int side = 0; side < 2; ++side) {
        for (int a = 0; a < 3; ++a)
            cell[side][a] = face->cell[a] - (side && a == axis);
        qni_repair_load_corners(&job->dmc->field, cell[side], d[side]);
    }
    for (int segment = 0; segment < 2; ++segment) {
        double uw[2], length;
        if (!arc_middle(face, segment, d[0], uw,
                        &length)) { /* shrunk to a corner: samples at the iso-value */
            const int corner = qni_face_corner(2 * axis, face->first_cut + 2 * segment);
            uw[0] = corner >> (axis == 0 ? 1 : 0) & 1;
            uw[1] = corner >> (axis == 2 ? 1 : 2) & 1;
        }
        for (int side = 0; side < 2; ++side) {
            double local[3];
            left += !point_in_cell(d[side], axis, side, uw, length * nearness, local);
            qni_repair_place(job, cell[side], local,
                             job->dmc->vertex_count + 4 * index + 2 * segment + side);
        }
    }
    return left;
}

/* ---- quads ----------------------------------------------------------------------------------- */

/* The boundary of a quad with the points on its sides, from its first corner on (repair_parts.h).
 */
static int boundary_of(const qni_dmc *dmc, const qni_quad_split *split,
                       uint32_t boundary[QNI_LARGEST_BOUNDARY]) {
    int count = 0;
    for (int k = 0; k < 4; ++k) {
        const int ring_side = qni_split_ring_side(split, k);
        if (qni_split_cuts(split, k)) {
            boundary[count++] = qni_cut_corner_vertex(dmc, split, k);
            boundary[count++] = qni_cut_side_vertex(dmc, split, k, true);
        } else {
            boundary[count++] = split->corners[k];
        }
        if (qni_split_doubles(split, k)) {
            /* Sides 0 and 1 of a ring climb, 2 and 3 come down. */
            const bool climbs = (ring_side < 2) == (split->forward != 0);
            const uint32_t above = (uint32_t)(dmc->vertex_count + split->points[ring_side]);
            boundary[count++] = climbs ? above + 1 : above;
            boundary[count++] = climbs ? above : above + 1;
        }
        if (qni_split_cuts(split, k + 1))
            boundary[count++] = qni_cut_side_vertex(dmc, split, k + 1, false);
    }
    return count;
}

static void fan_quad(const uint32_t *boundary, int count, uint32_t centre, int turn, int j,
                     uint32_t quad[4]) {
    quad[0] = centre;
    for (int n = 0; n < 3; ++n)
        quad[1 + n] = boundary[(2 * j + turn + n) % count];
}

static void corner_area(const float *positions, uint32_t o, uint32_t a, uint32_t b, double area[3],
                        double *squares) {
    double u[3], v[3];
    *squares = 0;
    for (int n = 0; n < 3; ++n) {
        u[n] = (double)positions[3 * (size_t)a + n] - (double)positions[3 * (size_t)o + n];
        v[n] = (double)positions[3 * (size_t)b + n] - (double)positions[3 * (size_t)o + n];
        *squares += u[n] * u[n] + v[n] * v[n];
    }
    for (int n = 0; n < 3; ++n)
        area[n] = u[(n + 1) % 3] * v[(n + 2) % 3] - u[(n + 2) % 3] * v[(n + 1) % 3];
}

/* [DMC21] equation (9) with a sign: corners that look against `up` count as negative. */
static double quad_quality(const float *positions, const uint32_t quad[4], const double up[3]) {
    double least = 1;
    for (int k = 0; k < 4; ++k) {
        double area[3], squares;
        corner_area(positions, quad[k], quad[(k + 1) & 3], quad[(k + 3) & 3], area, &squares);
        const double rise = area[0] * up[0] + area[1] * up[1] + area[2] * up[2];
        const double quality = squares > 0 ? 2 * rise / squares : 0;
        least = quality < least ? quality : least;
    }
    return least;
}

/* Which way to lay the spokes: the one whose worst corner is better, seen along the mean normal of
 * the whole fan. */
static int better_turn(const float *positions, const uint32_t *boundary, int count,
                       uint32_t centre) {
    double worst[2] = {1, 1}, up[3] = {0, 0, 0}, area[3], squares;
    for (int n = 0; n < count; ++n) {
        corner_area(positions, centre, boundary[n], boundary[(n + 1) % count], area, &squares);
        for (int a = 0; a < 3; ++a)
            up[a] += area[a];
    }
    const double length = sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    for (int a = 0; a < 3 && length > 0; ++a)
        up[a] /= length;
    for (int turn = 0; turn < 2; ++turn)
        for (int j = 0; j < count / 2; ++j) {
            uint32_t quad[4];
            fan_quad(boundary, count, centre, turn, j, quad);
            worst[turn] = fmin(worst[turn], quad_quality(positions, quad, up));
        }
    return worst[1] > worst[0];
}

/* Remember a quad as emitted: splits overwrite it, and tunnels need to know its corners. */
static void note_quad(const qni_repair_job *job, qni_quad_split *split) {
    const int64_t cell[3] = {split->point[0], split->point[1], split->point[2]};
    double d[8];
    qni_repair_load_corners(&job->dmc->field, cell, d);
    split->forward = (d[0] >= 0) != job->reverse;
    memcpy(split->corners, job->mesh->quads + 4 * (size_t)split->quad, sizeof split->corners);
}

/* The centre is where the lattice edge meets the surface: a point of all four cells and of the
 * right branch in each. */
static void split_quad(const qni_repair_job *job, int64_t index) {
    const qni_dmc *dmc = job->dmc;
    qni_quad_split *split = dmc->repair->splits + index;
    const int64_t cell[3] = {split->point[0], split->point[1], split->point[2]};
    const uint32_t centre = qni_centre_vertex(dmc, index);
    double local[3] = {0, 0, 0}, d[8];
    qni_repair_load_corners(&dmc->field, cell, d);
    local[split->axis] = d[0] / (d[0] - d[1 << split->axis]);
    qni_repair_place(job, cell, local, centre);
    uint32_t boundary[QNI_LARGEST_BOUNDARY];
    const int count = boundary_of(dmc, split, boundary);
    split->turn = (uint8_t)better_turn(job->mesh->positions, boundary, count, centre);
    for (int j = 0; j < count / 2; ++j)
        fan_quad(boundary, count, centre, split->turn, j,
                 job->mesh->quads + 4 * qni_fan_place(dmc, split, j));
}

void qni_repair_apply(qni_dmc *dmc, const qni_frame *frame, bool reverse, qn_mesh *mesh) {
    const qni_repair_job job = {dmc, frame, mesh, reverse};
    const qni_repair *repair = dmc->repair;
    const int32_t threads = qn_context_threads(dmc->context);
    int64_t left = 0;
    (void)threads;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t n = 0; n < repair->split_count; ++n)
        note_quad(&job, repair->splits + n);
#pragma omp parallel for schedule(static) reduction(+ : left) num_threads(threads)
    for (int64_t n = 0; n < repair->face_count; ++n)
        left += place_face_points(&job, n);
#pragma omp parallel for schedule(static) reduction(+ : left) num_threads(threads)
    for (int64_t n = 0; n < 2 * repair->tunnel_count; ++n)
        left += qni_tunnel_place_end(&job, n);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t n = 0; n < repair->split_count; ++n)
        split_quad(&job, n);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int64_t n = 0; n < repair->tunnel_count; ++n)
        qni_tunnel_close(&job, n);
    dmc->repair->fallback_points = left;
}
