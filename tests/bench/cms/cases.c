// SPDX-License-Identifier: MIT
#include "bench/cms/cases.h"

/* A quarter turn of the cube about an axis, for a set of corners. */
static int turned(int signs, int axis) {
    const int p = (axis + 1) % 3, q = (axis + 2) % 3;
    int out = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int u = corner >> p & 1, v = corner >> q & 1;
        const int to = (corner & 1 << axis) | ((1 - v) << p) | (u << q);
        out |= (signs >> corner & 1) << to;
    }
    return out;
}

/* The least of all sets that turns and a change of signs make of this one. */
static int least(int signs) {
    int best = 255;
    for (int flip = 0; flip < 2; ++flip) {
        int x = flip ? 255 - signs : signs;
        for (int a = 0; a < 4; ++a, x = turned(x, 0))
            for (int b = 0; b < 4; ++b, x = turned(x, 1))
                for (int c = 0; c < 4; ++c, x = turned(x, 2))
                    best = x < best ? x : best;
    }
    return best;
}

int marching_cubes_case(int signs) {
    /* 11 and 14 are mirror images of each other. */
    static const int examples[CASES] = {0x00, 0x01, 0x03, 0x09, 0x81, 0x07, 0x83, 0x29,
                                        0x0f, 0x17, 0xc3, 0x8b, 0x87, 0x69, 0x8d};
    const int wanted = least(signs);
    for (int n = 0; n < CASES; ++n)
        if (least(examples[n]) == wanted)
            return n;
    return -1;
}
