#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write a bracket as binary STL in mm: a plate with a bore and a pattern of four holes, by the
standard library alone.

bracket_part.py PART.stl [WIDTH HEIGHT THICKNESS BORE PITCH_X PITCH_Y HOLE SEGMENTS]

The plate lies in x and y about the origin, from z = 0 to THICKNESS; the bore about the origin, the
holes' centres in (±PITCH_X/2, ±PITCH_Y/2). Circles are polygons of SEGMENTS corners, whose area is
that of the circle."""

import math
import struct
import sys

DEFAULTS = dict(
    width=60.0,
    height=40.0,
    thickness=6.0,
    bore=16.0,
    pitch_x=40.0,
    pitch_y=24.0,
    hole=5.0,
    segments=720,
)


def cell(box, centre, diameter, segments):
    """The quadrilaterals between a circle and the rectangle around it, and the circle's corners,
    counter-clockwise."""
    x0, y0, x1, y1 = box
    step = 2 * math.pi / segments
    # The polygon whose area is the circle's.
    radius = diameter / 2 * math.sqrt(step / math.sin(step))
    angles = {i * step for i in range(segments)}
    # The rectangle's corners are corners of the outer side.
    angles |= {
        math.atan2(y - centre[1], x - centre[0]) % (2 * math.pi) for x in (x0, x1) for y in (y0, y1)
    }
    inner, outer = [], []
    for angle in sorted(angles):
        c, s = math.cos(angle), math.sin(angle)
        # On the polygon's side, where the angle is none of its corners.
        within = angle % step
        r = (
            radius * math.cos(step / 2) / math.cos(min(within, step - within) - step / 2)
            if min(within, step - within) > 1e-9
            else radius
        )
        reach = min(
            ((x1 if c > 0 else x0) - centre[0]) / c if abs(c) > 1e-12 else math.inf,
            ((y1 if s > 0 else y0) - centre[1]) / s if abs(s) > 1e-12 else math.inf,
        )
        inner.append((centre[0] + r * c, centre[1] + r * s))
        outer.append((centre[0] + reach * c, centre[1] + reach * s))
    return inner, outer


def bracket(width, height, thickness, bore, pitch_x, pitch_y, hole, segments):
    """Triangles of corners (x, y, z) in mm."""
    triangles = []

    def quad(a, b, c, d):
        triangles.append((a, b, c))
        triangles.append((a, c, d))

    # Columns: hole | bore | hole; the outer columns are two cells high, the middle is one.
    split = pitch_x / 4 + bore / 4
    w, h = width / 2, height / 2
    cells = [((-split, -h, split, h), (0, 0), bore)]
    for sx in (-1, 1):
        for sy in (-1, 1):
            box = (min(sx * split, sx * w), min(0, sy * h), max(sx * split, sx * w), max(0, sy * h))
            cells.append((box, (sx * pitch_x / 2, sy * pitch_y / 2), hole))
    for box, centre, diameter in cells:
        inner, outer = cell(box, centre, diameter, segments)
        for i in range(len(inner)):
            j = (i + 1) % len(inner)
            (ax, ay), (bx, by), (cx, cy), (dx, dy) = inner[i], outer[i], outer[j], inner[j]
            quad((ax, ay, thickness), (bx, by, thickness), (cx, cy, thickness), (dx, dy, thickness))
            quad((ax, ay, 0), (dx, dy, 0), (cx, cy, 0), (bx, by, 0))
            quad((ax, ay, 0), (ax, ay, thickness), (dx, dy, thickness), (dx, dy, 0))
    t = thickness
    for (x, y), (u, v) in zip(
        ((-w, -h), (w, -h), (w, h), (-w, h)), ((w, -h), (w, h), (-w, h), (-w, -h))
    ):
        quad((x, y, 0), (u, v, 0), (u, v, t), (x, y, t))
    return triangles


def write_stl(path, triangles):
    with open(path, "wb") as file:
        file.write(b"bracket, mm".ljust(80))
        file.write(struct.pack("<I", len(triangles)))
        for a, b, c in triangles:
            u = [b[i] - a[i] for i in range(3)]
            v = [c[i] - a[i] for i in range(3)]
            n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            length = math.sqrt(sum(k * k for k in n)) or 1.0
            file.write(struct.pack("<12fH", *(k / length for k in n), *a, *b, *c, 0))


def main():
    values = dict(DEFAULTS)
    for key, text in zip(values, sys.argv[2:]):
        values[key] = type(values[key])(text)
    write_stl(sys.argv[1], bracket(**values))


if __name__ == "__main__":
    main()
