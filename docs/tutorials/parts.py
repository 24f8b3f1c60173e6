#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write one of the tutorials' parts as binary STL in mm, by the standard library alone.

parts.py scratched|window|tabs|plain PART.stl

scratched  a block 20 x 14 x 3 mm, its top at z = 3, with a straight scratch along y: a V groove
           0.2 mm wide and 0.06 mm deep through x = 0
window     a window 20 x 15 x 3 mm; its top at z = 3 has a dent about the origin, a Gaussian of
           standard deviation 1 mm, 4 µm deep
tabs       two squares of 6 mm, 0.1 mm thick, turned by a slope of 1:10: one about (-6, 0) from
           z = 0 on, one about (6, 0) from z = 20 on
plain      a block 20 x 14 x 3 mm, its top at z = 3
"""
import math
import struct
import sys


def quad(a, b, c, d):
    return [(a, b, c), (a, c, d)]


def closed(top, floor):
    """The solid between a grid of points (rows by rising y, in each x rises) and z = floor."""
    triangles = []
    down = [[(x, y, floor) for x, y, _ in row] for row in top]
    for j in range(len(top) - 1):
        for i in range(len(top[0]) - 1):
            triangles += quad(top[j][i], top[j][i + 1], top[j + 1][i + 1], top[j + 1][i])
            triangles += quad(down[j][i], down[j + 1][i], down[j + 1][i + 1], down[j][i + 1])
    for a, b in ((0, 1), (-1, -2)):
        rows = range(len(top) - 1)
        for j in rows:
            side = quad(top[j][a], top[j + 1][a], down[j + 1][a], down[j][a])
            triangles += side if a == 0 else [t[::-1] for t in side]
        for i in range(len(top[0]) - 1):
            side = quad(top[a][i], down[a][i], down[a][i + 1], top[a][i + 1])
            triangles += side if a == 0 else [t[::-1] for t in side]
    return triangles


def scratched():
    profile = ((-10, 3), (-0.1, 3), (0, 2.94), (0.1, 3), (10, 3))
    return closed([[(x, y, z) for x, z in profile] for y in (-7, 7)], 0)


def plain():
    return closed([[(x, y, 3) for x in (-10, 10)] for y in (-7, 7)], 0)


def window():
    """Steps of 0.125 mm in the dent, to 4 standard deviations; wider ones where the top is flat."""
    fine = [0.125 * i for i in range(-32, 33)]
    columns, rows = [-10, -8, -6] + fine + [6, 8, 10], [-7.5, -6] + fine + [6, 7.5]
    return closed([[(x, y, 3 - 0.004 * math.exp(-(x * x + y * y) / 2)) for x in columns]
                   for y in rows], 0)


def tabs():
    c, s = 3 * math.cos(math.atan(0.1)), 3 * math.sin(math.atan(0.1))

    def square(x, low):
        return closed([[(x + u * c - v * s, u * s + v * c, low + 0.1) for u in (-1, 1)]
                       for v in (-1, 1)], low)

    return square(-6, 0) + square(6, 20)


def write_stl(path, triangles):
    """Normals are left to the reader of the file, as zeros."""
    with open(path, "wb") as file:
        file.write(b"a part of the tutorials, mm".ljust(80))
        file.write(struct.pack("<I", len(triangles)))
        for corners in triangles:
            file.write(struct.pack("<12fH", 0, 0, 0, *(k for corner in corners for k in corner), 0))


def main():
    parts = {"scratched": scratched, "window": window, "tabs": tabs, "plain": plain}
    if len(sys.argv) != 3 or sys.argv[1] not in parts:
        sys.exit("parts.py %s PART.stl" % "|".join(parts))
    write_stl(sys.argv[2], parts[sys.argv[1]]())


if __name__ == "__main__":
    main()
