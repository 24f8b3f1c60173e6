# SPDX-License-Identifier: Apache-2.0
"""A bottle moves on a conveyor past a line-scan camera and a backlight."""

import math

from gltf import Scene, facing
from optics import body
from setups import LETTERS, turned

# Of the axis y, in metres: the outer radius, and the letters' place on it.
RADIUS, PRINT = 0.012, 0.009


def arc(x, y, radius, first, last, count=8):
    """Points of a circle from one angle [degrees] to another."""
    angles = [math.radians(first + (last - first) * i / count) for i in range(count + 1)]
    return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]


def bottle():
    """Half the section of a bottle with a wall of 1.2 mm, from the middle of its bottom up to the
    rim and down inside."""
    return (
        [(0, 0), *arc(0.0105, 0.0015, 0.0015, -90, 0), *arc(0.0075, 0.034, 0.0045, 0, 60)]
        + [*arc(0.01125, 0.0405, 0.003, 240, 180), (0.00825, 0.05), (0.00825, 0.05)]
        + [(0.00705, 0.05), (0.00705, 0.05), *arc(0.01125, 0.0405, 0.0042, 180, 240)]
        + [*arc(0.0075, 0.034, 0.0033, 60, 0), *arc(0.0093, 0.003, 0.0015, 0, -90), (0, 0.0015)]
    )


def cap():
    """A cap of 20 mm over the neck."""
    edges = [(0.01, 0.044), (0.01, 0.0525)]  # creases, where points stand twice
    return [(0.0086, 0.044), edges[0], *edges, edges[1], (0, 0.0525)]


def printed():
    """Letters and a ruler with bars of half a millimetre, printed on the side that faces +z: lines
    go along the axis."""
    positions, triangles = [], []

    def patch(along, across, length, width):
        base, steps = len(positions), 4
        for i in range(steps + 1):
            angle = (across + width * i / steps) / RADIUS
            x, z = (1.005 * RADIUS * f(angle) for f in (math.sin, math.cos))
            positions.extend([(x, along, z), (x, along + length, z)])
        for k in range(base, base + 2 * steps, 2):
            triangles.extend([(k, k + 2, k + 3), (k, k + 3, k + 1)])

    for row, line in enumerate(LETTERS):
        for column, cell in enumerate(line):
            if cell == "X":
                patch(PRINT + column * 1e-3, (row - len(LETTERS) / 2) * 1e-3, 1e-3, 1e-3)
    for i in range(8):
        patch(PRINT + 0.013, (i - 3.75) * 1e-3, 0.006, 0.5e-3)
    return positions, triangles


def conveyor():
    """At 0.5 m/s a line of 0.25 mm takes 500 µs."""
    scene = Scene(
        "A bottle passes a line-scan camera at 0.5 m/s, 0.25 mm per line of 500 µs. "
        "sensors/camera/lineTime, exposureTime and stages are to be chosen."
    )
    black = scene.material("black", {"type": "absorber"}, (0.02, 0.02, 0.02))
    glass = body(scene, "glass", "N-BK7")
    parts = {
        "bottle": (glass, turned(bottle())),
        "cap": (black, turned(cap())),
        "print": (black, printed()),
    }
    for name, (material, mesh) in parts.items():
        scene.node(
            name,
            mesh=scene.mesh(name, material, *mesh),
            translation=[0.026125, 0, 0],
            motion={"velocity": [-0.5, 0, 0]},
        )
    scene.node(
        "backlight",
        translation=[0, 0.0265, -0.04],
        rotation=facing((0, 0, 1)),
        emitter={"type": "area", "size": ["120mm", "90mm"], "radiance": 0.4},
    )
    # Columns go along the bottle's axis, and rows along its way.
    half = math.sqrt(0.5)
    scene.node(
        "camera",
        translation=[0, 0.0265, 0.150],
        rotation=[0, 0, half, half],
        sensor={
            "type": "telecentric",
            "magnification": 0.1,
            "workingDistance": "150mm",
            "fNumber": 8,
            "resolution": [280, 210],
            "pixelSize": "25um",
            "radiometry": "irradiance",
            "shutter": "line",
            "lineTime": 500e-6,
            "exposureTime": 250e-6,
        },
    )
    return scene.gltf()


def files():
    return {"conveyor.gltf": conveyor()}
