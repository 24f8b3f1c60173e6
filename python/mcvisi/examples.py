# SPDX-License-Identifier: Apache-2.0
"""A part to try things with, where none is at hand."""

from __future__ import annotations

import struct
from typing import Any, Iterator, List, Tuple

from mcvisi.library import path_bytes
from mcvisi.options import Path

# The widths are 63.6 mm at the foot and WIDTH below it [mm].
WIDTH = 57.0
LEFT, RIGHT = 31.8 - WIDTH, 31.8
BOXES = (((LEFT, -20, 0), (RIGHT, 8, 6)), ((-RIGHT, 8, 0), (RIGHT, 20, 6)))
FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))

Corner = List[float]


def _triangles() -> Iterator[Tuple[Corner, Corner, Corner]]:
    for low, high in BOXES:
        corners: List[Any] = [
            [(high if i >> k & 1 else low)[k] for k in range(3)] for i in range(8)
        ]
        for a, b, c, d in FACES:
            yield corners[a], corners[b], corners[c]
            yield corners[a], corners[c], corners[d]


def bracket(path: Path) -> None:
    """
    Writes the bracket of the documentation as a binary STL file in mm, a plate with a foot, 63.6 x
    40 x 6 mm. The foot lies at y > 8 mm; below it the plate is 57 mm wide, and both end at x = 31.8 mm.
    """
    found = list(_triangles())
    words = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(t, []), 0) for t in found)
    with open(path_bytes(path, "path"), "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(found)) + words)
