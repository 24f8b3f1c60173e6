# SPDX-License-Identifier: Apache-2.0
"""Parts for the notebooks: plates whose upper side has a height at each place, as binary STL."""

import struct

import numpy as np


def plate(x, y, heights):
    """The triangles of a closed plate from z = 0 to `heights`, of shape (len(y), len(x)), over the
    coordinates x and y."""
    heights = np.broadcast_to(np.asarray(heights, float), (len(y), len(x)))
    columns, rows = np.meshgrid(np.asarray(x, float), np.asarray(y, float))
    top = np.stack([columns, rows, heights], -1)
    bottom = np.stack([columns, rows, np.zeros_like(columns)], -1)

    def quads(a, b, c, d):
        corners = [np.reshape(p, (-1, 3)) for p in (a, b, c, a, c, d)]
        return np.stack(corners, 1).reshape(-1, 3, 3)

    def face(p):
        return quads(p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1])

    def side(high, low):
        return quads(low[:-1], low[1:], high[1:], high[:-1])

    return np.concatenate(
        [
            face(top),
            face(bottom)[:, ::-1],
            side(top[0], bottom[0]),
            side(top[-1], bottom[-1])[:, ::-1],
            side(top[:, 0], bottom[:, 0])[:, ::-1],
            side(top[:, -1], bottom[:, -1]),
        ]
    )


def write_plates(path, plates):
    """Writes plates (x, y, heights) into one file. Lengths in mm."""
    triangles = np.concatenate([plate(*one) for one in plates])
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", len(triangles)))
        for corners in triangles:
            file.write(struct.pack("<12fH", 0, 0, 0, *corners.ravel(), 0))


def write_plate(path, x, y, heights):
    """Writes one plate."""
    write_plates(path, [(x, y, heights)])
