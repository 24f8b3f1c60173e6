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


def ring(circle, outline):
    """Triangles between a regular polygon and a convex outline around it, both counter-clockwise,
    the polygon from the angle 0. A side of the outline goes with the polygon's corner that is
    nearest to it: this corner sees the whole side."""
    triangles = []
    count = len(circle)
    sides = list(zip(outline, outline[1:] + outline[:1]))
    at = [
        round(math.atan2(ax - bx, by - ay) / (2 * math.pi) * count) % count
        for (ax, ay), (bx, by) in sides
    ]
    for i, (a, b) in enumerate(sides):
        triangles.append((circle[at[i]], a, b))
        # The polygon's sides up to the next side of the outline lie at its corner b.
        for k in range((at[(i + 1) % len(sides)] - at[i]) % count):
            j = (at[i] + k) % count
            triangles.append((circle[j], b, circle[(j + 1) % count]))
    return triangles


def bracket(width, height, thickness, bore, pitch_x, pitch_y, hole, segments):
    """Triangles of corners (x, y, z) in mm: a closed body."""
    triangles = []
    step = 2 * math.pi / segments

    def wall(a, b):
        """The quadrilateral above the side from a to b, whose outside is to the right."""
        triangles.append(((*a, 0), (*b, 0), (*b, thickness)))
        triangles.append(((*a, 0), (*b, thickness), (*a, thickness)))

    # Columns: hole | bore | hole; the outer columns are two cells high, the middle is one. Where
    # two outer cells meet, the middle one has a corner, too.
    split = pitch_x / 4 + bore / 4
    w, h = width / 2, height / 2
    cells = [
        (
            [(split, 0), (split, h), (-split, h), (-split, 0), (-split, -h), (split, -h)],
            (0, 0),
            bore,
        )
    ]
    for sx in (-1, 1):
        for sy in (-1, 1):
            x0, x1 = sorted((sx * split, sx * w))
            y0, y1 = sorted((0, sy * h))
            corners = [(x1, y1), (x0, y1), (x0, y0), (x1, y0)]
            cells.append((corners, (sx * pitch_x / 2, sy * pitch_y / 2), hole))
    for outline, (x, y), diameter in cells:
        # The polygon whose area is the circle's.
        radius = diameter / 2 * math.sqrt(step / math.sin(step))
        circle = [
            (radius * math.cos(i * step) + x, radius * math.sin(i * step) + y)
            for i in range(segments)
        ]
        for a, b, c in ring(circle, outline):
            triangles.append(((*a, thickness), (*b, thickness), (*c, thickness)))
            triangles.append(((*a, 0), (*c, 0), (*b, 0)))
        for a, b in zip(circle, circle[1:] + circle[:1]):
            wall(b, a)
        for a, b in zip(outline, outline[1:] + outline[:1]):
            if abs(a[0]) == abs(b[0]) == w or abs(a[1]) == abs(b[1]) == h:
                wall(a, b)
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
