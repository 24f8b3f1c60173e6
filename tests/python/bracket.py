# SPDX-License-Identifier: Apache-2.0
"""The part of docs/python.md: a plate with a foot, 63.6 x 40 x 6 mm, as binary STL in mm.

The foot is the wider part, y > 8 mm; below it the plate is WIDTH wide and ends where the foot does.
"""

import pathlib
import struct
import sys

WIDTH = 57.0
LEFT, RIGHT = 31.8 - WIDTH, 31.8
BOXES = (((LEFT, -20, 0), (RIGHT, 8, 6)), ((-RIGHT, 8, 0), (RIGHT, 20, 6)))
FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def triangles():
    for low, high in BOXES:
        corners = [[(high if i >> k & 1 else low)[k] for k in range(3)] for i in range(8)]
        for a, b, c, d in FACES:
            yield corners[a], corners[b], corners[c]
            yield corners[a], corners[c], corners[d]


def write(path):
    found = list(triangles())
    words = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(t, []), 0) for t in found)
    pathlib.Path(path).write_bytes(bytes(80) + struct.pack("<I", len(found)) + words)


if __name__ == "__main__":
    write(sys.argv[1])
