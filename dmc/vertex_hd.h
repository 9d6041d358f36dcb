// SPDX-License-Identifier: MIT
/* Where the vertex of an MC polygon lies: on the trilinear surface, on the polygon's own branch,
 * near its middle.
 *
 * [DMC21] section 3.1.2 samples each branch and keeps the sample next to the middle of the polygon.
 * Here the point is found directly, with + - * / alone, so that every processor gets the same bits:
 *  1. A cell with one polygon holds one branch. An axis line through the middle of the crossings
 * that changes sign between its ends meets it once; of the three axes' points the one nearest to
 * the middle is taken.
 *  2. Else a slice of the cell through the middle: the trilinear interpolant is bilinear there,
 * each of its arcs is monotone, and joins two crossings that lie on known face segments of known
 * polygons. The arc's own middle is a point of the branch. A slice is tried at the middle, then at
 * fixed fractions of the polygon's extent. Corner values are less iso; coordinates are local, 0
 * to 1. */
#ifndef QNI_DMC_VERTEX_HD_H
#define QNI_DMC_VERTEX_HD_H

#include "core/cube_hd.h"

enum qni_point_kind {
    QNI_POINT_AXIS,       /* on an axis line */
    QNI_POINT_SLICE,      /* middle of an arc of a slice */
    QNI_POINT_DEGENERATE, /* all crossings coincide: samples at the iso-value */
    QNI_POINT_FALLBACK    /* on a face arc: no slice would do */
};

typedef struct qni_point {
    double p[3];
    int kind;
} qni_point;

QN_HD_INLINE int qni_differ(double a, double b) {
    return (a >= 0) != (b >= 0);
}

QN_HD_INLINE double qni_lerp(double a, double b, double t) {
    return a + t * (b - a);
}

QN_HD_INLINE double qni_bilinear(double a00, double a10, double a01, double a11, double u,
                                 double v) {
    return qni_lerp(qni_lerp(a00, a10, u), qni_lerp(a01, a11, u), v);
}

QN_HD_INLINE double qni_distance(double a) {
    return a < 0 ? -a : a;
}

/* ---- cells with one polygon ------------------------------------------------------------------ */

/* The point of an axis line; `distance` from the middle along it is at least 2 when it misses the
 * surface. */
typedef struct qni_axis_hit {
    double at, distance;
} qni_axis_hit;

QN_HD_INLINE qni_axis_hit qni_axis_line(double low, double high, double middle) {
    const double at = low / (low - high);
    const int hit = qni_differ(low, high);
    qni_axis_hit result;
    result.at = hit ? at : middle;
    result.distance = hit ? qni_distance(at - middle) : 2;
    return result;
}

/* One edge's share in the sum of crossings: where it is crossed, and whether. The middle of the
 * crossings only says where to look for the surface, so single precision will do; where it
 * overflows, the line misses and slices find the point. */
QN_HD_INLINE float qni_crossing(float a, float b) {
    const float at = a / (a - b);
    return (a >= 0) != (b >= 0) ? at : 0;
}

QN_HD_INLINE float qni_crossed(float a, float b) {
    return (a >= 0) != (b >= 0) ? 1.0f : 0.0f;
}

typedef struct qni_axis_point {
    double x, y, z;
    double distance; /* 2 when no axis line meets the surface */
} qni_axis_point;

/* Written without branches and arrays, so that compilers turn a loop over it into vector code. */
QN_HD_INLINE qni_axis_point qni_point_of_one(double d0, double d1, double d2, double d3, double d4,
                                             double d5, double d6, double d7) {
    const float f0 = (float)d0, f1 = (float)d1, f2 = (float)d2, f3 = (float)d3, f4 = (float)d4,
                f5 = (float)d5, f6 = (float)d6, f7 = (float)d7;
    const float n0 = qni_crossed(f0, f1), n1 = qni_crossed(f2, f3), n2 = qni_crossed(f4, f5),
                n3 = qni_crossed(f6, f7), n4 = qni_crossed(f0, f2), n5 = qni_crossed(f1, f3),
                n6 = qni_crossed(f4, f6), n7 = qni_crossed(f5, f7), n8 = qni_crossed(f0, f4),
                n9 = qni_crossed(f1, f5), n10 = qni_crossed(f2, f6), n11 = qni_crossed(f3, f7);
    const float along_x = (qni_crossing(f0, f1) + qni_crossing(f2, f3)) +
                          (qni_crossing(f4, f5) + qni_crossing(f6, f7));
    const float along_y = (qni_crossing(f0, f2) + qni_crossing(f1, f3)) +
                          (qni_crossing(f4, f6) + qni_crossing(f5, f7));
    const float along_z = (qni_crossing(f0, f4) + qni_crossing(f1, f5)) +
                          (qni_crossing(f2, f6) + qni_crossing(f3, f7));
    const float count =
        ((n0 + n1) + (n2 + n3)) + ((n4 + n5) + (n6 + n7)) + ((n8 + n9) + (n10 + n11));
    const float share = 1 / count;
    const double x = (double)((along_x + ((n5 + n7) + (n9 + n11))) * share);
    const double y = (double)((along_y + ((n1 + n3) + (n10 + n11))) * share);
    const double z = (double)((along_z + ((n2 + n3) + (n6 + n7))) * share);

    const qni_axis_hit on_x =
        qni_axis_line(qni_bilinear(d0, d2, d4, d6, y, z), qni_bilinear(d1, d3, d5, d7, y, z), x);
    const qni_axis_hit on_y =
        qni_axis_line(qni_bilinear(d0, d1, d4, d5, x, z), qni_bilinear(d2, d3, d6, d7, x, z), y);
    const qni_axis_hit on_z =
        qni_axis_line(qni_bilinear(d0, d1, d2, d3, x, y), qni_bilinear(d4, d5, d6, d7, x, y), z);
    const int take_x = on_x.distance <= on_y.distance && on_x.distance <= on_z.distance;
    const int take_y = !take_x && on_y.distance <= on_z.distance;
    qni_axis_point result;
    result.x = take_x ? on_x.at : x;
    result.y = take_y ? on_y.at : y;
    result.z = !take_x && !take_y ? on_z.at : z;
    result.distance = take_x ? on_x.distance : take_y ? on_y.distance : on_z.distance;
    return result;
}

/* ---- any polygon, by slices ------------------------------------------------------------------ */

/* One polygon of a cell: its edges, the order in which they follow each other, its crossings. */
typedef struct qni_polygon {
    unsigned edge_mask;
    uint64_t next_code;   /* as in cases_hd.h, of the whole cell */
    double at[QNI_EDGES]; /* crossing along each edge of the mask */
    double low[3], high[3], middle[3];
} qni_polygon;

QN_HD_INLINE double qni_crossing_coordinate(const qni_polygon *polygon, int edge, int axis) {
    return qni_edge_axis(edge) == axis ? polygon->at[edge] : (double)qni_edge_side(edge, axis);
}

QN_HD static inline void qni_polygon_init(qni_polygon *polygon, const double d[8],
                                          unsigned edge_mask, uint64_t next_code) {
    double sum[3] = {0, 0, 0};
    int count = 0;
    polygon->edge_mask = edge_mask;
    polygon->next_code = next_code;
    for (int axis = 0; axis < 3; ++axis) {
        polygon->low[axis] = 1;
        polygon->high[axis] = 0;
    }
    QN_ROLLED
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        if (!(edge_mask >> edge & 1))
            continue;
        const int from = qni_edge_start_corner(edge), to = from + (1 << qni_edge_axis(edge));
        polygon->at[edge] = d[from] / (d[from] - d[to]);
        for (int axis = 0; axis < 3; ++axis) {
            const double c = qni_crossing_coordinate(polygon, edge, axis);
            sum[axis] += c;
            polygon->low[axis] = c < polygon->low[axis] ? c : polygon->low[axis];
            polygon->high[axis] = c > polygon->high[axis] ? c : polygon->high[axis];
        }
        ++count;
    }
    for (int axis = 0; axis < 3; ++axis)
        polygon->middle[axis] = sum[axis] / count;
}

/* A square of bilinear values: v[u + 2 w] at its corners, and which of its sides (u=0, u=1, w=0,
 * w=1) a segment of the polygon crosses. */
typedef struct qni_square {
    double v[4];
    int own[4];
} qni_square;

/* A point of the arc between the crossings of sides s and t: the middle of its longer extent. */
QN_HD static inline int qni_arc_middle(const qni_square *square, int s, int t, double uw[2]) {
    double a[2], b[2];
    for (int end = 0; end < 2; ++end) {
        const int side = end ? t : s;
        double *c = end ? b : a;
        const double v0 = side < 2 ? square->v[side] : square->v[2 * (side - 2)];
        const double v1 = side < 2 ? square->v[side + 2] : square->v[2 * (side - 2) + 1];
        c[side < 2 ? 0 : 1] = (double)(side & 1);
        c[side < 2 ? 1 : 0] = v0 / (v0 - v1);
    }
    const int along = qni_distance(a[0] - b[0]) >= qni_distance(a[1] - b[1]) ? 0 : 1;
    const int across = 1 - along;
    const double m = (a[along] + b[along]) * 0.5;
    const double *v = square->v;
    const double v0 = along == 0 ? qni_lerp(v[0], v[1], m) : qni_lerp(v[0], v[2], m);
    const double v1 = along == 0 ? qni_lerp(v[2], v[3], m) : qni_lerp(v[1], v[3], m);
    if (!qni_differ(v0, v1))
        return 0;
    const double c = v0 / (v0 - v1);
    const double low = a[across] < b[across] ? a[across] : b[across];
    const double high = a[across] < b[across] ? b[across] : a[across];
    uw[along] = m;
    uw[across] = c;
    return c >= low && c <= high;
}

/* Which sides the bilinear interpolant joins: partner[s], or -1. */
QN_HD static inline void qni_square_pairs(const qni_square *square, int partner[4]) {
    const double *v = square->v;
    int crossed[4], count = 0;
    crossed[0] = qni_differ(v[0], v[2]);
    crossed[1] = qni_differ(v[1], v[3]);
    crossed[2] = qni_differ(v[0], v[1]);
    crossed[3] = qni_differ(v[2], v[3]);
    for (int s = 0; s < 4; ++s) {
        partner[s] = -1;
        count += crossed[s];
    }
    if (count == 2) {
        for (int s = 0; s < 4; ++s)
            for (int t = 0; t < 4; ++t)
                if (s != t && crossed[s] && crossed[t])
                    partner[s] = t;
    } else if (count == 4) {
        /* Corners 0 and 3 face each other; corner 0 is cut off alone by sides 0 and 2. */
        const double along_03 = v[0] * v[3], along_12 = v[1] * v[2];
        const int joined_03 = v[0] >= 0 ? along_03 >= along_12 : along_03 > along_12;
        partner[0] = joined_03 ? 3 : 2;
        partner[3] = joined_03 ? 0 : 1;
        partner[1] = joined_03 ? 2 : 3;
        partner[2] = joined_03 ? 1 : 0;
    }
}

/* The arc of the square on the polygon that comes nearest to `middle`; squared distance, or -1. */
QN_HD static inline double qni_square_point(const qni_square *square, const double middle[2],
                                            double uw[2]) {
    int partner[4];
    double best = -1;
    qni_square_pairs(square, partner);
    for (int s = 0; s < 4; ++s) {
        const int t = partner[s];
        double c[2];
        if (t < s || !square->own[s] || !square->own[t] || !qni_arc_middle(square, s, t, c))
            continue;
        const double du = c[0] - middle[0], dw = c[1] - middle[1];
        const double distance = du * du + dw * dw;
        if (best < 0 || distance < best) {
            best = distance;
            uw[0] = c[0];
            uw[1] = c[1];
        }
    }
    return best;
}

/* The slice of the cell at `at` along `axis`. */
QN_HD static inline void qni_slice(const qni_polygon *polygon, const double d[8], int axis,
                                   double at, qni_square *square) {
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    for (int n = 0; n < 4; ++n) {
        const int corner = ((n & 1) << p) | ((n >> 1) << q);
        square->v[n] = qni_lerp(d[corner], d[corner | (1 << axis)], at);
        square->own[n] = 0;
    }
    QN_ROLLED
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        if (!(polygon->edge_mask >> edge & 1))
            continue;
        const int next = (int)(polygon->next_code >> (4 * edge) & 15);
        const int face = qni_face_of_edges(edge, next);
        if (face >> 1 == axis)
            continue;
        const double a = qni_crossing_coordinate(polygon, edge, axis);
        const double b = qni_crossing_coordinate(polygon, next, axis);
        if ((a <= at) != (b <= at))
            square->own[2 * (face >> 1 == q) + (face & 1)] = 1;
    }
}

/* The cell face that carries the polygon's widest segment, as a square owned by that segment alone.
 */
QN_HD static inline int qni_widest_face(const qni_polygon *polygon, const double d[8],
                                        qni_square *square) {
    double widest = -1;
    int widest_edge = 0;
    QN_ROLLED
    for (int edge = 0; edge < QNI_EDGES; ++edge) {
        if (!(polygon->edge_mask >> edge & 1))
            continue;
        const int next = (int)(polygon->next_code >> (4 * edge) & 15);
        double width = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double c = qni_crossing_coordinate(polygon, edge, axis) -
                             qni_crossing_coordinate(polygon, next, axis);
            width += c * c;
        }
        if (width > widest) {
            widest = width;
            widest_edge = edge;
        }
    }
    const int next = (int)(polygon->next_code >> (4 * widest_edge) & 15);
    const int face = qni_face_of_edges(widest_edge, next), axis = face >> 1, side = face & 1;
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    for (int n = 0; n < 4; ++n) {
        square->v[n] = d[(side << axis) | ((n & 1) << p) | ((n >> 1) << q)];
        square->own[n] = 0;
    }
    for (int n = 0; n < 2; ++n) {
        const int edge = n ? next : widest_edge;
        const int across = qni_edge_axis(edge) == p ? q : p;
        square->own[2 * (across == q) + qni_edge_side(edge, across)] = 1;
    }
    return face;
}

/* The nearest point to the polygon's middle on the slice at `at` along `axis`, if nearer than
 * `best`, the squared distance so far (negative: none yet). */
QN_HD static inline void qni_try_slice(const qni_polygon *polygon, const double d[8], int axis,
                                       double at, double *best, double point[3]) {
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    const double middle[2] = {polygon->middle[p], polygon->middle[q]};
    const double off = at - polygon->middle[axis];
    qni_square square;
    double uw[2] = {0, 0};
    qni_slice(polygon, d, axis, at, &square);
    const double in_slice = qni_square_point(&square, middle, uw);
    const double distance = in_slice + off * off;
    if (in_slice < 0 || (*best >= 0 && distance >= *best))
        return;
    *best = distance;
    point[axis] = at;
    point[p] = uw[0];
    point[q] = uw[1];
}

/* A face arc of the polygon, or at last one of its crossings: these are on its branch too. */
QN_HD static inline void qni_point_on_face(const qni_polygon *polygon, const double d[8],
                                           double point[3]) {
    qni_square square;
    double uw[2] = {0, 0};
    const int face = qni_widest_face(polygon, d, &square), axis = face >> 1;
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    const double middle[2] = {polygon->middle[p], polygon->middle[q]};
    if (qni_square_point(&square, middle, uw) >= 0) {
        point[axis] = (double)(face & 1);
        point[p] = uw[0];
        point[q] = uw[1];
        return;
    }
    int first = 0;
    while (!(polygon->edge_mask >> first & 1))
        ++first;
    for (int a = 0; a < 3; ++a)
        point[a] = qni_crossing_coordinate(polygon, first, a);
}

/* The vertex of any polygon of a cell with corner values d. */
QN_HD static inline qni_point qni_point_of_polygon(const double d[8], unsigned edge_mask,
                                                   uint64_t next_code) {
    /* Fractions of the extent are tried in pairs from both ends, so that a turned cell gets the
     * turned point. */
    const double fractions[5] = {0, 0.25, 0.1, 0.5, 0.03125};
    qni_polygon polygon;
    qni_point point;
    qni_polygon_init(&polygon, d, edge_mask, next_code);
    QN_ROLLED
    for (int n = 0; n < 5; ++n) {
        double best = -1;
        QN_ROLLED
        for (int axis = 0; axis < 3; ++axis) {
            const double low = polygon.low[axis], high = polygon.high[axis];
            if (n == 0) {
                qni_try_slice(&polygon, d, axis, polygon.middle[axis], &best, point.p);
                continue;
            }
            qni_try_slice(&polygon, d, axis, qni_lerp(low, high, fractions[n]), &best, point.p);
            qni_try_slice(&polygon, d, axis, qni_lerp(high, low, fractions[n]), &best, point.p);
        }
        if (best >= 0) {
            point.kind = QNI_POINT_SLICE;
            return point;
        }
    }
    int shrunk = 1;
    for (int axis = 0; axis < 3; ++axis) {
        shrunk = shrunk && polygon.low[axis] == polygon.high[axis];
        point.p[axis] = polygon.middle[axis];
    }
    point.kind = shrunk ? QNI_POINT_DEGENERATE : QNI_POINT_FALLBACK;
    if (!shrunk)
        qni_point_on_face(&polygon, d, point.p);
    return point;
}

/* ---- gradients ------------------------------------------------------------------------------- */

/* Twice the gradient along one axis at (u, v, w), by central differences at the corners,
 * interpolated: the four values of `plane_..` are bilinear values on the lattice planes -1, 0, 1, 2
 * across the axis; u is the place along it. */
QN_HD_INLINE double qni_central_gradient(double plane_before, double plane_0, double plane_1,
                                         double plane_after, double u) {
    return qni_lerp(plane_1 - plane_before, plane_after - plane_0, u);
}

#endif
