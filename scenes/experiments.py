# SPDX-License-Identifier: Apache-2.0
"""Rigs for `mcvisi sweep`; the experiments themselves are the .json files beside this one."""

import math

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


def files():
    return {"telecentric-edge.gltf": telecentric_edge().gltf()}
