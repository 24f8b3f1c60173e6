# SPDX-License-Identifier: Apache-2.0
"""Deflectometry: a camera sees the fringes of a screen in a mirror with a dent, and in a painted
panel. Cameras are focused on the part, so that the screen is blurred. Inverse schlieren: a display
behind a window sends what a flawless one passes on to the camera."""

import math

from basics import box, square
from gltf import Scene
from setups import PIXELS


def stand(scene, distance, pixel_size, screen):
    """Camera and screen at the distance from the origin, 25 degrees to both sides of +z; the node
    "table", about whose x-y plane the part lies."""
    scene.node("table")
    scene.node(
        "camera",
        pose={"target": [0, 0, 0], "distance": distance, "azimuth": "-25deg"},
        sensor={
            "type": "thinLens",
            "focalLength": "25mm",
            "focusDistance": distance,
            "fNumber": 8,
            "resolution": PIXELS,
            "pixelSize": pixel_size,
        },
    )
    scene.node(
        "screen",
        pose={"target": [0, 0, 0], "distance": distance, "azimuth": "25deg"},
        emitter=dict({"type": "screen", "index": 0, "radiance": 100}, **screen),
    )


def dent(scene, node, at, size, depth):
    scene.elements["defect"] = [
        {"name": "dent", "type": "dent", "node": node, "at": at, "size": size, "depth": depth}
    ]
    scene.extensions.add("MCVISI_defects")


def dented_mirror():
    """A mirror of 60 mm; a pixel sees 0.15 mm of it."""
    scene = Scene(
        "A mirror with a dent 1 um deep, whose slope is 303 urad at most. "
        "mcvisi deflectometry --plane table; defects/dent/depth says how deep."
    )
    chrome = scene.material("chrome", {"type": "mirror", "reflectance": 0.9})
    scene.node("mirror", mesh=scene.mesh("mirror", chrome, *square(0.03)))
    dent(scene, "mirror", [0.004, 0.003, 0], "8mm", "1um")
    stand(
        scene,
        "250mm",
        "16.7um",
        {
            "pixelPitch": "0.25mm",
            "pattern": {
                "type": "phaseShift",
                "steps": 4,
                "periods": 40,
                "resolution": [1280, 1024],
            },
        },
    )
    return scene.gltf()


RADII = (2.0, 5.0)  # of the panel, across and down [m]


def panel(half_width, half_height, cells):
    """z = -x²/(2 R) - y²/(2 S) with its normals, which facets interpolate exactly but for their
    length."""
    positions, normals, triangles = [], [], []
    for j in range(cells + 1):
        for i in range(cells + 1):
            x, y = half_width * (2 * i / cells - 1), half_height * (2 * j / cells - 1)
            p, q = (-x / RADII[0], -y / RADII[1])
            length = math.sqrt(1 + p * p + q * q)
            positions.append((x, y, 0.5 * (p * x + q * y)))
            normals.append((-p / length, -q / length, 1 / length))
    for j in range(cells):
        for i in range(cells):
            a, b = j * (cells + 1) + i, (j + 1) * (cells + 1) + i
            triangles += [(a, a + 1, b + 1), (a, b + 1, b)]
    return positions, triangles, normals


def painted_panel():
    """A panel of 240 mm x 200 mm, convex; a pixel sees 0.6 mm of it. The screen is 24 inches
    wide across its diagonal."""
    scene = Scene(
        "A painted panel as of a car's body, convex with radii of 2 m and 5 m, with a dent 20 um "
        "deep. mcvisi deflectometry --plane table --remove-form quadric; "
        "materials/paint/extensions/MCVISI_materials/roughness says how well it is polished."
    )
    paint = scene.material(
        "paint",
        {"type": "metallicRoughness", "baseColor": 0.05, "metallic": 0, "roughness": 0.032},
        (0.05, 0.05, 0.05),
    )
    scene.node("panel", mesh=scene.mesh("panel", paint, *panel(0.12, 0.1, 24)))
    dent(scene, "panel", [0.02, 0.015, 0], "20mm", "20um")
    stand(
        scene,
        "500mm",
        "31.6um",
        {
            "pixelPitch": "0.27mm",
            "pattern": {
                "type": "phaseShift",
                "steps": 4,
                "periods": 36,
                "resolution": [1920, 1200],
            },
        },
    )
    return scene.gltf()


DIRECTIONS, RANGE, ACCEPTED = 32, 0.008, 0.00076


def directions(lit):
    """A picture of the directions of one place: those within the distance `lit` [rad] of the axis
    are lit."""
    pitch = 2 * RANGE / DIRECTIONS
    middles = [(i + 0.5) * pitch - RANGE for i in range(DIRECTIONS)]
    return [[(255 * (math.hypot(x, y) < lit),) * 3 for x in middles] for y in middles]


def schlieren():
    """A window of 20 mm x 15 mm; a pixel sees 0.125 mm of it. The camera accepts 0.76 mrad; the
    display has directions of 0.5 mrad, of which the 12 in the middle are lit."""
    scene = Scene(
        "A window with a dent 4 um deep, whose slope turns light by 1.25 mrad, before a display "
        "that sends the directions that a camera accepts of a flawless one, as mcvisi "
        "inverse-pattern finds them. emitters/display/image=white lights all directions."
    )
    glass = scene.material("glass", {"type": "dielectric", "glass": "N-BK7"})
    plate = box((-0.01, -0.0075, 0), (0.01, 0.0075, 0.003))
    scene.node("window", mesh=scene.mesh("window", glass, *plate))
    dent(scene, "window", [0, 0, 0.003], "4mm", "4um")
    scene.node(
        "camera",
        translation=[0, 0, 0.303],
        sensor={
            "type": "telecentric",
            "magnification": 0.1,
            "workingDistance": "300mm",
            "numericalAperture": ACCEPTED,
            "resolution": [80, 60],
            "pixelSize": "12.5um",
            "radiometry": "radiance",
        },
    )
    scene.image("white", directions(1))
    scene.node(
        "display",
        translation=[0, 0, -0.02],
        rotation=[0, 1, 0, 0],
        emitter={
            "type": "lightField",
            "size": ["12mm", "9mm"],
            "spatialResolution": [1, 1],
            "angularResolution": [DIRECTIONS, DIRECTIONS],
            "angularRange": RANGE,
            "radiance": 1,
            "image": scene.image("pattern", directions(1.7 * 2 * RANGE / DIRECTIONS)),
        },
    )
    return scene.gltf()


def files():
    return {
        "dented-mirror.gltf": dented_mirror(),
        "painted-panel.gltf": painted_panel(),
        "schlieren.gltf": schlieren(),
    }
