# SPDX-License-Identifier: Apache-2.0
"""Rigs for `mcvisi sweep`; the experiments themselves are the .json files beside this one."""

import math
import random

from gltf import Scene


def telecentric_edge():
    """A straight edge, 5 degrees from the columns, half a millimetre nearer than the plane in
    focus, before a backlight whose cone is wider than all that the camera takes in: f = 36.67 mm, b
    = 55 mm, magnification 0.5, working distance 110 mm."""
    scene = Scene(
        "A tilted edge 0.5 mm out of focus before a telecentric camera: how well is it located? "
        "telecentric-edge.json sweeps the diameter of the stop."
    )
    black = scene.material("black", {"type": "absorber"}, (0, 0, 0))
    half = math.radians(2.5)  # half of the angle, for the quaternion
    plate = scene.mesh(
        "plate",
        black,
        [(-5e-3, -5e-3, 0), (0, -5e-3, 0), (0, 5e-3, 0), (-5e-3, 5e-3, 0)],
        [(0, 1, 2), (0, 2, 3)],
    )
    scene.node(
        "plate",
        translation=[0, 0, 0.5e-3],
        rotation=[0, 0, math.sin(half), math.cos(half)],
        mesh=plate,
    )
    scene.node(
        "camera",
        translation=[0, 0, 0.11],
        sensor={
            "name": "camera",
            "type": "telecentric",
            "focalLength": 0.11 / 3,
            "imageDistance": "55mm",
            "stopDiameter": "2mm",
            "lensDiameter": "40mm",
            "resolution": [96, 64],
            "pixelSize": "4.8um",
            "radiometry": "irradiance",
        },
    )
    scene.node(
        "back",
        translation=[0, 0, -0.02],
        rotation=[0, 1, 0, 0],
        emitter={
            "name": "back",
            "type": "parallel",
            "size": ["12mm", "12mm"],
            "halfAngle": "8deg",
            "radiance": 1,
        },
    )
    return scene


def depth_by_masks():
    """A plate of random black cells of 0.4 mm, half of them open, before a telecentric camera and
    a bright panel: magnification 0.1 at f/2, 0.3 m away, 0.1 mm of the plate to a pixel. Its scale
    does not tell the depth: only the blur does."""
    scene = Scene(
        "A plate of random cells before a telecentric camera: which mask tells its depth best? "
        "depth-by-masks.json sweeps masks and depths."
    )
    black = scene.material("black", {"type": "absorber"}, (0, 0, 0))
    side, count = 0.4e-3, 20
    cells = random.Random(1)
    corners, triangles = [], []
    for i in range(count):
        for j in range(count):
            if cells.random() < 0.5:
                continue
            x, y, first = (i - count / 2) * side, (j - count / 2) * side, len(corners)
            corners += [
                (x, y, 0),
                (x + side, y, 0),
                (x + side, y + side, 0),
                (x, y + side, 0),
            ]
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    scene.node("plate", mesh=scene.mesh("plate", black, corners, triangles))
    scene.node(
        "camera",
        translation=[0, 0, 0.3],
        sensor={
            "name": "camera",
            "type": "telecentric",
            "magnification": 0.1,
            "workingDistance": "300mm",
            "fNumber": 2,
            "resolution": [64, 64],
            "pixelSize": "10um",
            "radiometry": "irradiance",
        },
    )
    scene.node(
        "panel",
        translation=[0, 0, -0.02],
        rotation=[0, 1, 0, 0],
        emitter={"name": "panel", "type": "area", "size": ["30mm", "30mm"], "radiance": 1},
    )
    return scene


def files():
    return {
        "depth-by-masks.gltf": depth_by_masks().gltf(),
        "telecentric-edge.gltf": telecentric_edge().gltf(),
    }
