// SPDX-License-Identifier: MIT
/* The inner loops of putting merged vertices in place, included once for each instruction set
 * (kernel_*.c). Each lane does what the functions of project_hd.h named beside it do. */
#include "dmc/project.h"
#include "dmc/project_hd.h"

#include <math.h>

/* qni_middle_of_pair() */
static inline void middle_lanes(const qni_meetings *m, int from, qni_landings *out) {
#pragma omp simd
    for (int l = from; l < from + QNI_LANES; ++l) {
        for (int a = 0; a < 3; ++a)
            out->position[a][l] = 0.5f * m->position[0][a][l] + 0.5f * m->position[1][a][l];
        const float nx = m->normal[0][0][l], ny = m->normal[0][1][l], nz = m->normal[0][2][l];
        const float x = nx + m->normal[1][0][l], y = ny + m->normal[1][1][l],
                    z = nz + m->normal[1][2][l];
        const float squares = (x * x + y * y) + z * z;
        const int good = squares > 1e-6f;
        const float scale = good ? 1 / sqrtf(squares) : 0;
        out->normal[0][l] = good ? x * scale : nx;
        out->normal[1][l] = good ? y * scale : ny;
        out->normal[2][l] = good ? z * scale : nz;
    }
}

/* qni_move_between(), and qni_turn_between() with it */
static inline void move_lanes(const qni_meetings *m, int from, qni_landings *out) {
#pragma omp simd
    for (int l = from; l < from + QNI_LANES; ++l) {
#define P(a) (double)m->position[2][a][l]
#define Q(a) (double)m->position[3][a][l]
        const double wx = Q(0) - P(0), wy = Q(1) - P(1), wz = Q(2) - P(2);
        const float px = out->position[0][l], py = out->position[1][l], pz = out->position[2][l];
        const double along = ((0 + wx * ((double)px - 0.5 * (P(0) + Q(0)))) +
                              wy * ((double)py - 0.5 * (P(1) + Q(1)))) +
                             wz * ((double)pz - 0.5 * (P(2) + Q(2)));
#undef P
#undef Q
        const double squares = ((0 + wx * wx) + wy * wy) + wz * wz;
        const int moves = squares > 0;
        const double share = -along / squares;
        out->position[0][l] = moves ? (float)((double)px + share * wx) : px;
        out->position[1][l] = moves ? (float)((double)py + share * wy) : py;
        out->position[2][l] = moves ? (float)((double)pz + share * wz) : pz;
        const float turn = (float)share;
        const float nx = out->normal[0][l], ny = out->normal[1][l], nz = out->normal[2][l];
        const float x = nx + turn * (m->normal[3][0][l] - m->normal[2][0][l]),
                    y = ny + turn * (m->normal[3][1][l] - m->normal[2][1][l]),
                    z = nz + turn * (m->normal[3][2][l] - m->normal[2][2][l]);
        const float length = (x * x + y * y) + z * z;
        const float scale = length > 1e-6f ? 1 / sqrtf(length) : 0;
        const int turns = moves & (scale > 0);
        out->normal[0][l] = turns ? x * scale : nx;
        out->normal[1][l] = turns ? y * scale : ny;
        out->normal[2][l] = turns ? z * scale : nz;
    }
}

qni_meet_kernel KERNEL(qni_meet);

void KERNEL(qni_meet)(const qni_meetings *meetings, bool move, qni_landings *landings) {
    for (int from = 0; from < landings->count; from += QNI_LANES) {
        middle_lanes(meetings, from, landings);
        if (move)
            move_lanes(meetings, from, landings);
    }
}

/* to_lattice(), cell_of() and slope_of_normal() of project.c, along one axis */
static inline void locate_lanes(const qni_projector *projector, int a, const qni_landings *landings,
                                int from, qni_approach *approach) {
    const double *row = projector->lattice[a], last = (double)(projector->field->cells[a] - 1);
    const double(*world)[4] = (const double(*)[4])projector->field->world;
    const int below = projector->field->inside_below;
#pragma omp simd
    for (int l = from; l < from + QNI_LANES; ++l) {
        const double at = (row[0] * (double)landings->position[0][l] +
                           row[1] * (double)landings->position[1][l]) +
                          (row[2] * (double)landings->position[2][l] + row[3]);
        const double low = floor(at);
        const double sum = (world[0][a] * (double)landings->normal[0][l] +
                            world[1][a] * (double)landings->normal[1][l]) +
                           world[2][a] * (double)landings->normal[2][l];
        approach->at[a][l] = at;
        approach->cell[a][l] = low < 0 ? 0 : low > last ? last : low;
        approach->slope[a][l] = below ? sum : -sum;
    }
}

qni_locate_kernel KERNEL(qni_locate);

void KERNEL(qni_locate)(const qni_projector *projector, const qni_landings *landings,
                        qni_approach *approach) {
    for (int from = 0; from < landings->count; from += QNI_LANES)
        for (int a = 0; a < 3; ++a)
            locate_lanes(projector, a, landings, from, approach);
}

/* Where no normal is known: qni_slope_of_values() */
static inline void mend_slopes(int from, qni_approach *approach) {
#pragma omp simd
    for (int l = from; l < from + QNI_LANES; ++l) {
#define D(n) approach->corner[n][l]
        const double u = approach->at[0][l] - approach->cell[0][l],
                     v = approach->at[1][l] - approach->cell[1][l],
                     w = approach->at[2][l] - approach->cell[2][l];
        const double x = approach->slope[0][l], y = approach->slope[1][l],
                     z = approach->slope[2][l];
        const int unknown = (x == 0) & (y == 0) & (z == 0);
        const double of_x = qni_bilinear(D(1) - D(0), D(3) - D(2), D(5) - D(4), D(7) - D(6), v, w);
        const double of_y = qni_bilinear(D(2) - D(0), D(3) - D(1), D(6) - D(4), D(7) - D(5), u, w);
        const double of_z = qni_bilinear(D(4) - D(0), D(5) - D(1), D(6) - D(2), D(7) - D(3), u, v);
#undef D
        approach->slope[0][l] = unknown ? of_x : x;
        approach->slope[1][l] = unknown ? of_y : y;
        approach->slope[2][l] = unknown ? of_z : z;
    }
}

/* Lines along one axis each, through their points' cells. */
typedef struct axis_lines {
    double axis[QNI_LANES]; /* 0, 1, 2 */
    double low[QNI_LANES], high[QNI_LANES];
    double slope[QNI_LANES], at[QNI_LANES], start[QNI_LANES];
} axis_lines;

/* The first axis of qni_sort_axes(), qni_line_ends() */
static inline void find_lines(const qni_approach *approach, int from, axis_lines *lines) {
#pragma omp simd
    for (int n = 0; n < QNI_LANES; ++n) {
        const int l = from + n;
        const double x = approach->at[0][l], y = approach->at[1][l], z = approach->at[2][l];
        const double cx = approach->cell[0][l], cy = approach->cell[1][l],
                     cz = approach->cell[2][l];
        const double u = x - cx, v = y - cy, w = z - cz;
        const double sx = approach->slope[0][l], sy = approach->slope[1][l],
                     sz = approach->slope[2][l];
        const double d0 = approach->corner[0][l], d1 = approach->corner[1][l],
                     d2 = approach->corner[2][l], d3 = approach->corner[3][l],
                     d4 = approach->corner[4][l], d5 = approach->corner[5][l],
                     d6 = approach->corner[6][l], d7 = approach->corner[7][l];
        const int on_x = (fabs(sx) >= fabs(sy)) & (fabs(sx) >= fabs(sz));
        const int on_y = !on_x & (fabs(sy) >= fabs(sz));
        const int on_z = !on_x & !on_y;
        const double p = on_x ? v : u, q = on_z ? v : w;
        const double low_1 = on_x ? d2 : d1, low_2 = on_z ? d2 : d4, high_0 = on_z ? d4 : d2,
                     high_1 = on_z ? d5 : d3, high_2 = on_x ? d5 : d6, low_3 = on_y ? d5 : d3;
        lines->low[n] = qni_bilinear(d0, low_1, low_2, on_x ? d6 : low_3, p, q);
        lines->high[n] = qni_bilinear(on_x ? d1 : high_0, high_1, high_2, d7, p, q);
        lines->slope[n] = on_x ? sx : on_y ? sy : sz;
        lines->at[n] = on_x ? x : on_y ? y : z;
        lines->start[n] = on_x ? cx : on_y ? cy : cz;
        lines->axis[n] = on_x ? 0 : on_y ? 1 : 2;
    }
}

/* qni_crossing_of_line(), to_world() */
static inline void land_lanes(const qni_projector *projector, const qni_approach *approach,
                              const axis_lines *lines, int from, qni_landings *landings) {
    const double(*m)[4] = (const double(*)[4])projector->field->world;
#pragma omp simd
    for (int n = 0; n < QNI_LANES; ++n) {
        const int l = from + n;
        const double low = lines->low[n], high = lines->high[n], slope = lines->slope[n];
        const int rises = (slope > 0) & (low < 0) & (high >= 0);
        const int falls = (slope < 0) & (low >= 0) & (high < 0);
        const double zero = lines->start[n] + low / (low - high);
        const double x = approach->at[0][l], y = approach->at[1][l], z = approach->at[2][l];
        const double at[3] = {lines->axis[n] == 0 ? zero : x, lines->axis[n] == 1 ? zero : y,
                              lines->axis[n] == 2 ? zero : z};
        landings->landed[l] = (rises | falls) & (fabs(zero - lines->at[n]) <= 1);
        for (int r = 0; r < 3; ++r)
            landings->position[r][l] =
                (float)((m[r][0] * at[0] + m[r][1] * at[1]) + (m[r][2] * at[2] + m[r][3]));
    }
}

qni_land_kernel KERNEL(qni_land);

void KERNEL(qni_land)(const qni_projector *projector, qni_approach *approach,
                      qni_landings *landings) {
    for (int from = 0; from < landings->count; from += QNI_LANES) {
        axis_lines lines;
        mend_slopes(from, approach);
        find_lines(approach, from, &lines);
        land_lanes(projector, approach, &lines, from, landings);
    }
}
