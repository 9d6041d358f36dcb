// SPDX-License-Identifier: MIT
/* Repair of doubled edges (repair.h): where the new points lie, and how a fan's spokes are laid. */
#ifndef QNI_DMC_REPAIR_HD_H
#define QNI_DMC_REPAIR_HD_H

#include "dmc/doubled_hd.h"
#include "dmc/vertex_hd.h"

#include <math.h>

/* ---- points ---------------------------------------------------------------------------------- */

/* The middle of a segment's arc on its face, in the face's two axes; `length` of the arc's chord.
 */
QN_HD static inline int qni_segment_arc(int axis, int first_cut, int segment, const double d[8],
                                        double uw[2], double *length) {
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    qni_square square;
    int side[2];
    double ends[2][2];
    for (int n = 0; n < 4; ++n)
        square.v[n] = d[(n & 1) << p | (n >> 1) << q];
    for (int n = 0; n < 2; ++n) {
        const int edge = qni_doubled_edge(axis, first_cut, 2 * segment + n);
        const int across = qni_edge_axis(edge) == p ? q : p;
        const int start = qni_edge_start_corner(edge), end = start | 1 << qni_edge_axis(edge);
        const double at = d[start] / (d[start] - d[end]);
        side[n] = 2 * (across == q) + qni_edge_side(edge, across);
        ends[n][across == q] = qni_edge_side(edge, across);
        ends[n][across != q] = at;
    }
    const double du = ends[0][0] - ends[1][0], dw = ends[0][1] - ends[1][1];
    *length = sqrt(du * du + dw * dw);
    return qni_arc_middle(&square, side[0], side[1], uw);
}

/* The same; where the arc has shrunk to a corner, samples being at the iso-value, that corner. */
QN_HD static inline void qni_segment_middle(int axis, int first_cut, int segment, const double d[8],
                                            double uw[2], double *length) {
    if (qni_segment_arc(axis, first_cut, segment, d, uw, length))
        return;
    const int corner = qni_face_corner(2 * axis, first_cut + 2 * segment);
    uw[0] = corner >> (axis == 0 ? 1 : 0) & 1;
    uw[1] = corner >> (axis == 2 ? 1 : 2) & 1;
}

/* From the arc's middle into a cell, along the surface: in the slice across one axis of the face,
 * the arc that starts in the middle is followed to a plane at `depth` from the face. There the
 * slice is linear along the face's other axis, so the surface has one point; as long as the ends of
 * that line keep their signs, it is on the same arc, hence on the right branch. */
QN_HD static inline int qni_follow_arc(const double d[8], int axis, int face_side,
                                       const double uw[2], int slice, double depth, double *found) {
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
QN_HD static inline int qni_point_in_cell(const double d[8], int axis, int face_side,
                                          const double uw[2], double first_depth, double local[3]) {
    const int in_face[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    for (double depth = first_depth; depth > first_depth / 64; depth /= 2) {
        double found[2], move[2] = {2, 2};
        for (int slice = 0; slice < 2; ++slice)
            if (qni_follow_arc(d, axis, face_side, uw, slice, depth, found + slice))
                move[slice] = fabs(found[slice] - uw[1 - slice]);
        if (fmin(move[0], move[1]) >= 2)
            continue;
        const int slice = move[0] <= move[1] ? 0 : 1;
        local[axis] = face_side ? 1 - depth : depth;
        local[in_face[slice]] = uw[slice];
        local[in_face[1 - slice]] = found[slice];
        return 1;
    }
    local[axis] = face_side;
    local[in_face[0]] = uw[0];
    local[in_face[1]] = uw[1];
    return 0;
}

/* How deep into its cells a segment's points lie, against the length of its arc. Nearer points make
 * narrower quads but cross others less often: crossing pairs of triangles in
 * models/mri-brain.nii.gz at 40.5, with its 287 doubled edges, are 1,497 at 0.0625, 903 at 0.02,
 * 753 at 0.005. */
#define QNI_REPAIR_NEARNESS 0.02

/* ---- fans ------------------------------------------------------------------------------------ */

QN_HD_INLINE void qni_fan_quad(const uint32_t *boundary, int count, uint32_t centre, int turn,
                               int j, uint32_t quad[4]) {
    quad[0] = centre;
    for (int n = 0; n < 3; ++n) {
        const int at = 2 * j + turn + n; /* at most once round */
        quad[1 + n] = boundary[at < count ? at : at - count];
    }
}

QN_HD_INLINE void qni_corner_area(const float *positions, uint32_t o, uint32_t a, uint32_t b,
                                  double area[3], double *squares) {
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
QN_HD_INLINE double qni_quad_quality(const float *positions, const uint32_t quad[4],
                                     const double up[3]) {
    double least = 1;
    for (int k = 0; k < 4; ++k) {
        double area[3], squares;
        qni_corner_area(positions, quad[k], quad[(k + 1) & 3], quad[(k + 3) & 3], area, &squares);
        const double rise = area[0] * up[0] + area[1] * up[1] + area[2] * up[2];
        const double quality = squares > 0 ? 2 * rise / squares : 0;
        least = quality < least ? quality : least;
    }
    return least;
}

/* Which way to lay the spokes: the one whose worst corner is better, seen along the mean normal of
 * the whole fan. */
QN_HD static inline int qni_better_turn(const float *positions, const uint32_t *boundary, int count,
                                        uint32_t centre) {
    double worst[2] = {1, 1}, up[3] = {0, 0, 0}, area[3], squares;
    for (int n = 0; n < count; ++n) {
        qni_corner_area(positions, centre, boundary[n], boundary[n + 1 < count ? n + 1 : 0], area,
                        &squares);
        for (int a = 0; a < 3; ++a)
            up[a] += area[a];
    }
    const double length = sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    for (int a = 0; a < 3 && length > 0; ++a)
        up[a] /= length;
    for (int turn = 0; turn < 2; ++turn)
        for (int j = 0; j < count / 2 && (turn == 0 || worst[1] > worst[0]); ++j) {
            uint32_t quad[4];
            qni_fan_quad(boundary, count, centre, turn, j, quad);
            const double quality = qni_quad_quality(positions, quad, up);
            worst[turn] = quality < worst[turn] ? quality : worst[turn];
        }
    return worst[1] > worst[0];
}

#endif
