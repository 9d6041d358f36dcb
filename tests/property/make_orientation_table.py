#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes orientation_table.h: points whose orientation is hard to tell, with signs from exact fractions."""
import random
import struct
from fractions import Fraction

ROWS = 240


def as_float(x):
    """The float32 nearest to x."""
    return struct.unpack("<f", struct.pack("<f", float(x)))[0]


def step(x, ulps):
    """x moved by so many float32 steps."""
    bits = struct.unpack("<i", struct.pack("<f", x))[0] + ulps
    moved = struct.unpack("<f", struct.pack("<i", bits))[0]
    return moved if abs(moved) < 3e38 else x


def orientation(a, b, c, d):
    a, b, c, d = [[Fraction(x) for x in p] for p in (a, b, c, d)]
    u, v, w = [[p[i] - a[i] for i in range(3)] for p in (b, c, d)]
    value = sum(w[i] * (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]) for i in range(3))
    return (value > 0) - (value < 0)


def area_sign(a, b, c):
    a, b, c = [[Fraction(x) for x in p] for p in (a, b, c)]
    value = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return (value > 0) - (value < 0)


def wild(rng, spread):
    return as_float(rng.choice((-1, 1)) * rng.uniform(1, 2) * 2.0 ** rng.randint(-spread, spread))


def coplanar_row(rng):
    """Whole numbers in one plane, each axis then stretched by its own power of two."""
    a, b, c = [[rng.randint(-1000, 1000) for _ in range(3)] for _ in range(3)]
    s, t = rng.randint(-3, 3), rng.randint(-3, 3)
    d = [x + s * (y - x) + t * (z - x) for x, y, z in zip(a, b, c)]
    if rng.randint(0, 3) == 0:
        d[rng.randint(0, 2)] += 1
    if rng.randint(0, 3) == 0:
        c = [2 * y - x for x, y in zip(a, b)]
    scale = [2.0 ** rng.randint(-140, 100) for _ in range(3)]
    return [[as_float(x * k) for x, k in zip(p, scale)] for p in (a, b, c, d)]


def row(rng, number):
    if number % 2 == 0:
        return coplanar_row(rng)
    spread = (0, 3, 12, 30, 60, 120)[number % 6]
    a, b, c = [[wild(rng, spread) for _ in range(3)] for _ in range(3)]
    if number % 5 == 4:
        c = [as_float((x + y) / 2) for x, y in zip(a, b)]
    s, t = rng.uniform(-1, 2), rng.uniform(-1, 2)
    d = [as_float(max(-1e38, min(1e38, x + s * (y - x) + t * (z - x)))) for x, y, z in zip(a, b, c)]
    if number % 3 == 1:
        d = [step(x, rng.randint(-2, 2)) for x in d]
    if number % 7 == 6:
        d = [x * 2.0 ** -149 for x in (rng.randint(-4, 4), rng.randint(-4, 4), rng.randint(-4, 4))]
    return a, b, c, d


def main():
    rng = random.Random(1997)
    print("// SPDX-License-Identifier: MIT")
    print("/* Written by make_orientation_table.py. Twelve coordinates of a, b, c, d; the sign of their")
    print(" * orientation; the sign of the area of a, b, c in the plane of x and y. */")
    print("// clang-format off")
    print("static const struct { float points[4][3]; int orientation, area; } orientation_table[] = {")
    for number in range(ROWS):
        points = row(rng, number)
        text = ", ".join("{%s}" % ", ".join(x.hex() + "f" for x in p) for p in points)
        print("{{%s}, %d, %d}," % (text, orientation(*points), area_sign(*points[:3])))
    print("};")


main()
