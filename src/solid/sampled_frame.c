// SPDX-License-Identifier: MIT
/* Where a volume's samples lie: a frame whose planes are floats, and the way from there to the
 * world. */
#include "solid/sampled.h"

#include <math.h>
#include <string.h>

/* A cell must hold so many floats, or vertices in it could not be told apart. */
static const double least_floats = 512;

/* The world axis that each index axis runs along, when they run along axes. */
static bool find_axes(const double m[3][4], int axis_of[3]) {
    int taken = 0;
    for (int k = 0; k < 3; ++k) {
        int found = -1;
        for (int row = 0; row < 3; ++row)
            if (m[row][k] != 0) {
                if (found >= 0)
                    return false;
                found = row;
            }
        if (found < 0 || taken >> found & 1)
            return false;
        taken |= 1 << found;
        axis_of[k] = found;
    }
    return true;
}

static double determinant(const double m[3][4]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Are the planes fine enough there? */
static bool fits_floats(const qni_sample_frame *frame) {
    for (int k = 0; k < 3; ++k) {
        const double last = frame->origin[k] + frame->step[k] * frame->count[k];
        const double most = fmax(fabs(frame->origin[k]), fabs(last));
        if (!(frame->step[k] > least_floats * 6e-8 * most) || !(frame->step[k] > 1e-30) ||
            !(most < 1e30))
            return false;
    }
    return true;
}

static void set_exact(qni_sample_frame *frame, const double m[3][4], const int axis_of[3]) {
    memset(frame->to_world, 0, sizeof frame->to_world);
    frame->exact = true;
    for (int k = 0; k < 3; ++k) {
        const int row = axis_of[k];
        const double sign = m[row][k] < 0 ? -1 : 1;
        frame->step[k] = fabs(m[row][k]);
        frame->origin[k] = sign * m[row][3];
        frame->to_world[row][k] = sign;
    }
}

static void set_turned(qni_sample_frame *frame, const double m[3][4]) {
    frame->exact = false;
    for (int k = 0; k < 3; ++k) {
        frame->step[k] = sqrt(m[0][k] * m[0][k] + m[1][k] * m[1][k] + m[2][k] * m[2][k]);
        frame->origin[k] = 0;
    }
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k)
            frame->to_world[row][k] = m[row][k] / frame->step[k];
        frame->to_world[row][3] = m[row][3];
    }
}

void qni_sample_frame_init(qni_sample_frame *frame, const double world[3][4],
                           const int64_t points[3]) {
    int axis_of[3];
    for (int k = 0; k < 3; ++k)
        frame->count[k] = (int32_t)points[k];
    const bool along_axes = find_axes(world, axis_of);
    if (along_axes)
        set_exact(frame, world, axis_of);
    if (!along_axes || !fits_floats(frame))
        set_turned(frame, world);
    for (int k = 0; k < 3; ++k)
        frame->per_step[k] = 1 / frame->step[k];
    frame->turned = determinant((const double(*)[4])frame->to_world) < 0;
}
